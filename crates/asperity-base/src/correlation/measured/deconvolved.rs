//! The spectrum of a map without the blur of its window.

use std::f64::consts::TAU;

use super::positive::{Spline, Torus};
use crate::correlation::spectrum::hann;
use crate::fourier::{Complex64, RealFft2, good_length};
use crate::map::HeightMap;
use crate::stats::Moments;

/// Number of iterations, and exponent of their factors, which saves a third of them.
const ITERATIONS: usize = 20;
const RELAXATION: f64 = 1.5;
/// Largest wavenumber of the long waves, in periods per side of the map, within the main lobe of the window.
const LONG: f64 = 2.0;
/// Smallest factor on the long waves, if the middle of the map is rougher than its edges.
const LEAST_FACTOR: f64 = 0.1;
/// Number of coefficients of a spline that its value at a lag needs on either side.
const SPLINE_REACH: usize = 2;

/// Returns the most likely correlation of a complete map on a torus of twice its sides: blurred by the spectrum of the data
/// window, its spectrum is the periodogram of the map.
///
/// The window is Hann's. The iterations of Richardson and Lucy multiply the spectrum by the
/// blurred ratio of the periodogram and the blurred spectrum, so it stays non-negative. The result has the period of the
/// torus, and is positive semi-definite on it.
///
/// # References
/// Richardson, *J. Opt. Soc. Am.* **62** (1972) 55, <https://doi.org/10.1364/JOSA.62.000055>; Lucy, *Astron. J.* **79**
/// (1974) 745, <https://doi.org/10.1086/111605>.
pub(super) fn deconvolved(map: &HeightMap) -> Spline {
    let (ny, nx) = map.grid().shape();
    let torus = Torus { fft: RealFft2::new(good_length(2 * nx), good_length(2 * ny)) };
    let (along_x, along_y) = (hann(nx), hann(ny));
    let weights = along_y.iter().flat_map(|y| along_x.iter().map(move |x| y * x));
    let heights_m: Vec<f64> = map.present_m().collect();
    let (squares, sum) =
        weights.clone().zip(&heights_m).fold((0.0, 0.0), |(squares, sum), (w, z)| (squares + w * w, sum + w * w * z));
    let mean_m = sum / squares;
    let power = |value: &dyn Fn(f64) -> f64| {
        let mut values = vec![0.0; torus.fft.nx() * torus.fft.ny()];
        for (place, (w, z)) in weights.clone().zip(&heights_m).enumerate() {
            values[place / nx * torus.fft.nx() + place % nx] = w * value(*z) / squares.sqrt();
        }
        torus.transform(&values).into_iter().map(|amplitude| amplitude.norm_sqr()).collect::<Vec<f64>>()
    };
    let complex = |spectrum: &[f64]| spectrum.iter().map(|value| Complex64::from(*value)).collect::<Vec<_>>();
    let lag_window = torus.values(complex(&power(&|_| 1.0)));
    let blur = |spectrum: &[f64]| {
        let mut lags = torus.values(complex(spectrum));
        lags.iter_mut().zip(&lag_window).for_each(|(value, window)| *value *= window);
        torus.transform(&lags).into_iter().map(|value| value.re).collect::<Vec<f64>>()
    };
    let periodogram = power(&|z| z - mean_m);
    let least = f64::EPSILON * periodogram.iter().copied().fold(f64::MIN_POSITIVE, f64::max);
    let mut spectrum = periodogram.clone();
    for _ in 0..ITERATIONS {
        let blurred = blur(&spectrum);
        let ratios: Vec<f64> = periodogram.iter().zip(&blurred).map(|(met, own)| met / own.max(least)).collect();
        for (value, ratio) in spectrum.iter_mut().zip(blur(&ratios)) {
            *value *= ratio.max(0.0).powf(RELAXATION);
        }
    }
    // The window hides the edges, where waves as long as the map are highest: they get the rest of the variance.
    let is_long = |place: usize| {
        let (x, y) = torus.wavevector(place, |x, y| (x * nx as f64 / TAU, y * ny as f64 / TAU));
        x.hypot(y) <= LONG
    };
    let total = |wanted: bool| {
        let part = spectrum.iter().enumerate().filter(|(place, _)| is_long(*place) == wanted);
        part.map(|(place, value)| torus.multiplicity(place) * value).sum::<f64>() / torus.points()
    };
    let (long, short) = (total(true), total(false));
    let variance = Moments::new(&heights_m).std.powi(2);
    let factor = ((variance - short) / long).max(LEAST_FACTOR);
    let scale = 1.0 / (factor * long + short);
    let scaled = |(place, value): (usize, &f64)| scale * value * if is_long(place) { factor } else { 1.0 };
    let spectrum: Vec<f64> = spectrum.iter().enumerate().map(scaled).collect();
    torus.spline(complex(&spectrum), torus.fft.nx() / 2 + SPLINE_REACH, torus.fft.ny() / 2 + SPLINE_REACH)
}
