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
    let mut last_sum = f64::INFINITY;
    for _ in 0..200 {
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
        let bracketed = low.is_finite() && high.is_finite();
        let trusted = newton > low && newton < high && sum.abs() <= 0.5 * last_sum;
        let next = if trusted || !bracketed { newton } else { 0.5 * (low + high) };
        last_sum = sum.abs();
        if (next - lambda).abs() <= 1e-15 * lambda.abs() || next == low || next == high {
            return next;
        }
        lambda = next;
    }
    lambda
}

/// Shifts the members of `trial` marked in `working` by one scalar and clips them to [0, upper], so that they sum to
/// `target`: the Euclidean projection on the box and the plane of the prescribed sum.
///
/// The sum rises with the shift, piecewise linearly and flat at both ends, so Newton's step is taken only while it at least
/// halves the miss, and the bracket is halved otherwise. When the bracket is as narrow as the numbers allow, the sums at its
/// ends may still straddle the target (a hardness far below the trial values); the result is then interpolated between
/// them, which meets the sum within the bounds.
///
/// A target beyond what the bounds allow, as rounding of sums makes it when all members are about to reach a bound, is
/// replaced by the nearest that they do allow.
pub(super) fn project_to_sum(trial: &mut [f64], working: &[bool], upper: f64, target: f64) {
    let (mut least, mut largest, mut count) = (f64::INFINITY, f64::NEG_INFINITY, 0.0);
    for (t, _) in trial.iter().zip(working).filter(|(_, w)| **w) {
        least = least.min(*t);
        largest = largest.max(*t);
        count += 1.0;
    }
    if count == 0.0 {
        return;
    }
    let target = target.clamp(0.0, count * upper);
    let ceiling = upper.min(target);
    let sum_at = |trial: &[f64], shift: f64| -> f64 {
        trial.iter().zip(working).filter(|(_, w)| **w).map(|(t, _)| (t + shift).clamp(0.0, upper)).sum()
    };
    let (mut low, mut high) = (-largest, ceiling - least);
    // Far below the trial values, the bound is lost in the rounding of this difference.
    while least + high < ceiling {
        high += (high - low).max(f64::MIN_POSITIVE);
    }
    let mut shift = 0.0_f64.clamp(low, high);
    let mut last_miss = f64::INFINITY;
    for _ in 0..200 {
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
        if miss.abs() <= 1e-15 * target {
            (low, high) = (shift, shift);
            break;
        }
        let newton = shift + miss / slope;
        let trusted = slope > 0.0 && newton > low && newton < high && miss.abs() <= 0.5 * last_miss;
        let next = if trusted { newton } else { 0.5 * (low + high) };
        if next <= low || next >= high {
            break;
        }
        last_miss = miss.abs();
        shift = next;
    }
    let (sum_low, sum_high) = (sum_at(trial, low), sum_at(trial, high));
    let share = if sum_high > sum_low { ((target - sum_low) / (sum_high - sum_low)).clamp(0.0, 1.0) } else { 0.0 };
    for (t, _) in trial.iter_mut().zip(working).filter(|(_, w)| **w) {
        let (at_low, at_high) = ((*t + low).clamp(0.0, upper), (*t + high).clamp(0.0, upper));
        *t = at_low + share * (at_high - at_low);
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
    fn a_bound_far_below_the_trial_values_is_met_all_the_same() {
        for upper in [1e-4, 1e-8, 1e-12] {
            let mut trial = random::standard_normal(&mut random::stream(3, "projection", 1000), 500);
            let before = trial.clone();
            let target = 37.3 * upper;
            project_to_sum(&mut trial, &[true; 500], upper, target);
            assert!((trial.iter().sum::<f64>() / target - 1.0).abs() < 1e-12);
            assert!(trial.iter().all(|t| (0.0..=upper).contains(t)));
            // The largest 37 are at the bound, and one holds the rest.
            let mut order: Vec<usize> = (0..500).collect();
            order.sort_by(|a, b| before[*b].total_cmp(&before[*a]));
            assert!(order[..37].iter().all(|i| trial[*i] == upper) && order[38..].iter().all(|i| trial[*i] == 0.0));
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
