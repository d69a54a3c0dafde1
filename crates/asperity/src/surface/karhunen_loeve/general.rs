//! Modes of any stationary covariance on a rectangle, matrix-free.

use ndarray::Array2;

use super::lanczos::{Stopping, largest_eigenpairs};
use crate::correlation::StationaryCovariance;
use crate::fourier::{RealFft2, good_length};
use crate::map::Grid;
use crate::surface::GeneratorError;
use crate::surface::spectral::wrapped_eigenvalues_m2;

/// Largest residual of an eigenpair over the first eigenvalue; the eigenvalue's error is about its square.
const TOLERANCE: f64 = 1e-9;
/// Seed of the random start block. The modes do not depend on it but for rotations among equal eigenvalues.
const SEED: u64 = 0x6b61_7268_756e_656e;

/// The first eigenvalues in m² and functions in 1/m, rows of ny·nx values.
///
/// A product with the covariance matrix is a convolution: pad with zeros, transform, multiply by the eigenvalues of the
/// covariance wrapped on a domain of twice the size, transform back and crop. The embedding need not be non-negative.
pub(super) fn modes(
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
