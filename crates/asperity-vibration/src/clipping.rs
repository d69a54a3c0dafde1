//! Friction values that are raised so that friction stays positive.

use super::Oscillator;
use asperity_process::ProcessModel;

/// Fraction of the friction values that may be clipped without being allowed explicitly: beyond it the process is no longer
/// the stated one.
pub const LARGEST_CLIPPED_FRACTION: f64 = 0.05;

/// Least fluctuation that leaves the kinetic coefficient positive at the fastest slip that is expected, for
/// [`asperity_process::ProcessModel::least`].
///
/// Displacements scale with μ_st, so |v_rel| hardly exceeds V + μ_st, or `speeds` times that under violent friction. A tenth of
/// the coefficient there is left.
pub fn least_fluctuation(oscillator: &Oscillator, speeds: f64) -> f64 {
    let static_friction = oscillator.parameters().static_friction;
    let fastest = speeds * (oscillator.belt_velocity() + static_friction);
    // A linear law may end there; then the run reports that friction does not stay positive.
    -0.9 * oscillator.law().coefficient(fastest).max(0.01 * static_friction)
}

/// Probability of a larger fluctuation than the one for which [`kept_positive`] prepares.
const RARE: f64 = 1e-4;

/// The process, clipped at [`least_fluctuation`] for slips as fast as its largest fluctuation makes them.
pub fn kept_positive(oscillator: &Oscillator, model: ProcessModel) -> ProcessModel {
    let law = &model.marginal;
    let largest = model.std * (law.quantile(1.0 - RARE) - law.mean()) / law.std();
    let slowest = oscillator.belt_velocity() + oscillator.parameters().static_friction;
    let least = Some(least_fluctuation(oscillator, 1.0 + largest.max(0.0) / slowest));
    ProcessModel { least, ..model }
}
