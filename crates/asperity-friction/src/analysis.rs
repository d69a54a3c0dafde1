//! Further analysis of the records of a level: spectrum, drifts, and area against load.

use crate::strip::Record;
use crate::window::Window;
use asperity_base::correlation::{
    CrossCorrelation, EstimateError, RecordEnds, RecordSpectrum, Stationarity, cross_correlation, record_spectrum,
};
use asperity_base::stats::Layout;

/// Largest lag of the cross-correlation in windows.
const CROSS_WINDOWS: f64 = 2.0;

/// Spectrum, drifts and cross-correlation of the records of one level.
#[derive(Debug, Clone)]
pub struct ProcessAnalysis {
    /// Power spectral density.
    pub spectrum: Result<RecordSpectrum, EstimateError>,
    /// Drifts along the strips.
    pub stationarity: Result<Stationarity, EstimateError>,
    /// Contact area against load of the windows.
    pub area_and_load: Result<CrossCorrelation, EstimateError>,
}

impl ProcessAnalysis {
    /// Analyses records at the mean load ([`Record::at_mean_load`]) of strips of length `strip_m`, averaged over
    /// `window`. `layout` states whether the strips are periodic and the number of tracks on each.
    pub fn new(records: &[Record], window: &Window, layout: impl Into<Layout>, strip_m: f64) -> Self {
        let Layout { periodic, tracks } = layout.into();
        let (step_m, series) = (window.step_m(), series(records));
        let ends = record_ends(records, window, periodic, strip_m);
        let pairs: Vec<(&[f64], &[f64])> =
            records.iter().map(|record| (record.area_m2.as_slice(), record.load_n.as_slice())).collect();
        let reach = (CROSS_WINDOWS * window.length_m() / step_m).round() as usize;
        Self {
            spectrum: record_spectrum(&series, tracks, step_m, ends),
            stationarity: Stationarity::new(&series, tracks, step_m),
            area_and_load: cross_correlation(&pairs, tracks, step_m, reach),
        }
    }
}

fn series(records: &[Record]) -> Vec<&[f64]> {
    records.iter().map(|record| record.friction.as_slice()).collect()
}

/// Returns the end conditions of the records of a window. A periodic strip gives a periodic record only if the length
/// of the strip is a multiple of the step of the window.
pub fn record_ends(records: &[Record], window: &Window, periodic: bool, strip_m: f64) -> RecordEnds {
    let round = |record: &Record| (record.friction.len() as f64 * window.step_m() / strip_m - 1.0).abs() < 1e-6;
    if periodic && records.iter().all(round) { RecordEnds::Periodic } else { RecordEnds::Free }
}
