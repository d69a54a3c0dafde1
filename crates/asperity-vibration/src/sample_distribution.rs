//! Distribution of a quantity over many trajectories, collected in bounded memory.

use std::collections::BinaryHeap;

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use asperity_base::distribution::goodness::normality;
use asperity_base::random::hash;

/// Distribution of a quantity that occurs many times along many trajectories, such as the displacement at
/// re-attachment.
///
/// Values of one trajectory are correlated when a slip is not much longer than the correlation length. `normality_p`
/// assumes independent values, so it is a lower bound of the p-value.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct SampleDistribution {
    /// Number of values; the moments use all of them.
    pub count: u64,
    /// Mean.
    #[schemars(with = "Option<f64>")]
    pub mean: f64,
    /// Standard deviation.
    #[schemars(with = "Option<f64>")]
    pub std: f64,
    /// Skewness.
    #[schemars(with = "Option<f64>")]
    pub skewness: f64,
    /// Excess kurtosis.
    #[schemars(with = "Option<f64>")]
    pub excess_kurtosis: f64,
    /// p-value of D'Agostino and Pearson's test of normality on `sample`; none for fewer than 20 values.
    pub normality_p: Option<f64>,
    /// All values in order of trajectory and time if they are few enough; otherwise a simple random sample of them in
    /// the same order.
    #[schemars(extend("x-array" = true))]
    pub sample: Vec<f64>,
}

/// Count, mean and central sums of powers, updated value by value.
#[derive(Debug, Clone, Copy, PartialEq, Default, Serialize, Deserialize)]
pub(super) struct RunningMoments {
    count: u64,
    mean: f64,
    /// Σ(x − mean)², Σ(x − mean)³, Σ(x − mean)⁴.
    central: [f64; 3],
}

impl RunningMoments {
    pub(super) const EMPTY: Self = Self { count: 0, mean: 0.0, central: [0.0; 3] };

    /// Adds one value.
    ///
    /// # References
    /// Pébay, *Formulas for robust, one-pass parallel computation of covariances and arbitrary-order statistical moments*,
    /// Sandia Report SAND2008-6212 (2008).
    pub(super) fn add(&mut self, value: f64) {
        let before = self.count as f64;
        self.count += 1;
        let n = self.count as f64;
        let delta = value - self.mean;
        let fraction = delta / n;
        let second = delta * fraction * before;
        let [m2, m3, m4] = self.central;
        self.mean += fraction;
        self.central = [
            m2 + second,
            m3 + second * fraction * (n - 2.0) - 3.0 * fraction * m2,
            m4 + second * fraction * fraction * (n * n - 3.0 * n + 3.0) + 6.0 * fraction * fraction * m2
                - 4.0 * fraction * m3,
        ];
    }

    /// Adds all values of another sum, by the formulas for two sets in the reference of [`Self::add`].
    pub(super) fn merge(&mut self, other: &Self) {
        if self.count == 0 || other.count == 0 {
            *self = if self.count == 0 { *other } else { *self };
            return;
        }
        let (a, b) = (self.count as f64, other.count as f64);
        let n = a + b;
        let delta = other.mean - self.mean;
        let fraction = delta / n;
        let [[a2, a3, a4], [b2, b3, b4]] = [self.central, other.central];
        let product = delta * fraction * a * b;
        self.central = [
            a2 + b2 + product,
            a3 + b3 + product * fraction * (a - b) + 3.0 * fraction * (a * b2 - b * a2),
            a4 + b4
                + product * fraction * fraction * (a * a - a * b + b * b)
                + 6.0 * fraction * fraction * (a * a * b2 + b * b * a2)
                + 4.0 * fraction * (a * b3 - b * a3),
        ];
        self.mean += fraction * b;
        self.count += other.count;
    }

    pub(super) fn count(&self) -> u64 {
        self.count
    }

    pub(super) fn mean(&self) -> f64 {
        if self.count == 0 { f64::NAN } else { self.mean }
    }

    /// Returns the standard deviation with divisor n − 1.
    pub(super) fn std(&self) -> f64 {
        if self.count < 2 { f64::NAN } else { (self.central[0] / (self.count as f64 - 1.0)).sqrt() }
    }

    fn skewness(&self) -> f64 {
        (self.count as f64).sqrt() * self.central[1] / self.central[0].powf(1.5)
    }

    fn excess_kurtosis(&self) -> f64 {
        self.count as f64 * self.central[2] / self.central[0].powi(2) - 3.0
    }
}

/// Simple random sample of a stream of numbered values: the values with the smallest hashes of their numbers.
///
/// The choice is a function of the numbers alone, so it does not depend on threads or on the order of arrival.
#[derive(Debug, Clone, Serialize, Deserialize)]
struct Reservoir {
    capacity: usize,
    /// Heap of (hash, number, bits of the value), with the largest hash on top.
    kept: BinaryHeap<(u64, u64, u64)>,
}

impl Reservoir {
    fn add(&mut self, number: u64, value: f64) {
        self.take((hash(number, 0), number, value.to_bits()));
    }

    fn take(&mut self, (hash, number, bits): (u64, u64, u64)) {
        if self.kept.len() == self.capacity {
            if self.kept.peek().is_none_or(|(largest, ..)| hash >= *largest) {
                return;
            }
            self.kept.pop();
        }
        self.kept.push((hash, number, bits));
    }

    /// Returns the kept values in the order of their numbers.
    fn values(self) -> Vec<f64> {
        let mut kept = self.kept.into_vec();
        kept.sort_unstable_by_key(|&(_, number, _)| number);
        kept.into_iter().map(|(_, _, bits)| f64::from_bits(bits)).collect()
    }
}

/// Collector of a [`SampleDistribution`], from the values of one trajectory or by merging collectors.
#[derive(Debug, Clone, Serialize, Deserialize)]
pub(super) struct SampleCollector {
    sums: RunningMoments,
    reservoir: Reservoir,
    /// Number of the first value, unique to the trajectory.
    first: u64,
}

impl SampleCollector {
    pub(super) fn new(trajectory: u64, capacity: usize) -> Self {
        let reservoir = Reservoir { capacity, kept: BinaryHeap::new() };
        Self { sums: RunningMoments::EMPTY, reservoir, first: trajectory << 32 }
    }

    pub(super) fn add(&mut self, x: f64) {
        self.reservoir.add(self.first + self.sums.count(), x);
        self.sums.add(x);
    }

    pub(super) fn merge(&mut self, other: Self) {
        self.sums.merge(&other.sums);
        other.reservoir.kept.into_iter().for_each(|kept| self.reservoir.take(kept));
    }

    #[cfg(test)]
    pub(super) fn values(self) -> Vec<f64> {
        self.reservoir.values()
    }

    pub(super) fn finish(self) -> SampleDistribution {
        let sample = self.reservoir.values();
        let sums = self.sums;
        SampleDistribution {
            count: sums.count(),
            mean: sums.mean(),
            std: sums.std(),
            skewness: sums.skewness(),
            excess_kurtosis: sums.excess_kurtosis(),
            normality_p: normality(&sample).ok().map(|test| test.p_value),
            sample,
        }
    }
}

/// Mean, standard deviation and standard error of a number over trajectories.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct Count {
    /// Mean.
    pub mean: f64,
    /// Standard deviation over trajectories, divisor n − 1.
    pub std: f64,
    /// Standard error of the mean.
    pub se: f64,
}

impl Count {
    pub(super) fn from_moments(sums: &RunningMoments) -> Self {
        Self { mean: sums.mean(), std: sums.std(), se: sums.std() / (sums.count() as f64).sqrt() }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use asperity_base::random;
    use asperity_base::stats::Moments;

    #[test]
    fn streamed_moments_match_the_sample() {
        let values: Vec<f64> = random::standard_normal(&mut random::stream(1, "test", 0), 5000)
            .iter()
            .map(|xi| 1e3 + 1e-2 * (0.5 * xi).exp())
            .collect();
        let mut collector = SampleCollector::new(0, 10_000);
        values.iter().for_each(|x| collector.add(*x));
        let (found, wanted) = (collector.finish(), Moments::new(&values));
        assert_eq!(found.sample, values);
        assert!((found.mean - wanted.mean).abs() < 1e-12 * wanted.mean);
        // Deviations of 1e-2 about 1e3 keep eleven digits.
        assert!((found.std / wanted.sample_std() - 1.0).abs() < 1e-9);
        assert!((found.skewness / wanted.skewness - 1.0).abs() < 1e-8);
        assert!((found.excess_kurtosis / wanted.excess_kurtosis - 1.0).abs() < 1e-8);
        assert!(found.normality_p.unwrap() < 1e-10);
    }

    #[test]
    fn merged_collectors_match_the_collector_of_all_values() {
        let values: Vec<f64> = random::standard_normal(&mut random::stream(2, "test", 0), 6000)
            .iter()
            .map(|xi| 5.0 + (0.4 * xi).exp())
            .collect();
        let collected = |capacity: usize, order: &[usize]| {
            let parts = [0..0, 0..1, 1..700, 700..701, 701..6000];
            let mut whole = SampleCollector::new(0, capacity);
            for &i in order {
                let mut part = SampleCollector::new(i as u64, capacity);
                values[parts[i].clone()].iter().for_each(|x| part.add(*x));
                whole.merge(part);
            }
            whole.finish()
        };
        let (all, wanted) = (collected(10_000, &[0, 1, 2, 3, 4]), Moments::new(&values));
        assert_eq!((all.count, &all.sample), (6000, &values));
        for (found, wanted) in [
            (all.mean, wanted.mean),
            (all.std, wanted.sample_std()),
            (all.skewness, wanted.skewness),
            (all.excess_kurtosis, wanted.excess_kurtosis),
        ] {
            assert!((found / wanted - 1.0).abs() < 1e-11, "{found} and {wanted}");
        }
        // The kept sample depends neither on the order nor on the number of extra values kept in a part.
        let few = collected(500, &[0, 1, 2, 3, 4]);
        assert_eq!(few.sample.len(), 500);
        assert_eq!(few.sample, collected(500, &[4, 2, 0, 3, 1]).sample);
        assert!(few.sample.iter().all(|x| values.contains(x)));
    }

    #[test]
    fn a_full_reservoir_is_a_fair_sample_of_all() {
        let mut collector = SampleCollector::new(0, 2000);
        (0..100_000).for_each(|i| collector.add(f64::from(i)));
        let found = collector.finish();
        assert_eq!((found.count, found.sample.len()), (100_000, 2000));
        assert!(found.sample.is_sorted());
        let mean = found.sample.iter().sum::<f64>() / 2000.0;
        let standard_error = 1e5 / 12.0_f64.sqrt() / 2000.0_f64.sqrt();
        assert!((mean - 5e4).abs() < 4.0 * standard_error, "mean {mean}");
    }
}
