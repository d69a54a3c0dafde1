//! The covariance of a measured map, without a model.

mod deconvolved;
mod positive;
mod taper;

use std::f64::consts::TAU;

use ndarray::Array2;
use thiserror::Error;

use self::deconvolved::deconvolved;
use self::positive::{Beneath, PositiveCorrelation, Spline, made_positive};
use self::taper::Taper;
use super::estimate::{Autocorrelation, EstimateError};
use super::model::StationaryCovariance;
use asperity_results::EmpiricalCovariance;

use crate::fourier::{RealFft2, good_length};
use crate::map::HeightMap;

/// Least number of independent patches N/Σρ² of a map for an estimate of its correlation.
const FEWEST_PATCHES: f64 = 10.0;

/// An autocorrelation that cannot be made a covariance.
#[derive(Debug, Clone, PartialEq, Error)]
#[non_exhaustive]
pub enum MeasuredCovarianceError {
    /// A correlation so long that the map contains only a few independent patches.
    #[error(
        "the correlation reaches so far that the map holds only {patches:.1} independent patches, at least {wanted} are \
         needed: it is too short for its roughness or still has form to remove"
    )]
    FewPatches {
        /// Number of independent patches: points over the sum of squared correlations, N/Σρ².
        patches: f64,
        /// Least number of patches.
        wanted: f64,
    },
    /// Failed estimate of the autocorrelation.
    #[error(transparent)]
    Estimate(#[from] EstimateError),
    /// No pair of present heights at a lag next to zero.
    #[error("no two neighbouring heights are present, so the correlation near zero is unknown")]
    NoPairs,
}

/// Covariance of a measured map: its own autocorrelation, corrected to a positive semi-definite function.
///
/// It is derived from an [`Autocorrelation`] in six steps, whose changes [`EmpiricalCovariance`] lists:
///
/// 1. *Slope.* Near zero the correlation is 1 − γ/σ² with the semivariance γ, whose errors are relative to γ; it is
///    blended into the autocorrelation as the taper falls. The autocorrelation has a kink at zero, due to the heights
///    at the edges, which would change the roughness at the shortest wavelengths.
/// 2. *Mean.* With the subtracted mean the expectation of the estimate is (ρ − β)/(1 − β), where β is the mean of ρ
///    over all pairs of points. β follows from the estimate with zero lags beyond the taper, and corrects ρ and σ².
/// 3. *Taper.* Lags have full weight up to 1.5 times the range in which they exceed their standard error √(Σρ²/N), N
///    the pairs of a lag (Bartlett), and no weight beyond twice that, or beyond half of the map. Distance is measured
///    by the ellipse of the central lobe ρ > 0.2, so that the taper follows a texture at any angle. The flat top leaves
///    short lags unchanged. Along an axis on which the lobe extends beyond a quarter of the map, or along both if the
///    correlation does not decay, as on a periodic surface, Bohman's window over all estimated lags replaces it; this
///    is positive semi-definite and shortens the correlation smoothly.
/// 4. *Balancing.* Negative values of the tapered spectrum are set to zero and compensated by the positive values at
///    similar wavevectors, so that the noise of the estimate leaves no floor.
/// 5. *Square root.* The square root of that spectrum is a moving average, truncated at the end of the taper. The
///    covariance is the autocorrelation of this finite sequence, scaled to the variance, so it is positive
///    semi-definite on the infinite lattice and ends at twice the taper.
/// 6. *Interpolation* by cubic B-splines through the lags. It multiplies the spectrum by a positive factor that falls
///    off beyond the Nyquist wavenumber, so the covariance is positive semi-definite at every pitch and adds no
///    roughness at finer ones.
///
/// ρ(−x, −y) = ρ(x, y); ρ(−x, y) may differ.
///
/// # References
/// Politis & Romano, *J. Time Ser. Anal.* **16** (1995) 67, <https://doi.org/10.1111/j.1467-9892.1995.tb00223.x>;
/// Politis, *J. Nonparametr. Stat.* **15** (2003) 517, <https://doi.org/10.1080/10485250310001604659> (flat-top tapers
/// and where to end them); Unser, *IEEE Signal Process. Mag.* **16** (6) (1999) 22, <https://doi.org/10.1109/79.799930>
/// (splines).
#[derive(Debug, Clone)]
pub struct MeasuredCovariance {
    std_m: f64,
    spline: Spline,
    dx_m: f64,
    dy_m: f64,
    report: EmpiricalCovariance,
}

impl MeasuredCovariance {
    /// Creates the covariance of a map, from its autocorrelation at all lags.
    ///
    /// # Errors
    /// Heights that do not vary, a map of few independent patches, or no pair of neighbours.
    pub fn from_map(map: &HeightMap) -> Result<Self, MeasuredCovarianceError> {
        let grid = map.grid();
        Self::new(&Autocorrelation::within(map, grid.nx() - 1, grid.ny() - 1)?.and_semivariance(map))
    }

    /// Creates the covariance from an autocorrelation of the map. Without [`Autocorrelation::and_semivariance`] the
    /// kink at zero lag remains. An estimate at all lags of the map retains most of a correlation that does not decay
    /// within it.
    ///
    /// # Errors
    /// A map of few independent patches, or no pair of neighbours.
    pub fn new(estimate: &Autocorrelation) -> Result<Self, MeasuredCovarianceError> {
        let grid = estimate.grid();
        let (reach_x, reach_y) = estimate.reach();
        if reach_x.min(reach_y) == 0 || estimate.pairs(1, 0) + estimate.pairs(0, 1) == 0.0 {
            return Err(MeasuredCovarianceError::NoPairs);
        }
        let taper = Taper::new(estimate);
        let patches = taper.standard_error().powi(-2);
        if patches < FEWEST_PATCHES {
            return Err(MeasuredCovarianceError::FewPatches { patches, wanted: FEWEST_PATCHES });
        }
        let mean_fraction = mean_fraction(estimate, &taper);
        // Rows are lags 0 … along y, columns all lags along x.
        let (reach_x, reach_y) = taper.reach();
        let mut taper_change = 0.0_f64;
        let tapered = Array2::from_shape_fn((reach_y + 1, 2 * reach_x + 1), |(row, column)| {
            let (lag_x, lag_y) = (column as isize - reach_x as isize, row as isize);
            let estimated = estimate.correlation(lag_x, lag_y);
            if estimated.is_nan() {
                return 0.0;
            }
            let weight = taper.weight(lag_x, lag_y);
            let semivariance = estimate.semivariance_m2(lag_x, lag_y).map(|gamma| gamma / estimate.variance_m2());
            let near = semivariance.map_or(0.0, |gamma| weight * (1.0 - gamma - estimated));
            let rho = (1.0 - mean_fraction) * (estimated + near) + mean_fraction;
            taper_change = taper_change.max(((1.0 - weight) * rho).abs());
            weight * rho
        });
        let PositiveCorrelation { spline, clipped_variance, largest_change } =
            made_positive(&tapered, |x, y| taper.wavevector(x, y));
        let (reliable_x_m, reliable_y_m) = taper.reliable_m();
        let (decayed_x, decayed_y) = taper.decayed();
        let report = EmpiricalCovariance {
            mean_share: mean_fraction,
            standard_error: taper.standard_error(),
            reliable_x_m,
            reliable_y_m,
            decayed_x,
            decayed_y,
            taper_change,
            clipped_variance,
            clipping_change: largest_change,
        };
        let std_m = (estimate.variance_m2() / (1.0 - mean_fraction)).sqrt();
        Ok(Self { std_m, spline, dx_m: grid.dx_m(), dy_m: grid.dy_m(), report })
    }

    /// Returns the covariance of fields that have the waves of `map` as sharp as its grid shows them, within the map.
    ///
    /// The correlation is not tapered, so grooves do not end and steep spectra have no floor. It is that of the most
    /// likely non-negative spectrum on a torus of twice the sides of the map, repeats with that period, and contains
    /// the noise of the spectrum of one map. Other grids need [`MeasuredCovariance::from_map`], and so do maps with
    /// voids, unless they are filled.
    ///
    /// # Panics
    /// If a height is missing.
    #[must_use]
    pub fn deconvolved(&self, map: &HeightMap) -> Self {
        assert_eq!(map.missing_points(), 0, "the spectrum of a map with voids is not deconvolved");
        let grid = map.grid();
        let report = EmpiricalCovariance {
            reliable_x_m: grid.width_m(),
            reliable_y_m: grid.height_m(),
            taper_change: 0.0,
            clipped_variance: 0.0,
            clipping_change: 0.0,
            ..self.report
        };
        Self { spline: deconvolved(map), report, ..*self }
    }

    /// Returns the same correlation with another standard deviation of the heights.
    #[must_use]
    pub fn with_std(self, std_m: f64) -> Self {
        Self { std_m, ..self }
    }

    /// Returns the same correlation with lags scaled by `factor`.
    #[must_use]
    pub fn stretched(self, factor: f64) -> Self {
        Self { dx_m: factor * self.dx_m, dy_m: factor * self.dy_m, ..self }
    }

    /// Returns the covariance of a Gaussian field that, after a translation with the correlation distortion ρ ↦ T(ρ) in
    /// `distortion`, has the slopes of this one.
    ///
    /// The spectrum is first adapted so that the distorted correlation has the spectrum of this one, as closely as a
    /// positive spectrum permits. A translation with heavy tails turns long waves into short ones; the remaining excess
    /// or deficit of slope is removed by the factor (1 + q²/q₀²)^{−w}, q₀ = `corner_rad_per_m`, with w such that
    /// `slope_ratio` of the result is 1.
    #[must_use]
    pub fn beneath(
        &self,
        distortion: impl Fn(f64) -> f64,
        corner_rad_per_m: f64,
        slope_ratio: impl Fn(&Self) -> f64,
    ) -> Self {
        /// Step and bound of the search for w, and the tolerance of the logarithm of the ratio.
        const STEPS: usize = 8;
        const LARGEST: f64 = 4.0;
        const TOLERANCE: f64 = 0.01;

        let beneath = Beneath::new(&self.spline, distortion);
        let square = |phase: f64, pitch_m: f64| (phase / (pitch_m * corner_rad_per_m)).powi(2);
        let with = |w: f64| {
            let spline = beneath.spline(|x, y| (1.0 + square(x, self.dx_m) + square(y, self.dy_m)).powf(-w));
            let found = Self { spline, ..self.clone() };
            let error = slope_ratio(&found).ln();
            (found, error)
        };
        // Secant step through the last two points; d ln r/dw is about −1.
        let (mut best, mut error) = with(0.0);
        let (mut w, mut slope) = (0.0, -1.0);
        for _ in 0..STEPS {
            if error.abs() < TOLERANCE || !error.is_finite() {
                break;
            }
            let next = (w - error / slope).clamp(-LARGEST, LARGEST);
            let (found, left) = with(next);
            if left.abs() >= error.abs() || next == w {
                break;
            }
            slope = ((left - error) / (next - w)).min(-0.05);
            (best, error, w) = (found, left, next);
        }
        best
    }

    /// Returns the power spectral density P₁(q) = ∫ C(x, 0) e^{−iqx} dx of profiles along x in m³, at q in rad/m.
    ///
    /// It equals the spectrum of the lags times the factor of the spline interpolation, which falls as q⁻⁴ beyond their
    /// Nyquist wavenumber π/dx, where the map contains no information.
    pub fn profile_psd_x_m3(&self, q_rad_per_m: f64) -> f64 {
        self.profile_psd_m3(q_rad_per_m * self.dx_m, self.spline.reach().0, |k| self.spline.value(k, 0.0)) * self.dx_m
    }

    /// Returns the power spectral density of profiles along y; see [`MeasuredCovariance::profile_psd_x_m3`].
    pub fn profile_psd_y_m3(&self, q_rad_per_m: f64) -> f64 {
        self.profile_psd_m3(q_rad_per_m * self.dy_m, self.spline.reach().1, |k| self.spline.value(0.0, k)) * self.dy_m
    }

    /// In m² per lag, at a phase per lag.
    fn profile_psd_m3(&self, phase: f64, reach: usize, correlation: impl Fn(f64) -> f64) -> f64 {
        let lags: f64 = (1..=reach).map(|k| k as f64).map(|k| 2.0 * correlation(k) * (phase * k).cos()).sum();
        self.std_m * self.std_m * (1.0 + lags) * spline_factor(phase)
    }

    /// Returns the average of the two-dimensional power spectral density P(q) = ∬ C e^{−iq·x} d²x in m⁴ over the
    /// directions, at each of the wavenumbers in rad/m: averages over rings as wide as the spectral resolution of the
    /// covariance, interpolated linearly.
    pub fn radial_psd_m4(&self, q_rad_per_m: &[f64]) -> Vec<f64> {
        let (reach_x, reach_y) = self.spline.reach();
        let fft = RealFft2::new(good_length(2 * reach_x + 1), good_length(2 * reach_y + 1));
        let (nx, ny) = (fft.nx(), fft.ny());
        // Lags and wavevectors from zero in both directions.
        let signed = |k: usize, n: usize| if 2 * k <= n { k as f64 } else { k as f64 - n as f64 };
        let mut lags = vec![0.0; nx * ny];
        for (place, lag) in lags.iter_mut().enumerate() {
            *lag = self.spline.value(signed(place % nx, nx), signed(place / nx, ny));
        }
        let mut spectrum = fft.spectrum();
        fft.forward(&lags, &mut spectrum, &mut fft.workspace());
        let (step_x, step_y) = (TAU / (nx as f64 * self.dx_m), TAU / (ny as f64 * self.dy_m));
        let width = step_x.max(step_y);
        // Sums of wavenumbers and densities, and number of wavevectors, of every ring.
        let mut rings: Vec<(f64, f64, f64)> = vec![];
        for (place, value) in spectrum.iter().enumerate() {
            let (kx, ky) = ((place / ny) as f64, signed(place % ny, ny));
            let factor = spline_factor(TAU * kx / nx as f64) * spline_factor(TAU * ky / ny as f64);
            let q = (kx * step_x).hypot(ky * step_y);
            let ring = (q / width).round() as usize;
            if ring >= rings.len() {
                rings.resize(ring + 1, (0.0, 0.0, 0.0));
            }
            let times = fft.multiplicity(place / ny);
            rings[ring].0 += times * q;
            rings[ring].1 += times * value.re * factor;
            rings[ring].2 += times;
        }
        let unit = self.std_m * self.std_m * self.dx_m * self.dy_m;
        let means: Vec<(f64, f64)> =
            rings.iter().filter(|ring| ring.2 > 0.0).map(|(q, p, n)| (q / n, unit * p / n)).collect();
        let at = |q: &f64| {
            let after = means.partition_point(|(ring, _)| ring < q).clamp(1, means.len() - 1);
            let ((q0, p0), (q1, p1)) = (means[after - 1], means[after]);
            p0 + (p1 - p0) * ((q - q0) / (q1 - q0)).clamp(0.0, 1.0)
        };
        q_rad_per_m.iter().map(at).collect()
    }

    /// Returns the changes made to the autocorrelation.
    pub fn report(&self) -> EmpiricalCovariance {
        self.report
    }

    /// Returns the covariance σ²ρ at the lag (dx, dy) in metre, in m².
    pub fn value_m2(&self, dx_m: f64, dy_m: f64) -> f64 {
        self.std_m * self.std_m * self.correlation(dx_m, dy_m)
    }

    /// Returns the lags along x and y in metre beyond which the covariance is zero.
    pub fn support_m(&self) -> (f64, f64) {
        let (x, y) = self.spline.reach();
        (x as f64 * self.dx_m, y as f64 * self.dy_m)
    }
}

impl StationaryCovariance for MeasuredCovariance {
    fn std_m(&self) -> f64 {
        self.std_m
    }

    fn correlation(&self, dx_m: f64, dy_m: f64) -> f64 {
        if dx_m == 0.0 && dy_m == 0.0 { 1.0 } else { self.spline.value(dx_m / self.dx_m, dy_m / self.dy_m) }
    }
}

/// Returns the transform of the cardinal cubic spline (one at zero, zero at every other lag) over the pitch, at a phase
/// per lag.
fn spline_factor(phase: f64) -> f64 {
    let half = 0.5 * phase;
    let sinc = if half == 0.0 { 1.0 } else { half.sin() / half };
    3.0 * sinc.powi(4) / (2.0 + phase.cos())
}

/// Returns the mean β of ρ over all pairs of points, from the estimate (ρ − β)/(1 − β) within the taper w and zero
/// beyond it.
///
/// With N pairs at a lag, β = Σ N w ((1 − β)ρ̂ + β)/Σ N, which is linear in β.
fn mean_fraction(estimate: &Autocorrelation, taper: &Taper) -> f64 {
    let (reach_x, reach_y) = estimate.reach();
    let (reach_x, reach_y) = (reach_x as isize, reach_y as isize);
    // Every point makes a pair with every other and with itself.
    let all = estimate.all_pairs();
    let (mut weights, mut products) = (0.0, 0.0);
    for lag_y in 0..=reach_y {
        // Count a lag and its opposite.
        let times = if lag_y == 0 { 1.0 } else { 2.0 };
        for lag_x in -reach_x..=reach_x {
            let pairs = times * estimate.pairs(lag_x, lag_y);
            let weight = taper.weight(lag_x, lag_y);
            if weight > 0.0 && pairs > 0.0 {
                weights += pairs * weight;
                products += pairs * weight * estimate.correlation(lag_x, lag_y);
            }
        }
    }
    let (weights, products) = (weights / all, products / all);
    // An oscillating correlation can give a negative value, which is not a variance of a mean.
    (products / (1.0 - weights + products)).max(0.0)
}
