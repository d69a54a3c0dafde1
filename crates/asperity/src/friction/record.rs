//! What the records of a level say about μ(s) as a process.

use std::borrow::Cow;

use crate::correlation::{EstimateError, LagNormalisation, RecordCorrelation, RecordFit, RecordModel, fit_record};
use crate::friction::FrictionError;
use crate::friction::strip::Record;
use crate::law::fit::{End, Family, Fit, Ranking, rank_by_aic};
use crate::stats::{Bootstrap, Interval, Moments, Resampling, correlation_time};

/// Scatter over the mean below which friction does not vary.
const ROUNDING: f64 = 1e-12;

/// Contact cells that a window should hold for its area to mean something.
pub const WANTED_CONTACT_CELLS: f64 = 30.0;

/// Statistics of μ(s), pooled over the records of independent strips.
#[derive(Debug, Clone)]
pub struct FrictionStatistics {
    /// Moments over all windows with contact.
    pub moments: Moments,
    /// 95 % interval of the mean, by resampling strips.
    pub mean_interval: Interval,
    /// 95 % interval of the standard deviation, by resampling strips.
    pub std_interval: Interval,
    /// Windows without contact, left out of everything else.
    pub empty_windows: usize,
    /// Mean number of contact cells in a window.
    pub contact_cells: f64,
    /// Share of windows that hold fewer contact cells than [`WANTED_CONTACT_CELLS`], empty ones included.
    pub sparse_share: f64,
    /// Number of independent windows that the correlated ones are worth.
    pub effective_windows: f64,
    /// Marginal laws ranked by Akaike's criterion.
    pub marginals: Ranking,
    /// The Beta law with bounds fitted by likelihood, where it exists.
    pub beta: Option<Fit>,
    /// Autocorrelation over lags up to half the strip, or why there is none.
    pub correlation: Result<ProcessCorrelation, EstimateError>,
}

/// Autocorrelation of μ(s) with its fitted models.
#[derive(Debug, Clone)]
pub struct ProcessCorrelation {
    /// Pooled estimate.
    pub estimate: RecordCorrelation,
    /// e^{−s/ℓ}: ℓ is the paper's ℓ_μ, which contains the window.
    pub exponential: RecordFit,
}

impl FrictionStatistics {
    /// Statistics of the records of one level, whose positions lie `step_m` apart. A friction coefficient that does not
    /// vary at all has no correlation and no marginal law.
    ///
    /// # Errors
    /// Fewer than ten windows with contact.
    pub fn of(records: &[Record], step_m: f64, seed: u64) -> Result<Self, FrictionError> {
        let records = &without_rounding(records)[..];
        let pooled: Vec<f64> = records.iter().flat_map(|record| record.friction.iter().copied()).collect();
        let moments = Moments::of(&pooled);
        let empty_windows = pooled.len() - moments.n;
        if moments.n < 10 {
            return Err(FrictionError::NoContact { windows: pooled.len(), with_contact: moments.n });
        }
        // Strips are independent, windows on one are not: strips are resampled.
        let indices: Vec<f64> = (0..records.len()).map(|index| index as f64).collect();
        let bootstrap = Bootstrap::new(Resampling::Independent, seed);
        let of_strips = |chosen: &[f64]| {
            Moments::of_values(chosen.iter().flat_map(|index| records[*index as usize].friction.iter().copied()))
        };
        let mean_interval = bootstrap.interval(&indices, |chosen| of_strips(chosen).mean)?;
        let std_interval = bootstrap.interval(&indices, |chosen| of_strips(chosen).std)?;
        let cells = || records.iter().flat_map(|record| &record.contact_cells);
        let sparse = cells().filter(|cells| **cells < WANTED_CONTACT_CELLS).count();
        let effective_windows = records
            .iter()
            .map(|record| correlation_time(&record.friction).map_or(1.0, |time| time.effective_size()))
            .sum::<f64>()
            .min(moments.n as f64);
        let marginals = rank_by_aic(&Family::ANYWHERE, &pooled, Some(effective_windows));
        let beta = marginals.fits.iter().find(|fit| fit.family == Family::BetaFreeBounds).cloned();
        Ok(Self {
            moments,
            mean_interval,
            std_interval,
            empty_windows,
            contact_cells: cells().sum::<f64>() / pooled.len() as f64,
            sparse_share: sparse as f64 / pooled.len() as f64,
            effective_windows,
            marginals,
            beta,
            correlation: correlate(records, step_m),
        })
    }

    /// The marginal law to go on with: the first of the ranking whose ends the sample sees. A fitted end far outside the
    /// sample makes a law of four parameters that is hardly different from a simpler one.
    pub fn marginal(&self) -> Option<&Fit> {
        let seen = |fit: &&Fit| fit.low_end != End::OutOfSight && fit.high_end != End::OutOfSight;
        self.marginals.fits.iter().find(seen).or(self.marginals.fits.first())
    }
}

/// Records whose values differ by rounding alone are made constant, so that nobody takes rounding for a process.
fn without_rounding(records: &[Record]) -> Cow<'_, [Record]> {
    let moments = Moments::of_values(records.iter().flat_map(|record| record.friction.iter().copied()));
    if moments.n == 0 || moments.std > ROUNDING * moments.mean.abs() {
        return Cow::Borrowed(records);
    }
    let constant = |mu: &f64| if mu.is_nan() { f64::NAN } else { moments.mean };
    let settled =
        |record: &Record| Record { friction: record.friction.iter().map(constant).collect(), ..record.clone() };
    records.iter().map(settled).collect()
}

fn correlate(records: &[Record], step_m: f64) -> Result<ProcessCorrelation, EstimateError> {
    let series: Vec<&[f64]> = records.iter().map(|record| record.friction.as_slice()).collect();
    let largest_lag = series.iter().map(|record| record.len()).max().unwrap_or(0) / 2;
    let estimate = RecordCorrelation::estimate(&series, step_m, largest_lag, LagNormalisation::PairNormalised)?;
    let exponential = fit_record(&estimate, RecordModel::Exponential)?;
    Ok(ProcessCorrelation { estimate, exponential })
}
