//! Whittle's likelihood of a correlation model of records.

use std::f64::consts::PI;

use super::band::RecordBand;
use super::model::WindowedModel;
use crate::fourier::RealFft2;
use crate::numeric::scanned_minimum;
use crate::stats::{Moments, lag_sums};

/// Least number of values of a record with a spectrum.
const SHORTEST: usize = 8;
/// Range of the noise fraction.
const NOISE: (f64, f64) = (1e-6, 0.98);

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
pub(super) struct Group {
    n: usize,
    step_m: f64,
    window: WindowedModel,
    ends: RecordEnds,
    plan: RealFft2,
    /// Σ w_i w_{i+l}/Σ w² of the taper at the lags l; `None` for periodic records, where it is 1.
    lag_weights: Vec<f64>,
    /// Weight of each of the wavenumbers 1, 2, ….
    pub(super) fractions: Vec<f64>,
    /// Power transfer of the filters at each wavenumber; 1 where the weight is zero.
    passed: Vec<f64>,
    /// Variance of a periodogram ordinate with the taper relative to independent ordinates.
    spread: f64,
    /// Periodograms at the wavenumbers 1, 2, …, with the group index of each record.
    pub(super) powers: Vec<(usize, Vec<f64>)>,
}

impl Group {
    fn periodogram(&self, values: &[f64], squares: f64) -> Vec<f64> {
        let (mut spectrum, mut work) = (self.plan.spectrum(), self.plan.workspace());
        self.plan.forward(values, &mut spectrum, &mut work);
        spectrum[1..=self.fractions.len()].iter().map(|value| self.step_m * value.norm_sqr() / squares).collect()
    }

    /// Returns the expected periodogram for the length ℓ and a point process of the given variance.
    fn expected(&self, length_m: f64, variance: impl Fn(&WindowedModel, f64) -> f64) -> Vec<f64> {
        let n = self.n;
        let covariance = |lag: usize| variance(&self.window, lag as f64 * self.step_m);
        // Beyond this every model is negligible.
        let end = ((40.0 * length_m + self.window.window_m()) / self.step_m).ceil();
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
pub(super) struct Likelihood {
    pub(super) groups: Vec<Group>,
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
        let mut groups: Vec<Group> = Vec::new();
        for channel in channels {
            let window = model.with_window(channel.window_m);
            let stride = if band.highest_per_m.is_some() { 1 } else { channel.stride(ends) };
            let step_m = channel.step_m * stride as f64;
            // Subtract the common mean: the mean of each record would remove power from its lowest wavenumbers.
            let mean = Moments::from_values(channel.records.iter().flat_map(|record| record.iter().copied())).mean;
            let mut of_length: Vec<(usize, usize)> = Vec::new();
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
                let known = of_length.iter().find(|(length, _)| complete && *length == n).map(|(_, group)| *group);
                let group = known.unwrap_or_else(|| {
                    let periodic = complete && ends == RecordEnds::Periodic;
                    let lag_weights = if periodic {
                        Vec::new()
                    } else {
                        lag_sums(&weights, 0.0, n).0.into_iter().map(|sum| sum / squares).collect()
                    };
                    let used = |k: &usize| *k as f64 * step_per_m >= lowest;
                    let passed = |k: usize| if used(&k) { band.passed(k as f64 * step_per_m) } else { 1.0 };
                    let fourth: f64 = weights.iter().map(|w| w.powi(4)).sum();
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
                        window: window.clone(),
                        ends: if periodic { RecordEnds::Periodic } else { RecordEnds::Free },
                        plan: RealFft2::new(n, 1),
                        lag_weights,
                        fractions: (1..=last).map(fraction).collect(),
                        passed: (1..=last).map(passed).collect(),
                        spread: n as f64 * fourth / (squares * squares),
                        powers: Vec::new(),
                    });
                    groups.len() - 1
                });
                if complete && known.is_none() {
                    of_length.push((n, group));
                }
                if squares > 0.0 {
                    let power = groups[group].periodogram(&values, squares);
                    groups[group].powers.push((*owner, power));
                }
            }
        }
        let used: f64 = groups.iter().map(|g| g.fractions.iter().sum::<f64>() * g.powers.len() as f64).sum();
        (used >= 3.0).then(|| Self { groups, narrowest: model.with_window(narrowest_m) })
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
        Spectra(self.groups.iter().map(|group| group.expected(length_m, variance)).collect())
    }

    /// Returns the weighted sums of I/E and of 1 over the wavenumbers of all records.
    fn ratio_sums(&self, spectra: &Spectra) -> (f64, f64) {
        let (mut ratios, mut count) = (0.0, 0.0);
        for (group, expected) in self.groups.iter().zip(&spectra.0) {
            for (_, power) in &group.powers {
                for ((i, e), fraction) in power.iter().zip(expected).zip(&group.fractions) {
                    ratios += fraction * i / e;
                    count += fraction;
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
