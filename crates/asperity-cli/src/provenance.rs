//! Clock and host of a run. No other module reads them for a result.

use std::fs;
use std::path::PathBuf;
use std::time::{SystemTime, UNIX_EPOCH};

use asperity::study::result::{Machine, Program};
use asperity::study::{Provenance, elementary_functions, instruction_sets};

use crate::failure::{Failure, Kind};
use crate::run_folder::load_failure;

/// Starts the provenance record of a computation from `inputs`.
pub(crate) fn begin(name: &str, seed: u64, inputs: &[PathBuf]) -> Result<Provenance, Failure> {
    let file_record = asperity::study::provenance(name, seed, inputs).map_err(|e| load_failure(&e))?;
    Ok(Provenance {
        started_unix_s: SystemTime::now().duration_since(UNIX_EPOCH).map_or(0, |since| since.as_secs()),
        machine: Machine {
            system: std::env::consts::OS.into(),
            architecture: std::env::consts::ARCH.into(),
            processor: processor(),
            threads: rayon::current_num_threads(),
        },
        program: program()?,
        ..file_record
    })
}

/// Returns what decides the last bits of results: this program, and what it finds on this machine.
pub(crate) fn program() -> Result<Program, Failure> {
    let failed = |error: &std::io::Error| Failure::io(Kind::Runtime, "the program file", error);
    let file = std::env::current_exe().map_err(|e| failed(&e))?;
    let hash = asperity::study::file_hash(&file).map_err(|e| load_failure(&e))?;
    Ok(Program {
        sha256: hash,
        dependencies_sha256: dependencies_hash(),
        instruction_sets: instruction_sets(),
        functions: elementary_functions(),
    })
}

/// Returns the hash of the list of all libraries; empty if it was not known when the program was built.
fn dependencies_hash() -> String {
    let list = include_bytes!(concat!(env!("OUT_DIR"), "/Cargo.lock"));
    if list.is_empty() { String::new() } else { asperity::study::sha256(list) }
}

/// Returns the name of the processor, if the system reports it.
fn processor() -> Option<String> {
    let text = fs::read_to_string("/proc/cpuinfo").ok()?;
    let line = text.lines().find(|line| line.starts_with("model name"))?;
    Some(line.split_once(':')?.1.trim().to_owned())
}
