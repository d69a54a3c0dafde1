//! Clipping of the friction process so that friction stays positive.

use crate::Oscillator;
use asperity_base::sentence;
use asperity_process::ProcessModel;
use thiserror::Error;

/// Largest fraction of the friction values that may be clipped without explicit permission. Above it the process
/// differs too much from the stated one.
const LARGEST_CLIPPED_FRACTION: f64 = 0.05;

/// More of the friction values would be clipped than 5 %.
#[derive(Debug, Clone, Copy, PartialEq, Error)]
#[error(
    "{} % of the friction values would be clipped to stay positive, more than {} %",
    sentence::digits(100.0 * .0),
    100.0 * LARGEST_CLIPPED_FRACTION
)]
pub struct TooManyClipped(pub f64);

/// Fails if more of the friction values are clipped than 5 %, unless that is `allowed`.
pub fn accept_clipping(fraction: f64, allowed: bool) -> Result<(), TooManyClipped> {
    if fraction > LARGEST_CLIPPED_FRACTION && !allowed { Err(TooManyClipped(fraction)) } else { Ok(()) }
}

/// Probability of exceeding the fluctuation from which the fastest expected slip is computed.
const EXCEEDANCE: f64 = 1e-4;

/// Returns the process, clipped so that at least a tenth of the kinetic coefficient remains at the fastest expected
/// slip.
///
/// Displacements scale with friction, so |v_rel| rarely exceeds V + μ_st + m, with m the largest fluctuation. The
/// expected speed is `margin` times this value; `margin` is 1 unless slips turned out to be faster.
pub fn clipped_to_positive(oscillator: &Oscillator, model: ProcessModel, margin: f64) -> ProcessModel {
    let marginal = &model.marginal;
    let static_friction = oscillator.parameters().static_friction;
    let largest = model.std * (marginal.quantile(1.0 - EXCEEDANCE) - marginal.mean()) / marginal.std();
    let fastest = margin * (oscillator.belt_velocity() + static_friction + largest.max(0.0));
    // A linear law may fall to zero at this speed; the run then reports that friction does not stay positive.
    let least = Some(-0.9 * oscillator.law().coefficient(fastest).max(0.01 * static_friction));
    ProcessModel { least, ..model }
}
