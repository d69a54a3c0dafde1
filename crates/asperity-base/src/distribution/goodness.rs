//! Goodness of fit and tests of normality.

mod null;

pub use null::ProcessNull;

use super::{DistributionError, Marginal, condensed};
use crate::stats::{Moments, sorted_present};

/// Number of values between the first evaluations of the distribution function in [`largest_difference`].
const STRIDE: usize = 64;

/// Distance between a sample and a distribution, with its p-value.
///
/// The p-values of [`kolmogorov_smirnov`] and [`anderson_darling`] assume a distribution specified in advance. After a
/// fit to the same sample they are too large: small values still reject the distribution, large ones do not support it.
/// The p-values of [`ProcessNull`] account for the fit and the correlation.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Goodness {
    /// Test statistic of the sample.
    pub statistic: f64,
    /// Effective sample size of the p-value.
    pub effective_size: f64,
    /// p-value.
    pub p_value: f64,
}

/// Distances between a sample and a distribution fitted to it; the p-values are too large, see [`Goodness`].
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct FitGoodness {
    /// Largest difference of the distribution functions.
    pub kolmogorov_smirnov: Goodness,
    /// Anderson–Darling distance, which weights the tails; absent if a value is at the end of the support, where it is
    /// infinite.
    pub anderson_darling: Option<Goodness>,
}

impl FitGoodness {
    /// Returns the distances of independent or correlated values, sorted and without NaN; `None` for an empty sample.
    pub(super) fn new(marginal: &Marginal, sorted: &[f64], effective_size: f64) -> Option<Self> {
        (!sorted.is_empty()).then(|| Self {
            kolmogorov_smirnov: sorted_kolmogorov_smirnov(sorted, marginal, effective_size),
            anderson_darling: sorted_anderson_darling(sorted, marginal, effective_size).ok(),
        })
    }
}

/// Returns the Kolmogorov–Smirnov distance D = sup |F_n − F|. NaN values are skipped.
///
/// `effective_size` is the effective size of a correlated sample ([`crate::stats::correlation_time`]); `None` treats
/// the values as independent. The p-value is Kolmogorov's limit at λ = (√n + 0.12 + 0.11/√n) D (Stephens, *J. R. Stat.
/// Soc. B* **32** (1970) 115), accurate from n ≈ 5.
///
/// # Errors
/// An empty sample.
pub fn kolmogorov_smirnov(
    values: &[f64],
    marginal: &Marginal,
    effective_size: Option<f64>,
) -> Result<Goodness, DistributionError> {
    let sorted = present(values, marginal, 1)?;
    Ok(sorted_kolmogorov_smirnov(&sorted, marginal, effective_size.unwrap_or(f64::INFINITY)))
}

fn sorted_kolmogorov_smirnov(sorted: &[f64], marginal: &Marginal, effective_size: f64) -> Goodness {
    let statistic = largest_difference(sorted, marginal);
    let effective_size = effective_size.min(sorted.len() as f64);
    let root = effective_size.sqrt();
    let p_value = kolmogorov_survival((root + 0.12 + 0.11 / root) * statistic);
    Goodness { statistic, effective_size, p_value }
}

/// Returns sup |F_n − F| of sorted values. F is not evaluated between two values where its monotonicity excludes the
/// largest difference.
fn largest_difference(sorted: &[f64], marginal: &Marginal) -> f64 {
    let n = sorted.len() as f64;
    let difference = |i: usize, cdf: f64| {
        let above = cdf.mul_add(n, -(i as f64));
        f64::max(above, 1.0 - above) / n
    };
    let starts: Vec<(usize, f64)> = (0..sorted.len()).step_by(STRIDE).map(|i| (i, marginal.cdf(sorted[i]))).collect();
    let mut largest = starts.iter().map(|(i, cdf)| difference(*i, *cdf)).fold(0.0, f64::max);
    for (block, (start, low)) in starts.iter().enumerate() {
        let (end, high) = starts.get(block + 1).copied().unwrap_or((sorted.len(), 1.0));
        let bound = f64::max(high - *start as f64 / n, end as f64 / n - low);
        // A bound or a difference that is NaN excludes nothing.
        if bound + 1e-12 < largest {
            continue;
        }
        for (i, x) in (*start..end).zip(&sorted[*start..end]).skip(1) {
            largest = largest.max(difference(i, marginal.cdf(*x)));
        }
    }
    largest
}

/// Returns the Anderson–Darling distance A² = −n − Σ (2i − 1)/n [ln F(x_i) + ln(1 − F(x_{n+1−i}))], which weights the
/// tails. NaN values are skipped.
///
/// For a correlated sample A² is proportional to n/n_eff, which the p-value corrects. The p-value is the limit of large
/// samples (Marsaglia & Marsaglia, *J. Stat. Softw.* **9** (2004) 2, <https://doi.org/10.18637/jss.v009.i02>), to about
/// 1e-5. More than 32,768 values are grouped, which changes A² by about 0.001.
///
/// # Errors
/// An empty sample, or a value outside the support, where A² is infinite.
pub fn anderson_darling(
    values: &[f64],
    marginal: &Marginal,
    effective_size: Option<f64>,
) -> Result<Goodness, DistributionError> {
    let sorted = present(values, marginal, 1)?;
    sorted_anderson_darling(&sorted, marginal, effective_size.unwrap_or(f64::INFINITY))
}

fn sorted_anderson_darling(
    sorted: &[f64],
    marginal: &Marginal,
    effective_size: f64,
) -> Result<Goodness, DistributionError> {
    let few = condensed(sorted);
    let (n, groups) = (sorted.len() as f64, few.len() as f64);
    let sum: f64 = few
        .iter()
        .zip(few.iter().rev())
        .enumerate()
        .map(|(i, (low, high))| (2.0 * i as f64 + 1.0) * (marginal.cdf(*low).ln() + marginal.survival(*high).ln()))
        .sum();
    let inside = marginal.cdf(sorted[0]) > 0.0 && marginal.survival(sorted[sorted.len() - 1]) > 0.0;
    if !(sum.is_finite() && inside) {
        let reason = "a value lies at or beyond the end of the distribution's support";
        return Err(DistributionError::Sample { distribution: marginal.name(), n: sorted.len(), reason });
    }
    let statistic = n / groups * (-groups - sum / groups);
    let effective_size = effective_size.min(n);
    let p_value = 1.0 - anderson_darling_limit(statistic * effective_size / n);
    Ok(Goodness { statistic, effective_size, p_value })
}

/// Test of normality by skewness and kurtosis.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Normality {
    /// Skewness, transformed to a standard normal variable under normality.
    pub skewness_score: f64,
    /// Kurtosis, transformed to a standard normal variable under normality.
    pub kurtosis_score: f64,
    /// K², the sum of their squares: χ² with two degrees of freedom under normality.
    pub statistic: f64,
    /// p-value e^{−K²/2}.
    pub p_value: f64,
}

/// Tests independent values for normality by D'Agostino and Pearson's K²; NaN values are skipped.
///
/// # References
/// D'Agostino, *Biometrika* **57** (1970) 679, <https://doi.org/10.1093/biomet/57.3.679>; Anscombe & Glynn,
/// *Biometrika* **70** (1983) 227, <https://doi.org/10.1093/biomet/70.1.227>.
///
/// # Errors
/// Fewer than 20 values, for which the transformations are inaccurate, or all equal.
pub fn normality(values: &[f64]) -> Result<Normality, DistributionError> {
    let moments = Moments::new(values);
    let sample = |reason| DistributionError::Sample { distribution: "normal", n: moments.n, reason };
    if moments.n < 20 {
        return Err(sample("the test of normality needs at least 20"));
    }
    if moments.std == 0.0 {
        return Err(sample("all values are equal"));
    }
    let n = moments.n as f64;
    let skewness_score = skewness_score(moments.skewness, n);
    let kurtosis_score = kurtosis_score(moments.excess_kurtosis + 3.0, n);
    let statistic = skewness_score * skewness_score + kurtosis_score * kurtosis_score;
    Ok(Normality { skewness_score, kurtosis_score, statistic, p_value: (-0.5 * statistic).exp() })
}

/// D'Agostino's Johnson S_U transformation of √b₁.
fn skewness_score(skewness: f64, n: f64) -> f64 {
    let y = skewness * ((n + 1.0) * (n + 3.0) / (6.0 * (n - 2.0))).sqrt();
    let beta2 =
        3.0 * (n * n + 27.0 * n - 70.0) * (n + 1.0) * (n + 3.0) / ((n - 2.0) * (n + 5.0) * (n + 7.0) * (n + 9.0));
    let w2 = (2.0 * (beta2 - 1.0)).sqrt() - 1.0;
    let alpha = (2.0 / (w2 - 1.0)).sqrt();
    (y / alpha).asinh() / (0.5 * w2.ln()).sqrt()
}

/// Anscombe and Glynn's cube-root transformation of b₂.
fn kurtosis_score(kurtosis: f64, n: f64) -> f64 {
    let mean = 3.0 * (n - 1.0) / (n + 1.0);
    let variance = 24.0 * n * (n - 2.0) * (n - 3.0) / ((n + 1.0) * (n + 1.0) * (n + 3.0) * (n + 5.0));
    let x = (kurtosis - mean) / variance.sqrt();
    let root_beta1 = 6.0 * (n * n - 5.0 * n + 2.0) / ((n + 7.0) * (n + 9.0))
        * (6.0 * (n + 3.0) * (n + 5.0) / (n * (n - 2.0) * (n - 3.0))).sqrt();
    let a = 6.0 + 8.0 / root_beta1 * (2.0 / root_beta1 + (1.0 + 4.0 / (root_beta1 * root_beta1)).sqrt());
    let cube = (1.0 - 2.0 / a) / (1.0 + x * (2.0 / (a - 4.0)).sqrt());
    (1.0 - 2.0 / (9.0 * a) - cube.cbrt()) / (2.0 / (9.0 * a)).sqrt()
}

fn present(values: &[f64], marginal: &Marginal, wanted: usize) -> Result<Vec<f64>, DistributionError> {
    let sorted = sorted_present(values.iter().copied());
    if sorted.len() < wanted {
        return Err(DistributionError::Sample {
            distribution: marginal.name(),
            n: sorted.len(),
            reason: "no value is present",
        });
    }
    Ok(sorted)
}

/// Returns Kolmogorov's Q(λ) = 2 Σ (−1)^{k−1} e^{−2k²λ²}; for small λ by the theta transformation, which converges
/// faster.
fn kolmogorov_survival(lambda: f64) -> f64 {
    if lambda <= 0.0 {
        1.0
    } else if lambda < 1.18 {
        let y = (-std::f64::consts::PI.powi(2) / (8.0 * lambda * lambda)).exp();
        1.0 - std::f64::consts::TAU.sqrt() / lambda * (y + y.powi(9) + y.powi(25) + y.powi(49))
    } else {
        let x = (-2.0 * lambda * lambda).exp();
        2.0 * (x - x.powi(4) + x.powi(9))
    }
}

/// Returns P(A² < z) in the limit of large samples.
fn anderson_darling_limit(z: f64) -> f64 {
    if z <= 0.0 {
        0.0
    } else if z < 2.0 {
        let series =
            2.00012 + (0.247_105 - (0.064_982_1 - (0.034_796_2 - (0.011_672 - 0.001_686_91 * z) * z) * z) * z) * z;
        (-1.233_714_1 / z).exp() / z.sqrt() * series
    } else {
        let exponent = 1.0776 - (2.30695 - (0.43424 - (0.082_433 - (0.008_056 - 0.000_314_6 * z) * z) * z) * z) * z;
        (-exponent.exp()).exp()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::random;

    #[test]
    fn limits_have_their_tabulated_critical_values() {
        for (level, critical) in [(0.10, 1.223_848), (0.05, 1.358_099), (0.01, 1.627_624)] {
            assert!((kolmogorov_survival(critical) - level).abs() < 1e-6);
        }
        // The series of Anderson & Darling, Ann. Math. Stat. 23 (1952) 193, summed by quadrature in another program.
        for (statistic, p_value) in [(1.933, 0.099_995), (2.492, 0.050_022), (3.857, 0.010_241)] {
            assert!((1.0 - anderson_darling_limit(statistic) - p_value).abs() < 2e-5);
        }
        assert!((kolmogorov_survival(1.18 - 1e-9) - kolmogorov_survival(1.18)).abs() < 1e-8);
        assert!((anderson_darling_limit(2.0 - 1e-9) - anderson_darling_limit(2.0)).abs() < 1e-5);
    }

    #[test]
    fn a_perfect_sample_is_half_a_step_away_and_shuffling_changes_nothing() {
        let marginal: Marginal = "beta:2.1,5".parse().unwrap();
        let mut values: Vec<f64> = (0..50).map(|i| marginal.quantile((f64::from(i) + 0.5) / 50.0)).collect();
        let ks = kolmogorov_smirnov(&values, &marginal, None).unwrap();
        assert!((ks.statistic - 0.01).abs() < 1e-12 && ks.p_value > 1.0 - 1e-12);
        let ad = anderson_darling(&values, &marginal, None).unwrap();
        values.reverse();
        values.push(f64::NAN);
        let reversed = kolmogorov_smirnov(&values, &marginal, None).unwrap();
        assert!((ks.statistic - reversed.statistic).abs() < 1e-15);
        assert!((anderson_darling(&values, &marginal, None).unwrap().statistic - ad.statistic).abs() < 1e-12);
        assert!(anderson_darling(&[0.5, 1.5], &marginal, None).is_err());
    }

    #[test]
    fn the_largest_difference_is_the_largest_over_all_values() {
        for text in ["normal", "normal:0.1,0.8", "beta:2,3,-9,9", "lognormal:2,0.2,-8", "johnson_su:0,0.9"] {
            let marginal: Marginal = text.parse().unwrap();
            for (n, digits) in [(1, 1e9), (7, 1e9), (64, 1e9), (5000, 1e9), (5000, 5.0)] {
                let normal = random::standard_normal(&mut random::stream(6, "largest", n), n as usize);
                let sorted = sorted_present(normal.iter().map(|z| (z * digits).round() / digits));
                let above = |(i, x): (usize, &f64)| marginal.cdf(*x).mul_add(n as f64, -(i as f64));
                let differences = sorted.iter().enumerate().map(above).map(|d| f64::max(d, 1.0 - d) / n as f64);
                assert_eq!(largest_difference(&sorted, &marginal), differences.fold(0.0, f64::max), "{text} {n}");
            }
        }
    }

    #[test]
    fn the_distance_of_grouped_values_is_that_of_all() {
        let n = 50_000;
        let sorted = sorted_present(random::standard_normal(&mut random::stream(6, "grouped", 0), n));
        for text in ["normal", "normal:0.01,1", "lognormal:3,0.05,-20.1"] {
            let marginal: Marginal = text.parse().unwrap();
            let found = anderson_darling(&sorted, &marginal, None).unwrap().statistic;
            let of = |x: f64, y: f64| marginal.cdf(x).ln() + marginal.survival(y).ln();
            let terms = (0..n).map(|i| (2.0 * i as f64 + 1.0) * of(sorted[i], sorted[n - 1 - i]));
            let wanted = -(n as f64) - terms.sum::<f64>() / n as f64;
            assert!((found - wanted).abs() < 0.002 + 1e-3 * wanted, "{text}: {found} {wanted}");
        }
        // The largest value lies beyond the end, the mean of its group does not.
        let beyond = Marginal::beta(2.0, 2.0, -9.0, sorted[n - 1] - 1e-9).unwrap();
        assert!(anderson_darling(&sorted, &beyond, None).is_err());
    }

    #[test]
    fn p_values_of_true_distributions_are_uniform_and_correlation_is_paid_for() {
        let trials = 2000;
        let n = 60;
        let mut below = [0_usize; 3];
        for trial in 0..trials {
            let values = random::standard_normal(&mut random::stream(6, "goodness", trial), n);
            let marginal = &Marginal::STANDARD_NORMAL;
            let p = [
                kolmogorov_smirnov(&values, marginal, None).unwrap().p_value,
                anderson_darling(&values, marginal, None).unwrap().p_value,
                normality(&values).unwrap().p_value,
            ];
            below.iter_mut().zip(p).for_each(|(count, p)| *count += usize::from(p < 0.1));
            let doubled: Vec<f64> = values.iter().flat_map(|v| [*v, *v]).collect();
            let paid = anderson_darling(&doubled, marginal, Some(n as f64)).unwrap();
            assert!((paid.p_value - p[1]).abs() < 0.01, "{} {}", paid.p_value, p[1]);
        }
        // 10 % of 2,000, standard error 13.4; the K² approximation has an error of up to 1 % at n = 60.
        for (count, allowance) in below.into_iter().zip([0.0, 0.0, 20.0]) {
            assert!((count as f64 - 200.0).abs() < 4.0 * 13.4 + allowance, "{below:?}");
        }
    }

    /// Values by SciPy's `normaltest`, `skewtest` and `kurtosistest`.
    #[test]
    fn the_normality_test_matches_scipy() {
        let values: Vec<f64> = (1..=40).map(|i| (f64::from(i) / 41.0).powi(2)).collect();
        let test = normality(&values).unwrap();
        assert!((test.skewness_score - 1.7380777344580196).abs() < 1e-12, "{test:?}");
        assert!((test.kurtosis_score + 1.495935444956807).abs() < 1e-12, "{test:?}");
        assert!((test.p_value - 0.0721239917648529).abs() < 1e-12, "{test:?}");
        assert!(normality(&values[..19]).is_err());
        assert!(normality(&[1.0; 30]).is_err());
    }

    #[test]
    fn a_skewed_sample_is_not_normal() {
        let marginal: Marginal = "beta:2.1,5".parse().unwrap();
        let values: Vec<f64> = random::standard_normal(&mut random::stream(6, "skewed", 0), 2000)
            .iter()
            .map(|g| marginal.translate(*g))
            .collect();
        assert!(normality(&values).unwrap().p_value < 1e-6);
    }
}
