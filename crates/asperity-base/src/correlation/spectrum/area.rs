//! Two-dimensional spectra of maps, averaged over rings or along rays.

use std::f64::consts::{PI, TAU};

use crate::blocks;
use crate::correlation::{Autocorrelation, EstimateError, SpectrumRoute};
use crate::fourier::{RealFft2, power, signed_index};
use crate::map::{Grid, HeightMap};
use crate::stats::Extent;

use super::band::ReliableBand;
use super::filled::{Filled, filled};
use super::{hann, parzen};

/// Wavenumbers along x whose rings are summed per task.
const COLUMNS: usize = 16;
/// Density that filled voids may add, relative to the least density of a ring at which the spectrum shows the surface.
const SCATTER: f64 = 0.05;
/// Number of rays over half a turn, and of neighbours on either side in the smoothing of the angular spectrum: ±1°.
const RAYS: usize = 360;
const SMOOTHED: isize = 2;

/// Two-dimensional power spectral density of a map: P(q) in m⁴, two-sided, the variance is ∬ P d²q/(2π)².
#[derive(Debug, Clone)]
pub struct AreaSpectrum {
    pub(super) grid: Grid,
    /// In the layout of the spectrum of [`RealFft2`], kx = 0 … nx/2 by ky.
    pub(super) psd_m4: Vec<f64>,
    pub(super) route: SpectrumRoute,
}

/// Radially averaged two-dimensional power spectral density.
#[derive(Debug, Clone, PartialEq)]
pub struct RadialSpectrum {
    /// Mean |q| of each ring in rad/m; rings are 2π/min(Lx, Ly) wide and end at the lesser Nyquist wavenumber.
    pub q_rad_per_m: Vec<f64>,
    /// Mean two-sided power spectral density P(q) on the ring in m⁴.
    pub psd_m4: Vec<f64>,
    /// Number of wavevectors on each ring.
    pub wavevectors: Vec<usize>,
    /// Variance in m² of the wavevectors on no ring: those in the corners beyond the last ring and, below the first, the mean and the
    /// longest waves of an oblong map.
    ///
    /// Together with the sum over the rings of `wavevectors`·`psd_m4`/(LxLy) it is the windowed mean square Σ w²z²/Σw² of a complete
    /// map, z being relative to the mean, also of filled voids, and of a correlogram the variance of the present heights.
    pub corners_m2: f64,
    /// Estimator of the spectrum.
    pub route: SpectrumRoute,
    /// Reliable wavenumbers.
    pub reliable: ReliableBand,
}

/// Angular power density: distribution of the variance over the directions of the crests.
#[derive(Debug, Clone, PartialEq)]
pub struct AngularSpectrum {
    /// Directions of the crests in rad, in [0, π), counter-clockwise from x with row 0 at the top.
    pub angles_rad: Vec<f64>,
    /// ∫ P(q) q dq/(2π)² over the wavevectors normal to that direction, of both signs, in m² per rad; the integral over
    /// half a turn is the variance between the two wavenumbers.
    pub density_m2: Vec<f64>,
    /// Range of wavenumbers of the integral in rad/m: the resolution of the spectrum, and the smaller Nyquist
    /// wavenumber, so that all directions have the same range.
    pub range_rad_per_m: (f64, f64),
}

impl AngularSpectrum {
    /// Returns the direction of the texture in rad, in [0, π): the centroid of the largest peak, smoothed over ±1°,
    /// above half its height. For a single wave with k periods across the field the error is less than 0.2/k rad.
    ///
    /// Every map has such a maximum; the texture aspect ratio Str decides whether the texture is directional.
    pub fn direction_rad(&self) -> f64 {
        let n = self.density_m2.len() as isize;
        let around = |ray: isize| (ray - SMOOTHED..=ray + SMOOTHED).map(|k| self.density_m2[k.rem_euclid(n) as usize]);
        let smooth: Vec<f64> = (0..n).map(|ray| around(ray).sum()).collect();
        let top = (0..n).max_by(|a, b| smooth[*a as usize].total_cmp(&smooth[*b as usize]).then(b.cmp(a))).unwrap_or(0);
        let above = |k: isize| smooth[(top + k).rem_euclid(n) as usize] - 0.5 * smooth[top as usize];
        // Weights that vanish at the edges of the peak make the centroid continuous.
        let side = |sign: isize| (1..n / 2).map(move |k| sign * k).take_while(|k| above(*k) > 0.0);
        let (moment, weight) =
            side(1).chain(side(-1)).fold((0.0, above(0)), |(m, w), k| (m + k as f64 * above(k), w + above(k)));
        let shift = if weight > 0.0 { moment / weight } else { 0.0 };
        ((top as f64 + shift) * PI / n as f64).rem_euclid(PI)
    }
}

/// Returns the radially averaged power spectral density of a map; the estimator depends on the voids and is part of the result.
///
/// # Errors
/// The heights do not vary.
pub fn radial_spectrum(map: &HeightMap) -> Result<RadialSpectrum, EstimateError> {
    Ok(AreaSpectrum::new(map)?.radial())
}

impl AreaSpectrum {
    /// Creates the spectrum of a map: a periodogram |Σ w z e^{−iq·x}|² ΔxΔy/Σw² under a Hann window along x and y, also if voids are small:
    /// they are filled by solutions of Laplace's equation, if the errors of the filled heights add less than 5 % to the density of every
    /// reliable ring. Otherwise it is the transform of the autocovariance under a Parzen window, see
    /// [`SpectrumRoute::MaskedCorrelogram`].
    ///
    /// # Errors
    /// The heights do not vary.
    pub fn new(map: &HeightMap) -> Result<Self, EstimateError> {
        Self::with_extent(map, &Extent::new(map.values_m()))
    }

    /// Creates as [`AreaSpectrum::new`] with a known extent of the heights.
    #[doc(hidden)]
    pub fn with_extent(map: &HeightMap, extent: &Extent) -> Result<Self, EstimateError> {
        let has_voids = extent.n < map.grid().points();
        let filled = if has_voids { Self::of_small_voids(map, extent.mean) } else { None };
        filled.map_or_else(|| Self::unfilled(map, extent), Ok)
    }

    /// Creates as [`AreaSpectrum::new`] from measured heights alone: a correlogram if there are voids of any size.
    pub(super) fn unfilled(map: &HeightMap, extent: &Extent) -> Result<Self, EstimateError> {
        if extent.largest_deviation() <= 4.0 * f64::EPSILON * extent.mean.abs() {
            return Err(EstimateError::Constant { present: extent.n });
        }
        if extent.n < map.grid().points() {
            return Ok(Self::from_correlation(&Autocorrelation::estimate(map)?));
        }
        Ok(Self::periodogram(map.grid(), map.values_m(), extent.mean))
    }

    /// Creates the periodogram of a map whose voids are small enough to be filled; see [`AreaSpectrum::new`].
    #[doc(hidden)]
    pub fn of_small_voids(map: &HeightMap, mean_m: f64) -> Option<Self> {
        let Filled { heights_m, scatter_m4 } = filled(map)?;
        let found = Self::periodogram(map.grid(), &heights_m, mean_m);
        let RadialSpectrum { q_rad_per_m, psd_m4, reliable, .. } = found.radial();
        let band = reliable.low_rad_per_m..=reliable.high_rad_per_m;
        let rings = q_rad_per_m.iter().zip(&psd_m4).filter(|(q, _)| band.contains(q));
        let least_m4 = rings.map(|(_, density)| *density).fold(f64::INFINITY, f64::min);
        (scatter_m4 <= SCATTER * least_m4).then_some(found)
    }

    fn periodogram(grid: Grid, heights_m: &[f64], mean_m: f64) -> Self {
        let (ny, nx) = grid.shape();
        let (window_x, window_y) = (hann(nx), hann(ny));
        let square = |window: &[f64]| window.iter().map(|w| w * w).sum::<f64>();
        let norm = (grid.cell_area_m2() / (square(&window_x) * square(&window_y))).sqrt();
        let psd_m4 = power(nx, ny, |row, out| {
            let heights = &heights_m[row * nx..(row + 1) * nx];
            let weight = norm * window_y[row];
            for ((out, z), w) in out.iter_mut().zip(heights).zip(&window_x) {
                *out = weight * w * (z - mean_m);
            }
        });
        Self { grid, psd_m4, route: SpectrumRoute::Periodogram }
    }

    /// Creates the spectrum ΔxΔy Σ w(lag) C(lag) e^{−iq·lag} of an autocovariance, over its lags up to half the field
    /// with at least one pair, where w is the product of Parzen windows along x and y that end there.
    ///
    /// An autocovariance up to half the field gives the resolution of [`SpectrumRoute::MaskedCorrelogram`].
    #[doc(hidden)]
    pub fn from_correlation(correlation: &Autocorrelation) -> Self {
        Self::from_lags(correlation, |lag_x, lag_y| correlation.covariance_m2(lag_x, lag_y))
    }

    /// Creates as [`AreaSpectrum::from_correlation`] from the products normalised by all heights present instead of the
    /// pairs of a lag: the smoothed mean periodogram of the map with missing points set to zero. It includes the power
    /// that missing points scatter into every wavevector, and is non-negative.
    pub(super) fn with_scatter(correlation: &Autocorrelation) -> Self {
        let present = correlation.present() as f64;
        Self::from_lags(correlation, |lag_x, lag_y| {
            correlation.covariance_m2(lag_x, lag_y) * correlation.pairs(lag_x, lag_y) / present
        })
    }

    fn from_lags(correlation: &Autocorrelation, covariance_m2: impl Fn(isize, isize) -> f64 + Sync) -> Self {
        let grid = correlation.grid();
        let (ny, nx) = grid.shape();
        let (reach_x, reach_y) = correlation.reach();
        let (half_x, half_y) = (reach_x.min((nx - 1) / 2) as isize, reach_y.min((ny - 1) / 2) as isize);
        let weights = |half: isize| (0..=half).map(|lag| parzen(lag as f64 / (half + 1) as f64)).collect::<Vec<f64>>();
        let (weights_x, weights_y) = (weights(half_x), weights(half_y));
        let mut lags = vec![0.0; nx * ny];
        blocks::for_each(lags.chunks_exact_mut(nx).enumerate(), |(row, out)| {
            let lag_y = signed_index(row, ny) as isize;
            if lag_y.abs() > half_y {
                return;
            }
            for lag_x in -half_x..=half_x {
                let covariance = covariance_m2(lag_x, lag_y);
                if !covariance.is_nan() {
                    let weight = weights_x[lag_x.unsigned_abs()] * weights_y[lag_y.unsigned_abs()];
                    out[lag_x.rem_euclid(nx as isize) as usize] = weight * covariance * grid.cell_area_m2();
                }
            }
        });
        let fft = RealFft2::new(nx, ny);
        let mut spectrum = fft.spectrum();
        fft.forward(&lags, &mut spectrum, &mut fft.workspace());
        let psd_m4 = spectrum.iter().map(|value| value.re).collect();
        Self { grid, psd_m4, route: SpectrumRoute::MaskedCorrelogram }
    }

    /// Steps 2π/Lx and 2π/Ly, and the smaller Nyquist wavenumber, in rad/m.
    pub(super) fn wavenumbers(&self) -> (f64, f64, f64) {
        let grid = self.grid;
        (TAU / grid.width_m(), TAU / grid.height_m(), (PI / grid.dx_m()).min(PI / grid.dy_m()))
    }

    /// Returns the means over rings of wavevectors.
    pub fn radial(&self) -> RadialSpectrum {
        let (nx, ny) = (self.grid.nx(), self.grid.ny());
        let (qx_min, qy_min, nyquist) = self.wavenumbers();
        let width = qx_min.max(qy_min);
        let rings = (nyquist / width).floor() as usize;
        let rows: Vec<f64> = (0..ny).map(|ky| (signed_index(ky, ny) * qy_min / width).powi(2)).collect();
        // Sums of |q|, of the density and of wavevectors for every ring. Ring m covers wavenumbers from m + ½ to m +
        // 3/2 ring widths, centred on whole ones.
        let blocks: Vec<Vec<[f64; 3]>> = blocks::map(0..(nx / 2 + 1).div_ceil(COLUMNS), |block| {
            let mut sums = vec![[0.0; 3]; rings + 2];
            let columns = &self.psd_m4[block * COLUMNS * ny..];
            for (kx, column) in (block * COLUMNS..).zip(columns.chunks_exact(ny).take(COLUMNS)) {
                let weight = if kx == 0 || 2 * kx == nx { 1.0 } else { 2.0 };
                let square_x = (kx as f64 * qx_min / width).powi(2);
                for (psd, square_y) in column.iter().zip(&rows) {
                    let magnitude = (square_x + square_y).sqrt();
                    // An extra ring before the first and after the last for the wavenumbers outside.
                    let ring = ((magnitude + 0.5) as usize).min(rings + 1);
                    let [q, density, count] = &mut sums[ring];
                    *q += weight * magnitude;
                    *density += weight * psd;
                    *count += weight;
                }
            }
            sums
        });
        let mut sums = vec![[0.0; 3]; rings + 2];
        for block in blocks {
            sums.iter_mut().zip(block).for_each(|(sum, part)| (0..3).for_each(|i| sum[i] += part[i]));
        }
        let kept: Vec<[f64; 3]> = sums[1..=rings].iter().copied().filter(|[_, _, count]| *count > 0.0).collect();
        let q_rad_per_m: Vec<f64> = kept.iter().map(|[q, _, count]| width * q / count).collect();
        let psd_m4: Vec<f64> = kept.iter().map(|[_, density, count]| density / count).collect();
        let reliable = ReliableBand::from_area(&q_rad_per_m, &psd_m4, self.route.resolution() * width, nyquist);
        let wavevectors = kept.iter().map(|[_, _, count]| *count as usize).collect();
        let corners_m2 = (sums[0][1] + sums[rings + 1][1]) / self.grid.area_m2();
        RadialSpectrum { q_rad_per_m, psd_m4, wavevectors, corners_m2, route: self.route, reliable }
    }

    /// Returns the integrals along rays of wavevectors; `None` if the map is too small for a wavenumber between the
    /// resolution and the Nyquist wavenumber.
    ///
    /// The density is interpolated bilinearly between wavevectors and summed at half steps, which avoids the lattice
    /// bias of angular bins along the axes.
    pub fn angular(&self) -> Option<AngularSpectrum> {
        let (qx_min, qy_min, nyquist) = self.wavenumbers();
        let (low, high) = (self.route.resolution() * qx_min.max(qy_min), nyquist);
        let step = 0.5 * qx_min.min(qy_min);
        let samples = ((high - low) / step).floor();
        if samples < 2.0 {
            return None;
        }
        let angles_rad: Vec<f64> = (0..RAYS).map(|ray| PI * ray as f64 / RAYS as f64).collect();
        let density_m2 = blocks::map(0..RAYS, |ray| {
            let angle = angles_rad[ray];
            // Normal to a crest at `angle`; y points down in the map.
            let (x, y) = (angle.sin() / qx_min, angle.cos() / qy_min);
            let sum: f64 = (0..samples as usize)
                .map(|sample| low + (sample as f64 + 0.5) * step)
                .map(|q| q * self.interpolated(q * x, q * y))
                .sum();
            // Both signs of q contribute.
            2.0 * sum * step / (TAU * TAU)
        });
        Some(AngularSpectrum { angles_rad, density_m2, range_rad_per_m: (low, high) })
    }

    /// Returns the density at a wavevector in steps along x ≥ 0 and y, interpolated bilinearly.
    fn interpolated(&self, kx: f64, ky: f64) -> f64 {
        let ny = self.grid.ny();
        let (left, below) = (kx.floor(), ky.floor());
        let (along_x, along_y) = (kx - left, ky - below);
        let left = left as usize;
        let right = (left + 1).min(self.grid.nx() / 2);
        let below = (below as isize).rem_euclid(ny as isize) as usize;
        let above = if below + 1 == ny { 0 } else { below + 1 };
        let at = |kx: usize| {
            let (low, high) = (self.psd_m4[kx * ny + below], self.psd_m4[kx * ny + above]);
            low + along_y * (high - low)
        };
        let (low, high) = (at(left), at(right));
        low + along_x * (high - low)
    }

    /// Returns the wavelength of the largest density in metre, among the wavevectors above the resolution; the first of
    /// equal ones.
    pub fn dominant_wavelength_m(&self) -> Option<f64> {
        let ny = self.grid.ny();
        let square = |k: f64| (k / self.route.resolution()).powi(2);
        let rows: Vec<f64> = (0..ny).map(|ky| square(signed_index(ky, ny))).collect();
        let tops: Vec<(f64, usize, usize)> = blocks::map(0..self.psd_m4.len() / ny, |kx| {
            let column = &self.psd_m4[kx * ny..(kx + 1) * ny];
            let square_x = square(kx as f64);
            let mut top = (0.0, kx, 0);
            for (ky, (psd, square_y)) in column.iter().zip(&rows).enumerate() {
                if *psd > top.0 && square_x + square_y >= 1.0 {
                    top = (*psd, kx, ky);
                }
            }
            top
        });
        let (psd, kx, ky) = tops.into_iter().reduce(|a, b| if b.0 > a.0 { b } else { a })?;
        let (qx_min, qy_min, _) = self.wavenumbers();
        (psd > 0.0).then(|| TAU / (kx as f64 * qx_min).hypot(signed_index(ky, ny) * qy_min))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::random;
    use ndarray::Array2;

    /// Returns a wave with `periods` crests across 128 points at `angle`, counter-clockwise with row 0 at the top.
    fn crests(grid: Grid, angle: f64, periods: f64) -> HeightMap {
        let q = TAU * periods / grid.height_m();
        HeightMap::from_function(grid, |x, y| (q * (x * angle.sin() + y * angle.cos())).cos()).unwrap()
    }

    fn direction(map: &HeightMap) -> f64 {
        AreaSpectrum::new(map).unwrap().angular().unwrap().direction_rad()
    }

    fn turned(found: f64, wanted: f64) -> f64 {
        (found - wanted + 0.5 * PI).rem_euclid(PI) - 0.5 * PI
    }

    #[test]
    fn a_map_that_rises_to_the_upper_right_has_a_direction_below_a_right_angle() {
        // Row 0 is the top: crests x + y = const, with rows counted downwards, rise to the right.
        let grid = Grid::new(96, 96, 1.0, 1.0).unwrap();
        let map = HeightMap::from_function(grid, |x, y| ((x + y) / 3.0).sin()).unwrap();
        assert!((direction(&map) - 0.25 * PI).abs() < 0.01);
    }

    #[test]
    fn the_direction_of_crests_is_found_for_any_angle_field_and_pixel_size() {
        for grid in [Grid::new(128, 128, 1.0, 1.0).unwrap(), Grid::new(256, 128, 0.4, 1.0).unwrap()] {
            for turn in 0..24 {
                let angle = PI * (f64::from(turn) + 0.3) / 24.0;
                // The lattice of wavevectors leaves an error of a tenth of a step at 16 steps: 0.006 rad.
                let found = direction(&crests(grid, angle, 16.0));
                assert!(turned(found, angle).abs() < 0.01, "{angle}: {found}");
            }
        }
    }

    #[test]
    fn missing_points_do_not_change_the_direction() {
        let grid = Grid::new(128, 128, 1.0, 1.0).unwrap();
        for angle in [0.4, 1.1, 2.6] {
            let mut heights = crests(grid, angle, 16.0).heights_m().clone();
            heights
                .indexed_iter_mut()
                .filter(|((r, c), _)| (r + 7 * c) % 9 == 0 || *r > 100)
                .for_each(|(_, z)| *z = f64::NAN);
            let map = HeightMap::new(grid, heights).unwrap();
            let found = direction(&map);
            assert!(turned(found, angle).abs() < 0.03, "{angle}: {found}");
        }
    }

    #[test]
    fn the_angular_density_integrates_to_the_variance_of_its_wavenumbers() {
        // White heights: the density is flat, so rays and wavevectors agree up to scatter. The annulus of radius R
        // steps holds πR² wavevectors of relative standard deviation 1; a Hann window correlates about four neighbours.
        let grid = Grid::new(200, 160, 1.0, 1.25).unwrap();
        let white = random::standard_normal(&mut random::stream(15, "angular", 0), grid.points());
        let map = HeightMap::new(grid, Array2::from_shape_vec(grid.shape(), white).unwrap()).unwrap();
        let spectrum = AreaSpectrum::new(&map).unwrap();
        let angular = spectrum.angular().unwrap();
        let (low, high) = angular.range_rad_per_m;
        let rays: f64 = angular.density_m2.iter().sum::<f64>() * PI / RAYS as f64;
        let fft = RealFft2::new(200, 160);
        let (mut sum, mut count) = (0.0, 0.0);
        for (place, psd) in spectrum.psd_m4.iter().enumerate() {
            let (kx, ky) = (place / 160, place % 160);
            let q = (kx as f64 * TAU / 200.0).hypot(signed_index(ky, 160) * TAU / 200.0);
            if (low..high).contains(&q) {
                sum += fft.multiplicity(kx) * psd / grid.area_m2();
                count += fft.multiplicity(kx);
            }
        }
        assert!((rays / sum - 1.0).abs() < 4.0 * (8.0 / count).sqrt(), "{rays} {sum}");
    }

    #[test]
    fn the_dominant_wavelength_is_that_of_the_wave() {
        let grid = Grid::new(128, 128, 1.0, 1.0).unwrap();
        for periods in [5.0, 16.0, 30.0] {
            let found = AreaSpectrum::new(&crests(grid, 0.0, periods)).unwrap().dominant_wavelength_m().unwrap();
            assert!((found / (128.0 / periods) - 1.0).abs() < 1e-12, "{found}");
        }
    }

    #[test]
    fn rings_are_means_over_their_wavevectors() {
        let grid = Grid::new(31, 24, 0.7, 1.1).unwrap();
        let white = random::standard_normal(&mut random::stream(15, "rings", 0), grid.points());
        let map = HeightMap::new(grid, Array2::from_shape_vec(grid.shape(), white).unwrap()).unwrap();
        let spectrum = AreaSpectrum::new(&map).unwrap();
        let found = spectrum.radial();
        let (qx, qy, nyquist) = spectrum.wavenumbers();
        let width = qx.max(qy);
        let mut rings = vec![vec![]; (nyquist / width).floor() as usize];
        for kx in -15_isize..=15 {
            for ky in -11_isize..=12 {
                let q = (kx as f64 * qx).hypot(ky as f64 * qy);
                let ring = (q / width - 0.5).floor();
                // P(−q) = P(q).
                let (kx, ky) = if kx < 0 { (-kx, -ky) } else { (kx, ky) };
                if ring >= 0.0 && (ring as usize) < rings.len() {
                    rings[ring as usize].push((q, spectrum.psd_m4[kx as usize * 24 + ky.rem_euclid(24) as usize]));
                }
            }
        }
        for (ring, members) in rings.iter().enumerate() {
            let mean = |f: &dyn Fn(&(f64, f64)) -> f64| members.iter().map(f).sum::<f64>() / members.len() as f64;
            assert_eq!(found.wavevectors[ring], members.len());
            assert!((found.q_rad_per_m[ring] / mean(&|m| m.0) - 1.0).abs() < 1e-12);
            assert!((found.psd_m4[ring] / mean(&|m| m.1) - 1.0).abs() < 1e-12);
        }
    }

    /// Returns a rough map: waves of random directions and phases whose density falls as q⁻⁴.
    fn rough(n: usize) -> HeightMap {
        let angles = random::standard_normal(&mut random::stream(16, "rough", 0), 1200);
        let mut heights = Array2::zeros((n, n));
        for (wave, angles) in (0..600).zip(angles.chunks_exact(2)) {
            let [turn, phase] = [TAU * angles[0], TAU * angles[1]];
            let periods = 2.0 * (n as f64 / 5.0).powf(f64::from(wave) / 600.0);
            let (kx, ky) = (TAU * periods * turn.cos() / n as f64, TAU * periods * turn.sin() / n as f64);
            for ((row, column), z) in heights.indexed_iter_mut() {
                *z += (kx * column as f64 + ky * row as f64 + phase).cos() / periods;
            }
        }
        HeightMap::new(Grid::new(n, n, 1e-6, 1e-6).unwrap(), heights).unwrap()
    }

    #[test]
    fn small_voids_hardly_change_the_spectrum() {
        let n = 128;
        let whole = rough(n);
        let wanted = radial_spectrum(&whole).unwrap();
        let mut heights = Array2::from_shape_vec((n, n), whole.values_m().to_vec()).unwrap();
        for (voids, tolerance) in [(1, 5e-3), (40, 0.05)] {
            for void in 0..voids {
                heights[[(90 + 31 * void) % n, (100 + 17 * void) % n]] = f64::NAN;
            }
            let found = radial_spectrum(&HeightMap::new(whole.grid(), heights.clone()).unwrap()).unwrap();
            assert_eq!(found.route, SpectrumRoute::Periodogram);
            let all = found.psd_m4.iter().zip(&wanted.psd_m4).zip(&wanted.q_rad_per_m);
            for ((found, wanted), q) in all.filter(|(_, q)| **q <= wanted.reliable.high_rad_per_m) {
                assert!((found / wanted - 1.0).abs() < tolerance, "{voids} at {q}: {found} {wanted}");
            }
        }
        // A third of all points, alone: their errors would be seen at the shortest waves.
        let mut heights = heights;
        heights.iter_mut().step_by(3).for_each(|z| *z = f64::NAN);
        let found = radial_spectrum(&HeightMap::new(whole.grid(), heights).unwrap()).unwrap();
        assert_eq!(found.route, SpectrumRoute::MaskedCorrelogram);
    }

    #[test]
    fn rings_and_corners_are_the_windowed_mean_square() {
        for (nx, ny, dx_m, dy_m) in [(31, 24, 0.7, 1.1), (64, 32, 1.0, 3.0), (96, 6, 1.0, 1.0)] {
            let grid = Grid::new(nx, ny, dx_m, dy_m).unwrap();
            let white = random::standard_normal(&mut random::stream(15, "corners", nx as u64), grid.points());
            let mut heights = Array2::from_shape_vec(grid.shape(), white).unwrap();
            let total = |heights: &Array2<f64>| {
                let found = radial_spectrum(&HeightMap::new(grid, heights.clone()).unwrap()).unwrap();
                let rings = found.psd_m4.iter().zip(&found.wavevectors).map(|(psd, n)| psd * *n as f64);
                rings.sum::<f64>() / grid.area_m2() + found.corners_m2
            };
            let (window_x, window_y, mean) = (hann(nx), hann(ny), heights.mean().unwrap());
            let weight = |row: usize, column: usize| (window_x[column] * window_y[row]).powi(2);
            let (mut sum, mut weights) = (0.0, 0.0);
            for ((row, column), z) in heights.indexed_iter() {
                sum += weight(row, column) * (z - mean).powi(2);
                weights += weight(row, column);
            }
            assert!((total(&heights) * weights / sum - 1.0).abs() < 1e-12);
            // A void that is too large to be filled.
            let rows = if ny > 20 { 3..ny - 3 } else { 0..ny };
            heights.slice_mut(ndarray::s![rows, 5..nx - 5]).fill(f64::NAN);
            let present: Vec<f64> = heights.iter().copied().filter(|z| !z.is_nan()).collect();
            let (n, mean) = (present.len() as f64, Extent::new(&present).mean);
            let variance = present.iter().map(|z| (z - mean).powi(2)).sum::<f64>() / n;
            assert!((total(&heights) / variance - 1.0).abs() < 1e-12);
        }
    }
}
