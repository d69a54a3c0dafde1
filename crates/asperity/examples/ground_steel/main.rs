//! Makes the synthetic scan of `studies/quickstart.toml`: a ground steel surface with the faults of a real measurement.
//!
//! ```text
//! cargo run --release --example ground_steel -p asperity -- studies/ground_steel.x3p
//! ```
//!
//! Nothing here was measured. The surface is a random field, 512 × 512 points at 1 µm, ground along y: correlation lengths
//! of 12 µm across and 60 µm along the lay, Sq = 0.6 µm, with heights skewed towards valleys. On it lie a tilt, scratches,
//! spikes of an optical instrument, and patches without a reading.

#![expect(clippy::print_stderr, reason = "this is a program, and it talks to its user")]

mod scan;

use std::path::PathBuf;
use std::process::ExitCode;

use asperity_formats::{X3pData, write_x3p};

use crate::scan::ground_steel;

fn main() -> ExitCode {
    let Some(path) = std::env::args_os().nth(1).map(PathBuf::from) else {
        eprintln!("usage: ground_steel OUT.x3p");
        return ExitCode::from(2);
    };
    let written = ground_steel().and_then(|scan| Ok(std::fs::write(&path, write_x3p(&scan, X3pData::Int16)?)?));
    match written {
        Ok(()) => ExitCode::SUCCESS,
        Err(error) => {
            eprintln!("{}: {error}", path.display());
            ExitCode::FAILURE
        }
    }
}
