//! A record drawn from a fitted process.

use std::fmt::Write as _;
use std::fs;
use std::io::Write as _;
use std::path::{Path, PathBuf};

use asperity::friction::process::FittedProcess;
use asperity::quantity::Length;
use asperity_formats::{Scan, write_npy};
use clap::Args;
use ndarray::Array2;

use crate::args;
use crate::failure::{Failure, Kind};
use crate::monitor::Terminal;
use crate::output::{Answer, check_target, replace_file, said_of_writing};

/// Draws a record of the friction coefficient from a fitted process: a twin of the record it was fitted to.
///
/// CSV holds position and coefficient. NPY holds the fluctuation about the mean alone, with --fluctuation in CSV too, as
/// `asperity vibration trajectory --friction-file` reads it; its step there is the one given here over N/c.
#[derive(Debug, Args)]
pub(crate) struct Simulate {
    /// Fitted process, as `asperity friction fit --out` or a study wrote it.
    process: PathBuf,
    /// Sliding distance.
    #[arg(long, value_name = "Q", value_parser = args::positive_quantity::<Length>, allow_hyphen_values = true)]
    length: Length,
    /// Distance between values.
    #[arg(long, value_name = "Q", value_parser = args::positive_quantity::<Length>, allow_hyphen_values = true)]
    step: Length,
    /// Seed of every random draw.
    #[arg(long, value_name = "N", value_parser = args::seed, allow_hyphen_values = true)]
    seed: u64,
    /// File to write, .csv or .npy.
    #[arg(long, value_name = "FILE")]
    out: PathBuf,
    /// Write the fluctuation about the mean instead of the coefficient; NPY always holds it.
    #[arg(long)]
    fluctuation: bool,
    /// Print one JSON object instead of a table.
    #[arg(long)]
    json: bool,
}

impl Simulate {
    pub(crate) fn run(&self, monitor: &Terminal) -> Result<(), Failure> {
        let extension = self.out.extension().map(|extension| extension.to_string_lossy().to_ascii_lowercase());
        let npy = match extension.as_deref() {
            Some("npy") => true,
            Some("csv") => false,
            _ => return Err(Failure::usage(format!("--out {}: write a name that ends in .csv or .npy", self.out.display()))),
        };
        check_target("--out", &self.out, &[&self.process])?;
        let process = read_process(&self.process)?;
        let record = monitor
            .at_once(|| process.simulate(self.length.0, self.step.0, self.seed, 0))?
            .map_err(|e| Failure::usage(format_args!("{}: {e}", self.process.display())))?;
        let fluctuation = npy || self.fluctuation;
        let shown = if fluctuation { process.fluctuation(&record) } else { record.clone() };
        let said = said_of_writing(&self.out);
        let bytes = if npy { series(&shown)? } else { table(self.step.0, fluctuation, &shown).into_bytes() };
        replace_file(&self.out, |file| file.write_all(&bytes))?;
        monitor.note(&format!("{said} {}", self.out.display()));
        let moments = asperity::stats::Moments::of(&record);
        Answer::default()
            .with("values", record.len())
            .with("step_m", self.step.0)
            .with("mean", moments.mean)
            .with("std", moments.std)
            .with("process_mean", process.mean)
            .with("process_std", process.std)
            .print(self.json)
    }
}

/// Reads a fitted process.
pub(super) fn read_process(path: &Path) -> Result<FittedProcess, Failure> {
    let text = fs::read_to_string(path).map_err(|e| Failure::io(Kind::Data, path.display(), &e))?;
    FittedProcess::from_json(&text).map_err(|e| Failure::data(path.display(), &e))
}

fn table(step_m: f64, fluctuation: bool, values: &[f64]) -> String {
    let mut text = format!("position_m,{}\n", if fluctuation { "fluctuation" } else { "mu" });
    for (index, value) in values.iter().enumerate() {
        let _ = writeln!(text, "{:?},{value:?}", index as f64 * step_m);
    }
    text
}

fn series(values: &[f64]) -> Result<Vec<u8>, Failure> {
    let row = Array2::from_shape_vec((1, values.len()), values.to_vec())
        .map_err(|e| Failure::new(Kind::Runtime, e.to_string()))?;
    Ok(write_npy(&Scan::new(row, None)))
}
