//! Loading and friction law in the slip equation W′ = e + jump + linear·W + r(W).

use super::law::curve::CurveShape;
use super::law::{Curve, with_curve};
use super::{FrictionTable, Oscillator};

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
    /// Upper bound of dW′/dW; none if it falls with W.
    largest_slope: Option<f64>,
    /// Table of a tabulated law, with V.
    table: Option<(FrictionTable, f64)>,
}

impl Weakening {
    pub(super) fn new(oscillator: &Oscillator) -> Self {
        let v = oscillator.belt_velocity();
        let jump = (oscillator.static_friction() - oscillator.law().kinetic()) / v;
        let damping = -2.0 * oscillator.damping_ratio();
        let linear = damping + oscillator.law().linear_part();
        let gain = oscillator.law().batch_form(v).map(|form| form.gain);
        let steepest = gain.map(|gain| linear.abs().max((linear + gain).abs()));
        let largest_slope = (!oscillator.law().has_convex_fall()).then(|| damping + oscillator.law().steepest());
        let table = oscillator.law().table().map(|table| (table.clone(), v));
        let curve = oscillator.law().curve(v);
        Self { jump, linear, curve, steepest, largest_slope, table }
    }

    /// Selects the interval of a table in which W lies, or into which it moves from a point.
    #[inline(always)]
    pub(super) fn select(&mut self, w: f64, e: f64, loading: &Loading) {
        if self.table.is_some() {
            self.select_piece(w, e, loading.rate(w));
        }
    }

    fn select_piece(&mut self, w: f64, e: f64, e_rate: f64) {
        let (Some((table, v)), Curve::Cubic(cubic)) = (&self.table, &self.curve) else { return };
        let cubic = cubic.at(table, *v, w);
        let before = if cubic.from == w { cubic.before(table, *v) } else { None };
        self.curve = Curve::Cubic(cubic);
        let a = self.acceleration(w, e);
        // At W′ = 0 the law does not contribute to W″.
        let falls = a < 0.0 || (a == 0.0 && e_rate < 0.0);
        if let (true, Some(before)) = (falls, before) {
            self.curve = Curve::Cubic(before);
        }
    }

    /// Returns the bounds of W of the present curve, if there are any.
    #[inline(always)]
    pub(super) fn bounds(&self) -> Option<(f64, f64)> {
        if let Curve::Cubic(cubic) = &self.curve { Some((cubic.from, cubic.to)) } else { None }
    }

    /// Returns the argument cW of a law continued below W = 0; the pole of 1/(1 + cW) lies at −1.
    pub(super) fn curvature_of(&self, w: f64) -> f64 {
        with_curve!(&self.curve, curve => curve.argument(w))
    }

    /// Returns the rate c of a law with e^{−cW}; 0 for other laws.
    #[inline(always)]
    pub(super) fn decay(&self) -> f64 {
        with_curve!(&self.curve, curve => curve.exponent())
    }

    /// Returns W′.
    #[inline(always)]
    pub(super) fn acceleration(&self, w: f64, e: f64) -> f64 {
        let r = with_curve!(&self.curve, curve => curve.value(w));
        e + self.jump + self.linear * w + r
    }

    /// Returns dW′/dW at fixed e.
    #[inline]
    pub(super) fn slope(&self, w: f64) -> f64 {
        self.linear + with_curve!(&self.curve, curve => curve.slope(w))
    }

    /// Returns whether a motion without forcing and fluctuation at W ≥ 0 and the rate W′ ends in steady sliding without
    /// crossing W = 1. Under strong damping this saves the many short steps to steady sliding.
    ///
    /// With the distance u = |W − 1|, u″ = −u − c·u′, and c ≥ 2 all the way, no motion leaves −u ≤ u′ ≤ 0: on u′ = −u,
    /// (u′ + u)′ = (c − 2)u ≥ 0, and on u′ = 0, u″ < 0.
    pub(super) fn creeps(&self, w: f64, rate: f64) -> bool {
        let (distance, approach) = ((w - 1.0).abs(), (1.0 - w).signum() * rate);
        // dW′/dW = −c falls with W where the fall of friction is convex.
        let largest_slope = || self.largest_slope.unwrap_or_else(|| self.slope(w.min(1.0)));
        self.linear <= -2.0 && (0.0..=distance).contains(&approach) && largest_slope() <= -2.0
    }

    /// Returns the largest |dW′/dW| at W ≥ 0; none if unknown.
    #[inline(always)]
    pub(super) fn steepest(&self) -> Option<f64> {
        self.steepest
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::VelocityLaw;
    use crate::law::{Coulomb, Exponential, Stribeck};
    use crate::tests::machine;
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
                0 => VelocityLaw::Stribeck(Stribeck { kinetic, decay: 1.0 / reach }),
                1 => VelocityLaw::Exponential(Exponential {
                    kinetic,
                    high_speed: 0.3 * kinetic,
                    stribeck_velocity: reach,
                }),
                _ => VelocityLaw::Tabulated(FrictionTable::new(&points).unwrap()),
            };
            let (belt_velocity, damping_ratio) = (reach * g[2].exp(), 1.0 + g[3].abs());
            let static_friction = 3.0 * kinetic;
            let weakening = Weakening::new(&machine(static_friction, law.clone(), damping_ratio, belt_velocity));
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
        let law = VelocityLaw::Coulomb(Coulomb { kinetic: 0.3 });
        let weakening = Weakening::new(&machine(0.3, law, 1.0, 1.0));
        assert_eq!([-1.1, -1.0, 0.0, 0.1].map(|rate| weakening.creeps(2.0, rate)), [false, true, true, false]);
    }
}
