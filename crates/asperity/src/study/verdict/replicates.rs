//! Points of machines in several independent randomisations.

use crate::chaos::{Design, SamplingError, SamplingMethod};

/// Randomisations of the Sobol' points.
pub(in crate::study) const REPLICATES: usize = 8;
/// Stream of the points.
const STREAM: &str = "study/verdict/remedies";

/// Returns the standard normal variables of all replicates with `count` points each.
pub(super) fn points(variables: usize, count: usize, seed: u64) -> Result<Vec<Vec<f64>>, SamplingError> {
    if variables == 0 {
        return Ok(vec![Vec::new()]);
    }
    let design = Design::new(SamplingMethod::Sobol, seed, STREAM, count, variables)?;
    let mut points = Vec::with_capacity(REPLICATES * count);
    for replicate in 0..REPLICATES {
        let design = design.replicate(replicate)?;
        points.extend((0..count).map(|index| design.xi(index)));
    }
    Ok(points)
}

/// Returns the fraction of machines without an answer, whose margin is −∞.
pub(super) fn fraction_unanswered(margins: &[f64]) -> f64 {
    margins.iter().filter(|margin| **margin == f64::NEG_INFINITY).count() as f64 / margins.len() as f64
}

/// Returns the fraction of negative margins.
pub(super) fn fraction_below_zero(margins: &[f64]) -> f64 {
    margins.iter().filter(|margin| **margin < 0.0).count() as f64 / margins.len() as f64
}
