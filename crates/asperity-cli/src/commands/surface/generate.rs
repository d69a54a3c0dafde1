//! Random maps from a specification.

use std::path::{Path, PathBuf};

use asperity::monitor::Monitor;
use asperity::study::{Specimen, folder_of};
use clap::Args;

use super::maps::MapsOut;
use crate::args;
use crate::commands::study_file;
use crate::failure::Failure;
use crate::monitor::Terminal;
use crate::resources::require_memory;

/// Draws random maps with the statistics of a specification: seed, size, points and a [surface] section.
///
/// In [surface], correlation_length = "20 um" or ["20 um", "10 um"] is the length of the covariance model: the distance
/// at which the correlation falls to 1/e for exponential and squared_exponential, the scale for matern, the roll-off
/// length for self_affine. With covariance = "measured" (the default) a model is fitted to the scan by likelihood; if
/// no model has the slopes of the scan, its own covariance is used. The command draws a few maps and compares them with
/// the scan. It warns about slopes that differ by more than 15 % and about areas of elastic contact that differ by more
/// than a fifth. Spectrum and heights alone do not determine the contact: maps needed 0.3 to 1.4 times the mean pressure of
/// six measured scans for 5 % contact, and 5 to 8 times that of a scan with outliers of single pixels.
#[derive(Debug, Args)]
pub(crate) struct Generate {
    /// Specification file.
    spec: PathBuf,
    /// Seed to use instead of the file's.
    #[arg(long, value_name = "N", value_parser = args::seed, allow_hyphen_values = true)]
    seed: Option<u64>,
    /// Number of maps.
    #[arg(long, value_name = "K", default_value = "1", value_parser = args::count, allow_hyphen_values = true)]
    count: usize,
    #[command(flatten)]
    target: MapsOut,
}

impl Generate {
    pub(crate) fn run(&self, monitor: &Terminal) -> Result<(), Failure> {
        let (mut specimen, text) = study_file::read(&self.spec, Specimen::parse)?;
        specimen.seed = self.seed.unwrap_or(specimen.seed);
        let folder = folder_of(&self.spec);
        let scans = specimen.scan_paths(folder);
        let inputs: Vec<&Path> = scans.iter().chain([&self.spec]).map(PathBuf::as_path).collect();
        let maps = self.target.open(self.count, &inputs)?;
        require_memory(specimen.memory_bytes(), "a map of this size")?;
        maps.require_disk(self.count, specimen.grid().points() as f64)?;
        let sampler = specimen.sampler(folder).map_err(|e| study_file::failure(&self.spec, Some(&text), &e))?;
        for warning in sampler.warnings() {
            monitor.warn(warning);
        }
        for index in 0..self.count {
            monitor.check()?;
            maps.write(index, &sampler.draw(index as u64))?;
            monitor.progress("maps", index + 1, self.count);
        }
        monitor.check()?;
        monitor.note(&maps.commit()?.to_string());
        Ok(())
    }
}
