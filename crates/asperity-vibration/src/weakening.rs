//! Loading and friction law in the slip equation W′ = e + jump + linear·W + r(W), and the Taylor coefficients of r(W).

use super::polynomial::{RECIPROCAL, cross};
use super::{FrictionTable, Oscillator, VelocityLaw};

/// Least aVW to which the law 1/(1 + aVW) is continued; its pole lies at −1.
pub(super) const CONTINUATION: f64 = -0.5;

/// Constants of e′ during one step: base + swing·sin(phase + ηt) − κW.
#[derive(Debug, Clone, Copy)]
pub(super) struct Loading {
    pub(super) base: f64,
    pub(super) kappa: f64,
    /// ±qη/V.
    pub(super) swing: f64,
    /// η.
    pub(super) frequency: f64,
    /// ητ at the start of the step.
    pub(super) phase: f64,
}

impl Loading {
    /// Returns the constants of a step that starts later by t.
    pub(super) fn later(&self, t: f64) -> Self {
        Self { phase: self.phase + self.frequency * t, ..*self }
    }

    /// Returns e′ at the start.
    #[inline(always)]
    pub(super) fn rate(&self, w: f64) -> f64 {
        let scaled = if self.swing == 0.0 { 0.0 } else { self.swing * self.phase.sin() };
        self.base + scaled - self.kappa * w
    }
}

/// Constants of W′; r(0) = 0.
#[derive(Debug, Clone)]
pub(super) struct Weakening {
    /// (μ_st − μ_k)/V.
    pub(super) jump: f64,
    /// −2ζ, less the slope of a linear law.
    pub(super) linear: f64,
    pub(super) curve: Curve,
    /// Largest |dW′/dW| at W ≥ 0; none if unknown.
    steepest: Option<f64>,
    /// Table of a tabulated law, with V.
    table: Option<(FrictionTable, f64)>,
}

/// Nonlinear part r(W) of a law.
#[derive(Debug, Clone, Copy)]
pub(super) enum Curve {
    /// r = 0.
    Straight,
    /// r = gW/(1 + cW).
    Quotient(Quotient),
    /// r = (g/c)(1 − e^{−cW}).
    Exponential(Exponential),
    /// r is a cubic between two points of a table.
    Cubic(Cubic),
}

impl Curve {
    /// Returns g and c, zero without a nonlinear part; none for a table.
    pub(super) fn gain_and_curvature(&self) -> Option<[f64; 2]> {
        match self {
            Self::Straight => Some([0.0, 0.0]),
            Self::Quotient(q) => Some([q.gain, q.curvature]),
            Self::Exponential(x) => Some([x.gain, x.curvature]),
            Self::Cubic(_) => None,
        }
    }
}

#[derive(Debug, Clone, Copy)]
pub(super) struct Quotient {
    gain: f64,
    curvature: f64,
}

#[derive(Debug, Clone, Copy)]
pub(super) struct Exponential {
    gain: f64,
    curvature: f64,
}

#[derive(Debug, Clone, Copy)]
pub(super) struct Cubic {
    index: usize,
    /// Range `from` … `to` of W in which the cubic is valid.
    pub(super) from: f64,
    pub(super) to: f64,
    /// Coefficients in powers of W − from.
    coefficients: [f64; 4],
}

impl Weakening {
    pub(super) fn new(oscillator: &Oscillator) -> Self {
        let v = oscillator.belt_velocity();
        let jump = (oscillator.static_friction() - oscillator.law().kinetic()) / v;
        let damping = -2.0 * oscillator.damping_ratio();
        let (linear, curve) = match oscillator.law() {
            VelocityLaw::Stribeck { kinetic, decay } if *decay > 0.0 => {
                (damping, Curve::Quotient(Quotient { gain: decay * kinetic, curvature: decay * v }))
            }
            VelocityLaw::Exponential { kinetic, high_speed, stribeck_velocity } if high_speed < kinetic => {
                let gain = (kinetic - high_speed) / stribeck_velocity;
                (damping, Curve::Exponential(Exponential { gain, curvature: v / stribeck_velocity }))
            }
            VelocityLaw::Linear { slope, .. } => (damping + slope, Curve::Straight),
            VelocityLaw::Tabulated(table) => (damping, Curve::Cubic(Cubic::new(table, v, 0))),
            VelocityLaw::Stribeck { .. } | VelocityLaw::Exponential { .. } | VelocityLaw::Coulomb { .. } => {
                (damping, Curve::Straight)
            }
        };
        let steepest = curve.gain_and_curvature().map(|[gain, _]| linear.abs().max((linear + gain).abs()));
        let table = match oscillator.law() {
            VelocityLaw::Tabulated(table) => Some((table.clone(), v)),
            _ => None,
        };
        Self { jump, linear, curve, steepest, table }
    }

    /// Selects the interval of a table in which W lies, or into which it moves from a point.
    #[inline(always)]
    pub(super) fn select(&mut self, w: f64, e: f64, loading: &Loading) {
        if self.table.is_some() {
            self.select_piece(w, e, loading.rate(w));
        }
    }

    fn select_piece(&mut self, w: f64, e: f64, e_rate: f64) {
        let Some((table, v)) = &self.table else { return };
        let at_least = |index: usize| table.pieces()[index].from / v <= w;
        let mut index = if let Curve::Cubic(cubic) = &self.curve { cubic.index } else { 0 };
        while index > 0 && !at_least(index) {
            index -= 1;
        }
        while index + 1 < table.pieces().len() && at_least(index + 1) {
            index += 1;
        }
        self.curve = Curve::Cubic(Cubic::new(table, *v, index));
        let a = self.acceleration(w, e);
        // At W′ = 0 the law does not contribute to W″.
        let falls = a < 0.0 || (a == 0.0 && e_rate < 0.0);
        if index > 0 && falls && table.pieces()[index].from / v == w {
            self.curve = Curve::Cubic(Cubic::new(table, *v, index - 1));
        }
    }

    /// Returns the bounds of W of the present curve, if there are any.
    #[inline(always)]
    pub(super) fn bounds(&self) -> Option<(f64, f64)> {
        if let Curve::Cubic(cubic) = &self.curve { Some((cubic.from, cubic.to)) } else { None }
    }

    /// Returns the argument cW of a law continued below W = 0; the pole of 1/(1 + cW) lies at −1.
    pub(super) fn curvature_of(&self, w: f64) -> f64 {
        match &self.curve {
            Curve::Straight => 0.0,
            Curve::Quotient(q) => q.curvature * w,
            Curve::Exponential(x) => x.curvature * w,
            Curve::Cubic(c) => w / c.to,
        }
    }

    /// Returns the rate c of a law with e^{−cW}; 0 for other laws.
    #[inline(always)]
    pub(super) fn decay(&self) -> f64 {
        if let Curve::Exponential(x) = &self.curve { x.curvature } else { 0.0 }
    }

    /// Returns W′.
    #[inline(always)]
    pub(super) fn acceleration(&self, w: f64, e: f64) -> f64 {
        let r = match &self.curve {
            Curve::Straight => 0.0,
            Curve::Quotient(q) => q.gain * w / (1.0 + q.curvature * w),
            Curve::Exponential(x) => x.value(w),
            Curve::Cubic(c) => c.derivatives(w)[0],
        };
        e + self.jump + self.linear * w + r
    }

    /// Returns dW′/dW at fixed e.
    #[inline]
    pub(super) fn slope(&self, w: f64) -> f64 {
        let slope = match &self.curve {
            Curve::Straight => 0.0,
            Curve::Quotient(q) => {
                let inverse = 1.0 / (1.0 + q.curvature * w);
                q.gain * inverse * inverse
            }
            Curve::Exponential(x) => x.gain * (-x.curvature * w).exp(),
            Curve::Cubic(c) => c.derivatives(w)[1],
        };
        self.linear + slope
    }

    /// Returns whether a motion without forcing and fluctuation at W ≥ 0 and the rate W′ ends in steady sliding without
    /// crossing W = 1. Under strong damping this saves the many short steps to steady sliding.
    ///
    /// With the distance u = |W − 1|, u″ = −u − c·u′, and c ≥ 2 all the way, no motion leaves −u ≤ u′ ≤ 0: on u′ = −u,
    /// (u′ + u)′ = (c − 2)u ≥ 0, and on u′ = 0, u″ < 0.
    pub(super) fn creeps(&self, w: f64, rate: f64) -> bool {
        let (distance, approach) = ((w - 1.0).abs(), (1.0 - w).signum() * rate);
        // dW′/dW = −c falls with W, except for a table.
        let largest_slope = || match &self.table {
            Some((table, _)) => self.linear + table.steepest(),
            None => self.slope(w.min(1.0)),
        };
        self.linear <= -2.0 && (0.0..=distance).contains(&approach) && largest_slope() <= -2.0
    }

    /// Returns the largest |dW′/dW| at W ≥ 0; none if unknown.
    #[inline(always)]
    pub(super) fn steepest(&self) -> Option<f64> {
        self.steepest
    }
}

impl Exponential {
    fn value(&self, w: f64) -> f64 {
        -(self.gain / self.curvature) * (-self.curvature * w).exp_m1()
    }
}

impl Cubic {
    /// Creates (μ_k − μ(VW))/V in an interval of a table.
    fn new(table: &FrictionTable, v: f64, index: usize) -> Self {
        let piece = &table.pieces()[index];
        let to = table.pieces().get(index + 1).map_or(f64::INFINITY, |next| next.from / v);
        let [y, b, c, d] = piece.coefficients;
        Self { index, from: piece.from / v, to, coefficients: [(table.kinetic() - y) / v, -b, -c * v, -d * v * v] }
    }

    /// Returns r, r′, r″/2, r‴/6.
    #[inline(always)]
    fn derivatives(&self, w: f64) -> [f64; 4] {
        let [a, b, c, d] = self.coefficients;
        let x = w - self.from;
        [a + x * (b + x * (c + x * d)), b + x * (2.0 * c + x * 3.0 * d), c + 3.0 * d * x, d]
    }
}

/// Taylor coefficients of r(W(t)) from those of W(t), order by order.
pub(super) trait Recurrence<const N: usize> {
    /// Returns dr/dW at the start.
    fn slope(&self) -> f64;

    /// Returns r_n − slope·w_n, for n = 1, 2, … in turn; w is known up to n.
    fn rest(&mut self, w: &[f64; N], n: usize) -> f64;
}

/// Coefficients of a law without nonlinear part.
pub(super) struct NoTerms;

impl<const N: usize> Recurrence<N> for NoTerms {
    #[inline(always)]
    fn slope(&self) -> f64 {
        0.0
    }

    #[inline(always)]
    fn rest(&mut self, _: &[f64; N], _: usize) -> f64 {
        0.0
    }
}

/// Coefficients of a quotient: r(1 + cW) = gW gives r_n = slope·w_n − c′·Σ w_k r_{n−k} over 0 < k < n, with c′ = c/(1 +
/// cW_0).
pub(super) struct QuotientTerms<const N: usize> {
    slope: f64,
    curvature: f64,
    r: [f64; N],
    /// −c′·w_k.
    damped: [f64; N],
}

impl<const N: usize> QuotientTerms<N> {
    #[inline(always)]
    pub(super) fn new(quotient: &Quotient, w0: f64) -> Self {
        let inverse = 1.0 / (1.0 + quotient.curvature * w0);
        Self {
            slope: quotient.gain * inverse * inverse,
            curvature: quotient.curvature * inverse,
            r: [0.0; N],
            damped: [0.0; N],
        }
    }
}

impl<const N: usize> Recurrence<N> for QuotientTerms<N> {
    #[inline(always)]
    fn slope(&self) -> f64 {
        self.slope
    }

    #[inline(always)]
    fn rest(&mut self, w: &[f64; N], n: usize) -> f64 {
        let rest = cross(&self.damped, &self.r, n);
        self.r[n] = self.slope * w[n] + rest;
        self.damped[n] = -self.curvature * w[n];
        rest
    }
}

/// Coefficients of an exponential: r′ = cW′(g/c − r) gives n·r_n = n·slope·w_n − c·Σ k·w_k r_{n−k} over 0 < k < n, with
/// slope = g − c·r_0.
pub(super) struct ExponentialTerms<const N: usize> {
    slope: f64,
    curvature: f64,
    r: [f64; N],
    /// −c·k·w_k.
    rates: [f64; N],
}

impl<const N: usize> ExponentialTerms<N> {
    #[inline(always)]
    pub(super) fn new(exponential: &Exponential, w0: f64) -> Self {
        let Exponential { gain, curvature } = *exponential;
        Self { slope: gain * (-curvature * w0).exp(), curvature, r: [0.0; N], rates: [0.0; N] }
    }
}

impl<const N: usize> Recurrence<N> for ExponentialTerms<N> {
    #[inline(always)]
    fn slope(&self) -> f64 {
        self.slope
    }

    #[inline(always)]
    fn rest(&mut self, w: &[f64; N], n: usize) -> f64 {
        let rest = cross(&self.rates, &self.r, n) * RECIPROCAL[n];
        self.rates[n] = -self.curvature * (n as f64 * w[n]);
        self.r[n] = self.slope * w[n] + rest;
        rest
    }
}

/// Coefficients of a cubic: r = r_0 + r′u + (r″/2)u² + (r‴/6)u³ with u = W − W_0.
pub(super) struct CubicTerms<const N: usize> {
    derivatives: [f64; 4],
    /// u².
    square: [f64; N],
}

impl<const N: usize> CubicTerms<N> {
    #[inline(always)]
    pub(super) fn new(cubic: &Cubic, w0: f64) -> Self {
        Self { derivatives: cubic.derivatives(w0), square: [0.0; N] }
    }
}

impl<const N: usize> Recurrence<N> for CubicTerms<N> {
    #[inline(always)]
    fn slope(&self) -> f64 {
        self.derivatives[1]
    }

    #[inline(always)]
    fn rest(&mut self, w: &[f64; N], n: usize) -> f64 {
        self.square[n] = cross(w, w, n);
        self.derivatives[2] * self.square[n] + self.derivatives[3] * cross(w, &self.square, n)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Parameters;
    use asperity_base::random;

    #[test]
    fn an_orbit_that_creeps_never_reaches_the_section() {
        let rng = &mut random::stream(31, "test", 0);
        let mut counts = [0, 0];
        for i in 0..300 {
            let g = random::standard_normal(rng, 6);
            let (kinetic, reach) = (0.3 * g[0].exp(), 0.1 * g[1].exp());
            let wave = |v: f64| kinetic * (1.5 + f64::cos(v / reach));
            let points: Vec<_> = (0..20).map(|i| 0.7 * reach * f64::from(i)).map(|v| [v, wave(v)]).collect();
            let law = match i % 3 {
                0 => VelocityLaw::Stribeck { kinetic, decay: 1.0 / reach },
                1 => VelocityLaw::Exponential { kinetic, high_speed: 0.3 * kinetic, stribeck_velocity: reach },
                _ => VelocityLaw::Tabulated(FrictionTable::new(&points).unwrap()),
            };
            let (belt_velocity, damping_ratio) = (reach * g[2].exp(), 1.0 + g[3].abs());
            let static_friction = 3.0 * kinetic;
            let parameters =
                Parameters { static_friction, law: law.clone(), damping_ratio, belt_velocity, forcing: None };
            let weakening = Weakening::new(&Oscillator::new(parameters).unwrap());
            // A start in the wedge −u ≤ u′ ≤ 0, on either side of the section W = 1.
            let side = if g[4] > 0.0 { 1.0 } else { -1.0 };
            let u = if side > 0.0 { g[4] } else { (-g[4]).min(1.0) };
            let mut state = [u, -u * g[5].abs().fract()];
            let creeps = weakening.creeps(1.0 + side * u, side * state[1]);
            counts[usize::from(creeps)] += 1;
            // Classical Runge–Kutta method.
            let rate = |[u, v]: [f64; 2]| {
                let weakening = law.weakening(belt_velocity * (1.0 + side * u));
                [v, -u - (2.0 * damping_ratio - weakening) * v]
            };
            let along = |[u, v]: [f64; 2], [du, dv]: [f64; 2], h: f64| [u + h * du, v + h * dv];
            let h = 0.02 / damping_ratio;
            while creeps && state[0] > 1e-4 * u {
                let k1 = rate(state);
                let k2 = rate(along(state, k1, 0.5 * h));
                let k3 = rate(along(state, k2, 0.5 * h));
                let k4 = rate(along(state, k3, h));
                let mean = |i: usize| (k1[i] + 2.0 * (k2[i] + k3[i]) + k4[i]) / 6.0;
                state = along(state, [mean(0), mean(1)], h);
                assert!(-state[0] <= state[1] && state[1] <= 0.0, "{state:?} of {weakening:?}");
            }
        }
        assert!(counts.iter().all(|&n| n > 60), "{counts:?}");
        // Just outside the wedge an orbit of Coulomb friction crosses: u′ = −1.1u at critical damping, and u′ > 0 turns.
        let law = VelocityLaw::Coulomb { kinetic: 0.3 };
        let parameters =
            Parameters { static_friction: 0.3, law, damping_ratio: 1.0, belt_velocity: 1.0, forcing: None };
        let weakening = Weakening::new(&Oscillator::new(parameters).unwrap());
        assert_eq!([-1.1, -1.0, 0.0, 0.1].map(|rate| weakening.creeps(2.0, rate)), [false, true, true, false]);
    }
}
