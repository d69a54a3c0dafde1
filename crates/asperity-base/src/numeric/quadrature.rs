//! Nodes and weights of quadrature.

use std::array;
use std::f64::consts::PI;

/// Returns the nodes, falling, and weights of the Gauss–Legendre rule of N points on [−1, 1], by Newton's method.
pub fn gauss_legendre<const N: usize>() -> [(f64, f64); N] {
    let n = N as f64;
    // Legendre's polynomial P_N and its derivative.
    let at = |x: f64| {
        let (mut p, mut before) = (x, 1.0);
        for k in 2..=N {
            let k = k as f64;
            (p, before) = (((2.0 * k - 1.0) * x * p - (k - 1.0) * before) / k, p);
        }
        (p, n * (x * p - before) / (x * x - 1.0))
    };
    array::from_fn(|i| {
        let mut x = -(PI * ((N - 1 - i) as f64 + 0.75) / (n + 0.5)).cos();
        for _ in 0..8 {
            let (p, slope) = at(x);
            x -= p / slope;
        }
        let (_, slope) = at(x);
        (x, 2.0 / ((1.0 - x * x) * slope * slope))
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_rule_of_n_points_integrates_polynomials_of_degree_2n_minus_1() {
        let rule = gauss_legendre::<6>();
        for degree in 0..12 {
            let found: f64 = rule.iter().map(|(x, weight)| weight * x.powi(degree)).sum();
            let wanted = if degree % 2 == 0 { 2.0 / f64::from(degree + 1) } else { 0.0 };
            assert!((found - wanted).abs() < 1e-15, "{degree}: {found}");
        }
    }
}
