//! Window study: separates the correlation of μ(s) from the effect of the window.
//!
//! A window of length W that slides over uncorrelated friction has a triangular correlation. Windows of several lengths
//! on the same strips separate this effect from the process, whose own length ℓ does not depend on the window.

use crate::strip::Record;
use crate::window::Window;
use asperity_base::blocks;
use asperity_base::correlation::{
    EstimateError, FamilyFits, LackOfFit, LengthFit, LengthSettings, RecordCorrelation, RecordModel, WindowedModel,
    WindowedRecords, fit_families, fit_length, fit_record,
};
use asperity_base::stats::{Interval, jackknife_error, jackknife_reach, student_two_sided};

/// Largest and least number of groups of strips of the jackknife.
const MOST_GROUPS: usize = 20;
const LEAST_GROUPS: usize = 5;

/// One process under several windows, ρ_W = triangle_W ⊛ ρ_0(ℓ), fitted jointly by [`fit_families`].
///
/// Records of several windows are moving averages of the same strips. A wavenumber that two windows share carries the
/// same information in both, so it counts once. The narrowest window contains almost all information; the others show
/// whether one ℓ holds for all windows.
#[derive(Debug, Clone, PartialEq)]
pub struct WindowStudy {
    /// Results of each window, from the longest.
    pub windows: Vec<WindowCorrelation>,
    /// Both families of ρ_0 without the window.
    pub families: FamilyFits,
    /// Family of ρ_0 to use; the exponential if the records do not tell them apart.
    pub model: RecordModel,
    /// ℓ in metre, without the window; 0 if the windows explain the whole correlation.
    pub length_m: f64,
    /// 95 % interval of ℓ: the wider of the likelihood interval and the jackknife interval over strips.
    pub interval: Interval,
    /// Test of the model against the spectra under all windows.
    pub lack_of_fit: Option<LackOfFit>,
    /// Probability of such differences of ℓ between single windows if one ℓ holds for all: Student tests of the
    /// differences from the narrowest window with jackknife standard errors over strips, combined by Bonferroni. `None`
    /// with fewer than five strips or two windows.
    pub one_length_p: Option<f64>,
    /// Root mean square misfit of the correlations under all windows.
    pub misfit: f64,
    /// Shortest step of a window in metre; a shorter ℓ cannot be distinguished from 0.
    pub resolution_m: f64,
}

/// The process under one window.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct WindowCorrelation {
    /// Length of the window in metre.
    pub window_m: f64,
    /// Standard deviation of μ.
    pub std: f64,
    /// Standard deviation that the joint fit expects.
    pub expected_std: f64,
    /// ℓ in metre of e^{−s/ℓ} fitted to the correlation under this window; it includes the window.
    pub length_m: f64,
    /// ℓ of ρ_0 without the window, from this window alone; absent if the strips contain too few windows.
    pub own: Option<LengthFit>,
}

impl WindowStudy {
    /// Fits both families to records at the mean load ([`Record::at_mean_load`]), which are moving averages, with
    /// `tracks` records per strip. Every window has the records of the same strips in the same order. Ends may be
    /// periodic only if the positions of every window divide the strip evenly.
    ///
    /// # Errors
    /// There is no strip, the records are constant, or the strips are shorter than about three windows.
    pub fn new(
        records: &[(Window, Vec<Record>)],
        tracks: usize,
        settings: LengthSettings,
    ) -> Result<Self, EstimateError> {
        let channels: Vec<WindowedRecords<'_>> =
            records.iter().map(|(window, records)| channel(window, records, tracks)).collect();
        let families = fit_families(&channels, settings)?;
        let joint = families.chosen;
        let model = joint.model;
        let under = |window_m: f64| WindowedModel::new(model, window_m).with_cells(joint.cell_m);
        let seen: Result<Vec<(WindowCorrelation, f64)>, EstimateError> = blocks::map(0..channels.len(), |window| {
            let channel = &channels[window];
            let estimate = correlation(channel)?;
            let fitted = WindowCorrelation {
                window_m: channel.window_m,
                std: estimate.variance.sqrt(),
                expected_std: joint.std * std_ratio(under, joint.length_m, channel.window_m, joint.window_m),
                length_m: fit_record(&estimate, RecordModel::Exponential)?.length_m,
                own: fit_length(std::slice::from_ref(channel), model, settings).ok(),
            };
            Ok((fitted, estimate.misfit(&under(channel.window_m), joint.length_m)))
        });
        let seen = seen?;
        let resolution_m = channels.iter().map(|channel| channel.step_m).fold(f64::INFINITY, f64::min);
        let own: Vec<f64> = seen.iter().filter_map(|(seen, _)| seen.own).map(|own| own.length_m).collect();
        let jackknife = Jackknife::of(&channels, model, settings, resolution_m);
        let mean_square = seen.iter().map(|(_, misfit)| misfit * misfit).sum::<f64>() / seen.len() as f64;
        Ok(Self {
            windows: seen.into_iter().map(|(seen, _)| seen).collect(),
            families,
            model,
            length_m: joint.length_m,
            interval: jackknife.as_ref().map_or(joint.interval, |jackknife| jackknife.widened(&joint)),
            lack_of_fit: joint.lack_of_fit,
            one_length_p: jackknife
                .filter(|_| own.len() == channels.len())
                .and_then(|jackknife| jackknife.one_length(&own)),
            misfit: mean_square.sqrt(),
            resolution_m,
        })
    }

    /// Returns whether the windows alone explain the correlation: the interval of ℓ includes lengths below the
    /// resolution.
    pub fn window_only(&self) -> bool {
        self.interval.low < self.resolution_m
    }
}

/// Logarithms of ℓ without each group of strips: jointly for all windows, and for every window alone. Lengths below a
/// tenth of the resolution are set to that value.
struct Jackknife {
    joint: Vec<f64>,
    own: Vec<Vec<f64>>,
    least_m: f64,
}

impl Jackknife {
    fn of(
        channels: &[WindowedRecords<'_>],
        model: RecordModel,
        settings: LengthSettings,
        resolution_m: f64,
    ) -> Option<Self> {
        let tracks = channels.first()?.tracks;
        let strips = channels.iter().map(|channel| channel.records.len() / tracks).min()?;
        let groups = strips.min(MOST_GROUPS);
        let least_m = 0.1 * resolution_m;
        if groups < LEAST_GROUPS {
            return None;
        }
        let without = |group: usize| -> Option<(f64, Vec<f64>)> {
            let left: Vec<WindowedRecords<'_>> = channels
                .iter()
                .map(|channel| {
                    let kept = |index: &usize| (index / tracks) * groups / strips != group;
                    let records = (0..strips * tracks).filter(kept).map(|index| channel.records[index]).collect();
                    WindowedRecords { records, ..channel.clone() }
                })
                .collect();
            let length = |channels: &[WindowedRecords<'_>]| {
                fit_length(channels, model, settings).ok().map(|fit| fit.length_m.max(least_m).ln())
            };
            let own = left.iter().map(|channel| length(std::slice::from_ref(channel)).unwrap_or(f64::NAN)).collect();
            Some((length(&left)?, own))
        };
        let found: Option<Vec<(f64, Vec<f64>)>> = blocks::map(0..groups, without);
        let (joint, own) = found?.into_iter().unzip();
        Some(Self { joint, own, least_m })
    }

    /// Returns the joint interval, or the jackknife interval if it is wider.
    fn widened(&self, fit: &LengthFit) -> Interval {
        let reach = jackknife_reach(&self.joint);
        let Interval { low, high } = fit.interval;
        if fit.length_m <= self.least_m || !reach.is_finite() {
            return fit.interval;
        }
        Interval { low: low.min(fit.length_m * (-reach).exp()), high: high.max(fit.length_m * reach.exp()) }
    }

    fn one_length(&self, own_m: &[f64]) -> Option<f64> {
        let narrowest = own_m.len().checked_sub(1).filter(|last| *last > 0)?;
        let of = |length_m: f64| length_m.max(self.least_m).ln();
        let p = |window: usize| {
            let differences: Vec<f64> = self.own.iter().map(|own| own[window] - own[narrowest]).collect();
            let difference = of(own_m[window]) - of(own_m[narrowest]);
            student_two_sided(difference / jackknife_error(&differences), differences.len() as f64 - 1.0)
        };
        let least = (0..narrowest).map(p).filter(|p| p.is_finite()).fold(f64::INFINITY, f64::min);
        least.is_finite().then(|| (least * narrowest as f64).min(1.0))
    }
}

fn channel<'a>(window: &Window, records: &'a [Record], tracks: usize) -> WindowedRecords<'a> {
    WindowedRecords {
        window_m: window.length_m(),
        step_m: window.step_m(),
        cell_m: window.cell_m(),
        tracks,
        records: records.iter().map(|record| record.friction.as_slice()).collect(),
    }
}

/// Returns the standard deviation under a window over the standard deviation under a narrower one.
fn std_ratio(under: impl Fn(f64) -> WindowedModel, length_m: f64, window_m: f64, narrower_m: f64) -> f64 {
    if length_m == 0.0 {
        return (narrower_m / window_m).sqrt();
    }
    let variance = |window_m: f64| under(window_m).covariance(0.0, length_m);
    (variance(window_m) / variance(narrower_m)).sqrt()
}

fn correlation(channel: &WindowedRecords<'_>) -> Result<RecordCorrelation, EstimateError> {
    // Beyond four windows the correlation is negligible.
    let lags = (4.0 * channel.window_m / channel.step_m) as usize;
    let longest = channel.records.iter().map(|record| record.len()).max().unwrap_or(0);
    RecordCorrelation::estimate(&channel.records, channel.step_m, lags.min(longest / 2))
}
