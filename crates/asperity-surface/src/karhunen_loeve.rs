//! Karhunen–Loève surfaces, Gaus et al. 2016, eq. (2).

mod general;
mod lanczos;
mod parity;
mod profile;

use ndarray::{Array2, Axis};

use self::general::ClassModes;
use super::gaussian::{check_xi, map_of, row_order};
use super::spectral::{FourierModes, periodic_spectrum};
use super::{GaussianSurface, GeneratorError, RandomSurface};
use asperity_base::blocks;
use asperity_base::correlation::{Covariance, StationaryCovariance};
use asperity_base::map::{Grid, HeightMap};

pub use profile::{ProfileModes, profile_modes};

asperity_base::choice! {
    /// Method for the two-dimensional eigenproblem; it also determines which covariance is expanded.
    pub enum ModesRoute: "method for the eigenproblem" {
        /// Products of the modes of two profiles.
        ///
        /// Exact for the squared exponential. Any other model is replaced by the product ρ(x, 0)ρ(0, y) of its profiles,
        /// the exponential by e^{−|x|/ℓx−|y|/ℓy}. An oblique lay is lost.
        Separable = "separable",
        /// The unchanged covariance, oblique or not.
        ///
        /// Densely by parity up to about 64 × 64 points, beyond by block Lanczos on products with the circulant embedding.
        General = "general",
        /// The covariance wrapped onto a periodic map; its modes are cosines and sines.
        Periodic = "periodic",
    }
}

/// Truncated Karhunen–Loève surface z = σ Σ_{j≤M} √λ_j φ_j(x) ξ_j with ∫ρ(x − y)φ_j(y)dy = λ_j φ_j(x).
///
/// Eigenvalues belong to unit variance and are in m²; functions have unit L² norm on the map and are in 1/m. ξ_1 … ξ_M
/// are in the order of falling eigenvalues; the order of equal eigenvalues and all signs are fixed. The surface has
/// only the fraction [`KarhunenLoeve::captured_variance`] of σ²: the truncated map is smoother and lower than the
/// field.
///
/// # References
/// Ghanem & Spanos, *Stochastic Finite Elements* (1991), §2.3, <https://doi.org/10.1007/978-1-4612-3094-6>.
#[derive(Debug, Clone)]
pub struct KarhunenLoeve {
    grid: Grid,
    std_m: f64,
    route: ModesRoute,
    eigenvalues_m2: Vec<f64>,
    basis: Basis,
    /// Mean squared slope of the complete field of unit variance, by differences of neighbours, in 1/m².
    slope_variance_per_m2: f64,
}

/// The functions φ_j, in the form that is cheapest to sum.
#[derive(Debug, Clone)]
enum Basis {
    /// φ_j(x, y) = X_a(x) Y_b(y) with (a, b) = pairs[j].
    Tensor {
        x: Array2<f64>,
        y: Array2<f64>,
        pairs: Vec<(usize, usize)>,
    },
    /// φ_j by their values on one part of the map.
    Classes(ClassModes),
    Fourier(FourierModes),
}

impl KarhunenLoeve {
    /// Computes the first `modes` modes of `covariance` on `grid`.
    ///
    /// # Errors
    /// No mode or more modes than grid points; a covariance that is not finite; no convergence (general route).
    pub fn new(
        covariance: &dyn StationaryCovariance,
        grid: Grid,
        modes: usize,
        route: ModesRoute,
    ) -> Result<Self, GeneratorError> {
        if modes == 0 || modes > grid.points() {
            return Err(GeneratorError::Modes { wanted: modes, points: grid.points() });
        }
        let (eigenvalues_m2, basis) = match route {
            ModesRoute::Separable => tensor_modes(covariance, grid, modes)?,
            ModesRoute::General => {
                let found = general::modes(covariance, grid, modes)?;
                (found.eigenvalues_m2.clone(), Basis::Classes(found))
            }
            ModesRoute::Periodic => {
                let (fft, spectrum) = periodic_spectrum(covariance, grid);
                let mut fourier = FourierModes::new(grid, fft, &spectrum.eigenvalues_m2);
                fourier.truncate(modes);
                (fourier.eigenvalues_m2().collect(), Basis::Fourier(fourier))
            }
        };
        let slope_variance_per_m2 = slope_variance_per_m2(covariance, grid);
        Ok(Self { grid, std_m: covariance.std_m(), route, eigenvalues_m2, basis, slope_variance_per_m2 })
    }

    /// Computes the first `modes` Fourier modes of `covariance` wrapped onto a periodic map, without the constant mode.
    /// The other modes are scaled to the whole variance.
    ///
    /// # Errors
    /// The errors of [`KarhunenLoeve::new`], the constant mode not counted.
    pub fn periodic_without_constant(
        covariance: &dyn StationaryCovariance,
        grid: Grid,
        modes: usize,
    ) -> Result<Self, GeneratorError> {
        let points = grid.points() - 1;
        if modes == 0 || modes > points {
            return Err(GeneratorError::Modes { wanted: modes, points });
        }
        let (fft, spectrum) = periodic_spectrum(covariance, grid);
        let mut fourier = FourierModes::new(grid, fft, &spectrum.eigenvalues_m2);
        fourier.without_constant();
        fourier.truncate(modes);
        let eigenvalues_m2 = fourier.eigenvalues_m2().collect();
        Ok(Self {
            grid,
            std_m: covariance.std_m(),
            route: ModesRoute::Periodic,
            eigenvalues_m2,
            basis: Basis::Fourier(fourier),
            slope_variance_per_m2: slope_variance_per_m2(covariance, grid),
        })
    }

    /// Returns the surface scaled so that its modes have the whole variance of the field, averaged over the map.
    #[must_use]
    pub fn rescaled(self) -> Self {
        let captured = self.captured_variance();
        Self { std_m: self.std_m / captured.sqrt(), ..self }
    }

    /// Returns the standard deviation σ of the expanded field, in metre.
    pub fn std_m(&self) -> f64 {
        self.std_m
    }

    /// Returns the method for the eigenproblem.
    pub fn route(&self) -> ModesRoute {
        self.route
    }

    /// Returns the eigenvalues λ_j of unit variance in m², falling.
    pub fn eigenvalues_m2(&self) -> &[f64] {
        &self.eigenvalues_m2
    }

    /// Returns the fraction Σλ_j/A of the variance that the modes include, averaged over the map.
    pub fn captured_variance(&self) -> f64 {
        self.eigenvalues_m2.iter().sum::<f64>() / self.grid.area_m2()
    }

    /// Returns the fraction of the mean squared slope, by differences of neighbours on the grid, that the modes include.
    ///
    /// Elastic contact depends on slopes; the first modes include far less of the slopes than of the variance. The
    /// fraction of all modes is 1, also if negative eigenvalues of an estimated covariance were left out (the others
    /// then sum to more).
    pub fn captured_slope_variance(&self) -> f64 {
        let slope = |j: usize| self.eigenvalues_m2[j] * mean_squared_slope_per_m2(self.grid, &self.mode_per_m(j));
        let slopes: Vec<f64> = blocks::map(0..self.eigenvalues_m2.len(), slope);
        (slopes.iter().sum::<f64>() / self.slope_variance_per_m2).min(1.0)
    }

    /// Returns the function φ_j on the grid in 1/m, shape `[ny, nx]`, with Σ φ_j² ΔxΔy = 1.
    ///
    /// # Panics
    /// If there is no mode `j`.
    pub fn mode_per_m(&self, j: usize) -> Array2<f64> {
        assert!(j < self.eigenvalues_m2.len(), "mode {j} of {}", self.eigenvalues_m2.len());
        let mut weights = vec![0.0; self.eigenvalues_m2.len()];
        weights[j] = 1.0;
        let (ny, nx) = self.grid.shape();
        let values = match &self.basis {
            Basis::Fourier(fourier) => {
                let root = self.eigenvalues_m2[j].sqrt();
                let scaled = fourier.synthesise(&weights, ny, nx);
                scaled.into_iter().map(|v| v / root).collect()
            }
            _ => self.superpose(&weights),
        };
        Array2::from_shape_fn((ny, nx), |(row, column)| values[row * nx + column])
    }

    /// Returns Σ_j w_j φ_j on the grid in row order; for the Fourier basis w_j multiplies √λ_j φ_j.
    fn superpose(&self, weights: &[f64]) -> Vec<f64> {
        let (ny, nx) = self.grid.shape();
        match &self.basis {
            Basis::Tensor { x, y, pairs } => {
                let mut profiles = Array2::<f64>::zeros((y.nrows(), nx));
                for (weight, &(a, b)) in weights.iter().zip(pairs) {
                    profiles.row_mut(b).scaled_add(*weight, &x.row(a));
                }
                y.t().dot(&profiles).into_raw_vec_and_offset().0
            }
            Basis::Classes(found) => found.superpose(weights.iter().copied()),
            Basis::Fourier(fourier) => fourier.synthesise(weights, ny, nx),
        }
    }
}

/// Returns the mean squared slope of a field of unit variance, 2(1 − ρ(Δx, 0))/Δx² + 2(1 − ρ(0, Δy))/Δy², in 1/m².
fn slope_variance_per_m2(covariance: &dyn StationaryCovariance, grid: Grid) -> f64 {
    let (dx_m, dy_m) = (grid.dx_m(), grid.dy_m());
    let along_x = if grid.nx() > 1 { (1.0 - covariance.correlation(dx_m, 0.0)) / (dx_m * dx_m) } else { 0.0 };
    let along_y = if grid.ny() > 1 { (1.0 - covariance.correlation(0.0, dy_m)) / (dy_m * dy_m) } else { 0.0 };
    2.0 * (along_x + along_y)
}

/// Returns the mean squared slope of a function on the grid, by differences of neighbours.
fn mean_squared_slope_per_m2(grid: Grid, values: &Array2<f64>) -> f64 {
    let mean = |axis: Axis, pitch_m: f64| {
        let pairs = values.axis_windows(axis, 2).into_iter();
        let (mut sum, mut count) = (0.0, 0.0);
        for pair in pairs {
            let (first, second) = (pair.index_axis(axis, 0), pair.index_axis(axis, 1));
            sum += first.iter().zip(&second).map(|(a, b)| (b - a).powi(2)).sum::<f64>();
            count += first.len() as f64;
        }
        if count > 0.0 { sum / (count * pitch_m * pitch_m) } else { 0.0 }
    };
    mean(Axis(1), grid.dx_m()) + mean(Axis(0), grid.dy_m())
}

/// Returns about the number of modes of a covariance on a grid that include the given `fraction` of its mean squared
/// slope and of its variance.
///
/// The number is exact for the Fourier modes of the covariance wrapped onto the grid, which resemble the modes of a
/// patch of several correlation lengths.
pub fn modes_for_slopes(covariance: &dyn StationaryCovariance, grid: Grid, fraction: f64) -> usize {
    let (fft, spectrum) = periodic_spectrum(covariance, grid);
    let symbol = |k: usize, n: usize, pitch_m: f64| {
        (2.0 - 2.0 * (std::f64::consts::TAU * k as f64 / n as f64).cos()) / (pitch_m * pitch_m)
    };
    // Eigenvalues with their slopes and their multiplicity.
    let ny = grid.ny();
    let mut modes: Vec<(f64, f64, f64)> = spectrum
        .eigenvalues_m2
        .iter()
        .enumerate()
        .map(|(place, value)| {
            let slope = symbol(place / ny, grid.nx(), grid.dx_m()) + symbol(place % ny, ny, grid.dy_m());
            (*value, value * slope, fft.multiplicity(place / ny))
        })
        .collect();
    modes.sort_by(|a, b| b.0.total_cmp(&a.0));
    let total = modes.iter().fold((0.0, 0.0), |sum, (value, slope, n)| (sum.0 + n * value, sum.1 + n * slope));
    let (mut variance, mut slopes, mut count) = (0.0, 0.0, 0.0);
    for (value, slope, n) in modes {
        if variance >= fraction * total.0 && slopes >= fraction * total.1 {
            break;
        }
        (variance, slopes, count) = (variance + n * value, slopes + n * slope, count + n);
    }
    (count as usize).clamp(1, grid.points())
}

/// Returns the largest products of profile eigenvalues.
///
/// A product of the a-th and b-th values has at least (a + 1)(b + 1) − 1 others that are no smaller, so pairs beyond
/// (a + 1)(b + 1) = M are skipped.
fn tensor_modes(
    covariance: &dyn StationaryCovariance,
    grid: Grid,
    modes: usize,
) -> Result<(Vec<f64>, Basis), GeneratorError> {
    let x = profile_modes(|lag| covariance.correlation(lag, 0.0), grid.nx(), grid.dx_m(), modes.min(grid.nx()))?;
    let y = profile_modes(|lag| covariance.correlation(0.0, lag), grid.ny(), grid.dy_m(), modes.min(grid.ny()))?;
    let mut products: Vec<(f64, (usize, usize))> = Vec::new();
    for (b, value_y) in y.eigenvalues_m.iter().enumerate() {
        for (a, value_x) in x.eigenvalues_m.iter().enumerate().take(modes / (b + 1)) {
            products.push((value_x * value_y, (a, b)));
        }
    }
    products.sort_by(|p, q| q.0.total_cmp(&p.0).then(p.1.1.cmp(&q.1.1)).then(p.1.0.cmp(&q.1.0)));
    products.truncate(modes);
    let (eigenvalues, pairs): (Vec<f64>, Vec<(usize, usize)>) = products.into_iter().unzip();
    // Only the profiles in use are kept.
    let used_x = pairs.iter().map(|pair| pair.0 + 1).max().unwrap_or(0);
    let used_y = pairs.iter().map(|pair| pair.1 + 1).max().unwrap_or(0);
    let keep = |functions: Array2<f64>, used: usize| functions.slice_move(ndarray::s![..used, ..]);
    Ok((eigenvalues, Basis::Tensor { x: keep(x.functions, used_x), y: keep(y.functions, used_y), pairs }))
}

impl RandomSurface for KarhunenLoeve {
    fn xi_len(&self) -> usize {
        self.eigenvalues_m2.len()
    }

    fn grid(&self) -> Grid {
        self.grid
    }

    fn generate(&self, xi: &[f64]) -> HeightMap {
        check_xi(xi, self.xi_len());
        let weights: Vec<f64> = match self.basis {
            Basis::Fourier(_) => xi.iter().map(|xi| self.std_m * xi).collect(),
            _ => xi.iter().zip(&self.eigenvalues_m2).map(|(xi, value)| self.std_m * value.sqrt() * xi).collect(),
        };
        map_of(self.grid, self.superpose(&weights))
    }

    fn xi_response(&self, weights: &Array2<f64>) -> Option<Vec<f64>> {
        let weights = row_order(weights, self.grid);
        let (ny, nx) = self.grid.shape();
        let products = match &self.basis {
            Basis::Tensor { x, y, pairs } => {
                let weights = Array2::from_shape_fn((ny, nx), |(row, column)| weights[row * nx + column]);
                let products = y.dot(&weights).dot(&x.t());
                pairs.iter().map(|&(a, b)| products[[b, a]]).collect()
            }
            Basis::Classes(found) => found.products(&weights),
            Basis::Fourier(fourier) => {
                let scaled = fourier.analyse(&weights, ny, nx);
                return Some(scaled.into_iter().map(|value| self.std_m * value).collect());
            }
        };
        let scaled = |(product, value): (f64, &f64)| self.std_m * value.sqrt() * product;
        Some(Vec::into_iter(products).zip(&self.eigenvalues_m2).map(scaled).collect())
    }

    fn is_periodic_and_stationary(&self) -> bool {
        matches!(&self.basis, Basis::Fourier(modes) if modes.unpaired_fraction() < 1e-3)
    }
}

impl GaussianSurface for KarhunenLoeve {
    fn pointwise_std_m(&self) -> Array2<f64> {
        let (ny, nx) = self.grid.shape();
        let fractions = match &self.basis {
            Basis::Fourier(fourier) => fourier.pointwise_variance(ny, nx),
            Basis::Tensor { x, y, pairs } => {
                let (x2, y2) = (x.mapv(|v| v * v), y.mapv(|v| v * v));
                let mut profiles = Array2::<f64>::zeros((y.nrows(), nx));
                for (value, &(a, b)) in self.eigenvalues_m2.iter().zip(pairs) {
                    profiles.row_mut(b).scaled_add(*value, &x2.row(a));
                }
                y2.t().dot(&profiles)
            }
            Basis::Classes(found) => {
                let sum = found.superpose_squares(&self.eigenvalues_m2);
                Array2::from_shape_fn((ny, nx), |(row, column)| sum[row * nx + column])
            }
        };
        fractions.mapv(|fraction| self.std_m * fraction.max(0.0).sqrt())
    }

    fn covariance_with_m2(&self, row: usize, column: usize) -> Array2<f64> {
        let (ny, nx) = self.grid.shape();
        assert!(row < ny && column < nx, "no point at row {row}, column {column} of {ny} × {nx}");
        let values = match &self.basis {
            Basis::Fourier(fourier) => fourier.covariance_with(row, column, ny, nx),
            Basis::Tensor { x, y, pairs } => {
                let at_point = |&(a, b): &(usize, usize)| x[[a, column]] * y[[b, row]];
                let weights = self.eigenvalues_m2.iter().zip(pairs).map(|(value, pair)| value * at_point(pair));
                self.superpose(&weights.collect::<Vec<_>>())
            }
            Basis::Classes(found) => {
                let here = found.values_at(row * nx + column);
                found.superpose(self.eigenvalues_m2.iter().zip(here).map(|(value, phi)| value * phi))
            }
        };
        let variance = self.std_m * self.std_m;
        Array2::from_shape_fn((ny, nx), |(r, c)| variance * values[r * nx + c])
    }
}

/// Spectrum of a covariance operator of unit variance.
#[derive(Debug, Clone, PartialEq)]
pub struct Modes {
    /// Eigenvalues, falling, in m for one dimension and in m² for two.
    pub eigenvalues: Vec<f64>,
    /// Sum of the eigenvalues over the length or area: the fraction of the variance in the modes.
    pub captured_variance: f64,
}

/// Computes the first `modes` eigenvalues of the correlation of `covariance` on an interval or rectangle of `size_m`, on
/// `points` cells: one value of each for an interval (along x), two (x, y) for a rectangle.
///
/// # Errors
/// Other than one or two sizes and numbers of points, an invalid grid, and the errors of [`KarhunenLoeve::new`].
pub fn modes(
    covariance: &Covariance,
    size_m: &[f64],
    points: &[usize],
    modes: usize,
    route: ModesRoute,
) -> Result<Modes, GeneratorError> {
    match (size_m, points) {
        (&[length_m], &[points]) => {
            if !(length_m > 0.0 && length_m.is_finite()) {
                return Err(GeneratorError::Parameter { parameter: "size_m", value: length_m, wanted: "positive" });
            }
            let pitch_m = length_m / points as f64;
            let profile = |lag: f64| match route {
                // The nearest image on a ring of this length.
                ModesRoute::Periodic => covariance.correlation(lag.min(length_m - lag), 0.0),
                ModesRoute::Separable | ModesRoute::General => covariance.correlation(lag, 0.0),
            };
            let found = profile_modes(profile, points, pitch_m, modes)?;
            Ok(Modes { eigenvalues: found.eigenvalues_m, captured_variance: found.captured_variance })
        }
        (&[width_m, height_m], &[nx, ny]) => {
            let grid = Grid::with_size(nx, ny, width_m, height_m)?;
            let found = KarhunenLoeve::new(covariance, grid, modes, route)?;
            Ok(Modes { captured_variance: found.captured_variance(), eigenvalues: found.eigenvalues_m2 })
        }
        _ => Err(GeneratorError::Dimensions { sizes: size_m.len(), points: points.len() }),
    }
}

/// Returns the memory in byte, about, of [`modes`]: the dense problems of each interval, or the bases of the rectangle.
pub fn modes_memory_bytes(points: &[usize], modes: usize, route: ModesRoute) -> f64 {
    const DOUBLE_BYTES: f64 = 8.0;
    // Two problems of half the size, their vectors, and the functions.
    const DENSE_COPIES: f64 = 2.0;
    // A domain of four times the map: its eigenvalues, and two spectra for each of up to four threads.
    const TRANSFORMS: f64 = 50.0;
    let sides: Vec<f64> = points.iter().map(|n| *n as f64).collect();
    let dense = DENSE_COPIES * sides.iter().map(|n| n * n).fold(0.0, f64::max);
    let area = sides.iter().product::<f64>();
    let numbers = match (route, sides.len()) {
        (ModesRoute::General, 2) => area * (lanczos::basis_vectors(4, modes) + TRANSFORMS),
        (ModesRoute::Periodic, 2) => 4.0 * area,
        _ => dense,
    };
    DOUBLE_BYTES * numbers
}

#[cfg(test)]
mod tests;
