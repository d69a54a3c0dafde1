//! Spectra of profiles averaged over blocks of wavenumbers, for likelihood fits.

use std::f64::consts::{PI, TAU};

use super::band::end_of_fall;
use super::blocks::{FIRST_STEPS, LEAKAGE, edges};
use super::{ProfileSpectrum, ReliableBand, SpectrumRoute};
use crate::correlation::Covariance;

/// Fraction of independent ordinates under a Hann window, 18/35, times the two degrees of freedom of an ordinate.
const DEGREES: f64 = 2.0 * 18.0 / 35.0;
/// Number of aliases on either side.
const IMAGES: i32 = 2;

/// Spectral density of a profile, averaged over blocks of a third of an octave within the reliable band and, if the spectrum rolls off,
/// beyond it, as [`BlockSpectrum`](super::BlockSpectrum) is of a map.
#[derive(Debug, Clone, PartialEq)]
pub(in crate::correlation) struct LineBlocks {
    blocks: Vec<Block>,
    pub(in crate::correlation) band: ReliableBand,
    pub(in crate::correlation) pitch_m: f64,
    step_rad_per_m: f64,
    /// Half width of the window's smoothing in steps, and the weight of the spectrum at that distance on either side.
    smoothing: (f64, f64),
    /// Regularising density in m³, added to measured and expected densities.
    floor_m3: f64,
    /// Largest wavenumber in the blocks in rad/m.
    pub(in crate::correlation) high_rad_per_m: f64,
}

#[derive(Debug, Clone, PartialEq)]
struct Block {
    density_m3: f64,
    wavenumbers: Vec<f64>,
}

impl LineBlocks {
    pub(in crate::correlation) fn new(spectrum: &ProfileSpectrum, pitch_m: f64) -> Self {
        let ProfileSpectrum { q_rad_per_m, psd_m3, route, reliable: band, .. } = spectrum;
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
                wavenumbers: block.into_iter().map(|k| q_rad_per_m[k]).collect(),
            })
            .collect();
        let largest = blocks.iter().map(|block| block.density_m3).fold(0.0, f64::max);
        let floor_m3 = if is_short { LEAKAGE * largest } else { little_m3 };
        let blocks = blocks.into_iter().map(|block| Block { density_m3: block.density_m3 + floor_m3, ..block });
        Self {
            blocks: blocks.filter(|block| block.density_m3 > 0.0).collect(),
            band: *band,
            pitch_m,
            step_rad_per_m: step,
            smoothing: match route {
                SpectrumRoute::Periodogram => (1.0, 1.0 / 6.0),
                SpectrumRoute::MaskedCorrelogram => (2.0, 0.152),
            },
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
        self.blocks.iter().map(|block| (block.density_m3, (DEGREES * block.wavenumbers.len() as f64).max(1.0)))
    }

    /// Returns the density in m³ that a profile of this covariance is expected to have in a block, with aliasing and smoothing by the window.
    pub(in crate::correlation) fn expected_m3(&self, block: usize, covariance: &Covariance) -> f64 {
        let (distance, weight) = self.smoothing;
        let (shift, zone) = (distance * self.step_rad_per_m, TAU / self.pitch_m);
        let psd = |q: f64| covariance.profile_psd_x_m3(q.abs());
        let smooth = |q: f64| (1.0 - 2.0 * weight) * psd(q) + weight * (psd(q - shift) + psd(q + shift));
        let folded = |q: &f64| (-IMAGES..=IMAGES).map(|image| smooth(q + f64::from(image) * zone)).sum::<f64>();
        let wavenumbers = &self.blocks[block].wavenumbers;
        wavenumbers.iter().map(folded).sum::<f64>() / wavenumbers.len() as f64 + self.floor_m3
    }
}
