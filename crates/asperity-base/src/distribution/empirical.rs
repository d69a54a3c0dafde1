//! Empirical distribution: linear interpolation between sorted values.

use crate::stats::between_order_statistics;

/// Returns the distribution function, with point masses for the half steps beyond the first and the last value.
pub(super) fn cdf(sorted: &[f64], x: f64) -> f64 {
    if x.is_nan() {
        return f64::NAN;
    }
    let n = sorted.len() as f64;
    let after = sorted.partition_point(|v| *v <= x);
    if after == 0 {
        return 0.0;
    }
    if after == sorted.len() {
        return 1.0;
    }
    let (left, right) = (sorted[after - 1], sorted[after]);
    (after as f64 - 0.5 + (x - left) / (right - left)) / n
}

/// Returns the quantile.
pub(super) fn quantile(sorted: &[f64], probability: f64) -> f64 {
    let position = (probability * sorted.len() as f64 - 0.5).clamp(0.0, sorted.len() as f64 - 1.0);
    between_order_statistics(sorted, position)
}
