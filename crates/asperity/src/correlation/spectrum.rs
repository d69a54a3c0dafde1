//! Power spectral densities of maps; conventions are those of [`crate::correlation`].

use std::f64::consts::{PI, TAU};

use crate::fourier::{RealFft2, signed_index};
use crate::map::HeightMap;

use super::estimate::{Autocorrelation, Axis, EstimateError};

/// Mean periodogram of the profiles along one axis.
#[derive(Debug, Clone, PartialEq)]
pub struct ProfileSpectrum {
    /// Wavenumbers 0, 2π/L, … π/Δ in rad/m.
    pub q_rad_per_m: Vec<f64>,
    /// Two-sided power spectral density P₁(q) in m³: the variance is ∫ P₁ dq/2π over both signs of q.
    pub psd_m3: Vec<f64>,
    /// Profiles averaged.
    pub profiles: usize,
    /// Profiles left out because a point is missing.
    pub profiles_left_out: usize,
}

/// How a two-dimensional spectrum was found.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum SpectrumRoute {
    /// Periodogram of the whole map under a Hann window along x and y.
    Periodogram,
    /// Transform of the pair-normalised autocovariance under a Parzen lag window that ends at half the map. Used when
    /// points are missing; it has half the resolution, and noise may make single bins negative.
    MaskedCorrelogram,
}

/// Radially averaged two-dimensional power spectral density.
#[derive(Debug, Clone, PartialEq)]
pub struct RadialSpectrum {
    /// Mean |q| of each ring in rad/m; rings are 2π/min(Lx, Ly) wide and end at the lesser Nyquist wavenumber.
    pub q_rad_per_m: Vec<f64>,
    /// Mean two-sided power spectral density P(q) on the ring in m⁴.
    pub psd_m4: Vec<f64>,
    /// Wavevectors on each ring.
    pub wavevectors: Vec<usize>,
    /// How it was found.
    pub route: SpectrumRoute,
}

/// The periodic Hann window, sin²(πi/n).
fn hann(n: usize) -> Vec<f64> {
    (0..n).map(|i| (PI * (i as f64 + 0.5) / n as f64).sin().powi(2)).collect()
}

/// Mean periodogram of all complete profiles along `axis`: |Σ w z e^{−iqx}|² Δ/Σw², w a Hann window, z without the map's
/// mean. Profiles with missing points are left out and counted.
///
/// The window spreads a line over ±2 wavenumbers; for a spectrum that is smooth on that scale the estimate is unbiased.
///
/// # Errors
/// Every profile has missing points.
pub fn profile_spectrum(map: &HeightMap, axis: Axis) -> Result<ProfileSpectrum, EstimateError> {
    let grid = map.grid();
    let heights = map.heights_m();
    let mean_m = map.present_m().sum::<f64>() / map.present_m().count() as f64;
    let (lanes, n, pitch_m) = match axis {
        Axis::X => (heights.rows(), grid.nx(), grid.dx_m()),
        Axis::Y => (heights.columns(), grid.ny(), grid.dy_m()),
    };
    let window = hann(n);
    let norm = pitch_m / window.iter().map(|w| w * w).sum::<f64>();
    let fft = RealFft2::new(n, 1);
    let (mut spectrum, mut work) = (fft.spectrum(), fft.workspace());
    let mut psd_m3 = vec![0.0; fft.stored_kx()];
    let mut used = 0;
    let all = lanes.into_iter().len();
    let lanes = match axis {
        Axis::X => heights.rows(),
        Axis::Y => heights.columns(),
    };
    for lane in lanes {
        if lane.iter().any(|z| z.is_nan()) {
            continue;
        }
        let values: Vec<f64> = lane.iter().zip(&window).map(|(z, w)| w * (z - mean_m)).collect();
        fft.forward(&values, &mut spectrum, &mut work);
        for (sum, value) in psd_m3.iter_mut().zip(&spectrum) {
            *sum += norm * value.norm_sqr();
        }
        used += 1;
    }
    if used == 0 {
        return Err(EstimateError::NoCompleteProfile { axis, profiles: all });
    }
    for value in &mut psd_m3 {
        *value /= used as f64;
    }
    let q_min = TAU / (n as f64 * pitch_m);
    let q_rad_per_m = (0..psd_m3.len()).map(|k| k as f64 * q_min).collect();
    Ok(ProfileSpectrum { q_rad_per_m, psd_m3, profiles: used, profiles_left_out: all - used })
}

/// Radially averaged power spectral density of a map; the route depends on whether points are missing and is reported.
///
/// # Errors
/// The heights do not vary (only noticed when points are missing).
pub fn radial_spectrum(map: &HeightMap) -> Result<RadialSpectrum, EstimateError> {
    let (route, psd) = match map.missing_points() {
        0 => (SpectrumRoute::Periodogram, periodogram(map)),
        _ => (SpectrumRoute::MaskedCorrelogram, correlogram(map)?),
    };
    let grid = map.grid();
    let (nx, ny) = (grid.nx(), grid.ny());
    let (qx_min, qy_min) = (TAU / grid.width_m(), TAU / grid.height_m());
    let width = qx_min.max(qy_min);
    let nyquist = (PI / grid.dx_m()).min(PI / grid.dy_m());
    let rings = (nyquist / width).floor() as usize;
    let (mut q, mut sums, mut counts) = (vec![0.0; rings], vec![0.0; rings], vec![0_usize; rings]);
    for kx in 0..nx / 2 + 1 {
        let weight = if kx == 0 || 2 * kx == nx { 1 } else { 2 };
        for ky in 0..ny {
            let magnitude = (kx as f64 * qx_min).hypot(signed_index(ky, ny) * qy_min);
            // Ring m holds wavenumbers (m + ½, m + 3/2) widths: centred on whole wavenumbers.
            let ring = (magnitude / width - 0.5).floor();
            if ring >= 0.0 && (ring as usize) < rings {
                let ring = ring as usize;
                q[ring] += weight as f64 * magnitude;
                sums[ring] += weight as f64 * psd[kx * ny + ky];
                counts[ring] += weight;
            }
        }
    }
    let kept: Vec<usize> = (0..rings).filter(|ring| counts[*ring] > 0).collect();
    Ok(RadialSpectrum {
        q_rad_per_m: kept.iter().map(|&ring| q[ring] / counts[ring] as f64).collect(),
        psd_m4: kept.iter().map(|&ring| sums[ring] / counts[ring] as f64).collect(),
        wavevectors: kept.iter().map(|&ring| counts[ring]).collect(),
        route,
    })
}

/// Hann-windowed periodogram |Σ w z e^{−iq·x}|² ΔxΔy/Σw² of a complete map, laid out as a stored spectrum.
fn periodogram(map: &HeightMap) -> Vec<f64> {
    let grid = map.grid();
    let (ny, nx) = grid.shape();
    let mean_m = map.present_m().sum::<f64>() / grid.points() as f64;
    let (window_x, window_y) = (hann(nx), hann(ny));
    let square = |window: &[f64]| window.iter().map(|w| w * w).sum::<f64>();
    let norm = grid.cell_area_m2() / (square(&window_x) * square(&window_y));
    let values: Vec<f64> = map
        .heights_m()
        .indexed_iter()
        .map(|((row, column), z)| window_y[row] * window_x[column] * (z - mean_m))
        .collect();
    let fft = RealFft2::new(nx, ny);
    let mut spectrum = fft.spectrum();
    fft.forward(&values, &mut spectrum, &mut fft.workspace());
    spectrum.iter().map(|value| norm * value.norm_sqr()).collect()
}

/// Parzen's lag window, zero from |u| = 1; its transform is non-negative.
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

/// ΔxΔy Σ w(lag) C(lag) e^{−iq·lag} over lags up to half the map, laid out as a stored spectrum.
fn correlogram(map: &HeightMap) -> Result<Vec<f64>, EstimateError> {
    let found = Autocorrelation::estimate(map)?;
    let grid = map.grid();
    let (ny, nx) = grid.shape();
    let (half_x, half_y) = ((nx - 1) / 2, (ny - 1) / 2);
    let mut lags = vec![0.0; nx * ny];
    for lag_y in -(half_y as isize)..=half_y as isize {
        for lag_x in -(half_x as isize)..=half_x as isize {
            let covariance = found.covariance_m2(lag_x, lag_y);
            if covariance.is_nan() {
                continue;
            }
            let weight = parzen(lag_x as f64 / (half_x + 1) as f64) * parzen(lag_y as f64 / (half_y + 1) as f64);
            let (row, column) = (lag_y.rem_euclid(ny as isize) as usize, lag_x.rem_euclid(nx as isize) as usize);
            lags[row * nx + column] = weight * covariance;
        }
    }
    let fft = RealFft2::new(nx, ny);
    let mut spectrum = fft.spectrum();
    fft.forward(&lags, &mut spectrum, &mut fft.workspace());
    Ok(spectrum.iter().map(|value| grid.cell_area_m2() * value.re).collect())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::correlation::{CorrelationModel, Covariance};
    use crate::map::Grid;
    use crate::random;
    use crate::surface::{RandomSurface, SpectralField};

    #[test]
    fn the_power_of_a_cosine_is_half_its_amplitude_squared() {
        // Parseval under a window: Σ P₁ Δq/2π over both signs is the windowed mean square, A²/2 for whole periods.
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
    fn profiles_with_missing_points_are_left_out() {
        let grid = Grid::new(16, 5, 1.0, 1.0).unwrap();
        let map = HeightMap::from_function(grid, |x, y| if y < 1.0 && x < 2.0 { f64::NAN } else { x.sin() }).unwrap();
        let found = profile_spectrum(&map, Axis::X).unwrap();
        assert_eq!((found.profiles, found.profiles_left_out), (4, 1));
        let found = profile_spectrum(&map, Axis::Y).unwrap();
        assert_eq!((found.profiles, found.profiles_left_out), (14, 2));
        let diagonal =
            HeightMap::from_function(Grid::new(4, 4, 1.0, 1.0).unwrap(), |x, y| if x == y { f64::NAN } else { x });
        let error = profile_spectrum(&diagonal.unwrap(), Axis::X).unwrap_err();
        assert_eq!(error, EstimateError::NoCompleteProfile { axis: Axis::X, profiles: 4 });
    }

    /// Mean spectra over realisations of a known covariance, with their standard errors, against the model.
    fn against_model(missing_share: f64) {
        let covariance = Covariance::isotropic(CorrelationModel::SelfAffine { hurst: 0.8 }, 2.0, 3.0).unwrap();
        let grid = Grid::new(128, 128, 1.0, 1.0).unwrap();
        let field = SpectralField::periodic(&covariance, grid);
        let spectra: Vec<RadialSpectrum> = (0..24)
            .map(|index| {
                let mut stream = random::stream(11, "radial", index);
                let germ = random::standard_normal(&mut stream, field.germ_len());
                let mask = random::standard_normal(&mut stream, grid.points());
                let cut = crate::law::standard_normal_quantile(missing_share);
                let mut heights = field.generate(&germ).heights_m().clone();
                heights.iter_mut().zip(mask).filter(|(_, m)| *m < cut).for_each(|(z, _)| *z = f64::NAN);
                radial_spectrum(&HeightMap::new(grid, heights).unwrap()).unwrap()
            })
            .collect();
        let route = if missing_share > 0.0 { SpectrumRoute::MaskedCorrelogram } else { SpectrumRoute::Periodogram };
        assert!(spectra.iter().all(|s| s.route == route));
        // Rings where the model is smooth over the window and aliasing is small.
        for ring in [4, 7, 11, 16] {
            let values: Vec<f64> = spectra.iter().map(|s| s.psd_m4[ring]).collect();
            let mean = values.iter().sum::<f64>() / 24.0;
            let error = (values.iter().map(|v| (v - mean).powi(2)).sum::<f64>() / (23.0 * 24.0)).sqrt();
            let wanted = covariance.psd_m4(spectra[0].q_rad_per_m[ring], 0.0);
            // Four standard errors, and 3 % for the curvature within a ring and window, and the folded tail.
            assert!((mean - wanted).abs() < 4.0 * error + 0.03 * wanted, "ring {ring}: {mean} ± {error}, {wanted}");
        }
    }

    #[test]
    fn the_radial_spectrum_of_a_generated_map_is_the_model() {
        against_model(0.0);
    }

    #[test]
    fn scattered_missing_points_do_not_change_the_radial_spectrum() {
        against_model(0.1);
    }

    #[test]
    fn profile_spectra_tell_the_directions_apart() {
        let covariance = Covariance::new(CorrelationModel::SquaredExponential, 1.0, 4.0, 12.0).unwrap();
        let field = SpectralField::periodic(&covariance, Grid::new(128, 128, 1.0, 1.0).unwrap());
        let count = 30;
        let mut sums = [(0.0, 0.0); 2];
        let bin = 4;
        let q = bin as f64 * TAU / 128.0;
        for index in 0..count {
            let germ = random::standard_normal(&mut random::stream(12, "profiles", index), field.germ_len());
            let map = field.generate(&germ);
            for (sum, axis) in sums.iter_mut().zip([Axis::X, Axis::Y]) {
                let value = profile_spectrum(&map, axis).unwrap().psd_m3[bin];
                sum.0 += value;
                sum.1 += value * value;
            }
        }
        for ((sum, square), wanted) in
            sums.into_iter().zip([covariance.profile_psd_x_m3(q), covariance.profile_psd_y_m3(q)])
        {
            let mean = sum / count as f64;
            let error = ((square / count as f64 - mean * mean) / (count - 1) as f64).sqrt();
            // A Hann window adds half the curvature over its variance (4/3 bins² of 2π/L): below 2 % along x, 14 % along y.
            assert!((mean - wanted).abs() < 4.0 * error + 0.14 * wanted, "{mean} ± {error}, wanted {wanted}");
        }
    }
}
