//! Record drawn from a fitted process.

use std::io::Write;
use std::path::{Path, PathBuf};

use asperity::friction::process::FittedProcess;
use asperity::quantity::Length;
use asperity::stats::Moments;
use asperity::study::simulated_record;
use asperity_formats::{read_text, write_series};
use clap::Args;

use crate::args;
use crate::failure::{Failure, Kind, chain};
use crate::monitor::Terminal;
use crate::output::{Answer, check_target, replace_file, write_verb};

/// Draws a record of the friction coefficient from a fitted process.
///
/// CSV contains position, fluctuation about the mean, and coefficient. NPY contains the fluctuation alone, in the
/// form that `asperity vibration trajectory --friction-file` reads.
#[derive(Debug, Args)]
pub(crate) struct Simulate {
    /// Fitted process, written by `asperity friction fit --out` or by a study.
    process: PathBuf,
    /// Total sliding distance.
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
            _ => {
                return Err(Failure::usage(format!(
                    "--out {}: write a name that ends in .csv or .npy",
                    self.out.display()
                )));
            }
        };
        check_target("--out", &self.out, &[&self.process])?;
        let process = read_process(&self.process)?;
        let record = monitor
            .killable(|| simulated_record(&process, self.length.0, self.step.0, self.seed))?
            .map_err(|e| Failure::usage(format_args!("{}: {e}", self.process.display())))?;
        let bytes = match record.column("fluctuation").filter(|_| npy) {
            Some(fluctuation) => write_series(fluctuation),
            None => record.to_csv().map_err(|e| Failure::new(Kind::Runtime, chain(&e)))?,
        };
        let verb = write_verb(&self.out);
        replace_file(&self.out, |file| file.write_all(&bytes))?;
        monitor.note(&format!("{verb} {}", self.out.display()));
        let mu = record.column("mu").unwrap_or_default();
        let moments = Moments::new(mu);
        let negative = mu.iter().filter(|mu| **mu < 0.0).count();
        if negative > 0 {
            monitor.warn(&format!(
                "{}: {negative} of {} drawn values are below zero; the distribution extends to negative friction, which is unphysical",
                self.process.display(),
                mu.len()
            ));
        }
        Answer::default()
            .with("values", mu.len())
            .with("step_m", self.step.0)
            .with("mean", moments.mean)
            .with("std", moments.std)
            .with("negative_values", negative)
            .with("process_mean", process.mean)
            .with("process_std", process.std)
            .print(self.json)
    }
}

/// Reads a fitted process from a file.
pub(crate) fn read_process(path: &Path) -> Result<FittedProcess, Failure> {
    let text = read_text(path).map_err(|e| Failure::io(Kind::Data, path.display(), &e))?;
    FittedProcess::from_json(&text).map_err(|e| Failure::data(path.display(), &e))
}
