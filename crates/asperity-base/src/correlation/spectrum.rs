//! Power spectral densities of maps; see [`crate::correlation`] for the conventions.

mod area;
mod band;
mod binned;
mod blocks;
mod filled;
mod line_blocks;

use std::f64::consts::{PI, TAU};

use crate::fourier::{good_length, real_transform, summed_power};
use crate::map::HeightMap;
use crate::stats::Extent;

use super::estimate::EstimateError;
use super::profiles::{self, Axis};

pub use area::{AngularSpectrum, AreaSpectrum, RadialSpectrum, radial_spectrum};
pub use band::{ReliableBand, UpperLimit};
pub use binned::{BinnedSpectrum, binned_profile_spectrum, binned_radial_spectrum, radial_spectrum_with_bands};
pub(super) use binned::{bin_of, edges};
pub use blocks::{Block, BlockSpectrum};
pub(super) use line_blocks::LineBlocks;

/// Estimator of a spectrum.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum SpectrumRoute {
    /// Periodogram under a Hann window, with a resolution of ±2 wavenumbers 2π/L. Voids so small that their heights hardly matter are
    /// filled before.
    Periodogram,
    /// Transform of the pair-normalised autocovariance under a Parzen lag window that ends at half the map, for maps
    /// with other voids. Its resolution is ±4 wavenumbers 2π/L, and noise can make single bins negative.
    MaskedCorrelogram,
}

impl SpectrumRoute {
    /// Returns its name in files.
    pub fn name(self) -> &'static str {
        match self {
            Self::Periodogram => "periodogram",
            Self::MaskedCorrelogram => "correlogram",
        }
    }

    /// Returns the half width of a spectral line in wavenumbers 2π/L; at lower wavenumbers the subtracted mean and
    /// plane and the boundary of the field dominate.
    pub fn resolution(self) -> f64 {
        match self {
            Self::Periodogram => 2.0,
            Self::MaskedCorrelogram => 4.0,
        }
    }
}

/// Mean power spectral density of the profiles along one axis.
#[derive(Debug, Clone, PartialEq)]
pub struct ProfileSpectrum {
    /// Wavenumbers 0, 2π/L, … π/Δ in rad/m.
    pub q_rad_per_m: Vec<f64>,
    /// Two-sided power spectral density P₁(q) in m³: the variance is ∫ P₁ dq/2π over both signs of q.
    pub psd_m3: Vec<f64>,
    /// Estimator of the spectrum.
    pub route: SpectrumRoute,
    /// Number of profiles averaged.
    pub profiles: usize,
    /// Number of profiles excluded: for the periodogram those with a missing point, for the correlogram those without
    /// any point.
    pub profiles_left_out: usize,
    /// Reliable wavenumbers.
    pub reliable: ReliableBand,
}

impl ProfileSpectrum {
    /// Returns the length in metre of the shortest wave that profiles of points `pitch_m` apart resolve, as
    /// [`BlockSpectrum::shortest_wave_m`] does for maps.
    pub fn shortest_wave_m(&self, pitch_m: f64) -> f64 {
        TAU / LineBlocks::new(self, pitch_m).high_rad_per_m
    }
}

/// Returns the Hann window, sin²(π(i + ½)/n).
pub(super) fn hann(n: usize) -> Vec<f64> {
    (0..n).map(|i| (PI * (i as f64 + 0.5) / n as f64).sin().powi(2)).collect()
}

/// Returns Parzen's lag window, zero from |u| = 1; its transform is non-negative.
fn parzen(u: f64) -> f64 {
    let u = u.abs();
    if u <= 0.5 {
        1.0 - 6.0 * u * u * (1.0 - u)
    } else if u < 1.0 {
        2.0 * (1.0 - u).powi(3)
    } else {
        0.0
    }
}

/// Returns the mean power spectral density of the profiles along `axis`.
///
/// Heights are relative to the mean of the map. The means of single profiles differ from it, and are in the first bins: the wavenumber
/// 0 and, under the window, its neighbours. The density is therefore that of the surface, in which waves across the profiles belong to
/// the variance, and the sum over all bins and both signs of q is the windowed mean square of all profiles.
///
/// If at least half of the profiles are complete, it is the mean of their periodograms, |Σ w z e^{−iqx}|² Δ/Σw² with a
/// Hann window w. Otherwise it is the transform Δ Σ w(l) C(l) e^{−iql} of the mean product C(l) over all pairs of
/// present heights of the same profile, with a Parzen window w that ends at half the profile or at the first lag
/// without a pair. No height is interpolated. Both estimates are unbiased if the spectrum is smooth over their
/// resolution, see [`SpectrumRoute`]; the second scatters about zero where the spectrum is below the noise of the
/// missing pairs.
///
/// # Errors
/// The heights present do not vary.
pub fn profile_spectrum(map: &HeightMap, axis: Axis) -> Result<ProfileSpectrum, EstimateError> {
    let extent = Extent::new(map.values_m());
    if extent.largest_deviation() <= 4.0 * f64::EPSILON * extent.mean.abs() {
        return Err(EstimateError::Constant { present: extent.n });
    }
    let (all, n, pitch_m) = profiles::dimensions(map, axis);
    let is_complete = extent.n == map.values_m().len();
    let missing = if is_complete { vec![0; all] } else { missing_per_profile(map, axis) };
    let complete = missing.iter().filter(|missing| **missing == 0).count();
    let (psd_m3, route, used) = if 2 * complete >= all {
        (periodogram(map, axis, complete, extent.mean), SpectrumRoute::Periodogram, complete)
    } else {
        let used = missing.iter().filter(|missing| **missing < n).count();
        (correlogram(map, axis, extent.mean), SpectrumRoute::MaskedCorrelogram, used)
    };
    let q_min = TAU / (n as f64 * pitch_m);
    let q_rad_per_m: Vec<f64> = (0..psd_m3.len()).map(|k| k as f64 * q_min).collect();
    let reliable = ReliableBand::from_profile(&q_rad_per_m, &psd_m3, route.resolution() * q_min, PI / pitch_m);
    Ok(ProfileSpectrum { q_rad_per_m, psd_m3, route, profiles: used, profiles_left_out: all - used, reliable })
}

/// Returns the number of missing points of every profile.
fn missing_per_profile(map: &HeightMap, axis: Axis) -> Vec<usize> {
    let (all, _, _) = profiles::dimensions(map, axis);
    let mut missing = vec![0; all];
    for (row, heights) in map.values_m().chunks_exact(map.grid().nx()).enumerate() {
        match axis {
            Axis::X => missing[row] = heights.iter().filter(|z| z.is_nan()).count(),
            Axis::Y => missing.iter_mut().zip(heights).for_each(|(missing, z)| *missing += usize::from(z.is_nan())),
        }
    }
    missing
}

/// Returns the mean periodogram of the `complete` profiles; the others are set to zero.
fn periodogram(map: &HeightMap, axis: Axis, complete: usize, mean_m: f64) -> Vec<f64> {
    let (all, n, pitch_m) = profiles::dimensions(map, axis);
    let window = hann(n);
    let norm = pitch_m / window.iter().map(|w| w * w).sum::<f64>() / complete as f64;
    let power = summed_power(all, n, n, |range, out| {
        profiles::copy(map, axis, range, out);
        for profile in out.chunks_exact_mut(n) {
            if profile.iter().any(|z| z.is_nan()) {
                profile.fill(0.0);
            } else {
                profile.iter_mut().zip(&window).for_each(|(z, w)| *z = w * (*z - mean_m));
            }
        }
    });
    power.into_iter().map(|power| norm * power).collect()
}

/// Returns the windowed transform of the mean products over pairs of all profiles.
fn correlogram(map: &HeightMap, axis: Axis, mean_m: f64) -> Vec<f64> {
    let (_, n, pitch_m) = profiles::dimensions(map, axis);
    let half = (n - 1) / 2;
    let padded = good_length(n + half);
    let products = profiles::lag_sums(map, axis, padded, |z| if z.is_nan() { 0.0 } else { z - mean_m });
    let counts = profiles::lag_sums(map, axis, padded, |z| if z.is_nan() { 0.0 } else { 1.0 });
    let end = lag_window_end(&counts, half);
    let mut lags = vec![0.0; n];
    for lag in 0..end {
        let value = parzen(lag as f64 / end as f64) * products[lag] / counts[lag].round();
        lags[lag] = value;
        lags[(n - lag) % n] = value;
    }
    real_transform(&lags).into_iter().map(|value| pitch_m * value).collect()
}

/// Returns the lag at which Parzen's window ends: the first without a pair in `counts`, at most `half` plus one.
fn lag_window_end(counts: &[f64], half: usize) -> usize {
    // Counts are integers up to rounding.
    (0..=half).find(|lag| counts[*lag] < 0.5).unwrap_or(half + 1)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::map::Grid;
    use crate::random;
    use ndarray::Array2;

    #[test]
    fn the_power_of_a_cosine_is_half_its_amplitude_squared() {
        // Parseval's theorem under a window: Σ P₁ Δq/2π over both signs is the windowed mean square, A²/2 for whole
        // periods.
        let grid = Grid::new(200, 3, 0.1, 1.0).unwrap();
        let q = TAU * 20.0 / grid.width_m();
        let map = HeightMap::from_function(grid, |x, _| 7.0 + 3.0 * (q * x + 0.4).cos()).unwrap();
        let found = profile_spectrum(&map, Axis::X).unwrap();
        let dq = found.q_rad_per_m[1];
        let power: f64 = found.psd_m3[1..].iter().sum::<f64>() * 2.0 * dq / TAU;
        assert!((power - 4.5).abs() < 1e-10, "{power}");
        let top = (0..found.psd_m3.len()).max_by(|a, b| found.psd_m3[*a].total_cmp(&found.psd_m3[*b])).unwrap();
        assert!((found.q_rad_per_m[top] - q).abs() < 1e-9 * q);
    }

    #[test]
    fn few_profiles_with_missing_points_are_excluded() {
        let grid = Grid::new(16, 5, 1.0, 1.0).unwrap();
        let map = HeightMap::from_function(grid, |x, y| if y < 1.0 && x < 2.0 { f64::NAN } else { x.sin() }).unwrap();
        let found = profile_spectrum(&map, Axis::X).unwrap();
        assert_eq!((found.profiles, found.profiles_left_out, found.route), (4, 1, SpectrumRoute::Periodogram));
        let found = profile_spectrum(&map, Axis::Y).unwrap();
        assert_eq!((found.profiles, found.profiles_left_out), (14, 2));
        // The spectrum equals that of the other profiles, up to the mean of the whole map.
        let rest = HeightMap::from_function(Grid::new(16, 4, 1.0, 1.0).unwrap(), |x, _| x.sin()).unwrap();
        let (found, rest) = (profile_spectrum(&map, Axis::X).unwrap(), profile_spectrum(&rest, Axis::X).unwrap());
        assert!(found.psd_m3[2..].iter().zip(&rest.psd_m3[2..]).all(|(a, b)| (a - b).abs() < 1e-12));
    }

    #[test]
    fn the_correlogram_is_the_sum_over_present_pairs() {
        let grid = Grid::new(21, 6, 0.5, 1.0).unwrap();
        let mut heights = random::standard_normal(&mut random::stream(13, "correlogram", 0), grid.points());
        (0..6).for_each(|row| heights[21 * row + 3 * row] = f64::NAN);
        let map = HeightMap::new(grid, Array2::from_shape_vec((6, 21), heights.clone()).unwrap()).unwrap();
        let found = profile_spectrum(&map, Axis::X).unwrap();
        assert_eq!((found.profiles, found.profiles_left_out, found.route), (6, 0, SpectrumRoute::MaskedCorrelogram));
        let mean = Extent::new(&heights).mean;
        for (q, psd) in found.q_rad_per_m.iter().zip(&found.psd_m3) {
            let mut wanted = 0.0;
            for lag in -10_i32..=10 {
                let pairs: Vec<f64> = (0..6)
                    .flat_map(|row| (0..21 - lag.unsigned_abs() as usize).map(move |i| 21 * row + i))
                    .map(|i| (heights[i] - mean) * (heights[i + lag.unsigned_abs() as usize] - mean))
                    .filter(|product| !product.is_nan())
                    .collect();
                let covariance = pairs.iter().sum::<f64>() / pairs.len() as f64;
                wanted += 0.5 * parzen(f64::from(lag) / 11.0) * covariance * (q * 0.5 * f64::from(lag)).cos();
            }
            assert!((psd - wanted).abs() < 1e-12, "{psd} {wanted}");
        }
    }

    #[test]
    fn a_map_with_a_void_in_every_profile_has_the_spectrum_of_its_covariance() {
        // Rows of first-order autoregressive values: P₁(q) = Δ (1 − φ²)/(1 − 2φ cos qΔ + φ²), a tenth missing.
        let (rows, columns, phi) = (400, 256, 0.7_f64);
        let mut stream = random::stream(14, "autoregression", 0);
        let mut heights = vec![];
        for _ in 0..rows {
            let noise = random::standard_normal(&mut stream, columns);
            let mut z = noise[0];
            heights.push(z);
            for xi in &noise[1..] {
                z = phi * z + (1.0 - phi * phi).sqrt() * xi;
                heights.push(z);
            }
        }
        let holes = random::standard_normal(&mut stream, rows * columns);
        heights.iter_mut().zip(holes).filter(|(_, hole)| *hole < -1.2816).for_each(|(z, _)| *z = f64::NAN);
        let grid = Grid::new(columns, rows, 1.0, 1.0).unwrap();
        let map = HeightMap::new(grid, Array2::from_shape_vec((rows, columns), heights).unwrap()).unwrap();
        let found = profile_spectrum(&map, Axis::X).unwrap();
        assert_eq!(found.route, SpectrumRoute::MaskedCorrelogram);
        for k in [6, 12, 24, 48, 96] {
            let wanted = (1.0 - phi * phi) / (1.0 - 2.0 * phi * found.q_rad_per_m[k].cos() + phi * phi);
            // A Parzen window of half length M = 128 leaves about 3.7 columns/M = 7.4 degrees of freedom per row, so
            // the relative standard error is √(2/(7.4·400)) = 2.6 %; the white noise of the missing tenth is of order
            // 0.1·√(…) of the density of the variance, below it. Four standard errors, and 2 % for the curvature under
            // the window.
            assert!((found.psd_m3[k] / wanted - 1.0).abs() < 0.13, "{k}: {} {wanted}", found.psd_m3[k]);
        }
    }
}
