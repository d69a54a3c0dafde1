//! Effective size of a correlated record.

use super::{Moments, StatsError};
use crate::fourier::{RealFft2, good_length};

/// Sokal's window factor: the sum of correlations ends at the first lag of at least this many correlation times.
const WINDOW_FACTOR: f64 = 5.0;

/// Integrated autocorrelation time of a record.
#[derive(Debug, Clone, PartialEq)]
pub struct CorrelationTime {
    /// Values present.
    pub n: usize,
    /// τ = 1 + 2 Σ_{k=1}^{window} ρ_k, in sampling steps, at least 1: the mean of n values has the variance σ²τ/n.
    pub steps: f64,
    /// Lag at which the sum ends.
    pub window: usize,
    /// Whether that lag is short compared with the record (at most n/10), so that τ is reliable.
    pub resolved: bool,
}

impl CorrelationTime {
    /// Returns the effective sample size n/τ.
    pub fn effective_size(&self) -> f64 {
        self.n as f64 / self.steps
    }
}

/// Returns the integrated autocorrelation time of an equally spaced record; NaN is a missing value, and the pairs at a
/// lag are those with both values present.
///
/// The window is the least W ≥ 5 τ(W) (Madras & Sokal, *J. Stat. Phys.* **50** (1988) 109,
/// <https://doi.org/10.1007/BF01022990>). τ is at least 1, so the effective size never exceeds n.
///
/// # Errors
/// Fewer than four values, or all equal.
pub fn correlation_time(record: &[f64]) -> Result<CorrelationTime, StatsError> {
    let moments = Moments::new(record);
    let statistic = "a correlation time";
    if moments.n < 4 {
        return Err(StatsError::TooFew { statistic, n: moments.n, wanted: 4 });
    }
    if moments.std == 0.0 {
        return Err(StatsError::Constant { statistic, n: moments.n });
    }
    let correlation = autocorrelation(record, &moments);
    let mut steps = 1.0;
    let mut window = 0;
    for (lag, rho) in correlation.iter().enumerate().skip(1) {
        steps += 2.0 * rho;
        window = lag;
        if lag as f64 >= WINDOW_FACTOR * f64::max(steps, 1.0) {
            break;
        }
    }
    let resolved = 10 * window <= moments.n;
    Ok(CorrelationTime { n: moments.n, steps: steps.max(1.0), window, resolved })
}

/// Returns the sums of products of deviations from `mean`, and the numbers of pairs, at the lags 0 … `lags` − 1 of a
/// record with non-finite missing values, by transforms of the zero-padded record.
///
/// # Panics
/// If the record is empty or shorter than the number of lags.
#[doc(hidden)]
pub fn lag_sums(record: &[f64], mean: f64, lags: usize) -> (Vec<f64>, Vec<f64>) {
    assert!(lags <= record.len() && !record.is_empty(), "a record has no more lags than values");
    let fft = RealFft2::new(good_length(2 * record.len()), 1);
    let (mut spectrum, mut work) = (fft.spectrum(), fft.workspace());
    let mut correlate = |values: Vec<f64>| {
        fft.forward_padded(&values, 1, values.len(), &mut spectrum, &mut work);
        for coefficient in &mut spectrum {
            *coefficient = coefficient.norm_sqr().into();
        }
        let mut sums = vec![0.0; lags];
        fft.inverse_cropped(&mut spectrum, &mut sums, 1, lags, &mut work);
        sums
    };
    let products = correlate(record.iter().map(|v| if v.is_finite() { v - mean } else { 0.0 }).collect());
    let mut pairs = correlate(record.iter().map(|v| f64::from(u8::from(v.is_finite()))).collect());
    pairs.iter_mut().for_each(|count| *count = count.round());
    (products, pairs)
}

/// Returns ρ_k for k = 0 … n/2 as the mean product over present pairs.
fn autocorrelation(record: &[f64], moments: &Moments) -> Vec<f64> {
    let (products, pairs) = lag_sums(record, moments.mean, record.len() / 2 + 1);
    let variance = moments.std * moments.std;
    products.iter().zip(&pairs).map(|(sum, count)| if *count > 0.0 { sum / count / variance } else { 0.0 }).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::random;
    use crate::testing::autoregressive;

    fn record(phi: f64, n: usize) -> Vec<f64> {
        autoregressive(phi, n, &mut random::stream(5, "ar1", 0))
    }

    #[test]
    fn the_fast_autocorrelation_is_the_mean_of_products_of_present_pairs() {
        let mut record = record(0.7, 101);
        for gap in [3, 4, 50] {
            record[gap] = f64::NAN;
        }
        let moments = Moments::new(&record);
        let fast = autocorrelation(&record, &moments);
        for (lag, rho) in fast.iter().enumerate() {
            let products: Vec<f64> = (0..record.len() - lag)
                .map(|i| (record[i] - moments.mean) * (record[i + lag] - moments.mean))
                .filter(|product| !product.is_nan())
                .collect();
            let slow = products.iter().sum::<f64>() / products.len() as f64 / moments.std.powi(2);
            assert!((rho - slow).abs() < 1e-12, "lag {lag}: {rho} {slow}");
        }
    }

    #[test]
    fn an_autoregressive_record_has_the_known_correlation_time() {
        // τ = (1 + φ)/(1 − φ); its relative standard error is √(2(2W + 1)/n) (Madras & Sokal), W ≈ 5τ.
        let n = 200_000;
        for phi in [0.0, 0.5, 0.9] {
            let (found, wanted) = (correlation_time(&record(phi, n)).unwrap(), (1.0 + phi) / (1.0 - phi));
            let error = (2.0 * (2.0 * found.window as f64 + 1.0) / n as f64).sqrt();
            assert!((found.steps / wanted - 1.0).abs() < 4.0 * error, "φ = {phi}: τ = {}", found.steps);
            assert!(found.resolved);
        }
    }

    #[test]
    fn a_record_of_one_wave_is_not_resolved_and_a_constant_is_refused() {
        let ramp: Vec<f64> = (0..100).map(f64::from).collect();
        assert!(!correlation_time(&ramp).unwrap().resolved);
        assert!(matches!(correlation_time(&[1.0; 10]), Err(StatsError::Constant { .. })));
        assert!(matches!(correlation_time(&[1.0, 2.0]), Err(StatsError::TooFew { .. })));
        let alternating: Vec<f64> = (0..1000).map(|i| f64::from(i % 2)).collect();
        assert_eq!(correlation_time(&alternating).unwrap().steps, 1.0);
    }
}
