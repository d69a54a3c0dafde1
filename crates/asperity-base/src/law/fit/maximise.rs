//! Local maxima of profile likelihoods over free ends.

use super::{End, Family, Fit};
use crate::law::{LawError, Marginal};

/// Distances between the sample and a free end that are searched, in units of the sample's range.
pub(super) const NEAREST: f64 = 1e-6;
pub(super) const FARTHEST: f64 = 1e3;
/// Points of the logarithmic search grid.
const GRID: usize = 55;

/// Fits a law with a free lower end: the largest interior local maximum of the profile likelihood over the shift.
pub(super) fn shift(
    family: Family,
    sorted: &[f64],
    given: impl Fn(&[f64], f64) -> Result<Marginal, LawError>,
) -> Result<Fit, LawError> {
    let least = sorted[0];
    let range = sorted[sorted.len() - 1] - least;
    let at = |log_gap: f64| Some(Fit::unbounded(family, given(sorted, least - range * log_gap.exp()).ok()?, sorted));
    let profile = |log_gap: f64| at(log_gap).map_or(f64::NEG_INFINITY, |fit| fit.log_likelihood);

    let step = (FARTHEST / NEAREST).ln() / (GRID - 1) as f64;
    let gaps: Vec<f64> = (0..GRID).map(|i| NEAREST.ln() + step * i as f64).collect();
    let heights: Vec<f64> = gaps.iter().map(|gap| profile(*gap)).collect();
    let peak = (1..GRID - 1)
        .filter(|&i| heights[i].is_finite() && heights[i] > heights[i - 1] && heights[i] >= heights[i + 1])
        .max_by(|&i, &j| heights[i].total_cmp(&heights[j]));
    let none = LawError::Sample {
        law: family.name(),
        n: sorted.len(),
        reason: "the likelihood has no maximum over the shift: it grows towards the least value or towards minus infinity",
    };
    let Some(peak) = peak else { return Err(none) };
    let log_gap = golden_section(&profile, gaps[peak - 1], gaps[peak + 1]);
    at(log_gap).map(|fit| Fit { low_end: End::Fitted, ..fit }).ok_or(none)
}

/// The maximum of a function with one maximum between two arguments, to a relative 1e-8 of their distance.
fn golden_section(f: &impl Fn(f64) -> f64, mut low: f64, mut high: f64) -> f64 {
    let ratio = 0.5 * (5.0_f64.sqrt() - 1.0);
    let (mut left, mut right) = (high - ratio * (high - low), low + ratio * (high - low));
    let (mut f_left, mut f_right) = (f(left), f(right));
    for _ in 0..38 {
        if f_left > f_right {
            (high, right, f_right) = (right, left, f_left);
            left = high - ratio * (high - low);
            f_left = f(left);
        } else {
            (low, left, f_left) = (left, right, f_right);
            right = low + ratio * (high - low);
            f_right = f(right);
        }
    }
    0.5 * (low + high)
}

/// The maximum of a function of `D` variables from a start, by the simplex of Nelder and Mead (*Computer J.* **7** (1965)
/// 308), restarted until a restart gains nothing. −∞ marks forbidden points.
pub(super) fn simplex<const D: usize>(f: impl Fn([f64; D]) -> f64, start: [f64; D], size: f64) -> ([f64; D], f64) {
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
    fn the_simplex_climbs_a_curved_ridge() {
        // Rosenbrock's valley, upside down: maximum 0 at (1, 1).
        let f = |[x, y]: [f64; 2]| -(1.0 - x).powi(2) - 100.0 * (y - x * x).powi(2);
        let ([x, y], height) = simplex(f, [-1.2, 1.0], 0.5);
        assert!((x - 1.0).abs() < 1e-4 && (y - 1.0).abs() < 1e-4 && height > -1e-8, "({x}, {y})");
    }

    #[test]
    fn the_golden_section_halves_down_to_the_maximum() {
        let x = golden_section(&|x: f64| -(x - 0.3).powi(2), -1.0, 2.0);
        assert!((x - 0.3).abs() < 1e-7, "{x}");
    }
}
