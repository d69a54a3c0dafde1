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
    /// Seconds that each task took.
    pub seconds: BTreeMap<String, f64>,
    /// The machine.
    pub machine: Machine,
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
    /// Instruction sets on which the last bits of results may depend.
    pub instruction_sets: Vec<String>,
    /// Number of threads.
    pub threads: usize,
}
