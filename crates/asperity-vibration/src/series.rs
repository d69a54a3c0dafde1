//! The slip equations and their Taylor series.
//!
//! With the scaled relative speed W = |v_rel|/V, the excess force e = (±F − μ_st − m)/V over the stick limit (F = X + 2ζV
//! − q cos ητ, + for a mass slower than the belt) and the sliding distance S = s/V, slip in direction ± obeys
//!
//! W′ = e + (μ_st − μ(VW))/V − 2ζW,  e′ = ±1 − κW ± (qη/V) sin ητ,  S′ = W,  κ = 1 + dm/ds.
//!
//! No nearly equal numbers are subtracted when W and e are small: μ_st − μ(VW) is a jump plus aμ_kVW/(1 + aVW). Every
//! detachment is the state (0, 0).

use super::law::curve::{CurveShape, Recurrence};
use super::law::with_curve;
use super::polynomial::{self, CAPACITY, RECIPROCAL};
use super::weakening::{Loading, Weakening};
use asperity_base::wide::{Kernel, wide};

/// Number of coefficients of unshortened steps.
const LONG: usize = 24;
/// Last kept term of a series, relative to the state; the first dropped term is at most a third of it.
const TOLERANCE: f64 = 1e-13;

/// Exponent cW above which e^{−cW} does not contribute to the force, even a million times the scale.
const NO_EXPONENTIAL: f64 = 50.0;
/// Distance of extrema, relative to the step, below which they count as one.
const RESOLVED: f64 = 1e-12;

/// Repeats a block for the orders 1, 2, … below a limit, each as a constant, so that the compiler unrolls the loop.
macro_rules! for_orders {
    ($n:ident < $limit:expr, $body:block) => {
        for_orders!(@ $n, $limit, $body, 1 2 3 4 5 6 7 8 9 10 11 12 13 14 15 16 17 18 19 20 21 22 23 24 25 26)
    };
    (@ $n:ident, $limit:expr, $body:block, $($order:literal)*) => {
        $(if $order < $limit {
            let $n: usize = $order;
            $body
        })*
    };
}

/// Returns tⁿ.
#[inline(always)]
fn power(t: f64, n: usize) -> f64 {
    let (mut power, mut square, mut rest) = (1.0, t, n);
    while rest > 0 {
        if rest % 2 == 1 {
            power *= square;
        }
        square *= square;
        rest /= 2;
    }
    power
}

/// Returns approximately x^{1/n} for x > 0, within 1 % for n > 6, from the bits of x; the result is the same on every
/// machine.
fn root(x: f64, n: usize) -> f64 {
    const BIAS: f64 = 1023.0;
    // Exponent and mantissa together are log₂ x, at most 0.086 too small.
    let logarithm = x.to_bits() as i64 as f64 * (1.0 / (1_i64 << 52) as f64) - BIAS;
    let scaled = logarithm * RECIPROCAL[n] + BIAS;
    let exponent = scaled as i64;
    let fraction = scaled - exponent as f64;
    // 2^fraction within 0.4 %.
    f64::from_bits((exponent << 52) as u64) * (1.0 + fraction * (0.65 + 0.35 * fraction))
}

/// Returns a step ≤ h on which a law with e^{−cW} rises no more steeply than its series represents; `decay` is c, 0 for
/// other laws.
///
/// The terms of e^x grow up to the order x, so the last kept term bounds the dropped ones only if x is at most a third
/// of that order. Where e^{−cW} stays below rounding, the law is constant.
#[inline]
pub(super) fn exponential_step(w: &[f64], decay: f64, mut h: f64) -> f64 {
    let steepest = w.len() as f64 / 3.0;
    let too_steep = |h: f64| {
        let lowest = decay * polynomial::lower_bound(w, h);
        lowest <= NO_EXPONENTIAL && decay * w[0] - lowest > steepest
    };
    while decay > 0.0 && too_steep(h) {
        h *= 0.5;
    }
    h
}

/// Compiles [`Series::expand_with`] for newer processors, which need fewer copies of registers.
struct Expansion<const N: usize>;

/// Arguments of an expansion.
type Parts<'a, M> = (&'a mut Series, M, &'a Weakening, &'a Loading, [f64; 2]);

impl<const N: usize, T: Recurrence<N>, M: FnOnce() -> T> Kernel<Parts<'_, M>> for Expansion<N> {
    type Output = ();

    #[inline(always)]
    fn run((series, terms, weakening, loading, [w, e]): Parts<'_, M>) {
        series.recur::<N>(terms(), weakening, loading, w, e);
    }
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
    /// Rate c of a law with e^{−cW}; 0 for other laws.
    decay: f64,
}

impl Series {
    pub(super) fn new() -> Self {
        Self { len: 1, w: [0.0; CAPACITY], e: [0.0; CAPACITY], s: [0.0; CAPACITY], scale: 1.0, decay: 0.0 }
    }

    /// Returns the coefficients of W.
    #[inline]
    pub(super) fn w(&self) -> &[f64] {
        &self.w[..self.len]
    }

    /// Returns W(t) and e(t).
    #[inline]
    pub(super) fn state(&self, t: f64) -> (f64, f64) {
        (polynomial::split_value(self.w(), t), polynomial::split_value(&self.e[..self.len], t))
    }

    /// Returns S(t) = ∫₀ᵗ W and W(t).
    #[inline]
    pub(super) fn distance(&self, t: f64) -> (f64, f64) {
        (t * polynomial::split_value(&self.s[..self.len], t), polynomial::split_value(self.w(), t))
    }

    /// Returns W and W′ at the start.
    #[inline(always)]
    pub(super) fn start(&self) -> [f64; 2] {
        [self.w[0], self.w[1]]
    }

    /// Returns e at the start.
    #[inline(always)]
    pub(super) fn e_at_start(&self) -> f64 {
        self.e[0]
    }

    /// Returns the time in [0, h] at which S = `distance`, by Newton's method from a close guess; none if it does not
    /// converge.
    #[inline]
    pub(super) fn near_distance(&self, distance: f64, h: f64, guess: f64) -> Option<f64> {
        // Two iterations on the leading terms are cheap and leave one or two on the whole series.
        let [s0, s1, s2, s3] = [self.s[0], self.s[1], self.s[2], self.s[3]];
        let mut t = if guess < h { guess } else { h };
        for _ in 0..2 {
            let s = t * (s0 + t * (s1 + t * (s2 + t * s3)));
            t -= (s - distance) / (s0 + t * (2.0 * s1 + t * (3.0 * s2 + t * 4.0 * s3)));
        }
        for _ in 0..4 {
            if !(t > 0.0 && t <= h) {
                return None;
            }
            let (s, w) = self.distance(t);
            let step = (s - distance) / w;
            t -= step;
            // The error of Newton's method after an iteration is about its square times W′/2W.
            if step.abs() <= 1e-8 * t && step * step * self.scale <= 1e-17 * w {
                return (t <= h).then_some(t);
            }
        }
        None
    }

    /// Returns the time at which S = `distance`, which is reached before h.
    pub(super) fn time_of_distance(&self, distance: f64, h: f64) -> f64 {
        if distance <= 0.0 {
            return 0.0;
        }
        let excess = |t: f64| {
            let (s, w) = self.distance(t);
            (s - distance, w)
        };
        polynomial::bracketed_zero(excess, 0.0, h, false, 0.5 * h)
    }

    /// Expands about (w, e) with the number of coefficients that a step of length `horizon` needs.
    pub(super) fn expand(&mut self, weakening: &Weakening, loading: &Loading, w: f64, e: f64, horizon: f64) {
        // Terms fall like (√κ h)ⁿ/n!.
        let scaled = horizon * loading.kappa.max(1.0).sqrt();
        if scaled < 0.05 {
            self.expand_to::<8>(weakening, loading, w, e);
        } else if scaled < 0.25 {
            self.expand_to::<12>(weakening, loading, w, e);
        } else if scaled < 0.55 {
            self.expand_to::<16>(weakening, loading, w, e);
        } else {
            self.expand_to::<LONG>(weakening, loading, w, e);
        }
    }

    #[inline(always)]
    fn expand_to<const N: usize>(&mut self, weakening: &Weakening, loading: &Loading, w: f64, e: f64) {
        with_curve!(&weakening.curve, curve => self.expand_with::<N, _>(|| curve.terms::<N>(w), weakening, loading, w, e));
    }

    /// Computes the recurrence with N coefficients, compiled for several instruction sets only if N is large.
    fn expand_with<const N: usize, T: Recurrence<N>>(
        &mut self,
        terms: impl FnOnce() -> T,
        weakening: &Weakening,
        loading: &Loading,
        w: f64,
        e: f64,
    ) {
        if N == LONG {
            wide::<Expansion<N>, _>((self, terms, weakening, loading, [w, e]));
        } else {
            self.recur::<N>(terms(), weakening, loading, w, e);
        }
    }

    #[inline(always)]
    fn recur<const N: usize>(
        &mut self,
        mut terms: impl Recurrence<N>,
        weakening: &Weakening,
        loading: &Loading,
        w0: f64,
        e0: f64,
    ) {
        let mut external = [0.0; N];
        if loading.swing != 0.0 {
            // sin(phase + ηt) has the coefficients s, ηc, −η²s/2, …
            let (mut s, mut c) = (loading.swing * loading.phase.sin(), loading.swing * loading.phase.cos());
            for (n, term) in external.iter_mut().enumerate() {
                *term = s;
                (s, c) = (c * loading.frequency * RECIPROCAL[n + 1], -s * loading.frequency * RECIPROCAL[n + 1]);
            }
        }
        let mut w = [0.0; N];
        (w[0], w[1]) = (w0, weakening.acceleration(w0, e0));
        let slope = weakening.linear + terms.slope();
        for_orders!(n < N - 1, {
            let e = (external[n - 1] - loading.kappa * w[n - 1]) * RECIPROCAL[n];
            let e = if n == 1 { e + loading.base } else { e };
            // Products that are known early leave a short dependency chain from order to order.
            w[n + 1] = (slope * RECIPROCAL[n + 1]) * w[n] + (e + terms.rest(&w, n)) * RECIPROCAL[n + 1];
        });
        let (mut e, mut s) = ([0.0; N], [0.0; N]);
        for n in 0..N {
            s[n] = w[n] * RECIPROCAL[n + 1];
        }
        for n in 1..N {
            e[n] = (external[n - 1] - loading.kappa * w[n - 1]) * RECIPROCAL[n];
        }
        e[0] = e0;
        e[1] += loading.base;
        self.w[..N].copy_from_slice(&w);
        self.e[..N].copy_from_slice(&e);
        self.s[..N].copy_from_slice(&s);
        self.len = N;
        self.scale = w0.abs().max(e0.abs()).max(1.0);
        self.decay = weakening.decay();
    }

    /// Returns the longest step ≤ `wanted` on which the dropped terms stay below rounding.
    ///
    /// The last term of order n bounds them. In case it vanishes, so does the previous term times h²/n(n+1), and in
    /// case both vanish, the term before that times h³/(n−1)n(n+1).
    #[inline]
    pub(super) fn reach(&self, wanted: f64) -> f64 {
        let n = self.len - 1;
        let size = |k: usize| self.w[k].abs().max(self.e[k].abs());
        let allowed = TOLERANCE * self.scale;
        let before = size(n - 1).max(size(n - 2) * RECIPROCAL[n - 1]);
        let (last, before) = (size(n), before * RECIPROCAL[n] * RECIPROCAL[n + 1]);
        if wanted < 1.0 {
            let power = power(wanted, n);
            if last * power <= allowed && before * power * wanted <= allowed {
                return exponential_step(self.w(), self.decay, wanted);
            }
        }
        let h = wanted.min(root(allowed / last, n));
        let h = if before * h <= last { h } else { h.min(root(allowed / before, n + 1)) };
        exponential_step(self.w(), self.decay, h)
    }

    /// Returns the first extremum of W in (0, h]: a maximum if W rises at 0, otherwise a minimum.
    pub(super) fn first_extremum(&self, h: f64) -> Option<f64> {
        let mut slope = polynomial::derivative(self.w());
        let leading = slope.iter().take(2).take_while(|c| **c == 0.0).count();
        if slope[leading] < 0.0 {
            slope.iter_mut().for_each(|c| *c = -*c);
        }
        polynomial::first_zero(&slope[leading..self.len - 1], h)
    }

    /// Returns all extrema of W in (0, h) in order.
    pub(super) fn extrema(&self, h: f64) -> Vec<f64> {
        let slope = polynomial::derivative(self.w());
        let mut found: Vec<f64> = Vec::new();
        loop {
            let since = found.last().copied().unwrap_or(0.0);
            let mut local = polynomial::shifted(&slope[..self.len - 1], since);
            // The zero just found is divided out, up to its rounding.
            let zeros = if since > 0.0 { 1 } else { local.iter().take(2).take_while(|c| **c == 0.0).count() };
            if local[zeros] < 0.0 {
                local.iter_mut().for_each(|c| *c = -*c);
            }
            match polynomial::first_zero(&local[zeros..self.len - 1], h - since) {
                Some(t) if t > RESOLVED * h && since + t < h => found.push(since + t),
                _ => return found,
            }
        }
    }

    /// Returns whether W, at most `level` at 0, exceeds it in (0, h], for any number of extrema in between.
    #[inline]
    pub(super) fn exceeds(&self, level: f64, h: f64) -> bool {
        self.ceiling(h) > level && self.first_crossing(level, -1.0, h).is_some()
    }

    /// Returns an upper bound of W on [0, h].
    pub(super) fn ceiling(&self, h: f64) -> f64 {
        polynomial::upper_bound(self.w(), h)
    }
}
