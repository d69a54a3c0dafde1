//! Estimates and upper bounds of small probabilities.

use asperity_base::stats::Interval;

/// Probability of failure.
#[derive(Debug, Clone, PartialEq)]
pub enum SmallProbability {
    /// Failures occurred.
    Estimate(RareProbability),
    /// No failure occurred.
    Bound(UpperBound),
}

/// Estimate of a probability of failure.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct RareProbability {
    /// Probability of failure.
    pub probability: f64,
    /// 95 % confidence interval; both limits are positive.
    pub interval: Interval,
    /// Estimated standard deviation of the probability, divided by the probability. It exceeds the requested one if the
    /// evaluations were used up.
    pub coefficient_of_variation: f64,
    /// Number of evaluations of the limit state.
    pub evaluations: usize,
    /// Method of the estimate.
    pub method: RareMethod,
}

/// Method of an estimate.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum RareMethod {
    /// Importance sampling with an interpolant of the limit state; subset simulation on the interpolant or on the limit state
    /// located the regions of failure.
    ImportanceSampling,
    /// Mean of independent replicates of subset simulation on the limit state.
    SubsetSimulation,
}

/// Upper bound of a probability of failure.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct UpperBound {
    /// Probability that is exceeded with a confidence of 5 % at most.
    pub probability: f64,
    /// Reason why there is no estimate.
    pub reason: NoFailure,
    /// Number of evaluations of the limit state.
    pub evaluations: usize,
}

/// Reason why no failure occurred.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum NoFailure {
    /// The limit state is constant over nearly all samples of a level, so it does not lead to failures.
    Constant,
    /// The evaluations were used up, or the probability is below 10⁻¹³.
    Exhausted,
}
