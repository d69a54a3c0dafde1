//! Makes the synthetic scan of `studies/quickstart.toml`: the friction track of a brake disc, with the faults of a measurement.
//! The file in `studies` has these heights in steps of 16 bits.
//!
//! ```text
//! cargo run --release -p asperity-validation --bin brake_disc -- studies/brake_disc.x3p
//! ```
//!
//! Nothing here was measured. The surface is a random field of 512 × 512 points at 2 µm. Sliding follows x; the correlation
//! lengths are about 20 µm along x and 14 µm along y, the rms height is 0.8 µm, and the heights are skewed towards valleys, as
//! on a worn disc. A tilt, grooves along the sliding direction, spikes of an optical instrument, and patches without a reading
//! are added.

#![expect(clippy::print_stderr, reason = "prints errors")]

use std::path::PathBuf;
use std::process::ExitCode;

use asperity_formats::write_x3p;
use asperity_validation::brake_disc::brake_disc;

fn main() -> ExitCode {
    let Some(path) = std::env::args_os().nth(1).map(PathBuf::from) else {
        eprintln!("usage: brake_disc OUT.x3p");
        return ExitCode::from(2);
    };
    let written = brake_disc().and_then(|scan| Ok(std::fs::write(&path, write_x3p(&scan)?)?));
    match written {
        Ok(()) => ExitCode::SUCCESS,
        Err(error) => {
            eprintln!("{}: {error}", path.display());
            ExitCode::FAILURE
        }
    }
}
