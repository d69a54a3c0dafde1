//! Observed responses, and the bootstrap of moments and indices over the choice of points and the noise of the samples.

use thiserror::Error;

use crate::resamples::FITTED_FRACTION;
use crate::{Expansion, RegressionError, Resamples, SampleEstimate};
use asperity_base::blocks;
use asperity_base::stats::{Interval, Moments, NORMAL_95, student_95};

const ANY: Interval = Interval { low: f64::NEG_INFINITY, high: f64::INFINITY };
const POSITIVE: Interval = Interval { low: 0.0, high: f64::INFINITY };
const FRACTION: Interval = Interval { low: 0.0, high: 1.0 };

/// Reason why a response has no Sobol' indices.
#[derive(Debug, Clone, PartialEq, Error)]
pub enum NoIndices {
    /// The response does not vary with the parameters.
    #[error("it does not depend on the parameters")]
    Constant,
    /// No expansion predicts the response better than its mean.
    #[error("no expansion in the parameters predicts it better than its mean: relative leave-one-out error {error:.2}")]
    NothingPredicts {
        /// Smallest relative leave-one-out error.
        error: f64,
    },
    /// The expansion fails on too many resamples.
    #[error("{failed} of {resamples} resamples of the points have no expansion; more points are needed")]
    TooManyFailures {
        /// Number of resamples without an expansion.
        failed: usize,
        /// Total number of resamples.
        resamples: usize,
    },
}

/// Responses observed at the points of a design.
#[derive(Debug, Clone, Copy)]
pub struct Observed<'a> {
    /// Response at each point; NaN marks a missing response.
    pub values: &'a [f64],
    /// For each of the random samples behind the responses, the response at each point without that sample. Empty if
    /// the response has no noise. NaN counts as the response with all samples.
    pub without: &'a [Vec<f64>],
    /// Difference below which responses count as equal.
    pub resolution: f64,
}

impl<'a> Observed<'a> {
    /// Creates an observation without noise.
    pub fn exact(values: &'a [f64]) -> Self {
        Self { values, without: &[], resolution: 0.0 }
    }
}

/// Effect of the noise of a response.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Noise {
    /// Jackknife standard error of the mean over the points. It contains the noise that is common to all points in
    /// full.
    pub standard_error: f64,
    /// Variance over the points that is due to noise, divided by the observed variance: 0 without noise, about 1 if
    /// everything is noise. Noise common to all points does not contribute. 0 for a constant response.
    pub variance_fraction: f64,
}

/// Sobol' indices in the order of the parameters.
///
/// Intervals include the choice of the points, the noise, and the variance that the expansion does not explain (the
/// relative leave-one-out error bounds its effect on an index).
#[derive(Debug, Clone, PartialEq)]
pub struct ParameterIndices {
    /// First-order index: the fraction of the variance that a parameter explains alone.
    pub first_order: Vec<SampleEstimate>,
    /// Total index: the fraction that a parameter explains together with all others.
    pub total: Vec<SampleEstimate>,
}

/// Points with a response, and the influence of each random sample.
pub(super) struct Samples<'a> {
    pub(super) xi_samples: Vec<&'a [f64]>,
    pub(super) values: Vec<f64>,
    /// For each sample r and point k, (R − 1)(mean of y₍₋ᵣ₎ over r − y₍₋ᵣ₎). Counting the sample once more changes y by
    /// 1/R of it.
    influences: Vec<Vec<f64>>,
}

impl<'a> Samples<'a> {
    pub(super) fn new(xi_samples: &[&'a [f64]], observed: &Observed<'_>, kept: &[usize]) -> Self {
        let values: Vec<f64> = kept.iter().map(|&k| observed.values[k]).collect();
        let count = observed.without.len() as f64;
        let replaced = |without: &[f64], k: usize| {
            if without[k].is_finite() { without[k] } else { observed.values[k] }
        };
        let means: Vec<f64> =
            kept.iter().map(|&k| observed.without.iter().map(|w| replaced(w, k)).sum::<f64>() / count).collect();
        let influence = |without: &Vec<f64>| {
            kept.iter().zip(&means).map(|(&k, mean)| (count - 1.0) * (mean - replaced(without, k))).collect()
        };
        let influences = if count < 2.0 { Vec::new() } else { observed.without.iter().map(influence).collect() };
        Self { xi_samples: xi_samples.to_vec(), values, influences }
    }

    pub(super) fn len(&self) -> usize {
        self.values.len()
    }

    /// Estimates the effect of noise on the mean over the points and on their `variance`.
    ///
    /// With the jackknife covariance Σ of the responses, the mean over K points has the variance 1ᵀΣ1/K², and their sample
    /// variance is larger by (tr Σ − 1ᵀΣ1/K)/(K − 1) on average.
    pub(super) fn noise(&self, variance: f64) -> Noise {
        let (samples, points) = (self.influences.len() as f64, self.len() as f64);
        if self.influences.is_empty() {
            return Noise { standard_error: 0.0, variance_fraction: 0.0 };
        }
        let scale = 1.0 / (samples * (samples - 1.0));
        let (mut trace, mut whole) = (0.0, 0.0);
        for influence in &self.influences {
            trace += influence.iter().map(|u| u * u).sum::<f64>();
            whole += influence.iter().sum::<f64>().powi(2);
        }
        let own = (scale * (trace - whole / points) / (points - 1.0)).max(0.0);
        Noise {
            standard_error: (scale * whole).sqrt() / points,
            variance_fraction: if own > 0.0 { own / variance } else { 0.0 },
        }
    }

    /// Returns the points and values of resample `index`.
    fn resample(&self, resamples: &Resamples, index: usize) -> (Vec<usize>, Vec<f64>) {
        let count = self.influences.len();
        if count == 0 {
            let points = resamples.positions(index, &[self.len()]).swap_remove(0);
            let values = points.iter().map(|&k| self.values[k]).collect();
            return (points, values);
        }
        let mut drawn = resamples.positions(index, &[self.len(), count]);
        let (samples, points) = (drawn.swap_remove(1), drawn.swap_remove(0));
        let mut times = vec![-1.0; count];
        samples.iter().for_each(|&r| times[r] += 1.0);
        let n = count as f64;
        // The variance of the bootstrap is too small by (R − 1)/R, and few samples follow Student's distribution.
        let spread = (n / (n - 1.0)).sqrt() * student_95(count) / NORMAL_95 / n;
        let shift = |k: usize| spread * times.iter().zip(&self.influences).map(|(t, u)| t * u[k]).sum::<f64>();
        let values = points.iter().map(|&k| self.values[k] + shift(k)).collect();
        (points, values)
    }

    /// Returns the mean and standard deviation of the points.
    pub(super) fn moments(&self, resamples: &Resamples) -> (SampleEstimate, SampleEstimate) {
        let moments = Moments::new(&self.values);
        let drawn: Vec<Moments> = blocks::map(0..resamples.count, |i| Moments::new(&self.resample(resamples, i).1));
        (
            resamples.estimate(moments.mean, drawn.iter().map(|m| m.mean).collect(), ANY),
            resamples.estimate(moments.sample_std(), drawn.iter().map(Moments::sample_std).collect(), POSITIVE),
        )
    }

    /// Returns the mean, standard deviation and indices of an expansion of relative leave-one-out error `error`.
    pub(super) fn estimates(
        &self,
        expansion: &Expansion,
        error: f64,
        resamples: &Resamples,
    ) -> (SampleEstimate, SampleEstimate, Result<ParameterIndices, NoIndices>) {
        let variables = expansion.basis().set().variables();
        let numbers = |expansion: &Expansion| -> Vec<f64> {
            let mut numbers = vec![expansion.mean(), expansion.variance().sqrt()];
            numbers.extend(expansion.first_order_indices());
            numbers.extend(expansion.total_indices());
            numbers
        };
        let replicate = |index: usize| -> Result<Vec<f64>, RegressionError> {
            let (points, values) = self.resample(resamples, index);
            let xi_samples: Vec<&[f64]> = points.iter().map(|&k| self.xi_samples[k]).collect();
            Expansion::fit(expansion.basis().clone(), &xi_samples, &values).map(|(expansion, _)| numbers(&expansion))
        };
        let found: Vec<Vec<f64>> =
            blocks::map::<_, Vec<_>>(0..resamples.count, replicate).into_iter().flatten().collect();
        let failed = resamples.count - found.len();
        let estimates: Vec<SampleEstimate> = numbers(expansion)
            .into_iter()
            .enumerate()
            .map(|(place, value)| {
                let range = [ANY, POSITIVE].get(place).copied().unwrap_or(FRACTION);
                let list: Vec<f64> = found.iter().map(|n| n[place]).filter(|value| value.is_finite()).collect();
                let estimate = resamples.estimate(value, list, range);
                if place < 2 { estimate } else { widened(estimate, error) }
            })
            .collect();
        let (mean, std) = (estimates[0], estimates[1]);
        if found.len() as f64 <= FITTED_FRACTION * resamples.count as f64 {
            return (mean, std, Err(NoIndices::TooManyFailures { failed, resamples: resamples.count }));
        }
        let (first_order, total) = estimates[2..].split_at(variables);
        (mean, std, Ok(ParameterIndices { first_order: first_order.to_vec(), total: total.to_vec() }))
    }
}

/// Widens an interval by the variance fraction that the terms leave out, which bounds its effect on an index.
fn widened(estimate: SampleEstimate, error: f64) -> SampleEstimate {
    let Interval { low, high } = estimate.interval;
    SampleEstimate { interval: Interval { low: (low - error).max(0.0), high: (high + error).min(1.0) }, ..estimate }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_interval_grows_by_what_the_terms_leave_out_within_zero_and_one() {
        for (before, error, after) in [([0.2, 0.4], 0.1, [0.1, 0.5]), ([0.02, 0.97], 0.05, [0.0, 1.0])] {
            let interval = Interval { low: before[0], high: before[1] };
            let found = widened(SampleEstimate { value: 0.3, standard_error: 0.05, interval }, error);
            assert!((found.interval.low - after[0]).abs() < 1e-15 && (found.interval.high - after[1]).abs() < 1e-15);
            assert_eq!((found.value, found.standard_error), (0.3, 0.05));
        }
    }
}
