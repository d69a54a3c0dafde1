//! Factorisations of dense matrices of up to a few thousand rows.
//!
//! All are blocked or recursive, so that almost all operations are matrix products. Matrices have row-major (standard)
//! layout unless a function says otherwise.
//!
//! # References
//! Golub & Van Loan, *Matrix Computations*, 4th ed., Johns Hopkins University Press, 2013.

mod cholesky;
mod divide;
mod eigen;
mod elimination;
mod norm;
mod qr;
mod reflectors;
#[cfg(test)]
mod tests;
mod triangular;
mod tridiagonal;

use ndarray::linalg::general_mat_mul;
use ndarray::{ArrayView2, ArrayViewMut2, Axis, s};
use thiserror::Error;

pub use cholesky::Cholesky;
pub use eigen::{SymmetricEigen, symmetric_eigen};
pub use elimination::dense_solution;
pub use qr::{Qr, triangular_condition};
pub use triangular::solve_upper;

/// The eigenvalues cannot be computed, for example because an entry is not finite.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Error)]
#[error("the eigenvalues of a matrix cannot be computed")]
pub struct NotConverged;

/// Width of the blocks that are factorised without matrix products.
const BLOCK: usize = 32;

/// Returns about half of `n`, a multiple of the block.
fn half(n: usize) -> usize {
    (n / 2).next_multiple_of(BLOCK)
}

/// Subtracts x·yᵀ from the lower triangle of a square matrix; some of the upper triangle changes too.
fn subtract_from_lower(mut matrix: ArrayViewMut2<'_, f64>, x: ArrayView2<'_, f64>, y: ArrayView2<'_, f64>) {
    /// Size of the squares whose upper triangles are also computed.
    const SQUARE: usize = 4 * BLOCK;
    let n = matrix.nrows();
    if n <= SQUARE {
        general_mat_mul(-1.0, &x, &y.t(), 1.0, &mut matrix);
        return;
    }
    let half = half(n);
    let ((x_top, x_bottom), (y_top, y_bottom)) = (x.split_at(Axis(0), half), y.split_at(Axis(0), half));
    subtract_from_lower(matrix.slice_mut(s![..half, ..half]), x_top, y_top);
    general_mat_mul(-1.0, &x_bottom, &y_top.t(), 1.0, &mut matrix.slice_mut(s![half.., ..half]));
    subtract_from_lower(matrix.slice_mut(s![half.., half..]), x_bottom, y_bottom);
}
