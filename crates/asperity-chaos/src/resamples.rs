//! Bootstrap resampling.

use rand::RngExt;
use thiserror::Error;

use asperity_base::random::stream;
use asperity_base::stats::{Interval, Moments, quantile_sorted};

/// Minimum number of resamples for an interval.
const LEAST_COUNT: usize = 20;
/// Smallest fraction of resamples that must have an expansion.
pub(super) const FITTED_FRACTION: f64 = 0.95;

/// Reason why a bootstrap cannot be run.
#[derive(Debug, Clone, PartialEq, Error)]
#[non_exhaustive]
pub enum ResamplesError {
    /// There are too few resamples.
    #[error("{count} resamples; at least {LEAST_COUNT} are needed")]
    Count {
        /// Resamples asked for.
        count: usize,
    },
    /// The confidence level is outside (0, 1).
    #[error("the confidence level is {level}; it must lie between 0 and 1")]
    Level {
        /// The level.
        level: f64,
    },
    /// A sample is too small.
    #[error("a sample of {samples}; a bootstrap needs at least 2")]
    Samples {
        /// Size of the sample.
        samples: usize,
    },
}

/// Bootstrap of independent samples: each is resampled with replacement to its own size.
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

/// Value computed from samples, with its uncertainty.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SampleEstimate {
    /// The value.
    pub value: f64,
    /// Standard error: the standard deviation over resamples, or that of a jackknife.
    pub standard_error: f64,
    /// Confidence interval: the basic bootstrap interval, or Student's interval of a jackknife.
    pub interval: Interval,
}

impl Resamples {
    /// Creates the settings for 1,000 resamples and 95 % confidence.
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

    /// Returns the positions of resample `index` in samples of the given sizes.
    pub(super) fn positions(&self, index: usize, sizes: &[usize]) -> Vec<Vec<usize>> {
        let mut stream = stream(self.seed, "chaos/resamples", index as u64);
        sizes.iter().map(|&size| (0..size).map(|_| stream.random_range(0..size)).collect()).collect()
    }

    /// Combines a value in `range` with its replicates on the resamples.
    ///
    /// A plug-in value that is convex in the distribution, such as a distance or a sum of squares, is biased upwards,
    /// and its replicates are biased twice. The interval is therefore the basic one, 2 value − quantiles of the
    /// replicates, clipped to the range.
    pub(super) fn estimate(&self, value: f64, mut replicates: Vec<f64>, range: Interval) -> SampleEstimate {
        let standard_error = Moments::new(&replicates).sample_std();
        replicates.sort_by(f64::total_cmp);
        let tail = 0.5 * (1.0 - self.level);
        let end = |probability| (2.0 * value - quantile_sorted(&replicates, probability)).clamp(range.low, range.high);
        SampleEstimate { value, standard_error, interval: Interval { low: end(1.0 - tail), high: end(tail) } }
    }
}
