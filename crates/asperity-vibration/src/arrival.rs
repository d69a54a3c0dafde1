//! First zero of the relative velocity in a slip ("arrival").
//!
//! Without forcing, A = W′ and B = base − κW obey A′ = pA + B, B′ = −κA with p = dW′/dW at fixed e. The angle of
//! (A, B/√κ) turns by at most √κ + |p|/2 per unit of time and crosses the zeros of A only clockwise. At a maximum of W,
//! B ≤ 0 and W ≥ base/κ. So for W ≥ 0 a maximum is at least a quarter turn away from W = base/κ. Three cases follow:
//!
//! - A rising W does not arrive within a quarter turn. If it starts at W ≤ base/κ, it does not arrive within half a turn.
//! - A falling W that is negative after at most a quarter turn has arrived exactly once.
//! - A falling W that is positive and still falls after at most a quarter turn has not arrived.
//!
//! A minimum inside such an interval is the remaining case; [`polynomial::first_zero`] decides it by coefficient bounds.

use std::f64::consts::FRAC_PI_2;

use super::polynomial;
use super::series::Series;
use super::weakening::{Loading, Weakening};

/// Fraction of the turning time that is used, as a margin for rounding.
const MARGIN: f64 = 1.0 - 1e-9;
/// Relative size of Halley's correction, in units of the time in which W′ changes, whose cube is below rounding.
const SMALL: f64 = 3e-6;

/// Number of arrivals in an interval, as far as known.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Arrivals {
    None,
    One,
    Unknown,
}

/// Bound on the turning of (A, B) during a step.
#[derive(Debug, Clone, Copy)]
pub(super) struct Turning {
    /// Lower bound of the time of a quarter turn; zero if there is no bound.
    quarter: f64,
    kappa: f64,
    base: f64,
}

/// End of a step of slip.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Reached {
    pub(super) t: f64,
    pub(super) arrived: bool,
    /// W and e at the end, if known.
    pub(super) state: Option<(f64, f64)>,
}

/// State at a time inside a step.
#[derive(Debug, Clone, Copy)]
struct Passed {
    t: f64,
    w: f64,
    /// W′.
    a: f64,
    e: f64,
}

impl Passed {
    /// Returns the time at which W = 0 on a cubic t(W) through both states with their slopes.
    fn inverse_cubic(&self, to: &Self) -> f64 {
        let (height, span) = (to.w - self.w, to.t - self.t);
        let fraction = -self.w / height;
        // Deviations of the slopes from the slope of the chord.
        let (first, last) = (height / self.a - span, height / to.a - span);
        let rest = 1.0 - fraction;
        self.t + fraction * span + fraction * rest * (rest * first - fraction * last)
    }
}

impl Turning {
    #[inline]
    pub(super) fn new(weakening: &Weakening, loading: &Loading) -> Self {
        let Loading { kappa, base, swing, .. } = *loading;
        let known = swing == 0.0 && base > 0.0;
        let quarter = match weakening.steepest() {
            Some(steepest) if known && kappa > 0.0 => MARGIN * FRAC_PI_2 / (kappa.sqrt() + 0.5 * steepest),
            Some(_) if known => f64::INFINITY,
            _ => 0.0,
        };
        Self { quarter, kappa, base }
    }

    /// Returns whether W has at most one extremum in a step of this length: two extrema are half a turn apart.
    #[inline]
    pub(super) fn is_simple(&self, h: f64) -> bool {
        h <= 2.0 * self.quarter
    }

    /// Returns a time during which a slip at (W, W′) certainly does not arrive.
    #[inline]
    pub(super) fn safe(&self, w: f64, a: f64) -> f64 {
        if a < 0.0 {
            0.0
        } else if self.kappa * w <= self.base {
            // For κ ≤ 0 this always holds, and a rising W keeps rising.
            2.0 * self.quarter
        } else {
            self.quarter
        }
    }

    /// Returns the arrivals in an interval of length h from the states (W, W′) at its ends.
    #[inline]
    fn arrivals(&self, h: f64, (w0, a0): (f64, f64), (w1, a1): (f64, f64)) -> Arrivals {
        if h <= self.safe(w0, a0) {
            Arrivals::None
        } else if h > self.quarter || w0 <= 0.0 || a0 >= 0.0 {
            Arrivals::Unknown
        } else if w1 > 0.0 {
            if a1 <= 0.0 { Arrivals::None } else { Arrivals::Unknown }
        } else if self.kappa > 0.0 {
            Arrivals::One
        } else {
            Arrivals::Unknown
        }
    }
}

impl Series {
    /// Returns whether a slip with the state (w, a) at time h has certainly not arrived before h.
    #[inline]
    pub(super) fn stays(&self, turning: &Turning, h: f64, w: f64, a: f64) -> bool {
        let [w0, a0] = self.start();
        turning.arrivals(h, (w0, a0), (w, a)) == Arrivals::None
    }

    /// Returns the end of a slip of length at most h: its first arrival, if there is one.
    #[inline]
    pub(super) fn first_arrival(&self, weakening: &Weakening, turning: &Turning, h: f64) -> Reached {
        if turning.quarter == 0.0 {
            return self.bounded(h);
        }
        let [w0, a0] = self.start();
        let mut from = Passed { t: 0.0, w: w0, a: a0, e: self.e_at_start() };
        loop {
            let safe = from.t + turning.safe(from.w, from.a);
            if safe >= h {
                return Reached { t: h, arrived: false, state: None };
            }
            let t = h.min(safe.max(from.t + turning.quarter));
            let (w, e) = self.state(t);
            let to = Passed { t, w, a: weakening.acceleration(w, e), e };
            match turning.arrivals(to.t - from.t, (from.w, from.a), (to.w, to.a)) {
                Arrivals::None if to.t == h => return Reached { t: h, arrived: false, state: Some((w, e)) },
                Arrivals::None => from = to,
                Arrivals::One => return self.arrival_between(weakening, turning, from, to),
                Arrivals::Unknown => return self.bounded(h),
            }
        }
    }

    /// Returns the first arrival found by bounds of the coefficients.
    fn bounded(&self, h: f64) -> Reached {
        let found = self.first_zero(h);
        Reached { t: found.unwrap_or(h), arrived: found.is_some(), state: None }
    }

    /// Returns the first zero of W in (0, h], found by bounds of its coefficients.
    fn first_zero(&self, h: f64) -> Option<f64> {
        self.first_crossing(0.0, 1.0, h)
    }

    /// Returns the first time in (0, h] at which ±(W − level), positive just after 0, is zero.
    pub(super) fn first_crossing(&self, level: f64, sign: f64, h: f64) -> Option<f64> {
        let mut c = [0.0; polynomial::CAPACITY];
        for (c, w) in c.iter_mut().zip(self.w()) {
            *c = sign * w;
        }
        c[0] -= sign * level;
        // At a start on the level, for example a detachment, the difference is O(t) or O(t²). The factor is divided
        // out; otherwise its zero at t = 0 would be found.
        let leading = c.iter().take(2).take_while(|c| **c == 0.0).count();
        polynomial::first_zero(&c[leading..self.w().len()], h)
    }

    /// Returns the first time in (0, h] at which W leaves (from, to), and the end it reaches. A `from` of zero is
    /// ignored.
    pub(super) fn first_exit(&self, (from, to): (f64, f64), h: f64) -> Option<(f64, f64)> {
        let up = if to.is_finite() { self.first_crossing(to, -1.0, h) } else { None };
        let down = if from > 0.0 { self.first_crossing(from, 1.0, up.unwrap_or(h)) } else { None };
        down.map(|t| (t, from)).or(up.map(|t| (t, to)))
    }

    /// Returns the only arrival between two states; W falls from the first to the second.
    ///
    /// The first guess is the inverse of W as a cubic through both ends; Halley's method refines it.
    fn arrival_between(&self, weakening: &Weakening, turning: &Turning, from: Passed, to: Passed) -> Reached {
        let (mut low, mut high) = (from.t, to.t);
        let mut next = from.inverse_cubic(&to);
        let mut last = to;
        for _ in 0..100 {
            let inside = next > low && next < high;
            let t = if inside { next } else { 0.5 * (low + high) };
            let (w, e) = self.state(t);
            last = Passed { t, w, a: weakening.acceleration(w, e), e };
            if w > 0.0 {
                low = t
            } else {
                high = t
            }
            // W″ and e′, e″ at t.
            let (e_rate, gain) = (turning.base - turning.kappa * w, weakening.slope(w));
            let bend = gain * last.a + e_rate;
            let step = -w / (last.a - 0.5 * bend * w / last.a);
            if step.abs() * (bend.abs() + (1.0 + gain.abs()) * last.a.abs()) <= SMALL * last.a.abs() {
                let e = e + step * (e_rate - 0.5 * step * turning.kappa * last.a);
                return Reached { t: (t + step).clamp(low, high), arrived: true, state: Some((0.0, e)) };
            }
            if high - low <= f64::EPSILON * high {
                break;
            }
            next = t + step;
        }
        Reached { t: high, arrived: true, state: Some((0.0, last.e)) }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Oscillator;

    #[test]
    fn an_inverse_cubic_is_exact_where_the_time_is_a_cubic_of_the_state() {
        // t(W) falls from W = 0.5 to −0.4 and is 0.3 at W = 0.
        let time = |w: f64| 0.3 - 0.7 * w - 0.2 * w * w - 0.3 * w.powi(3);
        let slope = |w: f64| 1.0 / (-0.7 - 0.4 * w - 0.9 * w * w);
        let passed = |w: f64| Passed { t: time(w), w, a: slope(w), e: 0.0 };
        assert!((passed(0.5).inverse_cubic(&passed(-0.4)) - 0.3).abs() < 1e-15);
        assert!((passed(-0.2).inverse_cubic(&passed(0.1)) - 0.3).abs() < 1e-15);
    }

    #[test]
    fn the_turning_and_the_bounds_of_coefficients_find_the_same_arrivals() {
        let rng = &mut asperity_base::random::stream(8, "test", 0);
        let mut series = Series::new();
        let (mut none, mut some, mut settled) = (0, 0, 0);
        for i in 0..30_000 {
            let g = asperity_base::random::standard_normal(rng, 8);
            let (friction, decay, damping) = ((0.5 * g[0]).exp() * 0.2, 4.0 * g[1].exp(), 0.2 * g[2].exp());
            let oscillator = Oscillator::with_stribeck(friction, decay, damping, 0.05 * g[3].exp()).unwrap();
            let weakening = Weakening::new(&oscillator);
            let (base, kappa) = (1.0 + 0.5 * g[4], 1.0 + 0.7 * g[5]);
            let loading = Loading { base, kappa, swing: 0.0, frequency: 0.0, phase: 0.0 };
            // Every third state is a detachment.
            let (w, e) = if i % 3 == 0 { (0.0, 0.0) } else { (g[6].abs(), 2.0 * g[7]) };
            series.expand(&weakening, &loading, w, e, f64::INFINITY);
            let h = series.reach(f64::INFINITY);
            let turning = Turning::new(&weakening, &loading);
            let reached = series.first_arrival(&weakening, &turning, h);
            if let Some((w, e)) = reached.state {
                let (there, excess) = series.state(reached.t);
                assert!((w - there).abs() < 1e-13 * (1.0 + e.abs()) && (e - excess).abs() < 1e-13 * (1.0 + e.abs()));
            }
            let (found, wanted) = (reached.arrived.then_some(reached.t), series.first_zero(h));
            match (found, wanted) {
                (Some(a), Some(b)) => {
                    // Rounding moves a zero by (rounding of W)/W′.
                    let (w, e) = series.state(b);
                    let slope = weakening.acceleration(w, e).abs();
                    assert!((a - b).abs() * slope < 1e-13 * (1.0 + e.abs()), "{a} and {b}, W′ = {slope:e}");
                    some += 1;
                }
                (None, None) => none += 1,
                _ => panic!("{found:?} instead of {wanted:?}: {oscillator:?} {loading:?} {w} {e}"),
            }
            if let Some(t) = wanted.or(Some(h)) {
                let (end, e) = series.state(0.99 * t);
                let stays = series.stays(&turning, 0.99 * t, end, weakening.acceleration(end, e));
                assert!(!stays || series.first_zero(0.99 * t).is_none());
                settled += u32::from(stays);
            }
        }
        assert!(none > 5000 && some > 3000 && settled > 8000, "{none} {some} {settled}");
    }
}
