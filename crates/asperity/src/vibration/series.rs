//! The slip equations and their Taylor series.
//!
//! With the scaled relative speed W = |v_rel|/V, the excess force e = (±F − μ_st − m)/V over the stick limit (F = X + 2ζV
//! − q cos ητ, + for a mass slower than the belt) and the sliding distance S = s/V, slip in direction ± obeys
//!
//! W′ = e + (μ_st − μ(VW))/V − 2ζW,  e′ = ±1 − κW ± (qη/V) sin ητ,  S′ = W,  κ = 1 + dm/ds.
//!
//! Nothing cancels when W and e are small: μ_st − μ(VW) is a jump plus aμ_kVW/(1 + aVW). Every detachment is (0, 0).

use super::polynomial::{self, CAPACITY};
use super::{FrictionLaw, Oscillator};

/// Last kept term of a series, relative to the state.
const TOLERANCE: f64 = 2e-16;

/// 1/n.
pub(super) const RECIPROCAL: [f64; CAPACITY + 1] = {
    let mut r = [0.0; CAPACITY + 1];
    let mut n = 1;
    while n <= CAPACITY {
        r[n] = 1.0 / n as f64;
        n += 1;
    }
    r
};

/// The constants of W′: jump + linear·W + gain·W/(1 + curvature·W) + e.
#[derive(Debug, Clone, Copy)]
pub(super) struct Weakening {
    /// (μ_st − μ_k)/V.
    pub(super) jump: f64,
    pub(super) linear: f64,
    pub(super) gain: f64,
    pub(super) curvature: f64,
}

impl Weakening {
    pub(super) fn new(oscillator: &Oscillator) -> Self {
        let v = oscillator.belt_velocity();
        let jump = (oscillator.static_friction() - oscillator.law().kinetic()) / v;
        let damping = -2.0 * oscillator.damping_ratio();
        match oscillator.law() {
            FrictionLaw::Stribeck { kinetic, decay } => {
                Self { jump, linear: damping, gain: decay * kinetic, curvature: decay * v }
            }
            FrictionLaw::Coulomb { .. } => Self { jump, linear: damping, gain: 0.0, curvature: 0.0 },
            FrictionLaw::Linear { slope, .. } => Self { jump, linear: damping + slope, gain: 0.0, curvature: 0.0 },
        }
    }

    /// aVW, whose value −1 is the pole of the continued law.
    pub(super) fn curvature_of(&self, w: f64) -> f64 {
        self.curvature * w
    }

    /// W′.
    #[inline]
    pub(super) fn acceleration(&self, w: f64, e: f64) -> f64 {
        e + self.jump + self.linear * w + self.gain * w / (1.0 + self.curvature * w)
    }
}

/// The constants of e′ during one step: base + swing·sin(phase + ηt) − κW.
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

/// Taylor coefficients of W and e about the start of a step.
#[derive(Debug, Clone)]
pub(super) struct Series {
    len: usize,
    w: [f64; CAPACITY],
    e: [f64; CAPACITY],
    /// Coefficients of S(t)/t.
    s: [f64; CAPACITY],
    scale: f64,
}

impl Series {
    pub(super) fn new() -> Self {
        Self { len: 1, w: [0.0; CAPACITY], e: [0.0; CAPACITY], s: [0.0; CAPACITY], scale: 1.0 }
    }

    /// Coefficients of W.
    #[inline]
    pub(super) fn w(&self) -> &[f64] {
        &self.w[..self.len]
    }

    /// W(t), e(t).
    #[inline]
    pub(super) fn state(&self, t: f64) -> (f64, f64) {
        (polynomial::split_value(self.w(), t), polynomial::split_value(&self.e[..self.len], t))
    }

    /// S(t) = ∫₀ᵗ W and W(t).
    #[inline]
    pub(super) fn distance(&self, t: f64) -> (f64, f64) {
        (t * polynomial::split_value(&self.s[..self.len], t), polynomial::split_value(self.w(), t))
    }

    /// Time at which S = `distance`, which is reached before h; `guess` should be close.
    #[inline]
    pub(super) fn time_of_distance(&self, distance: f64, h: f64, guess: f64) -> f64 {
        if distance <= 0.0 {
            return 0.0;
        }
        // Two steps on the leading terms are nearly free and leave one or two on the whole series.
        let [s0, s1, s2, s3] = [self.s[0], self.s[1], self.s[2], self.s[3]];
        let mut t = if guess < h { guess } else { h };
        for _ in 0..2 {
            let s = t * (s0 + t * (s1 + t * (s2 + t * s3)));
            t -= (s - distance) / (s0 + t * (2.0 * s1 + t * (3.0 * s2 + t * 4.0 * s3)));
        }
        for _ in 0..4 {
            if !(t > 0.0 && t <= h) {
                break;
            }
            let (s, w) = self.distance(t);
            let step = (s - distance) / w;
            t -= step;
            // Newton's error after a step is about its square times W′/2W.
            if step.abs() <= 1e-8 * t && step * step * self.scale <= 1e-17 * w {
                return t.clamp(0.0, h);
            }
        }
        let excess = |t: f64| {
            let (s, w) = self.distance(t);
            (s - distance, w)
        };
        polynomial::bracketed_zero(excess, 0.0, h, false, 0.5 * h)
    }

    /// Expands about (w, e) with as many coefficients as a step of the length `horizon` needs.
    #[inline]
    pub(super) fn expand(&mut self, weakening: &Weakening, loading: &Loading, w: f64, e: f64, horizon: f64) {
        // Terms fall like (√κ h)ⁿ/n!.
        let scaled = horizon * loading.kappa.max(1.0).sqrt();
        if scaled < 0.07 {
            self.expand_to::<10>(weakening, loading, w, e);
        } else if scaled < 0.17 {
            self.expand_to::<12>(weakening, loading, w, e);
        } else if scaled < 0.33 {
            self.expand_to::<14>(weakening, loading, w, e);
        } else if scaled < 0.55 {
            self.expand_to::<16>(weakening, loading, w, e);
        } else {
            self.expand_to::<24>(weakening, loading, w, e);
        }
    }

    /// The recurrence, with N coefficients. Quotients: r(1 + cW) = gW gives r_n from r_0 … r_{n−1}.
    #[inline]
    fn expand_to<const N: usize>(&mut self, weakening: &Weakening, loading: &Loading, w0: f64, e0: f64) {
        let mut external = [0.0; N];
        external[0] = loading.base;
        if loading.swing != 0.0 {
            // sin(phase + ηt) has the coefficients s, ηc, −η²s/2, …
            let (mut s, mut c) = (loading.swing * loading.phase.sin(), loading.swing * loading.phase.cos());
            for (n, term) in external.iter_mut().enumerate() {
                *term += s;
                (s, c) = (c * loading.frequency * RECIPROCAL[n + 1], -s * loading.frequency * RECIPROCAL[n + 1]);
            }
        }
        let (mut w, mut e, mut r, mut s) = ([0.0; N], [0.0; N], [0.0; N], [0.0; N]);
        let quotient = 1.0 / (1.0 + weakening.curvature * w0);
        let curvature = weakening.curvature * quotient;
        (w[0], e[0], r[0], s[0]) = (w0, e0, weakening.gain * w0 * quotient, w0);
        // r_n = gain′·w_n − curvature′·Σ_{k=1}^{n−1} w_k r_{n−k}: the term w_n r_0 is in gain′.
        let gain = weakening.gain * quotient - curvature * r[0];
        let mut jump = weakening.jump;
        for n in 0..N - 1 {
            // Two sums, so that additions need not wait for each other.
            let (mut inner, mut other) = (0.0, 0.0);
            let mut k = 1;
            while k < n {
                inner += w[k] * r[n + 1 - k];
                other += w[k + 1] * r[n - k];
                k += 2;
            }
            if k == n {
                inner += w[n] * r[1];
            }
            w[n + 1] = (e[n] + weakening.linear * w[n] + jump + r[n]) * RECIPROCAL[n + 1];
            e[n + 1] = (external[n] - loading.kappa * w[n]) * RECIPROCAL[n + 1];
            r[n + 1] = gain * w[n + 1] - curvature * (inner + other);
            s[n + 1] = w[n + 1] * RECIPROCAL[n + 2];
            jump = 0.0;
        }
        self.w[..N].copy_from_slice(&w);
        self.e[..N].copy_from_slice(&e);
        self.s[..N].copy_from_slice(&s);
        self.len = N;
        self.scale = w0.abs().max(e0.abs()).max(1.0);
    }

    /// The longest step ≤ `wanted` on which the dropped terms stay below rounding.
    ///
    /// The last term of order n bounds them, and so does the one before times h²/n(n+1), in case the last vanishes.
    #[inline]
    pub(super) fn reach(&self, wanted: f64) -> f64 {
        let n = self.len - 1;
        let size = |k: usize| self.w[k].abs().max(self.e[k].abs());
        let allowed = TOLERANCE * self.scale;
        let (last, before) = (size(n), size(n - 1) * RECIPROCAL[n] * RECIPROCAL[n + 1]);
        let power = wanted.powi(n as i32);
        if wanted.is_finite() && last * power <= allowed && before * power * wanted <= allowed {
            return wanted;
        }
        wanted.min((allowed / last).powf(RECIPROCAL[n])).min((allowed / before).powf(RECIPROCAL[n + 1]))
    }

    /// First time in (0, h] at which W, positive just after 0, is zero.
    #[inline]
    pub(super) fn first_arrival(&self, h: f64) -> Option<f64> {
        // Right after a detachment W = O(t) or O(t²); the factor is divided out, or its zero at t = 0 would be found.
        let leading = self.w().iter().take(2).take_while(|c| **c == 0.0).count();
        polynomial::first_zero(&self.w()[leading..], h)
    }

    /// First extremum of W in (0, h]: a maximum if W rises at 0, else a minimum.
    pub(super) fn first_extremum(&self, h: f64) -> Option<f64> {
        let mut slope = polynomial::derivative(self.w());
        let leading = slope.iter().take(2).take_while(|c| **c == 0.0).count();
        if slope[leading] < 0.0 {
            slope.iter_mut().for_each(|c| *c = -*c);
        }
        polynomial::first_zero(&slope[leading..self.len - 1], h)
    }

    /// A number above W on [0, h].
    pub(super) fn ceiling(&self, h: f64) -> f64 {
        polynomial::upper_bound(self.w(), h)
    }
}
