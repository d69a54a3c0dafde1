//! The friction law in the slip equation W′ = e + jump + linear·W + r(W), and the Taylor coefficients of r(W).

use super::polynomial::cross;
use super::{FrictionLaw, Oscillator};

/// The constants of W′; r(0) = 0.
#[derive(Debug, Clone)]
pub(super) struct Weakening {
    /// (μ_st − μ_k)/V.
    pub(super) jump: f64,
    /// −2ζ, less the slope of a linear law.
    pub(super) linear: f64,
    pub(super) curve: Curve,
    /// Largest |dW′/dW| at W ≥ 0.
    steepest: f64,
}

/// The nonlinear part r(W) of a law.
#[derive(Debug, Clone, Copy)]
pub(super) enum Curve {
    /// 0.
    Straight,
    /// gW/(1 + cW).
    Quotient(Quotient),
    /// (g/c)(1 − e^{−cW}).
    Exponential(Exponential),
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

impl Weakening {
    pub(super) fn new(oscillator: &Oscillator) -> Self {
        let v = oscillator.belt_velocity();
        let jump = (oscillator.static_friction() - oscillator.law().kinetic()) / v;
        let damping = -2.0 * oscillator.damping_ratio();
        let (linear, curve, gain) = match oscillator.law() {
            FrictionLaw::Stribeck { kinetic, decay } if decay > 0.0 => {
                let gain = decay * kinetic;
                (damping, Curve::Quotient(Quotient { gain, curvature: decay * v }), gain)
            }
            FrictionLaw::Stribeck { .. } | FrictionLaw::Coulomb { .. } => (damping, Curve::Straight, 0.0),
            FrictionLaw::Linear { slope, .. } => (damping + slope, Curve::Straight, 0.0),
        };
        let steepest = linear.abs().max((linear + gain).abs());
        Self { jump, linear, curve, steepest }
    }

    /// How far the continuation of a law below W = 0 has come: −1 is the pole of 1/(1 + cW).
    pub(super) fn curvature_of(&self, w: f64) -> f64 {
        match &self.curve {
            Curve::Straight => 0.0,
            Curve::Quotient(q) => q.curvature * w,
            Curve::Exponential(x) => x.curvature * w,
        }
    }

    /// W′.
    #[inline(always)]
    pub(super) fn acceleration(&self, w: f64, e: f64) -> f64 {
        let r = match &self.curve {
            Curve::Straight => 0.0,
            Curve::Quotient(q) => q.gain * w / (1.0 + q.curvature * w),
            Curve::Exponential(x) => x.value(w),
        };
        e + self.jump + self.linear * w + r
    }

    /// Largest |dW′/dW| at W ≥ 0; none if not known.
    #[inline(always)]
    pub(super) fn steepest(&self) -> Option<f64> {
        Some(self.steepest)
    }
}

impl Exponential {
    fn value(&self, w: f64) -> f64 {
        -(self.gain / self.curvature) * (-self.curvature * w).exp_m1()
    }
}

/// Taylor coefficients of r(W(t)) from those of W(t), order by order.
pub(super) trait Recurrence<const N: usize> {
    /// dr/dW at the start.
    fn slope(&self) -> f64;

    /// r_n − slope·w_n, for n = 1, 2, … in turn; w is known up to n.
    fn rest(&mut self, w: &[f64; N], n: usize) -> f64;
}

/// Of a law without a curve.
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

/// r(1 + cW) = gW gives r_n = slope·w_n − c′·Σ w_k r_{n−k} over 0 < k < n, with c′ = c/(1 + cW_0).
pub(super) struct QuotientTerms<const N: usize> {
    slope: f64,
    curvature: f64,
    r: [f64; N],
}

impl<const N: usize> QuotientTerms<N> {
    #[inline(always)]
    pub(super) fn new(quotient: &Quotient, w0: f64) -> Self {
        let inverse = 1.0 / (1.0 + quotient.curvature * w0);
        Self { slope: quotient.gain * inverse * inverse, curvature: quotient.curvature * inverse, r: [0.0; N] }
    }
}

impl<const N: usize> Recurrence<N> for QuotientTerms<N> {
    #[inline(always)]
    fn slope(&self) -> f64 {
        self.slope
    }

    #[inline(always)]
    fn rest(&mut self, w: &[f64; N], n: usize) -> f64 {
        let rest = -self.curvature * cross(w, &self.r, n);
        self.r[n] = self.slope * w[n] + rest;
        rest
    }
}

/// r′ = cW′(g/c − r) gives n·r_n = n·slope·w_n − c·Σ k·w_k r_{n−k} over 0 < k < n, with slope = g − c·r_0.
pub(super) struct ExponentialTerms<const N: usize> {
    slope: f64,
    curvature: f64,
    r: [f64; N],
    /// k·w_k.
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
        let rest = -self.curvature / n as f64 * cross(&self.rates, &self.r, n);
        self.rates[n] = n as f64 * w[n];
        self.r[n] = self.slope * w[n] + rest;
        rest
    }
}
