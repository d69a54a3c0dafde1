//! Statistics of measured surfaces.

use std::path::{Path, PathBuf};

use asperity::study::{part_statistics, profile_of, profile_statistics, surface_statistics};
use asperity::surface::preparation::PreparationError;
use asperity::surface::profile::ProfileStatistics;
use asperity::surface::scanned::{MapStatistics, PooledStatistics};
use asperity_formats::Scan;
use clap::Args;

use super::preparation::PreparationOptions;
use crate::failure::Failure;
use crate::input::{self, ScanOptions};
use crate::monitor::Terminal;
use crate::output::Answer;

/// Computes ISO 25178-2 parameters, correlation lengths and the fractal dimension of a map, with 95 % intervals, or the ISO 21920-2
/// parameters of a profile. Pools the statistics of several scans of one part.
///
/// Heights are relative to their mean after the form is removed. Missing points are left out of every sum, never
/// filled. A map of n pixels is n pixels wide. Sdq uses forward differences, Sdq 7point the seven-point stencil of ISO
/// 25178-2, Sdr two triangles per pixel. The autocorrelation divides the sum of products at a lag by the number of
/// pairs present. Correlation lengths are the distances at which it falls to 1/e, Sal to 0.2; they differ from the
/// length of the covariance model that a study fits. The Sk family uses the least-squares line through the flattest 40
/// % of the material ratio curve, and additionally the secant. The Hurst exponent is fitted to the structure functions
/// from two pixels to an eighth of the map. Intervals treat the map as a sample of a stationary surface. They are
/// undefined if the map is too short for its correlation lengths, and for Ssk and Sku if Sku exceeds 4.
///
/// Of a profile, Rp, Rv and Rz are means over sections of the length of the L-filter's cutoff, or values of the whole profile without the
/// filter. A profile element is a hill with a dale; hills below 10 % of Rp and dales below 10 % of Rv belong to their neighbours. All
/// of the profile is evaluated: filters weight only present heights, also at the ends. Rdq uses forward differences, Rdq 7point the
/// stencil of ISO 21920-2.
#[derive(Debug, Args)]
pub(crate) struct Stats {
    /// Measured or generated heights, in any format that `asperity formats` lists; the content decides the format.
    /// Several files are scans of one part, whose statistics are pooled.
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

/// Statistics that are undefined if the correlation of the heights does not decay within the field.
const DECAYING: [&str; 5] =
    ["Sal_m", "Str", "correlation_length_x_m", "correlation_length_y_m", "correlation_length_m"];

impl Stats {
    pub(crate) fn run(&self, monitor: &Terminal) -> Result<(), Failure> {
        let (mut scans, mut sources) = (vec![], vec![]);
        for file in &self.files {
            let scan = input::scan(file, &self.options, monitor)?;
            if scan.is_profile() && self.files.len() == 1 {
                return self.profile(file, scan, monitor);
            }
            let (statistics, source) = self.statistics(file, scan, monitor)?;
            scans.push((file.display().to_string(), statistics));
            sources.push(source);
        }
        if let ([(_, statistics)], [source]) = (scans.as_slice(), sources.as_slice()) {
            return self.print(Answer::new(&surface_statistics(statistics))?, source.clone());
        }
        for (place, file) in self.files.iter().enumerate() {
            let same =
                |other: &PathBuf| file.canonicalize().is_ok_and(|file| other.canonicalize().is_ok_and(|o| o == file));
            if self.files[..place].iter().any(same) {
                let file = file.display();
                monitor.warn(&format!("{file} is listed twice and counts as two scans; intervals are too narrow"));
            }
        }
        let pooled = PooledStatistics::new(scans).map_err(|e| Failure::data("the scans", &e))?;
        self.print(Answer::new(&part_statistics(&pooled))?, Answer::lists(&sources))
    }

    /// Prints the statistics; JSON also states the `source` of the heights and the statistics of every scan.
    fn print(&self, answer: Answer, source: Answer) -> Result<(), Failure> {
        if self.json {
            return answer.and(source).print(true);
        }
        answer.without("scans").with_reason(&DECAYING, "no decay within the field").print(false)
    }

    /// Returns the statistics of a file, and its format and channel.
    fn statistics(&self, file: &Path, scan: Scan, monitor: &Terminal) -> Result<(MapStatistics, Answer), Failure> {
        let source = input::source(&scan);
        let map = input::height_map(scan, file)?;
        let preparation = self.preparation.preparation();
        let prepared = monitor.killable(|| preparation.apply(map))?.map_err(|e| not_prepared(file, e))?;
        warn_of_lost(file, prepared.lost, monitor);
        let statistics = monitor.killable(|| MapStatistics::new(&prepared))?;
        Ok((statistics.map_err(|e| Failure::data(file.display(), &e))?, source))
    }

    /// Prints the parameters of a profile.
    fn profile(&self, file: &Path, scan: Scan, monitor: &Terminal) -> Result<(), Failure> {
        let source = input::source(&scan);
        let profile = profile_of(scan).map_err(|e| input::no_map(&e, file))?;
        let preparation = self.preparation.preparation();
        let prepared = monitor.killable(|| profile.prepare(&preparation))?.map_err(|e| not_prepared(file, e))?;
        warn_of_lost(file, prepared.lost, monitor);
        if prepared.section_m.is_none() {
            monitor.warn(&format!(
                "{}: without --l-filter these are parameters of the primary profile (Pa, Pq, …), waviness included",
                file.display()
            ));
        }
        let statistics = monitor.killable(|| ProfileStatistics::new(prepared))?;
        let statistics = statistics.map_err(|e| Failure::data(file.display(), &e))?;
        self.print(Answer::new(&profile_statistics(&statistics))?, source)
    }
}

/// Returns the error of a map or profile that could not be prepared.
fn not_prepared(file: &Path, error: PreparationError) -> Failure {
    match error {
        // An invalid band or cutoff is an error of the flags.
        PreparationError::EmptyBand { .. } | PreparationError::SFilter(_) | PreparationError::LFilter(_) => {
            Failure::usage(format_args!("{}: {error}", file.display()))
        }
        error => Failure::data(file.display(), &error),
    }
}

fn warn_of_lost(file: &Path, lost: usize, monitor: &Terminal) {
    if lost > 0 {
        let file = file.display();
        monitor
            .warn(&format!("{file}: the robust filter found no surface around {lost} heights; they count as missing"));
    }
}
