//! Ranking of correlation models of records.

use super::RecordModel;
use super::length::{LengthFit, LengthSettings, Pieces, fit_length, narrowest};
use super::likelihood::WindowedRecords;
use super::model::WindowedModel;
use crate::correlation::estimate::EstimateError;
use crate::stats::{Moments, student_quantile};

/// Level of the test between models.
const LEVEL: f64 = 0.95;

/// Model in a ranking.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct RankedLength {
    /// The fit.
    pub fit: LengthFit,
    /// Akaike's criterion −2 ln L + 2k relative to the best model; k counts length, variance and a fitted ν, and ln L
    /// is corrected for the redundancy of the tracks of a strip.
    pub aic_difference: f64,
    /// Whether the best model is significantly better; `false` for the best model.
    pub worse: bool,
}

/// Fits models as [`fit_length`] does and ranks them by Akaike's criterion, best first.
///
/// ln L is a sum over the wavenumbers of all records, with two independent values each, so correlated lags are not
/// treated as independent; for tracks of a strip it is divided by [`LengthFit::track_redundancy`]. A model is rejected
/// against the best if the mean difference of ln L over blocks of the records is positive in a one-sided Student test
/// at 5 % (Vuong, *Econometrica* **57** (1989) 307, <https://doi.org/10.2307/1912557>).
///
/// # Errors
/// See [`fit_length`], or an empty list of models.
pub fn rank_lengths(
    channels: &[WindowedRecords<'_>],
    models: &[RecordModel],
    settings: LengthSettings,
) -> Result<Vec<RankedLength>, EstimateError> {
    let fits: Result<Vec<LengthFit>, EstimateError> =
        models.iter().map(|model| fit_length(channels, *model, settings)).collect();
    if models.is_empty() {
        return Err(EstimateError::Nothing);
    }
    Ok(ranked(channels, fits?.into_iter().map(|fit| (fit, 0.0)).collect(), settings))
}

/// Ranks fits to the same wavenumbers by −2 ln L plus the cost of further parameters.
pub(super) fn ranked(
    channels: &[WindowedRecords<'_>],
    mut fits: Vec<(LengthFit, f64)>,
    settings: LengthSettings,
) -> Vec<RankedLength> {
    let criterion = |(fit, cost): &(LengthFit, f64)| cost - 2.0 * fit.log_likelihood / fit.track_redundancy;
    fits.sort_by(|a, b| criterion(a).total_cmp(&criterion(b)));
    let Some(best) = fits.first().copied() else { return Vec::new() };
    let reach_m = best.0.length_m + best.0.window_m;
    let parts = |fit: &LengthFit| {
        let shape = WindowedModel::new(fit.model, 0.0).with_cells(fit.cell_m);
        let seen = WindowedRecords { window_m: fit.window_m, cell_m: fit.cell_m, ..narrowest(channels).clone() };
        Pieces::new(&seen, reach_m, settings, &shape)
            .map(|pieces| pieces.negative_logs(fit.length_m, fit.noise_fraction))
    };
    let of_best = parts(&best.0);
    let rank = |own: &(LengthFit, f64)| RankedLength {
        fit: own.0,
        aic_difference: own.1 - best.1 + 2.0 * (best.0.log_likelihood - own.0.log_likelihood) / best.0.track_redundancy,
        worse: match (&of_best, parts(&own.0)) {
            (Some(reference), Some(other)) if own.0.model != best.0.model => beyond_chance(reference, &other),
            _ => false,
        },
    };
    fits.iter().map(rank).collect()
}

/// Returns whether −ln L of the other model is significantly greater over the blocks.
fn beyond_chance(best: &[f64], other: &[f64]) -> bool {
    let differences: Vec<f64> = other.iter().zip(best).map(|(other, best)| other - best).collect();
    let moments = Moments::new(&differences);
    moments.mean > student_quantile(LEVEL, moments.n as f64 - 1.0) * moments.standard_error()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::random;

    /// Every fourth value of a twice filtered process with Matérn correlation ν = 3/2 and ℓ = √3/rate, or of a once
    /// filtered process, ν = 1/2.
    fn filtered(rate: f64, twice: bool, values: usize, index: u64) -> Vec<f64> {
        let phi = (-0.25 * rate).exp();
        let noise = random::standard_normal(&mut random::stream(43, "ranking", index), 4 * values);
        let (mut first, mut second) = (0.0, 0.0);
        let next = |e: &f64| {
            first = phi * first + e;
            second = phi * second + first;
            if twice { second } else { first }
        };
        noise.iter().map(next).step_by(4).collect()
    }

    fn ranked(record: &[f64]) -> Vec<RankedLength> {
        let channel = WindowedRecords { window_m: 0.0, step_m: 1.0, cell_m: 0.0, tracks: 1, records: vec![record] };
        rank_lengths(&[channel], &RecordModel::USUAL, LengthSettings::default()).unwrap()
    }

    #[test]
    fn the_true_model_is_selected_if_identifiable() {
        let rough = ranked(&filtered(1.0 / 10.0, false, 3000, 1));
        assert_eq!(rough[0].fit.model, RecordModel::Exponential, "{rough:?}");
        assert!(rough[0].aic_difference == 0.0 && !rough[0].worse);
        assert!(rough.iter().skip(1).all(|other| other.worse && other.aic_difference > 10.0), "{rough:?}");
        let smooth = ranked(&filtered(1.0 / 10.0, true, 3000, 2));
        assert_eq!(smooth[0].fit.model, RecordModel::Matern { nu: 1.5 }, "{smooth:?}");
        // With four cells per value the filter deviates from the continuous spectrum by some per cent at the highest
        // wavenumbers.
        let ratio = smooth[0].fit.length_m / (10.0 * 3.0_f64.sqrt());
        assert!((ratio - 1.0).abs() < 0.2, "{smooth:?}");
    }
}
