//! Least-squares fits of models to estimated correlations.

use super::{RecordCorrelation, RecordModel};
use crate::correlation::estimate::EstimateError;
use crate::correlation::least_squares::{Range, minimise};

/// A model fitted to the estimated correlation of a record, window and all.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct RecordFit {
    /// The model.
    pub model: RecordModel,
    /// Fitted ℓ in metre, which contains the window that the record was seen through.
    pub length_m: f64,
    /// Weighted root mean square of estimated minus fitted correlation over the lags used.
    pub misfit: f64,
}

/// Fits ℓ of one model over the lags up to where the correlation first falls to zero, weighted by pairs.
///
/// It describes a curve. Errors of neighbouring lags are correlated, so it has no interval; [`super::fit_length`] does.
///
/// # Errors
/// Fewer than one lag besides zero.
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
    let (found, sum) = minimise(&residuals, &[decay], &[range]);
    Ok(RecordFit { model, length_m: found[0], misfit: sum.sqrt() })
}
