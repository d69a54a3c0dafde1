//! Modes of any stationary covariance on a rectangle.

use ndarray::Array2;
use rayon::prelude::*;

use super::lanczos::{Stopping, largest_eigenpairs};
use super::profile::{dense_eigenpairs, fix_sign};
use crate::correlation::StationaryCovariance;
use crate::fourier::{RealFft2, good_length};
use crate::map::Grid;
use crate::surface::GeneratorError;
use crate::surface::spectral::wrapped_eigenvalues_m2;

/// Largest residual of an eigenpair over the first eigenvalue; the eigenvalue's error is about its square.
const TOLERANCE: f64 = 1e-9;
/// Seed of the random start block. The modes do not depend on it but for rotations among equal eigenvalues.
const SEED: u64 = 0x6b61_7268_756e_656e;
/// Points in a quarter of the map up to which the dense problem is faster than the iteration (a map of 64 × 64).
const DENSE_QUARTER: usize = 1100;

/// The first eigenvalues in m² and functions in 1/m, rows of ny·nx values.
pub(super) fn modes(
    covariance: &dyn StationaryCovariance,
    grid: Grid,
    modes: usize,
) -> Result<(Vec<f64>, Array2<f64>), GeneratorError> {
    if grid.nx().div_ceil(2) * grid.ny().div_ceil(2) <= DENSE_QUARTER {
        dense_modes(covariance, grid, modes)
    } else {
        iterated_modes(covariance, grid, modes)
    }
}

/// All modes of a small map by four dense problems, one for each parity in x and y.
///
/// A covariance that is even in x and y commutes with both reflections of the map, so modes are even or odd in each
/// direction, and a class lives on a quarter of the points: (e_i ± e_{n−1−i})/√2 along each axis.
pub(super) fn dense_modes(
    covariance: &dyn StationaryCovariance,
    grid: Grid,
    modes: usize,
) -> Result<(Vec<f64>, Array2<f64>), GeneratorError> {
    let (ny, nx) = grid.shape();
    let cell = grid.cell_area_m2();
    let lags = Array2::from_shape_fn((ny, nx), |(row, column)| {
        cell * covariance.correlation(column as f64 * grid.dx_m(), row as f64 * grid.dy_m())
    });
    if lags.iter().any(|value| !value.is_finite()) {
        return Err(GeneratorError::Eigen { points: grid.points() });
    }
    // (odd in x, odd in y); an odd class has no middle point.
    let classes = [(false, false), (true, false), (false, true), (true, true)];
    let solve = |(odd_x, odd_y): (bool, bool)| -> Result<Vec<(f64, Vec<f64>)>, GeneratorError> {
        let (half_x, half_y) = (half(nx, odd_x), half(ny, odd_y));
        if half_x * half_y == 0 {
            return Ok(Vec::new());
        }
        let (sign_x, sign_y) = (sign(odd_x), sign(odd_y));
        let entry = |i: usize, j: usize| {
            let ((xi, yi), (xj, yj)) = ((i % half_x, i / half_x), (j % half_x, j / half_x));
            let (mx, my) = (nx - 1 - xj, ny - 1 - yj);
            let row =
                |y: usize| lags[[yi.abs_diff(y), xi.abs_diff(xj)]] + sign_x * lags[[yi.abs_diff(y), xi.abs_diff(mx)]];
            let weight = middle(xi, nx) * middle(yi, ny) * middle(xj, nx) * middle(yj, ny);
            weight * (row(yj) + sign_y * row(my))
        };
        let (values, vectors) = dense_eigenpairs(half_x * half_y, entry)?;
        let expand = |vector: ndarray::ArrayView1<f64>| {
            let mut full = vec![0.0; nx * ny];
            for (i, value) in vector.iter().enumerate() {
                let (x, y) = (i % half_x, i / half_x);
                // A middle point is its own mirror and takes both halves.
                let part = 0.5 * value / (middle(x, nx) * middle(y, ny));
                for (row, from_y) in [(y, 1.0), (ny - 1 - y, sign_y)] {
                    for (column, from_x) in [(x, 1.0), (nx - 1 - x, sign_x)] {
                        full[row * nx + column] = part * from_x * from_y;
                    }
                }
            }
            full
        };
        Ok(values.into_iter().zip(vectors.rows()).take(modes).map(|(value, vector)| (value, expand(vector))).collect())
    };
    let solved: Vec<_> = classes.into_par_iter().map(solve).collect();
    let mut pairs = Vec::new();
    for class in solved {
        pairs.extend(class?);
    }
    // A stable sort: equal eigenvalues stay in the order of their classes.
    pairs.sort_by(|a, b| b.0.total_cmp(&a.0));
    pairs.truncate(modes);
    let mut functions = Array2::zeros((modes, nx * ny));
    for ((_, vector), mut function) in pairs.iter().zip(functions.rows_mut()) {
        function.iter_mut().zip(vector).for_each(|(phi, v)| *phi = v / cell.sqrt());
        fix_sign(function);
    }
    Ok((pairs.into_iter().map(|(value, _)| value).collect(), functions))
}

/// Points that describe an even or odd function of n points.
fn half(n: usize, odd: bool) -> usize {
    if odd { n / 2 } else { n.div_ceil(2) }
}

fn sign(odd: bool) -> f64 {
    if odd { -1.0 } else { 1.0 }
}

/// Weight 1/√2 of a middle point, which is its own mirror; 1 elsewhere.
fn middle(i: usize, n: usize) -> f64 {
    if 2 * i + 1 == n { std::f64::consts::FRAC_1_SQRT_2 } else { 1.0 }
}

/// The first modes of a map of any size, by block Lanczos.
///
/// A product with the covariance matrix is a convolution: pad with zeros, transform, multiply by the eigenvalues of the
/// covariance wrapped on a domain of twice the size, transform back and crop. The embedding need not be non-negative.
pub(super) fn iterated_modes(
    covariance: &dyn StationaryCovariance,
    grid: Grid,
    modes: usize,
) -> Result<(Vec<f64>, Array2<f64>), GeneratorError> {
    let (ny, nx) = grid.shape();
    let domain = Grid::new(good_length(2 * nx), good_length(2 * ny), grid.dx_m(), grid.dy_m())?;
    let fft = RealFft2::new(domain.nx(), domain.ny());
    let eigenvalues = wrapped_eigenvalues_m2(covariance, domain, &fft);
    if eigenvalues.iter().any(|value| !value.is_finite()) {
        return Err(GeneratorError::Eigen { points: grid.points() });
    }
    let apply = |vector: &[f64], out: &mut [f64]| {
        let (mut spectrum, mut work) = (fft.spectrum(), fft.workspace());
        fft.forward_padded(vector, ny, nx, &mut spectrum, &mut work);
        for (value, eigenvalue) in spectrum.iter_mut().zip(&eigenvalues) {
            *value *= eigenvalue;
        }
        fft.inverse_cropped(&mut spectrum, out, ny, nx, &mut work);
    };
    let stopping = Stopping { tolerance: TOLERANCE, subspace: 8 * modes + 200 };
    let (values, mut vectors) = largest_eigenpairs(&apply, grid.points(), modes, stopping, SEED)?;
    vectors /= grid.cell_area_m2().sqrt();
    Ok((values, vectors))
}
