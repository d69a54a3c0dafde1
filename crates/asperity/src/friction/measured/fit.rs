//! A prepared record as a process: its moments, its law, its correlation, and tables that show how well they fit.

use std::fmt;
use std::str::FromStr;

use super::{MeasuredError, Prepared};
use crate::correlation::{LagNormalisation, RecordCorrelation, RecordFit, RecordModel, fit_record};
use crate::friction::process::{CorrelationShape, FittedCorrelation, FittedProcess, Origin, OriginKind};
use crate::law::Marginal;
use crate::law::fit::{End, Family, Fit, FitGoodness, Ranking, rank_by_aic};
use crate::stats::{Histogram, Moments, correlation_time, quantile_sorted, sorted_present, student_quantile};

/// Least number of independent values that a record must be worth.
const LEAST_INDEPENDENT: f64 = 5.0;
/// Most parts of the jackknife of the correlation length, and the least length of one in correlation lengths.
const MOST_PARTS: usize = 20;
const LENGTHS_PER_PART: f64 = 10.0;
/// Values that an empirical law keeps.
const EMPIRICAL_VALUES: usize = 1001;
/// Bins of the probability integral transform, and pairs of the quantile plot.
const BINS: usize = 20;
const PAIRS: usize = 400;

/// Which law is taken.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub enum LawChoice {
    /// The first by Akaike's criterion whose ends the record sees.
    #[default]
    Auto,
    /// One family.
    One(Family),
    /// The record's own quantiles.
    Empirical,
}

impl FromStr for LawChoice {
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
                "`{text}` is no law to fit; write auto, normal, lognormal, weibull, beta, beta:LOW,HIGH, johnson or empirical"
            )),
        }
    }
}

impl fmt::Display for LawChoice {
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

/// A record with the process fitted to it.
#[derive(Debug, Clone, PartialEq)]
pub struct FittedRecord {
    /// The process.
    pub process: FittedProcess,
    /// Moments of μ.
    pub moments: Moments,
    /// Independent values that the correlated ones are worth for their mean.
    pub effective_size: f64,
    /// Laws by Akaike's criterion.
    pub laws: Ranking,
    /// How well the law of the process fits; none for the record's own quantiles.
    pub goodness: Option<FitGoodness>,
    /// Autocorrelation up to half the record.
    pub correlation: RecordCorrelation,
    /// Its models, the closest first.
    pub models: Vec<RecordFit>,
    /// What to be wary of, in words.
    pub warnings: Vec<String>,
}

/// Everything that is read off the values alone.
struct Statistics {
    moments: Moments,
    effective_size: f64,
    mean_interval: [f64; 2],
    std_interval: [f64; 2],
    resolved: bool,
}

/// Moments with intervals that count the correlation.
///
/// The mean of n values has the variance σ²τ/n with their correlation time τ, and so has the mean of the squared deviations
/// with its own; the standard deviation follows from that of the variance, which it is the root of.
fn statistics(values: &[f64]) -> Result<Statistics, MeasuredError> {
    let moments = Moments::of(values);
    let time = correlation_time(values)?;
    let effective_size = time.effective_size();
    if effective_size < LEAST_INDEPENDENT {
        let (present, effective) = (moments.n, effective_size);
        return Err(MeasuredError::TooShort { present, effective, wanted: LEAST_INDEPENDENT });
    }
    let squares: Vec<f64> = values.iter().map(|mu| (mu - moments.mean).powi(2)).collect();
    // Squares that are all equal, as of a square wave, know their mean exactly.
    let (square_error, square_size) = correlation_time(&squares).map_or((0.0, effective_size), |time| {
        (Moments::of(&squares).std / time.effective_size().sqrt(), time.effective_size())
    });
    let around = |value: f64, error: f64, size: f64| {
        let reach = student_quantile(0.975, (size - 1.0).max(1.0)) * error;
        [value - reach, value + reach]
    };
    let mean_interval = around(moments.mean, moments.std / effective_size.sqrt(), effective_size);
    let [low, high] = around(moments.std, 0.5 * square_error / moments.std, square_size);
    Ok(Statistics {
        moments,
        effective_size,
        mean_interval,
        std_interval: [low.max(0.0), high],
        resolved: time.resolved,
    })
}

/// The laws tried, and the one to go on with.
fn law(choice: LawChoice, values: &[f64], effective_size: f64) -> Result<(Ranking, Marginal), MeasuredError> {
    let families = match choice {
        LawChoice::One(family) => vec![family],
        LawChoice::Auto | LawChoice::Empirical => Family::ANYWHERE.to_vec(),
    };
    let ranking = rank_by_aic(&families, values, Some(effective_size));
    let law = if choice == LawChoice::Empirical {
        let sorted = sorted_present(values.iter().copied());
        let count = sorted.len().min(EMPIRICAL_VALUES);
        let quantiles = (0..count).map(|k| quantile_sorted(&sorted, (k as f64 + 0.5) / count as f64));
        Marginal::empirical(quantiles.collect())?
    } else {
        // A fitted end far outside the record makes a law of four parameters that is hardly different from a simpler one.
        let seen = |fit: &&Fit| fit.low_end != End::OutOfSight && fit.high_end != End::OutOfSight;
        let chosen = ranking.fits.iter().find(seen).or(ranking.fits.first());
        match (chosen, ranking.failed.first()) {
            (Some(fit), _) => fit.law.clone(),
            (None, Some((_, error))) => return Err(error.clone().into()),
            (None, None) => return Err(MeasuredError::TooFew { present: 0, what: "are there", wanted: 10 }),
        }
    };
    Ok((ranking, law))
}

/// Correlation up to half the record, and its models, the closest first.
fn correlate(values: &[f64], step_m: f64) -> Result<(RecordCorrelation, Vec<RecordFit>), MeasuredError> {
    let found = RecordCorrelation::estimate(&[values], step_m, values.len() / 2, LagNormalisation::PairNormalised)?;
    let models = [RecordModel::Exponential, RecordModel::SquaredExponential];
    let mut fits = models.iter().map(|model| fit_record(&found, *model)).collect::<Result<Vec<_>, _>>()?;
    fits.sort_by(|a, b| a.misfit.total_cmp(&b.misfit));
    Ok((found, fits))
}

/// 95 % interval of the length of a model, by the jackknife over parts of the record; none where it is too short.
fn length_interval(values: &[f64], step_m: f64, fit: &RecordFit) -> Option<[f64; 2]> {
    let lengths = values.len() as f64 * step_m / fit.length_m;
    let parts = ((lengths / LENGTHS_PER_PART) as usize).min(MOST_PARTS);
    if parts < 4 {
        return None;
    }
    let without = |part: usize| {
        let mut left = values.to_vec();
        let end = |part: usize| part * values.len() / parts;
        left[end(part)..end(part + 1)].fill(f64::NAN);
        let lags = values.len() / 2;
        let found = RecordCorrelation::estimate(&[&left], step_m, lags, LagNormalisation::PairNormalised).ok()?;
        fit_record(&found, fit.model).ok().map(|fit| fit.length_m)
    };
    let lengths: Vec<f64> = (0..parts).map(without).collect::<Option<_>>()?;
    let freedom = (parts - 1) as f64;
    let reach = student_quantile(0.975, freedom) * Moments::of(&lengths).std * freedom.sqrt();
    Some([(fit.length_m - reach).max(0.0), fit.length_m + reach])
}

impl FittedRecord {
    /// Fits a process to a prepared record; `description` says where it comes from.
    ///
    /// # Errors
    /// Fewer than 10 values, or so few correlation lengths that they are worth fewer than 5; values that do not vary; a law
    /// that cannot be fitted.
    pub fn of(prepared: &Prepared, choice: LawChoice, description: &str) -> Result<Self, MeasuredError> {
        let record = &prepared.record;
        let values = &record.friction[..];
        let present = record.present();
        if present < 10 {
            return Err(MeasuredError::TooFew { present, what: "are present", wanted: 10 });
        }
        let Statistics { moments, effective_size, mean_interval, std_interval, resolved } = statistics(values)?;
        let (laws, marginal) = law(choice, values, effective_size)?;
        let goodness = laws.fits.iter().position(|fit| fit.law == marginal).map(|place| laws.goodness[place]);
        let (correlation, models) = correlate(values, record.step_m)?;
        let Some(best) = models.first() else {
            return Err(MeasuredError::TooFew { present, what: "are present", wanted: 10 });
        };
        // A slow wave looks like many values; it is few lengths all the same.
        let independent = 0.5 * present as f64 * record.step_m / best.length_m;
        if independent < LEAST_INDEPENDENT {
            return Err(MeasuredError::TooShort { present, effective: independent, wanted: LEAST_INDEPENDENT });
        }
        let (shape, length_m) = CorrelationShape::of(best.model, best.length_m);
        let process = FittedProcess {
            mean: moments.mean,
            mean_interval: Some(mean_interval),
            std: moments.std,
            std_interval: Some(std_interval),
            marginal: Some(marginal),
            correlation: Some(FittedCorrelation {
                shape,
                length_m,
                length_interval_m: length_interval(values, record.step_m, best),
                window_m: None,
                length_without_window_m: None,
            }),
            stribeck_s_per_m: None,
            averaged_over_m: None,
            mean_pressure_pa: None,
            origin: Origin { kind: OriginKind::Record, description: description.into() },
        };
        process.check()?;
        let mut warnings = Vec::new();
        if !resolved {
            warnings.push(
                "the record holds few correlation times, so that intervals are uncertain themselves: measure longer, or take a \
                 trend out"
                    .into(),
            );
        }
        if best.length_m < 2.0 * record.step_m {
            warnings.push(format!(
                "the correlation length of {:.3e} m is hardly longer than the step of {:.3e} m: sampled more finely, it may be \
                 shorter",
                best.length_m, record.step_m
            ));
        }
        if let Some(fit) = goodness.filter(|fit| fit.kolmogorov_smirnov.p_value < 0.01) {
            warnings.push(format!(
                "the law does not fit: its distribution function is off by {:.3}, which chance would do with probability {:.1e}; \
                 another may fit better",
                fit.kolmogorov_smirnov.statistic, fit.kolmogorov_smirnov.p_value
            ));
        }
        if let Some(large) = prepared.removed.iter().find(|removal| removal.variance_share > 0.5) {
            warnings.push(format!(
                "{:.0} % of the variance went with the {}: what is left is the smaller part of the record",
                100.0 * large.variance_share,
                large.step.replace('_', "-")
            ));
        }
        Ok(Self { process, moments, effective_size, laws, goodness, correlation, models, warnings })
    }

    /// What the figures show: `friction_record`, `friction_histogram`, `friction_pit`, `friction_qq`, `friction_acf`.
    pub fn tables(&self, prepared: &Prepared) -> Vec<(&'static str, Series)> {
        let mut tables = vec![("friction_record", record_table(prepared))];
        tables.extend(self.histogram(prepared).map(|table| ("friction_histogram", table)));
        if let Some(law) = &self.process.marginal {
            let sorted = sorted_present(prepared.record.friction.iter().copied());
            tables.push(("friction_pit", integral_transform(law, &sorted, self.effective_size)));
            tables.push(("friction_qq", quantiles(law, &sorted)));
        }
        tables.push(("friction_acf", self.correlations()));
        tables
    }

    fn histogram(&self, prepared: &Prepared) -> Option<Series> {
        let histogram = Histogram::of(&prepared.record.friction).ok()?;
        let centres = histogram.centres();
        let chosen = self.process.marginal.as_ref();
        let density = |law: &Marginal| centres.iter().map(|mu| law.pdf(*mu)).collect::<Vec<f64>>();
        let mut columns = vec![("mu".to_owned(), centres.clone()), ("density".into(), histogram.density())];
        // Densities of a measured law are steps of its own noise.
        columns.extend(
            chosen
                .filter(|law| !matches!(law, Marginal::Empirical { .. }))
                .map(|law| ("fitted_density".into(), density(law))),
        );
        let others = self.laws.fits.iter().filter(|fit| Some(&fit.law) != chosen);
        columns.extend(others.map(|fit| (format!("{}_density", fit.family.name()), density(&fit.law))));
        Some(columns)
    }

    fn correlations(&self) -> Series {
        let step_m = self.correlation.step_m;
        // What follows ten lengths is the noise of the estimate.
        let reach = self.models.iter().map(|fit| 10.0 * fit.length_m / step_m).fold(20.0, f64::max);
        let lags = self.correlation.correlation.len().min(reach.ceil().min(1e9) as usize);
        let lag_m: Vec<f64> = (0..lags).map(|lag| lag as f64 * step_m).collect();
        let model = |fit: &RecordFit| -> (String, Vec<f64>) {
            let values = lag_m.iter().map(|lag| fit.model.correlation(*lag, fit.length_m)).collect();
            (fit.model.name().into(), values)
        };
        let mut columns =
            vec![("lag_m".to_owned(), lag_m.clone()), ("acf".into(), self.correlation.correlation[..lags].to_vec())];
        columns.extend(self.models.iter().map(model));
        columns
    }
}

fn record_table(prepared: &Prepared) -> Series {
    let record = &prepared.record;
    vec![
        ("position_m".into(), (0..record.friction.len()).map(|index| record.position_m(index)).collect()),
        ("measured".into(), prepared.measured.clone()),
        ("trend".into(), prepared.trend.clone()),
        ("mu".into(), record.friction.clone()),
    ]
}

/// Histogram of F(μ), 1 everywhere if the law fits, with the band that 95 % of the bins lie in for as many independent
/// values as the record is worth.
fn integral_transform(law: &Marginal, sorted: &[f64], effective_size: f64) -> Series {
    let mut density = vec![0.0; BINS];
    for mu in sorted {
        let bin = (law.cdf(*mu) * BINS as f64) as usize;
        density[bin.min(BINS - 1)] += BINS as f64 / sorted.len() as f64;
    }
    let share = 1.0 / BINS as f64;
    let reach = crate::stats::NORMAL_95 * (share * (1.0 - share) / effective_size).sqrt() * BINS as f64;
    vec![
        ("probability".into(), (0..BINS).map(|bin| (bin as f64 + 0.5) * share).collect()),
        ("density".into(), density),
        ("low".into(), vec![(1.0 - reach).max(0.0); BINS]),
        ("high".into(), vec![1.0 + reach; BINS]),
    ]
}

/// Quantiles of the record over those of the law at the same probabilities.
fn quantiles(law: &Marginal, sorted: &[f64]) -> Series {
    let count = sorted.len().min(PAIRS);
    let probability: Vec<f64> = (0..count).map(|k| (k as f64 + 0.5) / count as f64).collect();
    vec![
        ("fitted".into(), probability.iter().map(|p| law.quantile(*p)).collect()),
        ("measured".into(), probability.iter().map(|p| quantile_sorted(sorted, *p)).collect()),
        ("probability".into(), probability),
    ]
}
