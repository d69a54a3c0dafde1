//! Least squares with one factorisation and many right-hand sides.

use ndarray::linalg::general_mat_mul;
use ndarray::{Array2, ArrayView2, s};

use super::{LeastSquares, RegressionError};
use asperity_base::blocks;
use asperity_base::numeric::solve_upper;

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
        let blocks: Vec<(Array2<f64>, Vec<Option<f64>>)> = blocks::map(0..count.div_ceil(BLOCK), |block| {
            let start = block * BLOCK;
            self.solve_block(responses.slice(s![.., start..(start + BLOCK).min(count)]), assess)
        });
        let mut coefficients = Array2::zeros((self.coefficients(), count));
        let mut relative_errors = Vec::new();
        for (number, (block, errors)) in blocks.into_iter().enumerate() {
            let start = number * BLOCK;
            coefficients.slice_mut(s![.., start..start + block.ncols()]).assign(&block);
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

    fn solve_block(&self, responses: ArrayView2<'_, f64>, assess: bool) -> (Array2<f64>, Vec<Option<f64>>) {
        let mut solution = Array2::zeros((self.coefficients(), responses.ncols()));
        general_mat_mul(1.0, &self.qr.q.t(), &responses, 0.0, &mut solution);
        let errors = if assess { self.relative_errors(responses, &solution) } else { Vec::new() };
        solve_upper(self.qr.r.view(), solution.view_mut());
        (solution, errors)
    }

    /// Returns the relative leave-one-out errors of responses with the projections Qᵀy.
    fn relative_errors(&self, responses: ArrayView2<'_, f64>, projections: &Array2<f64>) -> Vec<Option<f64>> {
        let n = self.samples() as f64;
        let weights: Option<Vec<f64>> =
            self.leverages.iter().map(|h| super::is_determined(*h, n).then(|| 1.0 / (1.0 - h))).collect();
        let Some(weights) = weights else { return vec![None; responses.ncols()] };
        // In standard layout, so that the sums run over contiguous rows.
        let mut residuals = responses.as_standard_layout().into_owned();
        let mut means = vec![0.0; responses.ncols()];
        for row in residuals.rows() {
            means.iter_mut().zip(row).for_each(|(mean, y)| *mean += y / n);
        }
        let mut variances = vec![0.0; means.len()];
        for row in residuals.rows() {
            let values = means.iter().zip(row);
            variances.iter_mut().zip(values).for_each(|(sum, (mean, y))| *sum += (y - mean).powi(2) / (n - 1.0));
        }
        general_mat_mul(-1.0, &self.qr.q, projections, 1.0, &mut residuals);
        let mut squares = vec![0.0; means.len()];
        for (row, weight) in residuals.rows().into_iter().zip(&weights) {
            squares.iter_mut().zip(row).for_each(|(sum, r)| *sum += (r * weight).powi(2) / n);
        }
        squares.iter().zip(&variances).map(|(square, variance)| (*variance > 0.0).then(|| square / variance)).collect()
    }
}
