//! Shape of S_U.
//!
//! With d = e^{1/δ²} − 1, ω = 1 + d and m = (ω² − 1)/(1 + ω cosh(2γ/δ)), which lies between 0 (lognormal) and d
//! (symmetric),
//!
//! skewness² = (d − m)(3 + d + m/2)²,  kurtosis − 3 = d(ω³ + 3ω² + 6ω + 6) − (ω² + 2ω + 3)(2m + m²/2).
//!
//! # References
//! Johnson, *Biometrika* **36** (1949) 149; Tuenter, *J. Stat. Comput. Simul.* **70** (2001) 325,
//! <https://doi.org/10.1080/00949650108812126>, for m and the uniqueness of the solution.

use super::super::moments::Exact;
use crate::numeric::root_between;

/// Returns the moments of sinh((g − γ)/δ).
pub(in crate::distribution) fn unit_moments(gamma: f64, delta: f64) -> Exact {
    let (d, shift) = ((1.0 / (delta * delta)).exp_m1(), gamma / delta);
    let omega = 1.0 + d;
    // All terms are divided by powers of e^{|Ω|}, Ω = γ/δ, to avoid overflow.
    let a = (-2.0 * shift.abs()).exp();
    let (cosh_2, cosh_4) = (0.5 * (1.0 + a * a), 0.5 * (1.0 + a.powi(4)));
    let (sinh_1, sinh_3) = (-0.5 * a * (-2.0 * shift.abs()).exp_m1(), -0.5 * (-6.0 * shift.abs()).exp_m1());
    let v = omega * cosh_2 + a;
    let excess = d
        * (omega * omega * (omega * (omega * (omega + 3.0) + 6.0) + 6.0) * cosh_4
            + 4.0 * omega * (omega + 3.0) * cosh_2 * a
            - 3.0 * d * a * a)
        / (2.0 * v * v);
    let skewness = (0.5 * omega * d).sqrt() * (omega * (omega + 2.0) * sinh_3 + 3.0 * sinh_1) / v.powf(1.5);
    Exact {
        mean: -omega.sqrt() * shift.sinh(),
        std: (0.5 * d * v).sqrt() * shift.abs().exp(),
        skewness: -skewness.copysign(shift),
        excess_kurtosis: excess,
    }
}

/// Returns (γ, δ) of the distribution of this shape, skewness ≥ 0, if its kurtosis is above that of the lognormal
/// distribution; otherwise `None`.
///
/// At constant skewness the kurtosis increases with ω, from that of the lognormal distribution to infinity. At each ω
/// the difference n = d − m follows from the skewness, which avoids cancellation near the symmetric distributions,
/// where m ≈ d.
pub(super) fn solve(skewness: f64, excess: f64, lognormal_d: f64) -> Option<(f64, f64)> {
    let square = skewness * skewness;
    // The symmetric distribution of this kurtosis has the largest ω: (ω⁴ + 2ω² + 3)/2 = kurtosis.
    let h = 2.0 * excess / (2.0 + (4.0 + 2.0 * excess).sqrt());
    let largest_d = h / (1.0 + (1.0 + h).sqrt());
    let surplus = |d: f64| {
        let omega = 1.0 + d;
        let m = d - deficit(d, square);
        let lognormal = d * (omega * (omega * (omega + 3.0) + 6.0) + 6.0);
        lognormal - (omega * (omega + 2.0) + 3.0) * m * (2.0 + 0.5 * m) - excess
    };
    let d = if skewness == 0.0 {
        largest_d
    } else {
        root_between(surplus, [lognormal_d, surplus(lognormal_d)], [largest_d, surplus(largest_d).max(0.0)])?
    };
    let n = deficit(d, square);
    let m = d - n;
    // sinh²(γ/δ) = (ω + 1)n/(2ωm).
    let shift = ((2.0 + d) * n / (2.0 * (1.0 + d) * m)).sqrt().asinh();
    let delta = 1.0 / d.ln_1p().sqrt();
    (m > 0.0 && delta.is_finite()).then_some((-shift * delta, delta))
}

/// Returns the n in [0, d] with n (3 + d + (d − n)/2)² = skewness² by Newton's method on an increasing function.
fn deficit(d: f64, square: f64) -> f64 {
    let mut n = (square / (3.0 + d).powi(2)).min(d);
    for _ in 0..100 {
        let w = 3.0 + d + 0.5 * (d - n);
        let step = (n * w * w - square) / (w * (w - n));
        n = (n - step).clamp(0.0, d);
        if step.abs() <= 1e-16 * n {
            break;
        }
    }
    n
}
