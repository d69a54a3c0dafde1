//! What a measured surface is.

use std::error::Error;
use std::path::PathBuf;

use asperity::study::statistics;
use asperity::surface::preparation::PreparationError;
use clap::Args;

use super::preparation::PreparationOptions;
use crate::failure::Failure;
use crate::input::{self, ScanOptions};
use crate::monitor::Terminal;
use crate::output::Answer;

/// Computes ISO 25178-2 parameters, correlation lengths and the fractal dimension of a map.
#[derive(Debug, Args)]
pub(crate) struct Stats {
    /// Measured or generated heights, in any format that `asperity formats` lists; known by its content.
    file: PathBuf,
    #[command(flatten)]
    preparation: PreparationOptions,
    #[command(flatten)]
    options: ScanOptions,
    /// Print one JSON object instead of a table.
    #[arg(long)]
    json: bool,
}

impl Stats {
    pub(crate) fn run(&self, monitor: &Terminal) -> Result<(), Failure> {
        let map = input::map(&self.file, &self.options, monitor)?;
        let preparation = self.preparation.preparation();
        let unusable = |e: &dyn Error| Failure::data(self.file.display(), e);
        let prepared = monitor.at_once(|| preparation.apply(&map))?.map_err(|e| match e {
            // A band or a cutoff that does not fit is the caller's.
            PreparationError::EmptyBand { .. } | PreparationError::SFilter(_) | PreparationError::LFilter(_) => {
                Failure::usage(format_args!("{}: {e}", self.file.display()))
            }
            e => unusable(&e),
        })?;
        if prepared.lost > 0 {
            let lost = prepared.lost;
            monitor.warn(&format!("the robust filter found no surface around {lost} heights, which count as missing"));
        }
        let statistics = monitor.at_once(|| statistics(&prepared))?.map_err(|e| unusable(&e))?;
        Answer::of(&statistics)?.print(self.json)
    }
}
