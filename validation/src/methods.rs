//! Estimates of the pressure by all methods of the comparison, from the contact solutions of one study.
//!
//! Besides the methods of [`asperity::pressure`]: censored regression, a two-part model, a control
//! variate in the rotated normal variables, multilevel Monte Carlo without regression, and pooling of cells.

mod censored;
mod functions;
mod latent;
mod newton;
mod two_part;

use std::error::Error;

use asperity::monitor::Monitor;
use asperity::pressure::surrogate::{RotatedSamples, estimate, others};
use asperity::pressure::{MethodComparison, MethodError, PressureError, PressureEstimate, PressureMethod, Problem};

use latent::LatentOverlap;
use two_part::TwoPart;

/// Smallest number of samples in contact for a model of the pressure in contact.
const LEAST_IN_CONTACT: usize = 10;
/// Smallest number of samples per coefficient for a degree to be tried.
const SAMPLES_PER_TERM: usize = 4;

/// An estimate, or the reason why there is none.
pub type Outcome = Result<PressureEstimate, Box<dyn Error + Send + Sync>>;

/// Returns the names of the methods, in the order of [`estimates`].
pub fn names() -> Vec<&'static str> {
    let product: Vec<&str> = PressureMethod::ALL.iter().map(|method| method.name()).collect();
    let (last, first) = product.split_last().map_or(("", &[][..]), |(last, first)| (*last, first));
    let own = ["latent_overlap", "two_part", "control_variate", "multilevel", "pooled_sites"];
    first.iter().copied().chain(own).chain([last]).collect()
}

/// Estimates the distribution of the pressure of `problem` by every method of [`names`].
///
/// # Errors
/// As [`MethodComparison::run`].
pub fn estimates(
    study: &MethodComparison,
    problem: &Problem<'_>,
    monitor: &dyn Monitor,
) -> Result<Vec<Outcome>, PressureError> {
    let &MethodComparison { seed, degree, .. } = study;
    let largest_pa = problem.hardness_pa().unwrap_or(f64::INFINITY);
    let solutions = study.solve(problem, monitor)?;
    let by_rotated = |model: &dyn Fn(&RotatedSamples) -> Result<PressureEstimate, MethodError>| -> Outcome {
        let rotated = solutions.rotated.as_ref().ok_or("the local polynomial chaos is not among the methods")?;
        Ok(model(rotated.as_ref().map_err(Clone::clone)?)?)
    };
    let by_nested = |coarse: bool, fitted: bool| -> Outcome {
        let nested = solutions.nested.as_ref().map_err(Clone::clone)?;
        Ok(nested.estimate_pressure(problem, seed, coarse, fitted)?)
    };
    let mut own = vec![
        by_rotated(&|rotated| estimate(&LatentOverlap::new(rotated, degree), rotated.training(), seed)),
        by_rotated(&|rotated| estimate(&TwoPart::new(rotated, degree), rotated.training(), seed)),
        by_nested(false, true),
        by_nested(true, false),
    ];
    let sites = PressureEstimate::from_sites(&solutions.monte_carlo, largest_pa, seed)?;
    let results = solutions.results(monitor)?;
    let homogeneity = results.fields.as_ref().map(|fields| &fields.homogeneity);
    own.push(match homogeneity {
        _ if problem.cells_are_alike() => Ok(sites),
        Some(Ok(found)) if found.is_plausible() => Ok(sites),
        Some(Ok(found)) => Err(format!("cells differ: p-value {:.2e}", found.p_value).into()),
        Some(Err(reason)) => Err(reason.clone().into()),
        None => Err("no samples of whole fields".into()),
    });
    let mut product: Vec<Outcome> =
        results.methods.into_iter().map(|method| Ok(method.outcome.map(|(estimate, _)| estimate)?)).collect();
    let last = product.pop();
    Ok(product.into_iter().chain(own).chain(last).collect())
}

/// Returns the rows of some samples.
fn rows_of(rotated: &RotatedSamples, samples: &[usize]) -> Vec<Vec<f64>> {
    samples.iter().map(|i| rotated.rows[*i].clone()).collect()
}

/// Returns the rows of all other samples.
fn rows_but(rotated: &RotatedSamples, samples: &[usize]) -> Vec<Vec<f64>> {
    rows_of(rotated, &others(samples, rotated.rows.len()))
}

/// Returns a point between 0 and 1 for each index; the points are evenly distributed.
fn golden(index: usize) -> f64 {
    ((index as f64 + 0.5) * 0.618_033_988_749_894_9).fract()
}

#[cfg(test)]
mod tests;
