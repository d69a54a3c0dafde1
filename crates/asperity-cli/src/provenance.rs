//! Clock and host of a run. No other module reads them for a result.

use std::time::{SystemTime, UNIX_EPOCH};

use asperity::study::result::Program;
use asperity::study::{Provenance, machine};

use crate::failure::{Failure, Kind};
use crate::run_folder::load_failure;

/// Adds start, machine and program to a provenance.
pub(crate) fn begin(of_inputs: Provenance) -> Result<Provenance, Failure> {
    Ok(Provenance {
        started_unix_s: SystemTime::now().duration_since(UNIX_EPOCH).map_or(0, |since| since.as_secs()),
        machine: machine(),
        program: program()?,
        ..of_inputs
    })
}

/// Returns this program and its libraries on this machine, which determine the last bits of results.
pub(crate) fn program() -> Result<Program, Failure> {
    let failed = |error: &std::io::Error| Failure::io(Kind::Runtime, "the program file", error);
    let file = std::env::current_exe().map_err(|e| failed(&e))?;
    asperity::study::program(&file, dependencies_hash()).map_err(|e| load_failure(&e))
}

/// Returns the hash of the list of all libraries; empty if it was not known when the program was built.
fn dependencies_hash() -> String {
    let list = include_bytes!(concat!(env!("OUT_DIR"), "/Cargo.lock"));
    if list.is_empty() { String::new() } else { asperity::study::sha256(list) }
}
