//! Further analysis of the records of a level: correlation models, spectrum, drifts, and area against load.

use crate::strip::Record;
use crate::window::Window;
use asperity_base::correlation::{
    CrossCorrelation, EstimateError, LengthSettings, RankedLength, RecordEnds, RecordModel, RecordSpectrum,
    Stationarity, WindowedRecords, cross_correlation, rank_lengths, record_spectrum,
};
use asperity_base::stats::Layout;

/// Candidate models of the correlation without the effect of the window.
pub const MODELS: [RecordModel; 3] =
    [RecordModel::Exponential, RecordModel::SquaredExponential, RecordModel::Matern { nu: 1.5 }];
/// Largest lag of the cross-correlation in windows.
const CROSS_WINDOWS: f64 = 2.0;

/// Correlation models, spectrum, drifts and cross-correlation of the records of one level.
#[derive(Debug, Clone)]
pub struct ProcessAnalysis {
    /// Models of the correlation without the window, the most likely first. Windows that are not rectangles have none.
    pub models: Result<Vec<RankedLength>, EstimateError>,
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
        let models = if window.is_rectangle() {
            let channel = WindowedRecords {
                window_m: window.length_m(),
                step_m,
                cell_m: window.cell_m(),
                tracks,
                records: series.clone(),
            };
            rank_lengths(&[channel], &MODELS, LengthSettings { ends, ..LengthSettings::default() })
        } else {
            Err(EstimateError::Nothing)
        };
        let pairs: Vec<(&[f64], &[f64])> =
            records.iter().map(|record| (record.area_m2.as_slice(), record.load_n.as_slice())).collect();
        let reach = (CROSS_WINDOWS * window.length_m() / step_m).round() as usize;
        Self {
            models,
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
