//! Sample statistics: moments, intervals, histograms, and the effective size of correlated records.

mod autocorrelation;
#[doc(hidden)]
pub mod blocks;
#[doc(hidden)]
pub mod flat_top;
mod histogram;
mod layout;
mod moments;
mod process;
mod record_sum;
mod sorting;
mod spread;

use statrs::distribution::{ContinuousCDF, StudentsT};
use thiserror::Error;

#[doc(hidden)]
pub use autocorrelation::lag_sums;
pub use autocorrelation::{CorrelationTime, correlation_time};
pub use histogram::Histogram;
pub use layout::Layout;
#[doc(hidden)]
pub use layout::sum_of_tracks;
pub use moments::{Extent, Moments};
pub use process::{ProcessEstimate, ProcessMoments, fraction_above};
#[doc(hidden)]
pub use record_sum::RecordSum;
#[doc(hidden)]
pub use sorting::{Order, sorted};
#[doc(hidden)]
pub use spread::Spread;

/// Error of an undefined statistic.
#[derive(Debug, Clone, PartialEq, Error)]
#[non_exhaustive]
pub enum StatsError {
    /// Too few values.
    #[error("{n} values are present; {statistic} needs at least {wanted}")]
    TooFew {
        /// Name of the statistic.
        statistic: &'static str,
        /// Values present.
        n: usize,
        /// Values needed.
        wanted: usize,
    },
    /// Equal values.
    #[error("all {n} values are equal, so {statistic} is undefined")]
    Constant {
        /// Name of the statistic.
        statistic: &'static str,
        /// Values present.
        n: usize,
    },
}

/// Confidence interval.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Interval {
    /// Lower limit.
    pub low: f64,
    /// Upper limit.
    pub high: f64,
}

impl Interval {
    /// Returns whether the value is in the closed interval.
    pub fn contains(&self, value: f64) -> bool {
        self.low <= value && value <= self.high
    }

    /// Returns the smallest interval that contains this one and another.
    pub(crate) fn around(self, other: Self) -> Self {
        Self { low: self.low.min(other.low), high: self.high.max(other.high) }
    }
}

/// Returns the quantile of *sorted* values at `probability` by linear interpolation between order statistics, the i-th
/// of n at probability i/(n − 1) (type 7 of Hyndman & Fan 1996, the default of NumPy and R). NaN without values.
///
/// # Panics
/// If the probability lies outside [0, 1].
pub fn quantile_sorted(sorted: &[f64], probability: f64) -> f64 {
    assert!((0.0..=1.0).contains(&probability), "probability {probability} lies outside [0, 1]");
    if sorted.is_empty() { f64::NAN } else { between_order_statistics(sorted, probability * (sorted.len() - 1) as f64) }
}

/// Returns the linear interpolation of sorted values at a position between 0 and n − 1.
#[inline]
pub(crate) fn between_order_statistics(sorted: &[f64], position: f64) -> f64 {
    let left = position.floor() as usize;
    let right = (left + 1).min(sorted.len() - 1);
    let (low, high, part) = (sorted[left], sorted[right], position - left as f64);
    // Infinite values have no difference.
    match (low.is_finite(), high.is_finite()) {
        (true, true) => low + part * (high - low),
        (true, false) if part > 0.0 => high,
        _ => low,
    }
}

/// Returns the median, the upper one of two; `None` without values. The values are reordered.
#[doc(hidden)]
pub fn upper_median(values: &mut [f64]) -> Option<f64> {
    let middle = values.len() / 2;
    (!values.is_empty()).then(|| *values.select_nth_unstable_by(middle, f64::total_cmp).1)
}

/// Returns the sorted values without NaN.
pub fn sorted_present(values: impl IntoIterator<Item = f64>) -> Vec<f64> {
    let present: Vec<f64> = values.into_iter().filter(|v| !v.is_nan()).collect();
    sorted(&present, 0.0, Order::Ascending)
}

/// Returns the quantile of Student's distribution; NaN unless 0 < `probability` < 1 and the degrees of freedom are
/// positive.
pub fn student_quantile(probability: f64, degrees_of_freedom: f64) -> f64 {
    let inside = probability > 0.0 && probability < 1.0;
    let distribution = StudentsT::new(0.0, 1.0, degrees_of_freedom);
    distribution.ok().filter(|_| inside).map_or(f64::NAN, |student| student.inverse_cdf(probability))
}

/// Returns half the width of a two-sided 95 % interval in standard errors estimated from that many independent values:
/// Student's quantile of one degree of freedom less. Infinite for fewer than two values.
pub fn student_95(values: usize) -> f64 {
    if values < 2 { f64::INFINITY } else { student_quantile(0.975, values as f64 - 1.0) }
}

/// Returns the standard error of a statistic by the jackknife, from its values without each of the samples.
///
/// # References
/// Efron & Tibshirani, *An Introduction to the Bootstrap*, Chapman & Hall 1993, ch. 11.
pub fn jackknife_error(without: &[f64]) -> f64 {
    jackknife(1.0, without)
}

/// Returns half the width of the 95 % interval of a statistic by the jackknife; see [`jackknife_error`].
pub fn jackknife_reach(without: &[f64]) -> f64 {
    jackknife(student_95(without.len()), without)
}

fn jackknife(factor: f64, without: &[f64]) -> f64 {
    factor * Moments::new(without).std * (without.len() as f64 - 1.0).sqrt()
}

/// Returns the ratio Σa/Σb over independent pairs [a, b] and half the width of its 95 % interval, from the residuals
/// a − b Σa/Σb.
pub fn ratio_95(pairs: &[[f64; 2]]) -> [f64; 2] {
    let n = pairs.len() as f64;
    let [above, below] = pairs.iter().fold([0.0; 2], |sums, pair| [sums[0] + pair[0], sums[1] + pair[1]]);
    let ratio = above / below;
    let squares: f64 = pairs.iter().map(|[a, b]| (a - ratio * b).powi(2)).sum();
    [ratio, student_95(pairs.len()) * (squares * n / (n - 1.0)).sqrt() / below]
}

/// Returns the two-sided p-value of Student's t; NaN for NaN, and unless the degrees of freedom are positive.
pub fn student_two_sided(t: f64, degrees_of_freedom: f64) -> f64 {
    let distribution = StudentsT::new(0.0, 1.0, degrees_of_freedom);
    distribution.ok().filter(|_| !t.is_nan()).map_or(f64::NAN, |student| 2.0 * student.cdf(-t.abs()))
}

/// Returns Wilson's 95 % score interval of a proportion of `successes` out of `trials`; [0, 1] without trials.
///
/// In contrast to the normal approximation it is within [0, 1] and has positive width for 0 and for `trials` successes.
///
/// # References
/// Wilson, *J. Am. Stat. Assoc.* **22** (1927) 209, <https://doi.org/10.1080/01621459.1927.10502953>.
///
/// # Panics
/// If there are more successes than trials.
pub fn wilson_interval(successes: usize, trials: usize) -> Interval {
    assert!(successes <= trials, "{successes} successes of {trials} trials");
    if trials == 0 {
        return Interval { low: 0.0, high: 1.0 };
    }
    let (n, fraction) = (trials as f64, successes as f64 / trials as f64);
    let z2 = NORMAL_95 * NORMAL_95;
    let centre = (fraction + z2 / (2.0 * n)) / (1.0 + z2 / n);
    let half = NORMAL_95 / (1.0 + z2 / n) * (fraction * (1.0 - fraction) / n + z2 / (4.0 * n * n)).sqrt();
    Interval {
        low: if successes == 0 { 0.0 } else { centre - half },
        high: if successes == trials { 1.0 } else { centre + half },
    }
}

/// Φ⁻¹(0.975): half the width of a two-sided 95 % interval in standard errors.
pub const NORMAL_95: f64 = 1.959_963_984_540_054;

/// Default of the least fraction of random samples that must have a valid result; statistics of fewer are refused.
pub const VALID_FRACTION: f64 = 0.95;

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn quantiles_interpolate_between_order_statistics() {
        let sorted = [1.0, 2.0, 4.0, 8.0];
        assert_eq!(quantile_sorted(&sorted, 0.0), 1.0);
        assert_eq!(quantile_sorted(&sorted, 0.5), 3.0);
        assert_eq!(quantile_sorted(&sorted, 1.0), 8.0);
        assert_eq!(quantile_sorted(&[5.0], 0.3), 5.0);
        assert!(quantile_sorted(&[], 0.3).is_nan());
        // Between infinite values, and next to one.
        let infinite = [f64::NEG_INFINITY, f64::NEG_INFINITY, 1.0, 3.0, f64::INFINITY];
        let quantiles = [0.0, 0.1, 0.25, 0.3, 0.5, 0.625, 0.75, 0.8, 1.0].map(|p| quantile_sorted(&infinite, p));
        let (low, high) = (f64::NEG_INFINITY, f64::INFINITY);
        assert_eq!(quantiles, [low, low, low, low, 1.0, 2.0, 3.0, high, high]);
        assert_eq!(sorted_present([2.0, f64::NAN, 1.0]), [1.0, 2.0]);
    }

    #[test]
    fn wilson_ends_solve_the_score_equation() {
        // At a limit p of the interval, |fraction − p| = z √(p(1 − p)/n).
        for (successes, trials) in [(3, 10), (1, 50), (499, 500)] {
            let (n, fraction) = (trials as f64, successes as f64 / trials as f64);
            let interval = wilson_interval(successes, trials);
            for p in [interval.low, interval.high] {
                let score = (fraction - p).abs() / (p * (1.0 - p) / n).sqrt();
                assert!((score - NORMAL_95).abs() < 1e-9, "{successes}/{trials}: {score}");
            }
        }
        assert_eq!(wilson_interval(0, 10).low, 0.0);
        assert_eq!(wilson_interval(10, 10).high, 1.0);
        assert!((wilson_interval(0, 10).high - 0.277_53).abs() < 5e-6, "z²/(n + z²)");
        assert_eq!(wilson_interval(0, 0), Interval { low: 0.0, high: 1.0 });
    }

    #[test]
    fn student_quantiles_are_the_tables() {
        for (degrees, wanted) in [(1.0, 12.706_2), (9.0, 2.262_157), (30.0, 2.042_272)] {
            assert!((student_quantile(0.975, degrees) / wanted - 1.0).abs() < 1e-5);
        }
        assert!(student_quantile(0.975, 0.0).is_nan() && student_quantile(1.0, 5.0).is_nan());
        assert_eq!((student_95(10), student_95(1)), (student_quantile(0.975, 9.0), f64::INFINITY));
    }

    #[test]
    fn the_jackknife_of_a_mean_has_the_standard_error_of_the_mean() {
        let values = [1.0, 2.0, 4.0, 8.0];
        let without = values.map(|own| (15.0 - own) / 3.0);
        let error = Moments::new(&values).standard_error();
        assert!((jackknife_error(&without) / error - 1.0).abs() < 1e-14);
        assert!((jackknife_reach(&without) / (student_95(4) * error) - 1.0).abs() < 1e-14);
    }

    #[test]
    fn a_ratio_to_a_constant_has_the_interval_of_a_mean() {
        let values = [1.0, 2.0, 4.0, 8.0];
        let [ratio, reach] = ratio_95(&values.map(|value| [value, 2.0]));
        let wanted = 0.5 * student_95(4) * Moments::new(&values).standard_error();
        assert!((ratio - 1.875).abs() < 1e-15 && (reach / wanted - 1.0).abs() < 1e-14);
        assert_eq!(ratio_95(&[[1.0, 4.0], [2.0, 8.0]]), [0.25, 0.0]);
    }
}
