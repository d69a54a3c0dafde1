//! Subset simulation with independent replicates.

use asperity_base::monitor::Monitor;
use asperity_base::random::stream;
use asperity_base::stats::{Interval, Moments, student_quantile};

use super::chains::{LEAST_PROBABILITY, LastLevel, Plan, descend};
use super::error::RareError;
use super::limit_state::LimitState;
use super::probability::{NoFailure, RareMethod, RareProbability, SmallProbability, UpperBound};

/// Settings of [`subset_simulation`].
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SubsetSettings {
    /// Number of samples of a level, at least 100.
    pub samples: usize,
    /// Fraction of the samples that starts the next level, in [0.05, 0.5].
    pub fraction: f64,
    /// Number of independent replicates, at least 2.
    pub replicates: usize,
    /// Seed of all draws.
    pub seed: u64,
}

/// Estimates P[g(z) < 0] by subset simulation: the mean over independent replicates.
///
/// The interval is P exp(±t c) with the coefficient of variation c of the mean over replicates and Student's t. The bias of a
/// replicate is of the order of 1/`samples`. See [`small_probability`](super::small_probability) for a method with far fewer
/// evaluations.
///
/// # Errors
/// g fails or is NaN at a point, a setting is out of range, or the monitor cancels.
///
/// # References
/// Au & Beck, *Prob. Eng. Mech.* **16** (2001) 263, <https://doi.org/10.1016/S0266-8920(01)00019-4>, with the chains of
/// Papaioannou, Betz, Zwirglmaier & Straub, *Prob. Eng. Mech.* **41** (2015) 89,
/// <https://doi.org/10.1016/j.probengmech.2015.06.006>.
pub fn subset_simulation<E: Send>(
    variables: usize,
    g: &(dyn Fn(&[f64]) -> Result<f64, E> + Sync),
    settings: &SubsetSettings,
    monitor: &dyn Monitor,
) -> Result<SmallProbability, RareError<E>> {
    settings.check(variables)?;
    let SubsetSettings { samples, fraction, replicates, seed } = *settings;
    let plan = Plan { variables, samples, fraction, levels: usize::MAX };
    let levels = (LEAST_PROBABILITY.ln() / fraction.ln()).ceil() as usize + 1;
    let mut state = LimitState::new(g, samples * replicates * (levels + 1), monitor);
    replicated(plan, seed, &mut state, &|probabilities, _, _| probabilities.len() == replicates)
}

/// Adds replicates until `enough` of their probabilities, their coefficient of variation and the number of evaluations.
pub(super) fn replicated<E: Send>(
    plan: Plan,
    seed: u64,
    state: &mut LimitState<'_, E>,
    enough: &dyn Fn(&[f64], f64, usize) -> bool,
) -> Result<SmallProbability, RareError<E>> {
    let mut probabilities = Vec::new();
    let mut bound: Option<UpperBound> = None;
    loop {
        let mut draws = stream(seed, "chaos/rare/subset", probabilities.len() as u64);
        // The first replicate leaves evaluations for a second one.
        let replicates = if probabilities.is_empty() { 2 } else { 1 };
        let plan = Plan { levels: plan.levels.min(state.left() / plan.samples / replicates), ..plan };
        let level = descend(plan, &mut draws, &mut |points| state.evaluate(points))?;
        probabilities.push(if level.failed { level.probability } else { 0.0 });
        if !level.failed {
            let found = level.bound();
            bound = bound.filter(|bound| bound.probability >= found.probability).or(Some(found));
        }
        let moments = Moments::new(&probabilities);
        let count = probabilities.len() as f64;
        let coefficient_of_variation = moments.sample_std() / (moments.mean * count.sqrt());
        let evaluations = state.evaluations();
        if !enough(&probabilities, coefficient_of_variation, evaluations) {
            continue;
        }
        if let (true, Some(bound)) = (moments.mean == 0.0, bound) {
            return Ok(SmallProbability::Bound(UpperBound { evaluations, ..bound }));
        }
        let factor = (student_quantile(0.975, count - 1.0) * coefficient_of_variation).exp();
        return Ok(SmallProbability::Estimate(RareProbability {
            probability: moments.mean,
            interval: Interval { low: moments.mean / factor, high: moments.mean * factor },
            coefficient_of_variation,
            evaluations,
            method: RareMethod::SubsetSimulation,
        }));
    }
}

impl LastLevel {
    /// Returns the bound if no sample of the last level failed: with a probability of 3/n, n
    /// independent samples contain no failure with a probability of 5 %. The correlation of the chains and the errors of the levels before triple
    /// the bound.
    pub(super) fn bound(&self) -> UpperBound {
        let correlation = if self.levels > 1 { 3.0 } else { 1.0 };
        let probability = self.probability * (3.0 * correlation / self.values.len() as f64).min(1.0);
        let (low, high) =
            self.values.iter().fold((f64::INFINITY, f64::NEG_INFINITY), |(a, b), v| (a.min(*v), b.max(*v)));
        let reason = if low == high { NoFailure::Constant } else { NoFailure::Exhausted };
        UpperBound { probability, reason, evaluations: 0 }
    }
}

impl SubsetSettings {
    /// Returns ten replicates with a fraction of 0.1.
    pub fn new(samples: usize, seed: u64) -> Self {
        Self { samples, fraction: 0.1, replicates: 10, seed }
    }

    fn check<E>(&self, variables: usize) -> Result<(), RareError<E>> {
        let error = |name, value, wanted| Err(RareError::Setting { name, value, wanted });
        if variables == 0 {
            return error("variables", 0.0, "at least 1");
        }
        if self.samples < 100 {
            return error("samples", self.samples as f64, "at least 100");
        }
        if !(0.05..=0.5).contains(&self.fraction) {
            return error("fraction", self.fraction, "in [0.05, 0.5]");
        }
        if self.replicates < 2 {
            return error("replicates", self.replicates as f64, "at least 2");
        }
        Ok(())
    }
}
