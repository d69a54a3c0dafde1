//! Statistics of the process μ(s) from the records of a level.

mod heavy_tail;
mod tail;

use std::borrow::Cow;

use crate::FrictionError;
use crate::strip::Record;
use asperity_base::correlation::{
    EstimateError, RecordCorrelation, RecordFit, RecordModel, fit_record, fitted_length_interval,
};
use asperity_base::distribution::fit::{Family, Fit, ParameterEstimate, Ranking, rank_by_aic};
use asperity_base::distribution::goodness::ProcessNull;
use asperity_base::stats::{Interval, Layout, Moments, ProcessEstimate, ProcessMoments, fraction_above};

pub use heavy_tail::{HeavyTail, ISOLATED_FRACTION};
pub use tail::{DistributionTail, ReturnLevel, Tail};

/// Coefficient of variation below which friction counts as constant.
pub(super) const ROUNDING: f64 = 1e-12;

/// Number of contact cells per window below which its contact area is unreliable.
pub const WANTED_CONTACT_CELLS: f64 = 30.0;

/// Number of simulated samples for a p-value.
const DRAWS: usize = 499;

/// Statistics of μ(s), pooled over the records of independent strips.
#[derive(Debug, Clone)]
pub struct FrictionStatistics {
    /// Moments over all windows with contact.
    pub moments: Moments,
    /// Moments with intervals that account for the correlation along the strips.
    pub estimates: ProcessMoments,
    /// Number of windows without contact, which all other statistics leave out.
    pub empty_windows: usize,
    /// Mean number of contact cells in a window.
    pub contact_cells: f64,
    /// Fraction of windows with fewer contact cells than [`WANTED_CONTACT_CELLS`], empty ones included.
    pub sparse_fraction: f64,
    /// Effective sample size: number of independent windows with the same standard error of the mean.
    pub effective_windows: f64,
    /// Marginal distributions ranked by Akaike's criterion, with the empirical one among them. The p-values of their
    /// distances account for the fit and the correlation.
    pub marginals: Ranking,
    /// Parameters of the distributions, in their order, with intervals.
    pub parameters: Vec<Vec<ParameterEstimate>>,
    /// Beta distribution with bounds fitted by likelihood, if it exists.
    pub beta: Option<Fit>,
    /// Upper tail of μ; `None` if the records have too few separate peaks.
    pub tail: Option<Tail>,
    /// Autocorrelation over lags up to half the strip, or the reason why there is none.
    pub correlation: Result<ProcessCorrelation, EstimateError>,
    records: Vec<Vec<f64>>,
    layout: Layout,
}

/// Autocorrelation of μ(s) with its fitted models.
#[derive(Debug, Clone)]
pub struct ProcessCorrelation {
    /// Pooled estimate.
    pub estimate: RecordCorrelation,
    /// Model e^{−s/ℓ}: ℓ is the paper's ℓ_μ, which includes the window.
    pub exponential: RecordFit,
    /// 95 % interval of ℓ_μ by the jackknife over strips or pieces of them; `None` if they are too few.
    pub length_interval: Option<Interval>,
    /// Both families fitted without removing the window, the closest first.
    pub models: Vec<RecordFit>,
}

impl FrictionStatistics {
    /// Computes the statistics of the records of one level, with positions `step_m` apart.
    ///
    /// On a periodic strip the last position is a neighbour of the first. Tracks on one strip do not count as
    /// independent. `true` and `false` as `layout` stand for periodic and free strips with one track. A constant
    /// friction coefficient has no correlation and no marginal distribution.
    ///
    /// # Errors
    /// Fewer than ten windows with contact.
    pub fn new(records: &[Record], step_m: f64, layout: impl Into<Layout>, seed: u64) -> Result<Self, FrictionError> {
        let layout = layout.into();
        let records = &without_rounding(records)[..];
        let series: Vec<&[f64]> = records.iter().map(|record| record.friction.as_slice()).collect();
        let pooled: Vec<f64> = series.concat();
        let estimates = ProcessMoments::new(&series, layout);
        let moments = estimates.moments;
        let empty_windows = pooled.len() - moments.n;
        if moments.n < 10 {
            return Err(FrictionError::NoContact { windows: pooled.len(), with_contact: moments.n });
        }
        let cells = || records.iter().flat_map(|record| &record.contact_cells);
        let sparse = cells().filter(|cells| **cells < WANTED_CONTACT_CELLS).count();
        let effective_windows = estimates.effective_size;
        let families = [&Family::POSITIVE[..], &Family::EMPIRICAL].concat();
        let mut marginals = rank_by_aic(&families, &pooled, Some(effective_windows));
        if let Ok(null) = ProcessNull::new(&series, layout, DRAWS, seed) {
            marginals.assess(&null, &pooled);
        }
        let parameters = marginals.fits.iter().map(|fit| fit.estimates(&series, layout)).collect();
        let beta = marginals.fits.iter().find(|fit| fit.family == Family::BetaFreeBounds).cloned();
        Ok(Self {
            moments,
            estimates,
            empty_windows,
            contact_cells: cells().sum::<f64>() / pooled.len() as f64,
            sparse_fraction: sparse as f64 / pooled.len() as f64,
            effective_windows,
            tail: Tail::of(&series, layout.tracks, step_m, &marginals.fits),
            marginals,
            parameters,
            beta,
            correlation: correlate(&series, layout.tracks, step_m),
            records: series.iter().map(|record| record.to_vec()).collect(),
            layout,
        })
    }

    /// Returns the marginal distribution to use, [`Ranking::chosen`].
    pub fn marginal(&self) -> Option<&Fit> {
        self.marginals.chosen()
    }

    /// Returns the fraction of the windows whose μ exceeds a value, and an estimate with interval. For fitted
    /// distributions see [`asperity_base::distribution::Marginal::survival`].
    pub fn fraction_above(&self, mu: f64) -> (f64, Option<ProcessEstimate>) {
        let series: Vec<&[f64]> = self.records.iter().map(Vec::as_slice).collect();
        fraction_above(&series, mu, self.layout)
    }
}

/// Replaces records whose values differ only by rounding by constant records.
fn without_rounding(records: &[Record]) -> Cow<'_, [Record]> {
    let moments = Moments::from_values(records.iter().flat_map(|record| record.friction.iter().copied()));
    if moments.n == 0 || moments.std > ROUNDING * moments.mean.abs() {
        return Cow::Borrowed(records);
    }
    let constant = |mu: &f64| if mu.is_nan() { f64::NAN } else { moments.mean };
    let settled =
        |record: &Record| Record { friction: record.friction.iter().map(constant).collect(), ..record.clone() };
    records.iter().map(settled).collect()
}

pub(super) fn correlate(series: &[&[f64]], tracks: usize, step_m: f64) -> Result<ProcessCorrelation, EstimateError> {
    let largest_lag = series.iter().map(|record| record.len()).max().unwrap_or(0) / 2;
    let estimate = RecordCorrelation::estimate(series, step_m, largest_lag)?;
    let exponential = fit_record(&estimate, RecordModel::Exponential)?;
    let length_interval = fitted_length_interval(series, tracks, step_m, largest_lag, &exponential);
    let mut models =
        RecordModel::BOTH.iter().map(|model| fit_record(&estimate, *model)).collect::<Result<Vec<_>, _>>()?;
    models.sort_by(|a, b| a.misfit.total_cmp(&b.misfit));
    Ok(ProcessCorrelation { estimate, exponential, length_interval, models })
}
