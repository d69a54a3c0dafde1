//! Spectra averaged over blocks of wavevectors, for likelihood fits.

use std::f64::consts::TAU;

use crate::fourier::signed_index;
use crate::map::HeightMap;
use crate::stats::Extent;

use super::SpectrumRoute;
use super::area::AreaSpectrum;
use super::band::{ReliableBand, end_of_fall};
use crate::correlation::{Covariance, EstimateError};

/// Blocks per octave along each axis, where they contain a wavenumber each.
const PER_OCTAVE: f64 = 3.0;
/// Largest number of wavevectors per block at which a model is evaluated, for flat and for steep blocks; a steep block
/// needs more for its mean density.
const SAMPLES: usize = 6;
const SAMPLES_WHERE_STEEP: usize = 48;
/// Ratio of the mean densities of the inner and the outer half of a block above which it is steep.
const STEEP: f64 = 2.0;
/// Fraction of independent coefficients under a Hann window along both axes, (18/35)².
const INDEPENDENT: f64 = 0.264;
/// A band of less than one octave means a surface that is smooth on the scale of the map. Then the first wavenumbers
/// are used, up to this many steps, and densities below this fraction of the largest count as leakage of the window.
pub(super) const FIRST_STEPS: f64 = 4.0;
pub(super) const LEAKAGE: f64 = 1e-3;
/// Number of steps from zero beyond which the smoothing by the window is negligible.
const SMOOTHED_STEPS: f64 = 12.0;

/// Spectral density of a map, averaged over blocks of wavevectors within the reliable band and, if the spectrum rolls
/// off, beyond it: the roll-off is a property of a surface that is smooth on the scale of its pixels or was smoothed by
/// the instrument.
///
/// Blocks are rectangles in (|qx|, |qy|) with edges a third of an octave apart, which resolves narrow spectra along an
/// axis. Wavevectors (qx, qy) and (−qx, qy) share a block: the covariance models are even in x and in y.
#[derive(Debug, Clone, PartialEq)]
pub struct BlockSpectrum {
    blocks: Vec<Block>,
    /// Band of the radial spectrum.
    band: ReliableBand,
    /// Largest wavenumber in the blocks in rad/m.
    high_rad_per_m: f64,
    /// Steps of the wavenumbers along x and y in rad/m.
    step_rad_per_m: [f64; 2],
    pitch_m: [f64; 2],
    /// Half width of the window's smoothing in steps, and the weight of the spectrum at that distance on either side.
    smoothing: (f64, f64),
    slope_correlation: f64,
    /// Regularising density in m⁴, added to measured and expected densities.
    floor_m4: f64,
}

/// Block of wavevectors.
#[derive(Debug, Clone, PartialEq)]
#[doc(hidden)]
pub struct Block {
    /// Mean density in m⁴.
    pub density_m4: f64,
    /// Degrees of freedom of the mean.
    pub degrees_of_freedom: f64,
    /// Representative wavevectors of the block in rad/m.
    pub samples: Vec<[f64; 2]>,
}

impl BlockSpectrum {
    /// Creates the spectrum of a map from measured heights alone, because filled ones are smoother than the surface whose waves follow
    /// from it: a periodogram, or the correlogram of a map with voids.
    ///
    /// # Errors
    /// The heights present do not vary.
    pub fn new(map: &HeightMap) -> Result<Self, EstimateError> {
        /// Sums over the wavevectors of a block.
        #[derive(Clone, Default)]
        struct Sums {
            density: f64,
            count: f64,
            /// Wavevectors and their densities.
            places: Vec<([f64; 2], f64)>,
        }
        let spectrum = AreaSpectrum::unfilled(map, &Extent::new(map.values_m()))?;
        let radial = spectrum.radial();
        let band = radial.reliable;
        let grid = map.grid();
        let (nx, ny) = (grid.nx(), grid.ny());
        let (qx_min, qy_min, nyquist) = spectrum.wavenumbers();
        let is_short = band.high_rad_per_m < 2.0 * band.low_rad_per_m;
        let step = qx_min.max(qy_min);
        let (end, little_m4) = end_of_fall(&radial.q_rad_per_m, &radial.psd_m4, band, nyquist);
        let (low, high) =
            if is_short { (0.5 * step, end.max((FIRST_STEPS + 0.5) * step)) } else { (band.low_rad_per_m, end) };
        let high = high.min(0.5 * nyquist);
        let (edges_x, edges_y) = (edges(nx / 2), edges(ny / 2));
        let place_of = |edges: &[f64], k: f64| edges.partition_point(|edge| *edge <= k) - 1;
        let mut sums = vec![Sums::default(); edges_x.len() * edges_y.len()];
        // Products of slopes: xx, xy, yy.
        let mut slopes = [0.0; 3];
        for (kx, column) in spectrum.psd_m4.chunks_exact(ny).enumerate() {
            let times = if kx == 0 || 2 * kx == nx { 1.0 } else { 2.0 };
            let (qx, block_x) = (kx as f64 * qx_min, place_of(&edges_x, kx as f64));
            for (ky, density) in column.iter().enumerate() {
                let ky = signed_index(ky, ny);
                let qy = ky * qy_min;
                let q = qx.hypot(qy);
                if q < low || q > high {
                    continue;
                }
                let block = &mut sums[block_x * edges_y.len() + place_of(&edges_y, ky.abs())];
                block.density += times * density;
                block.count += times;
                block.places.push(([qx, qy.abs()], *density));
                // The zone boundary is its own opposite, with an undefined sign.
                let both = if kx == 0 || 2 * kx == nx { 0.0 } else { 1.0 };
                for (sum, product) in slopes.iter_mut().zip([qx * qx, both * qx * qy, qy * qy]) {
                    *sum += times * density * product;
                }
            }
        }
        let largest =
            sums.iter().filter(|sums| sums.count > 0.0).map(|sums| sums.density / sums.count).fold(0.0, f64::max);
        let floor_m4 = if is_short { LEAKAGE * largest } else { little_m4 };
        let block = |sums: Sums| {
            let half = sums.places.len() / 2;
            let mut outward = sums.places.clone();
            outward.sort_by(|(a, _), (b, _)| a[0].hypot(a[1]).total_cmp(&b[0].hypot(b[1])));
            let total = |places: &[([f64; 2], f64)]| places.iter().map(|(_, density)| density).sum::<f64>();
            let is_steep = half > 0 && total(&outward[..half]) > STEEP * total(&outward[outward.len() - half..]);
            let most = if is_steep { SAMPLES_WHERE_STEEP } else { SAMPLES };
            let stride = sums.places.len().div_ceil(most).max(1);
            Block {
                density_m4: sums.density / sums.count + floor_m4,
                degrees_of_freedom: (INDEPENDENT * sums.count).max(1.0),
                samples: sums.places.into_iter().skip(stride / 2).step_by(stride).map(|(q, _)| q).collect(),
            }
        };
        Ok(Self {
            blocks: sums.into_iter().map(block).filter(|block| block.density_m4 > 0.0).collect(),
            floor_m4,
            band,
            high_rad_per_m: high,
            step_rad_per_m: [qx_min, qy_min],
            pitch_m: [grid.dx_m(), grid.dy_m()],
            smoothing: match spectrum.route {
                // Second moments of the kernels: 1/3 and 12/π² squared steps.
                SpectrumRoute::Periodogram => (1.0, 1.0 / 6.0),
                SpectrumRoute::MaskedCorrelogram => (2.0, 0.152),
            },
            slope_correlation: slopes[1] / (slopes[0] * slopes[2]).sqrt(),
        })
    }

    /// Returns the reliable band of the radial spectrum.
    pub fn reliable(&self) -> ReliableBand {
        self.band
    }

    /// Returns the length in metre of the shortest wave that the map resolves: the end of its reliable band or, if the spectrum
    /// rolls off, the wave at which a thousandth of the density is left.
    pub fn shortest_wave_m(&self) -> f64 {
        TAU / self.high_rad_per_m
    }

    /// Returns the correlation of the slopes along x and y within the band; far from zero for an oblique texture.
    pub fn slope_correlation(&self) -> f64 {
        self.slope_correlation
    }

    /// Returns the sides of the map in metre.
    #[doc(hidden)]
    pub fn size_m(&self) -> [f64; 2] {
        self.step_rad_per_m.map(|step| TAU / step)
    }

    /// Pitches in metre.
    #[doc(hidden)]
    pub fn pitch_m(&self) -> [f64; 2] {
        self.pitch_m
    }

    #[doc(hidden)]
    pub fn blocks(&self) -> &[Block] {
        &self.blocks
    }

    /// Returns the expected density in m⁴ of a block for a map of this covariance, including aliasing and smoothing by
    /// the window.
    #[doc(hidden)]
    pub fn expected_m4(&self, block: &Block, covariance: &Covariance) -> f64 {
        let sum: f64 = block.samples.iter().map(|q| self.smoothed_m4(*q, covariance)).sum();
        sum / block.samples.len() as f64 + self.floor_m4
    }

    fn smoothed_m4(&self, q: [f64; 2], covariance: &Covariance) -> f64 {
        /// Number of images on either side.
        const IMAGES: i32 = 2;

        const ALONE: &[(f64, f64)] = &[(0.0, 1.0)];

        let (distance, weight) = self.smoothing;
        let shifts = self
            .step_rad_per_m
            .map(|step| [(0.0, 1.0 - 2.0 * weight), (-distance * step, weight), (distance * step, weight)]);
        let is_near = |axis: usize| q[axis] <= SMOOTHED_STEPS * distance * self.step_rad_per_m[axis];
        let smoothing = [0, 1].map(|axis| if is_near(axis) { &shifts[axis][..] } else { ALONE });
        let zone = self.pitch_m.map(|pitch_m| TAU / pitch_m);
        let image = |[i, j]: [i32; 2], [along_x, along_y]: [&[(f64, f64)]; 2]| {
            let [x, y] = [q[0] + f64::from(i) * zone[0], q[1] + f64::from(j) * zone[1]];
            let mut sum = 0.0;
            for (dx, wx) in along_x {
                for (dy, wy) in along_y {
                    sum += wx * wy * covariance.psd_m4(x + dx, y + dy);
                }
            }
            sum
        };
        let own = image([0, 0], smoothing);
        // The first image is the largest; if it is negligible, so are the others.
        let nearest = covariance.psd_m4(zone[0] - q[0].abs(), q[1]) + covariance.psd_m4(q[0], zone[1] - q[1].abs());
        if nearest < 1e-3 * own {
            return own;
        }
        let mut sum = own;
        for i in -IMAGES..=IMAGES {
            for j in -IMAGES..=IMAGES {
                // Of the aliases, only the nearest vary over the width of the window, along the axis that they are not shifted along.
                sum += match [i, j] {
                    [0, 0] => 0.0,
                    [0, -1 | 1] => image([i, j], [smoothing[0], ALONE]),
                    [-1 | 1, 0] => image([i, j], [ALONE, smoothing[1]]),
                    _ => image([i, j], [ALONE; 2]),
                };
            }
        }
        sum
    }
}

/// Returns the lower edges of the blocks along an axis, from wavenumber 0 to `last`.
pub(super) fn edges(last: usize) -> Vec<f64> {
    let ratio = (1.0 / PER_OCTAVE).exp2();
    let mut edges = vec![0.0, 0.5];
    let mut edge: f64 = 0.5;
    while edge < last as f64 {
        edge = (edge + 1.0).max((edge * ratio).round() + 0.5);
        edges.push(edge);
    }
    edges
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::correlation::CorrelationModel;
    use crate::map::Grid;

    /// Returns the density with aliases that the window smooths, too.
    fn smoothed_with_aliases(spectrum: &BlockSpectrum, q: [f64; 2], covariance: &Covariance) -> f64 {
        let (distance, weight) = spectrum.smoothing;
        let weights = |axis: usize| {
            let step = distance * spectrum.step_rad_per_m[axis];
            if q[axis] > SMOOTHED_STEPS * step {
                vec![(0.0, 1.0)]
            } else {
                vec![(-step, weight), (0.0, 1.0 - 2.0 * weight), (step, weight)]
            }
        };
        let zone = spectrum.pitch_m.map(|pitch_m| TAU / pitch_m);
        let mut sum = 0.0;
        for (dx, wx) in weights(0) {
            for (dy, wy) in weights(1) {
                for place in 0..25 {
                    let [i, j] = [place / 5, place % 5].map(|image| f64::from(image - 2));
                    sum += wx * wy * covariance.psd_m4(q[0] + dx + i * zone[0], q[1] + dy + j * zone[1]);
                }
            }
        }
        sum
    }

    #[test]
    fn aliases_are_smoothed_along_an_axis_that_they_are_not_shifted_along() {
        let grid = Grid::new(64, 96, 1e-6, 1.5e-6).unwrap();
        let map = HeightMap::from_function(grid, |x, y| (3e5 * x).sin() + (2e5 * y + 1e5 * x).cos()).unwrap();
        let spectrum = BlockSpectrum::new(&map).unwrap();
        for model in [CorrelationModel::Exponential, CorrelationModel::SelfAffine { hurst: 0.3 }] {
            for [x_m, y_m] in [[5e-6, 5e-6], [30e-6, 3e-6], [2e-6, 40e-6]] {
                let covariance = Covariance::new(model, 1e-6, x_m, y_m).unwrap();
                for place in 0..200 {
                    let [kx, ky] = [place / 15 * 3, place % 15 * 4].map(f64::from);
                    let q = [kx * spectrum.step_rad_per_m[0], ky * spectrum.step_rad_per_m[1]];
                    let found = spectrum.smoothed_m4(q, &covariance);
                    let exact = smoothed_with_aliases(&spectrum, q, &covariance);
                    // Where they are left out, aliases are together a few thousandths.
                    assert!((found / exact - 1.0).abs() < 4e-3, "{model:?} {x_m} {y_m} at {q:?}: {found:e}, {exact:e}");
                }
            }
        }
    }
}
