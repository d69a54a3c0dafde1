//! Return map of slip without forcing on the section X′ = 0, that is W = 1.
//!
//! Orbits cross the section upwards (W′ > 0, at the largest X) at e = e₀ + r, r > 0, with e₀ the excess in steady
//! sliding, and W′ = r there. The derivative of the map r → P(r) is (r/P)·exp ∫g, with g the divergence of the flow.

use super::super::polynomial;
use super::super::series::Series;
use super::super::weakening::{Loading, Weakening};
use super::super::{Oscillator, VibrationError};
use super::tangent::{Linear, Step};

const FREE: Loading = Loading { base: 1.0, kappa: 1.0, swing: 0.0, frequency: 0.0, phase: 0.0 };
/// Distance to steady sliding, relative to the start, below which an orbit counts as settled.
const SETTLED: f64 = 1e-9;
const MAX_STEPS: usize = 100_000;

/// Slip without forcing.
pub(super) struct Planar {
    oscillator: Oscillator,
    weakening: Weakening,
    /// e₀.
    pub(super) rest: f64,
}

/// Orbit between two upward crossings of the section.
#[derive(Debug, Clone, Copy)]
pub(super) struct Lap {
    /// P(r).
    pub(super) back: f64,
    pub(super) time: f64,
    /// ∫g.
    pub(super) stretch: f64,
    /// e − e₀ at the downward crossing, < 0.
    pub(super) lowest: f64,
    /// Largest and least W.
    pub(super) fastest: f64,
    pub(super) slowest: f64,
}

/// Outcome of an orbit that starts on the section.
#[derive(Debug, Clone, Copy)]
pub(super) enum Turn {
    Back(Lap),
    /// The orbit reaches the belt velocity first.
    Touches,
    /// The orbit ends in steady sliding without a return.
    Settles,
}

/// Outcome of an orbit on one side of the section.
enum Half {
    Crosses { excess: f64, time: f64, stretch: f64, extreme: f64 },
    Touches,
    Settles,
}

impl Planar {
    /// Creates the return map of an oscillator, ignoring its forcing.
    pub(super) fn new(oscillator: &Oscillator) -> Result<Self, VibrationError> {
        let oscillator = oscillator.with_forcing(None)?;
        let mut weakening = Weakening::new(&oscillator);
        weakening.select(1.0, 0.0, &FREE);
        let rest = -weakening.acceleration(1.0, 0.0);
        Ok(Self { oscillator, weakening, rest })
    }

    /// Returns the amplitude at which the orbit from a detachment crosses the section; none if it ends in rest below
    /// it.
    pub(super) fn detachment(&self) -> Result<Option<f64>, VibrationError> {
        Ok(match self.half(0.0, 0.0)? {
            Half::Crosses { excess, .. } => Some(excess),
            Half::Touches | Half::Settles => None,
        })
    }

    /// Follows one turn from r > 0.
    pub(super) fn turn(&self, r: f64) -> Result<Turn, VibrationError> {
        let (lowest, above, stretch, fastest) = match self.half(1.0, r)? {
            Half::Crosses { excess, time, stretch, extreme } => (excess, time, stretch, extreme),
            Half::Touches => return Ok(Turn::Touches),
            Half::Settles => return Ok(Turn::Settles),
        };
        Ok(match self.half(1.0, lowest)? {
            Half::Crosses { excess, time, stretch: below, extreme } => Turn::Back(Lap {
                back: excess,
                time: above + time,
                stretch: stretch + below,
                lowest,
                fastest,
                slowest: extreme,
            }),
            Half::Touches => Turn::Touches,
            Half::Settles => Turn::Settles,
        })
    }

    /// Follows (W, e₀ + excess) to the section; from W = 1 the sign of the excess determines the side.
    fn half(&self, w: f64, excess: f64) -> Result<Half, VibrationError> {
        let linear = Linear(&self.oscillator);
        let side = if w == 1.0 && excess > 0.0 { 1.0 } else { -1.0 };
        let size = f64::max((w - 1.0).abs(), excess.abs());
        let mut series = Series::new();
        let (mut w, mut e) = (w, if w == 0.0 { 0.0 } else { self.rest + excess });
        let (mut time, mut stretch, mut extreme) = (0.0, 0.0, w);
        let mut fresh = w == 1.0;
        let mut weakening = self.weakening.clone();
        for _ in 0..MAX_STEPS {
            weakening.select(w, e, &FREE);
            series.expand(&weakening, &FREE, w, e, f64::INFINITY);
            let mut h = series.reach(f64::INFINITY);
            let exit = weakening.bounds().and_then(|bounds| series.first_exit(bounds, h));
            if let Some((t, _)) = exit {
                h = t;
            }
            if h == f64::INFINITY {
                // Steady sliding itself, to rounding.
                return Ok(Half::Settles);
            }
            let mut beyond = polynomial::derivative(&[0.0]);
            let n = series.w().len();
            beyond[..n].copy_from_slice(series.w());
            beyond[0] = if fresh { 0.0 } else { beyond[0] - 1.0 };
            beyond.iter_mut().for_each(|c| *c *= side);
            let crossing = polynomial::first_zero(&beyond[usize::from(fresh)..n], h);
            let length = crossing.unwrap_or(h);
            if side < 0.0 && series.first_crossing(0.0, 1.0, length).is_some() {
                return Ok(Half::Touches);
            }
            if side * weakening.acceleration(w, e) >= 0.0
                && let Some(t) = series.first_extremum(length)
            {
                extreme = series.state(t).0;
            }
            stretch += linear.stretch(Step { series: &series, length });
            time += length;
            (w, e) = series.state(length);
            if crossing.is_some() {
                return Ok(Half::Crosses { excess: e - self.rest, time, stretch, extreme });
            }
            if let Some((_, level)) = exit {
                w = level;
            }
            fresh = false;
            let rate = weakening.acceleration(w, e);
            let settled = (w - 1.0).abs() < SETTLED * size && rate.abs() < SETTLED * size;
            if settled || weakening.creeps(w, rate) {
                return Ok(Half::Settles);
            }
        }
        Err(VibrationError::NotFound { what: "turn of a slip orbit", reason: "none within a hundred thousand steps" })
    }
}
