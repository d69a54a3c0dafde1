//! Points of machines in several independent randomisations, and means over them.
//!
//! The points of one scrambled Sobol' sequence depend on each other, so their standard deviation does not estimate the error of their mean.
//! Means of independently scrambled sequences are independent and have the same distribution; Student's t gives an interval of their mean.
//!
//! # References
//! Owen, *J. Complexity* **14** (1998) 466, <https://doi.org/10.1006/jcom.1998.0487>.

use crate::chaos::{Design, SamplingError, SamplingMethod};
use crate::stats::{Interval, Moments, student_95};

/// Randomisations of the Sobol' points.
pub(super) const REPLICATES: usize = 8;
/// Standard deviation of a count that lies between two whole numbers, at most.
const ROUNDING: f64 = 0.5;
/// Stream of the points of remedies and maps.
const STREAM: &str = "study/verdict/remedies";

/// Returns the standard normal variables of all replicates with `count` points each.
pub(super) fn points(variables: usize, count: usize, seed: u64) -> Result<Vec<Vec<f64>>, SamplingError> {
    if variables == 0 {
        return Ok(vec![Vec::new()]);
    }
    let designs = designs(variables, count, seed, STREAM)?;
    Ok(designs.iter().flat_map(|design| (0..count).map(|index| design.xi(index))).collect())
}

/// Returns the independent randomisations of `count` Sobol' points.
pub(super) fn designs(variables: usize, count: usize, seed: u64, stream: &str) -> Result<Vec<Design>, SamplingError> {
    let design = Design::new(SamplingMethod::Sobol, seed, stream, count, variables)?;
    (0..REPLICATES).map(|replicate| design.replicate(replicate)).collect()
}

/// Returns the half width of the 95 % interval of the mean of all replicates, given the mean of each and the standard deviation of a mean
/// due to rounding.
pub(super) fn half_width(means: &[f64], rounding: f64) -> f64 {
    let std = Moments::new(means).sample_std().hypot(rounding);
    student_95(means.len()) * std / (means.len() as f64).sqrt()
}

/// Mean of a value between 0 and 1 over machines, with half the width of its 95 % interval.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Mean {
    pub(super) value: f64,
    pub(super) half_width: f64,
}

impl Mean {
    /// Returns the mean of values of machines, given with the index of each machine: its remainder is the number of the replicate.
    ///
    /// Equal counts of all replicates do not prove that the probability is their fraction: it may lie between two counts. The half width
    /// contains this error of rounding.
    pub(super) fn new(values: impl Iterator<Item = (usize, f64)>) -> Self {
        let mut sums = [(0.0, 0.0); REPLICATES];
        for (index, value) in values {
            let (sum, count) = &mut sums[index % REPLICATES];
            *sum += value;
            *count += 1.0;
        }
        let (sum, count) = sums.iter().fold((0.0, 0.0), |a, b| (a.0 + b.0, a.1 + b.1));
        let means = sums.map(|(sum, count)| sum / count);
        let rounding = ROUNDING * REPLICATES as f64 / count;
        let half_width = if means.iter().all(|mean| mean.is_finite()) { half_width(&means, rounding) } else { 1.0 };
        Self { value: sum / count, half_width }
    }

    /// Returns the 95 % interval.
    pub(super) fn interval(self) -> Interval {
        Interval { low: (self.value - self.half_width).max(0.0), high: (self.value + self.half_width).min(1.0) }
    }
}

/// Returns the fraction of machines without an answer, whose margin is −∞.
pub(super) fn fraction_unanswered(margins: &[f64]) -> f64 {
    margins.iter().filter(|margin| **margin == f64::NEG_INFINITY).count() as f64 / margins.len() as f64
}

/// Returns the fraction of negative margins.
pub(super) fn fraction_below_zero(margins: &[f64]) -> f64 {
    margins.iter().filter(|margin| **margin < 0.0).count() as f64 / margins.len() as f64
}
