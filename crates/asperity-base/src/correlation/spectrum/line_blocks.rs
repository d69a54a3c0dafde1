//! Spectra of profiles averaged over blocks of wavenumbers, for likelihood fits.

use std::f64::consts::{PI, TAU};

use super::band::end_of_fall;
use super::blocks::{FIRST_STEPS, LEAKAGE, edges};
use super::{ProfileSpectrum, ReliableBand, SpectrumRoute, hann, parzen};
use crate::correlation::Covariance;
use crate::fourier::{good_length, lag_sums_of_power, real_transform, summed_power};

/// Fraction of independent ordinates under a Hann window, 18/35, times the two degrees of freedom of an ordinate.
const DEGREES: f64 = 2.0 * 18.0 / 35.0;
/// Fraction of the largest density below which a density is rounding.
const ROUNDING: f64 = 1e-13;

/// Spectral density of a profile, averaged over blocks of a third of an octave within the reliable band and, if the spectrum rolls off,
/// beyond it, as [`BlockSpectrum`](super::BlockSpectrum) is of a map.
#[derive(Debug, Clone, PartialEq)]
pub(in crate::correlation) struct LineBlocks {
    blocks: Vec<Block>,
    pub(in crate::correlation) band: ReliableBand,
    pub(in crate::correlation) pitch_m: f64,
    step_rad_per_m: f64,
    /// Weights of the covariance at the lags of the profile under the window.
    lag_weights: Vec<f64>,
    /// Regularising density in m³, added to measured and expected densities.
    floor_m3: f64,
    /// Largest wavenumber in the blocks in rad/m.
    pub(in crate::correlation) high_rad_per_m: f64,
}

#[derive(Debug, Clone, PartialEq)]
struct Block {
    density_m3: f64,
    /// Places in the spectrum.
    places: Vec<usize>,
}

impl LineBlocks {
    pub(in crate::correlation) fn new(spectrum: &ProfileSpectrum, pitch_m: f64) -> Self {
        let ProfileSpectrum { q_rad_per_m, psd_m3, route, reliable: band, .. } = spectrum;
        // A spectrum of n points has the wavenumbers up to n/2, the last of which is Nyquist's for even n.
        let points = (TAU / (q_rad_per_m.get(1).copied().unwrap_or(f64::INFINITY) * pitch_m)).round() as usize;
        let (step, nyquist) = (q_rad_per_m.get(1).copied().unwrap_or(f64::INFINITY), PI / pitch_m);
        let is_short = band.high_rad_per_m < 2.0 * band.low_rad_per_m;
        let (end, little_m3) = end_of_fall(q_rad_per_m, psd_m3, *band, nyquist);
        let (low, high) =
            if is_short { (0.5 * step, end.max((FIRST_STEPS + 0.5) * step)) } else { (band.low_rad_per_m, end) };
        let high = high.min(0.5 * nyquist);
        let within = |k: usize| (low..=high).contains(&q_rad_per_m[k]);
        let edges = edges(q_rad_per_m.len());
        let blocks: Vec<Block> = edges
            .windows(2)
            .map(|pair| {
                (pair[0].ceil() as usize..q_rad_per_m.len().min(pair[1].ceil() as usize)).filter(|k| within(*k))
            })
            .map(Iterator::collect::<Vec<usize>>)
            .filter(|block| !block.is_empty())
            .map(|block| Block {
                density_m3: block.iter().map(|k| psd_m3[*k]).sum::<f64>() / block.len() as f64,
                places: block,
            })
            .collect();
        let largest = blocks.iter().map(|block| block.density_m3).fold(0.0, f64::max);
        let floor_m3 = if is_short { LEAKAGE * largest } else { little_m3.max(ROUNDING * largest) };
        let blocks = blocks.into_iter().map(|block| Block { density_m3: block.density_m3 + floor_m3, ..block });
        Self {
            blocks: blocks.filter(|block| block.density_m3 > 0.0).collect(),
            band: *band,
            pitch_m,
            step_rad_per_m: step,
            lag_weights: lag_weights(*route, points),
            floor_m3,
            high_rad_per_m: high,
        }
    }

    /// Returns the length of the profile in metre.
    pub(in crate::correlation) fn length_m(&self) -> f64 {
        TAU / self.step_rad_per_m
    }

    /// Returns the density in m³ and the degrees of freedom of each block.
    pub(in crate::correlation) fn measured(&self) -> impl Iterator<Item = (f64, f64)> {
        self.blocks.iter().map(|block| (block.density_m3, (DEGREES * block.places.len() as f64).max(1.0)))
    }

    /// Returns the densities in m³ that a profile of this covariance is expected to have in the blocks: the transform of the covariance
    /// under the window, with its smoothing, its leakage and the aliases of the sampling.
    pub(in crate::correlation) fn expected_m3(&self, covariance: &Covariance) -> Vec<f64> {
        let points = self.lag_weights.len();
        let weighted = |lag: usize| match self.lag_weights[lag] {
            0.0 => 0.0,
            weight => weight * covariance.value_m2(lag as f64 * self.pitch_m, 0.0),
        };
        let weighted: Vec<f64> = (0..points).map(weighted).collect();
        // Lags l and l − n have the same phase.
        let folded = |lag: usize| if lag == 0 { weighted[0] } else { weighted[lag] + weighted[points - lag] };
        let density = real_transform(&(0..points).map(folded).collect::<Vec<f64>>());
        let mean = |block: &Block| {
            let sum: f64 = block.places.iter().map(|place| density[*place].max(0.0)).sum();
            self.pitch_m * sum / block.places.len() as f64 + self.floor_m3
        };
        self.blocks.iter().map(mean).collect()
    }
}

/// Returns the weight of the covariance at each lag in the expectation of a spectrum of `points` heights.
fn lag_weights(route: SpectrumRoute, points: usize) -> Vec<f64> {
    match route {
        SpectrumRoute::Periodogram => {
            let (window, padded) = (hann(points), good_length(2 * points));
            let power = summed_power(1, points, padded, |_, out| out.copy_from_slice(&window));
            let sums = lag_sums_of_power(&power, padded);
            sums[..points].iter().map(|sum| sum / sums[0]).collect()
        }
        SpectrumRoute::MaskedCorrelogram => {
            let end = points.div_ceil(2);
            (0..points).map(|lag| parzen(lag as f64 / end as f64)).collect()
        }
    }
}
