//! Process fitted to a prepared record: moments, distribution, correlation, and tables for the quality of the fit.

use std::fmt;
use std::str::FromStr;

use super::drift;
use super::smoothing::polynomial;
use super::{MeasuredError, PreparedRecord};
use crate::diagnostics::{Columns, integral_transform, quantile_pairs};
use crate::{CorrelationShape, FittedCorrelation, FittedProcess, IMPLAUSIBLE_FRICTION, Origin, OriginKind};
use asperity_base::blocks::Task;
use asperity_base::correlation::{
    FamilyFits, LengthFit, Observation, ObservedLengths, RecordCorrelation, RecordHistory, WindowedModel,
};
use asperity_base::distribution::Marginal;
use asperity_base::distribution::fit::{Family, Fit, Ranking, rank_by_aic};
use asperity_base::distribution::goodness::{FitGoodness, ProcessNull};
use asperity_base::monitor::{Monitor, Silent};
use asperity_base::stats::{
    Histogram, Interval, Moments, NORMAL_95, ProcessEstimate, ProcessMoments, StatsError, quantile_sorted,
    sorted_present,
};

/// Least effective sample size of a record.
const LEAST_INDEPENDENT: f64 = 5.0;
/// Degree of a polynomial; if it leaves less than the fraction `SLOW_REST` of the variance, the record is a slow curve.
const SLOW_DEGREE: usize = 3;
const SLOW_REST: f64 = 0.1;
/// Number of simulated records for a p-value, and their seed.
const DRAWS: usize = 499;
const SEED: u64 = 0;
/// Length, as a fraction of a step, that replaces shorter lengths.
const LEAST_LENGTH: f64 = 0.05;
/// Number of correlation lengths below which moments use the intervals of the correlation model where these are wider.
const SHORT: f64 = 100.0;
/// Number of steps of a fit for the progress: correlation, moments, distributions, and quality of their fits.
const STEPS: usize = 4;
/// Number of values of an empirical distribution.
const EMPIRICAL_VALUES: usize = 1001;

/// Choice of the distribution.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub enum DistributionChoice {
    /// The first distribution by Akaike's criterion whose ends the record covers; the candidates include the quantiles
    /// of the record.
    #[default]
    Auto,
    /// One family.
    One(Family),
    /// Quantiles of the record.
    Empirical,
}

impl FromStr for DistributionChoice {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        match text.trim() {
            "auto" => return Ok(Self::Auto),
            "empirical" => return Ok(Self::Empirical),
            "normal" => return Ok(Self::One(Family::Normal)),
            "lognormal" => return Ok(Self::One(Family::ShiftedLognormal)),
            "weibull" => return Ok(Self::One(Family::ShiftedWeibull)),
            "beta" => return Ok(Self::One(Family::BetaFreeBounds)),
            "johnson" => return Ok(Self::One(Family::Johnson)),
            _ => {}
        }
        let bounds = text.trim().strip_prefix("beta:").and_then(|bounds| bounds.split_once(','));
        let number = |text: &str| text.trim().parse::<f64>().ok().filter(|value| value.is_finite());
        match bounds.map(|(low, high)| (number(low), number(high))) {
            Some((Some(low), Some(high))) if low < high => Ok(Self::One(Family::Beta { low, high })),
            _ => Err(format!(
                "`{text}` is not a distribution to fit; write auto, normal, lognormal, weibull, beta, beta:LOW,HIGH, johnson or empirical"
            )),
        }
    }
}

impl fmt::Display for DistributionChoice {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Auto => f.write_str("auto"),
            Self::Empirical => f.write_str("empirical"),
            Self::One(Family::Beta { low, high }) => write!(f, "beta:{low},{high}"),
            Self::One(family) => f.write_str(family.name()),
        }
    }
}

/// Named columns of equal length.
pub type Series = Vec<(String, Vec<f64>)>;

/// Record with its fitted process.
#[derive(Debug, Clone, PartialEq)]
pub struct FittedRecord {
    /// Fitted process.
    pub process: FittedProcess,
    /// Moments of μ with intervals that account for the correlation.
    pub moments: ProcessMoments,
    /// Distributions ranked by Akaike's criterion.
    pub marginals: Ranking,
    /// Quality of fit of the distribution, with p-values that account for the fit and the correlation; none for the
    /// quantiles of the record.
    pub goodness: Option<FitGoodness>,
    /// Autocorrelation up to half the record.
    pub correlation: RecordCorrelation,
    /// Both correlation families, with the noise found beside them, and the one of the process.
    pub families: FamilyFits,
    /// Relation between the values and the process: points or means over the step.
    pub observation: Observation,
    /// Standard deviation of the values, including noise and averaging, which the standard deviation of the process
    /// excludes.
    pub std_measured: f64,
    /// Warnings in words.
    pub warnings: Vec<String>,
}

/// Returns the ranked distributions and the selected one.
fn marginal_of(
    choice: DistributionChoice,
    values: &[f64],
    effective_size: f64,
) -> Result<(Ranking, Marginal), MeasuredError> {
    let families = match choice {
        DistributionChoice::One(family) => vec![family],
        DistributionChoice::Auto | DistributionChoice::Empirical => {
            [&Family::ANYWHERE[..], &Family::EMPIRICAL].concat()
        }
    };
    let ranking = rank_by_aic(&families, values, Some(effective_size));
    let marginal = if choice == DistributionChoice::Empirical {
        let sorted = sorted_present(values.iter().copied());
        let count = sorted.len().min(EMPIRICAL_VALUES);
        let quantiles = (0..count).map(|k| quantile_sorted(&sorted, (k as f64 + 0.5) / count as f64));
        Marginal::empirical(quantiles.collect())?
    } else {
        match (ranking.chosen(), ranking.failed.first()) {
            (Some(fit), _) => fit.marginal.clone(),
            (None, Some((_, error))) => return Err(error.clone().into()),
            (None, None) => return Err(MeasuredError::TooFew { present: 0, what: "are there", wanted: 10 }),
        }
    };
    Ok((ranking, marginal))
}

/// Standard deviation of the process over the one of the values.
struct StdRatio {
    best: f64,
    /// Ratios for the lower and the upper end of the interval.
    ends: [f64; 2],
}

/// Fails if the present values of a record are too few, equal, or a slow curve.
fn check_variation(values: &[f64], present: usize) -> Result<(), MeasuredError> {
    if present < 10 {
        return Err(MeasuredError::TooFew { present, what: "are present", wanted: 10 });
    }
    let std = Moments::new(values).std;
    if std == 0.0 {
        return Err(StatsError::Constant { statistic: "the distribution of friction", n: present }.into());
    }
    // The correlation of a slow curve is meaningless.
    let rest: Vec<f64> = values.iter().zip(polynomial(values, SLOW_DEGREE)).map(|(mu, curve)| mu - curve).collect();
    if Moments::new(&rest).std.powi(2) < SLOW_REST * std.powi(2) {
        let effective = SLOW_DEGREE as f64 + 1.0;
        return Err(MeasuredError::TooShort { present, effective, wanted: LEAST_INDEPENDENT });
    }
    Ok(())
}

/// Returns whether the values are means over a step that does not resolve the correlation.
fn averages_unresolved(fit: &LengthFit, step_m: f64) -> bool {
    fit.window_m > 0.0 && fit.length_m < ObservedLengths::RESOLVED * step_m
}

/// Returns the ratio that excludes noise and the effect of averaging.
///
/// The variance of means over a step tends to zero with ℓ. If the step does not resolve the correlation, the ends
/// include the interval of ℓ; if ℓ may be zero, the ratio excludes noise only.
fn std_ratio(fit: &LengthFit, step_m: f64) -> StdRatio {
    let window = WindowedModel::new(fit.model, fit.window_m).with_cells(fit.cell_m);
    let ratio = |length_m: f64| {
        let left = if length_m > 0.0 { window.covariance(0.0, length_m) } else { 1.0 };
        ((1.0 - fit.noise_fraction) / left).sqrt()
    };
    let Interval { low, high } = fit.interval;
    let (length_m, ends_m) = match averages_unresolved(fit, step_m) {
        true if low == 0.0 => (0.0, [0.0; 2]),
        true => (fit.length_m, [high, low]),
        false => (fit.length_m, [fit.length_m; 2]),
    };
    StdRatio { best: ratio(length_m), ends: ends_m.map(ratio) }
}

/// Returns moments whose intervals account for the fitted correlation if the record is short.
fn moments(pieces: &[&[f64]], step_m: f64, history: RecordHistory, fit: &LengthFit) -> ProcessMoments {
    let moments = ProcessMoments::new(pieces, false);
    let lengths = moments.moments.n as f64 * step_m / fit.model.integral_scale_m(fit.length_m);
    // A filter that removes slow waves changes the correlation.
    if moments.mean.is_some() && lengths > SHORT || history.band.high_pass_m.is_some() || fit.length_m == 0.0 {
        return moments;
    }
    let window = WindowedModel::new(fit.model, fit.window_m).with_cells(fit.cell_m);
    let fraction = 1.0 - fit.noise_fraction;
    let rho = |lag: usize| match lag {
        0 => 1.0,
        _ => fraction * window.correlation(lag as f64 * step_m, fit.length_m),
    };
    let error = (fit.interval.high / fit.interval.low).ln() / (2.0 * NORMAL_95);
    moments.with_correlation(pieces, false, &rho, if error.is_finite() { error } else { 1.0 })
}

impl FittedRecord {
    /// Fits a process to a prepared record; `description` states its source.
    ///
    /// # Errors
    /// Fails if the record has fewer than 10 values or an effective sample size below 5, if the values do not vary, or
    /// if the distribution cannot be fitted.
    pub fn new(
        prepared: &PreparedRecord,
        choice: DistributionChoice,
        description: &str,
    ) -> Result<Self, MeasuredError> {
        Self::monitored(prepared, choice, description, &Silent)
    }

    /// Fits as [`FittedRecord::new`] does and reports the progress, but cannot be cancelled.
    ///
    /// # Errors
    /// See [`FittedRecord::new`].
    pub fn monitored(
        prepared: &PreparedRecord,
        choice: DistributionChoice,
        description: &str,
        monitor: &dyn Monitor,
    ) -> Result<Self, MeasuredError> {
        let task = Task::new(monitor, "steps of the fit", STEPS);
        task.advance(0);
        let record = &prepared.record;
        let values = &record.friction[..];
        let (present, pieces) = (record.present(), record.pieces());
        check_variation(values, present)?;
        let longest = pieces.iter().map(|piece| piece.len()).max().unwrap_or(0);
        let correlation = RecordCorrelation::estimate(&pieces, record.step_m, longest / 2)?;
        let ObservedLengths { families, observation } =
            ObservedLengths::fit(&pieces, record.step_m, prepared.history, monitor)?;
        let best = families.chosen;
        task.advance(1);
        // A slow wave has many values but few correlation lengths.
        let effective = 0.5 * present as f64 * record.step_m / best.model.integral_scale_m(best.length_m);
        if effective < LEAST_INDEPENDENT {
            return Err(MeasuredError::TooShort { present, effective, wanted: LEAST_INDEPENDENT });
        }
        let moments = moments(&pieces, record.step_m, prepared.history, &best);
        task.advance(1);
        let effective_size = moments.effective_size.max(LEAST_INDEPENDENT);
        let (mut marginals, marginal) = marginal_of(choice, values, effective_size)?;
        task.advance(1);
        if let Ok(null) = ProcessNull::new(&pieces, false, DRAWS, SEED) {
            marginals.assess(&null, values);
        }
        task.advance(1);
        let goodness =
            marginals.fits.iter().position(|fit| fit.marginal == marginal).and_then(|place| marginals.distance(place));
        let StdRatio { best: ratio, ends: ratios } = std_ratio(&best, record.step_m);
        let process = FittedProcess {
            mean: moments.moments.mean,
            mean_interval: moments.mean.filter(|_| prepared.history.band.high_pass_m.is_none()).map(pair),
            std: ratio * moments.moments.std,
            std_interval: moments.std.map(pair).map(|ends| [ratios[0] * ends[0], ratios[1] * ends[1]]),
            marginal: Some(marginal),
            correlation: Some(FittedCorrelation {
                shape: CorrelationShape::from_record_model(best.model),
                length_m: best.length_m.max(LEAST_LENGTH * record.step_m),
                length_interval_m: Some([best.interval.low, best.interval.high]),
                window_m: None,
                length_without_window_m: None,
            }),
            generator: None,
            stribeck_s_per_m: None,
            averaged_over_m: None,
            mean_pressure_pa: None,
            origin: Origin { kind: OriginKind::Record, description: description.into() },
        };
        process.check()?;
        let mut fitted = Self {
            process,
            std_measured: moments.moments.std,
            moments,
            marginals,
            goodness,
            correlation,
            families,
            observation,
            warnings: vec![],
        };
        fitted.warnings = fitted.warnings_about(prepared, ratio);
        Ok(fitted)
    }

    /// Returns the warnings about a fit to the record; `ratio` is the standard deviation of the process over that of the values.
    fn warnings_about(&self, prepared: &PreparedRecord, ratio: f64) -> Vec<String> {
        let Self { process, moments, goodness, families, observation, .. } = self;
        let (record, best) = (&prepared.record, families.chosen);
        let values = &record.friction[..];
        let mut warnings = Vec::new();
        let filtered = prepared.history.band.high_pass_m.is_some();
        if (moments.mean.is_none() && !filtered) || moments.std.is_none() {
            warnings.push(
                "the record covers too few correlation lengths for intervals: measure longer, or remove a trend".into(),
            );
        }
        if filtered {
            warnings.push(
                "the mean has no interval, because the removed slow waves determine its variability from record to \
                 record"
                    .into(),
            );
        }
        warnings.extend(drift::warning(values, record.step_m, moments.moments.std));
        warnings.extend(notes_on(families, *observation, moments.moments.std, ratio));
        if best.length_m < ObservedLengths::RESOLVED * record.step_m {
            warnings.push(unresolved(&best, record.step_m));
        }
        if let Some(fit) = goodness.as_ref().filter(|fit| fit.kolmogorov_smirnov.p_value < 0.01) {
            warnings.push(format!(
                "the distribution does not fit: the largest difference of the distribution functions is {:.3} (p = {:.1e}); \
                 another may fit better",
                fit.kolmogorov_smirnov.statistic, fit.kolmogorov_smirnov.p_value
            ));
        }
        if process.mean > IMPLAUSIBLE_FRICTION {
            warnings.push(format!(
                "a mean friction coefficient of {:.3} is implausible: check the units of friction and normal force",
                process.mean
            ));
        }
        let negative = values.iter().filter(|mu| **mu < 0.0).count();
        if negative > 0 {
            warnings.push(format!(
                "{negative} of {} values are negative, but friction is positive: check for an offset",
                record.present()
            ));
        }
        if let Some(large) = prepared.removed.iter().find(|removal| removal.variance_share > 0.5) {
            warnings.push(format!(
                "the {1} removed {0:.0} % of the variance: the result describes the smaller part of the record",
                100.0 * large.variance_share,
                large.step.replace('_', "-")
            ));
        }
        warnings
    }

    /// Returns the tables of the figures: `friction_record`, `friction_histogram`, `friction_pit`, `friction_qq`,
    /// `friction_acf`.
    pub fn tables(&self, prepared: &PreparedRecord) -> Vec<(&'static str, Series)> {
        let mut tables = vec![("friction_record", record_table(prepared))];
        tables.extend(self.histogram(prepared).map(|table| ("friction_histogram", table)));
        if let Some(marginal) = &self.process.marginal {
            let sorted = sorted_present(prepared.record.friction.iter().copied());
            let effective_size = self.moments.effective_size;
            tables.push(("friction_pit", named(integral_transform(marginal, &sorted, effective_size))));
            tables.push(("friction_qq", named(quantile_pairs(marginal, &sorted))));
        }
        tables.push(("friction_acf", self.correlations()));
        tables
    }

    fn histogram(&self, prepared: &PreparedRecord) -> Option<Series> {
        let histogram = Histogram::new(&prepared.record.friction).ok()?;
        let centres = histogram.centres();
        let chosen = self.process.marginal.as_ref();
        let density = |marginal: &Marginal| centres.iter().map(|mu| marginal.pdf(*mu)).collect::<Vec<f64>>();
        let mut columns = vec![("mu".to_owned(), centres.clone()), ("density".into(), histogram.density())];
        // The density of an empirical distribution follows its own noise.
        columns.extend(
            chosen
                .filter(|marginal| !matches!(marginal, Marginal::Empirical { .. }))
                .map(|marginal| ("fitted_density".into(), density(marginal))),
        );
        let smooth = |fit: &&Fit| !matches!(fit.family, Family::Empirical { .. });
        let others = self.marginals.fits.iter().filter(|fit| Some(&fit.marginal) != chosen).filter(smooth);
        columns.extend(others.map(|fit| (format!("{}_density", fit.family.key()), density(&fit.marginal))));
        Some(columns)
    }

    fn correlations(&self) -> Series {
        let step_m = self.correlation.step_m;
        // A family that is significantly worse may fit a scale that is not shown.
        let likely = if self.families.told_apart() { &self.families.fits[..1] } else { &self.families.fits };
        // Beyond ten lengths the estimate is noise.
        let reach = likely.iter().map(|fit| 10.0 * fit.length_m / step_m).fold(20.0, f64::max);
        let lags = self.correlation.correlation.len().min(reach.ceil().min(1e9) as usize);
        let lag_m: Vec<f64> = (0..lags).map(|lag| lag as f64 * step_m).collect();
        let model = |fit: &LengthFit| -> (String, Vec<f64>) {
            let length_m = fit.length_m.max(LEAST_LENGTH * step_m);
            (fit.model.name().into(), lag_m.iter().map(|lag| fit.model.correlation(*lag, length_m)).collect())
        };
        let mut columns =
            vec![("lag_m".to_owned(), lag_m.clone()), ("acf".into(), self.correlation.correlation[..lags].to_vec())];
        columns.extend(likely.iter().map(model));
        columns
    }
}

/// Returns notes on the fit of the correlation.
fn notes_on(families: &FamilyFits, observation: Observation, std: f64, ratio: f64) -> Vec<String> {
    let fit = &families.chosen;
    let mut notes = Vec::new();
    if !families.told_apart() {
        notes.push(format!(
            "the record cannot tell the correlation families apart: the process uses the {}, and the interval of the \
             correlation length covers both",
            fit.model.name()
        ));
    }
    if let Some(interval) = fit.noise_interval.filter(|_| fit.noise_fraction > 0.0) {
        notes.push(format!(
            "white noise is {:.2} % ({:.2} to {:.2} %) of the variance; the correlation length excludes it",
            100.0 * fit.noise_fraction,
            100.0 * interval.low,
            100.0 * interval.high
        ));
    }
    if observation == Observation::Means {
        notes.push(
            "the spectrum is consistent with means over the step, not with values at points; the correlation length excludes \
             this averaging"
                .into(),
        );
    }
    if (ratio - 1.0).abs() > 0.005 {
        notes.push(format!(
            "the standard deviation of the values is {std:.4e}; without noise and averaging, the process has {:.4e}",
            ratio * std
        ));
    }
    if let Some(test) = fit.lack_of_fit.filter(|test| test.significant()) {
        notes.push(format!(
            "the correlation family {} does not fit the record (p = {:.1e} for its spectrum): the correlation length and its \
             interval hold for this family alone; compare friction_acf. If the instrument filters fast waves, remove them \
             with a low-pass filter",
            fit.model.name(),
            test.p_value
        ));
    }
    notes
}

/// Returns the warning that the step does not resolve the correlation.
fn unresolved(fit: &LengthFit, step_m: f64) -> String {
    let metre = |value: f64| if value == 0.0 { "0".to_owned() } else { format!("{value:.3e}") };
    let Interval { low, high } = fit.interval;
    let start = format!(
        "the correlation length of {} m (95 %: {} to {} m) is not much longer than the step of {step_m:.3e} m: ",
        metre(fit.length_m),
        metre(low),
        metre(high)
    );
    let rest = if averages_unresolved(fit, step_m) && low == 0.0 {
        "the effect of the averaging is unknown, and the standard deviation is the one of the averages; sample more finely, or average \
         fewer values"
    } else if fit.window_m == 0.0 && fit.noise_fraction == 0.0 {
        "the spectrum hardly distinguishes values at points from means over the step, or the process from white noise; the \
         values are taken as values at points without noise, and the standard deviation is the one of the recorded values; \
         sample more finely"
    } else {
        "with finer sampling it may be shorter"
    };
    start + rest
}

fn pair(estimate: ProcessEstimate) -> [f64; 2] {
    [estimate.interval.low, estimate.interval.high]
}

fn named(columns: Columns) -> Series {
    columns.into_iter().map(|(name, values)| (name.to_owned(), values)).collect()
}

fn record_table(prepared: &PreparedRecord) -> Series {
    let record = &prepared.record;
    vec![
        ("position_m".into(), (0..record.friction.len()).map(|index| record.position_m(index)).collect()),
        ("measured".into(), prepared.measured.clone()),
        ("trend".into(), prepared.trend.clone()),
        ("mu".into(), record.friction.clone()),
    ]
}
