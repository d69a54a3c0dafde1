//! Least-squares fits of models to estimated correlations.

use super::{RecordCorrelation, RecordModel};
use crate::correlation::estimate::EstimateError;
use crate::numeric::{Range, least_squares};
use crate::stats::{Interval, jackknife_reach};

/// Jackknife: largest and least number of blocks, and the least length of a block in fitted lengths.
const MOST_PARTS: usize = 20;
const LEAST_PARTS: usize = 4;
const LENGTHS_PER_PART: f64 = 10.0;

/// Model fitted to the estimated correlation of a record, window included.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct RecordFit {
    /// The model.
    pub model: RecordModel,
    /// Fitted ℓ in metre, which includes the window of the record.
    pub length_m: f64,
    /// Weighted root mean square of estimated minus fitted correlation over the lags used.
    pub misfit: f64,
}

/// Fits ℓ of one model over the lags up to the first zero of the correlation, weighted by pairs.
///
/// The fit describes the curve only; [`fitted_length_interval`] gives the standard error of ℓ. If the model is that of
/// the process, [`super::fit_length`] is more efficient.
///
/// # Errors
/// No lag besides zero.
pub fn fit_record(record: &RecordCorrelation, model: RecordModel) -> Result<RecordFit, EstimateError> {
    let terms = record.fitted_lags();
    if terms.is_empty() {
        return Err(EstimateError::TooFew { present: record.correlation.len(), wanted: 2 });
    }
    let residuals = |p: &[f64]| -> Vec<f64> {
        terms.iter().map(|(lag_m, rho, weight)| weight * (model.correlation(*lag_m, p[0]) - rho)).collect()
    };
    let longest_m = record.step_m * record.correlation.len() as f64;
    let range = Range { low: 1e-3 * record.step_m, high: 100.0 * longest_m };
    let decay = record.correlation_length_m().unwrap_or(longest_m);
    let (found, sum) = least_squares(&residuals, &[decay], &[range]);
    Ok(RecordFit { model, length_m: found[0], misfit: sum.sqrt() })
}

/// Returns the 95 % interval of the ℓ of [`fit_record`] by the jackknife with Student's quantile, over strips of
/// `tracks` records or, with fewer than twenty strips, over blocks of them at least ten lengths long. `None` with fewer
/// than four blocks.
pub fn fitted_length_interval(
    records: &[&[f64]],
    tracks: usize,
    step_m: f64,
    largest_lag: usize,
    fit: &RecordFit,
) -> Option<Interval> {
    let strips = records.len().div_ceil(tracks);
    let pieces = |record: &[f64]| {
        let lengths = record.len() as f64 * step_m / (LENGTHS_PER_PART * fit.length_m);
        (lengths as usize).clamp(1, MOST_PARTS.div_ceil(strips))
    };
    // Returns the block of the value at an index of a record.
    let (mut first, mut parts_of) = (0, Vec::new());
    for strip in records.chunks(tracks) {
        let count = pieces(strip[0]);
        parts_of.extend(strip.iter().map(|_| (first, count)));
        first += count;
    }
    let parts = first.min(MOST_PARTS);
    if parts < LEAST_PARTS {
        return None;
    }
    let without = |left_out: usize| {
        let left: Vec<Vec<f64>> = records
            .iter()
            .zip(&parts_of)
            .map(|(record, (first, count))| {
                let part = |place: usize| (first + place * count / record.len()) % parts;
                record.iter().enumerate().map(|(i, v)| if part(i) == left_out { f64::NAN } else { *v }).collect()
            })
            .collect();
        let views: Vec<&[f64]> = left.iter().map(Vec::as_slice).collect();
        let found = RecordCorrelation::estimate(&views, step_m, largest_lag).ok()?;
        fit_record(&found, fit.model).ok().map(|fit| fit.length_m)
    };
    let lengths: Vec<f64> = (0..parts).map(without).collect::<Option<_>>()?;
    let reach = jackknife_reach(&lengths);
    Some(Interval { low: (fit.length_m - reach).max(0.0), high: fit.length_m + reach })
}
