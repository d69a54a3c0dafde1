//! Progress reports, cancellation and stored blocks of long computations.
//!
//! The library uses no clock, terminal, signal handler or file: a front end passes a [`Monitor`].

use std::fmt;

/// Observer of a long computation.
pub trait Monitor: Sync {
    /// Reports that `done` of `total` blocks of the task `what` are finished. Called from any thread, in any order.
    fn progress(&self, what: &str, done: usize, total: usize);

    /// Returns whether the computation should stop at the next block.
    fn cancelled(&self) -> bool;

    /// Reports the begin of a stage of a study. Stages follow each other.
    fn begin(&self, _stage: &str) {}

    /// Returns the store of finished blocks; `None` if every block is to be computed.
    fn store(&self) -> Option<&dyn BlockStore> {
        None
    }
}

/// Loop whose blocks a [`BlockStore`] holds.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub struct RoundId(pub u64);

/// Store of the finished blocks of a computation.
///
/// A computation is a sequence of rounds, loops over blocks. It begins its rounds in the same order each time, and a block
/// depends on the computation, the round, its index and the results of earlier rounds alone; so a block of an interrupted
/// computation, or of another process, replaces one of this.
pub trait BlockStore: Sync {
    /// Begins the next round with this name, of `count` blocks.
    fn begin(&self, name: &str, count: usize) -> RoundId;

    /// Returns a stored block; `None` if it is missing or damaged.
    fn load(&self, round: RoundId, index: usize) -> Option<Vec<u8>>;

    /// Stores a finished block, with the reason if it holds a failure. The store keeps its own errors.
    fn save(&self, round: RoundId, index: usize, failure: Option<String>, bytes: Vec<u8>);

    /// Returns whether this process computes a missing block.
    fn computes(&self, round: RoundId, index: usize) -> bool;
}

/// Monitor that ignores progress and never cancels.
#[derive(Debug, Clone, Copy, Default)]
pub struct Silent;

impl Monitor for Silent {
    fn progress(&self, _what: &str, _done: usize, _total: usize) {}

    fn cancelled(&self) -> bool {
        false
    }
}

/// Monitor that forwards all but the progress of inner loops.
#[derive(Clone, Copy)]
pub struct Quiet<'a>(pub &'a dyn Monitor);

impl Monitor for Quiet<'_> {
    fn progress(&self, _what: &str, _done: usize, _total: usize) {}

    fn cancelled(&self) -> bool {
        self.0.cancelled()
    }

    fn store(&self) -> Option<&dyn BlockStore> {
        self.0.store()
    }
}

impl fmt::Debug for Quiet<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str("Quiet")
    }
}

/// Monitor that forwards cancellation alone, for loops that are part of one block.
#[derive(Clone, Copy)]
pub struct Inner<'a>(pub &'a dyn Monitor);

impl Monitor for Inner<'_> {
    fn progress(&self, _what: &str, _done: usize, _total: usize) {}

    fn cancelled(&self) -> bool {
        self.0.cancelled()
    }
}

impl fmt::Debug for Inner<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str("Inner")
    }
}

/// Cancellation of a computation by its [`Monitor`].
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Cancelled;

impl fmt::Display for Cancelled {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str("cancelled")
    }
}

impl std::error::Error for Cancelled {}
