//! Nested sets and their Markov chains.
//!
//! The probability of {g < 0} is a product of conditional probabilities of nested sets {g < b₁} ⊃ {g < b₂} ⊃ … ⊃ {g < 0}. Each
//! threshold is a quantile of g over the samples of the set before. Markov chains that start from the samples inside a set
//! fill it up to the number of samples of a set.
//!
//! The chains propose z′ = ρz + √(1 − ρ²) ξ, which leaves the normal distribution invariant, and stay where they are if z′ is
//! outside the set. After each set √(1 − ρ²) is adapted towards the acceptance rate 0.44. Within a set it is constant, and the samples with
//! which the set began stay: the mean of the product is then the probability, whatever the number of samples [1].
//!
//! # References
//! 1. Bréhier, Gazeau, Goudenège, Lelièvre & Rousset, *Ann. Appl. Probab.* **26** (2016) 3559, <https://doi.org/10.1214/16-AAP1185>.

use asperity_base::random::{Stream, standard_normal};

/// Number of samples of a set.
const SAMPLES: usize = 500;
/// Number of samples with which the next set begins.
const STARTS: usize = SAMPLES / 10;
/// Number of samples that are kept of a set; neighbours in a chain resemble each other.
pub(super) const THINNED: usize = SAMPLES / 2;
/// Acceptance rate to which the chains adapt.
const ACCEPTANCE: f64 = 0.44;
/// Step √(1 − ρ²) of the first moves.
const FIRST_STEP: f64 = 0.6;
/// Change of the logarithm of the step by the difference of the acceptance rate.
const GAIN: f64 = 2.0;
/// Range of the step.
const STEPS: [f64; 2] = [0.02, 1.0];
/// Probability below which no further set begins.
const LEAST_PROBABILITY: f64 = 1e-8;
/// Fraction of equal values above which g does not lead to failures.
const CONSTANT: f64 = 0.9;

/// Evaluation of the function at points.
type Evaluate<'a, X> = dyn FnMut(&[Vec<f64>]) -> Result<Vec<f64>, X> + 'a;

/// Nested sets of one replicate.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Descent {
    /// Probability of each set, beginning with 1, and every second of its samples.
    pub(super) sets: Vec<(f64, Vec<Vec<f64>>)>,
    /// Probability of {g < 0}.
    pub(super) probability: f64,
}

/// Samples in a set, with their values.
struct Samples {
    points: Vec<Vec<f64>>,
    values: Vec<f64>,
}

/// Descends until a tenth of the samples is in {g < 0}, nearly all samples have the same value, or the probability is below 10⁻⁸.
///
/// # Errors
/// An error of `evaluate`.
pub(super) fn descend<X>(variables: usize, draws: &mut Stream, evaluate: &mut Evaluate<'_, X>) -> Result<Descent, X> {
    let points: Vec<Vec<f64>> = (0..SAMPLES).map(|_| standard_normal(draws, variables)).collect();
    let mut samples = Samples { values: evaluate(&points)?, points };
    let (mut sets, mut probability, mut step) = (Vec::new(), 1.0, FIRST_STEP);
    loop {
        sets.push((probability, samples.points.iter().step_by(SAMPLES / THINNED).cloned().collect()));
        let failures = samples.values.iter().filter(|value| **value < 0.0).count();
        let mut sorted = samples.values.clone();
        let mut threshold = *sorted.select_nth_unstable_by(STARTS, f64::total_cmp).1;
        // The sample on the threshold is not inside, or the product of the fractions would exceed the probability; equal values all are.
        if samples.values.iter().all(|value| *value >= threshold) {
            threshold = threshold.next_up();
        }
        let inside = samples.values.iter().filter(|value| **value < threshold).count();
        let fraction = inside as f64 / SAMPLES as f64;
        if failures >= STARTS || fraction > CONSTANT || probability * fraction < LEAST_PROBABILITY {
            return Ok(Descent { sets, probability: probability * failures as f64 / SAMPLES as f64 });
        }
        samples.retain(threshold);
        probability *= fraction;
        samples.fill(threshold, &mut step, draws, evaluate)?;
    }
}

impl Descent {
    /// Returns an upper bound of the probability if no sample of the last set failed: with a probability of 3/n, n independent samples
    /// contain no failure with a probability of 5 %. The correlation of the chains and the errors of the sets before triple the bound.
    pub(super) fn bound(&self) -> f64 {
        let correlation = if self.sets.len() > 1 { 3.0 } else { 1.0 };
        let last = self.sets.last().map_or(1.0, |(probability, _)| *probability);
        last * 3.0 * correlation / SAMPLES as f64
    }
}

impl Samples {
    /// Keeps the samples below a threshold.
    fn retain(&mut self, threshold: f64) {
        let kept: Vec<usize> = (0..self.values.len()).filter(|i| self.values[*i] < threshold).collect();
        self.points = kept.iter().map(|i| std::mem::take(&mut self.points[*i])).collect();
        self.values = kept.iter().map(|i| self.values[*i]).collect();
    }

    /// Adds states of chains that start from the samples.
    fn fill<X>(
        &mut self,
        threshold: f64,
        step: &mut f64,
        draws: &mut Stream,
        evaluate: &mut Evaluate<'_, X>,
    ) -> Result<(), X> {
        let chains = self.points.len();
        let (mut at, mut accepted, mut tried) = (0, 0.0, 0.0);
        let rest = (1.0 - *step * *step).sqrt();
        while self.points.len() < SAMPLES {
            let starts = at..(at + chains).min(at + SAMPLES - self.points.len());
            let proposals: Vec<Vec<f64>> = self.points[starts.clone()]
                .iter()
                .map(|start| {
                    let xi = standard_normal(draws, start.len());
                    start.iter().zip(xi).map(|(z, xi)| rest * z + *step * xi).collect()
                })
                .collect();
            let values = evaluate(&proposals)?;
            tried += proposals.len() as f64;
            for (start, (proposal, value)) in starts.zip(proposals.into_iter().zip(values)) {
                if value < threshold {
                    accepted += 1.0;
                    self.points.push(proposal);
                    self.values.push(value);
                } else {
                    self.points.push(self.points[start].clone());
                    self.values.push(self.values[start]);
                }
            }
            at += chains;
        }
        *step = (*step * (GAIN * (accepted / tried - ACCEPTANCE)).exp()).clamp(STEPS[0], STEPS[1]);
        Ok(())
    }
}
