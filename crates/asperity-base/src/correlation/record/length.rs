//! Correlation lengths of records with their intervals.

use statrs::distribution::{ChiSquared, ContinuousCDF};

use super::band::RecordBand;
use super::checked_moments;
use super::likelihood::{Likelihood, RecordEnds, WindowedRecords};
use super::model::RecordModel;
use super::tangent::Tangent;
use crate::correlation::estimate::EstimateError;
use crate::numeric::scanned_minimum;
use crate::stats::{Interval, Moments, student_quantile};

/// Least number of blocks for the variance of the score.
const PIECES: usize = 20;
/// Least length of a block in units of ℓ + W.
const SHORTEST_PIECE: f64 = 10.0;
/// Degrees of freedom assigned to the theoretical variance of the score for Gaussian records.
const PRIOR: f64 = 10.0;
/// Probability of the interval of a length.
const LEVEL: f64 = 0.95;

/// Settings of a fit of the correlation length.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct LengthSettings {
    /// Boundary of the records.
    pub ends: RecordEnds,
    /// Whether to fit the fraction of white noise in the values.
    pub noise: bool,
    /// Frequencies used; by default all up to half a wave per window.
    pub band: RecordBand,
}

/// Goodness-of-fit test of a spectrum of records: χ² over bands of wavenumbers, corrected for the fitted parameters.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct LackOfFit {
    /// Sum of squared deviations.
    pub statistic: f64,
    /// Degrees of freedom.
    pub degrees_of_freedom: f64,
    /// p-value.
    pub p_value: f64,
}

impl LackOfFit {
    /// Returns whether the test rejects the family at 1 %.
    pub fn significant(&self) -> bool {
        self.p_value < 0.01
    }
}

/// Fitted ℓ of a family ρ_0, corrected for the window.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct LengthFit {
    /// The family.
    pub model: RecordModel,
    /// ℓ in metre; 0 if the windows explain the whole correlation.
    pub length_m: f64,
    /// 95 % interval of ℓ; the upper limit is at most the length of the longest record, and a lower limit of 0
    /// means that no small length is rejected.
    pub interval: Interval,
    /// Narrowest window in metre.
    pub window_m: f64,
    /// Distance in metre of the values averaged by a window; 0 for a mean over a line.
    pub cell_m: f64,
    /// Standard deviation under the narrowest window, without noise and filters, in the unit of the records.
    pub std: f64,
    /// Fraction of white noise in the variance of the values; 0 if not fitted.
    pub noise_fraction: f64,
    /// 95 % interval of the noise fraction; `None` if not fitted.
    pub noise_interval: Option<Interval>,
    /// Goodness of fit; `None` with too few wavenumbers.
    pub lack_of_fit: Option<LackOfFit>,
    /// ln L of Whittle's likelihood, with each wavenumber counted once over all windows.
    pub log_likelihood: f64,
    /// Variance of the score relative to independent Gaussian records: 1 if model and normality hold.
    pub dispersion: f64,
    /// Redundancy of the tracks of a strip: variance of the score of strips relative to independent tracks; 1 with one
    /// track.
    pub track_redundancy: f64,
    /// Number of blocks for the variance of the score.
    pub pieces: usize,
}

/// Fits ℓ of a family to records of one process under one or more windows by Whittle's likelihood.
///
/// The expectation of every periodogram ordinate accounts for window, sampling and record length; the mean is unknown.
/// A wavenumber counts once over all windows, so windows on the same strips are not treated as independent.
///
/// The interval is {2 ln(L_max/L) < c t²} with Student's quantile t and the ratio c of the variance of the score to the
/// information. c combines the variance over blocks of the strips (whole strips, or about twenty blocks of fewer
/// strips) with the theoretical value for Gaussian records, weighted as ten blocks. The scores of the tracks in a block
/// are summed first, and the theoretical value is multiplied by [`LengthFit::track_redundancy`], which without blocks
/// is the number of tracks.
///
/// # Errors
/// No record, a step that is not positive, values that do not vary, or fewer than three wavenumbers below 1/(2W).
pub fn fit_length(
    channels: &[WindowedRecords<'_>],
    model: RecordModel,
    settings: LengthSettings,
) -> Result<LengthFit, EstimateError> {
    check(channels)?;
    let too_few = EstimateError::TooFew { present: 0, wanted: 3 };
    let likelihood = Likelihood::new(channels, settings.ends, settings.band, model).ok_or(too_few)?;
    let (low_m, high_m) = range_m(channels);
    let curve = |length_m: f64| likelihood.profile(length_m, settings.noise).1;
    let (length_m, least) = minimum(&curve, low_m, high_m);
    let (noise_fraction, _) = likelihood.profile(length_m, settings.noise);
    let narrowest = narrowest(channels);
    let scatter = Scatter::new(narrowest, model, settings, (length_m, low_m), noise_fraction, likelihood.spread());
    let bound = least + 0.5 * scatter.dispersion * scatter.t * scatter.t;
    let interval = Interval {
        low: if curve(0.0) <= bound { 0.0 } else { crossing(&curve, bound, length_m, low_m).unwrap_or(0.0) },
        high: crossing(&curve, bound, length_m.max(low_m), high_m).unwrap_or(high_m),
    };
    let tangent = Tangent::new(&likelihood, length_m, noise_fraction);
    let lack_of_fit = tangent.lack_of_fit(scatter.of_ordinates).and_then(|(statistic, degrees_of_freedom)| {
        let distribution = ChiSquared::new(degrees_of_freedom).ok()?;
        Some(LackOfFit { statistic, degrees_of_freedom, p_value: distribution.sf(statistic.max(0.0)) })
    });
    let noise_interval = settings.noise.then(|| {
        let variance = tangent.noise_variance(noise_fraction).unwrap_or(0.0);
        let reach = scatter.t * (scatter.dispersion * variance).sqrt();
        Interval { low: (noise_fraction - reach).max(0.0), high: (noise_fraction + reach).min(1.0) }
    });
    Ok(LengthFit {
        model,
        length_m,
        interval,
        window_m: narrowest.window_m,
        cell_m: narrowest.cell_m,
        std: (tangent.variance * (1.0 - noise_fraction)).sqrt(),
        noise_fraction,
        noise_interval,
        lack_of_fit,
        log_likelihood: -least,
        dispersion: scatter.dispersion,
        track_redundancy: scatter.track_redundancy,
        pieces: scatter.pieces,
    })
}

/// Returns ℓ in metre and the maximum of ln L, without the rest of [`fit_length`]; `None` with too few wavenumbers.
pub(super) fn most_likely(
    channel: &WindowedRecords<'_>,
    model: RecordModel,
    settings: LengthSettings,
) -> Option<(f64, f64)> {
    let channels = std::slice::from_ref(channel);
    let likelihood = Likelihood::new(channels, settings.ends, settings.band, model)?;
    let (low_m, high_m) = range_m(channels);
    let (length_m, least) = minimum(&|length_m| likelihood.profile(length_m, settings.noise).1, low_m, high_m);
    Some((length_m, -least))
}

fn check(channels: &[WindowedRecords<'_>]) -> Result<(), EstimateError> {
    for channel in channels {
        checked_moments(channel.records.iter().flat_map(|record| record.iter().copied()), channel.step_m, 3)?;
    }
    if channels.is_empty() { Err(EstimateError::Nothing) } else { Ok(()) }
}

/// Returns the channel with the narrowest window, which contains nearly all the information.
fn narrowest<'a, 'b>(channels: &'b [WindowedRecords<'a>]) -> &'b WindowedRecords<'a> {
    let less = |a: &'b WindowedRecords<'a>, b: &'b WindowedRecords<'a>| if b.window_m < a.window_m { b } else { a };
    channels.iter().fold(&channels[0], less)
}

/// Returns the range of lengths: shorter ones cannot be distinguished from zero, longer ones from a trend.
fn range_m(channels: &[WindowedRecords<'_>]) -> (f64, f64) {
    let finest = channels.iter().map(|c| f64::max(c.step_m, c.window_m / 16.0)).fold(f64::INFINITY, f64::min);
    let longest = channels.iter().map(WindowedRecords::longest_m).fold(0.0, f64::max);
    (0.02 * finest, longest)
}

/// Returns the minimum of −ln L over ℓ, by a coarse scan of ln ℓ and golden-section search; 0 if that is as likely.
fn minimum(curve: &dyn Fn(f64) -> f64, low_m: f64, high_m: f64) -> (f64, f64) {
    let factor: f64 = 2.0;
    let steps = ((high_m / low_m).ln() / factor.ln()).ceil() as i32;
    let logarithms: Vec<f64> = (0..=steps).map(|i| (low_m * factor.powi(i)).min(high_m).ln()).collect();
    let found = scanned_minimum(|log_length| curve(log_length.exp()), &logarithms, 2e-3);
    let found = (found.place.exp(), found.value);
    let zero = curve(0.0);
    if zero <= found.1 + 1e-6 { (0.0, zero) } else { found }
}

/// Returns the length between `from_m` and `limit_m` at which −ln L reaches `bound`; `None` if it does not.
fn crossing(curve: &dyn Fn(f64) -> f64, bound: f64, from_m: f64, limit_m: f64) -> Option<f64> {
    let next = |m: f64| if limit_m < from_m { (m / 1.5).max(limit_m) } else { (m * 1.5).min(limit_m) };
    let (mut inside, mut outside) = (from_m, from_m);
    while curve(outside) <= bound {
        if outside == limit_m {
            return None;
        }
        (inside, outside) = (outside, next(outside));
    }
    while (outside / inside).ln().abs() > 4e-3 {
        let middle = (inside * outside).sqrt();
        if curve(middle) <= bound { inside = middle } else { outside = middle }
    }
    Some((inside * outside).sqrt())
}

/// Variance of the score relative to independent Gaussian ordinates.
struct Scatter {
    dispersion: f64,
    /// Variance of ordinates: skewed records, and so their scores, have a larger variance than the theoretical one.
    of_ordinates: f64,
    track_redundancy: f64,
    /// Number of blocks.
    pieces: usize,
    /// Student's quantile for the interval.
    t: f64,
}

impl Scatter {
    /// Combines the variance over the blocks of records under the narrowest window with the theoretical one.
    fn new(
        channel: &WindowedRecords<'_>,
        model: RecordModel,
        settings: LengthSettings,
        (length_m, least_m): (f64, f64),
        noise: f64,
        theory: f64,
    ) -> Self {
        let pieces = Pieces::new(channel, length_m + channel.window_m, settings, model);
        let found = pieces.and_then(|pieces| pieces.dispersion(length_m.max(least_m), noise, channel.tracks));
        let (dispersion, track_redundancy, freedom, pieces) = match found {
            Some((found, redundancy, count)) => {
                let own = count as f64 - 1.0;
                ((PRIOR * theory * redundancy + own * found) / (PRIOR + own), redundancy, PRIOR + own, count)
            }
            None => (theory * channel.tracks as f64, channel.tracks as f64, PRIOR, 1),
        };
        let of_ordinates = dispersion.max(theory * track_redundancy);
        Self { dispersion, of_ordinates, track_redundancy, pieces, t: student_quantile(0.5 + 0.5 * LEVEL, freedom) }
    }
}

/// Blocks of the strips under the narrowest window.
struct Pieces {
    /// Likelihood by blocks of records.
    likelihood: Likelihood,
    /// Block of the strip that contains each block of a record.
    places: Vec<usize>,
    /// Number of blocks of strips.
    count: usize,
}

impl Pieces {
    /// Divides strips into about [`PIECES`] blocks, none shorter than ten times `reach_m`.
    fn new(channel: &WindowedRecords<'_>, reach_m: f64, settings: LengthSettings, model: RecordModel) -> Option<Self> {
        let wanted = PIECES.div_ceil(channel.records.len().div_ceil(channel.tracks));
        let shortest = SHORTEST_PIECE * reach_m / channel.step_m;
        let (mut pieces, mut places, mut count) = (Vec::<&[f64]>::new(), Vec::new(), 0);
        for strip in channel.records.chunks(channel.tracks) {
            let parts = wanted.min((strip[0].len() as f64 / shortest) as usize).max(1).min(strip[0].len());
            for record in strip {
                let length = record.len() / parts.max(1);
                for (place, piece) in record.chunks_exact(length.max(1)).take(parts).enumerate() {
                    pieces.push(piece);
                    places.push(count + place);
                }
            }
            count += parts;
        }
        let whole = pieces.len() == channel.records.len();
        let cut = WindowedRecords { records: pieces, ..channel.clone() };
        let ends = if whole { settings.ends } else { RecordEnds::Free };
        let likelihood = Likelihood::new(&[cut], ends, settings.band, model)?;
        (count > 1).then_some(Self { likelihood, places, count })
    }

    /// Returns the ratio of the variance of the block scores to their information, the redundancy of the tracks, and
    /// the number of blocks.
    fn dispersion(&self, length_m: f64, noise: f64, tracks: usize) -> Option<(f64, f64, usize)> {
        let (scores, information) = Tangent::new(&self.likelihood, length_m, noise).scores(self.places.len());
        let of = |scores: &[f64]| {
            let spread = Moments::new(scores).sample_std();
            scores.len() as f64 * spread * spread / information
        };
        let found = of(&self.by_place(&scores));
        let alike = if tracks == 1 { 1.0 } else { (found / of(&scores)).clamp(1.0, tracks as f64) };
        (found.is_finite() && alike.is_finite()).then_some((found, alike, self.count))
    }

    /// Returns the sums over the tracks of every block.
    fn by_place(&self, of_records: &[f64]) -> Vec<f64> {
        let mut sums = vec![0.0; self.count];
        self.places.iter().zip(of_records).for_each(|(place, value)| sums[*place] += value);
        sums
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::random;

    /// Returns the means over `window` cells, at every step, of a process with correlation e^{−s/ℓ} between cells.
    fn averaged(length: f64, window: usize, step: usize, cells: usize, index: u64) -> Vec<f64> {
        let phi = if length > 0.0 { (-1.0 / length).exp() } else { 0.0 };
        let noise = random::standard_normal(&mut random::stream(41, "length", index), cells);
        let mut last = noise[0];
        let mut sums = vec![0.0];
        for e in &noise {
            last = phi * last + (1.0 - phi * phi).sqrt() * e;
            sums.push(sums[sums.len() - 1] + last + 5.0);
        }
        (0..=cells - window).step_by(step).map(|i| (sums[i + window] - sums[i]) / window as f64).collect()
    }

    fn fit(records: &[Vec<f64>], window_m: f64, step_m: f64) -> LengthFit {
        let records = records.iter().map(Vec::as_slice).collect();
        let channel = WindowedRecords { window_m, step_m, cell_m: 1.0, tracks: 1, records };
        fit_length(&[channel], RecordModel::Exponential, LengthSettings::default()).unwrap()
    }

    #[test]
    fn intervals_cover_the_true_length_in_most_runs() {
        // The documentation reports 1,000 runs; here 60 of 100 ℓ: the expectation is 57, and fewer than 51 have
        // probability .003.
        let fits: Vec<LengthFit> = (0..60).map(|index| fit(&[averaged(40.0, 8, 1, 4000, index)], 8.0, 1.0)).collect();
        let hits = fits.iter().filter(|fit| fit.interval.contains(40.0)).count();
        let mean = fits.iter().map(|fit| fit.length_m).sum::<f64>() / 60.0;
        let sd = (fits.iter().map(|fit| (fit.length_m - mean).powi(2)).sum::<f64>() / 59.0).sqrt();
        assert!((51..=60).contains(&hits), "{hits} of 60");
        // Bias of order ℓ²/L = 1 %.
        assert!((mean - 40.0).abs() < 4.0 * sd / 60.0_f64.sqrt() + 0.4, "{mean} ± {sd}");
        // The variance of ℓ from a continuous exponential record of length T is 2ℓ³/T; the taper and the mean add some.
        let theory = (2.0 * 40.0_f64.powi(3) / 4000.0).sqrt();
        assert!(sd > 0.8 * theory && sd < 1.6 * theory, "{sd} {theory}");
    }

    #[test]
    fn uncorrelated_values_under_a_window_have_no_length() {
        // An interval misses the boundary value with probability 2.5 %; two or more of ten with 2.5 %.
        let fits: Vec<LengthFit> =
            (100..110).map(|index| fit(&[averaged(0.0, 16, 2, 4000, index)], 16.0, 2.0)).collect();
        let missed = fits.iter().filter(|found| found.interval.low >= 2.0).count();
        assert!(missed <= 1, "{missed} of 10");
        assert!(fits.iter().all(|found| found.length_m < 12.0));
    }

    #[test]
    fn windows_on_the_same_record_count_once() {
        let cells = averaged(40.0, 1, 1, 8192, 7);
        let under = |window: usize, step: usize| -> Vec<f64> {
            (0..=cells.len() - window)
                .step_by(step)
                .map(|i| cells[i..i + window].iter().sum::<f64>() / window as f64)
                .collect()
        };
        let windows = [64_usize, 32, 16, 8].map(|window| (window, under(window, window / 8)));
        let channels: Vec<WindowedRecords<'_>> = windows
            .iter()
            .map(|(window, record)| WindowedRecords {
                window_m: *window as f64,
                step_m: (*window / 8) as f64,
                cell_m: 1.0,
                tracks: 1,
                records: vec![record],
            })
            .collect();
        let settings = LengthSettings::default();
        let joint = fit_length(&channels, RecordModel::Exponential, settings).unwrap();
        let narrowest = fit_length(&channels[3..], RecordModel::Exponential, settings).unwrap();
        let width = |fit: &LengthFit| fit.interval.high - fit.interval.low;
        assert!((joint.length_m / narrowest.length_m - 1.0).abs() < 0.05, "{joint:?} {narrowest:?}");
        assert!((width(&joint) / width(&narrowest) - 1.0).abs() < 0.15, "{joint:?} {narrowest:?}");
    }

    #[test]
    fn uninformative_records_are_rejected() {
        let settings = LengthSettings::default();
        let of = |values: &[f64], step_m: f64| {
            let channel = WindowedRecords { window_m: 1.0, step_m, cell_m: 0.0, tracks: 1, records: vec![values] };
            fit_length(&[channel], RecordModel::Exponential, settings)
        };
        assert_eq!(fit_length(&[], RecordModel::Exponential, settings), Err(EstimateError::Nothing));
        assert_eq!(of(&[0.1; 50], 1.0), Err(EstimateError::Constant { present: 50 }));
        assert_eq!(of(&[0.1, 0.2, 0.3], 0.0), Err(EstimateError::BadStep { step_m: 0.0 }));
        assert!(matches!(of(&[0.1, 0.2, 0.3], 1.0), Err(EstimateError::TooFew { .. })));
    }
}
