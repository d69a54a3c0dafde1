//! Slip orbit that touches the belt velocity, and its derivatives.

use std::f64::consts::TAU;

use super::super::scaled_forcing::ScaledForcing;
use super::super::slip_orbit::{Minimum, first_minimum, first_minimum_from};
use super::super::{Oscillator, VibrationError};
use super::tangent::Linear;
use asperity_base::numeric::try_root_between;

/// Least W of the slip orbit from a detachment, with derivatives with respect to ζ and to the time of the detachment.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Graze {
    pub(crate) minimum: Minimum,
    /// ∂W_min/∂(ζ, τ).
    pub(crate) w_by: [f64; 2],
    /// ∂(time of the minimum)/∂(ζ, τ).
    pub(crate) time_by: [f64; 2],
}

/// Returns the first minimum of W after a detachment at the time τ, with derivatives; none if the orbit has no minimum.
///
/// For an orbit that was stopped below zero, the derivatives refer to its end at that time.
pub(crate) fn graze(oscillator: &Oscillator, tau: f64) -> Result<Option<Graze>, VibrationError> {
    let linear = Linear(oscillator);
    let scaled = ScaledForcing::new(oscillator);
    let angular = scaled.amplitude * scaled.frequency * scaled.frequency;
    let mut tangents = [[0.0; 2]; 2];
    let minimum = first_minimum_from(oscillator, tau, 0.0, |step, time| {
        linear.carry(step, &mut tangents, |t, w| {
            [[-2.0 * w, 0.0], [0.0, angular * (scaled.frequency * (tau + time + t)).cos()]]
        });
    })?;
    Ok(minimum.map(|minimum| {
        // W′ = 0 there, so W″ = e′, and the time moves by −δ(W′)/W″.
        let curvature = 1.0 - minimum.w + scaled.rate(tau + minimum.time);
        let gain = linear.gain(minimum.w);
        let time = |[w, e]: [f64; 2], source: f64| -(e + gain * w + source) / curvature;
        let time_by = [time(tangents[0], -2.0 * minimum.w), time(tangents[1], 0.0)];
        Graze { minimum, w_by: [tangents[0][0], tangents[1][0]], time_by }
    }))
}

/// Returns the damping ratio at which the slip orbit of a detachment at the time τ touches the belt velocity.
///
/// `guess` > 0 is the start of the search and `most` its end. Returns none if the orbit of the undamped oscillator does
/// not reach the belt velocity, or if all orbits up to `most` do.
pub(crate) fn grazing_damping(
    oscillator: &Oscillator,
    tau: f64,
    guess: f64,
    most: f64,
) -> Result<Option<f64>, VibrationError> {
    // An orbit without a minimum does not reach the belt velocity.
    let least = |damping: f64| -> Result<f64, VibrationError> {
        Ok(first_minimum(&oscillator.with_damping(damping)?, tau)?.map_or(1.0, |minimum| minimum.w))
    };
    let mut near = [guess, least(guess)?];
    if near[1] == 0.0 {
        return Ok(Some(guess));
    }
    // An orbit of one turn ends higher by some 2π per damping ratio. A longer step passes the root of a good guess.
    let mut step = 1.2 * near[1].abs() / TAU;
    while if near[1] > 0.0 { near[0] > 0.0 } else { near[0] < most } {
        let damping = if near[1] > 0.0 { (near[0] - step).max(0.0) } else { (near[0] + step).min(most) };
        let next = [damping, least(damping)?];
        if near[1] <= 0.0 && next[1] > 0.0 || near[1] > 0.0 && next[1] < 0.0 {
            return try_root_between(least, near, next, 0.0);
        }
        step *= 2.0;
        near = next;
    }
    Ok(None)
}
