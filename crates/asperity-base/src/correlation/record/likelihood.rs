//! Whittle's likelihood of a correlation family of records.

use std::f64::consts::PI;

use super::band::RecordBand;
use super::model::{RecordModel, WindowedModel};
use crate::fourier::{Complex64, RealFft2};
use crate::numeric::scanned_minimum;
use crate::stats::{Moments, lag_sums};

/// Least number of values of a record with a spectrum.
const SHORTEST: usize = 8;
/// Range of the noise fraction.
const NOISE: (f64, f64) = (1e-6, 0.98);
/// Highest frequency used, in units of 1/W; the window transmits 4/π² of the power there.
const BAND: f64 = 0.5;
/// Fraction of a free record tapered at either end.
const TAPER: f64 = 0.1;
/// Fraction of a window or a step that replaces shorter lengths.
const LEAST_LENGTH: f64 = 1e-9;

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

    fn highest_per_m(&self, band: RecordBand) -> f64 {
        band.high_per_m(BAND / self.window_m).min(0.5 / self.step_m)
    }
}

/// Returns the taper of a record: a cosine over a tenth at either end of a free record, none for a periodic one.
pub(super) fn taper(n: usize, ends: RecordEnds) -> Vec<f64> {
    let ramp = TAPER * n as f64;
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
pub(super) struct Group {
    n: usize,
    step_m: f64,
    ends: RecordEnds,
    window: WindowedModel,
    plan: RealFft2,
    /// Σ w_i w_{i+l}/Σ w² of the taper at the lags l, the mean over the records.
    lag_weights: Vec<f64>,
    /// Weight of each of the wavenumbers 1, 2, ….
    pub(super) fractions: Vec<f64>,
    /// Power transfer of the filters at each wavenumber; 1 where the weight is zero.
    passed: Vec<f64>,
    /// Variance of a periodogram ordinate with the taper relative to independent ordinates.
    spread: f64,
    /// Periodograms at the wavenumbers 1, 2, …, with the index of each record.
    pub(super) powers: Vec<(usize, Vec<f64>)>,
    /// Sum of the periodograms.
    pub(super) total: Vec<f64>,
}

impl Group {
    /// Creates a group without records; `None` if it has no wavenumber in the band.
    fn new(
        channels: &[WindowedRecords<'_>],
        channel: &WindowedRecords<'_>,
        (n, step_m): (usize, f64),
        (ends, band): (RecordEnds, RecordBand),
        model: RecordModel,
    ) -> Option<Self> {
        let step_per_m = 1.0 / (n as f64 * step_m);
        let lowest = band.low_per_m() * (1.0 - 1e-9);
        let last = ((channel.highest_per_m(band) / step_per_m).floor() as usize).min(n.saturating_sub(1) / 2);
        if n < SHORTEST || last == 0 || (last as f64) * step_per_m < lowest {
            return None;
        }
        let frequencies = (1..=last).map(|k| k as f64 * step_per_m);
        let fraction = |frequency: f64| {
            let seen = channels.iter().filter(|other| frequency <= other.highest_per_m(band) * (1.0 + 1e-9)).count();
            if frequency >= lowest { 1.0 / seen.max(1) as f64 } else { 0.0 }
        };
        let passed = |frequency: f64| if frequency >= lowest { band.passed(frequency) } else { 1.0 };
        Some(Self {
            n,
            step_m,
            ends,
            window: WindowedModel::new(model, channel.window_m).with_cells(channel.cell_m),
            plan: RealFft2::new(n, 1),
            lag_weights: vec![0.0; n],
            fractions: frequencies.clone().map(fraction).collect(),
            passed: frequencies.map(passed).collect(),
            spread: 0.0,
            powers: Vec::new(),
            total: vec![0.0; last],
        })
    }

    /// Adds a record of this index.
    fn add(&mut self, index: usize, record: &[f64], mean: f64) {
        let (values, weights) = tapered(record, &taper(self.n, self.ends), mean);
        let squares: f64 = weights.iter().map(|w| w * w).sum();
        if squares == 0.0 {
            return;
        }
        let part = 1.0 / (self.powers.len() as f64 + 1.0);
        let fourth: f64 = weights.iter().map(|w| w.powi(4)).sum();
        self.spread += part * (self.n as f64 * fourth / (squares * squares) - self.spread);
        // Complete records have the same weights.
        if self.powers.is_empty() || weights.contains(&0.0) {
            let own = lag_sums(&weights, 0.0, self.n).0;
            self.lag_weights.iter_mut().zip(own).for_each(|(mean, own)| *mean += part * (own / squares - *mean));
        }
        let (mut spectrum, mut work) = (self.plan.spectrum(), self.plan.workspace());
        self.plan.forward(&values, &mut spectrum, &mut work);
        let power: Vec<f64> =
            spectrum[1..=self.total.len()].iter().map(|v| self.step_m * v.norm_sqr() / squares).collect();
        self.total.iter_mut().zip(&power).for_each(|(total, power)| *total += power);
        self.powers.push((index, power));
    }

    /// Returns the expected periodogram for a length ℓ > 0, per `unit` of variance.
    fn expected(&self, length_m: f64, unit: f64) -> Vec<f64> {
        let n = self.n;
        // Beyond this every model is negligible.
        let end = (((40.0 * length_m + self.window.window_m()) / self.step_m).ceil() as usize).max(1);
        let mut folded = vec![0.0; n];
        let periodic = self.ends == RecordEnds::Periodic;
        for lag in 0..if periodic { end } else { end.min(n) } {
            let weight = if periodic { 1.0 } else { self.lag_weights[lag] };
            let value = weight * self.window.covariance(lag as f64 * self.step_m, length_m) / unit;
            folded[lag % n] += value;
            if lag > 0 {
                folded[(n - lag % n) % n] += value;
            }
        }
        let (mut spectrum, mut work) = (self.plan.spectrum(), self.plan.workspace());
        self.plan.forward(&folded, &mut spectrum, &mut work);
        let scaled = |(value, passed): (&Complex64, &f64)| self.step_m * value.re * passed;
        spectrum[1..=self.total.len()].iter().zip(&self.passed).map(scaled).collect()
    }

    pub(super) fn frequency_per_m(&self, place: usize) -> f64 {
        (place + 1) as f64 / (self.n as f64 * self.step_m)
    }

    /// Returns the number of records.
    pub(super) fn records(&self) -> f64 {
        self.powers.len() as f64
    }
}

/// Profile −ln of Whittle's likelihood of one family for records under one or more windows, as a function of its length
/// ℓ, with the variance at its optimum.
///
/// Every periodogram ordinate I is compared with its expectation E for the record's length, step, taper and window,
/// which accounts for sampling, leakage and missing values (Sykulski, Olhede, Guillaumin, Lilly & Early, *Biometrika*
/// **106** (2019) 251, <https://doi.org/10.1093/biomet/asy071>): −ln L = Σ [ln E + I/E]. The wavenumber 0, and so the
/// unknown mean, is excluded. Records of equal length share the mean of their expectations.
///
/// A window has zero transfer at its own wavenumber 1/W, so wavenumbers beyond 1/(2W) are excluded. A wavenumber that
/// several windows contain is weighted with the reciprocal of their number: windows on the same strip are redundant.
///
/// White noise with the fraction η of the variance of the values adds a floor: E = (1 − η) E_process + η Δ.
pub(super) struct Likelihood {
    pub(super) groups: Vec<Group>,
}

/// Expected periodograms of all groups, for unit variance under the narrowest window.
pub(super) type Spectra = Vec<Vec<f64>>;

impl Likelihood {
    /// Creates the likelihood of records under one or more windows. `None` with fewer than three wavenumbers.
    pub(super) fn new(
        channels: &[WindowedRecords<'_>],
        ends: RecordEnds,
        band: RecordBand,
        model: RecordModel,
    ) -> Option<Self> {
        let mut groups = Vec::new();
        for channel in channels {
            let stride = if band.highest_per_m.is_some() { 1 } else { channel.stride(ends) };
            let step_m = channel.step_m * stride as f64;
            // Subtract the common mean: the mean of each record would remove power from its lowest wavenumbers.
            let mean = Moments::from_values(channel.records.iter().flat_map(|record| record.iter().copied())).mean;
            let first = groups.len();
            for (index, record) in channel.records.iter().enumerate() {
                let record: Vec<f64> = record.iter().step_by(stride).copied().collect();
                let complete = record.iter().all(|value| value.is_finite());
                let own_ends = if complete { ends } else { RecordEnds::Free };
                let alike = |group: &Group| group.n == record.len() && group.ends == own_ends;
                let place = groups[first..].iter().position(alike).map(|place| first + place).or_else(|| {
                    let shape = (record.len(), step_m);
                    groups.push(Group::new(channels, channel, shape, (own_ends, band), model)?);
                    Some(groups.len() - 1)
                });
                if let Some(place) = place {
                    groups[place].add(index, &record, mean);
                }
            }
        }
        groups.retain(|group| !group.powers.is_empty());
        let used: f64 = groups.iter().map(|g| g.fractions.iter().sum::<f64>() * g.records()).sum();
        (used >= 3.0).then_some(Self { groups })
    }

    /// Returns the expected periodograms for the length ℓ ≥ 0 in metre.
    pub(super) fn spectra(&self, length_m: f64) -> Spectra {
        let narrower = |a: &'_ &Group, b: &'_ &Group| a.window.window_m().total_cmp(&b.window.window_m());
        let narrowest = self.groups.iter().min_by(narrower);
        let shortest_m = narrowest.map_or(0.0, |group| LEAST_LENGTH * group.window.window_m().max(group.step_m));
        let length_m = length_m.max(shortest_m);
        let unit = narrowest.map_or(1.0, |group| group.window.covariance(0.0, length_m));
        self.groups.iter().map(|group| group.expected(length_m, unit)).collect()
    }

    /// Returns the weighted sums of I/E and of 1 over the wavenumbers of all records.
    fn ratio_sums(&self, spectra: &Spectra) -> (f64, f64) {
        let (mut ratios, mut count) = (0.0, 0.0);
        for (group, expected) in self.groups.iter().zip(spectra) {
            for ((i, e), fraction) in group.total.iter().zip(expected).zip(&group.fractions) {
                ratios += fraction * i / e;
                count += group.records() * fraction;
            }
        }
        (ratios, count)
    }

    /// Returns the most likely variance under the narrowest window at a length.
    pub(super) fn variance(&self, spectra: &Spectra) -> f64 {
        let (ratios, count) = self.ratio_sums(spectra);
        ratios / count
    }

    /// Returns −ln L at a length, for the most likely variance; infinite if rounding makes an expectation non-positive.
    fn negative_log(&self, spectra: &Spectra) -> f64 {
        let (ratios, count) = self.ratio_sums(spectra);
        let mut logs = 0.0;
        for (group, expected) in self.groups.iter().zip(spectra) {
            let sum: f64 = expected.iter().zip(&group.fractions).map(|(e, fraction)| fraction * e.ln()).sum();
            logs += sum * group.records();
        }
        let value = count * ((ratios / count).ln() + 1.0) + logs;
        if value.is_nan() { f64::INFINITY } else { value }
    }

    /// Returns the expected spectra with a fraction of white noise in the variance of the values.
    pub(super) fn with_noise(&self, spectra: &Spectra, noise: f64) -> Spectra {
        let mixed = |(group, expected): (&Group, &Vec<f64>)| {
            let floor = noise * group.step_m;
            expected.iter().zip(&group.passed).map(|(e, passed)| (1.0 - noise) * e + floor * passed).collect()
        };
        self.groups.iter().zip(spectra).map(mixed).collect()
    }

    /// Returns the noise fraction (0 if it is not fitted) and −ln L at a length.
    pub(super) fn profile(&self, length_m: f64, noise: bool) -> (f64, f64) {
        let spectra = self.spectra(length_m);
        let none = (0.0, self.negative_log(&spectra));
        if !noise {
            return none;
        }
        let fraction = |logit: f64| 1.0 / (1.0 + (-logit).exp());
        let logit = |fraction: f64| (fraction / (1.0 - fraction)).ln();
        let (low, high, parts) = (logit(NOISE.0), logit(NOISE.1), 9_i32);
        let places: Vec<f64> = (0..=parts).map(|i| low + (high - low) * f64::from(i) / f64::from(parts)).collect();
        let at = |logit: f64| self.negative_log(&self.with_noise(&spectra, fraction(logit)));
        let found = scanned_minimum(at, &places, 1e-2);
        if none.1 <= found.value + 1e-6 { none } else { (fraction(found.place), found.value) }
    }

    /// Returns the variance of the mean of ordinates relative to independent ones.
    pub(super) fn spread(&self) -> f64 {
        let weight = |group: &Group| group.records() * group.fractions.iter().sum::<f64>();
        let all: f64 = self.groups.iter().map(weight).sum();
        self.groups.iter().map(|group| weight(group) * group.spread).sum::<f64>() / all
    }
}

#[cfg(test)]
mod tests {
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

    fn likelihood(channel: &WindowedRecords<'_>, ends: RecordEnds, model: RecordModel) -> Likelihood {
        Likelihood::new(std::slice::from_ref(channel), ends, RecordBand::default(), model).unwrap()
    }

    #[test]
    fn incomplete_records_share_the_mean_of_their_expectations() {
        let mut values: Vec<f64> = (0..4096_u32).map(|i| f64::from((i * i) % 1009)).collect();
        values[100..130].fill(f64::NAN);
        values[2051] = f64::NAN;
        let of = |records: Vec<&[f64]>| {
            let channel = WindowedRecords { window_m: 0.0, step_m: 1.0, cell_m: 0.0, tracks: 1, records };
            likelihood(&channel, RecordEnds::Free, RecordModel::Exponential)
        };
        let own: Vec<Likelihood> = values.chunks(2048).map(|record| of(vec![record])).collect();
        let shared = of(values.chunks(2048).collect());
        assert_eq!(shared.groups.len(), 1);
        let mean: Vec<f64> =
            own[0].spectra(5.0)[0].iter().zip(&own[1].spectra(5.0)[0]).map(|(a, b)| 0.5 * (a + b)).collect();
        assert!(shared.spectra(5.0)[0].iter().zip(mean).all(|(found, wanted)| (found / wanted - 1.0).abs() < 1e-9));
    }

    #[test]
    fn expected_periodograms_equal_double_sums() {
        let values: Vec<f64> = (0..60_u8).map(|i| f64::from(i % 7)).collect();
        let mut holed = values.clone();
        holed[17] = f64::NAN;
        let cases = [(&values, RecordEnds::Free), (&values, RecordEnds::Periodic), (&holed, RecordEnds::Free)];
        for ((record, ends), model) in cases.into_iter().flat_map(|case| RecordModel::BOTH.map(|model| (case, model))) {
            let channel = WindowedRecords { window_m: 3.0, step_m: 0.5, cell_m: 0.0, tracks: 1, records: vec![record] };
            let likelihood = likelihood(&channel, ends, model);
            for length in [0.0, 0.2, 4.0] {
                let found = likelihood.spectra(length);
                let window = WindowedModel::new(model, 3.0);
                let mut weights = taper(60, ends);
                record.iter().zip(&mut weights).filter(|(v, _)| v.is_nan()).for_each(|(_, w)| *w = 0.0);
                let covariance = |lag: f64| match ends {
                    RecordEnds::Free => window.correlation(lag, length),
                    RecordEnds::Periodic => {
                        (-9..=9).map(|turn| window.correlation(lag + 30.0 * f64::from(turn), length)).sum()
                    }
                };
                for (k, e) in found[0].iter().enumerate() {
                    let wanted = direct(60, 0.5, k + 1, &weights, covariance);
                    assert!((e - wanted).abs() < 1e-8 * wanted.max(1e-3), "{ends:?} ℓ {length} k {k}: {e} {wanted}");
                }
            }
        }
    }
}
