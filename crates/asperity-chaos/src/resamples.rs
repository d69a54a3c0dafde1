//! How often samples are drawn again for a bootstrap.

use rand::RngExt;
use thiserror::Error;

use asperity_base::random::stream;
use asperity_base::stats::{Interval, Moments, quantile_sorted};

/// Fewest resamples from which an interval is read.
const LEAST_COUNT: usize = 20;

/// A setting of a bootstrap is out of range.
#[derive(Debug, Clone, PartialEq, Error)]
pub enum ResamplesError {
    /// There are too few resamples.
    #[error("{count} resamples; at least {LEAST_COUNT} are needed")]
    Count {
        /// Resamples asked for.
        count: usize,
    },
    /// The level is no probability.
    #[error("the confidence level is {level}; it must lie between 0 and 1")]
    Level {
        /// The level.
        level: f64,
    },
    /// A sample is too small.
    #[error("a sample of {samples}; a bootstrap needs at least 2")]
    Samples {
        /// Its size.
        samples: usize,
    },
}

/// A bootstrap of independent samples: each is drawn again with replacement, as large as it is.
///
/// # References
/// Efron & Tibshirani, *An Introduction to the Bootstrap*, Chapman & Hall 1993.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Resamples {
    /// Number of resamples.
    pub count: usize,
    /// Confidence level of intervals and bands.
    pub level: f64,
    /// Seed; resample `i` uses the stream (seed, "chaos/resamples", i).
    pub seed: u64,
}

/// A value that was computed from samples, and how well it is known.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Estimate {
    /// The value.
    pub value: f64,
    /// Standard deviation over the resamples.
    pub standard_error: f64,
    /// The basic bootstrap interval.
    pub interval: Interval,
}

impl Resamples {
    /// 1,000 resamples, 95 %.
    pub fn new(seed: u64) -> Self {
        Self { count: 1000, level: 0.95, seed }
    }

    pub(super) fn check(&self, sizes: impl IntoIterator<Item = usize>) -> Result<(), ResamplesError> {
        if self.count < LEAST_COUNT {
            return Err(ResamplesError::Count { count: self.count });
        }
        if !(self.level > 0.0 && self.level < 1.0) {
            return Err(ResamplesError::Level { level: self.level });
        }
        sizes.into_iter().find(|size| *size < 2).map_or(Ok(()), |samples| Err(ResamplesError::Samples { samples }))
    }

    /// Positions of resample `index` in samples of the given sizes.
    pub(super) fn positions(&self, index: usize, sizes: &[usize]) -> Vec<Vec<usize>> {
        let mut stream = stream(self.seed, "chaos/resamples", index as u64);
        sizes.iter().map(|&size| (0..size).map(|_| stream.random_range(0..size)).collect()).collect()
    }

    /// What the values on the resamples say of a value in `range`.
    ///
    /// A plug-in value that is convex in the distribution, such as a distance or a sum of squares, is too large, and those of the
    /// resamples are so once more. So the interval is the basic one: 2 value − the quantiles of the resamples, cut off at
    /// the ends of the range.
    pub(super) fn estimate(&self, value: f64, mut replicates: Vec<f64>, range: Interval) -> Estimate {
        let standard_error = Moments::new(&replicates).sample_std();
        replicates.sort_by(f64::total_cmp);
        let tail = 0.5 * (1.0 - self.level);
        let end = |probability| (2.0 * value - quantile_sorted(&replicates, probability)).clamp(range.low, range.high);
        Estimate { value, standard_error, interval: Interval { low: end(1.0 - tail), high: end(tail) } }
    }
}
