//! Shape of S_B by quadrature.
//!
//! u = 1/(1 + e^{−t}) with t = τ + σg, σ = 1/δ and τ = −γ/δ. The moments are integrals over g by the trapezoidal rule;
//! the nearest poles are at Im g = πδ, so a step of 0.4 δ gives an error of e^{−2π²/0.4} = 4e-22.

use super::super::moments::Exact;
use super::super::special::standard_normal_pdf;
use crate::numeric::root_between;

/// Least δ: closer to two point masses the quadrature is slow, and such height distributions do not occur.
const LEAST_DELTA: f64 = 2e-3;
/// Largest |γ|: beyond it, one end has a probability of less than 1e-300.
const LARGEST_GAMMA: f64 = 37.0;
/// Half width of the integration range over the normal density; φ(9.5) = 1e-20.
const REACH: f64 = 9.5;

/// Returns the moments of u.
pub(in crate::distribution) fn unit_moments(gamma: f64, delta: f64) -> Exact {
    // 1 − u has the parameters −γ and δ.
    let mirrored = low_moments(gamma.abs() / delta, 1.0 / delta);
    if gamma >= 0.0 { mirrored } else { Exact { mean: 1.0 - mirrored.mean, skewness: -mirrored.skewness, ..mirrored } }
}

/// Returns the moments of 1/(1 + e^{depth − σg}), depth = −τ ≥ 0.
fn low_moments(depth: f64, sigma: f64) -> Exact {
    let step = f64::min(0.25, 0.4 / sigma);
    // y⁴φ(g) is largest at 4σ, or where u saturates.
    let top = REACH + f64::min(4.0 * sigma, depth / sigma);
    let (first, last) = (-(REACH / step).ceil() as i64, (top / step).ceil() as i64);
    let start = (-depth).exp();
    let deviation = |g: f64| {
        if sigma > 5.0 {
            // Values at both ends: no cancellation, but e^{σg} would overflow.
            return 1.0 / (1.0 + (depth - sigma * g).exp());
        }
        // (u(t) − u(τ)) e^{−τ}, which is accurate for small σ and for small u.
        let fall = (-sigma * g.abs()).exp_m1();
        let rest = if g > 0.0 { 1.0 + fall + start } else { 1.0 + start * (1.0 + fall) };
        if g > 0.0 { -fall / (rest * (1.0 + start)) } else { fall / (rest * (1.0 + start)) }
    };
    let nodes: Vec<(f64, f64)> =
        (first..=last).map(|i| step * i as f64).map(|g| (step * standard_normal_pdf(g), deviation(g))).collect();
    let scale = nodes.iter().map(|(_, y)| y.abs()).fold(0.0, f64::max);
    let sum = |f: &dyn Fn(f64) -> f64| nodes.iter().map(|(weight, y)| weight * f(y / scale)).sum::<f64>();
    let mean = sum(&|y| y);
    let central = |power: i32| sum(&|y| (y - mean).powi(power));
    let variance = central(2);
    let (unit, origin) = if sigma > 5.0 { (1.0, 0.0) } else { (start, start / (1.0 + start)) };
    Exact {
        mean: origin + unit * scale * mean,
        std: unit * scale * variance.sqrt(),
        skewness: central(3) / variance.powf(1.5),
        excess_kurtosis: central(4) / (variance * variance) - 3.0,
    }
}

/// Returns (γ, δ) of the distribution of this shape, skewness ≥ 0, with a kurtosis below that of the lognormal
/// distribution with e^{1/δ²} − 1 = `lognormal_d`; `None` if it is too close to two point masses.
///
/// At each δ the skewness decreases with the depth from that of the lognormal distribution to zero, and at constant
/// skewness the kurtosis increases with δ up to that of the lognormal distribution: two nested root searches.
pub(super) fn solve(skewness: f64, excess: f64, lognormal_d: f64) -> Option<(f64, f64)> {
    let largest = if skewness == 0.0 { largest_symmetric_delta(excess) } else { 1.0 / lognormal_d.ln_1p().sqrt() };
    let surplus = |log_delta: f64| {
        let sigma = (-log_delta).exp();
        low_moments(depth(skewness, sigma), sigma).excess_kurtosis - excess
    };
    let mut high = [largest.ln(), surplus(largest.ln()).max(0.0)];
    let log_delta = loop {
        // Small δ are expensive, so the bracket is extended towards them.
        let low = f64::max(high[0] - 1.0, LEAST_DELTA.ln());
        let at_low = surplus(low);
        if at_low <= 0.0 {
            break root_between(surplus, [low, at_low], high)?;
        }
        if low <= LEAST_DELTA.ln() {
            return None;
        }
        high = [low, at_low];
    };
    let delta = log_delta.exp();
    Some((delta * depth(skewness, 1.0 / delta), delta))
}

/// The symmetric distribution tends to the normal one as kurtosis − 3 → −2/δ² + O(δ⁻⁴), from above.
fn largest_symmetric_delta(excess: f64) -> f64 {
    2.0 * (2.0 / -excess).sqrt().max(1.0)
}

/// Returns the depth at which the distribution with this σ has this skewness; the largest depth if even the lognormal
/// limit has less.
fn depth(skewness: f64, sigma: f64) -> f64 {
    if skewness == 0.0 {
        return 0.0;
    }
    let surplus = |depth: f64| low_moments(depth, sigma).skewness - skewness;
    let (mut near, mut at_near, mut far) = (0.0, -skewness, 0.5 * sigma);
    // e^{−745} is the least positive double: beyond it the distribution is lognormal in double precision.
    let farthest = if sigma > 5.0 { LARGEST_GAMMA * sigma } else { 745.0 };
    loop {
        let at_far = surplus(far);
        if at_far >= 0.0 {
            return root_between(surplus, [near, at_near], [far, at_far]).unwrap_or(f64::NAN);
        }
        if far >= farthest {
            return far;
        }
        (near, at_near, far) = (far, at_far, f64::min(2.0 * far, farthest));
    }
}
