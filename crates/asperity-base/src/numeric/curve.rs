//! Straight and cubic curves through points.

/// Straight line y + slope·(x′ − x).
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Line {
    /// Mean x of the points.
    pub x: f64,
    /// Mean y of the points.
    pub y: f64,
    /// Slope; not finite if all x are equal.
    pub slope: f64,
}

impl Line {
    /// Creates the least-squares line through points (x, y).
    pub fn through(points: &[(f64, f64)]) -> Self {
        let mean = |of: fn(&(f64, f64)) -> f64| points.iter().map(of).sum::<f64>() / points.len() as f64;
        let (x, y) = (mean(|point| point.0), mean(|point| point.1));
        let products: f64 = points.iter().map(|point| (point.0 - x) * (point.1 - y)).sum();
        let squares: f64 = points.iter().map(|point| (point.0 - x).powi(2)).sum();
        Self { x, y, slope: products / squares }
    }
}

/// Returns the cubic Hermite interpolation at the fraction `t` of an interval, given [value, slope times its width] at
/// both ends.
#[inline]
pub fn cubic([y0, d0]: [f64; 2], [y1, d1]: [f64; 2], t: f64) -> f64 {
    let rise = y1 - y0;
    y0 + t * (d0 + t * ((3.0 * rise - 2.0 * d0 - d1) + t * (d0 + d1 - 2.0 * rise)))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn points_on_a_line_or_a_cubic_return_it() {
        let line = Line::through(&[1.0, 2.0, 4.0, 9.0].map(|x| (x, 3.0 - 2.0 * x)));
        assert_eq!((line.x, line.y, line.slope), (4.0, -5.0, -2.0));
        assert!(!Line::through(&[(1.0, 1.0), (1.0, 2.0)]).slope.is_finite());
        // y = x³ between 1 and 3.
        for t in [0.0, 0.3, 1.0] {
            assert!((cubic([1.0, 6.0], [27.0, 54.0], t) - (1.0 + 2.0 * t).powi(3)).abs() < 1e-13);
        }
    }
}
