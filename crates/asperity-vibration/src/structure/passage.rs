//! Motion from one detachment to the next under a harmonic force, with the derivative of its times.
//!
//! Every detachment into slip is the state (W, e) = (0, 0), so the motion with stick is a map τ → P(τ) from the time of
//! a detachment to the time of the next. Its derivative follows the tangent through slip. At an event whose time t
//! moves by δt, a tangent at fixed time gains (rate before − rate after)·δt.

use std::f64::consts::TAU;

use super::super::cycle::Turn;
use super::super::motion::{Motion, SlipState};
use super::super::scaled_forcing::ScaledForcing;
use super::super::weakening::Weakening;
use super::super::{EventKind, Oscillator, Phase, VibrationError};
use super::tangent::{Linear, Tangent};
use asperity_process::Steady;

/// Number of forcing periods of slip after which a mass counts as sliding.
const MAX_PERIODS: f64 = 30.0;
const MAX_STEPS: usize = 200_000;

/// Motion to the next detachment into slip.
#[derive(Debug, Clone)]
pub(super) struct Passage {
    /// P(τ).
    pub(super) tau: f64,
    /// dP/dτ.
    pub(super) slope: f64,
    /// One turn for each detachment, into slip or over-slip.
    pub(super) turns: Vec<Turn>,
}

/// Returns the passage from a detachment into slip at the time τ. Returns none if the force does not let the mass slip
/// then, or if the mass does not stick within 30 forcing periods.
pub(super) fn passage(oscillator: &Oscillator, tau: f64) -> Result<Option<Passage>, VibrationError> {
    let Some(forcing) = oscillator.forcing() else {
        return Err(VibrationError::NotFound { what: "passage", reason: "the oscillator has no forcing" });
    };
    let (weakening, scaled, linear) = (Weakening::new(oscillator), ScaledForcing::new(oscillator), Linear(oscillator));
    // Growth rate of the forward excess at W = 0.
    let rate = |tau: f64| 1.0 + scaled.rate(tau);
    if rate(tau) <= 0.0 {
        return Ok(None);
    }
    let end = tau + MAX_PERIODS * TAU / forcing.frequency;
    let mut motion = Motion::from_slip(oscillator, Steady, SlipState::detached(tau))?;
    // A later detachment means an earlier state at each time.
    let mut tangent: Tangent = [-weakening.jump, -rate(tau)];
    let (mut turn, mut turns, mut begun, mut slides_since) = (Turn::EMPTY, Vec::new(), tau, tau);
    for _ in 0..MAX_STEPS {
        let direction = motion.slip_state().map_or(1.0, |state| state.phase.direction());
        let event = motion.step(end)?;
        turn.include(&motion);
        let mut excess = 0.0;
        if let Some(step) = motion.slip_step() {
            let mut carried = [tangent];
            linear.carry(step, &mut carried, |_, _| [[0.0; 2]]);
            [tangent] = carried;
            excess = step.series.state(step.length).1;
        }
        let now = motion.tau;
        match event.map(|e| e.kind) {
            Some(kind @ (EventKind::Restick | EventKind::Reverse)) => {
                let delay = -tangent[0] / weakening.acceleration(0.0, excess);
                // Forward excess at the event as its time moves.
                let forward = direction * (tangent[1] + direction * rate(now) * delay);
                tangent = if kind == EventKind::Restick {
                    turn.slip += now - slides_since;
                    turn.reattachment = Some(motion.displacement());
                    [0.0, forward - rate(now) * delay]
                } else {
                    let after = motion.slip_state().map_or(0.0, |state| state.e);
                    let rates = [weakening.acceleration(0.0, after), -direction * rate(now)];
                    [-rates[0] * delay, -direction * forward - rates[1] * delay]
                };
            }
            Some(EventKind::Detach) => {
                let delay = -tangent[1] / rate(now);
                turn.duration = now - begun;
                turns.push(turn);
                if motion.slip_state().is_some_and(|state| state.phase == Phase::Slip) {
                    return Ok(Some(Passage { tau: now, slope: delay, turns }));
                }
                tangent = [-weakening.jump * delay, rate(now) * delay];
                (turn, begun, slides_since) = (Turn::EMPTY, now, now);
            }
            None if now >= end => return Ok(None),
            None => {}
        }
    }
    Err(VibrationError::NotFound { what: "passage", reason: "a slip phase needs more than 200,000 steps" })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::law::{self, Coulomb, Stribeck};
    use crate::{Forcing, Parameters, VelocityLaw};

    /// Returns dP/dτ by fourth-order differences.
    fn difference(oscillator: &Oscillator, tau: f64) -> f64 {
        let h = 1e-4;
        let at = |step: f64| passage(oscillator, tau + step * h).unwrap().unwrap().tau;
        (8.0 * (at(1.0) - at(-1.0)) - (at(2.0) - at(-2.0))) / (12.0 * h)
    }

    #[test]
    fn the_derivative_passes_through_stick_over_slip_and_reversals() {
        let stribeck = VelocityLaw::Stribeck(Stribeck { kinetic: 0.09, decay: 3.0 });
        let (mut several, mut count) = (0, 0);
        for (law, amplitude, frequency) in [
            (stribeck.clone(), 0.01, 0.98),
            (stribeck.clone(), 0.15, 0.5),
            (stribeck, 0.4, 0.6),
            (VelocityLaw::Stribeck(Stribeck { kinetic: 0.1, decay: 3.0 }), 0.4, 0.6),
            (VelocityLaw::Coulomb(Coulomb { kinetic: 0.08 }), 0.3, 0.3),
            (VelocityLaw::Linear(law::Linear { kinetic: 0.1, slope: 0.05 }), 0.2, 1.4),
        ] {
            let oscillator = Oscillator::new(Parameters {
                static_friction: 0.1,
                law,
                damping_ratio: 0.1,
                belt_velocity: 0.05,
                forcing: Some(Forcing { amplitude, frequency }),
            })
            .unwrap();
            for i in 0..12 {
                let tau = TAU / frequency * (f64::from(i) + 0.3) / 12.0;
                let Some(found) = passage(&oscillator, tau).unwrap() else { continue };
                let wanted = difference(&oscillator, tau);
                assert!((found.slope - wanted).abs() < 1e-8 * wanted.abs().max(1.0), "{} {wanted}", found.slope);
                several += usize::from(found.turns.len() > 1);
                count += 1;
            }
        }
        assert!(count > 30 && several > 5, "{count} passages, {several} with over-slip");
    }
}
