//! Correlation of one-dimensional records, such as a friction coefficient along a sliding path.

use super::estimate::{EstimateError, first_crossing};
use crate::stats::{Moments, lag_sums};

mod band;
mod cross;
mod families;
mod fit;
mod length;
mod likelihood;
mod model;
mod observed;
mod spectrum;
mod stationarity;
mod tangent;

pub use band::RecordBand;
pub use cross::{CrossCorrelation, cross_correlation};
pub use families::{FamilyFits, fit_families};
pub use fit::{RecordFit, fit_record, fitted_length_interval};
pub use length::{LackOfFit, LengthFit, LengthSettings, fit_length};
pub use likelihood::{RecordEnds, WindowedRecords};
pub use model::{RecordModel, WindowedModel, windowed_exponential};
pub use observed::{Observation, ObservedLengths, RecordHistory};
pub use spectrum::{RecordSpectrum, record_spectrum};
pub use stationarity::{DriftTest, Stationarity, Wander};

/// Autocorrelation of one or more records with equal steps.
#[derive(Debug, Clone, PartialEq)]
pub struct RecordCorrelation {
    /// Distance between values in metre.
    pub step_m: f64,
    /// Correlation at the lags 0, 1, 2, … steps; NaN where no pair is present.
    pub correlation: Vec<f64>,
    /// Pairs at each lag.
    pub pairs: Vec<f64>,
    /// Subtracted mean, in the unit of the record.
    pub mean: f64,
    /// Variance C(0), in the squared unit of the record.
    pub variance: f64,
}

impl RecordCorrelation {
    /// Estimates the correlation of `records` up to `largest_lag` steps. NaN is a missing value. The common mean of all
    /// values present is subtracted and products are summed over the records, so several realisations of a process
    /// should be passed together. A sum of products is divided by the number of pairs present at its lag: unbiased for
    /// a known mean, noisy at long lags.
    ///
    /// # Errors
    /// Fewer than three values present, values that do not vary, or a step that is not positive.
    pub fn estimate(records: &[&[f64]], step_m: f64, largest_lag: usize) -> Result<Self, EstimateError> {
        let values = records.iter().flat_map(|record| record.iter().copied());
        let Moments { n: present, mean, .. } = checked_moments(values, step_m, 3)?;
        let longest = records.iter().map(|record| record.len()).max().unwrap_or(0);
        let lags = largest_lag.min(longest - 1) + 1;
        let (mut sums, mut pairs) = (vec![0.0; lags], vec![0.0; lags]);
        for record in records.iter().filter(|record| !record.is_empty()) {
            let (products, counts) = lag_sums(record, mean, lags.min(record.len()));
            for (lag, (product, count)) in products.into_iter().zip(counts).enumerate() {
                sums[lag] += product;
                pairs[lag] += count;
            }
        }
        let variance = sums[0] / present as f64;
        let correlation = sums
            .iter()
            .zip(&pairs)
            .map(|(sum, count)| if *count > 0.0 { sum / count / variance } else { f64::NAN })
            .collect();
        Ok(Self { step_m, correlation, pairs, mean, variance })
    }

    /// Returns the distance in metre at which the correlation first falls to 1/e, interpolated linearly; `None` if it
    /// does not.
    pub fn correlation_length_m(&self) -> Option<f64> {
        first_crossing(&self.correlation, (-1.0_f64).exp()).map(|lags| lags * self.step_m)
    }

    /// Returns the root mean square difference from a model over the lags up to where the correlation first falls to
    /// zero, weighted by pairs.
    pub fn misfit(&self, model: &WindowedModel, length_m: f64) -> f64 {
        let square =
            |(lag_m, rho, weight): (f64, f64, f64)| (weight * (model.correlation(lag_m, length_m) - rho)).powi(2);
        self.fitted_lags().into_iter().map(square).sum::<f64>().sqrt()
    }

    /// Returns the lags 1, 2, … used in a fit, up to the first zero of the correlation but at least three, with the
    /// square root of their fraction of the pairs.
    fn fitted_lags(&self) -> Vec<(f64, f64, f64)> {
        let end = self.correlation.iter().position(|rho| rho.is_nan() || *rho <= 0.0).unwrap_or(self.correlation.len());
        let lags = 1..(end + 1).max(4).min(self.correlation.len());
        let all: f64 = lags.clone().map(|lag| self.pairs[lag]).sum();
        lags.filter(|lag| !self.correlation[*lag].is_nan())
            .map(|lag| (lag as f64 * self.step_m, self.correlation[lag], (self.pairs[lag] / all).sqrt()))
            .collect()
    }
}

/// Returns the moments of the finite values of records.
///
/// # Errors
/// A step that is not positive, fewer than `wanted` values, or values that do not vary.
fn checked_moments(values: impl Iterator<Item = f64>, step_m: f64, wanted: usize) -> Result<Moments, EstimateError> {
    if !(step_m > 0.0 && step_m.is_finite()) {
        return Err(EstimateError::BadStep { step_m });
    }
    let moments = Moments::from_values(values.filter(|value| value.is_finite()));
    match moments.n {
        present if present < wanted => Err(EstimateError::TooFew { present, wanted }),
        present if moments.std == 0.0 => Err(EstimateError::Constant { present }),
        _ => Ok(moments),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::random;
    use crate::testing::autoregressive;

    fn of_one(values: &[f64]) -> Result<Vec<f64>, EstimateError> {
        RecordCorrelation::estimate(&[values], 1.0, values.len()).map(|found| found.correlation)
    }

    fn record(phi: f64, n: usize, index: u64) -> Vec<f64> {
        autoregressive(phi, n, &mut random::stream(31, "ar", index))
    }

    #[test]
    fn correlations_are_direct_sums_over_the_pairs_present() {
        let mut record = record(0.7, 23, 0);
        (record[3], record[10], record[11]) = (f64::NAN, f64::NAN, f64::INFINITY);
        let present: Vec<f64> = record.iter().copied().filter(|v| v.is_finite()).collect();
        let mean = present.iter().sum::<f64>() / 20.0;
        let variance = present.iter().map(|v| (v - mean).powi(2)).sum::<f64>() / 20.0;
        let paired = of_one(&record).unwrap();
        for lag in 0..23 {
            let products: Vec<f64> = (0..23 - lag)
                .map(|i| (record[i] - mean) * (record[i + lag] - mean))
                .filter(|p| p.is_finite())
                .collect();
            let sum = products.iter().sum::<f64>() / variance;
            assert!((paired[lag] - sum / products.len() as f64).abs() < 1e-12 || products.is_empty());
        }
    }

    /// Returns the exact correlation of a model at lags of one metre in place of an estimate.
    fn exact(model: &WindowedModel, length_m: f64, lags: usize) -> RecordCorrelation {
        let correlation = (0..lags).map(|lag| model.correlation(10.0 * lag as f64, length_m)).collect();
        RecordCorrelation { step_m: 10.0, correlation, pairs: vec![100.0; lags], mean: 0.0, variance: 1.0 }
    }

    #[test]
    fn exact_correlations_are_fitted_exactly() {
        for model in RecordModel::BOTH {
            let fit = fit_record(&exact(&WindowedModel::new(model, 0.0), 250.0, 400), model).unwrap();
            assert!((fit.length_m / 250.0 - 1.0).abs() < 1e-5 && fit.misfit < 1e-7, "{fit:?}");
        }
    }

    #[test]
    fn an_exponential_fitted_to_the_triangle_of_a_window_finds_a_length_of_the_window() {
        // For W = 600 µm alone the fit gives 322–368 µm, depending on the range of lags.
        let triangle = exact(&WindowedModel::new(RecordModel::Exponential, 600.0), 0.0, 100);
        let fit = fit_record(&triangle, RecordModel::Exponential).unwrap();
        assert!(fit.length_m > 322.0 && fit.length_m < 368.0, "{}", fit.length_m);
    }

    #[test]
    fn the_length_of_an_autoregressive_record_is_recovered() {
        // φ = e^{−Δ/ℓ} with Δ = 10, ℓ = 250: .9607894392.
        let lengths: Vec<f64> = (0..16)
            .map(|index| {
                let records: Vec<Vec<f64>> = (0..4).map(|r| record(0.960_789_439_2, 5000, 4 * index + r)).collect();
                let views: Vec<&[f64]> = records.iter().map(Vec::as_slice).collect();
                let found = RecordCorrelation::estimate(&views, 10.0, 400).unwrap();
                fit_record(&found, RecordModel::Exponential).unwrap().length_m
            })
            .collect();
        let mean = lengths.iter().sum::<f64>() / 16.0;
        let error = (lengths.iter().map(|l| (l - mean).powi(2)).sum::<f64>() / (15.0 * 16.0)).sqrt();
        assert!((mean - 250.0).abs() < 4.0 * error + 2.5, "{mean} ± {error}");
    }

    #[test]
    fn records_without_variation_or_values_are_refused() {
        assert_eq!(of_one(&[0.1; 5]), Err(EstimateError::Constant { present: 5 }));
        assert!(matches!(of_one(&[]), Err(EstimateError::TooFew { present: 0, .. })));
        let bad = RecordCorrelation::estimate(&[&[0.0, 1.0, 2.0]], 0.0, 2);
        assert_eq!(bad, Err(EstimateError::BadStep { step_m: 0.0 }));
    }
}
