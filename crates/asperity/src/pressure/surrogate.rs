//! Laws from models that are cheap to evaluate, and how well the samples determine them.
//!
//! A [`Surrogate`] is fitted to samples with weights. All weights 1 give its estimate; random weights, those of the
//! Bayesian bootstrap, give its errors. No sample ever gets the weight 0, so that a model that the samples determine is
//! determined in every resample, which drawing with replacement does not grant: there 37 % of the samples are missing. What is
//! chosen beforehand, variables and degree, is chosen once, and is not part of the errors; nor is what the model cannot say.
//!
//! # References
//! D. B. Rubin, *Ann. Statist.* **9** (1981) 130, <https://doi.org/10.1214/aos/1176345338>.

pub(super) mod censored;
pub(super) mod functions;
pub(super) mod latent;
pub(super) mod newton;
pub(super) mod two_part;

use rand::RngExt;
use rayon::prelude::*;

use crate::chaos::{Design, StepLaw};
use crate::pressure::adapted::Adapted;
use crate::pressure::estimate::nodes;
use crate::pressure::nested::kappa_pa_per_m;
use crate::pressure::{Band, Estimate, MethodError, Problem, Samples};
use crate::random::stream;
use crate::stats::{Interval, wilson_interval};

/// Resamples from which errors are taken,
const RESAMPLES: usize = 60;
/// and the least number that must have a model.
const LEAST_FITTED: usize = 30;
/// Most variables of the rotated germ, and the degree of the polynomials that choose them.
const MOST_VARIABLES: usize = 8;
const CHOOSING_DEGREE: usize = 3;
/// Fewest samples in contact from which a law of the pressure in contact is modelled.
pub(super) const LEAST_IN_CONTACT: usize = 10;
/// Samples for each coefficient that a degree needs to be tried.
pub(super) const SAMPLES_PER_TERM: usize = 4;

/// What a model says.
#[derive(Debug, Clone)]
pub(super) struct Fitted {
    /// Pressures in pascal and their probabilities.
    pub(super) atoms: Vec<(f64, f64)>,
    pub(super) contact_probability: f64,
    pub(super) coefficients: usize,
    pub(super) leave_one_out_error: Option<f64>,
}

/// A model of the pressure.
pub(super) trait Surrogate: Sync {
    /// Fits samples with the given weights, one for each sample, 1 on average.
    fn fit(&self, weights: &[f64]) -> Result<Fitted, MethodError>;
}

/// The law by a surrogate of `samples` samples, of which `in_contact` are, evaluated on `evaluations` fresh germs, with
/// errors by resampling.
///
/// # Errors
/// The samples have no model, or it overflows.
pub(super) fn estimate(
    surrogate: &dyn Surrogate,
    [samples, in_contact]: [usize; 2],
    evaluations: usize,
    seed: u64,
) -> Result<Estimate, MethodError> {
    let fitted = surrogate.fit(&vec![1.0; samples])?;
    let overflowed = fitted.atoms.iter().filter(|(p, _)| !p.is_finite()).count();
    if overflowed > 0 {
        return Err(MethodError::Overflow { overflowed, evaluations });
    }
    let law = StepLaw::weighted(fitted.atoms)?;
    let nodes = nodes(&law, samples);
    let cdf: Vec<f64> = nodes.iter().map(|t| law.cdf(*t)).collect();
    let replicates: Vec<Option<Vec<f64>>> = (0..RESAMPLES)
        .into_par_iter()
        .map(|i| Some(summary(surrogate.fit(&weights(samples, seed, i)).ok()?, &nodes)))
        .collect();
    let replicates: Vec<Vec<f64>> = replicates.into_iter().flatten().collect();
    let (band, mean_se_pa, contact_probability_se) = if replicates.len() < LEAST_FITTED {
        (None, f64::NAN, f64::NAN)
    } else {
        let covariance = covariance(&replicates);
        let (n, length) = (nodes.len(), nodes.len() + 2);
        // That of the evaluations comes on top; they are the same in all resamples.
        let more = |i: usize, j: usize| cdf[i.min(j)] * (1.0 - cdf[i.max(j)]) / evaluations as f64;
        let of_cdf: Vec<f64> = (0..n * n).map(|k| covariance[k / n * length + k % n] + more(k / n, k % n)).collect();
        let band = Band::new(&nodes, &cdf, &of_cdf, Some(replicates.len() - 1), seed);
        let variance = |i: usize| covariance[i * length + i];
        (
            Some(band),
            (variance(n) + law.std().powi(2) / evaluations as f64).sqrt(),
            (variance(n + 1) + more(0, 0)).sqrt(),
        )
    };
    let contact_probability = fitted.contact_probability;
    // Where all samples agree they say nothing of the error of a model.
    let contact_probability_interval = match &band {
        Some(band) if in_contact > 0 && in_contact < samples => {
            let half = band.pointwise_factor * contact_probability_se;
            Interval {
                low: (contact_probability - half).clamp(0.0, 1.0),
                high: (contact_probability + half).clamp(0.0, 1.0),
            }
        }
        _ => wilson_interval(in_contact, samples),
    };
    Ok(Estimate {
        contact_probability,
        contact_probability_se,
        contact_probability_interval,
        mean_pa: law.mean(),
        mean_se_pa,
        band,
        coefficients: Some(fitted.coefficients),
        leave_one_out_error: fitted.leave_one_out_error,
        law,
    })
}

/// Standard exponential weights over their mean.
fn weights(samples: usize, seed: u64, resample: usize) -> Vec<f64> {
    let mut stream = stream(seed, "pressure/surrogate", resample as u64);
    let mut weights: Vec<f64> =
        (0..samples).map(|_| (-(1.0 - stream.random::<f64>()).ln()).max(f64::EPSILON)).collect();
    let mean = weights.iter().sum::<f64>() / samples as f64;
    weights.iter_mut().for_each(|w| *w /= mean);
    weights
}

/// Distribution function at the nodes, mean and contact probability.
fn summary(mut fitted: Fitted, nodes: &[f64]) -> Vec<f64> {
    fitted.atoms.sort_by(|a, b| a.0.total_cmp(&b.0));
    let (mut atoms, mut below) = (fitted.atoms.iter().peekable(), 0.0);
    let mut values: Vec<f64> = nodes
        .iter()
        .map(|t| {
            while let Some((_, probability)) = atoms.next_if(|(p, _)| p <= t) {
                below += probability;
            }
            below
        })
        .collect();
    values.push(fitted.atoms.iter().map(|(p, probability)| p * probability).sum());
    values.push(fitted.contact_probability);
    values
}

/// Covariance of vectors, row by row.
fn covariance(vectors: &[Vec<f64>]) -> Vec<f64> {
    let (count, n) = (vectors.len() as f64, vectors[0].len());
    let means: Vec<f64> = (0..n).map(|i| vectors.iter().map(|v| v[i]).sum::<f64>() / count).collect();
    let product = |i: usize, j: usize| vectors.iter().map(|v| (v[i] - means[i]) * (v[j] - means[j])).sum::<f64>();
    (0..n * n).map(|k| product(k / n, k % n) / (count - 1.0)).collect()
}

/// Samples in the variables of the germ rotated to the cell, see [`Adapted`], and fresh ones.
#[derive(Debug, Clone)]
pub(super) struct Rotated {
    /// Variables of each sample; none where no direction predicts the pressure.
    pub(super) rows: Vec<Vec<f64>>,
    pub(super) pressures_pa: Vec<f64>,
    /// Fresh variables, independent and standard normal.
    pub(super) fresh: Vec<Vec<f64>>,
    /// Upper bound of the pressure.
    pub(super) largest_pa: f64,
}

impl Rotated {
    /// `design` makes fresh germs of so many variables.
    pub(super) fn new<E>(
        problem: &Problem<'_>,
        samples: &Samples,
        design: impl Fn(usize) -> Result<Design, E>,
    ) -> Result<Result<Self, MethodError>, E> {
        let germs: Vec<Vec<f64>> = (0..samples.len()).map(|i| samples.germ(i)).collect();
        let latent = latent_pa(samples);
        let adapted = match Adapted::new(problem, MOST_VARIABLES, CHOOSING_DEGREE, &germs, &latent) {
            Ok(adapted) => adapted,
            Err(error) => return Ok(Err(error)),
        };
        let rows: Vec<Vec<f64>> = germs.iter().map(|germ| adapted.of(germ)).collect();
        let variables = rows.first().map_or(0, Vec::len);
        // A design has at least one variable.
        let design = design(variables.max(1))?;
        let fresh = (0..design.samples()).map(|i| design.germ(i)).collect();
        let pressures_pa = samples.observations().iter().map(|o| o.pressure_pa).collect();
        let largest_pa = problem.hardness_pa().unwrap_or(f64::INFINITY);
        Ok(Ok(Self { rows, pressures_pa, fresh, largest_pa }))
    }

    pub(super) fn variables(&self) -> usize {
        self.rows.first().map_or(0, Vec::len)
    }

    /// Samples, and those in contact.
    pub(super) fn counts(&self) -> [usize; 2] {
        [self.pressures_pa.len(), self.pressures_pa.iter().filter(|p| **p > 0.0).count()]
    }
}

/// The pressure of each sample, continued below zero by the gap and above the hardness by the plastic displacement.
pub(super) fn latent_pa(samples: &Samples) -> Vec<f64> {
    let kappa = kappa_pa_per_m(samples.observations());
    let latent = |o: &crate::pressure::Observation| o.pressure_pa + kappa * (o.plastic_displacement_m - o.gap_m);
    samples.observations().iter().map(latent).collect()
}

/// A point between 0 and 1 for each index, evenly spread.
pub(super) fn golden(index: usize) -> f64 {
    ((index as f64 + 0.5) * 0.618_033_988_749_894_9).fract()
}

#[cfg(test)]
mod tests;
