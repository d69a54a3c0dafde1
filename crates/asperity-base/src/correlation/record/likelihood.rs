//! Whittle's likelihood of a correlation model of records.

use std::f64::consts::PI;
use std::sync::Arc;

use super::band::RecordBand;
use super::model::WindowedModel;
use crate::fourier::RealFft2;
use crate::numeric::scanned_minimum;
use crate::stats::{Moments, lag_sums};

/// Least number of values of a record with a spectrum.
const SHORTEST: usize = 8;
/// Number of values from which the periodograms of records of equal length are summed, also of incomplete records.
const MANY: usize = 1 << 15;
/// Range of the noise fraction.
const NOISE: (f64, f64) = (1e-6, 0.98);
/// Least expected power relative to its maximum, and largest fraction of leakage in it, of ordinates of a smooth process
/// without noise.
const LEAST_POWER: f64 = 1e-5;
const MOST_LEAKAGE: f64 = 0.2;

/// Boundary condition of records.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum RecordEnds {
    /// Free ends: the record is part of a longer one.
    #[default]
    Free,
    /// Periodic record; the period is the number of values times the step.
    Periodic,
}

/// Records of one process with equal steps, each value a mean over a window. NaN is a missing value.
#[derive(Debug, Clone)]
pub struct WindowedRecords<'a> {
    /// Window W in metre; 0 for values at points.
    pub window_m: f64,
    /// Distance between values in metre.
    pub step_m: f64,
    /// Distance in metre of the values averaged by a window; 0 for a mean over a line.
    pub cell_m: f64,
    /// Records per strip, listed one after another. Strips are independent; the tracks of a strip may be dependent.
    pub tracks: usize,
    /// The records.
    pub records: Vec<&'a [f64]>,
}

impl WindowedRecords<'_> {
    /// Returns the length of the longest record in metre.
    pub(super) fn longest_m(&self) -> f64 {
        self.records.iter().map(|record| record.len()).max().unwrap_or(0) as f64 * self.step_m
    }

    /// Returns the stride of values that suffice: four per window are enough below 1/(2W), and a period must be
    /// divisible.
    fn stride(&self, ends: RecordEnds) -> usize {
        let wanted = ((self.window_m / self.step_m / 4.0) as usize).max(1);
        let fits = |stride: usize| {
            ends == RecordEnds::Free || self.records.iter().all(|record| record.len().is_multiple_of(stride))
        };
        (1..=wanted).rev().find(|stride| fits(*stride)).unwrap_or(1)
    }
}

/// Returns the taper of a record: a cosine over the fraction `share` at either end of a free record, none for a
/// periodic one.
pub(super) fn taper(n: usize, ends: RecordEnds, fraction: f64) -> Vec<f64> {
    let ramp = fraction * n as f64;
    let at = |i: usize| {
        let from_end = (i.min(n - 1 - i) as f64 + 0.5) / ramp;
        if ends == RecordEnds::Periodic || from_end >= 1.0 { 1.0 } else { 0.5 - 0.5 * (PI * from_end).cos() }
    };
    (0..n).map(at).collect()
}

/// Returns the tapered deviations of the record from `mean`, zero at missing values, and the effective weights.
pub(super) fn tapered(record: &[f64], taper: &[f64], mean: f64) -> (Vec<f64>, Vec<f64>) {
    let pairs = || record.iter().zip(taper);
    let weights = pairs().map(|(value, weight)| if value.is_finite() { *weight } else { 0.0 });
    let values = pairs().map(|(value, weight)| if value.is_finite() { weight * (value - mean) } else { 0.0 });
    (values.collect(), weights.collect())
}

/// Records of equal length and step under one window.
#[derive(Clone)]
pub(super) struct Group {
    n: usize,
    step_m: f64,
    ends: RecordEnds,
    plan: RealFft2,
    /// Σ w_i w_{i+l}/Σ w² of the taper at the lags l, the mean over the records; empty for periodic records, where it
    /// is 1.
    lag_weights: Vec<f64>,
    /// Weight of each of the wavenumbers 1, 2, ….
    pub(super) fractions: Vec<f64>,
    /// Power transfer of the filters at each wavenumber; 1 where the weight is zero.
    passed: Vec<f64>,
    /// Variance of a periodogram ordinate with the taper relative to independent ordinates.
    spread: f64,
    /// Periodograms at the wavenumbers 1, 2, …, with the group index of each record.
    pub(super) powers: Vec<(usize, Vec<f64>)>,
    /// Sum of the periodograms of many values.
    total: Option<Vec<f64>>,
    /// Index of the group of the segments, if this is a whole record with its waves that are longer than two segments.
    segments: Option<usize>,
}

impl Group {
    fn periodogram(&self, values: &[f64], squares: f64) -> Vec<f64> {
        let (mut spectrum, mut work) = (self.plan.spectrum(), self.plan.workspace());
        self.plan.forward(values, &mut spectrum, &mut work);
        spectrum[1..=self.fractions.len()].iter().map(|value| self.step_m * value.norm_sqr() / squares).collect()
    }

    /// Returns the expected periodogram for the length ℓ and a point process of the given variance.
    fn expected(
        &self,
        window: &WindowedModel,
        length_m: f64,
        variance: impl Fn(&WindowedModel, f64) -> f64,
    ) -> Vec<f64> {
        let n = self.n;
        let covariance = |lag: usize| variance(window, lag as f64 * self.step_m);
        // Beyond this every model is negligible.
        let end = ((40.0 * length_m + window.window_m()) / self.step_m).ceil();
        let mut folded = vec![0.0; n];
        match self.ends {
            RecordEnds::Free => {
                let lags = (end.min(n as f64) as usize).max(1).min(n);
                for lag in 0..lags {
                    let value = self.lag_weights[lag] * covariance(lag);
                    folded[lag] += value;
                    if lag > 0 {
                        folded[n - lag] += value;
                    }
                }
            }
            RecordEnds::Periodic => {
                // Sum over all periods.
                let lags = (end as usize).max(1);
                for lag in 0..lags {
                    let value = covariance(lag);
                    folded[lag % n] += value;
                    if lag > 0 {
                        folded[(n - lag % n) % n] += value;
                    }
                }
            }
        }
        let (mut spectrum, mut work) = (self.plan.spectrum(), self.plan.workspace());
        self.plan.forward(&folded, &mut spectrum, &mut work);
        spectrum[1..=self.fractions.len()]
            .iter()
            .zip(&self.passed)
            .map(|(v, passed)| self.step_m * v.re * passed)
            .collect()
    }

    /// Returns the expected periodogram below the wavenumbers 1, 2, … of segments, from their expectations.
    fn extrapolated(&self, segments: &[f64], segment: usize) -> Vec<f64> {
        let slope = segments.get(1).map_or(0.0, |second| (second - segments[0]) / 3.0);
        let at = |(place, passed): (usize, &f64)| {
            let wavenumber = (place + 1) as f64 * segment as f64 / self.n as f64;
            passed * (segments[0] + slope * (wavenumber * wavenumber - 1.0))
        };
        self.passed.iter().enumerate().map(at).collect()
    }

    pub(super) fn frequency_per_m(&self, place: usize) -> f64 {
        (place + 1) as f64 / (self.n as f64 * self.step_m)
    }
}

/// Profile −ln of Whittle's likelihood of one model for records under one or more windows, as a function of its length
/// ℓ, with the variance at its optimum.
///
/// Every periodogram ordinate I is compared with its expectation E for the record's length, step, taper and window,
/// which accounts for sampling, leakage and missing values (Sykulski, Olhede, Guillaumin, Lilly & Early, *Biometrika*
/// **106** (2019) 251, <https://doi.org/10.1093/biomet/asy071>): −ln L = Σ [ln E + I/E]. The wavenumber 0, and so the
/// unknown mean, is excluded.
///
/// A window has zero transfer at its own wavenumber 1/W, so wavenumbers beyond [`Likelihood::BAND`]/W are excluded. A
/// wavenumber that several windows contain is weighted with the reciprocal of their number: windows on the same strip
/// are redundant.
///
/// White noise with the fraction η of the variance of the values adds a floor: E = (1 − η) E_process + η Δ.
#[derive(Clone)]
pub(super) struct Likelihood {
    pub(super) groups: Arc<Vec<Group>>,
    /// Model of every group under its window.
    windows: Vec<WindowedModel>,
    narrowest: WindowedModel,
}

/// Expected periodograms of all groups, for unit variance under the narrowest window.
pub(super) struct Spectra(pub(super) Vec<Vec<f64>>);

impl Likelihood {
    /// Highest frequency used, in units of 1/W; the window transmits 4/π² of the power there.
    pub(super) const BAND: f64 = 0.5;
    /// Fraction of a free record tapered at either end.
    pub(super) const TAPER: f64 = 0.1;

    /// Creates the likelihood of records under one or more windows; `owners` are the group indices of the records of
    /// every channel. `None` with fewer than three wavenumbers.
    pub(super) fn new(
        channels: &[WindowedRecords<'_>],
        owners: &[usize],
        (ends, band): (RecordEnds, RecordBand),
        model: &WindowedModel,
    ) -> Option<Self> {
        let narrowest_m = channels.iter().map(|channel| channel.window_m).fold(f64::INFINITY, f64::min);
        if !narrowest_m.is_finite() {
            return None;
        }
        let highest =
            |channel: &WindowedRecords<'_>| band.high_per_m(Self::BAND / channel.window_m).min(0.5 / channel.step_m);
        let lowest = band.low_per_m() * (1.0 - 1e-9);
        let (mut groups, mut windows) = (Vec::<Group>::new(), Vec::new());
        for channel in channels {
            let window = model.with_window(channel.window_m);
            let stride = if band.highest_per_m.is_some() { 1 } else { channel.stride(ends) };
            let step_m = channel.step_m * stride as f64;
            // Subtract the common mean: the mean of each record would remove power from its lowest wavenumbers.
            let mean = Moments::from_values(channel.records.iter().flat_map(|record| record.iter().copied())).mean;
            let values: usize = channel.records.iter().map(|record| record.len()).sum();
            let pooled = band.highest_per_m.is_some() && values > MANY;
            let mut of_length: Vec<(usize, bool, usize)> = Vec::new();
            for (record, owner) in channel.records.iter().zip(owners) {
                let record: Vec<f64> = record.iter().step_by(stride).copied().collect();
                let n = record.len();
                let complete = record.iter().all(|value| value.is_finite());
                let step_per_m = 1.0 / (n as f64 * step_m);
                let last = (highest(channel) / step_per_m).floor() as usize;
                let last = last.min(n.saturating_sub(1) / 2);
                if n < SHORTEST || last == 0 || last as f64 * step_per_m < lowest {
                    continue;
                }
                let (values, weights) = tapered(&record, &taper(n, ends, Self::TAPER), mean);
                let squares: f64 = weights.iter().map(|w| w * w).sum();
                if squares == 0.0 {
                    continue;
                }
                let alike = |(length, whole, _): &&(usize, bool, usize)| {
                    *length == n && *whole == complete && (complete || pooled)
                };
                let known = of_length.iter().find(alike).map(|(_, _, group)| *group);
                let lag_weights = || lag_sums(&weights, 0.0, n).0.into_iter().map(|sum| sum / squares);
                let fourth: f64 = weights.iter().map(|w| w.powi(4)).sum();
                let spread = n as f64 * fourth / (squares * squares);
                let group = known.unwrap_or_else(|| {
                    let periodic = complete && ends == RecordEnds::Periodic;
                    let used = |k: &usize| *k as f64 * step_per_m >= lowest;
                    let passed = |k: usize| if used(&k) { band.passed(k as f64 * step_per_m) } else { 1.0 };
                    let fraction = |k: usize| {
                        let frequency = k as f64 * step_per_m;
                        if !used(&k) {
                            return 0.0;
                        }
                        let seen = channels.iter().filter(|other| frequency <= highest(other) * (1.0 + 1e-9)).count();
                        1.0 / seen.max(1) as f64
                    };
                    groups.push(Group {
                        n,
                        step_m,
                        ends: if periodic { RecordEnds::Periodic } else { RecordEnds::Free },
                        plan: RealFft2::new(n, 1),
                        lag_weights: if periodic { Vec::new() } else { lag_weights().collect() },
                        fractions: (1..=last).map(fraction).collect(),
                        passed: (1..=last).map(passed).collect(),
                        spread,
                        total: pooled.then(|| vec![0.0; last]),
                        powers: Vec::new(),
                        segments: None,
                    });
                    windows.push(window.clone());
                    of_length.push((n, complete, groups.len() - 1));
                    groups.len() - 1
                });
                let group = &mut groups[group];
                if known.is_some() && !complete {
                    let part = 1.0 / (group.powers.len() as f64 + 1.0);
                    group
                        .lag_weights
                        .iter_mut()
                        .zip(lag_weights())
                        .for_each(|(mean, own)| *mean += part * (own - *mean));
                    group.spread += part * (spread - group.spread);
                }
                let power = group.periodogram(&values, squares);
                if let Some(total) = &mut group.total {
                    total.iter_mut().zip(&power).for_each(|(total, power)| *total += power);
                }
                group.powers.push((*owner, power));
            }
        }
        let used: f64 = groups.iter().map(|g| g.fractions.iter().sum::<f64>() * g.powers.len() as f64).sum();
        let groups = Arc::new(groups);
        (used >= 3.0).then(|| Self { groups, windows, narrowest: model.with_window(narrowest_m) })
    }

    /// Adds the waves of whole records that are longer than two segments of them, with the segments as records of the
    /// likelihood. Their expectation is extrapolated from the lowest wavenumbers of the segments by a parabola, because
    /// segments are long compared with the correlation.
    #[must_use]
    pub(super) fn with_slow_waves(mut self, records: &[&[f64]], segment: usize, step_m: f64, band: RecordBand) -> Self {
        let segments = self.groups.iter().position(|group| group.n == segment);
        let long: Vec<&[f64]> = records.iter().copied().filter(|record| record.len() >= 2 * segment).collect();
        if segments.is_none() || long.is_empty() {
            return self;
        }
        let groups = Arc::make_mut(&mut self.groups);
        let mean = Moments::from_values(records.iter().flat_map(|record| record.iter().copied())).mean;
        for record in long {
            let (n, last) = (record.len(), record.len() / (2 * segment));
            let (values, weights) = tapered(record, &taper(n, RecordEnds::Free, Self::TAPER), mean);
            let squares: f64 = weights.iter().map(|w| w * w).sum();
            if squares == 0.0 {
                continue;
            }
            let frequency_per_m = |k: usize| k as f64 / (n as f64 * step_m);
            let used = |k: usize| frequency_per_m(k) >= band.low_per_m() * (1.0 - 1e-9);
            let mut group = Group {
                n,
                step_m,
                ends: RecordEnds::Free,
                plan: RealFft2::new(n, 1),
                lag_weights: Vec::new(),
                fractions: (1..=last).map(|k| f64::from(u8::from(used(k)))).collect(),
                passed: (1..=last).map(|k| if used(k) { band.passed(frequency_per_m(k)) } else { 1.0 }).collect(),
                spread: n as f64 * weights.iter().map(|w| w.powi(4)).sum::<f64>() / (squares * squares),
                powers: Vec::new(),
                total: None,
                segments,
            };
            group.powers.push((0, group.periodogram(&values, squares)));
            groups.push(group);
            self.windows.push(self.narrowest.clone());
        }
        self
    }

    /// Returns the likelihood of another model or window for the same values. They have one window, and the band has a
    /// highest frequency, so that the wavenumbers do not depend on the window.
    pub(super) fn with_model(&self, model: &WindowedModel) -> Self {
        let windows = vec![model.clone(); self.groups.len()];
        Self { groups: Arc::clone(&self.groups), windows, narrowest: model.clone() }
    }

    /// Returns the expected periodograms for the length ℓ ≥ 0 in metre.
    pub(super) fn spectra(&self, length_m: f64) -> Spectra {
        let narrowest_m = self.narrowest.window_m();
        // Uncorrelated values have a variance ∝ 1/W.
        let alone = length_m <= 1e-9 * narrowest_m || length_m == 0.0;
        let unit = if alone { 1.0 } else { self.narrowest.covariance(0.0, length_m) };
        let variance = |window: &WindowedModel, lag_m: f64| {
            if alone {
                let fraction = if narrowest_m > 0.0 { narrowest_m / window.window_m() } else { 1.0 };
                fraction * window.correlation(lag_m, 0.0)
            } else {
                window.covariance(lag_m, length_m) / unit
            }
        };
        let mut spectra: Vec<Vec<f64>> = Vec::with_capacity(self.groups.len());
        for (group, window) in self.groups.iter().zip(&self.windows) {
            let expected = match group.segments {
                Some(index) => group.extrapolated(&spectra[index], self.groups[index].n),
                None => group.expected(window, length_m, variance),
            };
            spectra.push(expected);
        }
        Spectra(spectra)
    }

    /// Returns the weighted sums of I/E and of 1 over the wavenumbers of all records.
    fn ratio_sums(&self, spectra: &Spectra) -> (f64, f64) {
        let (mut ratios, mut count) = (0.0, 0.0);
        for (group, expected) in self.groups.iter().zip(&spectra.0) {
            let sums: Vec<(f64, &Vec<f64>)> = match &group.total {
                Some(total) => vec![(group.powers.len() as f64, total)],
                None => group.powers.iter().map(|(_, power)| (1.0, power)).collect(),
            };
            for (records, power) in sums {
                for ((i, e), fraction) in power.iter().zip(expected).zip(&group.fractions) {
                    ratios += fraction * i / e;
                    count += records * fraction;
                }
            }
        }
        (ratios, count)
    }

    /// Returns the most likely variance under the narrowest window at a length.
    pub(super) fn variance(&self, spectra: &Spectra) -> f64 {
        let (ratios, count) = self.ratio_sums(spectra);
        ratios / count
    }

    /// Returns −ln L at a length, for the most likely variance.
    pub(super) fn negative_log(&self, spectra: &Spectra) -> f64 {
        let (ratios, count) = self.ratio_sums(spectra);
        let mut logs = 0.0;
        for (group, expected) in self.groups.iter().zip(&spectra.0) {
            let sum: f64 = expected.iter().zip(&group.fractions).map(|(e, fraction)| fraction * e.ln()).sum();
            logs += sum * group.powers.len() as f64;
        }
        count * ((ratios / count).ln() + 1.0) + logs
    }

    /// Returns −ln L of every group at the common most likely variance.
    pub(super) fn negative_log_by_owner(&self, spectra: &Spectra, owners: usize) -> Vec<f64> {
        let variance = self.variance(spectra);
        let mut parts = vec![0.0; owners];
        for (group, expected) in self.groups.iter().zip(&spectra.0) {
            for (owner, power) in &group.powers {
                for ((i, e), fraction) in power.iter().zip(expected).zip(&group.fractions) {
                    let e = variance * e;
                    parts[*owner] += fraction * (e.ln() + i / e);
                }
            }
        }
        parts
    }

    /// Returns the expected spectra with a fraction of white noise in the variance of the values.
    pub(super) fn with_noise(&self, spectra: &Spectra, noise: f64) -> Spectra {
        let mixed = |(group, expected): (&Group, &Vec<f64>)| {
            let floor = noise * group.step_m;
            expected.iter().zip(&group.passed).map(|(e, passed)| (1.0 - noise) * e + floor * passed).collect()
        };
        Spectra(self.groups.iter().zip(&spectra.0).map(mixed).collect())
    }

    /// Returns the lowest frequency in 1/metre at which the expected power at a length is below [`LEAST_POWER`] of its
    /// maximum, or contains more than [`MOST_LEAKAGE`] of leakage of longer waves through the taper. Ordinates beyond it
    /// are correlated, or depend on noise too weak to be fitted.
    pub(super) fn leakage_from_per_m(&self, length_m: f64) -> Option<f64> {
        let cyclic = |group: &Group| Group { ends: RecordEnds::Periodic, ..group.clone() };
        let without = Self { groups: Arc::new(self.groups.iter().map(cyclic).collect()), ..self.clone() };
        let of_group = |(group, (with, without)): (&Group, (&Vec<f64>, &Vec<f64>))| {
            let least = LEAST_POWER * with.iter().copied().fold(0.0, f64::max);
            let leaks = |(with, without): (&f64, &f64)| *with < least || *without < (1.0 - MOST_LEAKAGE) * with;
            let place = with.iter().zip(without).position(leaks)?;
            group.segments.is_none().then(|| group.frequency_per_m(place))
        };
        let (with, without) = (self.spectra(length_m), without.spectra(length_m));
        self.groups.iter().zip(with.0.iter().zip(&without.0)).filter_map(of_group).reduce(f64::min)
    }

    /// Returns the most likely noise fraction at a length, and −ln L there.
    pub(super) fn best_noise(&self, spectra: &Spectra) -> (f64, f64) {
        let at = |logit: f64| {
            let value = self.negative_log(&self.with_noise(spectra, 1.0 / (1.0 + (-logit).exp())));
            if value.is_nan() { f64::INFINITY } else { value }
        };
        let logit = |fraction: f64| (fraction / (1.0 - fraction)).ln();
        let (low, high, parts) = (logit(NOISE.0), logit(NOISE.1), 9_i32);
        let place = |i: i32| low + (high - low) * f64::from(i) / f64::from(parts);
        let places: Vec<f64> = (0..=parts).map(place).collect();
        let found = scanned_minimum(at, &places, 1e-2);
        let none = self.negative_log(spectra);
        if none <= found.value + 1e-6 { (0.0, none) } else { (1.0 / (1.0 + (-found.place).exp()), found.value) }
    }

    /// Returns the noise fraction (0 if it is not fitted) and −ln L at a length, which is infinite if rounding makes an
    /// expectation non-positive.
    pub(super) fn profile(&self, length_m: f64, noise: bool) -> (f64, f64) {
        let spectra = self.spectra(length_m);
        let (fraction, value) = if noise { self.best_noise(&spectra) } else { (0.0, self.negative_log(&spectra)) };
        (fraction, if value.is_nan() { f64::INFINITY } else { value })
    }

    /// Returns the variance of the mean of ordinates relative to independent ones.
    pub(super) fn spread(&self) -> f64 {
        let weight = |group: &Group| group.powers.len() as f64 * group.fractions.iter().sum::<f64>();
        let all: f64 = self.groups.iter().map(weight).sum();
        self.groups.iter().map(|group| weight(group) * group.spread).sum::<f64>() / all
    }
}

#[cfg(test)]
mod tests {
    use super::super::model::RecordModel;
    use super::*;

    /// E of the periodogram by its double sum.
    fn direct(n: usize, step: f64, k: usize, weights: &[f64], covariance: impl Fn(f64) -> f64) -> f64 {
        let squares: f64 = weights.iter().map(|w| w * w).sum();
        let mut sum = 0.0;
        for i in 0..n {
            for j in 0..n {
                let lag = i as f64 - j as f64;
                let phase = 2.0 * PI * k as f64 * lag / n as f64;
                sum += weights[i] * weights[j] * covariance(lag * step) * phase.cos();
            }
        }
        step * sum / squares
    }

    #[test]
    fn slow_waves_have_nearly_the_expectation_of_the_whole_record() {
        let model = WindowedModel::new(RecordModel::Exponential, 0.0);
        let values: Vec<f64> = (0..8192_u16).map(|i| f64::from(i % 7)).collect();
        let of = |records: Vec<&[f64]>| {
            let owners: Vec<usize> = (0..records.len()).collect();
            let channel = WindowedRecords { window_m: 0.0, step_m: 0.5, cell_m: 0.0, tracks: 1, records };
            Likelihood::new(&[channel], &owners, (RecordEnds::Free, RecordBand::default()), &model).unwrap()
        };
        let whole = of(vec![&values]);
        let parts = of(values.chunks(512).collect()).with_slow_waves(&[&values], 512, 0.5, RecordBand::default());
        let ([slow], [all]) = (&parts.groups[1..], &whole.groups[..]) else { panic!() };
        // 512/(2·8192) of the wavenumbers.
        assert_eq!(slow.fractions, [1.0; 8]);
        assert_eq!(slow.frequency_per_m(3), all.frequency_per_m(3));
        assert!(slow.powers[0].1.iter().zip(&all.powers[0].1).all(|(a, b)| (a - b).abs() < 1e-9 * (1.0 + b)));
        for length in [0.0, 0.3, 2.0] {
            let (found, wanted) = (parts.spectra(length), whole.spectra(length));
            let error = found.0[1].iter().zip(&wanted.0[0]).map(|(a, b)| (a / b - 1.0).abs()).fold(0.0, f64::max);
            assert!(error < 0.005, "ℓ {length}: {error}");
        }
    }

    #[test]
    fn the_sum_of_many_periodograms_has_the_likelihood_of_all() {
        let model = WindowedModel::new(RecordModel::Exponential, 0.0);
        let values: Vec<f64> = (0..MANY + 64).map(|i| ((i * i) % 1009) as f64).collect();
        let of = |highest_per_m: Option<f64>| {
            let records: Vec<&[f64]> = values.chunks_exact(64).collect();
            let owners: Vec<usize> = (0..records.len()).collect();
            let channel = WindowedRecords { window_m: 0.0, step_m: 1.0, cell_m: 0.0, tracks: 1, records };
            let band = RecordBand { highest_per_m, ..RecordBand::default() };
            Likelihood::new(&[channel], &owners, (RecordEnds::Free, band), &model).unwrap()
        };
        let (summed, single) = (of(Some(0.5)), of(None));
        assert!(summed.groups[0].total.is_some() && single.groups[0].total.is_none());
        for length in [0.0, 3.0] {
            let [a, b] = [&summed, &single].map(|likelihood| likelihood.negative_log(&likelihood.spectra(length)));
            assert!((a / b - 1.0).abs() < 1e-12, "{a} {b}");
        }
    }

    #[test]
    fn incomplete_records_share_the_mean_of_their_expectations() {
        let model = WindowedModel::new(RecordModel::Exponential, 0.0);
        let mut values: Vec<f64> = (0..2 * MANY).map(|i| ((i * i) % 1009) as f64).collect();
        values[100..130].fill(f64::NAN);
        values[MANY + 3] = f64::NAN;
        let of = |records: Vec<&[f64]>, highest_per_m: Option<f64>| {
            let owners: Vec<usize> = (0..records.len()).collect();
            let channel = WindowedRecords { window_m: 0.0, step_m: 1.0, cell_m: 0.0, tracks: 1, records };
            let band = RecordBand { highest_per_m, ..RecordBand::default() };
            Likelihood::new(&[channel], &owners, (RecordEnds::Free, band), &model).unwrap()
        };
        let (shared, own) = (of(values.chunks(MANY).collect(), Some(0.5)), of(values.chunks(MANY).collect(), None));
        assert_eq!((shared.groups.len(), own.groups.len()), (1, 2));
        let (shared, own) = (shared.spectra(5.0), own.spectra(5.0));
        let mean = own.0[0].iter().zip(&own.0[1]).map(|(a, b)| 0.5 * (a + b));
        assert!(shared.0[0].iter().zip(mean).all(|(found, wanted)| (found / wanted - 1.0).abs() < 1e-9));
    }

    #[test]
    fn expected_periodograms_equal_double_sums() {
        let model = WindowedModel::new(RecordModel::Exponential, 0.0);
        let values: Vec<f64> = (0..60_u8).map(|i| f64::from(i % 7)).collect();
        let mut holed = values.clone();
        holed[17] = f64::NAN;
        for (record, ends) in [(&values, RecordEnds::Free), (&values, RecordEnds::Periodic), (&holed, RecordEnds::Free)]
        {
            let channel = WindowedRecords { window_m: 3.0, step_m: 0.5, cell_m: 0.0, tracks: 1, records: vec![record] };
            let likelihood = Likelihood::new(&[channel], &[0], (ends, RecordBand::default()), &model).unwrap();
            for length in [0.0, 0.2, 4.0] {
                let found = likelihood.spectra(length);
                let window = model.with_window(3.0);
                let mut weights = taper(60, ends, Likelihood::TAPER);
                record.iter().zip(&mut weights).filter(|(v, _)| v.is_nan()).for_each(|(_, w)| *w = 0.0);
                let covariance = |lag: f64| match ends {
                    RecordEnds::Free => window.correlation(lag, length),
                    RecordEnds::Periodic => {
                        (-9..=9).map(|turn| window.correlation(lag + 30.0 * f64::from(turn), length)).sum()
                    }
                };
                for (k, e) in found.0[0].iter().enumerate() {
                    let wanted = direct(60, 0.5, k + 1, &weights, covariance);
                    assert!((e - wanted).abs() < 1e-10 * wanted.max(1e-3), "{ends:?} ℓ {length} k {k}: {e} {wanted}");
                }
            }
        }
    }
}
