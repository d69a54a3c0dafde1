//! Extrapolation of the mean friction in the pitch of the strips.
//!
//! The mean is μ(h) = μ₀ + c hᵖ at the pitch h. The strips at h, h/2, … have the same surfaces. Three pitches give the order p, of the
//! strips or else of the scan. The limit μ₀ differs from μ at the smallest pitch by the last term of the series, which is taken as its
//! error. Of what that μ exceeds the plastic floor, at most half is taken for an error of the pitch.

use super::cutoff::SolvedCutoffs;
use crate::friction::strip::{Record, SolvedStrips, StripProblem};
use crate::stats::{Moments, NORMAL_95};
use crate::study::result::{Pair, ScanFriction};
use crate::study::sentence;

/// Largest error of the pitch over the mean of a resolved surface.
const RESOLVED: f64 = 0.03;
/// Error of the pitch over the sampling error, or over the mean, that needs no smaller pitch.
const BELOW_SAMPLING: f64 = 0.5;
const NEGLIGIBLE: f64 = 0.005;
/// Order of convergence if none is observed, and the range of credible ones.
const ORDER: f64 = 1.0;
const CREDIBLE: std::ops::RangeInclusive<f64> = 0.7..=2.0;
/// Distance from the least friction, over the mean, that rounding may leave.
const ROUNDING: f64 = 1e-9;

/// Mean friction at the pitch of the strips and at vanishing pitch.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Pitch {
    /// μ = ΣF/ΣN at the pitch of the strips.
    pub(super) mean_at_pitch: f64,
    /// Limit at vanishing pitch.
    pub(super) mean: f64,
    /// See [`Strips::pitch_factor`](crate::friction::strip::Strips::pitch_factor).
    pub(super) factor: f64,
    /// Least and largest limit that the order of convergence leaves possible.
    pub(super) range: Pair,
    /// Half of the 95 % interval of `mean` that is due to the few strips of smaller pitches.
    pub(super) noise: f64,
    /// Order of convergence, and where it is from.
    order: f64,
    source: &'static str,
    pitch_m: f64,
    /// Plastic floor of the mean, 0 without one.
    least: f64,
}

impl Pitch {
    /// Extrapolates the mean of strips; `None` if the strips of half the pitch have no solution. A change that the few strips do not show
    /// to differ from zero is not extrapolated.
    pub(super) fn new(
        problem: &StripProblem,
        strips: &SolvedStrips,
        cutoffs: &SolvedCutoffs,
        scan: Option<&ScanFriction>,
    ) -> Option<Self> {
        let mean_at_pitch = Record::at_mean_load(&strips.records).0;
        let order = scan.and_then(|scan| scan.cut_offs.first()?.order);
        Self::of_changes(mean_at_pitch, &cutoffs.changes(), problem.least_coefficient(), order)
            .map(|found| Self { pitch_m: cutoffs.pitch_m, ..found })
    }

    /// Extrapolates a mean from its relative changes from each pitch to half of it, with the half widths of their intervals.
    fn of_changes(mean_at_pitch: f64, changes: &[Pair], least: Option<f64>, of_scan: Option<f64>) -> Option<Self> {
        let (&[change, half], before) = changes.split_last()?;
        let least = least.unwrap_or(0.0).min(mean_at_pitch);
        let coarse = before.iter().fold(mean_at_pitch, |mean, [change, _]| mean * (1.0 + change));
        let coarse_half = before.iter().fold(0.0_f64, |sum, [_, half]| sum.hypot(*half));
        let is_significant = change.abs() > half;
        let of_strips = before.last().filter(|[before, half]| is_significant && before.abs() > *half);
        let of_strips = of_strips.map(|[before, _]| (before / (1.0 + before) / change).log2());
        let (order, source) = match (of_strips.filter(|order| order.is_finite()), of_scan) {
            (Some(order), _) => (order, "observed on the strips"),
            (None, Some(order)) => (order, "observed on the scan"),
            (None, None) => (ORDER, "assumed"),
        };
        let order = order.clamp(*CREDIBLE.start(), *CREDIBLE.end());
        let whole = 1.0 / (1.0 - (-order).exp2());
        let at = |factor: f64| (coarse * (1.0 + factor * change)).max(least);
        let (mean, ends) = if is_significant {
            (at(whole).max(0.5 * (least + at(1.0))), [1.0, 2.0 * whole - 1.0])
        } else {
            (coarse.max(least), [0.0, whole])
        };
        let [a, b] = ends.map(at);
        let excess = mean_at_pitch - least;
        Some(Self {
            mean_at_pitch,
            mean,
            factor: if excess > ROUNDING * mean_at_pitch { (mean - least) / excess } else { 1.0 },
            range: [a.min(b), a.max(b)],
            noise: coarse * coarse_half.hypot(half * if is_significant { whole } else { 1.0 }),
            order,
            source,
            pitch_m: f64::NAN,
            least,
        })
        .filter(|found| found.mean > 0.0)
    }

    /// Returns whether the error of the pitch hardly matters beside the sampling of the strips.
    pub(super) fn is_negligible(&self, strips: &SolvedStrips) -> bool {
        let sampling = NORMAL_95 * Moments::new(&strips.strip_means()).standard_error();
        self.error() <= (BELOW_SAMPLING * sampling).max(NEGLIGIBLE * self.mean)
    }

    /// Returns the error of the mean.
    pub(super) fn error(&self) -> f64 {
        (self.range[1] - self.mean).max(self.mean - self.range[0])
    }

    /// Returns the least and the largest factor of the fluctuation that `range` leaves possible: like the mean, it is what exceeds the floor.
    pub(super) fn fluctuation(&self) -> Pair {
        let excess = self.mean - self.least;
        if excess > 0.0 { self.range.map(|end| (end - self.least) / excess) } else { [1.0; 2] }
    }

    /// Returns the factor of the points along each side that makes the error small; `None` if it is.
    pub(super) fn wanted_points(&self) -> Option<f64> {
        let ratio = self.error() / (RESOLVED * self.mean);
        (self.is_extrapolated() && ratio > 1.0).then(|| ratio.powf(1.0 / self.order).ceil())
    }

    fn is_extrapolated(&self) -> bool {
        self.mean != self.mean_at_pitch
    }

    /// Returns a sentence on the extrapolation; `None` if the mean is that of the pitch.
    pub(super) fn sentence(&self) -> Option<String> {
        let digits = sentence::digits;
        self.is_extrapolated().then(|| {
            format!(
                "The friction coefficient at the operating point is extrapolated to vanishing pitch: it is {} at the pitch {} of the strips, \
                 and of order {} in the pitch ({}).",
                digits(self.mean_at_pitch),
                sentence::si(self.pitch_m, "m"),
                digits(self.order),
                self.source,
            )
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_known_series_has_its_limit_within_the_range() {
        for (order, observed) in
            [(1.0, None), (1.5, Some(1.5)), (2.0, Some(2.0)), (1.4, None), (0.8, None), (2.0, None)]
        {
            let (limit, term) = (0.3, 0.05_f64);
            let [coarse, fine] = [1.0, 0.5_f64].map(|h| limit + term * h.powf(order));
            let found = Pitch::of_changes(coarse, &[[fine / coarse - 1.0, 0.0]], None, observed).unwrap();
            if observed.is_some_and(|observed| observed == order) {
                assert!(
                    (found.mean - limit).abs() < 1e-12 && (found.error() - (fine - limit)).abs() < 1e-12,
                    "{found:?}"
                );
            }
            assert!((found.factor * coarse - found.mean).abs() < 1e-12);
            assert!(found.range[0] <= limit + 1e-12 && limit <= found.range[1], "{order}: {found:?}");
        }
    }

    #[test]
    fn three_pitches_show_their_own_order() {
        for order in [0.8_f64, 1.0, 1.7] {
            let [coarse, fine, finest] = [1.0, 0.5, 0.25_f64].map(|h| 0.3 + 0.05 * h.powf(order));
            let changes = [[fine / coarse - 1.0, 0.001], [finest / fine - 1.0, 0.002]];
            // The order of the scan does not count.
            let found = Pitch::of_changes(coarse, &changes, None, Some(2.0)).unwrap();
            assert!((found.mean - 0.3).abs() < 1e-12 && (found.order - order).abs() < 1e-9, "{found:?}");
            assert!((found.error() - (finest - 0.3)).abs() < 1e-12 && (found.factor * coarse - 0.3).abs() < 1e-12);
            // Independent errors of both changes, the last one times what is extrapolated from it.
            let whole = 1.0 / (1.0 - (-order).exp2());
            assert!((found.noise - fine * 0.001_f64.hypot(0.002 * whole)).abs() < 1e-12, "{found:?}");
        }
        // The last change is noise: the mean of the pitch before it.
        let found = Pitch::of_changes(0.4, &[[-0.05, 0.001], [-0.001, 0.002]], None, None).unwrap();
        assert!((found.mean - 0.38).abs() < 1e-12 && (found.error() - 0.38 * 0.002).abs() < 1e-12, "{found:?}");
        // Changes of either sign have no order.
        let found = Pitch::of_changes(0.4, &[[-0.05, 0.001], [0.01, 0.002]], None, Some(1.5)).unwrap();
        assert_eq!((found.order, found.source), (1.5, "observed on the scan"));
    }

    #[test]
    fn the_plastic_floor_bounds_the_limit_and_noise_is_not_extrapolated() {
        let found = Pitch::of_changes(0.4, &[[-0.2, 0.01]], Some(0.35), None).unwrap();
        assert_eq!((found.mean, found.factor), (0.35, 0.0));
        let found = Pitch::of_changes(0.4, &[[-0.02, 0.03]], None, None).unwrap();
        assert_eq!((found.mean, found.factor, found.wanted_points()), (0.4, 1.0, None));
        assert!((found.range[0] - 0.384).abs() < 1e-12 && found.range[1] == 0.4 && (found.noise - 0.012).abs() < 1e-12);
        // The series leads to 0.33, half of the excess at half the pitch to 0.35.
        let found = Pitch::of_changes(0.4, &[[-0.05, 0.01]], Some(0.32), Some(0.7)).unwrap();
        assert!((found.mean - 0.35).abs() < 1e-12 && found.range == [0.32, 0.38], "{found:?}");
        let [low, high] = found.fluctuation();
        assert!(low == 0.0 && (high - 2.0).abs() < 1e-12, "{found:?}");
        // All contact is at the hardness.
        assert_eq!(Pitch::of_changes(0.4, &[[0.0, 0.0]], Some(0.4), None).unwrap().factor, 1.0);
        // An error of 10 % of first order: four times the points.
        let found = Pitch::of_changes(0.4, &[[-0.1, 0.0]], None, None).unwrap();
        assert_eq!(found.wanted_points(), Some(5.0), "{found:?}");
    }
}
