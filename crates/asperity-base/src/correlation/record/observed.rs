//! Correlation of a record with an unknown observation process.

use super::RecordCorrelation;
use super::band::RecordBand;
use super::families::FamilyFits;
use super::length::{LengthFit, LengthSettings, fit_length, most_likely};
use super::likelihood::{RecordEnds, WindowedRecords};
use super::model::RecordModel;
use super::spectrum::record_spectrum;
use crate::blocks::Task;
use crate::correlation::estimate::EstimateError;
use crate::monitor::Monitor;

/// Required gain of 2 ln L for noise and for means over the step, each, if the step resolves the correlation, and
/// otherwise. Of 950 white records none gained more than 10.
const GAIN: f64 = 4.0;
const UNRESOLVED_GAIN: f64 = 12.0;
/// Power density relative to its maximum below which waves are not used.
const LEAST_POWER: f64 = 1e-4;
/// Number of values above which records are divided into segments.
const LONG: usize = 1 << 15;
/// Least length of a segment: absolute, in correlation lengths, and in cutoffs of a high-pass filter.
const LEAST_SEGMENT: usize = 1 << 14;
const LEAST_LENGTHS: f64 = 32.0;
const LEAST_CUTOFFS: f64 = 8.0;

/// Observation model: how the values of a record derive from the process.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Observation {
    /// Values of the process at points.
    Points,
    /// Means over the step, as of an integrating converter.
    Means,
}

impl Observation {
    /// Returns the name as in files.
    pub fn name(self) -> &'static str {
        match self {
            Self::Points => "points",
            Self::Means => "means_over_step",
        }
    }
}

/// Known properties of the measurement of a record.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct RecordHistory {
    /// Number of instrument values averaged in each value; 1 for none.
    pub decimation: usize,
    /// Effect of trends and filters on the frequencies.
    pub band: RecordBand,
}

impl Default for RecordHistory {
    /// Returns unprocessed values.
    fn default() -> Self {
        Self { decimation: 1, band: RecordBand::default() }
    }
}

/// Correlation of a record, estimated together with its observation model.
#[derive(Debug, Clone, PartialEq)]
pub struct ObservedLengths {
    /// Both families, each with an observation model. Their ln L is the largest of all observation models, because a
    /// family with the wrong one may be less likely than the other family.
    pub families: FamilyFits,
    /// Observation model of the chosen family.
    pub observation: Observation,
}

impl ObservedLengths {
    /// Correlation length in steps below which the step does not resolve the correlation.
    pub const RESOLVED: f64 = 2.0;

    /// Fits both families to records of one process with equal steps, NaN being a missing value. The observation models
    /// are values at points and means over the step, with and without white noise.
    ///
    /// All candidates are compared on the same wavenumbers, up to the last with a power density of at least 1e-4 of its
    /// maximum. Shorter waves of a smooth record are leakage, or noise too weak to matter.
    ///
    /// Noise, and means over the step, must each gain 4 in 2 ln L. If the exponential of values at points is shorter
    /// than two steps, the spectrum is nearly flat and hardly distinguishes them, so they must gain 12. If the step
    /// resolves the correlation, the interval of the length covers the intervals of all models within 4 of the best one.
    ///
    /// More than 32,768 values are divided into segments of at least 32 correlation lengths, whose waves are used.
    ///
    /// # Errors
    /// See [`super::fit_length`].
    pub fn fit(
        records: &[&[f64]],
        step_m: f64,
        history: RecordHistory,
        monitor: &dyn Monitor,
    ) -> Result<Self, EstimateError> {
        let records = segments(records, step_m, history.band)?;
        let highest_per_m = highest_per_m(&records, step_m, history.band)?;
        let band = RecordBand { highest_per_m: Some(highest_per_m), ..history.band };
        let candidates = Candidates { records, step_m, decimation: history.decimation, band };
        let points = candidates.channel(Observation::Points);
        let rough = RecordModel::Exponential;
        let resolved = most_likely(&points, rough, candidates.settings(false))
            .is_some_and(|(length_m, _)| length_m >= Self::RESOLVED * step_m);
        let task = Task::new(monitor, "correlation fits", RecordModel::BOTH.len());
        let fit = |model| {
            let found = candidates.fit(model, resolved);
            task.advance(1);
            found
        };
        let families = FamilyFits::new([fit(rough)?, fit(RecordModel::Smooth)?]);
        let means = families.chosen.window_m > 0.0 && families.chosen.cell_m == 0.0;
        Ok(Self { families, observation: if means { Observation::Means } else { Observation::Points } })
    }
}

/// Records with the observation models to choose from.
struct Candidates<'a> {
    records: Vec<&'a [f64]>,
    step_m: f64,
    decimation: usize,
    band: RecordBand,
}

impl Candidates<'_> {
    fn settings(&self, noise: bool) -> LengthSettings {
        LengthSettings { ends: RecordEnds::Free, noise, band: self.band }
    }

    fn channel(&self, observation: Observation) -> WindowedRecords<'_> {
        let cell_m = self.step_m / self.decimation as f64;
        let (window_m, cell_m) = match observation {
            Observation::Points if self.decimation == 1 => (0.0, 0.0),
            Observation::Points => (self.step_m, cell_m),
            Observation::Means => (self.step_m, 0.0),
        };
        WindowedRecords { window_m, step_m: self.step_m, cell_m, tracks: 1, records: self.records.clone() }
    }

    /// Fits a family with its most likely observation model. If the step resolves the correlation, the interval covers
    /// the intervals of the models that are nearly as likely.
    fn fit(&self, model: RecordModel, resolved: bool) -> Result<LengthFit, EstimateError> {
        let gain = if resolved { GAIN } else { UNRESOLVED_GAIN };
        let all = [Observation::Points, Observation::Means].into_iter().flat_map(|seen| [(seen, false), (seen, true)]);
        let cost = |observation: Observation, noise: bool| {
            0.5 * gain * f64::from(u8::from(observation == Observation::Means) + u8::from(noise))
        };
        let score = |(observation, noise): (Observation, bool)| {
            let found = most_likely(&self.channel(observation), model, self.settings(noise));
            (observation, noise, found.map_or(f64::NEG_INFINITY, |(_, value)| value - cost(observation, noise)))
        };
        let scores: Vec<(Observation, bool, f64)> = all.map(score).collect();
        let best = scores.iter().copied().max_by(|a, b| a.2.total_cmp(&b.2)).ok_or(EstimateError::Nothing)?;
        let fit = |(observation, noise, _): (Observation, bool, f64)| {
            fit_length(&[self.channel(observation)], model, self.settings(noise))
        };
        let found = fit(best)?;
        let mut interval = found.interval;
        let alike = |other: &&(Observation, bool, f64)| resolved && best.2 - other.2 < 0.5 * GAIN && **other != best;
        for other in scores.iter().filter(alike) {
            interval = interval.around(fit(*other)?.interval);
        }
        let likelihoods = scores.iter().map(|(observation, noise, score)| score + cost(*observation, *noise));
        Ok(LengthFit { interval, log_likelihood: likelihoods.fold(f64::NEG_INFINITY, f64::max), ..found })
    }
}

/// Returns the highest frequency up to which records are used.
fn highest_per_m(records: &[&[f64]], step_m: f64, band: RecordBand) -> Result<f64, EstimateError> {
    let nyquist_per_m = 0.5 / step_m;
    let spectrum = record_spectrum(records, 1, step_m, RecordEnds::Free)?;
    let least = LEAST_POWER * spectrum.density.iter().copied().fold(0.0, f64::max);
    let last = spectrum.density.iter().rposition(|density| *density >= least).unwrap_or(0);
    let end_per_m = spectrum.frequency_per_m.get(last + 1).copied().unwrap_or(nyquist_per_m);
    Ok(band.high_per_m(nyquist_per_m).min(end_per_m))
}

/// Divides long records into segments. Lengths are rounded down by at most a 64th, so that few of them differ.
fn segments<'a>(records: &[&'a [f64]], step_m: f64, band: RecordBand) -> Result<Vec<&'a [f64]>, EstimateError> {
    let values: usize = records.iter().map(|record| record.len()).sum();
    if values <= LONG {
        return Ok(records.to_vec());
    }
    let longest = records.iter().map(|record| record.len()).max().unwrap_or(0);
    let decay_m = RecordCorrelation::estimate(records, step_m, longest / 2)?.correlation_length_m();
    let cutoff_m = band.high_pass_m.unwrap_or(0.0);
    let wanted = decay_m.map_or(f64::INFINITY, |m| f64::max(LEAST_LENGTHS * m, LEAST_CUTOFFS * cutoff_m) / step_m);
    let length = (wanted.min(longest as f64) as usize).next_power_of_two().max(LEAST_SEGMENT);
    let rounded = |part: &'a [f64]| {
        let grain = 1 << (part.len() / 64).max(1).ilog2();
        &part[..part.len() - part.len() % grain]
    };
    Ok(records.iter().flat_map(|record| record.chunks(length)).map(rounded).collect())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::monitor::Silent;
    use crate::random;

    /// Returns a record of the correlation e^{−lag/ℓ}, ℓ = 20.
    fn exponential(values: usize, index: u64) -> Vec<f64> {
        exponential_of(20.0, values, index)
    }

    fn exponential_of(length: f64, values: usize, index: u64) -> Vec<f64> {
        let phi = (-1.0 / length).exp();
        let mut record = random::standard_normal(&mut random::stream(59, "observed", index), values);
        for t in 1..values {
            record[t] = phi * record[t - 1] + (1.0 - phi * phi).sqrt() * record[t];
        }
        record
    }

    fn found(record: &[f64], history: RecordHistory) -> ObservedLengths {
        ObservedLengths::fit(&[record], history.decimation as f64, history, &Silent).unwrap()
    }

    #[test]
    #[ignore = "slow"]
    fn means_and_noise_are_found_beside_the_length() {
        // Of fifteen 95 % intervals, four or more fail with probability .005.
        let mut missed = 0;
        for run in 0..5 {
            let record = exponential(3004, run);
            let fine = exponential_of(320.0, 16 * 3004, 50 + run);
            let means: Vec<f64> = fine.chunks_exact(16).map(|part| part.iter().sum::<f64>() / 16.0).collect();
            let of_means = found(&means, RecordHistory::default());
            assert_eq!(of_means.observation, Observation::Means);
            let noise = random::standard_normal(&mut random::stream(59, "noise", run), 3004);
            let noisy: Vec<f64> = record.iter().zip(&noise).map(|(value, noise)| value + 0.3 * noise).collect();
            let of_noisy = found(&noisy, RecordHistory::default());
            // .09/1.09, at the sample variance of the record.
            let fraction = of_noisy.families.chosen.noise_fraction;
            assert!((fraction / 0.0826 - 1.0).abs() < 0.5, "{fraction}");
            assert!(of_noisy.families.chosen.noise_interval.unwrap().low > 0.0);
            let fives: Vec<f64> = record.chunks_exact(5).map(|five| five.iter().sum::<f64>() / 5.0).collect();
            let of_fives = found(&fives, RecordHistory { decimation: 5, ..RecordHistory::default() });
            for fit in [of_means.families.chosen, of_noisy.families.chosen, of_fives.families.chosen] {
                missed += usize::from(!fit.interval.contains(20.0));
                assert!((fit.length_m / 20.0).ln().abs() < 0.6, "{fit:?}");
            }
        }
        assert!(missed <= 3, "{missed} of 15");
    }

    #[test]
    #[ignore = "slow"]
    fn segments_of_a_long_record_have_the_fit_of_the_whole_record() {
        let mut record = exponential(40_000, 300);
        record[7000..7010].fill(f64::NAN);
        let channel = WindowedRecords { window_m: 0.0, step_m: 1.0, cell_m: 0.0, tracks: 1, records: vec![&record] };
        let b = fit_length(&[channel], RecordModel::Exponential, LengthSettings::default()).unwrap();
        let a = found(&record, RecordHistory::default()).families.chosen;
        assert_eq!((a.model, a.window_m, a.noise_fraction), (b.model, 0.0, 0.0));
        let width = |fit: LengthFit| (fit.interval.high / fit.interval.low).ln();
        // The tapers of the segments weight other values, a tenth of all.
        assert!((a.length_m / b.length_m).ln().abs() < 0.2 * width(b), "{a:?} {b:?}");
        assert!((width(a) / width(b)).ln().abs() < 0.4, "{a:?} {b:?}");
    }

    #[test]
    fn segments_contain_all_values_but_a_64th_and_have_few_lengths() {
        let records: Vec<Vec<f64>> =
            (0..50).map(|i| exponential(3000 + i, 400 + i as u64)).chain([exponential(70_000, 399)]).collect();
        let views: Vec<&[f64]> = records.iter().map(Vec::as_slice).collect();
        let segments = segments(&views, 1.0, RecordBand::default()).unwrap();
        let kept: usize = segments.iter().map(|part| part.len()).sum();
        let all: usize = views.iter().map(|record| record.len()).sum();
        assert!(64 * (all - kept) <= all, "{kept} of {all}");
        let mut lengths: Vec<usize> = segments.iter().map(|part| part.len()).collect();
        lengths.sort_unstable();
        lengths.dedup();
        assert!(lengths.len() < 6 && lengths.last() == Some(&(1 << 14)), "{lengths:?}");
    }

    #[test]
    fn the_goodness_of_fit_test_has_its_level_and_power() {
        let p = |record: &[f64]| {
            let channel = WindowedRecords { window_m: 0.0, step_m: 1.0, cell_m: 0.0, tracks: 1, records: vec![record] };
            let fit = fit_length(&[channel], RecordModel::Exponential, LengthSettings::default()).unwrap();
            fit.lack_of_fit.unwrap().p_value
        };
        let records: Vec<Vec<f64>> = (100..160).map(|index| exponential(2000, index)).collect();
        let values: Vec<f64> = records.iter().map(|record| p(record)).collect();
        let below = |level: f64| values.iter().filter(|p| **p < level).count();
        // Of 60, 5 % are 3 ± 1.7 and a half is 30 ± 3.9; the estimated dispersion makes the test slightly conservative.
        assert!(below(0.05) <= 9 && below(0.5) >= 14 && below(0.5) <= 43, "{values:?}");
        let smooth = |record: &Vec<f64>| record.windows(3).map(|v| v.iter().sum::<f64>() / 3.0).collect::<Vec<f64>>();
        assert!(records[..5].iter().all(|record| p(&smooth(record)) < 1e-6));
    }

    #[test]
    fn unknown_filters_fail_the_test_of_fit() {
        // Two resonant poles with a period of eight steps.
        let record = exponential(4000, 200);
        let mut out = vec![0.0; record.len()];
        for t in 2..record.len() {
            out[t] = 1.3 * out[t - 1] - 0.85 * out[t - 2] + record[t];
        }
        let found = found(&out[50..], RecordHistory::default());
        assert!(found.families.chosen.lack_of_fit.unwrap().significant(), "{found:?}");
    }
}
