//! Least squares with one factorisation and many right-hand sides.

use faer::linalg::matmul::matmul;
use faer::{Accum, Mat, MatRef, Par};
use ndarray::{Array2, ArrayView2, CowArray, Ix2};

use super::{LeastSquares, RegressionError};
use asperity_base::blocks;

/// Number of right-hand sides that are solved together.
const BLOCK: usize = 256;

/// Coefficients of many right-hand sides with their leave-one-out errors.
#[derive(Debug, Clone, PartialEq)]
pub struct Fits {
    /// Shape `[coefficients P, responses R]`.
    pub coefficients: Array2<f64>,
    /// Relative leave-one-out error of each response, as [`LeaveOneOut::relative_error`](super::LeaveOneOut::relative_error).
    pub relative_errors: Vec<Option<f64>>,
}

impl LeastSquares {
    /// Solves for many responses, shape `[samples K, responses R]` in any layout; the result has shape `[coefficients
    /// P, responses R]`. The result is bit-identical for any number of threads.
    ///
    /// # Errors
    /// The number of values is wrong, or a value is not finite.
    pub fn solve_many(&self, responses: ArrayView2<'_, f64>) -> Result<Array2<f64>, RegressionError> {
        Ok(self.solve_blocks(responses, false)?.coefficients)
    }

    /// Solves as [`LeastSquares::solve_many`] and computes the leave-one-out error of each response, at twice the cost.
    ///
    /// # Errors
    /// See [`LeastSquares::solve_many`].
    pub fn fit_many(&self, responses: ArrayView2<'_, f64>) -> Result<Fits, RegressionError> {
        self.solve_blocks(responses, true)
    }

    fn solve_blocks(&self, responses: ArrayView2<'_, f64>, assess: bool) -> Result<Fits, RegressionError> {
        let (samples, count) = responses.dim();
        if samples != self.samples() {
            return Err(RegressionError::Length { values: samples, samples: self.samples() });
        }
        let responses = contiguous(responses);
        let matrix = matrix(&responses);
        let blocks: Vec<(Mat<f64>, Vec<Option<f64>>)> = blocks::map(0..count.div_ceil(BLOCK), |block| {
            let start = block * BLOCK;
            self.solve_block(matrix.subcols(start, BLOCK.min(count - start)), assess)
        });
        let mut coefficients = Array2::zeros((self.coefficients(), count));
        let mut relative_errors = Vec::new();
        for (number, (block, errors)) in blocks.into_iter().enumerate() {
            for (j, mut row) in coefficients.rows_mut().into_iter().enumerate() {
                row.iter_mut().skip(number * BLOCK).zip(block.row(j).iter()).for_each(|(cell, c)| *cell = *c);
            }
            relative_errors.extend(errors);
        }
        // A value that is not finite spoils all coefficients of its response, so the responses need not be searched
        // first.
        if coefficients.iter().any(|c| !c.is_finite())
            && let Some(sample) = responses.rows().into_iter().position(|row| row.iter().any(|y| !y.is_finite()))
        {
            return Err(RegressionError::NotFinite { sample });
        }
        Ok(Fits { coefficients, relative_errors })
    }

    fn solve_block(&self, responses: MatRef<'_, f64>, assess: bool) -> (Mat<f64>, Vec<Option<f64>>) {
        let mut solution = Mat::zeros(self.coefficients(), responses.ncols());
        matmul(solution.as_mut(), Accum::Replace, self.q.transpose(), responses, 1.0, Par::Seq);
        let errors = if assess { self.relative_errors(responses, &solution) } else { Vec::new() };
        self.qr.thin_R().solve_upper_triangular_in_place(solution.as_mut());
        (solution, errors)
    }

    /// Returns the relative leave-one-out errors of responses with the projections Qᵀy.
    fn relative_errors(&self, responses: MatRef<'_, f64>, projections: &Mat<f64>) -> Vec<Option<f64>> {
        let n = self.samples() as f64;
        let weights: Option<Vec<f64>> =
            self.leverages.iter().map(|h| super::is_determined(*h, n).then(|| 1.0 / (1.0 - h))).collect();
        let Some(weights) = weights else { return vec![None; responses.ncols()] };
        // Transposed, so that the sums run over contiguous rows.
        let mut residuals = responses.transpose().to_owned();
        let mut means = vec![0.0; responses.ncols()];
        for column in residuals.col_iter() {
            means.iter_mut().zip(column.iter()).for_each(|(mean, y)| *mean += y / n);
        }
        let mut variances = vec![0.0; means.len()];
        for column in residuals.col_iter() {
            let values = means.iter().zip(column.iter());
            variances.iter_mut().zip(values).for_each(|(sum, (mean, y))| *sum += (y - mean).powi(2) / (n - 1.0));
        }
        matmul(residuals.as_mut(), Accum::Add, projections.transpose(), self.q.transpose(), -1.0, Par::Seq);
        let mut squares = vec![0.0; means.len()];
        for (column, weight) in residuals.col_iter().zip(&weights) {
            squares.iter_mut().zip(column.iter()).for_each(|(sum, r)| *sum += (r * weight).powi(2) / n);
        }
        squares.iter().zip(&variances).map(|(square, variance)| (*variance > 0.0).then(|| square / variance)).collect()
    }
}

/// Returns the array itself if its rows or columns are contiguous, and a copy otherwise.
fn contiguous(array: ArrayView2<'_, f64>) -> CowArray<'_, f64, Ix2> {
    if array.is_standard_layout() || array.t().is_standard_layout() {
        CowArray::from(array)
    } else {
        CowArray::from(array.as_standard_layout().into_owned())
    }
}

/// Views a contiguous array as a matrix.
fn matrix<'a>(array: &'a CowArray<'_, f64, Ix2>) -> MatRef<'a, f64> {
    let (rows, columns) = array.dim();
    match (array.as_slice(), array.as_slice_memory_order()) {
        (Some(slice), _) => MatRef::from_row_major_slice(slice, rows, columns),
        (None, Some(slice)) => MatRef::from_column_major_slice(slice, rows, columns),
        (None, None) => unreachable!("the layout was made contiguous"),
    }
}
