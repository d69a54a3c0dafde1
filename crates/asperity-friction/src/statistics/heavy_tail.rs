//! Test for the variance of the quotient F/N of windows.
//!
//! A Hertz contact of overlap δ has an area proportional to δ and a load proportional to δ^{3/2}, so F/N of a window
//! with a single contact grows as δ^{−1/2}. Small overlaps are as likely as others. So P(F/N > x) falls as x^{−2}, the
//! tail index is α = 2 (shape ξ = 1/α = 1/2 of the generalised Pareto distribution), and the variance diverges
//! logarithmically. A contact that enters a window at its border has the same effect. On a grid the last contact is one
//! cell, with α = 1.

use super::{FrictionStatistics, Tail};
use asperity_base::stats::Interval;

/// Fraction of sparse windows ([`FrictionStatistics::sparse_fraction`]) above which contacts count as isolated.
pub const ISOLATED_FRACTION: f64 = 0.1;
/// Shape ξ of a tail from which on the variance is infinite.
const NO_VARIANCE: f64 = 0.5;
/// Shape ξ of a tail from which on the mean is infinite.
const NO_MEAN: f64 = 1.0;

/// Evidence that the quotient F/N has no variance.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct HeavyTail {
    /// Fraction of windows with fewer than [`super::WANTED_CONTACT_CELLS`] contact cells.
    pub sparse_fraction: f64,
    /// Shape ξ of the tail with its 95 % interval; `None` if the records have too few separate peaks.
    pub shape: Option<(f64, Interval)>,
}

impl HeavyTail {
    /// Returns whether the mean exists: the tail index α = 1/ξ is above 1.
    pub fn has_mean(&self) -> bool {
        self.shape.is_none_or(|(shape, _)| shape < NO_MEAN)
    }
}

impl FrictionStatistics {
    /// Returns the evidence that the friction coefficient of windows has no variance; `None` if it has one.
    ///
    /// The variance is undefined in two cases: contacts are isolated (more than [`ISOLATED_FRACTION`] of the windows
    /// are sparse) and the interval of the tail's shape does not exclude ξ ≥ 1/2; or the whole interval lies above 1/2.
    pub fn heavy_tail(&self) -> Option<HeavyTail> {
        evidence(self.sparse_fraction, self.moments.std > 0.0, self.tail.as_ref())
    }
}

fn evidence(sparse_fraction: f64, varies: bool, tail: Option<&Tail>) -> Option<HeavyTail> {
    let shape = tail.map(|tail| (tail.shape, tail.shape_interval));
    let isolated = sparse_fraction > ISOLATED_FRACTION && varies;
    let possible = shape.is_none_or(|(_, interval)| interval.high >= NO_VARIANCE);
    let certain = shape.is_some_and(|(_, interval)| interval.low >= NO_VARIANCE);
    ((isolated && possible) || certain).then_some(HeavyTail { sparse_fraction, shape })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::statistics::WANTED_CONTACT_CELLS;
    use asperity_base::random;

    /// Returns the evidence from independent windows, each with a friction coefficient and a number of contact cells.
    fn found(windows: &[(f64, f64)]) -> Option<HeavyTail> {
        let friction: Vec<f64> = windows.iter().map(|window| window.0).collect();
        let records: Vec<&[f64]> = friction.chunks(250).collect();
        let sparse = windows.iter().filter(|window| window.1 < WANTED_CONTACT_CELLS).count();
        let varies = friction.iter().any(|mu| *mu != friction[0]);
        evidence(sparse as f64 / windows.len() as f64, varies, Tail::of(&records, 1, 1e-4, &[]).as_ref())
    }

    /// Returns uniform numbers in (0, 1).
    fn uniform(count: usize, run: u64) -> Vec<f64> {
        let xi = random::standard_normal(&mut random::stream(5, "heavy tail", run), count);
        xi.iter().map(|xi| asperity_base::distribution::standard_normal_cdf(*xi)).collect()
    }

    #[test]
    fn a_known_tail_index_decides_whether_there_is_a_variance() {
        // P(μ > x) ∝ x^{−α}: μ = U^{−1/α}. Five samples of each; all must be right if α is far from 2.
        for (index, heavy) in [(1.0, true), (5.0, false), (10.0, false), (f64::INFINITY, false)] {
            let wrong = (0..5).filter(|run| {
                let value = |u: &f64| if f64::is_infinite(index) { 1.0 - u.ln() } else { u.powf(-1.0 / index) };
                let windows: Vec<_> = uniform(8000, *run).iter().map(|u| (0.2 * value(u), 500.0)).collect();
                found(&windows).is_some() != heavy
            });
            assert_eq!(wrong.count(), 0, "α = {index}");
        }
    }

    #[test]
    fn windows_of_single_hertz_contacts_have_no_variance_and_windows_of_many_have_one() {
        // n contacts of overlaps uniform in (0, 1): areas ∝ δ, loads ∝ δ^{3/2}. α = 2 for n = 1 and 2n for more, because
        // all n overlaps must be small together. A contact of full overlap has 25 cells.
        for (contacts, heavy) in [(1, true), (12, false)] {
            for run in 0..10 {
                let overlaps = uniform(2000 * contacts, 100 + run);
                let window = |overlaps: &[f64]| {
                    let area: f64 = overlaps.iter().sum();
                    let load: f64 = overlaps.iter().map(|overlap| overlap.powf(1.5)).sum();
                    (0.2 * area / load, 25.0 * area)
                };
                let windows: Vec<_> = overlaps.chunks(contacts).map(window).collect();
                assert_eq!(found(&windows).is_some(), heavy, "{contacts} contacts, run {run}");
            }
        }
    }

    #[test]
    fn constant_friction_has_zero_variance_for_any_number_of_contacts() {
        assert_eq!(found(&[(0.2, 3.0); 500]), None);
    }
}
