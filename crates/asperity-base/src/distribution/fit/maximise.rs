//! Local maxima of profile likelihoods over free ends.

use super::family::{End, Family, Fit};
use crate::distribution::{DistributionError, Marginal, condensed};
use crate::numeric::golden_section;

/// Range of the distance between the sample and a free end, in units of the range of the sample.
pub(super) const NEAREST: f64 = 1e-6;
pub(super) const FARTHEST: f64 = 1e3;
/// Number of points of the logarithmic search grid.
const GRID: usize = 55;

/// Fits a distribution with a free lower end, at the largest interior local maximum of the profile likelihood over the
/// shift. The shift of a large sample is found on the [`condensed`] one.
pub(super) fn shift(
    family: Family,
    sorted: &[f64],
    given: impl Fn(&[f64], f64) -> Result<Marginal, DistributionError>,
) -> Result<Fit, DistributionError> {
    shift_by(family, sorted, &condensed(sorted), given)
}

/// Fits as [`shift`] does, with a search over the values of `few`.
fn shift_by(
    family: Family,
    sorted: &[f64],
    few: &[f64],
    given: impl Fn(&[f64], f64) -> Result<Marginal, DistributionError>,
) -> Result<Fit, DistributionError> {
    let least = sorted[0];
    let range = sorted[sorted.len() - 1] - least;
    let at = |values: &[f64], log_gap: f64| {
        Some(Fit::unbounded(family, given(values, least - range * log_gap.exp()).ok()?, values))
    };
    let profile = |log_gap: f64| at(few, log_gap).map_or(f64::NEG_INFINITY, |fit| fit.log_likelihood);

    let step = (FARTHEST / NEAREST).ln() / (GRID - 1) as f64;
    let gaps: Vec<f64> = (0..GRID).map(|i| NEAREST.ln() + step * i as f64).collect();
    let heights: Vec<f64> = gaps.iter().map(|gap| profile(*gap)).collect();
    let peak = (1..GRID - 1)
        .filter(|&i| heights[i].is_finite() && heights[i] > heights[i - 1] && heights[i] >= heights[i + 1])
        .max_by(|&i, &j| heights[i].total_cmp(&heights[j]));
    let none = DistributionError::Sample {
        distribution: family.name(),
        n: sorted.len(),
        reason: "the likelihood has no maximum over the shift: it grows towards the least value or towards minus infinity",
    };
    let Some(peak) = peak else { return Err(none) };
    let bracket = [gaps[peak - 1], gaps[peak + 1]];
    let log_gap = golden_section(|log_gap| -profile(log_gap), bracket, 1.2e-8 * (bracket[1] - bracket[0])).middle();
    at(sorted, log_gap).map(|fit| Fit { low_end: End::Fitted, ..fit }).ok_or(none)
}

#[cfg(test)]
mod tests {
    use super::super::tests::sample;
    use super::super::{lognormal, weibull};
    use super::*;
    use crate::stats::sorted_present;

    type Given = fn(&[f64], f64) -> Result<Marginal, DistributionError>;

    #[test]
    fn a_search_over_group_means_finds_the_shift_of_the_whole_sample() {
        let families: [(Family, &str, Given); 2] = [
            (Family::ShiftedLognormal, "lognormal:0.4,0.7,-3", lognormal::fit),
            (Family::ShiftedWeibull, "weibull:2.5,2,-7", weibull::fit),
        ];
        for (family, text, given) in families {
            let sorted = sorted_present(sample(text, 40_000, 200));
            let found = shift(family, &sorted, given).unwrap();
            let wanted = shift_by(family, &sorted, &sorted, given).unwrap();
            let gain = wanted.log_likelihood - found.log_likelihood;
            // One standard error of the shift costs 1/2.
            assert!((-1e-6..0.05).contains(&gain), "{text}: {gain} {found:?} {wanted:?}");
        }
    }
}
