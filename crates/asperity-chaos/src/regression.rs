//! Linear least squares by QR factorisation.

mod many;
#[cfg(test)]
mod tests;

use ndarray::{Array2, ArrayView1, Axis};
use thiserror::Error;

pub use many::Fits;

use asperity_base::numeric::{Qr, solve_upper, triangular_condition};

/// Reason why a regression failed.
#[derive(Debug, Clone, PartialEq, Error)]
#[non_exhaustive]
pub enum RegressionError {
    /// There are not more samples than coefficients.
    #[error("{samples} samples for {coefficients} coefficients; more samples than coefficients are needed")]
    TooFewSamples {
        /// Number K of samples.
        samples: usize,
        /// Number P of coefficients.
        coefficients: usize,
    },
    /// The functions are linearly dependent on the samples.
    #[error(
        "the {coefficients} functions cannot be told apart on the {samples} samples: condition number {condition:.1e}"
    )]
    RankDeficient {
        /// Number K of samples.
        samples: usize,
        /// Number P of coefficients.
        coefficients: usize,
        /// Ratio of the largest to the smallest singular value.
        condition: f64,
    },
    /// A value of the design matrix or of a response is not finite.
    #[error("sample {sample} is not a finite number")]
    NotFinite {
        /// Index of the first such sample.
        sample: usize,
    },
    /// The response and the design differ in length.
    #[error("{values} response values for {samples} samples")]
    Length {
        /// Values given.
        values: usize,
        /// Samples of the design.
        samples: usize,
    },
}

/// Factorised least-squares problem min ‖A c − y‖₂ with K rows and P columns. One factorisation serves any number of
/// right-hand sides.
#[derive(Debug)]
pub struct LeastSquares {
    qr: Qr,
    leverages: Vec<f64>,
    condition: f64,
}

/// Coefficients of one right-hand side with its leave-one-out errors.
#[derive(Debug, Clone, PartialEq)]
pub struct LeastSquaresFit {
    /// Coefficients, in the order of the columns.
    pub coefficients: Vec<f64>,
    /// Residuals y − A c.
    pub residuals: Vec<f64>,
    /// Errors of predicting each sample from all others.
    pub leave_one_out: LeaveOneOut,
}

/// Exact errors r_i/(1 − h_i) of predicting each sample from all others, with the leverage h_i.
///
/// A sample with leverage 1 determines a coefficient alone and cannot be predicted from the others.
///
/// # References
/// Allen, *Technometrics* **16** (1974) 125, <https://doi.org/10.1080/00401706.1974.10489157>.
#[derive(Debug, Clone, PartialEq)]
pub struct LeaveOneOut {
    /// y_i minus its prediction from all other samples; `None` where the leverage is 1.
    pub errors: Vec<Option<f64>>,
    /// Mean square error divided by the sample variance (n − 1) of the response; `None` if a sample cannot be predicted
    /// or the response is constant.
    pub relative_error: Option<f64>,
}

impl LeaveOneOut {
    /// Computes the errors from the residuals and leverages of a fit.
    pub(super) fn new(response: &[f64], residuals: &[f64], leverages: &[f64]) -> Self {
        let n = response.len() as f64;
        let errors: Vec<Option<f64>> = residuals
            .iter()
            .zip(leverages)
            .map(|(residual, leverage)| is_determined(*leverage, n).then(|| residual / (1.0 - leverage)))
            .collect();
        let mean = response.iter().sum::<f64>() / n;
        let variance = response.iter().map(|y| (y - mean).powi(2)).sum::<f64>() / (n - 1.0);
        let mean_square = errors.iter().map(|e| e.map(|e| e * e)).sum::<Option<f64>>().map(|sum| sum / n);
        let relative_error = mean_square.filter(|_| variance > 0.0).map(|square| square / variance);
        Self { errors, relative_error }
    }

    /// Returns the number of samples that cannot be predicted from the others.
    pub fn undetermined(&self) -> usize {
        self.errors.iter().filter(|e| e.is_none()).count()
    }
}

impl LeastSquares {
    /// Factorises the design matrix, shape `[samples K, coefficients P]`, K > P.
    ///
    /// # Errors
    /// K ≤ P, a value is not finite, or the columns are linearly dependent in double precision.
    pub fn new(design: Array2<f64>) -> Result<Self, RegressionError> {
        let (samples, coefficients) = design.dim();
        if samples <= coefficients {
            return Err(RegressionError::TooFewSamples { samples, coefficients });
        }
        if let Some(sample) = design.rows().into_iter().position(|row| row.iter().any(|a| !a.is_finite())) {
            return Err(RegressionError::NotFinite { sample });
        }
        let qr = Qr::new(design);
        let condition = triangular_condition(qr.r.view());
        if condition > 1.0 / (f64::EPSILON * samples as f64) {
            return Err(RegressionError::RankDeficient { samples, coefficients, condition });
        }
        let leverages = qr.q.rows().into_iter().map(|row| row.iter().map(|q| q * q).sum()).collect();
        Ok(Self { qr, leverages, condition })
    }

    /// Returns the number of samples K.
    pub fn samples(&self) -> usize {
        self.qr.q.nrows()
    }

    /// Returns the number of coefficients P.
    pub fn coefficients(&self) -> usize {
        self.qr.q.ncols()
    }

    /// Returns the leverages h_i, the diagonal of A (AᵀA)⁻¹ Aᵀ. They lie in [0, 1] and sum to P.
    pub fn leverages(&self) -> &[f64] {
        &self.leverages
    }

    /// Returns the ratio of the largest to the smallest singular value of the design matrix.
    pub fn condition(&self) -> f64 {
        self.condition
    }

    /// Solves for one response of K values.
    ///
    /// # Errors
    /// The number of values is wrong, or a value is not finite.
    pub fn fit(&self, response: &[f64]) -> Result<LeastSquaresFit, RegressionError> {
        let samples = self.samples();
        if response.len() != samples {
            return Err(RegressionError::Length { values: response.len(), samples });
        }
        if let Some(sample) = response.iter().position(|y| !y.is_finite()) {
            return Err(RegressionError::NotFinite { sample });
        }
        let y = ArrayView1::from(response);
        let projected = self.qr.q.t().dot(&y);
        let residuals = (&y - &self.qr.q.dot(&projected)).to_vec();
        let mut solution = projected.insert_axis(Axis(1));
        solve_upper(self.qr.r.view(), solution.view_mut());
        Ok(LeastSquaresFit {
            coefficients: solution.iter().copied().collect(),
            leave_one_out: LeaveOneOut::new(response, &residuals, &self.leverages),
            residuals,
        })
    }

    /// Returns the coefficients that a fit would have without each of the samples, shape `[coefficients P, samples K]`;
    /// `None` if a sample has leverage 1.
    ///
    /// They are c − (AᵀA)⁻¹ a_i e_i with the row a_i of A and the leave-one-out error e_i.
    pub(super) fn without_each(&self, fit: &LeastSquaresFit) -> Option<Array2<f64>> {
        let errors: Vec<f64> = fit.leave_one_out.errors.iter().copied().collect::<Option<_>>()?;
        let mut without = self.qr.q.t().as_standard_layout().into_owned();
        solve_upper(self.qr.r.view(), without.view_mut());
        for (mut row, c) in without.rows_mut().into_iter().zip(&fit.coefficients) {
            row.iter_mut().zip(&errors).for_each(|(change, error)| *change = c - *change * error);
        }
        Some(without)
    }
}

/// Returns whether the other samples determine the prediction of a sample with this leverage, of `samples` in all.
///
/// The square root of a leverage is the length of a row of an orthonormal matrix, which determines its rounding error.
fn is_determined(leverage: f64, samples: f64) -> bool {
    1.0 - leverage > 8.0 * f64::EPSILON * samples
}
