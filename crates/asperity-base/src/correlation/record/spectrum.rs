//! Power spectrum of records with confidence bands.

use std::f64::consts::TAU;

use super::checked_moments;
use super::likelihood::{RecordEnds, taper, tapered};
use super::model::WindowedModel;
use crate::correlation::estimate::EstimateError;
use crate::correlation::spectrum::{bin_of, edges};
use crate::distribution::chi_square_quantile;
use crate::fourier::{Complex64, RealFft2};

/// Largest distance of ordinates that the taper correlates.
const REACH: usize = 8;

/// One-sided power spectral density of records with 95 % bands, in bins of a sixth of an octave or of one ordinate
/// where that is wider. Its integral over the frequencies in 1/metre is the variance.
///
/// The density of a bin is the mean of m periodogram ordinates, each distributed as density times χ²₂/2, over all
/// records. The band is [νŜ/χ²(ν; 97.5 %), νŜ/χ²(ν; 2.5 %)] with ν = 2m, reduced for the correlation of neighbouring
/// ordinates by the taper and divided by the redundancy Σ|S_ab|²/ΣS_aa² of the tracks of a strip with cross-spectra
/// S_ab in the bin. It is a band of the mean density over the bin if records are Gaussian and long compared with the
/// correlation.
#[derive(Debug, Clone, PartialEq)]
pub struct RecordSpectrum {
    /// Distance between values in metre.
    pub step_m: f64,
    /// Mean frequency of every bin in 1/metre.
    pub frequency_per_m: Vec<f64>,
    /// Density in the squared unit of the record times metre.
    pub density: Vec<f64>,
    /// Lower limit of the band.
    pub low: Vec<f64>,
    /// Upper limit of the band.
    pub high: Vec<f64>,
    /// Degrees of freedom ν.
    pub degrees_of_freedom: Vec<f64>,
    /// Width of the bin in 1/metre; the sum of densities times widths is the variance.
    pub width_per_m: Vec<f64>,
}

/// Returns the spectrum of records with equal steps and `tracks` records per strip. Free records are centred on their
/// common mean and tapered by a cosine over a tenth at either end. Missing values (NaN) are then set to zero, and
/// scatter power into all frequencies.
///
/// # Errors
/// A step that is not positive, no record of eight values, or values that do not vary.
pub fn record_spectrum(
    records: &[&[f64]],
    tracks: usize,
    step_m: f64,
    ends: RecordEnds,
) -> Result<RecordSpectrum, EstimateError> {
    let moments = checked_moments(records.iter().flat_map(|record| record.iter().copied()), step_m, 8)?;
    let longest = records.iter().map(|record| record.len()).max().unwrap_or(0);
    if longest < 8 {
        return Err(EstimateError::TooFew { present: moments.n, wanted: 8 });
    }
    let edges = edges(longest / 2);
    let unit_per_m = 1.0 / (longest as f64 * step_m);
    let mut bins = vec![Bin::default(); edges.len() - 1];
    let mut shared = vec![CrossSums::new(tracks); bins.len()];
    for (place, record) in records.iter().enumerate().filter(|(_, record)| record.len() >= 8) {
        let track = place % tracks;
        let n = record.len();
        let weights = taper(n, ends);
        let (values, weights) = tapered(record, &weights, moments.mean);
        let squares: f64 = weights.iter().map(|w| w * w).sum();
        if squares == 0.0 {
            continue;
        }
        let fft = RealFft2::new(n, 1);
        let (mut spectrum, mut work) = (fft.spectrum(), fft.workspace());
        fft.forward(&values, &mut spectrum, &mut work);
        let mut in_bin = vec![0.0; bins.len()];
        for (k, value) in spectrum.iter().enumerate().skip(1) {
            let frequency_per_m = k as f64 / (n as f64 * step_m);
            // The Nyquist ordinate of an even number of values has a single sign.
            let fraction = if 2 * k == n { 0.5 } else { 1.0 };
            if let Some(bin) = bin_of(&edges, frequency_per_m / unit_per_m) {
                bins[bin].sum += fraction * 2.0 * step_m * value.norm_sqr() / squares;
                bins[bin].frequency += fraction * frequency_per_m;
                bins[bin].count += fraction;
                bins[bin].power += fraction * 2.0 * value.norm_sqr() / squares / n as f64;
                in_bin[bin] += fraction;
                shared[bin].add(track, k, *value, step_m / squares);
            }
        }
        let kappa = neighbours(&weights, squares);
        for (bin, count) in bins.iter_mut().zip(in_bin) {
            bin.spread += spread(count, &kappa);
        }
        bins[0].records += 1.0;
    }
    let records = bins[0].records;
    bins.iter_mut().zip(&shared).for_each(|(bin, shared)| bin.spread *= shared.alike());
    let used: Vec<Bin> = bins.into_iter().filter(|bin| bin.count > 0.0).collect();
    let degrees: Vec<f64> = used.iter().map(|bin| 2.0 * bin.count * bin.count / bin.spread).collect();
    let density: Vec<f64> = used.iter().map(|bin| bin.sum / bin.count).collect();
    let end = |probability: f64| -> Vec<f64> {
        density.iter().zip(&degrees).map(|(s, nu)| nu * s / chi_square_quantile(*nu, probability)).collect()
    };
    let (low, high) = (end(0.975), end(0.025));
    Ok(RecordSpectrum {
        step_m,
        frequency_per_m: used.iter().map(|bin| bin.frequency / bin.count).collect(),
        width_per_m: used.iter().zip(&density).map(|(bin, s)| bin.power / records / s).collect(),
        density,
        low,
        high,
        degrees_of_freedom: degrees,
    })
}

#[derive(Debug, Clone, Default)]
struct Bin {
    sum: f64,
    frequency: f64,
    count: f64,
    /// Variance in the bin.
    power: f64,
    /// Sum of the correlations over pairs of ordinates.
    spread: f64,
    records: f64,
}

/// Cross-spectra of the tracks of strips in a bin.
#[derive(Debug, Clone)]
struct CrossSums {
    tracks: usize,
    /// Ordinates of the preceding tracks of the current strip, by wavenumber.
    strip: Vec<(usize, Vec<Complex64>)>,
    /// Σ X_a X_b* over ordinates and strips.
    sums: Vec<Complex64>,
}

impl CrossSums {
    fn new(tracks: usize) -> Self {
        Self { tracks, strip: Vec::new(), sums: vec![Complex64::new(0.0, 0.0); tracks * tracks] }
    }

    /// Adds an ordinate of a track, with its power scaled by `weight`.
    fn add(&mut self, track: usize, k: usize, value: Complex64, weight: f64) {
        if self.tracks == 1 {
            return;
        }
        let value = value * weight.sqrt();
        let place = self.strip.iter().position(|(other, _)| *other == k).unwrap_or_else(|| {
            self.strip.push((k, vec![Complex64::new(0.0, 0.0); self.tracks]));
            self.strip.len() - 1
        });
        self.strip[place].1[track] = value;
        if track + 1 == self.tracks {
            let (_, values) = self.strip.swap_remove(place);
            for (a, x) in values.iter().enumerate() {
                for (b, y) in values.iter().enumerate() {
                    self.sums[a * self.tracks + b] += x * y.conj();
                }
            }
        }
    }

    /// Returns the redundancy of the tracks: 1 if they are independent.
    fn alike(&self) -> f64 {
        let all: f64 = self.sums.iter().map(Complex64::norm_sqr).sum();
        let own: f64 = self.sums.iter().step_by(self.tracks + 1).map(Complex64::norm_sqr).sum();
        if own > 0.0 { all / own } else { 1.0 }
    }
}

/// Returns the correlation |Σ w² e^{−2πidj/n}/Σ w²|² of ordinates at the distances d = 1, 2, ….
fn neighbours(weights: &[f64], squares: f64) -> Vec<f64> {
    let n = weights.len() as f64;
    let at = |d: usize| {
        let (mut re, mut im) = (0.0, 0.0);
        for (j, w) in weights.iter().enumerate() {
            let phase = TAU * d as f64 * j as f64 / n;
            (re, im) = (re + w * w * phase.cos(), im + w * w * phase.sin());
        }
        (re * re + im * im) / (squares * squares)
    };
    (1..=REACH).map(at).collect()
}

fn spread(count: f64, kappa: &[f64]) -> f64 {
    let pairs = kappa.iter().enumerate().map(|(index, kappa)| 2.0 * (count - index as f64 - 1.0).max(0.0) * kappa);
    count + pairs.sum::<f64>()
}

impl RecordSpectrum {
    /// Returns the one-sided density in the bins for a model of the given length and variance under its window,
    /// including sampling: 2Δ Σ C(lΔ) cos(2πf lΔ).
    pub fn model_density(&self, model: &WindowedModel, length_m: f64, variance: f64) -> Vec<f64> {
        let lags = ((40.0 * length_m + model.window_m()) / self.step_m).ceil() as usize;
        let correlation: Vec<f64> =
            (0..=lags).map(|lag| model.correlation(lag as f64 * self.step_m, length_m)).collect();
        let at = |frequency: &f64| {
            let term = |(lag, rho): (usize, &f64)| {
                let fraction = if lag == 0 { 1.0 } else { 2.0 };
                fraction * rho * (TAU * frequency * lag as f64 * self.step_m).cos()
            };
            2.0 * self.step_m * variance * correlation.iter().enumerate().map(term).sum::<f64>()
        };
        self.frequency_per_m.iter().map(at).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::super::model::RecordModel;
    use super::*;
    use crate::random;
    use crate::stats::Moments;

    fn autoregressive(phi: f64, n: usize, index: u64) -> Vec<f64> {
        let noise = random::standard_normal(&mut random::stream(45, "record/spectrum", index), n);
        let mut last = noise[0];
        let next = |e: &f64| {
            last = phi * last + (1.0 - phi * phi).sqrt() * e;
            3.0 + last
        };
        noise.iter().map(next).collect()
    }

    #[test]
    fn densities_times_widths_are_the_variance_of_periodic_records() {
        for n in [100, 101] {
            let record = autoregressive(0.8, n, 0);
            let found = record_spectrum(&[&record], 1, 0.5, RecordEnds::Periodic).unwrap();
            let sum: f64 = found.density.iter().zip(&found.width_per_m).map(|(s, width)| s * width).sum();
            let moments = Moments::new(&record);
            assert!((sum / (moments.std * moments.std) - 1.0).abs() < 1e-12, "{n}");
            let last = found.frequency_per_m.len() - 1;
            assert!(found.frequency_per_m[last] < 1.0 && found.frequency_per_m[0] >= 1.0 / (n as f64 * 0.5) - 1e-12);
        }
    }

    #[test]
    fn bands_cover_the_spectrum_of_the_model() {
        // Sampled exponential, φ = e^{−Δ/ℓ}. 20 strips, 95 % bands: 93–97 % of all bins of 20 seeds.
        let (phi, step) = (0.9_f64, 2.0);
        let length = -step / phi.ln();
        let (mut inside, mut all) = (0_usize, 0);
        for seed in 0..20 {
            let strips: Vec<Vec<f64>> = (0..20).map(|strip| autoregressive(phi, 512, 1 + 20 * seed + strip)).collect();
            let views: Vec<&[f64]> = strips.iter().map(Vec::as_slice).collect();
            let found = record_spectrum(&views, 1, step, RecordEnds::Free).unwrap();
            let model = found.model_density(&WindowedModel::new(RecordModel::Exponential, 0.0), length, 1.0);
            for (bin, s) in model.iter().enumerate() {
                // Sum of the geometric series.
                let phase = TAU * found.frequency_per_m[bin] * step;
                let exact = 2.0 * step * (1.0 - phi * phi) / (1.0 - 2.0 * phi * phase.cos() + phi * phi);
                assert!((s / exact - 1.0).abs() < 1e-9);
                // The first two ordinates are reduced by the subtracted mean and the taper.
                if bin >= 2 {
                    all += 1;
                    inside += usize::from(found.low[bin] <= *s && *s <= found.high[bin]);
                }
            }
        }
        // Bins of one seed are independent, so 95 % has the standard error √(.95·.05/all), about .9 %; three of them.
        let fraction = inside as f64 / f64::from(all);
        assert!((fraction - 0.95).abs() < 0.03, "{fraction} of {all}");
    }
}
