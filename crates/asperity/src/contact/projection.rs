//! The two scalar equations of a box-constrained problem under a prescribed sum.

/// State of one cell's pressure within its bounds.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Bound {
    /// p = 0.
    Lower,
    /// 0 < p < H.
    Free,
    /// p = H.
    Upper,
}

/// The bound on which a pressure lies.
pub(super) fn bound(p: f64, upper: f64) -> Bound {
    if p <= 0.0 {
        Bound::Lower
    } else if p >= upper {
        Bound::Upper
    } else {
        Bound::Free
    }
}

/// The multiplier λ for which the projection of λ − v on the tangent cone of the box at `p` has zero sum:
/// Σ_free (v−λ) + Σ_{p=0} min(v−λ, 0) + Σ_{p=H} max(v−λ, 0) = 0.
///
/// The left side falls monotonically and is piecewise linear in λ, so a bracketed Newton iteration ends after a few
/// steps. Where it vanishes on an interval (no free cell), any root serves: the optimality conditions hold for each.
pub(super) fn tangent_multiplier(p: &[f64], v: &[f64], upper: f64, start: f64) -> f64 {
    let (mut low, mut high) = (f64::NEG_INFINITY, f64::INFINITY);
    let mut lambda = start;
    for _ in 0..100 {
        let (mut sum, mut slope) = (0.0, 0.0);
        for (p, v) in p.iter().zip(v) {
            let g = v - lambda;
            let counts = match bound(*p, upper) {
                Bound::Free => true,
                Bound::Lower => g < 0.0,
                Bound::Upper => g > 0.0,
            };
            if counts {
                sum += g;
                slope += 1.0;
            }
        }
        if slope == 0.0 {
            return lambda;
        }
        if sum > 0.0 {
            low = lambda;
        } else {
            high = lambda;
        }
        let newton = lambda + sum / slope;
        let next = if newton > low && newton < high || !(low.is_finite() && high.is_finite()) {
            newton
        } else {
            0.5 * (low + high)
        };
        if (next - lambda).abs() <= 1e-15 * lambda.abs() || next == low || next == high {
            return next;
        }
        lambda = next;
    }
    lambda
}

/// Shifts the members of `trial` marked in `working` by one scalar and clips them to [0, upper], so that they sum to
/// `target`: the Euclidean projection on the box and the plane of the prescribed sum.
pub(super) fn project_to_sum(trial: &mut [f64], working: &[bool], upper: f64, target: f64) {
    let (mut low, mut high) = (f64::NEG_INFINITY, f64::INFINITY);
    let mut shift = 0.0;
    for _ in 0..100 {
        let (mut sum, mut slope) = (0.0, 0.0);
        for (t, working) in trial.iter().zip(working) {
            if *working {
                let value = t + shift;
                sum += value.clamp(0.0, upper);
                if value > 0.0 && value < upper {
                    slope += 1.0;
                }
            }
        }
        let miss = target - sum;
        if miss > 0.0 {
            low = shift;
        } else {
            high = shift;
        }
        if miss.abs() <= 1e-15 * target.abs() {
            break;
        }
        let newton = shift + miss / slope;
        let next = if slope > 0.0 && newton > low && newton < high {
            newton
        } else if low.is_finite() && high.is_finite() {
            0.5 * (low + high)
        } else {
            // No free cell: reach for the nearest kink in the direction that is missing.
            let kink = trial
                .iter()
                .zip(working)
                .filter(|(_, working)| **working)
                .map(|(t, _)| if miss > 0.0 { -t } else { upper - t })
                .filter(|kink| if miss > 0.0 { *kink > shift } else { *kink < shift })
                .fold(f64::NAN, |best: f64, kink| if miss > 0.0 { best.min(kink) } else { best.max(kink) });
            if kink.is_nan() {
                break;
            }
            // A step past the kink by the mean deficit frees at least one cell.
            kink + miss / trial.len() as f64
        };
        if next == shift {
            break;
        }
        shift = next;
    }
    for (t, working) in trial.iter_mut().zip(working) {
        if *working {
            *t = (*t + shift).clamp(0.0, upper);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::random;

    #[test]
    fn the_projection_meets_the_sum_and_is_a_common_shift() {
        for sample in 0..200 {
            let mut trial = random::standard_normal(&mut random::stream(3, "projection", sample), 50);
            let working: Vec<bool> = (0..50).map(|i| i % 7 != 3).collect();
            let upper = if sample % 2 == 0 { f64::INFINITY } else { 1.5 };
            let before = trial.clone();
            let target = 0.1 + 0.2 * sample as f64 % 60.0;
            project_to_sum(&mut trial, &working, upper, target);
            let sum: f64 = trial.iter().zip(&working).filter(|(_, w)| **w).map(|(t, _)| t).sum();
            assert!((sum - target).abs() < 1e-12 * target.max(1.0), "sample {sample}: {sum} for {target}");
            let shifts: Vec<f64> = (0..50)
                .filter(|&i| working[i] && trial[i] > 0.0 && trial[i] < upper)
                .map(|i| trial[i] - before[i])
                .collect();
            assert!(shifts.iter().all(|s| (s - shifts[0]).abs() < 1e-12));
            assert!((0..50).filter(|&i| !working[i]).all(|i| trial[i] == before[i]));
        }
    }

    #[test]
    fn the_multiplier_zeroes_the_sum_over_the_tangent_cone() {
        for sample in 0..200 {
            let mut stream = random::stream(4, "projection", sample);
            let v = random::standard_normal(&mut stream, 60);
            let p: Vec<f64> =
                random::standard_normal(&mut stream, 60).iter().map(|x| (x + 0.3).clamp(0.0, 1.0)).collect();
            let lambda = tangent_multiplier(&p, &v, 1.0, 5.0);
            let sum: f64 = p
                .iter()
                .zip(&v)
                .map(|(p, v)| match bound(*p, 1.0) {
                    Bound::Free => v - lambda,
                    Bound::Lower => (v - lambda).min(0.0),
                    Bound::Upper => (v - lambda).max(0.0),
                })
                .sum();
            assert!(sum.abs() < 1e-12, "sample {sample}: {sum:e}");
        }
    }
}
