//! Origin of a run: the content of `provenance.json`.

use std::collections::BTreeMap;

use serde::{Deserialize, Serialize};

/// Version, inputs, times and machine of a run.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Provenance {
    /// Version of asperity.
    pub asperity: String,
    /// Name of the study.
    pub study: String,
    /// Seed of the study.
    pub seed: u64,
    /// SHA-256 of every input, by file name.
    pub inputs: BTreeMap<String, String>,
    /// The stage that was asked for, if not all.
    pub only: Option<String>,
    /// Start of the run in seconds since 1970-01-01, UTC.
    pub started_unix_s: u64,
    /// Time and memory of each stage.
    pub stages: BTreeMap<String, StageCost>,
    /// Seconds that each task took.
    pub seconds: BTreeMap<String, f64>,
    /// Program and libraries that determine the last bits of the results.
    pub program: Program,
    /// The machine.
    pub machine: Machine,
}

/// Time and memory of a stage.
#[derive(Debug, Clone, Copy, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct StageCost {
    /// Seconds that the stage took.
    pub seconds: f64,
    /// Largest resident memory of the program during the stage in bytes, where the system reports it.
    pub peak_memory_bytes: Option<f64>,
}

/// Program and libraries that determine, with the study, the last bits of the results.
#[derive(Debug, Clone, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Program {
    /// SHA-256 of the program file.
    pub sha256: String,
    /// SHA-256 of the list of the versions of all libraries that the program was built from (`Cargo.lock`); empty if it was not known.
    pub dependencies_sha256: String,
    /// Instruction sets on which the last bits of results may depend.
    pub instruction_sets: Vec<String>,
    /// Hash of values of the elementary functions.
    pub functions: String,
}

/// The machine that computed a run.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Machine {
    /// Operating system.
    pub system: String,
    /// Processor architecture.
    pub architecture: String,
    /// Name of the processor, where the system reports it.
    pub processor: Option<String>,
    /// Number of threads.
    pub threads: usize,
}
