//! Contact solutions on a design of germs.

use rayon::prelude::*;
use std::sync::atomic::{AtomicUsize, Ordering};

use crate::chaos::{Design, SamplingMethod, StepLaw};
use crate::monitor::{Cancelled, Monitor};
use crate::pressure::{FailureReason, Observation, PressureError, Problem};

/// A sample without an answer.
#[derive(Debug, Clone, PartialEq)]
pub struct Failure {
    /// Index of the sample in its design.
    pub index: usize,
    /// Why.
    pub reason: FailureReason,
}

/// The pressures of a design of germs, in index order, and the samples that failed.
#[derive(Debug, Clone)]
pub struct Samples {
    design: Design,
    /// Indices of the samples that were solved.
    indices: Vec<usize>,
    observations: Vec<Observation>,
    failures: Vec<Failure>,
}

/// Solves the contact problems of `samples` germs in parallel; the result does not depend on the number of threads.
///
/// # Errors
/// The design cannot be made, fewer than `valid_share` (0 to 1) of the problems were solved, or the monitor cancelled.
pub fn solve(
    problem: &Problem<'_>,
    method: SamplingMethod,
    seed: u64,
    stage: &str,
    samples: usize,
    valid_share: f64,
    monitor: &dyn Monitor,
) -> Result<Samples, PressureError> {
    let design = Design::new(method, seed, stage, samples, problem.surface().germ_len())?;
    let done = AtomicUsize::new(0);
    let outcomes: Vec<Result<Observation, FailureReason>> = (0..samples)
        .into_par_iter()
        .map_init(
            || (problem.half_space().workspace(), vec![0.0; design.dimensions()]),
            |(workspace, germ), index| {
                if monitor.cancelled() {
                    return Err(Cancelled);
                }
                design.fill_germ(index, germ);
                let outcome = problem.observe(germ, workspace);
                monitor.progress(stage, done.fetch_add(1, Ordering::Relaxed) + 1, samples);
                Ok(outcome)
            },
        )
        .collect::<Result<_, Cancelled>>()?;
    let mut solved = Samples { design, indices: Vec::new(), observations: Vec::new(), failures: Vec::new() };
    for (index, outcome) in outcomes.into_iter().enumerate() {
        match outcome {
            Ok(observation) => {
                solved.indices.push(index);
                solved.observations.push(observation);
            }
            Err(reason) => solved.failures.push(Failure { index, reason }),
        }
    }
    match solved.failures.first() {
        Some(first) if (solved.indices.len() as f64) < valid_share * samples as f64 || solved.indices.is_empty() => {
            Err(PressureError::TooFewValid {
                stage: stage.to_owned(),
                valid: solved.indices.len(),
                samples,
                wanted_percent: 100.0 * valid_share,
                first_index: first.index,
                first_reason: first.reason.clone(),
            })
        }
        _ => Ok(solved),
    }
}

impl Samples {
    /// Number of samples with an answer.
    pub fn len(&self) -> usize {
        self.indices.len()
    }

    /// Whether no sample has an answer: never, [`solve`] refuses that.
    pub fn is_empty(&self) -> bool {
        self.indices.is_empty()
    }

    /// Number of contact problems posed, failed ones included.
    pub fn posed(&self) -> usize {
        self.design.samples()
    }

    /// What the solutions say, in index order.
    pub fn observations(&self) -> &[Observation] {
        &self.observations
    }

    /// The samples without an answer, in index order.
    pub fn failures(&self) -> &[Failure] {
        &self.failures
    }

    /// The whole germ of the solved sample number `position`.
    pub fn germ(&self, position: usize) -> Vec<f64> {
        self.design.germ(self.indices[position])
    }

    /// The leading `variables` germ values of every solved sample.
    pub fn leading_germs(&self, variables: usize) -> Vec<Vec<f64>> {
        (0..self.len())
            .map(|position| {
                let mut germ = self.germ(position);
                germ.truncate(variables);
                germ
            })
            .collect()
    }

    /// Number K of samples in contact.
    pub fn in_contact(&self) -> usize {
        self.observations.iter().filter(|o| o.pressure_pa > 0.0).count()
    }

    /// K/K_t, the share of samples in contact.
    pub fn contact_probability(&self) -> f64 {
        self.in_contact() as f64 / self.len() as f64
    }

    /// Standard error √(P(1−P)/K_t) of independent samples. For Latin hypercube and scrambled Sobol' points it is, up to
    /// small factors, an upper bound.
    ///
    /// # References
    /// Owen, *Ann. Statist.* **25** (1997) 1541, <https://doi.org/10.1214/aos/1031594731>.
    pub fn contact_probability_se(&self) -> f64 {
        let p = self.contact_probability();
        (p * (1.0 - p) / self.len() as f64).sqrt()
    }

    /// The empirical law of the pressure in pascal.
    ///
    /// # Errors
    /// A pressure is not finite.
    pub fn law(&self) -> Result<StepLaw, PressureError> {
        let pressures: Vec<f64> = self.observations.iter().map(|o| o.pressure_pa).collect();
        Ok(StepLaw::empirical(&pressures)?)
    }
}
