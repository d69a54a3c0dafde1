//! One step of slip in all lanes: Taylor series, end of the step and new state.

use std::f64::consts::{LOG2_E, PI};

use super::super::Oscillator;
use super::super::law::BatchForm;
use super::super::polynomial;
use super::super::polynomial::RECIPROCAL;
use super::super::series::exponential_step;
use super::super::weakening::Weakening;
use asperity_base::wide::{Kernel, wide};
use asperity_process::Cell;

/// Number of trajectories that advance together: four registers of four numbers, or two of eight.
pub(crate) const LANES: usize = 16;

/// Numbers of coefficients and relative tolerances of a step: with grid points, which are close together, and without.
pub(super) const NOISY: usize = 12;
const NOISY_TOLERANCE: f64 = 1e-13;
pub(super) const STEADY: usize = 22;
const STEADY_TOLERANCE: f64 = 1e-12;

/// One number per lane.
pub(super) type Lane = [f64; LANES];

/// One flag per lane, 1 (true) or 0 (false), as a number so that selections stay in the registers.
pub(super) type Flags = Lane;

/// Length of a step, as a fraction of the least distance between two extrema of W.
const EXTREMA: f64 = 0.9;
/// Length of a step over the time in which W would fall to zero at its present slope. From a minimum of W a step of
/// twice that time passes the minimum, so steps do not shrink towards it.
const FALLS: f64 = 4.0;
/// Factor that shortens a step by more than the error of [`coarse_root`], 0.4 %.
const REACH: f64 = 0.98;

/// Constants of the slip equations, per lane; see [`super::super::series`].
#[derive(Debug, Clone)]
pub(super) struct Consts {
    pub(super) jump: Lane,
    linear: Lane,
    gain: Lane,
    curvature: Lane,
    /// The coefficient is positive where floor + m > W·(loss − m·thinning). For a linear law, `floor` is μ_k and `loss`
    /// its decrease per W; for a quotient, `thinning` is its curvature. For an exponential law `floor` is μ_∞.
    floor: Lane,
    loss: Lane,
    thinning: Lane,
    /// Bound of the change of the stiffness κ by the weakening, over |W′|, within the distance of two extrema of W.
    softening: Lane,
}

/// State of each lane. The phase is always slip, because a stick is skipped in one operation.
#[derive(Debug, Clone)]
pub(super) struct States {
    pub(super) w: Lane,
    pub(super) e: Lane,
    pub(super) tau: Lane,
    /// +1 in slip and −1 in over-slip.
    pub(super) direction: Lane,
    /// κ = 1 + dm/ds.
    pub(super) kappa: Lane,
    /// Scaled distance S between grid points; infinite without grid points.
    pub(super) span: Lane,
    /// Scaled distance S since the last grid point.
    pub(super) passed: Lane,
    /// Least m in this cell, at most zero.
    pub(super) least: Lane,
    /// Largest W at the end of a step since the last detachment.
    pub(super) fastest: Lane,
}

/// Results at the end of a step.
#[derive(Debug, Clone)]
pub(super) struct Cuts {
    /// Length of the step.
    pub(super) h: Lane,
    /// A grid point was crossed.
    pub(super) crossed: Flags,
    /// W reached zero.
    pub(super) arrived: Flags,
    /// The step is undecided: a minimum near zero, or Newton's method did not converge.
    pub(super) unsure: Flags,
    /// W turned from rising to falling, and no step ended above 1.
    pub(super) turned: Flags,
    /// The friction coefficient may not be positive along the whole step.
    pub(super) weak: Flags,
    /// A grid point was crossed and nothing else happened.
    pub(super) plain: Flags,
    /// Nothing happened.
    pub(super) quiet: Flags,
    /// Length of the step before it was shortened.
    pub(super) trial: Lane,
    /// τ, S since the last grid point and e at the start of the step.
    pub(super) tau: Lane,
    pub(super) passed: Lane,
    excess: Lane,
}

impl Consts {
    pub(super) const NONE: Self = Self {
        jump: [0.0; LANES],
        linear: [0.0; LANES],
        gain: [0.0; LANES],
        curvature: [0.0; LANES],
        floor: [1.0; LANES],
        loss: [0.0; LANES],
        thinning: [0.0; LANES],
        softening: [0.0; LANES],
    };

    pub(super) fn set(&mut self, lane: usize, oscillator: &Oscillator, form: &BatchForm) {
        let Weakening { jump, linear, .. } = Weakening::new(oscillator);
        let BatchForm { gain, curvature, is_exponential, floor, loss } = *form;
        // r″ is at most twice gain × curvature for a quotient, and once that for an exponential law.
        let (bend, thinning) = if is_exponential { (0.5, 0.0) } else { (1.0, curvature) };
        (self.jump[lane], self.linear[lane], self.gain[lane], self.curvature[lane]) = (jump, linear, gain, curvature);
        self.softening[lane] = bend * gain * curvature;
        (self.floor[lane], self.loss[lane]) = (floor, loss);
        self.thinning[lane] = thinning;
    }
}

impl Cuts {
    pub(super) const NONE: Self = Self {
        h: [0.0; LANES],
        crossed: [0.0; LANES],
        arrived: [0.0; LANES],
        unsure: [0.0; LANES],
        turned: [0.0; LANES],
        weak: [0.0; LANES],
        plain: [0.0; LANES],
        quiet: [0.0; LANES],
        trial: [0.0; LANES],
        tau: [0.0; LANES],
        passed: [0.0; LANES],
        excess: [0.0; LANES],
    };
}

impl States {
    /// Enters a cell of the process.
    #[inline(always)]
    pub(super) fn enter(&mut self, lane: usize, cell: &Cell, velocity: f64) {
        let endless = cell.length == f64::INFINITY;
        self.kappa[lane] = 1.0 + if endless { 0.0 } else { cell.slope() };
        self.span[lane] = cell.length / velocity;
        self.passed[lane] = 0.0;
        self.least[lane] = smaller(smaller(cell.left, cell.right), 0.0);
    }

    /// Puts an empty lane into steady sliding.
    pub(super) fn clear(&mut self, lane: usize) {
        (self.w[lane], self.e[lane], self.tau[lane]) = (1.0, 0.0, 0.0);
        (self.span[lane], self.passed[lane]) = (f64::INFINITY, 0.0);
        (self.direction[lane], self.kappa[lane], self.fastest[lane]) = (1.0, 1.0, 0.0);
    }

    pub(super) const NONE: Self = Self {
        w: [1.0; LANES],
        e: [0.0; LANES],
        tau: [0.0; LANES],
        direction: [1.0; LANES],
        kappa: [1.0; LANES],
        span: [f64::INFINITY; LANES],
        passed: [0.0; LANES],
        least: [0.0; LANES],
        fastest: [0.0; LANES],
    };
}

/// N Taylor coefficients, N even, of W, S/t and the weakening of friction r, each in all lanes, and the last two of e.
/// Laws are either exponential, r = (g/c)(1 − e^{−cW}), or quotients, r = gW/(1 + cW), which include the linear and
/// constant laws with c = 0.
#[derive(Debug, Clone)]
pub(super) struct Expansion<const N: usize, const EXPONENTIAL: bool> {
    w: [Lane; N],
    s: [Lane; N],
    r: [Lane; N],
    /// Coefficients k·w_k of W′ times t, for an exponential law.
    rates: [Lane; N],
    e: [Lane; 2],
}

#[inline(always)]
fn each(f: impl Fn(usize) -> f64) -> Lane {
    let mut y = [0.0; LANES];
    for l in 0..LANES {
        y[l] = f(l);
    }
    y
}

/// Returns the larger number in one instruction; `f64::max` needs more because it handles NaN.
#[inline(always)]
fn larger(a: f64, b: f64) -> f64 {
    if a > b { a } else { b }
}

#[inline(always)]
fn smaller(a: f64, b: f64) -> f64 {
    if a < b { a } else { b }
}

#[inline(always)]
fn flag(condition: bool) -> f64 {
    if condition { 1.0 } else { 0.0 }
}

#[inline(always)]
fn choose(flag: f64, yes: f64, no: f64) -> f64 {
    if flag > 0.5 { yes } else { no }
}

#[inline(always)]
fn any(flags: &Flags) -> bool {
    let mut sum = 0.0;
    for l in 0..LANES {
        sum += flags[l];
    }
    sum > 0.0
}

/// Returns Σ c_k t^k as the sum of its even and odd parts.
#[inline(always)]
fn value<const N: usize>(c: &[Lane; N], t: &Lane) -> Lane {
    let square = each(|l| t[l] * t[l]);
    let (mut even, mut odd) = ([0.0; LANES], [0.0; LANES]);
    for k in (0..N / 2).rev() {
        even = each(|l| even[l] * square[l] + c[2 * k][l]);
        odd = each(|l| odd[l] * square[l] + c[2 * k + 1][l]);
    }
    each(|l| even[l] + t[l] * odd[l])
}

/// Returns Σ c_k t^k and its derivative.
#[inline(always)]
fn value_and_slope<const N: usize>(c: &[Lane; N], t: &Lane) -> (Lane, Lane) {
    let (mut sum, mut slope) = (c[N - 1], [0.0; LANES]);
    for k in (0..N - 1).rev() {
        slope = each(|l| slope[l] * t[l] + sum[l]);
        sum = each(|l| sum[l] * t[l] + c[k][l]);
    }
    (sum, slope)
}

/// Returns a lower bound of Σ c_k t^k on [0, h] from the signs of the coefficients.
#[inline(always)]
fn lower_bound<const N: usize>(c: &[Lane; N], h: &Lane) -> Lane {
    let mut sum = [0.0; LANES];
    for k in (1..N).rev() {
        sum = each(|l| (sum[l] + smaller(c[k][l], 0.0)) * h[l]);
    }
    each(|l| c[0][l] + sum[l])
}

/// 2⁵², which plus an integer has the integer in its lowest bits.
const SHIFT: f64 = 4_503_599_627_370_496.0;

/// Returns x^(1/n) for positive x within 0.5 %: the upper half of the bits of a number is nearly its logarithm.
#[inline(always)]
fn coarse_root(x: f64, reciprocal: f64) -> f64 {
    const ONE: f64 = 1_072_693_248.0;
    let logarithm = f64::from_bits((x.to_bits() >> 32) | SHIFT.to_bits()) - SHIFT;
    f64::from_bits((ONE + (logarithm - ONE) * reciprocal + SHIFT).to_bits() << 32)
}

/// Returns e^x and e^x − 1, both to rounding, for |x| < 700. Beyond, returns the values at ±700.
#[inline(always)]
fn exponential(x: f64) -> (f64, f64) {
    // Adding 3·2⁵¹ rounds a number to an integer.
    const ROUND: f64 = 6_755_399_441_055_744.0;
    // ln 2 in two parts; an integer times the first part is exact.
    const LN_2: [f64; 2] = [0.693_147_180_369_123_8, 1.908_214_929_270_587_7e-10];
    let x = smaller(larger(x, -700.0), 700.0);
    let k = (x * LOG2_E + ROUND) - ROUND;
    let t = (x - k * LN_2[0]) - k * LN_2[1];
    let mut sum = FACTORIAL_RECIPROCAL[13];
    for n in (1..13).rev() {
        sum = sum * t + FACTORIAL_RECIPROCAL[n];
    }
    let scale = f64::from_bits((k + (1023.0 + SHIFT)).to_bits() << 52);
    let less_one = (scale - 1.0) + scale * (t * sum);
    (scale + scale * (t * sum), less_one)
}

/// 1/n!.
const FACTORIAL_RECIPROCAL: [f64; 14] = {
    let (mut r, mut factorial, mut n) = ([1.0; 14], 1.0, 1);
    while n < 14 {
        factorial *= n as f64;
        r[n] = 1.0 / factorial;
        n += 1;
    }
    r
};

impl<const N: usize, const EXPONENTIAL: bool> Expansion<N, EXPONENTIAL> {
    pub(super) const NONE: Self = Self {
        w: [[0.0; LANES]; N],
        s: [[0.0; LANES]; N],
        r: [[0.0; LANES]; N],
        rates: [[0.0; LANES]; N],
        e: [[0.0; LANES]; 2],
    };

    /// Returns r(W) and its slope.
    #[inline(always)]
    fn law(consts: &Consts, l: usize, w: f64) -> (f64, f64) {
        let (gain, curvature) = (consts.gain[l], consts.curvature[l]);
        if EXPONENTIAL {
            let (fade, less_one) = exponential(-curvature * w);
            (-(gain / curvature) * less_one, gain * fade)
        } else {
            let quotient = 1.0 / (1.0 + curvature * w);
            (gain * w * quotient, gain * quotient * quotient)
        }
    }

    /// Computes the recurrence of [`super::super::series::Series`] without forcing.
    #[inline(always)]
    fn expand(&mut self, consts: &Consts, states: &States) {
        (self.w[0], self.s[0]) = (states.w, states.w);
        let (gain, curvature) = if EXPONENTIAL {
            let mut gain = [0.0; LANES];
            for l in 0..LANES {
                (self.r[0][l], gain[l]) = Self::law(consts, l, states.w[l]);
            }
            (gain, consts.curvature)
        } else {
            let quotient = each(|l| 1.0 / (1.0 + consts.curvature[l] * states.w[l]));
            let curvature = each(|l| consts.curvature[l] * quotient[l]);
            self.r[0] = each(|l| consts.gain[l] * states.w[l] * quotient[l]);
            (each(|l| consts.gain[l] * quotient[l] - curvature[l] * self.r[0][l]), curvature)
        };
        self.w[1] = each(|l| states.e[l] + consts.linear[l] * states.w[l] + consts.jump[l] + self.r[0][l]);
        self.s[1] = each(|l| self.w[1][l] * 0.5);
        self.r[1] = each(|l| gain[l] * self.w[1][l]);
        self.rates[1] = self.w[1];
        self.e = [states.e, each(|l| states.direction[l] - states.kappa[l] * states.w[l])];
        // Two orders at a time, so that every coefficient is read once for both of its products.
        let mut m = 2;
        while m < N {
            let (mut lower, mut upper) = ([0.0; LANES], [0.0; LANES]);
            let mut above = self.r[m - 1];
            let first = self.factor(1);
            lower = each(|l| lower[l] + first[l] * above[l]);
            for k in 2..m {
                let (w, r) = (self.factor(k), self.r[m - k]);
                upper = each(|l| upper[l] + w[l] * above[l]);
                lower = each(|l| lower[l] + w[l] * r[l]);
                above = r;
            }
            self.advance(consts, states, (&gain, &curvature), m, &lower);
            let last = self.factor(m);
            upper = each(|l| upper[l] + (first[l] * self.r[m][l] + last[l] * self.r[1][l]));
            self.advance(consts, states, (&gain, &curvature), m + 1, &upper);
            m += 2;
        }
    }

    /// Returns the factor of r_{m−k} in the recurrence: w_k, or k·w_k for an exponential law.
    #[inline(always)]
    fn factor(&self, k: usize) -> Lane {
        if EXPONENTIAL { self.rates[k] } else { self.w[k] }
    }

    /// Computes the coefficients of order m from the previous ones and Σ w_k r_{m−k}, or Σ k·w_k r_{m−k}.
    #[inline(always)]
    fn advance(&mut self, consts: &Consts, states: &States, (gain, curvature): (&Lane, &Lane), m: usize, sum: &Lane) {
        let (next, after) = (RECIPROCAL[m], RECIPROCAL[m + 1]);
        let (before, e) = (self.w[m - 1], self.e[1]);
        let w = each(|l| (e[l] + consts.linear[l] * before[l] + self.r[m - 1][l]) * next);
        self.e = [e, each(|l| -states.kappa[l] * before[l] * next)];
        if EXPONENTIAL {
            self.r[m] = each(|l| gain[l] * w[l] - curvature[l] * next * sum[l]);
            self.rates[m] = each(|l| m as f64 * w[l]);
        } else {
            self.r[m] = each(|l| gain[l] * w[l] - curvature[l] * sum[l]);
        }
        self.s[m] = each(|l| w[l] * after);
        self.w[m] = w;
    }

    /// Returns approximately the longest step on which the dropped terms stay below `tolerance` times the state.
    #[inline(always)]
    fn reach(&self, states: &States, tolerance: f64) -> Lane {
        let n = N - 1;
        let size = |w: f64, e: f64| larger(larger(w.abs(), e.abs()), 1e-280);
        let allowed = each(|l| tolerance * larger(size(states.w[l], states.e[l]), 1.0));
        // The last two terms may both vanish by accident.
        let earlier = each(|l| {
            larger(size(self.w[n - 1][l], self.e[0][l]), self.w[n - 2][l].abs() * RECIPROCAL[n - 1])
                * (RECIPROCAL[n] * RECIPROCAL[n + 1])
        });
        let last = each(|l| coarse_root(allowed[l] / size(self.w[n][l], self.e[1][l]), RECIPROCAL[n]));
        let before = each(|l| coarse_root(allowed[l] / earlier[l], RECIPROCAL[n + 1]));
        each(|l| REACH * smaller(last[l], before[l]))
    }

    /// Returns the time of the zero of W, W′ there, and whether it was found. W is positive at 0 and w ≤ 0 with slope
    /// `slope` at h.
    #[inline(always)]
    fn arrival(&self, consts: &Consts, states: &States, h: &Lane, w: &Lane, slope: &Lane) -> (Lane, Lane, Flags) {
        // W″ follows from W and W′, so each iteration is Halley's method, of third order.
        let bend = |w: &Lane, slope: &Lane| {
            each(|l| {
                let weakening = consts.linear[l] + Self::law(consts, l, w[l]).1;
                weakening * slope[l] + states.direction[l] - states.kappa[l] * w[l]
            })
        };
        // First guess: the parabola at h.
        let second = bend(w, slope);
        let mut t = each(|l| {
            let root = larger(slope[l] * slope[l] - 2.0 * second[l] * w[l], 0.0).sqrt();
            larger(h[l] - 2.0 * w[l] / (slope[l] - root), 0.0)
        });
        let (mut step, mut end) = ([0.0; LANES], [0.0; LANES]);
        for _ in 0..3 {
            let (y, dy) = value_and_slope(&self.w, &t);
            let second = bend(&y, &dy);
            step = each(|l| 2.0 * y[l] * dy[l] / (2.0 * dy[l] * dy[l] - y[l] * second[l]));
            t = each(|l| smaller(larger(t[l] - step[l], 0.0), h[l]));
            end = each(|l| dy[l] - step[l] * second[l]);
        }
        let found = each(|l| {
            let size = step[l].abs();
            // The error of the slope at the end is of the order of the square of the last correction.
            flag((size * size <= 1e-16 * h[l]) & (t[l] > 0.0) & (t[l] < h[l]))
        });
        (t, end, found)
    }

    /// Returns the time at which S reaches `left`, not later than `cap`, and whether it was found.
    #[inline(always)]
    fn crossing(&self, left: &Lane, cap: &Lane) -> (Lane, Flags) {
        let (w, s) = (&self.w, &self.s);
        // First guess: constant acceleration. Then Newton's method, first on the leading terms, then on all.
        let mut t = each(|l| {
            let discriminant = larger(w[0][l] * w[0][l] + 2.0 * w[1][l] * left[l], 0.0);
            smaller(2.0 * left[l] / (w[0][l] + discriminant.sqrt()), cap[l])
        });
        for _ in 0..2 {
            t = each(|l| {
                let t = t[l];
                let y = t * (s[0][l] + t * (s[1][l] + t * (s[2][l] + t * s[3][l])));
                let dy = w[0][l] + t * (w[1][l] + t * (w[2][l] + t * w[3][l]));
                t - (y - left[l]) / dy
            });
        }
        let (mut step, mut speed) = ([0.0; LANES], [0.0; LANES]);
        for _ in 0..2 {
            let y = value(s, &t);
            speed = value(w, &t);
            step = each(|l| (t[l] * y[l] - left[l]) / speed[l]);
            t = each(|l| t[l] - step[l]);
        }
        // The error of Newton's method after an iteration is about its square times W′/2W.
        let found = each(|l| flag((step[l] * step[l] <= 1e-17 * t[l] * speed[l]) & (t[l] > 0.0) & (t[l] <= cap[l])));
        (t, found)
    }

    /// Advances every lane by one step, at most to the time `until`.
    ///
    /// A step is shorter than the least distance of two extrema of W, so W has at most one extremum in it. If W is not
    /// positive at the end, it has exactly one zero. If W is positive at the end and the extremum is a maximum, it has
    /// none. Two extrema are at least π/√(κ + δ) apart: Z = W′ obeys Z″ + (pZ)′ + κZ = 0 with p = 2ζ − dr/dW, whose
    /// zeros are at least as far apart (Sturm) with δ = max p′/2 ≤ (weakening gain × curvature) × max |W′|.
    pub(super) fn step(&mut self, consts: &Consts, states: &mut States, until: f64, cuts: &mut Cuts) {
        wide::<Step, _>((self, consts, states, until, cuts));
    }

    #[inline(always)]
    fn step_in_place(&mut self, consts: &Consts, states: &mut States, until: f64, cuts: &mut Cuts) {
        self.expand(consts, states);
        let (w0, slope0) = (self.w[0], self.w[1]);
        let remaining = each(|l| until - states.tau[l]);
        let left = each(|l| states.span[l] - states.passed[l]);
        let reach = self.reach(states, if N == STEADY { STEADY_TOLERANCE } else { NOISY_TOLERANCE });
        let quickest = each(|l| slope0[l].abs() + 2.0 * (1.0 + states.kappa[l].abs()) * (1.0 + w0[l]));
        let mut cap = each(|l| {
            let stiffness = larger(states.kappa[l] + consts.softening[l] * quickest[l], 0.1);
            // A falling W that arrives does so soon, and must not return before the end of the step.
            let fall = if slope0[l] < 0.0 { FALLS * w0[l] / -slope0[l] } else { f64::INFINITY };
            smaller(smaller(reach[l], fall), smaller(EXTREMA * PI / stiffness.sqrt(), remaining[l]))
        });
        if EXPONENTIAL {
            self.limit_exponential_steps(consts, &mut cap);
        }
        (cuts.trial, cuts.tau, cuts.passed, cuts.excess) = (cap, states.tau, states.passed, states.e);
        let (mut h, mut crossed) = (cap, [0.0; LANES]);
        if N == NOISY {
            let (t, found) = self.crossing(&left, &cap);
            crossed = found;
            h = each(|l| choose(found[l], t[l], cap[l]));
        }
        let (mut w, mut slope) = value_and_slope(&self.w, &h);
        let arrived = each(|l| flag(w[l] <= 0.0));
        // A minimum inside the step may lie below zero.
        let mut unsure = each(|l| flag((w[l] > 0.0) & (slope0[l] < 0.0) & (slope[l] > 0.0)));
        if any(&unsure) {
            let floor = lower_bound(&self.w, &h);
            unsure = each(|l| unsure[l] * flag(floor[l] <= 0.0));
        }
        unsure = each(|l| larger(unsure[l], flag(slope[l].abs() > quickest[l])));
        if any(&arrived) {
            // Arrivals are searched before grid points: after an arrival the distance would run backwards.
            let (t, end, found) = self.arrival(consts, states, &h, &w, &slope);
            unsure = each(|l| larger(unsure[l], arrived[l] * (1.0 - found[l])));
            crossed = each(|l| crossed[l] * (1.0 - arrived[l]));
            h = each(|l| choose(arrived[l], t[l], h[l]));
            w = each(|l| choose(arrived[l], 0.0, w[l]));
            slope = each(|l| choose(arrived[l], end[l], slope[l]));
        }
        let distance = value(&self.s, &h);
        let distance = each(|l| h[l] * distance[l]);
        // A grid point that was not found, or lies before an arrival.
        unsure = each(|l| larger(unsure[l], (1.0 - crossed[l]) * flag(distance[l] >= left[l])));
        states.w = w;
        states.e = each(|l| cuts.excess[l] + states.direction[l] * h[l] - states.kappa[l] * distance[l]);
        states.fastest = each(|l| larger(states.fastest[l], w[l]));
        let turned = each(|l| flag((slope0[l] > 0.0) & (slope[l] < 0.0)));
        // In a step with one maximum the largest slope bounds the rise of W.
        let ceiling = each(|l| larger(w0[l], w[l]) + turned[l] * h[l] * quickest[l]);
        cuts.turned = each(|l| turned[l] * flag(states.fastest[l] <= 1.0));
        cuts.weak = each(|l| {
            let loss = consts.loss[l] - states.least[l] * consts.thinning[l];
            flag(consts.floor[l] + states.least[l] <= ceiling[l] * loss)
        });
        states.tau = each(|l| choose(flag(h[l] == remaining[l]), until, states.tau[l] + h[l]));
        states.passed = each(|l| choose(crossed[l], 0.0, states.passed[l] + distance[l]));
        let calm = each(|l| {
            let seen = larger(larger(unsure[l], arrived[l]), larger(cuts.turned[l], cuts.weak[l]));
            (1.0 - seen) * flag(states.tau[l] < until)
        });
        cuts.plain = each(|l| crossed[l] * calm[l]);
        cuts.quiet = each(|l| (1.0 - crossed[l]) * calm[l] * flag(h[l] > 0.0));
        (cuts.h, cuts.crossed, cuts.arrived, cuts.unsure) = (h, crossed, arrived, unsure);
    }

    /// Shortens the steps on which e^{−cW} rises more steeply than its series can represent.
    #[inline(always)]
    fn limit_exponential_steps(&self, consts: &Consts, cap: &mut Lane) {
        let lowest = lower_bound(&self.w, cap);
        let steep = each(|l| flag(consts.curvature[l] * (self.w[0][l] - lowest[l]) > N as f64 / 3.0));
        if any(&steep) {
            for (l, h) in cap.iter_mut().enumerate() {
                let w: [f64; N] = std::array::from_fn(|k| self.w[k][l]);
                *h = exponential_step(&w, consts.curvature[l], *h);
            }
        }
    }

    /// Recomputes the end of the step of one lane by the slow, certain method, from the state at the start of the step.
    pub(super) fn recompute_end(&self, lane: usize, states: &mut States, until: f64, cuts: &mut Cuts) {
        let of = |c: &[Lane; N]| -> [f64; N] { std::array::from_fn(|k| c[k][lane]) };
        let (w, s) = (of(&self.w), of(&self.s));
        let mut h = cuts.trial[lane];
        let leading = w.iter().take(2).take_while(|c| **c == 0.0).count();
        let arrival = polynomial::first_zero(&w[leading..], h);
        h = arrival.unwrap_or(h);
        let left = states.span[lane] - cuts.passed[lane];
        let distance = |t: f64| t * polynomial::value(&s, t);
        let crossed = distance(h) >= left;
        if crossed {
            let excess = |t: f64| (distance(t) - left, polynomial::value(&w, t));
            h = polynomial::bracketed_zero(excess, 0.0, h, false, 0.5 * h);
        }
        let arrived = arrival.is_some() && !crossed;
        (cuts.crossed[lane], cuts.arrived[lane], cuts.unsure[lane]) = (flag(crossed), flag(arrived), 0.0);
        cuts.h[lane] = h;
        let rises = w[1] > 0.0 || leading > 0;
        let end = polynomial::value_and_slope(&w, h);
        states.w[lane] = if arrived { 0.0 } else { end.0.max(0.0) };
        states.e[lane] = cuts.excess[lane] + states.direction[lane] * h - states.kappa[lane] * distance(h);
        states.tau[lane] = if h == until - cuts.tau[lane] { until } else { cuts.tau[lane] + h };
        states.passed[lane] = if crossed { 0.0 } else { cuts.passed[lane] + distance(h) };
        states.fastest[lane] = states.fastest[lane].max(states.w[lane]);
        cuts.turned[lane] = flag(rises && (end.1 < 0.0 || arrived) && states.fastest[lane] <= 1.0);
    }

    /// Returns the first maximum of W inside the last step of a lane in which W rises at the start.
    pub(super) fn highest(&self, lane: usize, h: f64) -> f64 {
        let w: [f64; N] = std::array::from_fn(|k| self.w[k][lane]);
        if polynomial::upper_bound(&w, h) <= 1.0 {
            return 0.0;
        }
        let slope = polynomial::derivative(&w);
        let leading = slope.iter().take(2).take_while(|c| **c == 0.0).count();
        polynomial::first_zero(&slope[leading..N - 1], h).map_or(0.0, |t| polynomial::value(&w, t))
    }
}

struct Step;

impl<const N: usize, const EXPONENTIAL: bool>
    Kernel<(&mut Expansion<N, EXPONENTIAL>, &Consts, &mut States, f64, &mut Cuts)> for Step
{
    type Output = ();

    #[inline(always)]
    fn run(
        (expansion, consts, states, until, cuts): (
            &mut Expansion<N, EXPONENTIAL>,
            &Consts,
            &mut States,
            f64,
            &mut Cuts,
        ),
    ) {
        expansion.step_in_place(consts, states, until, cuts);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_exponential_matches_the_mathematical_library_to_rounding() {
        for i in -14_000..14_000 {
            let x = f64::from(i) * 0.049_73;
            let (whole, less_one) = exponential(x);
            assert!((whole / x.exp() - 1.0).abs() < 4e-16, "{x}: {whole:e}");
            assert!((less_one - x.exp_m1()).abs() <= 4e-16 * x.exp_m1().abs(), "{x}: {less_one:e}");
        }
        for x in [1e-300, -1e-17, 3e-9, -2e-4, 0.01, -0.3] {
            assert!((exponential(x).1 / f64::exp_m1(x) - 1.0).abs() < 4e-16, "{x}");
        }
        assert_eq!((exponential(0.0), exponential(-1e6)), ((1.0, 0.0), exponential(-700.0)));
    }
}
