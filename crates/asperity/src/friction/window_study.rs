//! What of the correlation of μ(s) is not the window's.
//!
//! A window of length W that slides over uncorrelated friction gives a triangular correlation by itself. One process seen
//! through several windows tells the two apart: its own length ℓ is the same under all of them.

use rayon::prelude::*;

use crate::correlation::{
    EstimateError, LagNormalisation, LengthFit, LengthSettings, RecordCorrelation, RecordModel, WindowedModel,
    WindowedRecords, fit_length, fit_record,
};
use crate::friction::strip::Record;
use crate::friction::window::Window;
use crate::stats::Interval;

/// One process under several windows, ρ_W = triangle_W ⊛ ρ_0(ℓ), fitted jointly by [`fit_length`].
///
/// Records of several windows are moving averages of the same strips. Where two windows show the same wavenumber they say the
/// same, so it counts once, and the narrowest window says nearly everything: the others show whether one ℓ holds under
/// all of them.
#[derive(Debug, Clone, PartialEq)]
pub struct WindowStudy {
    /// What each window sees, from the longest.
    pub windows: Vec<WindowCorrelation>,
    /// Model ρ_0 without the window.
    pub model: RecordModel,
    /// ℓ in metre, without the window; 0 where the windows explain everything.
    pub length_m: f64,
    /// 95 % interval of ℓ.
    pub interval: Interval,
    /// Root mean square misfit of the correlations under all windows.
    pub misfit: f64,
    /// Shortest step of a window in metre: a shorter ℓ cannot be told from 0.
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
    /// ℓ in metre of e^{−s/ℓ} fitted to the correlation under this window, which contains the window.
    pub length_m: f64,
    /// ℓ of ρ_0 without the window, from this window alone; absent where the strips hold too few windows.
    pub own: Option<LengthFit>,
}

impl WindowStudy {
    /// The study with ρ_0 = e^{−s/ℓ} of records at the mean load ([`Record::at_mean_load`]), which are moving averages; the
    /// same strips, in the same order, under every window. Strips are taken for free ones of one lane.
    ///
    /// # Errors
    /// No strip, records that do not vary, or strips shorter than about three windows.
    pub fn of(records: &[(Window, Vec<Record>)]) -> Result<Self, EstimateError> {
        Self::with(records, 1, RecordModel::Exponential, LengthSettings::default())
    }

    /// The study of strips of so many lanes, with another model or other ends. Ends are periodic only where the positions of every window go round the
    /// strip evenly.
    ///
    /// # Errors
    /// As [`WindowStudy::of`].
    pub fn with(
        records: &[(Window, Vec<Record>)],
        lanes: usize,
        model: RecordModel,
        settings: LengthSettings,
    ) -> Result<Self, EstimateError> {
        let channels: Vec<WindowedRecords<'_>> =
            records.iter().map(|(window, records)| under(window, records, lanes)).collect();
        let joint = fit_length(&channels, model, settings)?;
        let shape = WindowedModel::new(model, 0.0).on_cells(channels[0].cell_m);
        let narrowest_m = channels.iter().map(|channel| channel.window_m).fold(f64::INFINITY, f64::min);
        let seen: Result<Vec<(WindowCorrelation, f64)>, EstimateError> = channels
            .par_iter()
            .map(|channel| {
                let estimate = correlation(channel)?;
                let fitted = WindowCorrelation {
                    window_m: channel.window_m,
                    std: estimate.variance.sqrt(),
                    expected_std: joint.std * std_ratio(&shape, joint.length_m, channel.window_m, narrowest_m),
                    length_m: fit_record(&estimate, RecordModel::Exponential)?.length_m,
                    own: fit_length(std::slice::from_ref(channel), model, settings).ok(),
                };
                Ok((fitted, estimate.misfit(&shape.under(channel.window_m), joint.length_m)))
            })
            .collect();
        let seen = seen?;
        let mean_square = seen.iter().map(|(_, misfit)| misfit * misfit).sum::<f64>() / seen.len() as f64;
        Ok(Self {
            windows: seen.into_iter().map(|(seen, _)| seen).collect(),
            model,
            length_m: joint.length_m,
            interval: joint.interval,
            misfit: mean_square.sqrt(),
            resolution_m: channels.iter().map(|channel| channel.step_m).fold(f64::INFINITY, f64::min),
        })
    }

    /// Whether the windows alone explain the correlation: the interval of ℓ includes what cannot be told from 0.
    pub fn window_only(&self) -> bool {
        self.interval.low < self.resolution_m
    }
}

fn under<'a>(window: &Window, records: &'a [Record], lanes: usize) -> WindowedRecords<'a> {
    WindowedRecords {
        window_m: window.length_m(),
        step_m: window.step_m(),
        cell_m: window.cell_m(),
        lanes,
        records: records.iter().map(|record| record.friction.as_slice()).collect(),
    }
}

/// Standard deviation under a window over that under a narrower one.
fn std_ratio(shape: &WindowedModel, length_m: f64, window_m: f64, narrower_m: f64) -> f64 {
    if length_m == 0.0 {
        return (narrower_m / window_m).sqrt();
    }
    let variance = |window_m: f64| shape.under(window_m).covariance(0.0, length_m);
    (variance(window_m) / variance(narrower_m)).sqrt()
}

fn correlation(channel: &WindowedRecords<'_>) -> Result<RecordCorrelation, EstimateError> {
    // Beyond four windows there is nothing left to see of either.
    let lags = (4.0 * channel.window_m / channel.step_m) as usize;
    let longest = channel.records.iter().map(|record| record.len()).max().unwrap_or(0);
    let normalisation = LagNormalisation::PairNormalised;
    RecordCorrelation::estimate(&channel.records, channel.step_m, lags.min(longest / 2), normalisation)
}
