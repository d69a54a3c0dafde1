//! What a measured surface is.

use std::error::Error;
use std::path::{Path, PathBuf};

use asperity::study::{part_statistics, surface_statistics};
use asperity::surface::preparation::PreparationError;
use asperity::surface::scanned::{MapStatistics, PooledStatistics};
use clap::Args;

use super::preparation::PreparationOptions;
use crate::failure::Failure;
use crate::input::{self, ScanOptions};
use crate::monitor::Terminal;
use crate::output::Answer;

/// Computes ISO 25178-2 parameters, correlation lengths and the fractal dimension of a map, with 95 % intervals; of several
/// scans of one part those of the part.
///
/// Heights count from their mean after the form is removed; missing points are left out of every sum, never filled. A map of n
/// pixels is n pixels wide. Sdq is by forward differences, Sdq 7point by the stencil of seven points of ISO 25178-2, Sdr by two
/// triangles a pixel. The autocorrelation divides the sum of products at a lag by the number of pairs that are present;
/// correlation lengths are where it falls to 1/e, Sal to 0.2; they are not the lengths of the covariance model that a study
/// fits. The Sk family is by the line of least squares through the
/// flattest 40 % of the material ratio curve, beside it by the secant. The Hurst exponent is fitted to the structure functions
/// from two pixels to an eighth of the map. Intervals take the map for a sample of a stationary surface; they are undefined
/// where it holds too few correlation lengths, and for Ssk and Sku where Sku exceeds 4.
#[derive(Debug, Args)]
pub(crate) struct Stats {
    /// Measured or generated heights, in any format that `asperity formats` lists; known by its content. Several files are
    /// scans of one part, whose statistics are pooled.
    #[arg(required = true, value_name = "FILE")]
    files: Vec<PathBuf>,
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
        let (mut scans, mut sources) = (vec![], vec![]);
        for file in &self.files {
            let (statistics, source) = self.statistics(file, monitor)?;
            scans.push((file.display().to_string(), statistics));
            sources.push(source);
        }
        if let ([(_, statistics)], [source]) = (scans.as_slice(), sources.as_slice()) {
            let answer = Answer::of(&surface_statistics(statistics))?;
            return if self.json { answer.and(source.clone()).print(true) } else { answer.print(false) };
        }
        for (place, file) in self.files.iter().enumerate() {
            let same =
                |other: &PathBuf| file.canonicalize().is_ok_and(|file| other.canonicalize().is_ok_and(|o| o == file));
            if self.files[..place].iter().any(same) {
                let file = file.display();
                monitor.warn(&format!("{file} is listed twice and counts as two places: intervals are too narrow"));
            }
        }
        let pooled = PooledStatistics::new(scans).map_err(|e| Failure::data("the scans", &e))?;
        let answer = Answer::of(&part_statistics(&pooled))?;
        if self.json { answer.and(Answer::lists(&sources)).print(true) } else { answer.without("scans").print(false) }
    }

    /// The statistics of a file, with its format and channel.
    fn statistics(&self, file: &Path, monitor: &Terminal) -> Result<(MapStatistics, Answer), Failure> {
        let scan = input::scan(file, &self.options, monitor)?;
        let source = input::source(&scan);
        let map = input::height_map(scan, file)?;
        let preparation = self.preparation.preparation();
        let unusable = |e: &dyn Error| Failure::data(file.display(), e);
        let prepared = monitor.at_once(|| preparation.apply(&map))?.map_err(|e| match e {
            // A band or a cutoff that does not fit is the caller's.
            PreparationError::EmptyBand { .. } | PreparationError::SFilter(_) | PreparationError::LFilter(_) => {
                Failure::usage(format_args!("{}: {e}", file.display()))
            }
            e => unusable(&e),
        })?;
        if prepared.lost > 0 {
            let (file, lost) = (file.display(), prepared.lost);
            monitor.warn(&format!(
                "{file}: the robust filter found no surface around {lost} heights, which count as missing"
            ));
        }
        let statistics = monitor.at_once(|| MapStatistics::new(&prepared))?.map_err(|e| unusable(&e))?;
        Ok((statistics, source))
    }
}
