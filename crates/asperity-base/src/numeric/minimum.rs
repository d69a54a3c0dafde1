//! Derivative-free minima and maxima.

/// Result of [`golden_section`].
#[derive(Debug, Clone, Copy)]
pub struct GoldenSection {
    /// Bracket of the minimum.
    pub bracket: [f64; 2],
    /// The better of the last two arguments evaluated.
    pub place: f64,
    /// Value at the best argument.
    pub value: f64,
}

impl GoldenSection {
    /// Returns the centre of the bracket.
    pub fn middle(&self) -> f64 {
        0.5 * (self.bracket[0] + self.bracket[1])
    }
}

/// Returns the minimum of a unimodal function between two arguments, to `tolerance` in the argument.
pub fn golden_section(mut f: impl FnMut(f64) -> f64, [mut low, mut high]: [f64; 2], tolerance: f64) -> GoldenSection {
    const RATIO: f64 = 0.618_033_988_749_894_8;
    let mut at = |x: f64| [x, f(x)];
    let (mut left, mut right) = (at(high - RATIO * (high - low)), at(low + RATIO * (high - low)));
    while high - low > tolerance {
        if left[1] < right[1] {
            (high, right) = (right[0], left);
            left = at(high - RATIO * (high - low));
        } else {
            (low, left) = (left[0], right);
            right = at(low + RATIO * (high - low));
        }
    }
    let [place, value] = if left[1] < right[1] { left } else { right };
    GoldenSection { bracket: [low, high], place, value }
}

/// Returns the minimum of a function next to the best of several increasing arguments, to `tolerance` in the argument.
///
/// # Panics
/// Without arguments.
pub fn scanned_minimum(f: impl Fn(f64) -> f64, arguments: &[f64], tolerance: f64) -> GoldenSection {
    let values: Vec<f64> = arguments.iter().map(|x| f(*x)).collect();
    let best = values.iter().enumerate().min_by(|a, b| a.1.total_cmp(b.1)).map_or(0, |(index, _)| index);
    let ends = [best.saturating_sub(1), (best + 1).min(arguments.len() - 1)];
    golden_section(f, ends.map(|index| arguments[index]), tolerance)
}

/// Returns the position and value of a maximum of a function of `D` variables near a start, by the simplex method of
/// Nelder and Mead (*Computer J.* **7** (1965) 308), restarted until a restart gives no improvement. −∞ marks
/// infeasible points.
pub fn simplex<const D: usize>(f: impl Fn([f64; D]) -> f64, start: [f64; D], size: f64) -> ([f64; D], f64) {
    let mut best = (start, f(start));
    for _ in 0..10 {
        let next = simplex_once(&f, best.0, size);
        let gain = next.1 - best.1;
        if next.1 > best.1 {
            best = next;
        }
        if gain.is_nan() || gain <= 1e-9 * (1.0 + best.1.abs()) {
            break;
        }
    }
    best
}

fn simplex_once<const D: usize>(f: &impl Fn([f64; D]) -> f64, start: [f64; D], size: f64) -> ([f64; D], f64) {
    let mut corners: Vec<([f64; D], f64)> = (0..=D)
        .map(|i| {
            let mut corner = start;
            if i > 0 {
                corner[i - 1] += size;
            }
            (corner, f(corner))
        })
        .collect();
    for _ in 0..200 {
        corners.sort_by(|a, b| b.1.total_cmp(&a.1));
        let spread = (0..D).map(|d| (corners[0].0[d] - corners[D].0[d]).abs()).fold(0.0, f64::max);
        if spread < 1e-8 {
            break;
        }
        let centre: [f64; D] = std::array::from_fn(|d| corners[..D].iter().map(|c| c.0[d]).sum::<f64>() / D as f64);
        let worst = corners[D];
        let along = |t: f64| {
            let point = std::array::from_fn(|d| centre[d] + t * (centre[d] - worst.0[d]));
            (point, f(point))
        };
        let reflected = along(1.0);
        corners[D] = if reflected.1 > corners[0].1 {
            let expanded = along(2.0);
            if expanded.1 > reflected.1 { expanded } else { reflected }
        } else if reflected.1 > corners[D - 1].1 {
            reflected
        } else {
            let contracted = if reflected.1 > worst.1 { along(0.5) } else { along(-0.5) };
            if contracted.1 > f64::max(worst.1, reflected.1) {
                contracted
            } else {
                let best = corners[0].0;
                for corner in &mut corners[1..] {
                    let point = std::array::from_fn(|d| 0.5 * (best[d] + corner.0[d]));
                    *corner = (point, f(point));
                }
                continue;
            }
        };
    }
    corners.sort_by(|a, b| b.1.total_cmp(&a.1));
    corners[0]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_golden_section_closes_in_on_the_minimum() {
        let found = golden_section(|x: f64| (x - 0.3).powi(2) + 2.0, [-1.0, 2.0], 3e-8);
        assert!((found.middle() - 0.3).abs() < 1e-7 && (found.place - 0.3).abs() < 1e-7, "{found:?}");
        assert!(found.value - 2.0 < 1e-14);
    }

    #[test]
    fn the_simplex_climbs_a_curved_ridge() {
        // Rosenbrock's function with the sign reversed: maximum 0 at (1, 1).
        let f = |[x, y]: [f64; 2]| -(1.0 - x).powi(2) - 100.0 * (y - x * x).powi(2);
        let ([x, y], height) = simplex(f, [-1.2, 1.0], 0.5);
        assert!((x - 1.0).abs() < 1e-4 && (y - 1.0).abs() < 1e-4 && height > -1e-8, "({x}, {y})");
    }
}
