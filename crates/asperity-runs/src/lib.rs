//! Folders of computations: finished ones that appear complete or not at all, and finished blocks of interrupted ones.
//!
//! [`Staging`] writes a folder beside its destination and then moves it there in one step, so that a destination is either complete or
//! unchanged. Each folder has a manifest of the files that asperity wrote, and is replaced only if it contains nothing else.
//! [`RunBlocks`] stores the blocks of loops, by which an interrupted run goes on and parts of a run are computed elsewhere. Nothing here
//! knows what is computed.

mod blocks;
mod manifest;
mod staging;
mod store;
mod system;

#[cfg(fuzzing)]
pub use blocks::read_blocks;
pub use blocks::{
    BlockPlace, FailedBlock, LeftLoop, Others, Replay, RoundState, RunBlocks, RunRecord, RunStatus, Share, StageBlocks,
    key_of, program, program_difference, sha256,
};
pub use staging::Staging;
pub use store::{StoreError, file_hash, is_finished, json_bytes, replace_files, require_finished, require_unchanged};
pub use system::{forget_peak_memory, free_memory_bytes, machine, peak_memory_bytes};

#[cfg(doctest)]
#[doc = include_str!("../README.md")]
struct Readme;
