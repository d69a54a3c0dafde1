//! Quality of fit of a friction distribution: probability integral transform and quantile plot.

use asperity_base::distribution::Marginal;
use asperity_base::stats::{NORMAL_95, quantile_sorted};

/// Numbers of bins of the probability integral transform and of pairs of the quantile plot.
const BINS: usize = 20;
const PAIRS: usize = 400;

/// Named columns of equal length.
pub type Columns = Vec<(&'static str, Vec<f64>)>;

/// Returns the histogram of F(μ), which is 1 everywhere if the distribution fits, with a band that contains 95 % of the
/// bins. The band assumes `effective_size` independent values. Columns: `probability`, `density`, `low`, `high`.
pub fn integral_transform(marginal: &Marginal, sorted: &[f64], effective_size: f64) -> Columns {
    let mut density = vec![0.0; BINS];
    for mu in sorted {
        let bin = (marginal.cdf(*mu) * BINS as f64) as usize;
        density[bin.min(BINS - 1)] += BINS as f64 / sorted.len() as f64;
    }
    let fraction = 1.0 / BINS as f64;
    let reach = NORMAL_95 * (fraction * (1.0 - fraction) / effective_size).sqrt() * BINS as f64;
    vec![
        ("probability", (0..BINS).map(|bin| (bin as f64 + 0.5) * fraction).collect()),
        ("density", density),
        ("low", vec![(1.0 - reach).max(0.0); BINS]),
        ("high", vec![1.0 + reach; BINS]),
    ]
}

/// Returns quantiles of a sorted sample and of the distribution at the same probabilities: `probability`, `fitted`,
/// `measured`.
pub fn quantile_pairs(marginal: &Marginal, sorted: &[f64]) -> Columns {
    let count = sorted.len().min(PAIRS);
    let probability: Vec<f64> = (0..count).map(|k| (k as f64 + 0.5) / count as f64).collect();
    vec![
        ("fitted", probability.iter().map(|p| marginal.quantile(*p)).collect()),
        ("measured", probability.iter().map(|p| quantile_sorted(sorted, *p)).collect()),
        ("probability", probability),
    ]
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Returns quantiles of the distribution itself at the centres of equal probability intervals.
    fn ideal(marginal: &Marginal, n: usize) -> Vec<f64> {
        (0..n).map(|k| marginal.quantile((k as f64 + 0.5) / n as f64)).collect()
    }

    #[test]
    fn a_fitting_distribution_is_flat_and_straight() {
        let marginal: Marginal = "beta:2.1,5".parse().unwrap();
        let sorted = ideal(&marginal, 4000);
        let flat = integral_transform(&marginal, &sorted, 100.0);
        assert!(flat[1].1.iter().all(|density| (density - 1.0).abs() < 0.01), "{:?}", flat[1]);
        // 5 ± 1.96 √(100 · 0.05 · 0.95) values of 100 in a bin of 5 %.
        assert!((flat[3].1[0] - (1.0 + 1.959_964 * 4.75_f64.sqrt() / 5.0)).abs() < 1e-6);
        let straight = quantile_pairs(&marginal, &sorted);
        // Near the ends, a quantile of the sample lies between values that are far apart.
        let middle = 20..380;
        let pairs = || straight[0].1[middle.clone()].iter().zip(&straight[1].1[middle.clone()]);
        assert!(pairs().all(|(a, b)| (a - b).abs() < 2e-3));
    }

    #[test]
    fn a_too_narrow_distribution_deviates_at_both_ends() {
        let (marginal, wide) = (Marginal::STANDARD_NORMAL, Marginal::normal(0.0, 2.0).unwrap());
        let density = &integral_transform(&marginal, &ideal(&wide, 4000), 100.0)[1].1;
        // P(|2Z| > 1.645) / 0.1 = 4.11 at the ends.
        assert!((density[0] - 4.11).abs() < 0.03 && (density[19] - 4.11).abs() < 0.03, "{density:?}");
        let pairs = quantile_pairs(&marginal, &ideal(&wide, 4000));
        assert!(pairs[1].1.last().unwrap() > &(1.9 * pairs[0].1.last().unwrap()));
    }
}
