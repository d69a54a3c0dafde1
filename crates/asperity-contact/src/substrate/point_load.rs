//! Change of the displacement about a point load by a layer, on the free boundary.
//!
//! A point load F displaces the surface of a half-space by F/(πE*r). A layer of thickness h adds F/(πE*h)·Φ(r/h) with
//! Φ(ρ) = ∫₀^∞ (R(s) − 1) J₀(sρ) ds, where R is the ratio of the compliances. R − 1 decays as s²e^{−2s}, so Φ is smooth
//! on the scale of the layer and, far away, on the scale of the distance. It is integrated by Gauss' rule at the
//! Chebyshev points of [0, 1], [1, 2], [2, 4], …. Far away only waves as long as the distance contribute. A window ½
//! erfc((s − 6δ)/δ) removes the others with an error of e^{−(ρδ)²/4}. The integral over a cell is by Gauss' rule; cells
//! that are large against their distance and the layer are split. The error is less than 10⁻¹⁰ of the displacement of a
//! half-space by the cell's own pressure.

use std::f64::consts::PI;

use statrs::function::erf::erfc;

use super::{Base, Layer};
use asperity_base::blocks;
use asperity_base::map::Grid;
use asperity_base::numeric::gauss_legendre;

/// Number of Chebyshev points of a piece. The nearest singularity, a mirrored load at depth 2h, leaves an error of 6⁻¹⁶.
const NODES: usize = 16;
/// Upper limit of the integral, at which R − 1 ~ e^{−2s} is negligible.
const END: f64 = 22.0;
/// ρδ of the window, and the end of the window over δ.
const WINDOW: f64 = 13.0;
const WINDOW_END: f64 = 12.0;
/// Largest ratio of cell side to distance for which 2, 3 and 5 points in either direction suffice.
const TINY: f64 = 0.006;
const SMALL: f64 = 0.05;
const LARGE: f64 = 0.25;

/// Change of the displacement by a layer, as a function of the distance.
#[derive(Debug, Clone)]
pub(crate) struct PointLoad {
    thickness_m: f64,
    /// 1/(πE*h) in 1/(Pa·m): displacement over force.
    unit: f64,
    /// Chebyshev coefficients of Φ on [0, 1], [1, 2], [2, 4], …
    pieces: Vec<[f64; NODES]>,
    /// Nodes and weights of Gauss' rules for cells.
    two: [(f64, f64); 2],
    three: [(f64, f64); 3],
    five: [(f64, f64); 5],
}

impl PointLoad {
    /// Tabulates Φ for distances up to `reach_m`.
    pub(crate) fn new(layer: &Layer, reach_m: f64) -> Self {
        let reach = reach_m / layer.thickness_m;
        let mut pieces = Vec::new();
        let mut end = 1.0;
        while pieces.is_empty() || 0.5 * end < reach {
            pieces.push(piece(layer, if pieces.is_empty() { 0.0 } else { 0.5 * end }, end));
            end *= 2.0;
        }
        let unit = 1.0 / (PI * layer.material.contact_modulus_pa() * layer.thickness_m);
        Self {
            thickness_m: layer.thickness_m,
            unit,
            pieces,
            two: gauss_legendre(),
            three: gauss_legendre(),
            five: gauss_legendre(),
        }
    }

    /// Returns Φ at the distance ρ over the thickness, within the tabulated range.
    fn at(&self, rho: f64) -> f64 {
        let index = if rho < 1.0 { 0 } else { 1 + rho.log2() as usize }.min(self.pieces.len() - 1);
        let end = (index as f64).exp2();
        let start = if index == 0 { 0.0 } else { 0.5 * end };
        clenshaw(&self.pieces[index], (2.0 * rho - start - end) / (end - start))
    }

    /// Returns the change of the influence coefficients of a grid by the layer in m/Pa: row-major by the cells between
    /// source and target along either axis.
    pub(crate) fn coefficients_m_per_pa(&self, grid: Grid) -> Vec<f64> {
        let (nx, dx_m, dy_m) = (grid.nx(), grid.dx_m(), grid.dy_m());
        let mut coefficients = vec![0.0; grid.points()];
        blocks::for_each(coefficients.chunks_mut(nx).enumerate(), |(row, coefficients)| {
            for (column, coefficient) in coefficients.iter_mut().enumerate() {
                *coefficient = self.coefficient_m_per_pa(column as f64 * dx_m, row as f64 * dy_m, dx_m, dy_m);
            }
        });
        coefficients
    }

    /// Returns the change by the layer of the displacement at (x, y) by a unit pressure on the rectangle `dx_m` ×
    /// `dy_m` about the origin, in m/Pa.
    fn coefficient_m_per_pa(&self, x_m: f64, y_m: f64, dx_m: f64, dy_m: f64) -> f64 {
        self.unit * self.over_rectangle([x_m, y_m], [dx_m, dy_m])
    }

    /// Returns ∬ Φ over a rectangle, in m².
    fn over_rectangle(&self, centre: [f64; 2], sides: [f64; 2]) -> f64 {
        let [x, y] = centre;
        // The scale of Φ is the distance from the nearest point of the cell, or from a load mirrored in the base.
        let nearest = (x.abs() - 0.5 * sides[0]).max(0.0).hypot((y.abs() - 0.5 * sides[1]).max(0.0));
        let distance = nearest.hypot(2.0 * self.thickness_m);
        let larger = usize::from(sides[1] > sides[0]);
        if sides[larger] > LARGE * distance {
            let (mut first, mut second, mut half) = (centre, centre, sides);
            half[larger] *= 0.5;
            first[larger] -= 0.5 * half[larger];
            second[larger] += 0.5 * half[larger];
            return self.over_rectangle(first, half) + self.over_rectangle(second, half);
        }
        let rule = match sides[larger] / distance {
            ratio if ratio > SMALL => self.five.as_slice(),
            ratio if ratio > TINY => self.three.as_slice(),
            _ => self.two.as_slice(),
        };
        let mut sum = 0.0;
        for (u, weight_x) in rule {
            for (v, weight_y) in rule {
                let r = (x + 0.5 * sides[0] * u).hypot(y + 0.5 * sides[1] * v);
                sum += weight_x * weight_y * self.at(r / self.thickness_m);
            }
        }
        0.25 * sides[0] * sides[1] * sum
    }
}

/// Computes the Chebyshev coefficients of Φ on [start, end].
fn piece(layer: &Layer, start: f64, end: f64) -> [f64; NODES] {
    let nodes = nodes(layer, WINDOW / start, end);
    let angle = |i: usize| PI * (i as f64 + 0.5) / NODES as f64;
    let values: [f64; NODES] = std::array::from_fn(|i| {
        let rho = 0.5 * (start + end + (end - start) * angle(i).cos());
        nodes.iter().map(|(s, weight)| weight * bessel_j0(s * rho)).sum()
    });
    std::array::from_fn(|k| {
        let sum: f64 = values.iter().enumerate().map(|(i, value)| value * (k as f64 * angle(i)).cos()).sum();
        sum * if k == 0 { 1.0 } else { 2.0 } / NODES as f64
    })
}

/// Returns nodes s and weight·(R − 1) of the integral over (R(s) − 1) J₀(sρ), windowed by `delta`, for ρ up to
/// `longest`.
fn nodes(layer: &Layer, delta: f64, longest: f64) -> Vec<(f64, f64)> {
    let rule = gauss_legendre::<16>();
    // R changes at s = 1 and, on a softer base, from the ratio of the moduli on.
    let scale = match layer.base {
        Base::Elastic(base) => 0.2 * (base.shear_modulus_pa() / layer.material.shear_modulus_pa()).min(1.0),
        Base::Rigid | Base::Slippery => 1.0,
    };
    let end = END.min(WINDOW_END * delta);
    let is_windowed = end < END;
    let mut nodes = Vec::new();
    let mut s = 0.0;
    while s < end {
        // Panels in which R, J₀ and the window change little.
        let half = 0.5 * (0.5 * (s + scale)).min(1.0).min(10.0 / longest);
        nodes.extend(rule.iter().map(|(u, weight)| {
            let s = s + half * (1.0 + u);
            let window = if is_windowed { 0.5 * erfc(s / delta - 6.0) } else { 1.0 };
            (s, half * weight * window * (layer.ratio(s) - 1.0))
        }));
        s += 2.0 * half;
    }
    nodes
}

/// Returns Σ c_k T_k(x).
fn clenshaw(coefficients: &[f64; NODES], x: f64) -> f64 {
    let (mut b1, mut b2) = (0.0, 0.0);
    for c in coefficients[1..].iter().rev() {
        (b1, b2) = (2.0 * x * b1 - b2 + c, b1);
    }
    x * b1 - b2 + coefficients[0]
}

/// Table of sin(π(i + ½)/32).
const SINES: [f64; 16] = [
    0.049_067_674_327_418_015,
    0.146_730_474_455_361_75,
    0.242_980_179_903_263_87,
    0.336_889_853_392_220_05,
    0.427_555_093_430_282_1,
    0.514_102_744_193_221_7,
    0.595_699_304_492_433_4,
    0.671_558_954_847_018_3,
    0.740_951_125_354_959_1,
    0.803_207_531_480_644_8,
    0.857_728_610_000_272_1,
    0.903_989_293_123_443_3,
    0.941_544_065_183_020_8,
    0.970_031_253_194_544,
    0.989_176_509_964_781,
    0.998_795_456_205_172_4,
];

/// Returns Bessel's J₀ for x ≥ 0 to 10⁻¹⁵: the mean of cos(x sin t) over equidistant t (32 points are exact up to
/// J₆₄(x)), and Hankel's expansion from x = 25 on.
///
/// # References
/// M. Abramowitz and I. A. Stegun, *Handbook of Mathematical Functions* (1964), 9.1.18 and 9.2.5.
fn bessel_j0(x: f64) -> f64 {
    if x < 25.0 {
        return (0..16).map(|i| (x * SINES[i]).cos()).sum::<f64>() / 16.0;
    }
    let (mut p, mut q, mut term) = (1.0, 0.0, 1.0);
    for k in 1..=12 {
        let odd = (2 * k - 1) as f64;
        term *= -odd * odd / (k as f64 * 8.0 * x);
        let sign = if (k / 2) % 2 == 0 { 1.0 } else { -1.0 };
        if k % 2 == 0 {
            p += sign * term;
        } else {
            q += sign * term;
        }
    }
    let (sin, cos) = (x - 0.25 * PI).sin_cos();
    (2.0 / (PI * x)).sqrt() * (p * cos - q * sin)
}

#[cfg(test)]
mod tests {
    use super::super::tests::{elastic, layer};
    use super::*;
    use crate::Elastic;

    #[test]
    fn bessel_j0_has_its_tabulated_values() {
        for (x, wanted) in [
            (0.0, 1.0),
            (1.0, 0.765_197_686_557_966_6),
            (2.404_825_557_695_773, 0.0),
            (10.0, -0.245_935_764_451_348_33),
            (50.0, 0.055_812_327_669_251_746),
            (100.0, 0.019_985_850_304_223_122),
        ] {
            assert!((bessel_j0(x) - wanted).abs() < 1e-15, "{x}: {:e}", bessel_j0(x) - wanted);
        }
        // Both forms agree at the border.
        let (below, above) = (bessel_j0(25.0_f64.next_down()), bessel_j0(25.0));
        assert!((below - above).abs() < 1e-14, "{:e}", below - above);
    }

    /// Materials that differ only in Poisson's ratio: R − 1 = Σ λⁿ e^{−2ns}, loads mirrored at the depths 2nh.
    fn mirrored(layer_nu: f64, base_nu: f64) -> (Layer, Vec<(f64, f64)>) {
        let mut layer = layer(1.0 + layer_nu, layer_nu, elastic(1.0 + base_nu, base_nu));
        layer.thickness_m = 0.3;
        let lambda = 1.0 - (1.0 - layer_nu) / (1.0 - base_nu);
        (layer, (1..400).map(|n| (lambda.powi(n), 2.0 * f64::from(n) * layer.thickness_m)).collect())
    }

    #[test]
    fn mirrored_loads_are_reproduced() {
        for (layer_nu, base_nu) in [(0.5, 0.1), (0.2, 0.45), (0.3, 0.3)] {
            let (layer, loads) = mirrored(layer_nu, base_nu);
            let kernel = PointLoad::new(&layer, 1e6);
            let mut worst = 0.0_f64;
            for i in 0..600 {
                let rho = if i == 0 { 0.0 } else { 1e-2 * 1.03_f64.powi(i) };
                let r = rho * layer.thickness_m;
                let wanted: f64 =
                    loads.iter().map(|(weight, depth)| weight * layer.thickness_m / r.hypot(*depth)).sum();
                worst = worst.max((kernel.at(rho) - wanted).abs() * rho.max(1.0));
            }
            println!("{layer_nu} {base_nu}: {worst:.1e}");
            assert!(worst < 1e-11, "{worst:e}");
        }
    }

    #[test]
    fn cell_integrals_equal_closed_forms() {
        // ∬ dA/√(r² + b²) over a rectangle, from its corners.
        let corner = |x: f64, y: f64, b: f64| {
            x * (y / x.hypot(b)).asinh() + y * (x / y.hypot(b)).asinh() - b * (x * y / (b * x.hypot(y).hypot(b))).atan()
        };
        let (layer, loads) = mirrored(0.2, 0.45);
        let kernel = PointLoad::new(&layer, 1e6);
        let own = crate::love_coefficient(0.0, 0.0, 1.0, 1.0, layer.material.contact_modulus_pa());
        for (dx, dy) in [(0.01, 0.01), (0.4, 0.4), (0.1, 3.0), (50.0, 30.0)] {
            for (x, y) in [(0.0, 0.0), (dx, 0.0), (dx, dy), (0.0, 3.0 * dy), (20.0 * dx, -7.0 * dy), (999.0 * dx, dy)] {
                let wanted: f64 = loads
                    .iter()
                    .map(|(weight, b)| {
                        let (x0, x1, y0, y1) = (x - 0.5 * dx, x + 0.5 * dx, y - 0.5 * dy, y + 0.5 * dy);
                        weight * (corner(x1, y1, *b) - corner(x0, y1, *b) - corner(x1, y0, *b) + corner(x0, y0, *b))
                    })
                    .sum::<f64>()
                    / (PI * layer.material.contact_modulus_pa());
                let error = (kernel.coefficient_m_per_pa(x, y, dx, dy) - wanted) / (own * f64::max(dx, dy));
                // The closed form itself cancels at large distances.
                assert!(error.abs() < 1e-10, "{dx} × {dy} at ({x}, {y}): {error:e} of {wanted:e}");
            }
        }
    }

    #[test]
    fn only_the_base_matters_at_large_distances() {
        let error = |layer: &Layer, rho: f64, limit: f64| {
            let found = rho * PointLoad::new(layer, rho).at(rho);
            (found / (limit - 1.0) - 1.0).abs()
        };
        for nu in [0.0, 0.3, 0.5] {
            // A rigid base cancels the displacement of the half-space up to an exponentially small rest.
            for base in [Base::Rigid, Base::Slippery] {
                for rho in [60.0, 1e3, 1e6] {
                    let error = error(&layer(1.0, nu, base), rho, 0.0);
                    assert!(error < 1e-11, "{base:?} {nu} at {rho}: {error:e}");
                }
            }
            // From a distance an elastic base acts as a half-space, to second order.
            for (youngs_modulus_pa, poisson_ratio) in [(0.3, 0.2), (1e-3, 0.5), (1e-5, 0.3), (1e4, 0.3)] {
                let below = Elastic { youngs_modulus_pa, poisson_ratio };
                let layer = layer(1.0, nu, Base::Elastic(below));
                let limit = layer.material.contact_modulus_pa() / below.contact_modulus_pa();
                let rho = 1e6 * limit.max(1.0);
                assert!(error(&layer, rho, limit) < 1e-11, "{below:?} {nu}: {:e}", error(&layer, rho, limit));
            }
        }
    }

    #[test]
    fn the_window_removes_nothing() {
        for base in
            [Base::Rigid, Base::Slippery, elastic(0.3, 0.2), elastic(1e-2, 0.3), elastic(1e-3, 0.4), elastic(50.0, 0.0)]
        {
            for nu in [0.0, 0.3, 0.5] {
                let layer = layer(1.0, nu, base);
                let kernel = PointLoad::new(&layer, 200.0);
                for rho in [8.5, 20.0, 31.0, 100.0, 200.0] {
                    let all = nodes(&layer, f64::INFINITY, rho);
                    let wanted: f64 = all.iter().map(|(s, weight)| weight * bessel_j0(s * rho)).sum();
                    let error = (kernel.at(rho) - wanted).abs() * rho / (layer.ratio(1e-9) + 1.0);
                    assert!(error < 1e-11, "{base:?} {nu} at {rho}: {error:e}");
                }
            }
        }
    }

    #[test]
    fn the_table_equals_the_integral() {
        // Simpson's rule with steps far below all scales.
        let layer = layer(5.0, 0.35, elastic(1.0, 0.25));
        let kernel = PointLoad::new(&layer, 100.0);
        for rho in [0.0, 0.3, 1.0, 2.7, 9.0, 40.0] {
            let n = 40_000;
            let step = END / f64::from(n);
            let value = |i: i32| (layer.ratio(step * f64::from(i)) - 1.0) * bessel_j0(step * f64::from(i) * rho);
            let sum: f64 = (1..n).map(|i| if i % 2 == 1 { 4.0 } else { 2.0 } * value(i)).sum();
            let wanted = (sum + value(0) + value(n)) * step / 3.0;
            assert!((kernel.at(rho) - wanted).abs() < 1e-10, "{rho}: {:e} {wanted:e}", kernel.at(rho));
        }
    }
}
