//! Small probabilities of expensive limit states.
//!
//! [`small_probability`] estimates P[g(z) < 0] for independent standard normal variables z, from 0.1 down to about 10⁻⁸. It
//! needs no derivatives of g, and g may have kinks, flat parts and several regions of failure.
//!
//! 1. Subset simulation on an interpolant of few evaluations locates the regions of failure. If the interpolant does not predict
//!    failures, subset simulation on g itself locates them.
//! 2. A mixture of half-spaces and normal distributions is fitted to the samples in these regions.
//! 3. Importance sampling from the mixture estimates the probability, with the interpolant as control variate. It uses new
//!    evaluations only, so no error of the interpolant biases the estimate, and its variance gives the interval.
//!
//! A limit state that is nearly linear needs about 20 evaluations, several regions of failure or kinks in ten variables a few
//! thousand. A region of failure that neither the search nor a draw reaches is missing from the probability and from its interval.
//!
//! [`subset_simulation`] is the classical method, with an interval from independent replicates.
//!
//! ```
//! use asperity_base::monitor::Silent;
//! use asperity_chaos::rare::{Settings, SmallProbability, small_probability};
//!
//! // P[z₁ + z₂ > 4.5·√2] = Φ(−4.5) = 3.4e-6
//! let g = |z: &[f64]| Ok::<f64, ()>(4.5 * 2.0_f64.sqrt() - z[0] - z[1]);
//! let SmallProbability::Estimate(found) = small_probability(2, &g, &Settings::new(1), &Silent)? else { panic!() };
//! assert!(found.interval.contains(3.398e-6) && found.evaluations < 200);
//! # Ok::<(), asperity_chaos::rare::RareError<()>>(())
//! ```

mod chains;
mod error;
mod importance;
mod interpolant;
mod learning;
mod limit_state;
mod probability;
mod proposal;
mod subset;
#[cfg(test)]
mod tests;

use asperity_base::monitor::Monitor;
use asperity_base::random::stream;

use chains::Plan;
pub use error::RareError;
use importance::{Draws, UNSEEN};
use learning::Learning;
use limit_state::LimitState;
pub use probability::{NoFailure, RareMethod, RareProbability, SmallProbability, UpperBound};
use proposal::Proposal;
pub use subset::{SubsetSettings, subset_simulation};

/// Importance samples of the first batch if the interpolant does not predict all failures among fewer samples.
const FIRST_DRAWS: usize = 20;
/// Smallest number of importance samples.
const LEAST_DRAWS: usize = 8;
/// Importance samples of the first batch in regions that subset simulation on g located.
const LOCATED_DRAWS: usize = 400;
/// Number of mixtures that are fitted to the interpolant.
const ATTEMPTS: usize = 3;
/// Rounds of learning before each mixture.
const ROUNDS: [usize; ATTEMPTS] = [24, 8, 8];
/// Further importance samples above which another mixture is tried.
const MANY: f64 = 200.0;
/// Further importance samples above which replicates of subset simulation are preferred.
const TOO_MANY: f64 = 3000.0;
/// Samples per level of subset simulation on g.
const LEVEL_SAMPLES: usize = 500;
/// Smallest number of levels for which the evaluations suffice, replicates included.
const LEAST_LEVELS: usize = 16;
/// Smallest number of replicates of subset simulation on g.
const LEAST_REPLICATES: usize = 12;

/// Settings of [`small_probability`].
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Settings {
    /// Coefficient of variation of the probability at which sampling ends.
    pub coefficient_of_variation: f64,
    /// Largest number of evaluations, at least 2,000.
    pub most_evaluations: usize,
    /// Seed of all draws.
    pub seed: u64,
}

impl Settings {
    /// Returns a coefficient of variation of 0.1 and at most 20,000 evaluations.
    pub fn new(seed: u64) -> Self {
        Self { coefficient_of_variation: 0.1, most_evaluations: 20_000, seed }
    }
}

/// Estimates P[g(z) < 0] for `variables` independent standard normal variables z.
///
/// g is evaluated in parallel batches; the result does not depend on the number of threads. It must be deterministic.
///
/// # Errors
/// g fails or is NaN at a point, a setting is out of range, or the monitor cancels.
pub fn small_probability<E: Send>(
    variables: usize,
    g: &(dyn Fn(&[f64]) -> Result<f64, E> + Sync),
    settings: &Settings,
    monitor: &dyn Monitor,
) -> Result<SmallProbability, RareError<E>> {
    settings.check(variables)?;
    if variables == 1 {
        // In one dimension the points of the interpolant are too close to each other; a variable without effect separates them.
        return estimate(2, &|z: &[f64]| g(&z[..1]), settings, monitor);
    }
    estimate(variables, g, settings, monitor)
}

fn estimate<E: Send>(
    variables: usize,
    g: &(dyn Fn(&[f64]) -> Result<f64, E> + Sync),
    settings: &Settings,
    monitor: &dyn Monitor,
) -> Result<SmallProbability, RareError<E>> {
    let state = &mut LimitState::new(g, settings.most_evaluations, monitor);
    let mut learning = Learning::new(variables, settings.seed, state)?;
    if let Some(found) = attempts(settings, &mut learning, state)? {
        return Ok(SmallProbability::Estimate(found));
    }
    let samples = (state.left() / LEAST_LEVELS).min(LEVEL_SAMPLES);
    let plan = Plan { variables, samples, fraction: 0.1, levels: usize::MAX };
    subset::replicated(plan, settings.seed, state, &|probabilities, coefficient_of_variation, evaluations| {
        let count = probabilities.len();
        let used_up = evaluations + evaluations / count > settings.most_evaluations;
        let accurate = count >= LEAST_REPLICATES && coefficient_of_variation <= settings.coefficient_of_variation;
        count > 1 && (used_up || accurate)
    })
}

/// Learns mixtures until importance sampling from one of them promises few evaluations, and samples from it. The last mixture
/// comes from subset simulation on g.
fn attempts<E: Send>(
    settings: &Settings,
    learning: &mut Learning,
    state: &mut LimitState<'_, E>,
) -> Result<Option<RareProbability>, RareError<E>> {
    let mut learns = true;
    for attempt in 0..=ATTEMPTS {
        let learnt = match ROUNDS.get(attempt) {
            Some(rounds) if learns => learning.region(*rounds, state)?,
            _ => None,
        };
        learns = learnt.is_some();
        let Some(region) = (if learns { learnt } else { learning.located(state)? }) else { break };
        let proposal = Proposal::fit(&region.points, &region.directions);
        let random = stream(settings.seed, "chaos/rare/importance", attempt as u64);
        let mut draws = Draws::new(&proposal, &region.interpolant, random);
        let first = if learns { settings.first_draws() } else { LOCATED_DRAWS };
        draws.add(first.min(state.left()), state)?;
        if !draws.predicted() {
            draws.add(FIRST_DRAWS.saturating_sub(first).min(state.left()), state)?;
        }
        let most = if learns && attempt + 1 < ATTEMPTS { MANY } else { TOO_MANY };
        if settings.further(&draws) < most {
            return finish(settings, draws, state).map(Some);
        }
        if !learns {
            break;
        }
        learning.add(&draws.points, &draws.values);
    }
    Ok(None)
}

/// Adds draws until the coefficient of variation is reached or the evaluations are used up.
fn finish<E: Send>(
    settings: &Settings,
    mut draws: Draws<'_>,
    state: &mut LimitState<'_, E>,
) -> Result<RareProbability, RareError<E>> {
    loop {
        let wanted = settings.further(&draws).min(state.left() as f64) as usize;
        if wanted == 0 {
            break;
        }
        draws.add(wanted, state)?;
    }
    let [probability, coefficient_of_variation] = draws.estimate();
    Ok(RareProbability {
        probability,
        interval: draws.interval(),
        coefficient_of_variation,
        evaluations: state.evaluations(),
        method: RareMethod::ImportanceSampling,
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
        if self.most_evaluations < 2000 {
            let value = self.most_evaluations as f64;
            return Err(RareError::Setting { name: "most_evaluations", value, wanted: "at least 2000" });
        }
        Ok(())
    }

    /// Returns the number of draws that suffice if the interpolant predicts all failures.
    fn first_draws(&self) -> usize {
        ((UNSEEN / self.coefficient_of_variation.powi(2) * 1.01).ceil() as usize).clamp(LEAST_DRAWS, FIRST_DRAWS)
    }

    /// Returns the number of further draws that reach the coefficient of variation.
    fn further(&self, draws: &Draws) -> f64 {
        let ratio = draws.estimate()[1] / self.coefficient_of_variation;
        if ratio <= 1.0 { 0.0 } else { ((ratio * ratio - 1.0) * draws.points.len() as f64).ceil().max(5.0) }
    }
}
