//! Modes: zeros of a real polynomial of degree four, as pairs.

use serde::{Deserialize, Serialize};

/// Eigenvalue: motion grows like e^{growth·τ} and oscillates with an angular frequency.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct Mode {
    /// Real part.
    pub growth: f64,
    /// Imaginary part ≥ 0.
    pub frequency: f64,
}

impl Mode {
    pub(super) fn minus(self, other: Self) -> Self {
        Self { growth: self.growth - other.growth, frequency: self.frequency - other.frequency }
    }

    pub(super) fn size(self) -> f64 {
        self.growth.hypot(self.frequency)
    }
}

/// Complex number. Products are not fused, so results are the same on every machine.
#[derive(Debug, Clone, Copy)]
struct Complex {
    re: f64,
    im: f64,
}

impl Complex {
    fn plus(self, other: Self) -> Self {
        Self { re: self.re + other.re, im: self.im + other.im }
    }

    fn minus(self, other: Self) -> Self {
        Self { re: self.re - other.re, im: self.im - other.im }
    }

    fn times(self, other: Self) -> Self {
        Self { re: self.re * other.re - self.im * other.im, im: self.re * other.im + self.im * other.re }
    }

    fn over(self, other: Self) -> Self {
        let size = other.re * other.re + other.im * other.im;
        let product = self.times(Self { re: other.re, im: -other.im });
        Self { re: product.re / size, im: product.im / size }
    }

    fn size(self) -> f64 {
        self.re.hypot(self.im)
    }
}

/// Largest number of iterations; Aberth's method needs about ten, and about fifty at a double zero.
const MAX_ITERATIONS: usize = 200;
/// Imaginary part, relative to the largest zero, below which a zero counts as real: rounding splits a double zero by
/// this amount.
const REAL: f64 = 1e-7;

/// Returns the zeros of λ⁴ + a₃λ³ + a₂λ² + a₁λ + a₀ as two pairs. Of two conjugate zeros the one above the real axis is
/// returned, of two real zeros the larger. A double zero is accurate to half the digits, the limit of every method that
/// uses the coefficients only.
///
/// # References
/// Aberth, *Math. Comp.* **27** (1973) 339, <https://doi.org/10.1090/S0025-5718-1973-0329236-7>.
pub(super) fn pairs([a0, a1, a2, a3]: [f64; 4]) -> [Mode; 2] {
    // Every zero lies inside this circle (Fujiwara).
    let radius = 2.0 * a3.abs().max(a2.abs().sqrt()).max(a1.abs().cbrt()).max(a0.abs().sqrt().sqrt());
    if radius == 0.0 {
        return [Mode { growth: 0.0, frequency: 0.0 }; 2];
    }
    // The starts are not symmetric about the real axis, because conjugate starts would never find real zeros.
    let start = |angle: f64| Complex { re: 0.5 * radius * angle.cos(), im: 0.5 * radius * angle.sin() };
    let mut zeros = [0.4, 2.1, 3.6, 5.3].map(start);
    for _ in 0..MAX_ITERATIONS {
        let mut moved = 0.0_f64;
        for i in 0..4 {
            let z = zeros[i];
            let (mut value, mut slope) = (Complex { re: 1.0, im: 0.0 }, Complex { re: 0.0, im: 0.0 });
            for a in [a3, a2, a1, a0] {
                slope = slope.times(z).plus(value);
                value = value.times(z).plus(Complex { re: a, im: 0.0 });
            }
            if value.size() == 0.0 {
                continue;
            }
            let mut repulsion = Complex { re: 0.0, im: 0.0 };
            for (j, &other) in zeros.iter().enumerate() {
                let apart = z.minus(other);
                if j != i && apart.size() > 0.0 {
                    repulsion = repulsion.plus(Complex { re: 1.0, im: 0.0 }.over(apart));
                }
            }
            // Newton's step n/(1 − n·repulsion), as value/(slope − value·repulsion).
            let step = value.over(slope.minus(value.times(repulsion)));
            if !step.size().is_finite() {
                continue;
            }
            zeros[i] = z.minus(step);
            moved = moved.max(step.size());
        }
        if moved <= 4.0 * f64::EPSILON * radius {
            break;
        }
    }
    let mut above: Vec<Mode> =
        zeros.iter().filter(|z| z.im > REAL * radius).map(|z| Mode { growth: z.re, frequency: z.im }).collect();
    let mut real: Vec<f64> = zeros.iter().filter(|z| z.im.abs() <= REAL * radius).map(|z| z.re).collect();
    real.sort_by(|a, b| b.total_cmp(a));
    above.extend(real.chunks(2).map(|pair| Mode { growth: pair[0], frequency: 0.0 }));
    above.sort_by(|a, b| a.frequency.total_cmp(&b.frequency).then(a.growth.total_cmp(&b.growth)));
    let nothing = Mode { growth: f64::NAN, frequency: f64::NAN };
    [above.first().copied().unwrap_or(nothing), above.get(1).copied().unwrap_or(nothing)]
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Returns the coefficients of (λ² + pλ + q)(λ² + rλ + s).
    fn product(p: f64, q: f64, r: f64, s: f64) -> [f64; 4] {
        [q * s, p * s + q * r, q + s + p * r, p + r]
    }

    fn pair(p: f64, q: f64) -> Mode {
        let discriminant = 0.25 * p * p - q;
        if discriminant < 0.0 {
            Mode { growth: -0.5 * p, frequency: (-discriminant).sqrt() }
        } else {
            Mode { growth: -0.5 * p + discriminant.sqrt(), frequency: 0.0 }
        }
    }

    #[test]
    fn zeros_match_the_two_quadratic_factors() {
        for (p, q, r, s) in [
            (0.1, 1.0, 0.3, 3.0),
            (-0.2, 2.0, 0.2, 2.0),
            (0.0, 1.0, 0.0, 4.0),
            (5.0, 1.0, 0.1, 9.0),
            (1e-3, 1e4, 1e-3, 1e-2),
        ] {
            let found = pairs(product(p, q, r, s));
            let (first, second) = (pair(p, q), pair(r, s));
            let scale = q.sqrt().max(s.sqrt()).max(p).max(r);
            let near = |m: Mode, w: Mode| (m.growth - w.growth).hypot(m.frequency - w.frequency) < 2e-14 * scale;
            let matched =
                (near(found[0], first) && near(found[1], second)) || (near(found[0], second) && near(found[1], first));
            assert!(matched, "{p} {q} {r} {s}: {found:?}, not {first:?} {second:?}");
        }
    }

    #[test]
    fn four_real_zeros_return_the_largest_and_the_third() {
        let found = pairs(product(3.0, 2.0, 12.0, 35.0));
        assert!((found[0].growth + 5.0).abs() < 1e-12 && (found[1].growth + 1.0).abs() < 1e-12, "{found:?}");
    }

    #[test]
    fn a_double_zero_is_accurate_to_half_the_digits() {
        let found = pairs(product(0.2, 2.0, 0.2, 2.0));
        for mode in found {
            let wanted = pair(0.2, 2.0);
            assert!((mode.growth - wanted.growth).hypot(mode.frequency - wanted.frequency) < 1e-7, "{found:?}");
        }
    }
}
