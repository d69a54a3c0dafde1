//! Modes of any stationary covariance on a rectangle.

use ndarray::Array2;

use super::lanczos::{Operator, largest_eigenpairs, sort_falling};
use super::parity::Class;
use super::profile::class_eigenpairs;
use crate::GeneratorError;
use crate::spectral::wrapped_eigenvalues_m2;
use asperity_base::blocks;
use asperity_base::correlation::StationaryCovariance;
use asperity_base::fourier::{Complex64, RealFft2, Workspace, good_length};
use asperity_base::map::Grid;

/// Largest residual of an eigenpair over the first eigenvalue; the relative error of the eigenvalue is about its square.
const TOLERANCE: f64 = 1e-9;
/// Seed of the random start blocks. The modes do not depend on it, except for rotations among equal eigenvalues.
const SEED: u64 = 0x6b61_7268_756e_656e;
/// Number of points of a class up to which the dense problem is faster than the iteration (a quarter of a map of 64 ×
/// 64).
const DENSE_CLASS: usize = 1100;

/// Eigenfunctions that are even or odd, by their values on one part of the map.
#[derive(Debug, Clone)]
pub(super) struct ClassModes {
    /// Eigenvalues in m², falling.
    pub(super) eigenvalues_m2: Vec<f64>,
    classes: Vec<Class>,
    /// Coordinates of the functions of each class in 1/m, as rows.
    functions: Vec<Array2<f64>>,
    /// Class and row of every mode.
    pub(super) places: Vec<(usize, usize)>,
    points: usize,
}

/// Computes the first eigenvalues in m² and functions in 1/m.
pub(super) fn modes(
    covariance: &dyn StationaryCovariance,
    grid: Grid,
    modes: usize,
) -> Result<ClassModes, GeneratorError> {
    let classes = Class::all(grid, covariance.mirror_symmetric());
    if classes.iter().all(|class| class.len() <= DENSE_CLASS) {
        dense_modes(covariance, grid, modes)
    } else {
        iterated_modes(covariance, grid, modes)
    }
}

/// Computes all modes of a small map by one dense problem for each class.
pub(super) fn dense_modes(
    covariance: &dyn StationaryCovariance,
    grid: Grid,
    modes: usize,
) -> Result<ClassModes, GeneratorError> {
    let (ny, nx) = grid.shape();
    let cell = grid.cell_area_m2();
    // Rows are lags −(ny − 1) … ny − 1 along y; columns are lags along x in the same order.
    let lags = Array2::from_shape_fn((2 * ny - 1, 2 * nx - 1), |(row, column)| {
        let (lag_x, lag_y) = (column as f64 - (nx - 1) as f64, row as f64 - (ny - 1) as f64);
        cell * covariance.correlation(lag_x * grid.dx_m(), lag_y * grid.dy_m())
    });
    if lags.iter().any(|value| !value.is_finite()) {
        return Err(GeneratorError::Eigen { points: grid.points() });
    }
    let entry = |p: usize, q: usize| lags[[p / nx + ny - 1 - q / nx, p % nx + nx - 1 - q % nx]];
    let classes = Class::all(grid, covariance.mirror_symmetric());
    let solved: Result<Vec<_>, GeneratorError> =
        blocks::map(0..classes.len(), |class| class_eigenpairs(&classes[class], entry));
    Ok(ClassModes::merge(grid, classes, solved?, modes))
}

/// Computes the first modes of a map of any size by block Lanczos.
///
/// A product with the covariance matrix is a convolution: pad with zeros, transform, multiply by the eigenvalues of the
/// covariance wrapped on a domain of twice the size, transform back and crop. The embedding need not be non-negative.
/// One product serves a vector of every class: their sum is transformed, and the result is folded into the classes
/// again.
pub(super) fn iterated_modes(
    covariance: &dyn StationaryCovariance,
    grid: Grid,
    modes: usize,
) -> Result<ClassModes, GeneratorError> {
    let (ny, nx) = grid.shape();
    let domain = Grid::new(good_length(2 * nx), good_length(2 * ny), grid.dx_m(), grid.dy_m())?;
    let fft = RealFft2::new(domain.nx(), domain.ny());
    let eigenvalues_m2 = wrapped_eigenvalues_m2(covariance, domain, &fft);
    if eigenvalues_m2.iter().any(|value| !value.is_finite()) {
        return Err(GeneratorError::Eigen { points: grid.points() });
    }
    let operator = Convolution { grid, fft, eigenvalues_m2, classes: Class::all(grid, covariance.mirror_symmetric()) };
    let pairs = largest_eigenpairs(&operator, modes, TOLERANCE, SEED)?;
    let found = pairs.into_iter().map(|pairs| (pairs.values, pairs.vectors)).collect();
    Ok(ClassModes::merge(grid, operator.classes, found, modes))
}

/// Product of a covariance with maps.
struct Convolution {
    grid: Grid,
    fft: RealFft2,
    eigenvalues_m2: Vec<f64>,
    classes: Vec<Class>,
}

/// Scratch memory of one thread.
struct ConvolutionWork {
    map: Vec<f64>,
    spectrum: Vec<Complex64>,
    fft: Workspace,
}

impl Operator for Convolution {
    type Workspace = ConvolutionWork;

    fn workspace(&self) -> ConvolutionWork {
        let map = vec![0.0; self.grid.points()];
        ConvolutionWork { map, spectrum: self.fft.spectrum(), fft: self.fft.workspace() }
    }

    fn dimensions(&self) -> Vec<usize> {
        self.classes.iter().map(Class::len).collect()
    }

    fn apply(&self, vectors: &mut [Vec<f64>], work: &mut ConvolutionWork) {
        let (ny, nx) = self.grid.shape();
        work.map.fill(0.0);
        for (class, vector) in self.classes.iter().zip(&*vectors) {
            if !vector.is_empty() {
                class.add_to(vector, &mut work.map);
            }
        }
        self.fft.forward_padded(&work.map, ny, nx, &mut work.spectrum, &mut work.fft);
        for (value, eigenvalue) in work.spectrum.iter_mut().zip(&self.eigenvalues_m2) {
            *value *= eigenvalue;
        }
        self.fft.inverse_cropped(&mut work.spectrum, &mut work.map, ny, nx, &mut work.fft);
        for (class, vector) in self.classes.iter().zip(vectors) {
            if !vector.is_empty() {
                class.fold(&work.map, vector);
            }
        }
    }
}

impl ClassModes {
    /// Combines the first modes of all classes, from eigenvalues and unit vectors as rows of each.
    fn merge(grid: Grid, classes: Vec<Class>, found: Vec<(Vec<f64>, Array2<f64>)>, modes: usize) -> Self {
        let mut all: Vec<(f64, (usize, usize))> = Vec::new();
        for (class, (values, _)) in found.iter().enumerate() {
            all.extend(values.iter().enumerate().map(|(row, value)| (*value, (class, row))));
        }
        sort_falling(&mut all);
        all.truncate(modes);
        let norm = grid.cell_area_m2().sqrt();
        let functions = found.into_iter().enumerate().map(|(class, (_, vectors))| {
            // The modes of one class are its first rows, because its values fall.
            let used = all.iter().filter(|(_, place)| place.0 == class).count();
            let mut functions =
                if used == vectors.nrows() { vectors } else { vectors.slice(ndarray::s![..used, ..]).to_owned() };
            for mut row in functions.rows_mut() {
                row.mapv_inplace(|v| v / norm);
                if let Some(row) = row.as_slice_mut() {
                    classes[class].fix_sign(row);
                }
            }
            functions
        });
        let functions = functions.collect();
        let (eigenvalues_m2, places) = all.into_iter().unzip();
        Self { eigenvalues_m2, classes, functions, places, points: grid.points() }
    }

    /// Returns Σ_j w_j φ_j in row order.
    pub(super) fn superpose(&self, weights: impl IntoIterator<Item = f64>) -> Vec<f64> {
        let mut sums: Vec<Vec<f64>> = self.classes.iter().map(|class| vec![0.0; class.len()]).collect();
        for (weight, &(class, row)) in weights.into_iter().zip(&self.places) {
            if weight != 0.0 {
                let function = self.functions[class].row(row);
                sums[class].iter_mut().zip(function).for_each(|(sum, phi)| *sum += weight * phi);
            }
        }
        let mut map = vec![0.0; self.points];
        for (class, sum) in self.classes.iter().zip(&sums) {
            class.add_to(sum, &mut map);
        }
        map
    }

    /// Returns Σ_x w(x) φ_j(x) for all j, with `weights` in row order.
    pub(super) fn products(&self, weights: &[f64]) -> Vec<f64> {
        let folded = |class: &Class| {
            let mut folded = vec![0.0; class.len()];
            for (place, weight) in weights.iter().enumerate() {
                if let Some((i, factor)) = class.coordinate_at(place) {
                    folded[i] += factor * weight;
                }
            }
            folded
        };
        let folded: Vec<Vec<f64>> = self.classes.iter().map(folded).collect();
        let product = |&(class, row): &(usize, usize)| {
            self.functions[class].row(row).iter().zip(&folded[class]).map(|(phi, weight)| phi * weight).sum()
        };
        self.places.iter().map(product).collect()
    }

    /// Returns Σ_j w_j φ_j² in row order.
    pub(super) fn superpose_squares(&self, weights: &[f64]) -> Vec<f64> {
        let mut map = vec![0.0; self.points];
        for (index, class) in self.classes.iter().enumerate() {
            let mut sum = vec![0.0; class.len()];
            let own = weights.iter().zip(&self.places).filter(|(_, place)| place.0 == index);
            for (weight, &(_, row)) in own {
                let function = self.functions[index].row(row);
                sum.iter_mut().zip(function).for_each(|(sum, phi)| *sum += weight * phi * phi);
            }
            for (place, value) in map.iter_mut().enumerate() {
                if let Some((i, factor)) = class.coordinate_at(place) {
                    *value += factor * factor * sum[i];
                }
            }
        }
        map
    }

    /// Returns φ_j at a place of the map for all j, in 1/m.
    pub(super) fn values_at(&self, place: usize) -> Vec<f64> {
        let here: Vec<_> = self.classes.iter().map(|class| class.coordinate_at(place)).collect();
        let value = |&(class, row): &(usize, usize)| {
            here[class].map_or(0.0, |(i, factor): (usize, f64)| factor * self.functions[class][[row, i]])
        };
        self.places.iter().map(value).collect()
    }
}
