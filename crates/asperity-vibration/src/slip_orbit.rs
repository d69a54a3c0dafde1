//! Slip orbit from a detachment, continued smoothly past the belt velocity.

use super::scaled_forcing::ScaledForcing;
use super::series::Series;
use super::structure::tangent::Step;
use super::weakening::{CONTINUATION, Loading, Weakening};
use super::{Oscillator, VibrationError};

/// Distance of W and W′ from steady sliding below which the orbit has no further minimum near zero.
const SETTLED: f64 = 1e-6;
const MAX_STEPS: usize = 1_000_000;

/// First minimum of W on a slip orbit.
#[derive(Debug, Clone, Copy)]
pub(super) struct Minimum {
    /// Time since the detachment.
    pub(super) time: f64,
    /// Least W; negative if the orbit reaches the belt velocity before.
    pub(super) w: f64,
}

/// Returns the first minimum of W after a detachment at the time τ; none if the orbit ends in rest without a minimum.
///
/// An orbit that falls far below zero is stopped; its value is then negative, but not a minimum.
pub(super) fn first_minimum(oscillator: &Oscillator, tau: f64) -> Result<Option<Minimum>, VibrationError> {
    first_minimum_from(oscillator, tau, 0.0, |_, _| {})
}

/// Returns the first minimum of an orbit from (W, e) = (0, e) that rises; `visit` receives each step and the time since
/// the start before it.
pub(super) fn first_minimum_from(
    oscillator: &Oscillator,
    tau: f64,
    excess: f64,
    mut visit: impl FnMut(Step, f64),
) -> Result<Option<Minimum>, VibrationError> {
    let mut weakening = Weakening::new(oscillator);
    let scaled = ScaledForcing::new(oscillator);
    let mut series = Series::new();
    let (mut w, mut e, mut time) = (0.0, excess, 0.0);
    let mut falling = false;
    for _ in 0..MAX_STEPS {
        let loading = Loading {
            base: 1.0,
            kappa: 1.0,
            swing: scaled.amplitude * scaled.frequency,
            frequency: scaled.frequency,
            phase: scaled.frequency * (tau + time),
        };
        weakening.select(w, e, &loading);
        series.expand(&weakening, &loading, w, e, f64::INFINITY);
        let mut h = series.reach(f64::INFINITY);
        let exit = weakening.bounds().and_then(|bounds| series.first_exit(bounds, h));
        if let Some((t, _)) = exit {
            h = t;
        }
        if falling && let Some(t) = series.first_extremum(h) {
            visit(Step { series: &series, length: t }, time);
            return Ok(Some(Minimum { time: time + t, w: series.state(t).0 }));
        }
        visit(Step { series: &series, length: h }, time);
        (w, e) = series.state(h);
        if let Some((_, level)) = exit {
            w = level;
        }
        time += h;
        let acceleration = weakening.acceleration(w, e);
        if falling && weakening.curvature_of(w) < CONTINUATION {
            return Ok(Some(Minimum { time, w }));
        }
        falling = acceleration < 0.0;
        let settled = (w - 1.0).abs() < SETTLED && acceleration.abs() < SETTLED;
        if scaled.amplitude == 0.0 && (settled || weakening.creeps(w, acceleration)) {
            return Ok(None);
        }
    }
    Err(VibrationError::NotFound { what: "turning point of the slip orbit", reason: "none within a million steps" })
}
