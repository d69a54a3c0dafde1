//! Polynomials that are orthonormal under the distribution of a standard variable.
//!
//! # References
//! Xiu & Karniadakis, *SIAM J. Sci. Comput.* **24** (2002) 619, <https://doi.org/10.1137/S1064827501387826>.

use serde::Serialize;

/// Distribution of a standard variable and its orthonormal polynomials ψ₀ = 1, ψ₁, ψ₂, …: E ψ_m ψ_n = δ_mn.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
pub enum PolynomialFamily {
    /// Standard normal variable; ψ_n = He_n/√n! with the probabilists' Hermite polynomials He_n.
    Hermite,
    /// Variable uniform on [−1, 1]; ψ_n = √(2n+1) P_n with the Legendre polynomials P_n.
    Legendre,
}

impl PolynomialFamily {
    /// Writes ψ₀(x), ψ₁(x), … into `values` by the three-term recurrence.
    ///
    /// Hermite: √(n+1) ψ_{n+1} = x ψ_n − √n ψ_{n−1}. Legendre: b_{n+1} ψ_{n+1} = x ψ_n − b_n ψ_{n−1} with
    /// b_n = n/√(4n²−1).
    pub fn fill_orthonormal(self, x: f64, values: &mut [f64]) {
        let mut before = 0.0;
        let mut now = 1.0;
        let mut b_now = 0.0;
        for (n, value) in values.iter_mut().enumerate() {
            *value = now;
            let b_next = self.recurrence(n + 1);
            (before, now) = (now, (x * now - b_now * before) / b_next);
            b_now = b_next;
        }
    }

    /// Returns b_n of the recurrence b_{n+1} ψ_{n+1} = x ψ_n − b_n ψ_{n−1}, which is symmetric for both families.
    pub(super) fn recurrence(self, n: usize) -> f64 {
        let n = n as f64;
        match self {
            Self::Hermite => n.sqrt(),
            Self::Legendre => n / (4.0 * n * n - 1.0).sqrt(),
        }
    }

    /// Returns the value of the standard variable whose distribution function equals `u`, 0 < u < 1.
    pub fn from_unit(self, u: f64) -> f64 {
        match self {
            Self::Hermite => asperity_base::distribution::standard_normal_quantile(u),
            Self::Legendre => 2.0 * u - 1.0,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use asperity_base::numeric::symmetric_eigen;
    use ndarray::Array2;

    /// Returns the Gauss rule (nodes, weights) for the distribution of the family, from the eigenvalues of its Jacobi
    /// matrix (Golub & Welsch, *Math. Comp.* 23 (1969) 221).
    fn gauss_rule(family: PolynomialFamily, points: usize) -> Vec<(f64, f64)> {
        let entry = |(i, j): (usize, usize)| if i.abs_diff(j) == 1 { family.recurrence(i.max(j)) } else { 0.0 };
        let eigen = symmetric_eigen(Array2::from_shape_fn((points, points), entry)).unwrap();
        (0..points).map(|k| (eigen.values[k], eigen.vectors[[k, 0]].powi(2))).collect()
    }

    fn values(family: PolynomialFamily, count: usize, x: f64) -> Vec<f64> {
        let mut values = vec![0.0; count];
        family.fill_orthonormal(x, &mut values);
        values
    }

    /// Returns the unnormalised coefficient c_n = E f He_n / n! by Simpson's rule on [low, 12].
    fn hermite_coefficient(n: usize, low: f64, f: impl Fn(f64) -> f64) -> f64 {
        let factorial: f64 = (1..=n).map(|k| k as f64).product();
        let intervals = 20_000;
        let step = (12.0 - low) / f64::from(intervals);
        let integrand = |x: f64| {
            let density = (-0.5 * x * x).exp() / std::f64::consts::TAU.sqrt();
            f(x) * values(PolynomialFamily::Hermite, n + 1, x)[n] * density / factorial.sqrt()
        };
        (0..=intervals)
            .map(|i| {
                let weight = if i == 0 || i == intervals { 1.0 } else { f64::from(2 + 2 * (i % 2)) };
                weight * integrand(low + f64::from(i) * step)
            })
            .sum::<f64>()
            * step
            / 3.0
    }

    #[test]
    fn low_degrees_are_the_textbook_polynomials() {
        let x = 1.7_f64;
        let hermite = values(PolynomialFamily::Hermite, 4, x);
        let legendre = values(PolynomialFamily::Legendre, 4, x);
        let wanted_hermite = [1.0, x, (x * x - 1.0) / 2.0_f64.sqrt(), (x.powi(3) - 3.0 * x) / 6.0_f64.sqrt()];
        let wanted_legendre = [
            1.0,
            3.0_f64.sqrt() * x,
            5.0_f64.sqrt() * (3.0 * x * x - 1.0) / 2.0,
            7.0_f64.sqrt() * (5.0 * x.powi(3) - 3.0 * x) / 2.0,
        ];
        for n in 0..4 {
            assert!((hermite[n] - wanted_hermite[n]).abs() < 1e-14);
            assert!((legendre[n] - wanted_legendre[n]).abs() < 1e-13);
        }
    }

    #[test]
    fn polynomials_are_orthonormal_under_gauss_quadrature() {
        for family in [PolynomialFamily::Hermite, PolynomialFamily::Legendre] {
            let rule = gauss_rule(family, 14);
            for m in 0..=12 {
                for n in 0..=m {
                    let inner: f64 = rule
                        .iter()
                        .map(|&(x, weight)| {
                            let psi = values(family, 13, x);
                            weight * psi[m] * psi[n]
                        })
                        .sum();
                    let wanted = if m == n { 1.0 } else { 0.0 };
                    assert!((inner - wanted).abs() < 1e-11, "{family:?}: E ψ{m} ψ{n} = {inner}");
                }
            }
        }
    }

    #[test]
    fn the_exponential_has_its_closed_coefficients() {
        let sigma = 0.8_f64;
        let mut closed = (0.5 * sigma * sigma).exp();
        for n in 0..9 {
            let found = hermite_coefficient(n, -12.0, |x| (sigma * x).exp());
            assert!((found - closed).abs() < 1e-11, "c_{n} = {found}, wanted {closed}");
            closed *= sigma / (n + 1) as f64;
        }
    }

    #[test]
    fn the_clipped_variable_has_its_published_coefficients() {
        let published = [0.398_942_28, 0.5, 0.199_471_14, 0.0, -0.016_622_60];
        for (n, wanted) in published.into_iter().enumerate() {
            let found = hermite_coefficient(n, 0.0, |x| x);
            assert!((found - wanted).abs() < 1e-8, "c_{n} = {found}, wanted {wanted}");
        }
    }
}
