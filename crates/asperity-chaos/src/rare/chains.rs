//! Subset levels and their Markov chains.
//!
//! The probability of {g < 0} is a product of conditional probabilities of nested sets {g ≤ b₁} ⊃ {g ≤ b₂} ⊃ … ⊃ {g < 0}. Each
//! threshold is a quantile of g over the samples of the level before. Markov chains that start from the samples inside a set
//! fill it up to the number of samples of a level.
//!
//! The chains propose z′ = ρz + √(1 − ρ²) ξ, which leaves the normal distribution invariant, and stay where they are if z′ is
//! outside the set. The chains of a level move together; after each move √(1 − ρ²) is adapted towards the acceptance rate 0.44.
//!
//! # References
//! Au & Beck, *Prob. Eng. Mech.* **16** (2001) 263, <https://doi.org/10.1016/S0266-8920(01)00019-4>; Papaioannou, Betz,
//! Zwirglmaier & Straub, *Prob. Eng. Mech.* **41** (2015) 89, <https://doi.org/10.1016/j.probengmech.2015.06.006>.

use asperity_base::random::{Stream, standard_normal};

/// Acceptance rate to which the chains adapt.
const ACCEPTANCE: f64 = 0.44;
/// Step √(1 − ρ²) of the first moves.
const FIRST_STEP: f64 = 0.6;
/// Range of the step.
const STEPS: [f64; 2] = [0.02, 1.0];
/// Probability below which no further level is opened.
pub(super) const LEAST_PROBABILITY: f64 = 1e-13;

/// Evaluation of the function at points.
type Evaluate<'a, X> = dyn FnMut(&[Vec<f64>]) -> Result<Vec<f64>, X> + 'a;

/// Size of the levels.
#[derive(Debug, Clone, Copy)]
pub(super) struct Plan {
    pub(super) variables: usize,
    /// Number of samples of a level.
    pub(super) samples: usize,
    /// Fraction of the samples that the threshold of the next level keeps.
    pub(super) fraction: f64,
    /// Largest number of levels.
    pub(super) levels: usize,
}

/// Samples of the last level.
#[derive(Debug, Clone)]
pub(super) struct LastLevel {
    pub(super) points: Vec<Vec<f64>>,
    pub(super) values: Vec<f64>,
    /// Probability of {g < 0}, or of the last level if no further level could be opened.
    pub(super) probability: f64,
    /// Whether the samples are in {g < 0}.
    pub(super) failed: bool,
    /// Number of levels, the first one included.
    pub(super) levels: usize,
    /// Samples of the last two levels before the threshold was applied, with their values.
    pub(super) before: [(Vec<Vec<f64>>, Vec<f64>); 2],
}

/// Runs levels until a fraction of the samples is in {g < 0}, and returns the samples there.
///
/// The levels also end if nearly all samples have the same value, at the largest number of levels, or below a probability of
/// 10⁻¹³.
///
/// # Errors
/// An error of `evaluate`.
pub(super) fn descend<X>(plan: Plan, draws: &mut Stream, evaluate: &mut Evaluate<'_, X>) -> Result<LastLevel, X> {
    let points: Vec<Vec<f64>> = (0..plan.samples).map(|_| standard_normal(draws, plan.variables)).collect();
    let values = evaluate(&points)?;
    let mut level =
        LastLevel { points, values, probability: 1.0, failed: false, levels: 1, before: Default::default() };
    let wanted = ((plan.fraction * plan.samples as f64) as usize).max(1);
    let mut step = FIRST_STEP;
    loop {
        level.before.swap(0, 1);
        level.before[1] = (level.points.clone(), level.values.clone());
        let total = level.values.len() as f64;
        let failures = level.values.iter().filter(|value| **value < 0.0).count();
        if failures >= wanted {
            level.retain(&|value| value < 0.0);
            level.probability *= failures as f64 / total;
            level.failed = true;
            return Ok(level);
        }
        let mut sorted = level.values.clone();
        let threshold = *sorted.select_nth_unstable_by(wanted - 1, f64::total_cmp).1;
        let inside = level.values.iter().filter(|value| **value <= threshold).count();
        let constant = inside as f64 > 0.9 * total;
        let probability = level.probability * inside as f64 / total;
        if constant || probability < LEAST_PROBABILITY || level.levels >= plan.levels {
            // Failures below the wanted fraction still count.
            if failures > 0 {
                level.retain(&|value| value < 0.0);
                level.probability *= failures as f64 / total;
                level.failed = true;
            }
            return Ok(level);
        }
        level.retain(&|value| value <= threshold);
        level.probability = probability;
        level.levels += 1;
        level.fill(plan.samples, &|value| value <= threshold, &mut step, draws, evaluate)?;
    }
}

impl LastLevel {
    /// Keeps the samples whose values are inside.
    fn retain(&mut self, inside: &dyn Fn(f64) -> bool) {
        let kept: Vec<usize> = (0..self.values.len()).filter(|i| inside(self.values[*i])).collect();
        self.points = kept.iter().map(|i| std::mem::take(&mut self.points[*i])).collect();
        self.values = kept.iter().map(|i| self.values[*i]).collect();
    }

    /// Keeps `count` samples, evenly spaced in the list.
    pub(super) fn thin(&mut self, count: usize) {
        let total = self.points.len();
        if total > count {
            self.points = (0..count).map(|i| std::mem::take(&mut self.points[i * total / count])).collect();
            self.values = (0..count).map(|i| self.values[i * total / count]).collect();
        }
    }

    /// Moves every sample `moves` times inside the set.
    pub(super) fn mix<X>(
        &mut self,
        moves: usize,
        inside: &dyn Fn(f64) -> bool,
        step: &mut f64,
        draws: &mut Stream,
        evaluate: &mut Evaluate<'_, X>,
    ) -> Result<(), X> {
        let count = self.points.len();
        for _ in 0..moves {
            self.fill(2 * count, inside, step, draws, evaluate)?;
            self.points.drain(..count);
            self.values.drain(..count);
        }
        Ok(())
    }

    /// Adds states of chains that start from the samples, up to a number of samples.
    pub(super) fn fill<X>(
        &mut self,
        samples: usize,
        inside: &dyn Fn(f64) -> bool,
        step: &mut f64,
        draws: &mut Stream,
        evaluate: &mut Evaluate<'_, X>,
    ) -> Result<(), X> {
        let chains = self.points.len();
        let (mut at, mut move_number) = (0, 0.0_f64);
        while self.points.len() < samples {
            let starts = at..(at + chains).min(at + samples - self.points.len());
            let rest = (1.0 - *step * *step).sqrt();
            let proposals: Vec<Vec<f64>> = self.points[starts.clone()]
                .iter()
                .map(|start| {
                    let xi = standard_normal(draws, start.len());
                    start.iter().zip(xi).map(|(z, xi)| rest * z + *step * xi).collect()
                })
                .collect();
            let values = evaluate(&proposals)?;
            let mut accepted = 0.0;
            let tried = proposals.len() as f64;
            for (start, (proposal, value)) in starts.zip(proposals.into_iter().zip(values)) {
                if inside(value) {
                    accepted += 1.0;
                    self.points.push(proposal);
                    self.values.push(value);
                } else {
                    self.points.push(self.points[start].clone());
                    self.values.push(self.values[start]);
                }
            }
            at += chains;
            move_number += 1.0;
            *step = (*step * ((accepted / tried - ACCEPTANCE) / move_number.sqrt()).exp()).clamp(STEPS[0], STEPS[1]);
        }
        Ok(())
    }
}
