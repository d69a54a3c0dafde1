//! Structure function, Hurst exponent and fractal dimension.

use std::ops::Range;

use thiserror::Error;

use asperity_base::blocks;
use asperity_base::correlation::{Axis, profiles};
use asperity_base::map::HeightMap;
use asperity_base::numeric::Line;
use asperity_base::stats::blocks::LANES;
use asperity_base::stats::{Moments, jackknife_error};

/// Number of bands of neighbouring profiles, for the jackknife standard error.
const BANDS: usize = 16;
/// Number of profiles copied at a time, so that profiles along y are contiguous; they fit the second-level cache.
const COPIED: usize = 16;
/// Ratio of neighbouring lags of the logarithmic ladder, before rounding to pixels.
const LADDER: f64 = 1.15;
/// Least ratio of the longest to the shortest lag of a fit.
const LEAST_SPAN: f64 = 4.0;
/// Least number of lags of a fit.
const LEAST_LAGS: usize = 5;
/// Fraction of the limit 2 Sq² of the structure function at which a fit without a stated range ends. Beyond it the
/// roll-off bends the structure function.
const SATURATION: f64 = 0.2;
/// Largest accepted exponent. Larger ones belong to a surface that is smooth on the scale of its pixels.
const SMOOTH: f64 = 0.95;
/// Largest difference between the exponents of the shorter and the longer half of the lags in one scaling range.
const LARGEST_BEND: f64 = 0.2;
/// Largest accepted standard error of an exponent.
const LARGEST_ERROR: f64 = 0.1;

/// Reason why a map has no structure function.
#[derive(Debug, Clone, PartialEq, Error)]
#[non_exhaustive]
pub enum FractalError {
    /// All heights are equal.
    #[error("all {present} heights that are present are equal; a surface without roughness has no fractal dimension")]
    Flat {
        /// Number of present heights.
        present: usize,
    },
    /// The stated range of lags is empty or not positive.
    #[error("the fit range is {low_m} to {high_m} m, but must be positive and ascending")]
    Range {
        /// Shortest lag in metre.
        low_m: f64,
        /// Longest lag in metre.
        high_m: f64,
    },
}

/// S(τ) = ⟨(z(x + τ) − z(x))²⟩ over the pairs of present heights of the profiles along one axis.
#[derive(Debug, Clone, PartialEq)]
pub struct StructureFunction {
    /// Axis of the profiles.
    pub axis: Axis,
    /// Lags τ in metre, ascending, about evenly spaced in their logarithm, up to half the profile.
    pub lags_m: Vec<f64>,
    /// S(τ) in m².
    pub values_m2: Vec<f64>,
    /// Sum and number of squared differences per lag in each band of profiles.
    bands: Vec<Vec<(f64, f64)>>,
}

impl StructureFunction {
    /// Computes the structure function along an axis; lags without a pair are left out. No form is removed here.
    pub fn new(map: &HeightMap, axis: Axis) -> Self {
        let (all, length, pitch_m) = profiles::dimensions(map, axis);
        let band_count = BANDS.min(all);
        let lags = ladder(length / 2);
        let sums: Vec<Vec<(f64, f64)>> = blocks::map(0..band_count, |band| {
            band_sums(map, axis, band * all / band_count..(band + 1) * all / band_count, &lags)
        });
        let mut lags_m = vec![];
        let mut values_m2 = vec![];
        let mut bands = vec![vec![]; band_count];
        for (place, lag) in lags.into_iter().enumerate() {
            let (sum, count) = total(sums.iter().map(|band| &band[place]));
            if count > 0.0 {
                lags_m.push(lag as f64 * pitch_m);
                values_m2.push(sum / count);
                bands.iter_mut().zip(&sums).for_each(|(band, sums)| band.push(sums[place]));
            }
        }
        Self { axis, lags_m, values_m2, bands }
    }

    /// Fits S ∝ τ^{2H} by least squares of the logarithms over the lags from `low_m` to `high_m`.
    ///
    /// The standard error is the jackknife over up to 16 bands of neighbouring profiles, because the residuals of the
    /// line are far too correlated between lags. It does not include the bias of the roll-off, of the instrument's
    /// smoothing or of levelling, which shorten the scaling range.
    ///
    /// Returns `None` if there is no scaling: fewer than 5 lags or less than a factor of 4 between them, an exponent
    /// outside 0 < H < 0.95 (white, or smooth at the pixel), exponents of the two halves of the range that differ by
    /// more than 0.2, or a standard error above 0.1.
    pub fn scaling(&self, low_m: f64, high_m: f64) -> Option<ProfileScaling> {
        // Lags are multiples of the pitch; rounding must not exclude the ends of the range.
        let inside = |lag_m: f64| lag_m >= low_m * (1.0 - 1e-9) && lag_m <= high_m * (1.0 + 1e-9);
        let used: Vec<usize> =
            (0..self.lags_m.len()).filter(|&i| inside(self.lags_m[i]) && self.values_m2[i] > 0.0).collect();
        let (first, last) = (*used.first()?, *used.last()?);
        if used.len() < LEAST_LAGS || self.lags_m[last] < LEAST_SPAN * self.lags_m[first] {
            return None;
        }
        let exponent = |used: &[usize], value: &dyn Fn(usize) -> f64| {
            let points: Vec<(f64, f64)> = used.iter().map(|&i| (self.lags_m[i].ln(), value(i).ln())).collect();
            0.5 * Line::through(&points).slope
        };
        let whole = |i: usize| self.values_m2[i];
        let hurst = exponent(&used, &whole);
        let (short, long) = used.split_at(used.len() / 2);
        let bend = exponent(short, &whole) - exponent(long, &whole);
        if !(hurst > 0.0 && hurst < SMOOTH && bend.abs() <= LARGEST_BEND) {
            return None;
        }
        let without: Vec<f64> = (0..self.bands.len())
            .map(|left_out| {
                let rest = |i: usize| {
                    let others = self.bands.iter().enumerate().filter(|(band, _)| *band != left_out);
                    let (sum, count) = total(others.map(|(_, band)| &band[i]));
                    sum / count
                };
                exponent(&used, &rest)
            })
            .collect();
        let hurst_se = (without.len() > 1).then(|| jackknife_error(&without)).filter(|se| se.is_finite());
        if hurst_se.is_some_and(|se| se > LARGEST_ERROR) {
            return None;
        }
        Some(ProfileScaling { hurst, hurst_se, range_m: (self.lags_m[first], self.lags_m[last]) })
    }
}

/// Hurst exponent of the profiles along one axis.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ProfileScaling {
    /// Hurst exponent H.
    pub hurst: f64,
    /// Standard error of H; `None` for a single profile.
    pub hurst_se: Option<f64>,
    /// Shortest and longest lag of the fit in metre.
    pub range_m: (f64, f64),
}

/// Hurst exponent and fractal dimension of a map.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Scaling {
    /// Hurst exponent H: the mean over the axes that scale.
    pub hurst: f64,
    /// Standard error of H: the mean of the standard errors of the axes, which are treated as fully dependent.
    pub hurst_se: Option<f64>,
    /// Fractal dimension D = 3 − H of the surface; the dimension of a profile is one less.
    pub fractal_dimension: f64,
    /// Result along x; `None` without a scaling range.
    pub x: Option<ProfileScaling>,
    /// Result along y; `None` without a scaling range.
    pub y: Option<ProfileScaling>,
}

/// Estimates the Hurst exponent and fractal dimension of a map over a range of lags in metre.
///
/// Without a stated range the fit runs from two pixels to the longest lag that is at most an eighth of the profile and
/// at which S is at most 0.2 of 2 Sq². Remove the form first: a tilt scales with H = 1.
///
/// Returns `Ok(None)` if neither axis has a scaling range ([`StructureFunction::scaling`]).
///
/// # References
/// Sayles & Thomas, *Nature* **271** (1978) 431, <https://doi.org/10.1038/271431a0>; Mandelbrot, *The Fractal Geometry
/// of Nature*, Freeman 1982.
///
/// # Errors
/// All heights are equal, or the range is not positive and ascending.
pub fn scaling(map: &HeightMap, range_m: Option<(f64, f64)>) -> Result<Option<Scaling>, FractalError> {
    let moments = Moments::new(map.values_m());
    if moments.std <= 8.0 * f64::EPSILON * moments.mean.abs() || moments.std == 0.0 {
        return Err(FractalError::Flat { present: moments.n });
    }
    if let Some((low_m, high_m)) = range_m
        && !(low_m > 0.0 && high_m > low_m && high_m.is_finite())
    {
        return Err(FractalError::Range { low_m, high_m });
    }
    let grid = map.grid();
    let along = |axis: Axis| {
        let structure = StructureFunction::new(map, axis);
        let (pitch_m, length_m) = match axis {
            Axis::X => (grid.dx_m(), grid.width_m()),
            Axis::Y => (grid.dy_m(), grid.height_m()),
        };
        let (low_m, high_m) = range_m.unwrap_or_else(|| {
            let limit_m2 = SATURATION * 2.0 * moments.std * moments.std;
            let saturated = structure.values_m2.partition_point(|s| *s <= limit_m2);
            let unsaturated_m = if saturated > 0 { structure.lags_m[saturated - 1] } else { 0.0 };
            (2.0 * pitch_m, f64::min(length_m / 8.0, unsaturated_m))
        });
        structure.scaling(low_m, high_m)
    };
    let (x, y) = (along(Axis::X), along(Axis::Y));
    let axes: Vec<ProfileScaling> = x.into_iter().chain(y).collect();
    if axes.is_empty() {
        return Ok(None);
    }
    let n = axes.len() as f64;
    let hurst = axes.iter().map(|axis| axis.hurst).sum::<f64>() / n;
    let hurst_se = axes.iter().map(|axis| axis.hurst_se).sum::<Option<f64>>().map(|sum| sum / n);
    Ok(Some(Scaling { hurst, hurst_se, fractal_dimension: 3.0 - hurst, x, y }))
}

/// Returns the sums and numbers of squared differences at every lag over neighbouring profiles.
fn band_sums(map: &HeightMap, axis: Axis, band: Range<usize>, lags: &[usize]) -> Vec<(f64, f64)> {
    let (_, length, _) = profiles::dimensions(map, axis);
    let mut sums = vec![(0.0, 0.0); lags.len()];
    let mut heights_m = vec![0.0; COPIED * length];
    for first in band.clone().step_by(COPIED) {
        let copied = first..(first + COPIED).min(band.end);
        let heights_m = &mut heights_m[..copied.len() * length];
        profiles::copy(map, axis, copied, heights_m);
        for profile in heights_m.chunks_exact(length) {
            let complete = profile.iter().all(|z| !z.is_nan());
            for ((sum, count), lag) in sums.iter_mut().zip(lags) {
                let (squares, pairs) = squared_differences(profile, *lag, complete);
                *sum += squares;
                *count += pairs;
            }
        }
    }
    sums
}

/// Returns the sum and number of the squared differences of a profile at a lag, over the pairs of present heights.
fn squared_differences(profile: &[f64], lag: usize, complete: bool) -> (f64, f64) {
    let (here, there) = (&profile[..profile.len() - lag], &profile[lag..]);
    // Independent partial sums let the processor add several differences at once.
    let (here_lanes, here_rest) = here.as_chunks::<LANES>();
    let (there_lanes, there_rest) = there.as_chunks::<LANES>();
    let mut sums = [0.0; LANES];
    let mut counts = [0.0; LANES];
    if complete {
        for (a, b) in here_lanes.iter().zip(there_lanes) {
            for lane in 0..LANES {
                let difference = b[lane] - a[lane];
                sums[lane] += difference * difference;
            }
        }
        let rest: f64 = here_rest.iter().zip(there_rest).map(|(a, b)| (b - a) * (b - a)).sum();
        return (sums.iter().sum::<f64>() + rest, here.len() as f64);
    }
    let mut take = |lane: usize, a: f64, b: f64| {
        let square = (b - a) * (b - a);
        sums[lane] += if square.is_nan() { 0.0 } else { square };
        counts[lane] += if square.is_nan() { 0.0 } else { 1.0 };
    };
    for (a, b) in here_lanes.iter().zip(there_lanes) {
        (0..LANES).for_each(|lane| take(lane, a[lane], b[lane]));
    }
    here_rest.iter().zip(there_rest).for_each(|(a, b)| take(0, *a, *b));
    (sums.iter().sum(), counts.iter().sum())
}

/// Returns the lags 1, 2, 3, … growing by the ratio of the ladder, up to `longest`.
fn ladder(longest: usize) -> Vec<usize> {
    let mut lags = vec![];
    let mut lag = 1;
    while lag <= longest {
        lags.push(lag);
        lag = usize::max(lag + 1, (lag as f64 * LADDER).round() as usize);
    }
    lags
}

fn total<'a>(sums: impl Iterator<Item = &'a (f64, f64)>) -> (f64, f64) {
    sums.fold((0.0, 0.0), |(sum, count), (s, c)| (sum + s, count + c))
}

#[cfg(test)]
mod tests {
    use super::*;
    use asperity_base::fourier::{Complex64, RealFft2};
    use asperity_base::map::Grid;
    use asperity_base::random;
    use ndarray::Array2;

    /// Returns rows of independent fractional Brownian motion, exact (Davies & Harte 1987): S(τ) = τ^{2H} with unit
    /// pitch.
    fn brownian(hurst: f64, rows: usize, n: usize) -> HeightMap {
        let fft = RealFft2::new(2 * n, 1);
        let (mut eigenvalues, mut work) = (fft.spectrum(), fft.workspace());
        let covariance = |k: f64| {
            let power = |k: f64| k.abs().powf(2.0 * hurst);
            0.5 * (power(k + 1.0) - 2.0 * power(k) + power(k - 1.0))
        };
        let circulant: Vec<f64> = (0..2 * n).map(|k| covariance(usize::min(k, 2 * n - k) as f64)).collect();
        fft.forward(&circulant, &mut eigenvalues, &mut work);
        let mut heights = Array2::zeros((rows, n));
        for row in 0..rows {
            let white = random::standard_normal(&mut random::stream(12, "brownian", row as u64), 2 * n);
            let mut spectrum = fft.spectrum();
            fft.forward(&white, &mut spectrum, &mut work);
            for (value, eigenvalue) in spectrum.iter_mut().zip(&eigenvalues) {
                *value *= Complex64::from(eigenvalue.re.max(0.0).sqrt());
            }
            let mut noise = vec![0.0; 2 * n];
            fft.inverse(&mut spectrum, &mut noise, &mut work);
            let mut height = 0.0;
            for column in 0..n {
                height += noise[column];
                heights[[row, column]] = height;
            }
        }
        HeightMap::new(Grid::new(n, rows, 1.0, 1.0).unwrap(), heights).unwrap()
    }

    #[test]
    fn fractional_brownian_profiles_have_their_exponent_within_its_standard_error() {
        for hurst in [0.3, 0.5, 0.8] {
            let structure = StructureFunction::new(&brownian(hurst, 64, 1024), Axis::X);
            let fit = structure.scaling(1.0, 64.0).unwrap();
            let error = fit.hurst_se.unwrap();
            assert!((fit.hurst - hurst).abs() < 4.0 * error, "H = {hurst}: {fit:?}");
            assert!(error > 1e-4 && error < 0.02, "{error}");
            assert_eq!(fit.range_m.0, 1.0);
            assert!(fit.range_m.1 <= 64.0);
        }
    }

    #[test]
    fn the_jackknife_error_equals_the_spread_over_independent_maps() {
        let all = brownian(0.5, 24 * 32, 256);
        let fits: Vec<ProfileScaling> = (0..24)
            .map(|part| {
                let rows = all.heights_m().slice(ndarray::s![part * 32..(part + 1) * 32, ..]).to_owned();
                let map = HeightMap::new(Grid::new(256, 32, 1.0, 1.0).unwrap(), rows).unwrap();
                StructureFunction::new(&map, Axis::X).scaling(1.0, 32.0).unwrap()
            })
            .collect();
        let spread = Moments::new(&fits.iter().map(|fit| fit.hurst).collect::<Vec<_>>());
        let told = Moments::new(&fits.iter().filter_map(|fit| fit.hurst_se).collect::<Vec<_>>());
        // The spread of 24 values has a standard error of 1/√46 = 15 %.
        assert!((told.mean / spread.sample_std() - 1.0).abs() < 0.45, "{} {}", told.mean, spread.sample_std());
        assert!((spread.mean - 0.5).abs() < 4.0 * spread.standard_error());
    }

    #[test]
    fn a_brownian_map_scales_only_along_its_profiles() {
        let found = scaling(&brownian(0.5, 256, 1024), None).unwrap().unwrap();
        // Across the independent profiles the map is a step at every lag, without an exponent.
        assert_eq!(found.y, None);
        assert_eq!(Some(found.hurst), found.x.map(|x| x.hurst));
        assert!((found.hurst - 0.5).abs() < 4.0 * found.hurst_se.unwrap(), "{found:?}");
        assert_eq!(found.fractal_dimension, 3.0 - found.hurst);
    }

    #[test]
    fn sums_by_bands_equal_sums_over_all_present_pairs() {
        for (nx, ny, holes) in [(50, 41, 0), (41, 50, 7), (5, 70, 3), (300, 3, 0)] {
            let mut heights = random::standard_normal(&mut random::stream(12, "pairs", nx as u64), nx * ny);
            if holes > 0 {
                heights.iter_mut().step_by(holes).for_each(|z| *z = f64::NAN);
            }
            let heights = Array2::from_shape_vec((ny, nx), heights).unwrap();
            let map = HeightMap::new(Grid::new(nx, ny, 0.5, 0.25).unwrap(), heights.clone()).unwrap();
            for (axis, pitch, profiles) in [(Axis::X, 0.5, heights.view()), (Axis::Y, 0.25, heights.t())] {
                let found = StructureFunction::new(&map, axis);
                for (lag_m, value) in found.lags_m.iter().zip(&found.values_m2) {
                    let lag = (lag_m / pitch).round() as usize;
                    let squares: Vec<f64> = profiles
                        .rows()
                        .into_iter()
                        .flat_map(|z| (0..z.len() - lag).map(|i| (z[i + lag] - z[i]).powi(2)).collect::<Vec<_>>())
                        .filter(|square| !square.is_nan())
                        .collect();
                    let wanted = squares.iter().sum::<f64>() / squares.len() as f64;
                    assert!((value / wanted - 1.0).abs() < 1e-12, "{nx} × {ny}, {axis}, {lag}: {value} {wanted}");
                    let bands =
                        found.bands.iter().map(|band| &band[found.lags_m.iter().position(|l| l == lag_m).unwrap()]);
                    assert_eq!(total(bands).1, squares.len() as f64);
                }
            }
        }
    }

    #[test]
    fn missing_points_change_the_pairs_but_not_the_exponent() {
        let full = brownian(0.5, 64, 512);
        let mut heights = full.heights_m().clone();
        heights.iter_mut().step_by(7).for_each(|z| *z = f64::NAN);
        let holes = HeightMap::new(full.grid(), heights).unwrap();
        let (full, holes) = (StructureFunction::new(&full, Axis::X), StructureFunction::new(&holes, Axis::X));
        assert_eq!(full.lags_m, holes.lags_m);
        let (a, b) = (full.scaling(2.0, 64.0).unwrap(), holes.scaling(2.0, 64.0).unwrap());
        assert!((a.hurst - b.hurst).abs() < a.hurst_se.unwrap());
    }

    #[test]
    fn white_smooth_and_bent_surfaces_have_no_scaling_range() {
        let grid = Grid::new(256, 256, 1e-6, 1e-6).unwrap();
        let white = random::standard_normal(&mut random::stream(12, "white", 0), grid.points());
        let white = HeightMap::new(grid, Array2::from_shape_vec(grid.shape(), white).unwrap()).unwrap();
        assert_eq!(scaling(&white, None), Ok(None));
        let wave = HeightMap::from_function(grid, |x, y| (x / 20e-6).sin() * (y / 20e-6).cos()).unwrap();
        assert_eq!(scaling(&wave, None), Ok(None));
        // Two slopes in one stated range: smooth below the wavelength, constant above it.
        assert_eq!(scaling(&wave, Some((1e-6, 120e-6))), Ok(None));
        let flat = HeightMap::from_function(grid, |_, _| 0.1).unwrap();
        assert_eq!(scaling(&flat, None), Err(FractalError::Flat { present: 256 * 256 }));
        assert!(scaling(&wave, Some((2e-6, 1e-6))).is_err());
    }
}
