//! Friction values that are raised so that friction stays positive.

use crate::Oscillator;
use asperity_process::ProcessModel;

/// Fraction of the friction values that may be clipped without being allowed explicitly: beyond it the process is no longer
/// the stated one.
pub const LARGEST_CLIPPED_FRACTION: f64 = 0.05;

/// Probability of a larger fluctuation than the one that sets the fastest slip that is expected.
const RARE: f64 = 1e-4;

/// The process, clipped where it would leave less than a tenth of the kinetic coefficient at the fastest slip that is expected.
///
/// Displacements scale with friction, so |v_rel| hardly exceeds V + μ_st + m with m the largest fluctuation. `margin` times
/// that is prepared for: 1 unless slips turned out to be faster.
pub fn kept_positive(oscillator: &Oscillator, model: ProcessModel, margin: f64) -> ProcessModel {
    let law = &model.marginal;
    let static_friction = oscillator.parameters().static_friction;
    let largest = model.std * (law.quantile(1.0 - RARE) - law.mean()) / law.std();
    let fastest = margin * (oscillator.belt_velocity() + static_friction + largest.max(0.0));
    // A linear law may end there; then the run reports that friction does not stay positive.
    let least = Some(-0.9 * oscillator.law().coefficient(fastest).max(0.01 * static_friction));
    ProcessModel { least, ..model }
}
