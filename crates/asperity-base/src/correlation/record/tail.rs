//! Table of the twice integrated tail of a correlation without a closed form.

use crate::numeric::gauss_legendre;

/// Number of intervals of the table.
const CELLS: usize = 1500;
/// Points lie at r_max (i/n)^POWER, dense near zero, where a rough process has a cusp.
const POWER: i32 = 3;

/// T(x) = ∫_x^∞ (u − x) ρ(u) du by quintic Hermite interpolation of T, T′ and T″ = ρ.
#[derive(Debug, Clone)]
pub(super) struct TailTable {
    last: f64,
    /// (T, −T′, ρ) at every point.
    points: Vec<[f64; 3]>,
}

impl TailTable {
    /// Creates the table of a correlation that is negligible beyond `last`.
    pub(super) fn new(correlation: &dyn Fn(f64) -> f64, last: f64) -> Self {
        let rule = gauss_legendre::<8>();
        let mut points = vec![[0.0, 0.0, correlation(last)]; CELLS + 1];
        for cell in (0..CELLS).rev() {
            let (low, high) = (at(last, cell), at(last, cell + 1));
            // Moments of the interval about its lower end.
            let [mut mass, mut moment] = [0.0; 2];
            for (node, weight) in rule {
                let above = 0.5 * (high - low) * (1.0 + node);
                let part = 0.5 * (high - low) * weight * correlation(low + above);
                (mass, moment) = (mass + part, moment + above * part);
            }
            let [tail, slope, _] = points[cell + 1];
            points[cell] = [tail + slope * (high - low) + moment, slope + mass, correlation(low)];
        }
        Self { last, points }
    }

    /// Returns T(x).
    pub(super) fn tail(&self, x: f64) -> f64 {
        let Some((cell, width, v)) = self.place(x) else { return 0.0 };
        let ([f0, s0, c0], [f1, s1, c1]) = (self.points[cell], self.points[cell + 1]);
        let (d0, d1, e0, e1) = (-s0 * width, -s1 * width, c0 * width * width, c1 * width * width);
        // Quintic with values f, slopes d and curvatures e at both ends.
        let jump = f1 - f0 - d0 - 0.5 * e0;
        let (slope, curve) = (d1 - d0 - e0, e1 - e0);
        let a3 = 10.0 * jump - 4.0 * slope + 0.5 * curve;
        let a4 = -15.0 * jump + 7.0 * slope - curve;
        let a5 = 6.0 * jump - 3.0 * slope + 0.5 * curve;
        f0 + v * (d0 + v * (0.5 * e0 + v * (a3 + v * (a4 + v * a5))))
    }

    /// Returns the interval that contains x, its width, and the relative position in it; `None` beyond the table.
    fn place(&self, x: f64) -> Option<(usize, f64, f64)> {
        if x >= self.last {
            return None;
        }
        let guess = ((x / self.last).cbrt() * CELLS as f64) as usize;
        let mut cell = guess.min(CELLS - 1);
        if cell > 0 && at(self.last, cell) > x {
            cell -= 1;
        } else if cell + 1 < CELLS && at(self.last, cell + 1) <= x {
            cell += 1;
        }
        let (low, high) = (at(self.last, cell), at(self.last, cell + 1));
        Some((cell, high - low, (x - low) / (high - low)))
    }
}

fn at(last: f64, index: usize) -> f64 {
    last * (index as f64 / CELLS as f64).powi(POWER)
}
