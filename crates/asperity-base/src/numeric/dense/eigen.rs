//! Eigenproblems of symmetric matrices.

use ndarray::{Array2, s};

use super::NotConverged;
use super::divide::eigenpairs;
use super::tridiagonal::Tridiagonal;

/// Eigenpairs of a symmetric matrix.
#[derive(Debug, Clone)]
pub struct SymmetricEigen {
    /// Eigenvalues, rising.
    pub values: Vec<f64>,
    /// Orthonormal eigenvectors as rows.
    pub vectors: Array2<f64>,
}

/// Computes all eigenpairs of a symmetric matrix in standard layout, whose lower triangle is read.
///
/// # Errors
/// An entry is not finite, or the iteration does not converge.
///
/// # Panics
/// The matrix is not square or not in standard layout.
pub fn symmetric_eigen(matrix: Array2<f64>) -> Result<SymmetricEigen, NotConverged> {
    let (scale, reduced) = reduced(matrix)?;
    let (values, mut vectors) = eigenpairs(reduced.diagonal, &reduced.beside)?;
    for (first, factor) in reduced.factors.iter().rev() {
        factor.apply(vectors.slice_mut(s![.., *first..]).reversed_axes());
    }
    Ok(SymmetricEigen { values: values.into_iter().map(|value| value * scale).collect(), vectors })
}

/// Divides a matrix by its largest entry, which is returned, and makes it tridiagonal.
fn reduced(mut matrix: Array2<f64>) -> Result<(f64, Tridiagonal), NotConverged> {
    assert!(matrix.is_square() && matrix.is_standard_layout(), "shape {:?}", matrix.dim());
    let lower = || matrix.rows().into_iter().enumerate().flat_map(|(i, row)| row.into_iter().take(i + 1));
    if lower().any(|value| !value.is_finite()) {
        return Err(NotConverged);
    }
    let largest = lower().fold(0.0_f64, |m, value| m.max(value.abs()));
    let scale = if largest > 0.0 { largest } else { 1.0 };
    matrix.mapv_inplace(|value| value / scale);
    Ok((scale, Tridiagonal::new(matrix)))
}
