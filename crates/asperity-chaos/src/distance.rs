//! Discrete distributions with point masses, and distances between distributions.

use thiserror::Error;

/// Reason why a distribution could not be created.
#[derive(Debug, Clone, PartialEq, Error)]
#[non_exhaustive]
pub enum DiscreteDistributionError {
    /// There are no values.
    #[error("a distribution needs at least one value")]
    Empty,
    /// A value is not finite, or a weight is negative or not finite.
    #[error("value {index} is {value} with weight {weight}; values must be finite and weights at least 0")]
    Value {
        /// Position of the value.
        index: usize,
        /// The value.
        value: f64,
        /// Its weight.
        weight: f64,
    },
    /// All weights are zero.
    #[error("all {values} weights are zero")]
    NoWeight {
        /// Number of values.
        values: usize,
    },
}

/// Distribution on finitely many values. Its distribution function is a step function, continuous from the right.
#[derive(Debug, Clone, PartialEq)]
pub struct DiscreteDistribution {
    /// Distinct values, increasing.
    values: Vec<f64>,
    /// F at each value; the last is 1.
    cumulative: Vec<f64>,
}

impl DiscreteDistribution {
    /// Creates the empirical distribution of a sample.
    ///
    /// # Errors
    /// The sample is empty, or a value is not finite.
    pub fn empirical(sample: &[f64]) -> Result<Self, DiscreteDistributionError> {
        Self::weighted(sample.iter().map(|&value| (value, 1.0)))
    }

    /// Creates the distribution whose probabilities are proportional to the weights of (value, weight) pairs.
    ///
    /// # Errors
    /// There are no values, a value is not finite, a weight is negative, or no weight is positive.
    pub fn weighted(points: impl IntoIterator<Item = (f64, f64)>) -> Result<Self, DiscreteDistributionError> {
        let mut points: Vec<(f64, f64)> = points.into_iter().collect();
        if points.is_empty() {
            return Err(DiscreteDistributionError::Empty);
        }
        if let Some(index) = points.iter().position(|(x, w)| !(x.is_finite() && w.is_finite() && *w >= 0.0)) {
            let (value, weight) = points[index];
            return Err(DiscreteDistributionError::Value { index, value, weight });
        }
        let count = points.len();
        points.retain(|&(_, weight)| weight > 0.0);
        // −0 and 0 are one value.
        points.iter_mut().for_each(|(value, _)| *value += 0.0);
        points.sort_by(|a, b| a.0.total_cmp(&b.0));
        let total: f64 = points.iter().map(|&(_, weight)| weight).sum();
        if points.is_empty() {
            return Err(DiscreteDistributionError::NoWeight { values: count });
        }
        let mut values: Vec<f64> = Vec::with_capacity(points.len());
        let mut cumulative: Vec<f64> = Vec::with_capacity(points.len());
        let mut sum = 0.0;
        for (value, weight) in points {
            sum += weight;
            if values.last() == Some(&value) {
                cumulative.pop();
            } else {
                values.push(value);
            }
            cumulative.push(sum / total);
        }
        if let Some(last) = cumulative.last_mut() {
            *last = 1.0;
        }
        Ok(Self { values, cumulative })
    }

    /// Returns the distinct values in increasing order.
    pub fn values(&self) -> &[f64] {
        &self.values
    }

    /// Returns the distribution function at each of [`DiscreteDistribution::values`].
    pub fn cumulative(&self) -> &[f64] {
        &self.cumulative
    }

    /// Returns F(x) = P(X ≤ x).
    pub fn cdf(&self, x: f64) -> f64 {
        self.after(self.values.partition_point(|&v| v <= x))
    }

    /// Returns P(X < x).
    pub fn cdf_left(&self, x: f64) -> f64 {
        self.after(self.values.partition_point(|&v| v < x))
    }

    fn after(&self, count: usize) -> f64 {
        if count == 0 { 0.0 } else { self.cumulative[count - 1] }
    }

    /// Returns the smallest value x with F(x) ≥ probability.
    pub fn quantile(&self, probability: f64) -> f64 {
        let position = self.cumulative.partition_point(|&f| f < probability);
        self.values[position.min(self.values.len() - 1)]
    }

    /// Returns (value, probability) of each point mass.
    pub fn point_masses(&self) -> impl Iterator<Item = (f64, f64)> + '_ {
        self.values.iter().enumerate().map(|(i, &value)| (value, self.cumulative[i] - self.after(i)))
    }

    /// Returns the mean.
    pub fn mean(&self) -> f64 {
        self.point_masses().map(|(value, probability)| value * probability).sum()
    }

    /// Returns the standard deviation of the distribution (divisor n, not n − 1).
    pub fn std(&self) -> f64 {
        let mean = self.mean();
        self.point_masses().map(|(value, probability)| probability * (value - mean).powi(2)).sum::<f64>().sqrt()
    }
}

/// Returns the Kolmogorov–Smirnov distance sup_x |F(x) − G(x)| of two distributions, exact also for point masses.
pub fn kolmogorov_smirnov(first: &DiscreteDistribution, second: &DiscreteDistribution) -> f64 {
    differences(first, second).map(|(_, difference)| difference).fold(0.0, f64::max)
}

/// Returns the Wasserstein-1 distance ∫|F(x) − G(x)| dx of two distributions, exact, in the unit of the values.
pub fn wasserstein_1(first: &DiscreteDistribution, second: &DiscreteDistribution) -> f64 {
    let mut sum = 0.0;
    let mut left: Option<(f64, f64)> = None;
    for (x, difference) in differences(first, second) {
        if let Some((from, height)) = left {
            sum += height * (x - from);
        }
        left = Some((x, difference));
    }
    sum
}

/// Returns (x, |F(x) − G(x)|) at every value of either distribution, increasing.
fn differences<'a>(
    first: &'a DiscreteDistribution,
    second: &'a DiscreteDistribution,
) -> impl Iterator<Item = (f64, f64)> + 'a {
    let (mut i, mut j) = (0, 0);
    std::iter::from_fn(move || {
        let x = match (first.values.get(i), second.values.get(j)) {
            (Some(&a), Some(&b)) => a.min(b),
            (Some(&a), None) => a,
            (None, Some(&b)) => b,
            (None, None) => return None,
        };
        i += usize::from(first.values.get(i) == Some(&x));
        j += usize::from(second.values.get(j) == Some(&x));
        Some((x, (first.after(i) - second.after(j)).abs()))
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use asperity_base::random::{standard_normal, stream};

    fn distribution(sample: &[f64]) -> DiscreteDistribution {
        DiscreteDistribution::empirical(sample).unwrap()
    }

    #[test]
    fn tied_values_make_one_point_mass() {
        let distribution = distribution(&[0.0, 2.0, -0.0, 1.0]);
        assert_eq!(distribution.values(), [0.0, 1.0, 2.0]);
        assert_eq!(distribution.cumulative(), [0.5, 0.75, 1.0]);
        assert_eq!(
            (distribution.cdf_left(0.0), distribution.cdf(0.0), distribution.cdf(0.5), distribution.cdf(9.0)),
            (0.0, 0.5, 0.5, 1.0)
        );
        assert_eq!(
            (distribution.quantile(0.5), distribution.quantile(0.6), distribution.quantile(1.0)),
            (0.0, 1.0, 2.0)
        );
        assert!((distribution.mean() - 0.75).abs() < 1e-15);
        assert!((distribution.std() - (0.6875_f64).sqrt()).abs() < 1e-15);
    }

    #[test]
    fn distances_of_point_masses_are_one_and_their_separation() {
        let (a, b) = (distribution(&[1.0]), distribution(&[4.5]));
        assert_eq!(kolmogorov_smirnov(&a, &b), 1.0);
        assert_eq!(wasserstein_1(&a, &b), 3.5);
        assert_eq!((kolmogorov_smirnov(&a, &a), wasserstein_1(&a, &a)), (0.0, 0.0));
    }

    #[test]
    fn the_distance_of_distributions_that_differ_in_a_point_mass_is_its_difference() {
        let two_points = |zero: f64| DiscreteDistribution::weighted([(0.0, zero), (1.0, 1.0 - zero)]).unwrap();
        assert!((kolmogorov_smirnov(&two_points(0.3), &two_points(0.7)) - 0.4).abs() < 1e-15);
        assert!((wasserstein_1(&two_points(0.3), &two_points(0.7)) - 0.4).abs() < 1e-15);
    }

    #[test]
    fn wasserstein_of_equally_large_samples_is_the_mean_distance_of_order_statistics() {
        let mut a = standard_normal(&mut stream(1, "a", 0), 300);
        let mut b = standard_normal(&mut stream(1, "b", 0), 300);
        let distance = wasserstein_1(&distribution(&a), &distribution(&b));
        a.sort_by(f64::total_cmp);
        b.sort_by(f64::total_cmp);
        let oracle = a.iter().zip(&b).map(|(x, y)| (x - y).abs()).sum::<f64>() / 300.0;
        assert!((distance - oracle).abs() < 1e-13);
    }

    #[test]
    fn the_supremum_is_found_among_all_values_and_left_limits() {
        let sample: Vec<f64> = standard_normal(&mut stream(2, "a", 0), 50).iter().map(|x| x.max(-0.3)).collect();
        let other: Vec<f64> = standard_normal(&mut stream(2, "b", 0), 70).iter().map(|x| x.max(0.1)).collect();
        let (a, b) = (distribution(&sample), distribution(&other));
        let brute = sample.iter().chain(&other).map(|&x| (a.cdf(x) - b.cdf(x)).abs()).fold(0.0, f64::max);
        assert_eq!(kolmogorov_smirnov(&a, &b), brute);
    }

    #[test]
    fn empty_distributions_are_rejected() {
        assert_eq!(DiscreteDistribution::empirical(&[]), Err(DiscreteDistributionError::Empty));
        assert!(matches!(
            DiscreteDistribution::empirical(&[1.0, f64::NAN]),
            Err(DiscreteDistributionError::Value { index: 1, .. })
        ));
        assert_eq!(
            DiscreteDistribution::weighted([(1.0, 0.0)]),
            Err(DiscreteDistributionError::NoWeight { values: 1 })
        );
        assert!(matches!(DiscreteDistribution::weighted([(1.0, -1.0)]), Err(DiscreteDistributionError::Value { .. })));
    }
}
