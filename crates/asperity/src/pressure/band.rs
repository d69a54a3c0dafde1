//! How well a distribution function is known: standard errors and bands.

use faer::{Mat, Side};

use crate::chaos::StepLaw;
use crate::random;
use crate::stats::{Interval, NORMAL_95};

/// Draws from which the critical value of a simultaneous band is taken.
const DRAWS: usize = 4000;

/// An estimated distribution function with 95 % bands at some values.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Band {
    /// Increasing values.
    pub values: Vec<f64>,
    /// Estimate of F at each; not forced to rise or to stay between 0 and 1.
    pub cdf: Vec<f64>,
    /// Standard errors.
    pub standard_errors: Vec<f64>,
    /// So many standard errors to either side hold F at one value with 95 %,
    pub pointwise_factor: f64,
    /// and so many at all the values at once.
    pub simultaneous_factor: f64,
}

impl Band {
    /// The band of normal errors with the given covariance, row by row; where that is estimated with few degrees of freedom,
    /// of Student's.
    pub(super) fn new(
        values: &[f64],
        cdf: &[f64],
        covariance: &[f64],
        degrees_of_freedom: Option<usize>,
        seed: u64,
    ) -> Self {
        let n = values.len();
        let standard_errors: Vec<f64> = (0..n).map(|i| covariance[i * n + i].max(0.0).sqrt()).collect();
        let simultaneous_factor = critical_value(&standard_errors, covariance, degrees_of_freedom, seed);
        let pointwise_factor = degrees_of_freedom.map_or(NORMAL_95, student_95);
        Self { values: values.to_vec(), cdf: cdf.to_vec(), standard_errors, pointwise_factor, simultaneous_factor }
    }

    /// The band of the empirical distribution function of `samples` independent values; F̂ at `values` is `cdf`.
    pub(super) fn of_independent(values: &[f64], cdf: &[f64], samples: usize, seed: u64) -> Self {
        let covariance = |i: usize, j: usize| cdf[i.min(j)] * (1.0 - cdf[i.max(j)]) / samples as f64;
        let n = values.len();
        let covariance: Vec<f64> = (0..n * n).map(|k| covariance(k / n, k % n)).collect();
        Self::new(values, cdf, &covariance, None, seed)
    }

    /// The 95 % interval of F at the value number `i`.
    pub fn pointwise(&self, i: usize) -> [f64; 2] {
        self.around(i, self.pointwise_factor)
    }

    /// The 95 % band of F at all values, at the one number `i`.
    pub fn simultaneous(&self, i: usize) -> [f64; 2] {
        self.around(i, self.simultaneous_factor)
    }

    fn around(&self, i: usize, factor: f64) -> [f64; 2] {
        let half = factor * self.standard_errors[i];
        [(self.cdf[i] - half).clamp(0.0, 1.0), (self.cdf[i] + half).clamp(0.0, 1.0)]
    }

    /// Standard error of F at any value: linear between those known.
    pub fn standard_error_at(&self, value: f64) -> f64 {
        let after = self.values.partition_point(|v| *v <= value);
        let (Some(low), Some(high)) = (after.checked_sub(1), self.values.get(after)) else {
            let ends = [self.standard_errors.first(), self.standard_errors.last()];
            return ends[usize::from(after > 0)].copied().unwrap_or(f64::INFINITY);
        };
        let share = (value - self.values[low]) / (high - self.values[low]);
        self.standard_errors[low] + share * (self.standard_errors[after] - self.standard_errors[low])
    }
}

/// A quantile and its 95 % interval.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct QuantileResult {
    /// Probability.
    pub probability: f64,
    /// The least value at which F reaches it.
    pub value: f64,
    /// The values at which F, a pointwise half width higher or lower, reaches it.
    pub interval: Interval,
}

impl Band {
    /// A quantile of `law`, which this is the band of.
    pub fn quantile(&self, law: &StepLaw, probability: f64) -> QuantileResult {
        let at = |shift: f64| {
            let reached = |value: &&f64| law.cdf(**value) + shift * self.standard_error_at(**value) >= probability;
            let values = law.values();
            values.iter().find(reached).or(values.last()).copied().unwrap_or(f64::NAN)
        };
        let factor = self.pointwise_factor;
        let interval = Interval { low: at(factor), high: at(-factor) };
        QuantileResult { probability, value: law.quantile(probability), interval }
    }
}

/// Two-sided 95 % point of Student's law; infinite without degrees of freedom.
fn student_95(degrees_of_freedom: usize) -> f64 {
    if degrees_of_freedom == 0 {
        f64::INFINITY
    } else {
        crate::stats::student_quantile(0.975, degrees_of_freedom as f64)
    }
}

/// The 95 % quantile of the largest |Z_i|/σ_i of normal Z with the given covariance.
fn critical_value(standard_errors: &[f64], covariance: &[f64], degrees_of_freedom: Option<usize>, seed: u64) -> f64 {
    let n = standard_errors.len();
    let used: Vec<usize> = (0..n).filter(|i| standard_errors[*i] > 0.0).collect();
    if used.is_empty() {
        return NORMAL_95;
    }
    let correlation = Mat::from_fn(used.len(), used.len(), |a, b| {
        let (i, j) = (used[a], used[b]);
        covariance[i * n + j] / (standard_errors[i] * standard_errors[j])
    });
    let Ok(eigen) = correlation.self_adjoint_eigen(Side::Lower) else { return f64::INFINITY };
    // Z = U √Λ ξ; rounding leaves some eigenvalues below zero.
    let factor = Mat::from_fn(used.len(), used.len(), |a, b| eigen.U()[(a, b)] * eigen.S()[b].max(0.0).sqrt());
    let degrees = degrees_of_freedom.unwrap_or(0);
    let rows = used.len() + degrees;
    let xi = random::standard_normal(&mut random::stream(seed, "pressure/band", 0), rows * DRAWS);
    let z = &factor * Mat::from_fn(used.len(), DRAWS, |a, draw| xi[draw * rows + a]);
    let mut largest: Vec<f64> = (0..DRAWS)
        .map(|draw| {
            let chi: f64 = xi[draw * rows + used.len()..(draw + 1) * rows].iter().map(|x| x * x).sum();
            let scale = if degrees > 0 { (chi / degrees as f64).sqrt() } else { 1.0 };
            (0..used.len()).map(|a| z[(a, draw)].abs()).fold(0.0, f64::max) / scale
        })
        .collect();
    largest.sort_by(f64::total_cmp);
    largest[DRAWS * 95 / 100]
}

/// Sums and products of vectors of one length.
#[derive(Debug, Clone)]
pub(super) struct Moments {
    count: f64,
    sums: Vec<f64>,
    /// Of each pair (i, j ≤ i), row by row.
    products: Vec<f64>,
}

impl Moments {
    pub(super) fn new(length: usize) -> Self {
        Self { count: 0.0, sums: vec![0.0; length], products: vec![0.0; length * (length + 1) / 2] }
    }

    pub(super) fn add(&mut self, values: &[f64]) {
        self.count += 1.0;
        let mut row = 0;
        for (i, value) in values.iter().enumerate() {
            self.sums[i] += value;
            for (product, other) in self.products[row..=row + i].iter_mut().zip(values) {
                *product += value * other;
            }
            row += i + 1;
        }
    }

    /// Variance of each component.
    pub(super) fn variances(&self) -> impl Iterator<Item = f64> {
        (0..self.sums.len())
            .scan(0, |place, i| {
                *place += i + 1;
                Some(*place - 1)
            })
            .zip(&self.sums)
            .map(|(place, sum)| (self.products[place] - sum * sum / self.count) / (self.count - 1.0))
    }

    /// Covariance of the vectors, pair by pair; zero of fewer than two.
    fn covariances(&self) -> impl Iterator<Item = f64> {
        let pairs = (0..self.sums.len()).flat_map(|i| (0..=i).map(move |j| (i, j)));
        let scale = if self.count > 1.0 { 1.0 / (self.count - 1.0) } else { 0.0 };
        pairs
            .zip(&self.products)
            .map(move |((i, j), product)| scale * (product - self.sums[i] * self.sums[j] / self.count))
    }
}

/// A sum of independent estimates: its value and the covariance of its errors.
#[derive(Debug, Clone)]
pub(super) struct Total {
    values: Vec<f64>,
    /// Of each pair (i, j ≤ i), row by row.
    covariances: Vec<f64>,
}

impl Total {
    pub(super) fn new(length: usize) -> Self {
        Self { values: vec![0.0; length], covariances: vec![0.0; length * (length + 1) / 2] }
    }

    /// Adds the sum of independent vectors.
    pub(super) fn add_sum(&mut self, vectors: &Moments) {
        if vectors.count > 0.0 {
            self.values.iter_mut().zip(&vectors.sums).for_each(|(value, sum)| *value += sum);
            self.covariances.iter_mut().zip(vectors.covariances()).for_each(|(own, c)| *own += vectors.count * c);
        }
    }

    /// Adds the mean of independent vectors.
    pub(super) fn add_mean(&mut self, vectors: &Moments) {
        let count = vectors.count;
        self.values.iter_mut().zip(&vectors.sums).for_each(|(value, sum)| *value += sum / count);
        self.covariances.iter_mut().zip(vectors.covariances()).for_each(|(own, c)| *own += c / count);
    }

    pub(super) fn value(&self, i: usize) -> f64 {
        self.values[i]
    }

    pub(super) fn standard_error(&self, i: usize) -> f64 {
        self.covariances[i * (i + 1) / 2 + i].max(0.0).sqrt()
    }

    /// The band of the first of them, at `values`.
    pub(super) fn band(&self, values: &[f64], degrees_of_freedom: Option<usize>, seed: u64) -> Band {
        let n = values.len();
        let pair = |i: usize, j: usize| self.covariances[i.max(j) * (i.max(j) + 1) / 2 + i.min(j)];
        let covariance: Vec<f64> = (0..n * n).map(|k| pair(k / n, k % n)).collect();
        Band::new(values, &self.values[..n], &covariance, degrees_of_freedom, seed)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::law::standard_normal_quantile;

    #[test]
    fn critical_values_of_equal_and_of_independent_errors_are_known() {
        let equal = Band::new(&[0.0, 1.0], &[0.2, 0.5], &[4.0, 4.0, 4.0, 4.0], None, 1);
        assert_eq!(equal.standard_errors, [2.0, 2.0]);
        // The 95 % point of 4,000 draws has a relative standard error of 1.5 %.
        assert!((equal.simultaneous_factor / NORMAL_95 - 1.0).abs() < 0.06, "{}", equal.simultaneous_factor);
        let n = 20;
        let identity: Vec<f64> = (0..n * n).map(|k| if k / n == k % n { 1.0 } else { 0.0 }).collect();
        let values: Vec<f64> = (0..n).map(|i| i as f64).collect();
        let independent = Band::new(&values, &vec![0.5; n], &identity, None, 1);
        let wanted = standard_normal_quantile(0.5 + 0.5 * 0.95_f64.powf(1.0 / n as f64));
        assert!((independent.simultaneous_factor / wanted - 1.0).abs() < 0.04, "{}", independent.simultaneous_factor);
    }

    #[test]
    fn a_band_of_many_values_of_independent_samples_has_kolmogorovs_width() {
        // In the middle; towards the ends it is narrower, by design.
        let n = 199;
        let cdf: Vec<f64> = (1..=n).map(|i| f64::from(i) / f64::from(n + 1)).collect();
        let band = Band::of_independent(&cdf, &cdf, 100, 1);
        assert!((band.standard_errors[99] - 0.05).abs() < 1e-12);
        assert!(band.simultaneous_factor > 2.7 && band.simultaneous_factor < 3.3, "{}", band.simultaneous_factor);
        assert!((band.standard_error_at(0.5) - 0.05).abs() < 1e-12);
    }

    #[test]
    fn sums_and_means_of_vectors_have_their_covariances() {
        let mut vectors = Moments::new(2);
        for v in [[1.0, 0.0], [3.0, 2.0], [5.0, 1.0]] {
            vectors.add(&v);
        }
        // Variances 4 and 1, covariance 1.
        let mut total = Total::new(2);
        total.add_sum(&vectors);
        total.add_mean(&vectors);
        assert_eq!((total.value(0), total.value(1)), (12.0, 4.0));
        assert!((total.standard_error(0) - (4.0_f64 * 3.0 + 4.0 / 3.0).sqrt()).abs() < 1e-12);
        assert!((total.standard_error(1) - (3.0_f64 + 1.0 / 3.0).sqrt()).abs() < 1e-12);
        let band = total.band(&[0.0], None, 1);
        assert_eq!((band.cdf[0], band.standard_errors[0]), (12.0, total.standard_error(0)));
    }
}
