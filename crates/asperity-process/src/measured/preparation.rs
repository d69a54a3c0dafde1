//! Preparation of a record before its analysis: cut, trend, noise.

use std::fmt;
use std::str::FromStr;

use super::record::check_scales;
use super::smoothing::{gaussian, polynomial};
use super::{MeasuredError, MeasuredRecord};
use asperity_base::correlation::{RecordBand, RecordHistory};
use asperity_base::quantity::Length;
use asperity_base::stats::Moments;

/// Highest degree of a trend; a higher degree would act as a filter.
const HIGHEST_DEGREE: usize = 30;

/// Steps of the preparation, in this order.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct RecordPreparation {
    /// Part of the record that is kept.
    pub cut: Option<Cut>,
    /// Trend that is removed; the mean is kept.
    pub detrend: Detrend,
    /// Cutoff length in metre of a Gaussian filter that removes faster waves.
    pub low_pass_m: Option<f64>,
    /// Number of values that are replaced by their mean.
    pub decimation: usize,
}

/// Part of a record, in the coordinates of the file.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Cut {
    /// From one distance to another, in metre.
    Distance(f64, f64),
    /// From one time to another, in second.
    Time(f64, f64),
}

/// Trend of a record.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub enum Detrend {
    /// No trend; the same as `mean`, because the mean is kept.
    #[default]
    None,
    /// Least-squares polynomial of this degree; 0 is the mean, 1 the line.
    Polynomial(usize),
    /// Gaussian mean line with this cutoff length in metre, after a least-squares line.
    HighPass {
        /// Cutoff length in metre; waves of that length are halved.
        cutoff_m: f64,
    },
}

impl FromStr for Detrend {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let (name, value) = text.split_once(':').map_or((text, None), |(name, value)| (name, Some(value)));
        let degree = |value: &str| value.trim().parse::<usize>().ok().filter(|degree| *degree <= HIGHEST_DEGREE);
        match (name.trim(), value) {
            ("none", None) => Ok(Self::None),
            ("mean", None) => Ok(Self::Polynomial(0)),
            ("linear", None) => Ok(Self::Polynomial(1)),
            ("polynomial", Some(value)) => {
                let wanted = || format!("a degree is a whole number from 0 to {HIGHEST_DEGREE}, not `{value}`");
                Ok(Self::Polynomial(degree(value).ok_or_else(wanted)?))
            }
            ("high_pass", Some(value)) => {
                let cutoff: Length = value.parse().map_err(|error| format!("{error}"))?;
                if cutoff.0 > 0.0 {
                    Ok(Self::HighPass { cutoff_m: cutoff.0 })
                } else {
                    Err("a cutoff is positive".into())
                }
            }
            _ => Err(format!(
                "`{text}` is not a trend; write none, mean, linear, polynomial:DEGREE or high_pass:LENGTH, such as \
                 high_pass:5mm"
            )),
        }
    }
}

impl fmt::Display for Detrend {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::None => f.write_str("none"),
            Self::Polynomial(0) => f.write_str("mean"),
            Self::Polynomial(1) => f.write_str("linear"),
            Self::Polynomial(degree) => write!(f, "polynomial:{degree}"),
            Self::HighPass { cutoff_m } => write!(f, "high_pass:{}", Length(*cutoff_m)),
        }
    }
}

/// Effect of one step of the preparation.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Removal {
    /// Name of the step: `trend`, `low_pass` or `decimation`.
    pub step: &'static str,
    /// Removed fraction of the variance before the step.
    pub variance_share: f64,
}

/// Record that is ready for analysis.
#[derive(Debug, Clone, PartialEq)]
pub struct PreparedRecord {
    /// The record; its warnings include those of the preparation.
    pub record: MeasuredRecord,
    /// Measured values of the kept part before the other steps, at the same positions.
    pub measured: Vec<f64>,
    /// Trend including the mean, at the same positions.
    pub trend: Vec<f64>,
    /// Effect of each step.
    pub removed: Vec<Removal>,
    /// Band of the correlation that remains visible.
    pub history: RecordHistory,
}

impl RecordPreparation {
    /// Prepares a record.
    ///
    /// # Errors
    /// Fails if a cut leaves fewer than 10 values or is a cut of time without a velocity, if a degree exceeds 30, or if
    /// a cutoff or a decimation does not fit the record.
    pub fn apply(&self, record: &MeasuredRecord) -> Result<PreparedRecord, MeasuredError> {
        check_scales(record.step_m, &record.friction)?;
        let mut record = self.cut(record)?;
        let (step_m, length_m) = (record.step_m, record.step_m * record.friction.len() as f64);
        let fits = |option, cutoff_m: f64| {
            if cutoff_m > 2.0 * step_m && cutoff_m < length_m {
                Ok(cutoff_m / step_m)
            } else {
                let wanted = "longer than two steps and shorter than the record, in metre";
                Err(MeasuredError::Option { option, value: cutoff_m, wanted })
            }
        };
        let measured = record.friction.clone();
        let mut removed = Vec::new();
        let mut taken = |step, before: &[f64], after: &[f64]| {
            let [before, after] = [before, after].map(|values| Moments::new(values).std.powi(2));
            let variance_share = if before > 0.0 { 1.0 - after / before } else { 0.0 };
            removed.push(Removal { step, variance_share });
        };
        let mean = Moments::new(&measured).mean;
        let trend = match self.detrend {
            Detrend::None => vec![mean; measured.len()],
            Detrend::Polynomial(degree) if degree <= HIGHEST_DEGREE => polynomial(&measured, degree),
            Detrend::Polynomial(degree) => {
                let (option, wanted) = ("degree of the trend", "at most 30");
                return Err(MeasuredError::Option { option, value: degree as f64, wanted });
            }
            Detrend::HighPass { cutoff_m } => {
                let cutoff = fits("cutoff of the trend", cutoff_m)?;
                let line = polynomial(&measured, 1);
                let rest: Vec<f64> = measured.iter().zip(&line).map(|(mu, line)| mu - line).collect();
                gaussian(&rest, cutoff).into_iter().zip(line).map(|(rest, line)| rest + line).collect()
            }
        };
        if !matches!(self.detrend, Detrend::None | Detrend::Polynomial(0)) {
            let rest: Vec<f64> = measured.iter().zip(&trend).map(|(mu, trend)| mu - trend).collect();
            // A filter removes a small part of the mean; the mean of the record is restored exactly.
            let shift = mean - Moments::new(&rest).mean;
            record.friction = rest.into_iter().map(|mu| mu + shift).collect();
            taken("trend", &measured, &record.friction);
        }
        if let Some(cutoff_m) = self.low_pass_m {
            let smooth = gaussian(&record.friction, fits("cutoff of the low-pass filter", cutoff_m)?);
            // Missing values remain missing.
            let kept =
                record.friction.iter().zip(&smooth).map(|(mu, smooth)| if mu.is_nan() { f64::NAN } else { *smooth });
            let kept: Vec<f64> = kept.collect();
            taken("low_pass", &record.friction, &kept);
            record.friction = kept;
        }
        let degree = if let Detrend::Polynomial(degree) = self.detrend { degree } else { 0 };
        let band = RecordBand {
            // A polynomial removes half a wave along the record for every degree.
            lowest_per_m: if degree > 0 { (0.5 * degree as f64 + 1.0) / length_m } else { 0.0 },
            high_pass_m: if let Detrend::HighPass { cutoff_m } = self.detrend { Some(cutoff_m) } else { None },
            low_pass_m: self.low_pass_m,
            highest_per_m: None,
        };
        let history = RecordHistory { decimation: self.decimation.max(1), band };
        let mut prepared = PreparedRecord { record, measured, trend, removed: Vec::new(), history };
        if self.decimation > 1 {
            let before = prepared.record.friction.clone();
            prepared.decimate(self.decimation)?;
            taken("decimation", &before, &prepared.record.friction);
        }
        prepared.removed = removed;
        Ok(prepared)
    }

    fn cut(&self, record: &MeasuredRecord) -> Result<MeasuredRecord, MeasuredError> {
        let Some(cut) = self.cut else { return Ok(record.clone()) };
        let (from_m, to_m) = match cut {
            Cut::Distance(from, to) => (from, to),
            Cut::Time(from, to) => {
                let velocity = record.velocity_m_per_s.ok_or(MeasuredError::CutOfTime)?;
                (from * velocity, to * velocity)
            }
        };
        if !(from_m < to_m && from_m.is_finite() && to_m.is_finite()) {
            let (option, wanted) = ("end of the cut", "after its start");
            return Err(MeasuredError::Option { option, value: to_m, wanted });
        }
        let index = |position_m: f64| (position_m - record.start_m) / record.step_m;
        // Tolerance for rounding: a value at an end of the cut is inside.
        let first = (index(from_m) - 1e-6).ceil().max(0.0) as usize;
        let end = ((index(to_m) + 1e-6).floor() + 1.0).clamp(0.0, record.friction.len() as f64) as usize;
        let kept = record.friction.get(first..end).unwrap_or(&[]).to_vec();
        let part = MeasuredRecord { start_m: record.position_m(first), friction: kept, ..record.clone() };
        match part.present() {
            present if present < 10 => Err(MeasuredError::TooFew { present, what: "lie in the cut", wanted: 10 }),
            _ => Ok(part),
        }
    }
}

impl PreparedRecord {
    /// Replaces every `count` values by the mean of the present ones; the result is a gap if fewer than half are
    /// present.
    fn decimate(&mut self, count: usize) -> Result<(), MeasuredError> {
        if count * 10 > self.record.friction.len() {
            let (option, wanted) = ("decimation", "at most a tenth of the values");
            return Err(MeasuredError::Option { option, value: count as f64, wanted });
        }
        let blocks = |values: &[f64]| -> Vec<f64> {
            let mean = |block: &[f64]| {
                let (sum, present) = super::sampling::sum(block);
                if 2 * present >= count { sum / present as f64 } else { f64::NAN }
            };
            values.chunks_exact(count).map(mean).collect()
        };
        // The position of the mean is the centre of its values.
        self.record.start_m += 0.5 * (count - 1) as f64 * self.record.step_m;
        self.record.step_m *= count as f64;
        self.record.friction = blocks(&self.record.friction);
        self.measured = blocks(&self.measured);
        self.trend = blocks(&self.trend);
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn record(friction: Vec<f64>) -> MeasuredRecord {
        MeasuredRecord {
            start_m: 0.01,
            step_m: 1e-4,
            friction,
            velocity_m_per_s: Some(0.1),
            strokes_m: vec![],
            warnings: vec![],
        }
    }

    fn waves(n: usize) -> Vec<f64> {
        (0..n).map(|i| 0.2 + 0.01 * (0.5 * i as f64).sin() + 3e-5 * i as f64).collect()
    }

    #[test]
    fn a_removed_line_keeps_the_mean_and_reports_its_fraction() {
        let values = waves(2001);
        let before = Moments::new(&values);
        let prepared = RecordPreparation { detrend: Detrend::Polynomial(1), ..RecordPreparation::default() };
        let prepared = prepared.apply(&record(values)).unwrap();
        let after = Moments::new(&prepared.record.friction);
        assert!((after.mean - before.mean).abs() < 1e-12);
        // The line has the variance (3e-5)²(n² − 1)/12, the wave 1e-4/2.
        let line = 9e-10 * (2001.0_f64.powi(2) - 1.0) / 12.0;
        assert!((prepared.removed[0].variance_share - line / (line + 5e-5)).abs() < 1e-3, "{:?}", prepared.removed);
        assert!((after.std - 5e-5_f64.sqrt()).abs() < 1e-4);
    }

    #[test]
    fn filters_pass_their_band() {
        // Waves of 4π = 12.6 steps, 1.26 mm.
        let of = |preparation: RecordPreparation| {
            let prepared = preparation.apply(&record(waves(4000))).unwrap();
            Moments::new(&prepared.record.friction[500..3500]).std / 5e-5_f64.sqrt()
        };
        let high = |cutoff_m| {
            of(RecordPreparation { detrend: Detrend::HighPass { cutoff_m }, ..RecordPreparation::default() })
        };
        assert!((high(20e-3) - 1.0).abs() < 0.01, "{}", high(20e-3));
        // 1 − ½ at the cutoff.
        assert!((high(4e-4 * std::f64::consts::PI) - 0.5).abs() < 0.01);
        let line = Detrend::Polynomial(1);
        let low = of(RecordPreparation {
            detrend: line,
            low_pass_m: Some(4e-4 * std::f64::consts::PI),
            ..RecordPreparation::default()
        });
        assert!((low - 0.5).abs() < 0.01, "{low}");
    }

    #[test]
    fn cuts_use_the_coordinates_of_the_file() {
        let values: Vec<f64> = (0..1000).map(f64::from).collect();
        let cut =
            |cut| RecordPreparation { cut: Some(cut), ..RecordPreparation::default() }.apply(&record(values.clone()));
        let part = cut(Cut::Distance(0.011, 0.021)).unwrap().record;
        assert_eq!((part.friction[0], part.friction.len()), (10.0, 101));
        assert_eq!(cut(Cut::Time(0.11, 0.21)).unwrap().record, part);
        assert!((part.start_m - 0.011).abs() < 1e-12);
        assert!(cut(Cut::Distance(0.0, 0.0105)).is_err_and(|error| error.is_too_few()));
        assert!(cut(Cut::Distance(0.02, 0.01)).is_err_and(|error| error.is_request()));
        let by_distance = MeasuredRecord { velocity_m_per_s: None, ..record(values.clone()) };
        let times = RecordPreparation { cut: Some(Cut::Time(0.11, 0.21)), ..RecordPreparation::default() };
        let error = times.apply(&by_distance).unwrap_err();
        assert!(error.is_request() && error.to_string().contains("the record is over the sliding distance"), "{error}");
    }

    #[test]
    fn decimation_averages_and_keeps_gaps_and_positions() {
        let mut values: Vec<f64> = (0..1003).map(f64::from).collect();
        values[10..13].fill(f64::NAN);
        values[25] = f64::NAN;
        let prepared =
            RecordPreparation { decimation: 5, ..RecordPreparation::default() }.apply(&record(values)).unwrap().record;
        assert_eq!(prepared.friction.len(), 200);
        assert!(prepared.friction[2].is_nan() && prepared.friction[5] == 27.5 && prepared.friction[0] == 2.0);
        assert!((prepared.start_m - 0.0102).abs() < 1e-12 && (prepared.step_m - 5e-4).abs() < 1e-15);
        assert!(
            RecordPreparation { decimation: 500, ..RecordPreparation::default() }
                .apply(&record(vec![0.1; 1000]))
                .is_err()
        );
    }

    #[test]
    fn trends_parse_their_own_text() {
        for text in ["none", "mean", "linear", "polynomial:3", "high_pass:5 mm"] {
            assert_eq!(text.parse::<Detrend>().unwrap().to_string(), text);
        }
        for text in ["", "quadratic", "polynomial", "polynomial:31", "high_pass:5", "high_pass:-1mm", "linear:2"] {
            assert!(text.parse::<Detrend>().is_err(), "{text}");
        }
    }
}
