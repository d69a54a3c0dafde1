//! Multiplier and projection of a box-constrained problem under a prescribed sum.

/// Newton steps before a bracket is halved. A few suffice unless a cell is on a bound beyond the root.
const NEWTON_STEPS: usize = 20;

/// Returns `value` clamped to [0, `hardness`].
#[inline(always)]
pub(super) fn within(value: f64, hardness: f64) -> f64 {
    let value = if value > 0.0 { value } else { 0.0 };
    if value < hardness { value } else { hardness }
}

/// Range of the trial values of the cells that may move, before they are clipped to the bounds.
#[derive(Debug, Clone, Copy)]
pub(super) struct Extent {
    pub(super) least: f64,
    pub(super) largest: f64,
    pub(super) members: usize,
    /// Sum and maximum of the hardness.
    pub(super) capacity: f64,
    pub(super) largest_hardness: f64,
}

impl Extent {
    pub(super) const NONE: Self =
        Self { least: f64::INFINITY, largest: f64::NEG_INFINITY, members: 0, capacity: 0.0, largest_hardness: 0.0 };

    /// Combines the extents of two sets of cells.
    pub(super) fn with(self, other: Self) -> Self {
        Self {
            least: self.least.min(other.least),
            largest: self.largest.max(other.largest),
            members: self.members + other.members,
            capacity: self.capacity + other.capacity,
            largest_hardness: self.largest_hardness.max(other.largest_hardness),
        }
    }
}

/// Returns whether moving a cell of pressure `p` and gradient `g` within 0 ≤ p ≤ `hardness` may lower the energy: true
/// between the bounds, and on a bound from which the descent leads inwards.
#[inline(always)]
pub(super) fn may_move(p: f64, g: f64, hardness: f64) -> bool {
    ((p > 0.0) | (g < 0.0)) & ((p < hardness) | (g > 0.0))
}

/// Returns the multiplier λ for which the projection of λ − v on the tangent cone of the box at `p` has zero sum:
/// Σ_free (v−λ) + Σ_{p=0} min(v−λ, 0) + Σ_{p=H} max(v−λ, 0) = 0.
///
/// `sums` returns that sum at a λ, and the number of its terms below the hardness and at it. The sum falls
/// monotonically and is piecewise linear in λ, so a bracketed Newton iteration ends after a few steps: when the number
/// of terms is unchanged, or the step is `negligible`. If the sum vanishes on an interval (no free cell), every root
/// satisfies the optimality conditions.
pub(super) fn tangent_multiplier(start: f64, negligible: f64, sums: impl Fn(f64) -> [f64; 3]) -> f64 {
    let (mut low, mut high) = (f64::NEG_INFINITY, f64::INFINITY);
    let mut lambda = start;
    let mut last_terms = [0.0; 2];
    for evaluation in 0..200 {
        let [sum, below, on] = sums(lambda);
        let slope = below + on;
        if slope == 0.0 {
            return lambda;
        }
        if sum > 0.0 {
            low = lambda;
        } else {
            high = lambda;
        }
        let newton = lambda + sum / slope;
        if (newton - lambda).abs() <= negligible {
            return newton;
        }
        let bracketed = low.is_finite() && high.is_finite();
        let trusted = newton > low && newton < high && evaluation < NEWTON_STEPS;
        let next = if trusted || !bracketed { newton } else { 0.5 * (low + high) };
        // The same terms define the same line, whose root this already is, up to rounding.
        let linear = trusted && [below, on] == last_terms;
        if linear || next == low || next == high {
            return next;
        }
        (lambda, last_terms) = (next, [below, on]);
    }
    lambda
}

/// A common shift of trial values before they are clipped to the bounds, computed by [`project_to_sum`]. It
/// interpolates by `weight` between the results of two neighbouring floating-point shifts.
#[derive(Debug, Clone, Copy)]
pub(super) struct Shift {
    low: f64,
    high: f64,
    weight: f64,
}

impl Shift {
    pub(super) const NONE: Self = Self { low: 0.0, high: 0.0, weight: 0.0 };

    fn by(value: f64) -> Self {
        Self { low: value, high: value, weight: 0.0 }
    }

    /// Returns the larger of the two shifts, infinite if the bounds alone determine the result.
    pub(super) fn largest(self) -> f64 {
        self.high
    }

    /// Returns the shift if it is one finite value.
    pub(super) fn common(self) -> Option<f64> {
        (self.weight == 0.0 && self.low.is_finite()).then_some(self.low)
    }

    /// Returns the value of `t` after the shift, within [0, `hardness`].
    pub(super) fn applied(self, t: f64, hardness: f64) -> f64 {
        // Infinite trial values stay on their bound at every shift.
        if t.is_infinite() {
            return within(t, hardness);
        }
        let at_low = within(t + self.low, hardness);
        if self.weight == 0.0 { at_low } else { at_low + self.weight * (within(t + self.high, hardness) - at_low) }
    }
}

/// Computes the shift of trial values after which they sum to `target` within their bounds: the Euclidean projection on
/// the intersection of the box and the plane of the prescribed sum.
///
/// `sums` returns the sum within the bounds at a shift and the number of values that follow the shift. Infinite values
/// stay on their bound at every shift; `fixed` is their sum. The sum rises piecewise linearly with the shift and is
/// flat at both ends, so a Newton step is accepted only if it at least halves the miss; otherwise the bracket is
/// halved. At the narrowest bracket of floating-point numbers the sums at its ends may still lie on either side of the
/// target (if the hardness is far below the trial values). The result is then interpolated between both, which meets
/// the sum within the bounds. Rounding of sums can move the target beyond the bounds when all values are about to reach
/// them; it is then replaced by the nearest feasible sum.
pub(super) fn project_to_sum(extent: Extent, fixed: f64, target: f64, sums: impl Fn(f64) -> [f64; 2]) -> Shift {
    let Extent { least, largest, members, capacity, largest_hardness } = extent;
    if members == 0 {
        return Shift::NONE;
    }
    let own = target - fixed;
    if own <= 0.0 || own >= capacity {
        return Shift::by(if own > 0.0 { f64::INFINITY } else { f64::NEG_INFINITY });
    }
    let largest_hardness = largest_hardness.min(own);
    let (mut low, mut high) = (-largest, largest_hardness - least);
    // Far below the trial values, the rounding of this difference exceeds the hardness.
    while least + high < largest_hardness {
        high += (high - low).max(f64::EPSILON * high.abs()).max(f64::MIN_POSITIVE);
    }
    // Rounding of the sum.
    let negligible = f64::EPSILON * (members as f64).sqrt() * own;
    let mut shift = 0.0_f64.clamp(low, high);
    let mut last_miss = f64::INFINITY;
    for _ in 0..200 {
        let [sum, slope] = sums(shift);
        let miss = target - sum;
        if miss > 0.0 {
            low = shift;
        } else {
            high = shift;
        }
        if miss.abs() <= negligible {
            return Shift::by(shift);
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
    let ([sum_low, _], [sum_high, _]) = (sums(low), sums(high));
    let weight = if sum_high > sum_low { ((target - sum_low) / (sum_high - sum_low)).clamp(0.0, 1.0) } else { 0.0 };
    Shift { low, high, weight }
}

#[cfg(test)]
mod tests {
    use super::*;
    use asperity_base::random;

    fn sums<const K: usize>(terms: impl Iterator<Item = [f64; K]>) -> [f64; K] {
        terms.fold([0.0; K], |sums, terms| std::array::from_fn(|k| sums[k] + terms[k]))
    }

    fn project_to_sum(trial: &mut [f64], hardness: f64, target: f64) {
        let least = trial.iter().copied().fold(f64::INFINITY, f64::min);
        let largest = trial.iter().copied().fold(f64::NEG_INFINITY, f64::max);
        let capacity = hardness * trial.len() as f64;
        let extent = Extent { least, largest, members: trial.len(), capacity, largest_hardness: hardness };
        let shift = super::project_to_sum(extent, 0.0, target, |shift| {
            sums(trial.iter().map(|t| {
                let value = t + shift;
                [within(value, hardness), if (value > 0.0) & (value < hardness) { 1.0 } else { 0.0 }]
            }))
        });
        trial.iter_mut().for_each(|t| *t = shift.applied(*t, hardness));
    }

    fn tangent_multiplier(p: &[f64], v: &[f64], hardness: f64, start: f64) -> f64 {
        super::tangent_multiplier(start, 1e-15, |lambda| {
            sums(p.iter().zip(v).map(|(p, v)| {
                let g = v - lambda;
                let counts = |on: bool| if may_move(*p, g, hardness) && on == (*p >= hardness) { 1.0 } else { 0.0 };
                [if may_move(*p, g, hardness) { g } else { 0.0 }, counts(false), counts(true)]
            }))
        })
    }

    #[test]
    fn the_projection_has_the_prescribed_sum_and_is_a_common_shift() {
        for sample in 0..200 {
            let mut trial = random::standard_normal(&mut random::stream(3, "projection", sample), 50);
            let hardness = if sample % 2 == 0 { f64::INFINITY } else { 1.5 };
            let before = trial.clone();
            let target = 0.1 + 0.2 * sample as f64 % 60.0;
            project_to_sum(&mut trial, hardness, target);
            let sum: f64 = trial.iter().sum();
            assert!((sum - target).abs() < 1e-12 * target.max(1.0), "sample {sample}: {sum} for {target}");
            let shifts: Vec<f64> =
                (0..50).filter(|&i| trial[i] > 0.0 && trial[i] < hardness).map(|i| trial[i] - before[i]).collect();
            assert!(shifts.iter().all(|s| (s - shifts[0]).abs() < 1e-12));
        }
    }

    #[test]
    fn a_target_beyond_the_bounds_by_rounding_is_replaced_by_the_bound() {
        let mut trial = vec![0.2, -3.0, 5.0];
        project_to_sum(&mut trial, 1.0, -1e-17);
        assert_eq!(trial, [0.0; 3]);
        let mut trial = vec![0.2, -3.0, 5.0];
        project_to_sum(&mut trial, 1.0, 3.0 + 1e-12);
        assert_eq!(trial, [1.0; 3]);
        project_to_sum(&mut [], 1.0, 1.0);
        // Equal values whose rounding error exceeds the bound.
        let mut trial = vec![1e17; 3];
        project_to_sum(&mut trial, 2.0, 5.0);
        assert!((trial.iter().sum::<f64>() - 5.0).abs() < 1e-14);
    }

    #[test]
    fn a_bound_below_the_rounding_of_the_trial_values_is_met() {
        for largest in [1e17, 1e25, 1e300] {
            let mut trial = vec![-largest, largest, 0.5 * largest, 0.0];
            project_to_sum(&mut trial, 2.0, 7.0);
            assert!((trial.iter().sum::<f64>() - 7.0).abs() < 1e-14, "{trial:?}");
            assert!(trial.iter().all(|t| (0.0..=2.0).contains(t)), "{trial:?}");
        }
    }

    #[test]
    fn a_bound_far_below_the_trial_values_is_met() {
        for hardness in [1e-4, 1e-8, 1e-12] {
            let mut trial = random::standard_normal(&mut random::stream(3, "projection", 1000), 500);
            let before = trial.clone();
            let target = 37.3 * hardness;
            project_to_sum(&mut trial, hardness, target);
            assert!((trial.iter().sum::<f64>() / target - 1.0).abs() < 1e-12);
            assert!(trial.iter().all(|t| (0.0..=hardness).contains(t)));
            // The largest 37 values are at the bound, and one value carries the rest.
            let mut order: Vec<usize> = (0..500).collect();
            order.sort_by(|a, b| before[*b].total_cmp(&before[*a]));
            assert!(order[..37].iter().all(|i| trial[*i] == hardness) && order[38..].iter().all(|i| trial[*i] == 0.0));
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
                .map(|(p, v)| match *p {
                    0.0 => (v - lambda).min(0.0),
                    1.0 => (v - lambda).max(0.0),
                    _ => v - lambda,
                })
                .sum();
            assert!(sum.abs() < 1e-12, "sample {sample}: {sum:e}");
        }
    }
}
