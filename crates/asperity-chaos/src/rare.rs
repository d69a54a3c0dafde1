//! Small probabilities.
//!
//! [`small_probability`] estimates P[g(z) < 0] for independent standard normal variables z, from 0.1 down to about 10⁻⁸, by subset
//! simulation [1, 2]. It needs no derivatives of g, and g may have kinks, flat parts and several regions of failure. The mean of
//! independent replicates is the estimate, and their scatter gives its interval. A region of failure that no sample reaches is missing
//! from the probability and from its interval.
//!
//! ```
//! use asperity_base::monitor::Silent;
//! use asperity_chaos::rare::{Settings, small_probability};
//!
//! // P[z₁ + z₂ > 4.5·√2] = Φ(−4.5) = 3.4e-6
//! let g = |z: &[f64]| Ok::<f64, ()>(4.5 * 2.0_f64.sqrt() - z[0] - z[1]);
//! let found = small_probability(2, &g, &Settings::new(1), &Silent)?;
//! assert!(found.interval.contains(3.398e-6));
//! # Ok::<(), asperity_chaos::rare::RareError<()>>(())
//! ```
//!
//! # References
//! 1. Au & Beck, *Prob. Eng. Mech.* **16** (2001) 263, <https://doi.org/10.1016/S0266-8920(01)00019-4>.
//! 2. Papaioannou, Betz, Zwirglmaier & Straub, *Prob. Eng. Mech.* **41** (2015) 89,
//!    <https://doi.org/10.1016/j.probengmech.2015.06.006>.

mod chains;
mod error;
#[cfg(test)]
mod tests;

use asperity_base::blocks::Task;
use asperity_base::monitor::Monitor;
use asperity_base::random::stream;
use asperity_base::stats::{Interval, Moments, student_95};

use chains::{Descent, THINNED, descend};
pub use error::RareError;

/// Smallest number of replicates. Stopping earlier, where their scatter is small by chance, would favour small probabilities.
const LEAST_REPLICATES: usize = 20;
/// Replicates whose samples give the probability of another limit state.
const KEPT: usize = 12;
/// Fraction of the samples of a set that fail, above which the set may not contain all failures of another limit state.
const MOST_FAILURES: f64 = 0.5;

/// Limit state g, whose error is E.
pub type LimitState<'a, E> = dyn Fn(&[f64]) -> Result<f64, E> + Sync + 'a;

/// Settings of [`small_probability`].
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Settings {
    /// Coefficient of variation of the probability at which sampling ends.
    pub coefficient_of_variation: f64,
    /// Number of evaluations after which no further replicate begins.
    pub most_evaluations: usize,
    /// Seed of all draws.
    pub seed: u64,
}

impl Settings {
    /// Returns a coefficient of variation of 0.07 and 80,000 evaluations.
    pub fn new(seed: u64) -> Self {
        Self { coefficient_of_variation: 0.07, most_evaluations: 80_000, seed }
    }
}

/// Probability of failure.
#[derive(Debug, Clone, PartialEq)]
pub struct SmallProbability {
    /// Probability of failure; 0 if no failure occurred down to a probability of 10⁻⁸, or if g is constant.
    pub probability: f64,
    /// 95 % confidence interval. Without failures it begins at 0.
    pub interval: Interval,
    /// Number of evaluations of the limit state.
    pub evaluations: usize,
    replicates: Vec<Descent>,
}

/// Estimates P[g(z) < 0] for `variables` independent standard normal variables z.
///
/// The interval is P exp(±t c) with the coefficient of variation c of the mean over replicates and Student's t. If the first replicate
/// has no failures, it ends at three times the upper bound of independent samples, which allows for the correlation of the chains.
///
/// g is evaluated in parallel batches; the result does not depend on the number of threads. It must be deterministic.
///
/// # Errors
/// g fails or is NaN at a point, a setting is out of range, or the monitor cancels.
pub fn small_probability<E: Send>(
    variables: usize,
    g: &LimitState<'_, E>,
    settings: &Settings,
    monitor: &dyn Monitor,
) -> Result<SmallProbability, RareError<E>> {
    settings.check(variables)?;
    let task = Task::new(monitor, "small probability", settings.most_evaluations);
    let (mut probabilities, mut replicates, mut evaluations) = (Vec::new(), Vec::new(), 0);
    // Evaluations that are not needed end the progress.
    let end = |evaluations: usize| task.advance(settings.most_evaluations.saturating_sub(evaluations));
    loop {
        let mut draws = stream(settings.seed, "chaos/rare/subset", probabilities.len() as u64);
        let found = descend(variables, &mut draws, &mut |points| {
            evaluations += points.len();
            values(g, points, &task)
        })?;
        if probabilities.is_empty() && found.probability == 0.0 {
            end(evaluations);
            let interval = Interval { low: 0.0, high: found.bound() };
            return Ok(SmallProbability { probability: 0.0, interval, evaluations, replicates: vec![found] });
        }
        probabilities.push(found.probability);
        if replicates.len() < KEPT {
            replicates.push(found);
        }
        let (mean, count) = (Moments::new(&probabilities).mean, probabilities.len());
        let coefficient_of_variation = relative_error(&probabilities);
        let is_accurate = count >= LEAST_REPLICATES && coefficient_of_variation <= settings.coefficient_of_variation;
        if is_accurate || (count > 1 && evaluations >= settings.most_evaluations) {
            end(evaluations);
            let factor = (student_95(count) * coefficient_of_variation).exp();
            let interval = Interval { low: mean / factor, high: mean * factor };
            return Ok(SmallProbability { probability: mean, interval, evaluations, replicates });
        }
    }
}

/// Returns the coefficient of variation of the mean of replicates.
///
/// Their distribution resembles a lognormal one, whose standard deviation few replicates underestimate; the variance of their logarithms
/// does not (Cox's method: Land, *Technometrics* **14** (1972) 145).
fn relative_error(probabilities: &[f64]) -> f64 {
    let (moments, count) = (Moments::new(probabilities), probabilities.len() as f64);
    let own = moments.sample_std() / (moments.mean * count.sqrt());
    let logarithms: Vec<f64> = probabilities.iter().map(|probability| probability.ln()).collect();
    let variance = Moments::new(&logarithms).sample_std().powi(2);
    let of_logarithms = (variance / count + variance * variance / (2.0 * (count - 1.0))).sqrt();
    if of_logarithms.is_finite() { own.max(of_logarithms) } else { own }
}

impl SmallProbability {
    /// Returns the probability of failure of another limit state, from samples of this one.
    ///
    /// Its failures should lie in one of the nested sets of this one: it is this limit state with a small shift. The ratio of both
    /// probabilities is then more accurate than that of two independent estimates, from 3,000 evaluations or a few times as many.
    ///
    /// # Errors
    /// g fails or is NaN at a point, or the monitor cancels.
    pub fn of_other<E: Send>(&self, g: &LimitState<'_, E>, monitor: &dyn Monitor) -> Result<f64, RareError<E>> {
        let task = Task::new(monitor, "small probability: changed", self.replicates.len() * THINNED);
        let mut sum = 0.0;
        for replicate in &self.replicates {
            for (number, (probability, points)) in replicate.sets.iter().enumerate().rev() {
                let failures = values(g, points, &task)?.into_iter().filter(|value| *value < 0.0).count();
                let fraction = failures as f64 / points.len() as f64;
                if fraction <= MOST_FAILURES || number == 0 {
                    sum += probability * fraction;
                    break;
                }
            }
        }
        let own: f64 = self.replicates.iter().map(|replicate| replicate.probability).sum();
        Ok(if own > 0.0 { (self.probability * sum / own).min(1.0) } else { sum / self.replicates.len() as f64 })
    }
}

/// Returns g at the points, in their order.
fn values<E: Send>(g: &LimitState<'_, E>, points: &[Vec<f64>], task: &Task<'_>) -> Result<Vec<f64>, RareError<E>> {
    task.map(points.len(), |index| match g(&points[index]) {
        Err(error) => Err(RareError::Evaluation(error)),
        Ok(value) if value.is_nan() => Err(RareError::NotANumber { point: points[index].clone() }),
        Ok(value) => Ok(value),
    })
}

impl Settings {
    fn check<E>(&self, variables: usize) -> Result<(), RareError<E>> {
        if variables == 0 {
            return Err(RareError::Setting { name: "variables", value: 0.0, wanted: "at least 1" });
        }
        let cv = self.coefficient_of_variation;
        if !(cv > 0.0 && cv <= 1.0) {
            return Err(RareError::Setting { name: "coefficient_of_variation", value: cv, wanted: "in (0, 1]" });
        }
        Ok(())
    }
}
