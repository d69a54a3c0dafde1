//! Correlation of one-dimensional records, such as a friction coefficient along a sliding path.

use super::estimate::{EstimateError, first_crossing};
use super::least_squares::{Range, minimise};
use crate::stats::{Moments, lag_sums};

/// How the sum of products at a lag becomes a covariance.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum LagNormalisation {
    /// Divided by the number of values present: biased towards zero at long lags, positive definite when none is missing.
    Biased,
    /// Divided by the number of pairs present at the lag: unbiased for a known mean, noisy at long lags.
    PairNormalised,
}

/// Autocorrelation of one or more records with equal steps.
#[derive(Debug, Clone, PartialEq)]
pub struct RecordCorrelation {
    /// Distance between values in metre.
    pub step_m: f64,
    /// Correlation at the lags 0, 1, 2, … steps; NaN where no pair is present.
    pub correlation: Vec<f64>,
    /// Pairs at each lag.
    pub pairs: Vec<f64>,
    /// Mean that was removed, in the unit of the record.
    pub mean: f64,
    /// Variance C(0), in the squared unit of the record.
    pub variance: f64,
}

impl RecordCorrelation {
    /// Estimates the correlation of `records` up to `largest_lag` steps. NaN is a missing value. The common mean of all
    /// values present is removed, and products are pooled, so realisations of one process should come together.
    ///
    /// # Errors
    /// Fewer than three values present, values that do not vary, or a step that is not positive.
    pub fn estimate(
        records: &[&[f64]],
        step_m: f64,
        largest_lag: usize,
        normalisation: LagNormalisation,
    ) -> Result<Self, EstimateError> {
        if !(step_m > 0.0 && step_m.is_finite()) {
            return Err(EstimateError::BadStep { step_m });
        }
        let values = || records.iter().flat_map(|record| record.iter().copied()).filter(|v| v.is_finite());
        let present = values().count();
        if present < 3 {
            return Err(EstimateError::TooFew { present, wanted: 3 });
        }
        let Moments { mean, std, .. } = Moments::of_values(values());
        if std == 0.0 {
            return Err(EstimateError::Constant { present });
        }
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
            .map(|(sum, count)| match normalisation {
                LagNormalisation::Biased => sum / present as f64 / variance,
                LagNormalisation::PairNormalised if *count > 0.0 => sum / count / variance,
                LagNormalisation::PairNormalised => f64::NAN,
            })
            .collect();
        Ok(Self { step_m, correlation, pairs, mean, variance })
    }

    /// Distance in metre at which the correlation first falls to 1/e, linear between lags; `None` if it does not.
    pub fn correlation_length_m(&self) -> Option<f64> {
        first_crossing(&self.correlation, (-1.0_f64).exp()).map(|lags| lags * self.step_m)
    }

    /// Lags 1, 2, … that enter a fit: up to where the correlation first falls to zero, at least three, with the root of
    /// their share of the pairs.
    fn fitted_lags(&self) -> Vec<(f64, f64, f64)> {
        let end = self.correlation.iter().position(|rho| rho.is_nan() || *rho <= 0.0).unwrap_or(self.correlation.len());
        let lags = 1..(end + 1).max(4).min(self.correlation.len());
        let all: f64 = lags.clone().map(|lag| self.pairs[lag]).sum();
        lags.filter(|lag| !self.correlation[*lag].is_nan())
            .map(|lag| (lag as f64 * self.step_m, self.correlation[lag], (self.pairs[lag] / all).sqrt()))
            .collect()
    }

    fn length_range(&self) -> Range {
        Range { low: 1e-3 * self.step_m, high: 100.0 * self.step_m * self.correlation.len() as f64 }
    }
}

/// Autocorrelation of one record at the lags 0 … n − 1; NaN is a missing value.
///
/// # Errors
/// As [`RecordCorrelation::estimate`].
pub fn autocorrelation_1d(values: &[f64], normalisation: LagNormalisation) -> Result<Vec<f64>, EstimateError> {
    RecordCorrelation::estimate(&[values], 1.0, values.len(), normalisation).map(|found| found.correlation)
}

/// Correlation of the moving average, over a window W, of a process with correlation e^{−|s|/ℓ}:
/// triangle_W ⊛ e^{−|s|/ℓ}, scaled to 1 at s = 0.
///
/// With a = W/ℓ, t = |s|/ℓ and G(x) = e^{−x} − 1 + x the covariance is [G(t + a) + G(|t − a|) − 2G(t)]/a². ℓ = 0 leaves
/// the triangle of the window alone, W = 0 the exponential.
///
/// # Panics
/// If a length is negative, or both are zero.
pub fn windowed_exponential(lag_m: f64, window_m: f64, length_m: f64) -> f64 {
    assert!(
        window_m >= 0.0 && length_m >= 0.0 && window_m + length_m > 0.0,
        "window {window_m} m, length {length_m} m"
    );
    let lag_m = lag_m.abs();
    if length_m < 1e-9 * window_m {
        return (1.0 - lag_m / window_m).max(0.0);
    }
    let (a, t) = (window_m / length_m, lag_m / length_m);
    if a < 1e-9 {
        return (-t).exp();
    }
    let covariance =
        if t >= a { (a - t).exp() * (-a).exp_m1().powi(2) } else { bend(t + a) + bend(a - t) - 2.0 * bend(t) };
    covariance / (2.0 * bend(a))
}

/// G(x) = e^{−x} − 1 + x without cancellation.
fn bend(x: f64) -> f64 {
    if x > 0.05 {
        return (-x).exp_m1() + x;
    }
    // Σ_{n≥2} (−x)ⁿ/n!
    let mut term = 0.5 * x * x;
    let mut sum = term;
    for n in 3..12 {
        term *= -x / f64::from(n);
        sum += term;
    }
    sum
}

/// A correlation model of a record.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum RecordModel {
    /// e^{−s/ℓ}.
    Exponential,
    /// e^{−(s/ℓ)²}.
    SquaredExponential,
    /// The moving average over a window of an exponential; see [`windowed_exponential`].
    WindowedExponential {
        /// Window W in metre.
        window_m: f64,
    },
}

impl RecordModel {
    /// Correlation at a lag, for the length ℓ, both in metre.
    pub fn correlation(&self, lag_m: f64, length_m: f64) -> f64 {
        match self {
            Self::Exponential => (-lag_m / length_m).exp(),
            Self::SquaredExponential => (-(lag_m / length_m).powi(2)).exp(),
            Self::WindowedExponential { window_m } => windowed_exponential(lag_m, *window_m, length_m),
        }
    }
}

/// A model fitted to a record.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct RecordFit {
    /// The model.
    pub model: RecordModel,
    /// Fitted ℓ in metre. Values near 10⁻³ steps mean that the window alone explains the record.
    pub length_m: f64,
    /// Weighted root mean square of estimated minus fitted correlation over the lags used.
    pub misfit: f64,
}

/// Fits ℓ of one model over the lags up to where the correlation first falls to zero, weighted by pairs.
///
/// # Errors
/// Fewer than one lag besides zero.
pub fn fit_record(record: &RecordCorrelation, model: RecordModel) -> Result<RecordFit, EstimateError> {
    let (length_m, misfit) = fit_length(&[(model, record)])?;
    Ok(RecordFit { model, length_m, misfit })
}

/// Fits one ℓ to records averaged over different windows, each (W in metre, correlation): the exponential process under
/// all of them. Returns ℓ in metre and the misfit. Every record weighs the same.
///
/// # Errors
/// No record, or one without a lag besides zero.
pub fn fit_windowed_exponential(records: &[(f64, &RecordCorrelation)]) -> Result<(f64, f64), EstimateError> {
    let with_models: Vec<_> = records
        .iter()
        .map(|(window_m, record)| (RecordModel::WindowedExponential { window_m: *window_m }, *record))
        .collect();
    fit_length(&with_models)
}

fn fit_length(records: &[(RecordModel, &RecordCorrelation)]) -> Result<(f64, f64), EstimateError> {
    let mut terms = Vec::new();
    let share = 1.0 / (records.len() as f64).sqrt();
    for (model, record) in records {
        let lags = record.fitted_lags();
        if lags.is_empty() {
            return Err(EstimateError::TooFew { present: record.correlation.len(), wanted: 2 });
        }
        terms.extend(lags.into_iter().map(|(lag_m, rho, weight)| (*model, lag_m, rho, weight * share)));
    }
    let Some((_, first)) = records.first() else {
        return Err(EstimateError::TooFew { present: 0, wanted: 1 });
    };
    let ranges = records.iter().map(|(_, record)| record.length_range());
    let range = ranges.fold(first.length_range(), |a, b| Range { low: a.low.min(b.low), high: a.high.max(b.high) });
    let residuals = |p: &[f64]| -> Vec<f64> {
        terms.iter().map(|(model, lag_m, rho, weight)| weight * (model.correlation(*lag_m, p[0]) - rho)).collect()
    };
    let decay = first.correlation_length_m().unwrap_or(first.step_m * first.correlation.len() as f64);
    // One start may lie on the plateau where the window hides ℓ; the best of three is kept.
    let candidates = [1.0, 0.1, 0.01].map(|factor| minimise(&residuals, &[factor * decay], &[range]));
    let best = candidates.into_iter().min_by(|a, b| a.1.total_cmp(&b.1));
    best.map(|(found, sum)| (found[0], sum.sqrt())).ok_or(EstimateError::TooFew { present: 0, wanted: 1 })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::random;

    /// A stationary autoregressive record with correlation φ^lag.
    fn autoregressive(phi: f64, n: usize, index: u64) -> Vec<f64> {
        let noise = random::standard_normal(&mut random::stream(31, "ar", index), n);
        let mut last = noise[0];
        noise
            .iter()
            .enumerate()
            .map(|(i, e)| {
                last = if i == 0 { *e } else { phi * last + (1.0 - phi * phi).sqrt() * e };
                last
            })
            .collect()
    }

    #[test]
    fn both_normalisations_are_direct_sums_with_missing_values() {
        let mut record = autoregressive(0.7, 23, 0);
        (record[3], record[10], record[11]) = (f64::NAN, f64::NAN, f64::INFINITY);
        let present: Vec<f64> = record.iter().copied().filter(|v| v.is_finite()).collect();
        let mean = present.iter().sum::<f64>() / 20.0;
        let variance = present.iter().map(|v| (v - mean).powi(2)).sum::<f64>() / 20.0;
        let biased = autocorrelation_1d(&record, LagNormalisation::Biased).unwrap();
        let paired = autocorrelation_1d(&record, LagNormalisation::PairNormalised).unwrap();
        for lag in 0..23 {
            let products: Vec<f64> = (0..23 - lag)
                .map(|i| (record[i] - mean) * (record[i + lag] - mean))
                .filter(|p| p.is_finite())
                .collect();
            let sum = products.iter().sum::<f64>() / variance;
            assert!((biased[lag] - sum / 20.0).abs() < 1e-13);
            assert!((paired[lag] - sum / products.len() as f64).abs() < 1e-12 || products.is_empty());
        }
    }

    /// The correlation of a window mean by a fine double sum over the window.
    fn direct(lag: f64, window: f64, length: f64) -> f64 {
        let n = 400_i32;
        let step = window / f64::from(n);
        let at = |lag: f64| {
            let mut sum = 0.0;
            for i in -(n - 1)..n {
                sum += f64::from(n - i.abs()) * (-(lag + step * f64::from(i)).abs() / length).exp();
            }
            sum
        };
        at(lag) / at(0.0)
    }

    #[test]
    fn the_windowed_exponential_is_the_average_over_the_window() {
        for (window, length) in [(600.0, 250.0), (600.0, 2000.0), (75.0, 250.0), (600.0, 60.0)] {
            for lag in [0.0, 20.0, 74.0, 300.0, 599.0, 601.0, 1500.0] {
                let error = (windowed_exponential(lag, window, length) - direct(lag, window, length)).abs();
                // The sum over cells h errs by (h/ℓ)²/12 of the smooth part and h²/(4ℓW) at the kink.
                let cell = window / 400.0;
                assert!(
                    error < cell * cell / length * (1.0 / length + 1.0 / window),
                    "W {window} ℓ {length} lag {lag}: {error:e}"
                );
            }
        }
    }

    #[test]
    fn the_window_limits_are_the_triangle_and_the_exponential() {
        for s in [0.0_f64, 0.3, 0.99, 1.7] {
            assert!((windowed_exponential(s, 1.0, 1e-7) - (1.0 - s).max(0.0)).abs() < 1e-6);
            assert!((windowed_exponential(s, 1.0, 0.0) - (1.0 - s).max(0.0)).abs() < 1e-15);
            assert!((windowed_exponential(s, 1e-5, 1.0) - (-s).exp()).abs() < 1e-5);
            assert!((windowed_exponential(s, 1e-12, 1.0) - (-s).exp()).abs() < 1e-9);
        }
        // Its variance is the published factor 2ℓ/W[1 − (ℓ/W)(1 − e^{−W/ℓ})] = .51761 for W = 600, ℓ = 250.
        let a: f64 = 600.0 / 250.0;
        assert!((2.0 * bend(a) / (a * a) - 0.51761).abs() < 5e-6);
        assert!((bend(0.05) - ((-0.05_f64).exp_m1() + 0.05)).abs() < 1e-16);
    }

    /// The exact correlation of a model at lags of one metre, as if estimated.
    fn exact(model: RecordModel, length_m: f64, lags: usize) -> RecordCorrelation {
        let correlation = (0..lags).map(|lag| model.correlation(10.0 * lag as f64, length_m)).collect();
        RecordCorrelation { step_m: 10.0, correlation, pairs: vec![100.0; lags], mean: 0.0, variance: 1.0 }
    }

    #[test]
    fn exact_correlations_give_their_length_back_and_no_misfit() {
        for model in [
            RecordModel::Exponential,
            RecordModel::SquaredExponential,
            RecordModel::WindowedExponential { window_m: 600.0 },
            RecordModel::WindowedExponential { window_m: 75.0 },
        ] {
            let fit = fit_record(&exact(model, 250.0, 400), model).unwrap();
            assert!((fit.length_m / 250.0 - 1.0).abs() < 1e-5 && fit.misfit < 1e-7, "{fit:?}");
        }
        let windows = [75.0, 150.0, 300.0, 600.0];
        let records = windows.map(|window_m| exact(RecordModel::WindowedExponential { window_m }, 120.0, 300));
        let pairs: Vec<_> = windows.into_iter().zip(&records).collect();
        let (length_m, misfit) = fit_windowed_exponential(&pairs).unwrap();
        assert!((length_m / 120.0 - 1.0).abs() < 1e-5 && misfit < 1e-7);
    }

    #[test]
    fn an_exponential_fitted_to_the_triangle_of_a_window_finds_a_length_of_the_window() {
        // W = 600 µm alone returns 322–368 µm, depending on how far the fit reaches.
        let triangle = exact(RecordModel::WindowedExponential { window_m: 600.0 }, 0.0, 100);
        let fit = fit_record(&triangle, RecordModel::Exponential).unwrap();
        assert!(fit.length_m > 322.0 && fit.length_m < 368.0, "{}", fit.length_m);
        let own = fit_record(&triangle, RecordModel::WindowedExponential { window_m: 600.0 }).unwrap();
        assert!(own.length_m < 5.0 && own.misfit < 0.2 * fit.misfit, "{own:?}");
    }

    #[test]
    fn the_length_of_an_autoregressive_record_is_recovered() {
        // φ = e^{−Δ/ℓ} with Δ = 10, ℓ = 250: .9607894392.
        let lengths: Vec<f64> = (0..16)
            .map(|index| {
                let records: Vec<Vec<f64>> =
                    (0..4).map(|r| autoregressive(0.960_789_439_2, 5000, 4 * index + r)).collect();
                let views: Vec<&[f64]> = records.iter().map(Vec::as_slice).collect();
                let found = RecordCorrelation::estimate(&views, 10.0, 400, LagNormalisation::PairNormalised).unwrap();
                fit_record(&found, RecordModel::Exponential).unwrap().length_m
            })
            .collect();
        let mean = lengths.iter().sum::<f64>() / 16.0;
        let error = (lengths.iter().map(|l| (l - mean).powi(2)).sum::<f64>() / (15.0 * 16.0)).sqrt();
        assert!((mean - 250.0).abs() < 4.0 * error + 2.5, "{mean} ± {error}");
    }

    #[test]
    fn records_without_variation_or_values_are_refused() {
        assert_eq!(
            autocorrelation_1d(&[0.1; 5], LagNormalisation::Biased),
            Err(EstimateError::Constant { present: 5 })
        );
        assert!(matches!(
            autocorrelation_1d(&[], LagNormalisation::Biased),
            Err(EstimateError::TooFew { present: 0, .. })
        ));
        let bad = RecordCorrelation::estimate(&[&[0.0, 1.0, 2.0]], 0.0, 2, LagNormalisation::Biased);
        assert_eq!(bad, Err(EstimateError::BadStep { step_m: 0.0 }));
    }
}
