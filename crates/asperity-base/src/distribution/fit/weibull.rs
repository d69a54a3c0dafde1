//! Weibull distribution with a given shift.

use crate::distribution::{DistributionError, Marginal};
use crate::stats::Moments;

/// Returns the maximum-likelihood Weibull distribution with this shift.
///
/// The shape k is the root of Σ tᵏ ln t/Σ tᵏ − 1/k = mean ln t, whose left side increases with k, by Newton's method on
/// ln k within a bracket. The scale is (mean tᵏ)^{1/k}.
pub(super) fn fit(sorted: &[f64], shift: f64) -> Result<Marginal, DistributionError> {
    let n = sorted.len() as f64;
    let failed = |reason| DistributionError::Sample { distribution: "weibull", n: sorted.len(), reason };
    let logs: Vec<f64> = sorted.iter().map(|x| (x - shift).ln()).collect();
    let moments = Moments::new(&logs);
    let largest = logs.last().copied().unwrap_or(f64::NAN);
    // Sums of t̃ᵏ (ln t̃)ʲ with t̃ = t/max t, which avoids overflow.
    let sums = |shape: f64| {
        logs.iter().map(|log| log - largest).fold([0.0; 3], |[zero, one, two], log| {
            let power = (shape * log).exp();
            [zero + power, one + power * log, two + power * log * log]
        })
    };
    // ln t has the standard deviation π/(√6 k).
    let mut log_shape = (std::f64::consts::PI / (6.0_f64.sqrt() * moments.std)).ln();
    if !log_shape.is_finite() {
        return Err(failed("a value lies at the shift"));
    }
    let (mut low, mut high) = (f64::NEG_INFINITY, f64::INFINITY);
    for _ in 0..100 {
        let shape = log_shape.exp();
        let [zero, one, two] = sums(shape);
        let mean_log = one / zero;
        let excess = mean_log + largest - moments.mean - 1.0 / shape;
        if excess < 0.0 {
            low = log_shape;
        } else {
            high = log_shape;
        }
        let slope = shape * (two / zero - mean_log * mean_log) + 1.0 / shape;
        let newton = log_shape - excess / slope;
        let next = if newton > low && newton < high { newton } else { 0.5 * (low + high) };
        let step = (next - log_shape).abs();
        if !next.is_finite() {
            return Err(failed("the equation of the shape has no root"));
        }
        log_shape = next;
        if step < 1e-14 {
            break;
        }
    }
    let shape = log_shape.exp();
    Marginal::weibull(shape, (largest + (sums(shape)[0] / n).ln() / shape).exp(), shift)
}

#[cfg(test)]
mod tests {
    use super::super::tests::sample;
    use super::super::{Family, fit};
    use crate::distribution::{DistributionError, Marginal};

    #[test]
    fn a_density_that_diverges_at_its_end_has_no_fitted_shift() {
        let error = fit(Family::ShiftedWeibull, &sample("weibull:0.6,2", 500, 21)).unwrap_err();
        assert!(matches!(error, DistributionError::Sample { .. }), "{error}");
    }

    #[test]
    fn the_fit_follows_the_unit_of_the_values() {
        let metre = sample("weibull:2,1", 300, 22);
        let nanometre: Vec<f64> = metre.iter().map(|x| x * 1e-9).collect();
        let (Marginal::Weibull { shape: a, scale: s, .. }, Marginal::Weibull { shape: b, scale: t, .. }) =
            (fit(Family::Weibull, &metre).unwrap().marginal, fit(Family::Weibull, &nanometre).unwrap().marginal)
        else {
            panic!()
        };
        assert!((a / b - 1.0).abs() < 1e-12 && (s * 1e-9 / t - 1.0).abs() < 1e-12);
    }
}
