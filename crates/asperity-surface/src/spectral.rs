//! Stationary Gaussian surfaces by Fourier synthesis.

mod modes;
mod periodic;
#[cfg(test)]
mod round_trip;

use ndarray::Array2;

use super::gaussian::{check_xi, map_of, row_order};
use super::{GaussianSurface, GeneratorError, RandomSurface};
use asperity_base::correlation::StationaryCovariance;
use asperity_base::fourier::{Complex64, RealFft2, good_length};
use asperity_base::map::{Grid, HeightMap};

pub(super) use modes::{FourierModes, WrappedSpectrum, wrapped_eigenvalues_m2, wrapped_spectrum};
pub(super) use periodic::OnPeriod;

/// Fraction of negative circulant variance that counts as rounding.
pub(crate) const NEGLIGIBLE: f64 = 1e-12;
/// Largest side of an embedding domain over the side of the grid, and its largest number of points.
const LARGEST_FACTOR: usize = 64;
const LARGEST_DOMAIN: usize = 1 << 24;

/// Stationary Gaussian surface z = σ Σ_q √(λ_q/A) (…) over the Fourier modes of a periodic domain of area A.
///
/// ξ contains one standard normal variable per degree of freedom of the domain (a cosine and a sine per pair ±q),
/// sorted by falling variance. One inverse transform generates a map. Every point has the same variance.
///
/// - [`SpectralField::periodic`]: λ from the covariance wrapped onto the grid, which *is* then the ensemble covariance.
///   Where the covariance has not decayed at half a side and the wrapped one has negative eigenvalues, λ is the mean
///   spectral density over the band of each wavevector: the waves of the surface, without others, on a period too short
///   for their correlation.
/// - [`SpectralField::free`]: a crop of a larger periodic domain on which the wrapped covariance is non-negative
///   (circulant embedding), so that opposite edges have only the correlation that the covariance states.
///
/// # References
/// Dietrich & Newsam, *SIAM J. Sci. Comput.* **18** (1997) 1088, <https://doi.org/10.1137/S1064827592240555>;
/// Wu, *Tribol. Int.* **33** (2000) 47, <https://doi.org/10.1016/S0301-679X(00)00016-5>.
#[derive(Debug, Clone)]
pub struct SpectralField {
    grid: Grid,
    std_m: f64,
    modes: FourierModes,
    clipped_variance: f64,
}

impl SpectralField {
    /// Creates a field on the periodic `grid`.
    pub fn periodic(covariance: &dyn StationaryCovariance, grid: Grid) -> Self {
        let (fft, spectrum) = periodic_spectrum(covariance, grid);
        Self::from_spectrum(grid, grid, fft, covariance.std_m(), &spectrum)
    }

    /// Creates a field that is not periodic on `grid`, with the exact covariance if the embedding is non-negative.
    ///
    /// The domain starts at twice the grid. While negative eigenvalues have more than 1e−12 of the variance, the side
    /// across which the covariance has decayed less is doubled, up to 64 times the grid or 2²⁴ points. The remaining
    /// negative eigenvalues are clipped and reported.
    ///
    /// # Errors
    /// Only if the padded grid is invalid; never for a valid grid otherwise.
    pub fn free(covariance: &dyn StationaryCovariance, grid: Grid) -> Result<Self, GeneratorError> {
        let (domain, fft, spectrum) = embedding(covariance, grid, 2, good_length)?;
        Ok(Self::from_spectrum(grid, domain, fft, covariance.std_m(), &spectrum))
    }

    /// Returns the same field with ξ in the order of wavevectors, which is the same for all covariances.
    ///
    /// In the order of variance, a variable belongs to another wave as soon as the covariance changes, and rounding
    /// decides the order of two waves of one variance. In the order of wavevectors, ξ means the same waves in fields of
    /// different covariance on one grid. Free fields may have domains of different size, for which this does not hold.
    #[must_use]
    pub fn by_wavevector(mut self) -> Self {
        self.modes.sort_by_place();
        self
    }

    /// Returns the same field without the waves that are shorter than a length in metre, scaled to the same standard deviation, and
    /// the fraction of the variance in the others. The variables of the removed waves stay in ξ without effect. A field of shorter
    /// waves alone is returned as it is.
    pub(crate) fn without_waves_below(mut self, shortest_m: f64) -> (Self, f64) {
        let kept = self.modes.remove_waves_below(shortest_m, self.grid);
        (self, kept)
    }

    /// Returns the modes, on the grid itself or on the embedding of a free field.
    pub(super) fn modes(&self) -> &FourierModes {
        &self.modes
    }

    /// Creates a crop of `domain` with given eigenvalues.
    pub(super) fn from_spectrum(
        grid: Grid,
        domain: Grid,
        fft: RealFft2,
        std_m: f64,
        spectrum: &WrappedSpectrum,
    ) -> Self {
        let modes = FourierModes::new(domain, fft, &spectrum.eigenvalues_m2);
        Self { grid, std_m, modes, clipped_variance: spectrum.clipped }
    }

    /// Returns the map of a spectrum of its modes.
    fn map_of(&self, spectrum: Vec<Complex64>) -> HeightMap {
        let mut heights = self.modes.inverse(spectrum, self.grid.ny(), self.grid.nx());
        heights.iter_mut().for_each(|z| *z *= self.std_m);
        map_of(self.grid, heights)
    }

    /// Returns the fraction of the variance in negative eigenvalues on the largest domain that was tried. They are set to
    /// zero and the others scaled to conserve the variance, so the covariance deviates from the requested one by about
    /// this much.
    pub fn clipped_variance(&self) -> f64 {
        self.clipped_variance
    }
}

/// Returns the spectrum of periodic fields on `grid`, with its transforms.
pub(super) fn periodic_spectrum(covariance: &dyn StationaryCovariance, grid: Grid) -> (RealFft2, WrappedSpectrum) {
    let periodic = OnPeriod::new(covariance, grid);
    let fft = RealFft2::new(grid.nx(), grid.ny());
    let spectrum = wrapped_spectrum(&periodic, grid, &fft);
    (fft, WrappedSpectrum { clipped: periodic.clipped.max(spectrum.clipped), ..spectrum })
}

/// Returns a periodic domain on which the covariance has no negative eigenvalues, or the largest one that was tried, with its
/// transforms and its spectrum. Its sides are those of the grid times a power of two of at least `least`, lengthened by `length`.
fn embedding(
    covariance: &dyn StationaryCovariance,
    grid: Grid,
    least: usize,
    length: fn(usize) -> usize,
) -> Result<(Grid, RealFft2, WrappedSpectrum), GeneratorError> {
    let (mut factor_x, mut factor_y) = (least, least);
    loop {
        let (nx, ny) = (length(factor_x * grid.nx()), length(factor_y * grid.ny()));
        let domain = Grid::new(nx, ny, grid.dx_m(), grid.dy_m())?;
        let fft = RealFft2::new(domain.nx(), domain.ny());
        let spectrum = wrapped_spectrum(covariance, domain, &fft);
        let (across_x, across_y) = largest_across(covariance, domain);
        let factor = if across_x > across_y { &mut factor_x } else { &mut factor_y };
        if spectrum.clipped < NEGLIGIBLE || *factor >= LARGEST_FACTOR || 2 * domain.points() > LARGEST_DOMAIN {
            return Ok((domain, fft, spectrum));
        }
        *factor *= 2;
    }
}

/// Returns the number of normal variables of a field: the points of the grid, or of the larger domain of a free field.
pub(crate) fn variables(covariance: &dyn StationaryCovariance, grid: Grid, periodic: bool) -> usize {
    if periodic {
        grid.points()
    } else {
        embedding(covariance, grid, 2, good_length).map_or(grid.points(), |(domain, ..)| domain.points())
    }
}

/// Returns the largest |ρ| at which a periodic domain closes along x, and along y. Without an oblique lay both are on
/// the axes.
fn largest_across(covariance: &dyn StationaryCovariance, domain: Grid) -> (f64, f64) {
    const STEPS: usize = 64;
    let (half_x, half_y) = (0.5 * domain.width_m(), 0.5 * domain.height_m());
    let along = |value: &dyn Fn(f64) -> f64| {
        if covariance.mirror_symmetric() {
            return value(0.0).abs();
        }
        (0..=STEPS).map(|i| value(2.0 * i as f64 / STEPS as f64 - 1.0).abs()).fold(0.0, f64::max)
    };
    (along(&|t| covariance.correlation(half_x, t * half_y)), along(&|t| covariance.correlation(t * half_x, half_y)))
}

impl RandomSurface for SpectralField {
    fn xi_len(&self) -> usize {
        self.modes.len()
    }

    fn grid(&self) -> Grid {
        self.grid
    }

    fn generate(&self, xi: &[f64]) -> HeightMap {
        check_xi(xi, self.xi_len());
        self.map_of(self.modes.excited(xi))
    }

    fn generate_from(&self, xi: Vec<f64>) -> HeightMap {
        check_xi(&xi, self.xi_len());
        let spectrum = self.modes.excited(&xi);
        drop(xi);
        self.map_of(spectrum)
    }

    fn xi_response(&self, weights: &Array2<f64>) -> Option<Vec<f64>> {
        let weights = row_order(weights, self.grid);
        let mut response = self.modes.analyse(&weights, self.grid.ny(), self.grid.nx());
        response.iter_mut().for_each(|value| *value *= self.std_m);
        Some(response)
    }

    fn is_periodic_and_stationary(&self) -> bool {
        let fft = self.modes.fft();
        (fft.ny(), fft.nx()) == self.grid.shape()
    }
}

impl GaussianSurface for SpectralField {
    fn pointwise_std_m(&self) -> Array2<f64> {
        Array2::from_elem(self.grid.shape(), self.std_m)
    }

    fn covariance_with_m2(&self, row: usize, column: usize) -> Array2<f64> {
        let correlation = self.modes.covariance_with(row, column, self.grid.ny(), self.grid.nx());
        let variance = self.std_m * self.std_m;
        Array2::from_shape_fn(self.grid.shape(), |(r, c)| variance * correlation[r * self.grid.nx() + c])
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use asperity_base::correlation::{CorrelationModel, Covariance, Rotated};
    use asperity_base::random;

    fn model(model: CorrelationModel, length_x_m: f64, length_y_m: f64) -> Covariance {
        Covariance::new(model, 2.0, length_x_m, length_y_m).unwrap()
    }

    /// Returns the least image of a lag of `n` points.
    fn wrapped(lag: usize, n: usize) -> f64 {
        lag.min(n - lag) as f64
    }

    #[test]
    fn the_covariance_of_the_modes_is_the_wrapped_model() {
        let covariance = model(CorrelationModel::Exponential, 3.0, 1.5);
        for (nx, ny) in [(24, 16), (15, 24), (24, 9)] {
            let field = SpectralField::periodic(&covariance, Grid::new(nx, ny, 1.0, 0.5).unwrap());
            assert_eq!(field.xi_len(), nx * ny);
            assert!(field.clipped_variance() < 1e-12);
            let met = field.covariance_with_m2(4, 7);
            for ((row, column), value) in met.indexed_iter() {
                let (dx, dy) = (wrapped(column.abs_diff(7), nx), 0.5 * wrapped(row.abs_diff(4), ny));
                let wanted = covariance.value_m2(dx, dy);
                assert!((value - wanted).abs() < 1e-12, "{nx}x{ny} ({row},{column}): {value} {wanted}");
            }
        }
    }

    #[test]
    fn each_normal_variable_excites_a_mode_of_its_own_variance() {
        // z is linear in ξ, so Σ_j z_j(x)z_j(x₀) over unit vectors ξ is the covariance, without sampling error.
        let grid = Grid::new(12, 10, 1.0, 1.0).unwrap();
        let field = SpectralField::periodic(&model(CorrelationModel::Matern { nu: 1.5 }, 1.5, 1.0), grid);
        let mut met = Array2::<f64>::zeros(grid.shape());
        let mut last = f64::INFINITY;
        for j in 0..field.xi_len() {
            let mut xi = vec![0.0; field.xi_len()];
            xi[j] = 1.0;
            let mode = field.generate(&xi).heights_m().clone();
            let power = mode.mapv(|z| z * z).sum();
            assert!(power <= last * (1.0 + 1e-12), "mode {j} is larger than the one before");
            last = power;
            met.scaled_add(mode[[2, 3]], &mode);
        }
        let wanted = field.covariance_with_m2(2, 3);
        assert!(met.iter().zip(&wanted).all(|(a, b)| (a - b).abs() < 1e-12));
        assert!((wanted[[2, 3]] - field.pointwise_std_m()[[2, 3]].powi(2)).abs() < 1e-12);
    }

    #[test]
    fn a_field_without_short_waves_has_the_variance_of_the_long_ones() {
        // The density of e^{−r²/ℓ²} is a Gaussian in q: the waves up to Q have 1 − e^{−Q²ℓ²/4} of the variance.
        let (length_m, shortest_m) = (6.0, 16.0);
        let grid = Grid::new(192, 160, 1.0, 1.25).unwrap();
        let covariance = model(CorrelationModel::SquaredExponential, length_m, length_m);
        let (field, kept) = SpectralField::periodic(&covariance, grid).without_waves_below(shortest_m);
        let q = std::f64::consts::TAU / shortest_m;
        assert!((kept / (1.0 - (-0.25 * (q * length_m).powi(2)).exp()) - 1.0).abs() < 0.01, "{kept}");
        let xi = random::standard_normal(&mut random::stream(2, "long waves", 0), field.xi_len());
        let map = field.generate(&xi);
        let rest = crate::filter::Respaced::cut(&map, crate::filter::Edges::Periodic, shortest_m).generate(&[]);
        let largest = (map.heights_m() - rest.heights_m()).iter().fold(0.0_f64, |most, z| most.max(z.abs()));
        assert!(largest < 1e-12, "{largest}");
        // The others have the whole variance.
        assert!((field.covariance_with_m2(3, 4)[[3, 4]] / 4.0 - 1.0).abs() < 1e-12);
    }

    #[test]
    fn a_crop_of_an_embedding_has_the_model_covariance_without_wrapping() {
        for kind in [
            CorrelationModel::Exponential,
            CorrelationModel::SquaredExponential,
            CorrelationModel::SelfAffine { hurst: 0.8 },
        ] {
            let covariance = model(kind, 4.0, 6.0);
            let field = SpectralField::free(&covariance, Grid::new(20, 17, 1.0, 1.0).unwrap()).unwrap();
            assert!(field.clipped_variance() < 1e-9, "{kind:?}: {}", field.clipped_variance());
            let met = field.covariance_with_m2(0, 0);
            for ((row, column), value) in met.indexed_iter() {
                let error = (value - covariance.value_m2(column as f64, row as f64)).abs();
                assert!(error < 1e-8, "{kind:?} at ({row},{column}): {error:e}");
            }
        }
    }

    #[test]
    fn an_oblique_lay_keeps_its_angle_periodic_and_free() {
        let ridge = Rotated::new(model(CorrelationModel::SquaredExponential, 9.0, 2.0), 0.7).unwrap();
        for (nx, ny) in [(48, 40), (47, 41)] {
            let grid = Grid::new(nx, ny, 1.0, 1.0).unwrap();
            for field in [SpectralField::periodic(&ridge, grid), SpectralField::free(&ridge, grid).unwrap()] {
                assert!(field.clipped_variance() < 1e-5, "{}", field.clipped_variance());
                let met = field.covariance_with_m2(20, 23);
                for (x, y) in [(0, 0), (5, 4), (-5, 4), (5, -4), (-5, -4), (10, 8), (1, 0), (0, -1)] {
                    let value = met[[(20 + y) as usize, (23 + x) as usize]];
                    let wanted = 4.0 * ridge.correlation(f64::from(x), f64::from(y));
                    assert!((value - wanted).abs() < 1e-4, "({x}, {y}): {value} {wanted}");
                }
                // Along the ridge the correlation falls as e^{−(r/9)²}, across it as e^{−(r/2)²}.
                let along = met[[20 + 4, 23 + 5]] / met[[20, 23]];
                let r = (5.0 * 0.7_f64.cos() + 4.0 * 0.7_f64.sin()).powi(2) / 81.0
                    + (4.0 * 0.7_f64.cos() - 5.0 * 0.7_f64.sin()).powi(2) / 4.0;
                assert!((along - (-r).exp()).abs() < 1e-5);
            }
        }
    }

    #[test]
    fn a_narrow_strip_is_padded_across_but_not_along() {
        let covariance = model(CorrelationModel::SquaredExponential, 12.0, 12.0);
        let field = SpectralField::free(&covariance, Grid::new(256, 8, 1.0, 1.0).unwrap()).unwrap();
        assert!(field.clipped_variance() < 1e-12);
        // The wrap across must reach e^{−(L/2ℓ)²} ≲ 1e−13, L ≥ 11ℓ = 131: 8 × 16 points. Along the strip, twice its
        // length suffices.
        assert_eq!(field.xi_len(), 512 * 128);
        let met = field.covariance_with_m2(0, 0);
        assert!((met[[7, 20]] - covariance.value_m2(20.0, 7.0)).abs() < 1e-11);
    }

    #[test]
    fn clipping_of_what_is_no_covariance_is_reported_and_keeps_the_variance() {
        // A step along x, whose transform changes its sign on every domain.
        struct Step;
        impl StationaryCovariance for Step {
            fn std_m(&self) -> f64 {
                2.0
            }
            fn correlation(&self, dx_m: f64, dy_m: f64) -> f64 {
                f64::from(dx_m.abs() < 6.0) * (-dy_m.abs()).exp()
            }
        }
        let grid = Grid::new(32, 32, 1.0, 1.0).unwrap();
        for field in [SpectralField::periodic(&Step, grid), SpectralField::free(&Step, grid).unwrap()] {
            assert!(field.clipped_variance() > 0.1, "{}", field.clipped_variance());
            assert!((field.covariance_with_m2(3, 5)[[3, 5]] - 4.0).abs() < 1e-12);
        }
    }

    #[test]
    fn a_long_anisotropic_strip_has_the_model_covariance_within_four_standard_errors() {
        let covariance = model(CorrelationModel::SelfAffine { hurst: 0.7 }, 12.0, 4.0);
        let (nx, ny) = (512, 32);
        let field = SpectralField::periodic(&covariance, Grid::new(nx, ny, 1.0, 1.0).unwrap());
        let lags = [(0, 0), (1, 0), (5, 0), (20, 0), (0, 1), (0, 4), (6, 2), (100, 10)];
        let count = 60;
        let mut sums = vec![(0.0, 0.0); lags.len()];
        for index in 0..count {
            let xi = random::standard_normal(&mut random::stream(3, "strip", index), field.xi_len());
            let map = field.generate(&xi);
            let z = map.heights_m();
            for (sum, (lag_x, lag_y)) in sums.iter_mut().zip(lags) {
                let mean = z
                    .indexed_iter()
                    .map(|((row, column), value)| value * z[[(row + lag_y) % ny, (column + lag_x) % nx]])
                    .sum::<f64>()
                    / (nx * ny) as f64;
                sum.0 += mean;
                sum.1 += mean * mean;
            }
        }
        for ((sum, square), (lag_x, lag_y)) in sums.into_iter().zip(lags) {
            let mean = sum / count as f64;
            let error = ((square / count as f64 - mean * mean) / (count - 1) as f64).sqrt();
            let wanted = covariance.value_m2(lag_x as f64, lag_y as f64);
            assert!((mean - wanted).abs() < 4.0 * error, "lag ({lag_x},{lag_y}): {mean} ± {error}, wanted {wanted}");
        }
    }
}
