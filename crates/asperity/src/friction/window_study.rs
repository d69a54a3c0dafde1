//! What of the correlation of μ(s) is not the window's.
//!
//! A window of length W that slides over uncorrelated friction gives a triangular correlation by itself. One process seen
//! through several windows tells the two apart: its own length ℓ is the same under all of them.

use rayon::prelude::*;

use crate::correlation::{
    EstimateError, LagNormalisation, RecordCorrelation, RecordModel, fit_record, fit_windowed_exponential,
};
use crate::friction::strip::Record;
use crate::friction::window::Window;
use crate::stats::{Interval, Moments, NORMAL_95};

/// Most groups of strips of the jackknife.
const MOST_GROUPS: usize = 20;

/// One exponential process under several windows: ρ_W = triangle_W ⊛ e^{−s/ℓ}, fitted jointly.
#[derive(Debug, Clone, PartialEq)]
pub struct WindowStudy {
    /// What each window sees, from the longest.
    pub windows: Vec<WindowCorrelation>,
    /// ℓ in metre, without the window; 0 where the windows explain everything.
    pub length_m: f64,
    /// 95 % interval of ℓ by the jackknife over strips, cut at 0.
    pub interval: Interval,
    /// Root mean square misfit of the correlations.
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
    /// ℓ in metre of e^{−s/ℓ} fitted to this window alone, which contains the window.
    pub length_m: f64,
}

impl WindowStudy {
    /// The study of records at the mean load ([`Record::at_mean_load`]), which are moving averages; the same strips, in the
    /// same order, under every window.
    ///
    /// # Errors
    /// Fewer than two strips, or records that do not vary.
    pub fn of(records: &[(Window, Vec<Record>)]) -> Result<Self, EstimateError> {
        let strips = records.iter().map(|(_, records)| records.len()).min().unwrap_or(0);
        if strips < 2 {
            return Err(EstimateError::TooFew { present: strips, wanted: 2 });
        }
        let (length_m, misfit) = joint_fit(records, |_| true)?;
        let groups = strips.min(MOST_GROUPS);
        let left_out: Result<Vec<f64>, EstimateError> = (0..groups)
            .into_par_iter()
            .map(|group| joint_fit(records, |strip| strip % groups != group).map(|(length_m, _)| length_m))
            .collect();
        let spread = Moments::of(&left_out?).std;
        let half_width_m = NORMAL_95 * spread * ((groups - 1) as f64).sqrt();
        let windows: Result<Vec<WindowCorrelation>, EstimateError> =
            records.iter().map(|(window, records)| WindowCorrelation::of(window, records)).collect();
        Ok(Self {
            windows: windows?,
            length_m,
            interval: Interval { low: (length_m - half_width_m).max(0.0), high: length_m + half_width_m },
            misfit,
            resolution_m: resolution_m(records),
        })
    }

    /// Whether the windows alone explain the correlation: the interval of ℓ includes what cannot be told from 0.
    pub fn window_only(&self) -> bool {
        self.interval.low < self.resolution_m
    }
}

impl WindowCorrelation {
    fn of(window: &Window, records: &[Record]) -> Result<Self, EstimateError> {
        let estimate = correlation(window, records, |_| true)?;
        let length_m = fit_record(&estimate, RecordModel::Exponential)?.length_m;
        Ok(Self { window_m: window.length_m(), std: estimate.variance.sqrt(), length_m })
    }
}

/// ℓ and misfit over the strips that are `kept`.
fn joint_fit(
    records: &[(Window, Vec<Record>)],
    kept: impl Fn(usize) -> bool + Copy,
) -> Result<(f64, f64), EstimateError> {
    let estimates: Result<Vec<(f64, RecordCorrelation)>, EstimateError> =
        records.iter().map(|(window, records)| Ok((window.length_m(), correlation(window, records, kept)?))).collect();
    let estimates = estimates?;
    let views: Vec<(f64, &RecordCorrelation)> = estimates.iter().map(|(window_m, found)| (*window_m, found)).collect();
    let (length_m, misfit) = fit_windowed_exponential(&views)?;
    // A length far below every step is the lower end of the fit, and means zero.
    Ok((if length_m < 0.1 * resolution_m(records) { 0.0 } else { length_m }, misfit))
}

/// Shortest step of the windows in metre.
fn resolution_m(records: &[(Window, Vec<Record>)]) -> f64 {
    records.iter().map(|(window, _)| window.step_m()).fold(f64::INFINITY, f64::min)
}

fn correlation(
    window: &Window,
    records: &[Record],
    kept: impl Fn(usize) -> bool,
) -> Result<RecordCorrelation, EstimateError> {
    let chosen = records.iter().enumerate().filter(|(strip, _)| kept(*strip));
    let series: Vec<&[f64]> = chosen.map(|(_, record)| record.friction.as_slice()).collect();
    // Beyond four windows there is nothing left to see of either.
    let lags = (4.0 * window.length_m() / window.step_m()) as usize;
    let longest = series.iter().map(|record| record.len()).max().unwrap_or(0);
    RecordCorrelation::estimate(&series, window.step_m(), lags.min(longest / 2), LagNormalisation::PairNormalised)
}
