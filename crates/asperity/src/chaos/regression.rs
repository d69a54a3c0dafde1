//! Linear least squares by QR factorisation.

use faer::Mat;
use faer::linalg::solvers::Qr;
use ndarray::ArrayView2;
use thiserror::Error;

/// Why a regression could not be made.
#[derive(Debug, Clone, PartialEq, Error)]
pub enum RegressionError {
    /// There are no more samples than coefficients.
    #[error("{samples} samples for {coefficients} coefficients; more samples than coefficients are needed")]
    TooFewSamples {
        /// Number K of samples.
        samples: usize,
        /// Number P of coefficients.
        coefficients: usize,
    },
    /// The functions cannot be told apart on the samples.
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
    /// A sample of the design matrix or of a response is not finite.
    #[error("sample {sample} is not a finite number")]
    NotFinite {
        /// Index of the first such sample.
        sample: usize,
    },
    /// The response has another length than the design.
    #[error("{values} response values for {samples} samples")]
    Length {
        /// Values given.
        values: usize,
        /// Samples of the design.
        samples: usize,
    },
}

/// A factorised least-squares problem min ‖A c − y‖₂ with K rows and P columns; one factorisation serves any number of
/// right-hand sides.
#[derive(Debug)]
pub struct LeastSquares {
    qr: Qr<f64>,
    /// Orthonormal basis of the columns, K × P.
    q: Mat<f64>,
    leverages: Vec<f64>,
    condition: f64,
}

/// Coefficients of one right-hand side, and how well they predict.
#[derive(Debug, Clone, PartialEq)]
pub struct Fit {
    /// Coefficients, in the order of the columns.
    pub coefficients: Vec<f64>,
    /// Residuals y − A c.
    pub residuals: Vec<f64>,
    /// Prediction of each sample from all others.
    pub leave_one_out: LeaveOneOut,
}

/// Errors of predicting each sample from all others: r_i/(1 − h_i), with the leverage h_i, exactly.
///
/// A sample with leverage 1 is alone in determining a coefficient; nothing can be said about it from the others.
///
/// # References
/// Allen, *Technometrics* **16** (1974) 125, <https://doi.org/10.1080/00401706.1974.10489157>.
#[derive(Debug, Clone, PartialEq)]
pub struct LeaveOneOut {
    /// y_i minus its prediction from all other samples; `None` where the leverage is 1.
    pub errors: Vec<Option<f64>>,
    /// Mean square error divided by the sample variance (n−1) of the response; `None` when a sample is undetermined or
    /// the response is constant.
    pub relative_error: Option<f64>,
}

impl LeaveOneOut {
    /// Number of samples that the others do not determine.
    pub fn undetermined(&self) -> usize {
        self.errors.iter().filter(|e| e.is_none()).count()
    }
}

impl LeastSquares {
    /// Factorises the design matrix, shape `[samples K, coefficients P]`, K > P.
    ///
    /// # Errors
    /// K ≤ P, a value that is not finite, or columns that are linearly dependent in double precision.
    pub fn new(design: ArrayView2<'_, f64>) -> Result<Self, RegressionError> {
        let (samples, coefficients) = design.dim();
        if samples <= coefficients {
            return Err(RegressionError::TooFewSamples { samples, coefficients });
        }
        if let Some(sample) = design.rows().into_iter().position(|row| row.iter().any(|a| !a.is_finite())) {
            return Err(RegressionError::NotFinite { sample });
        }
        let qr = Mat::from_fn(samples, coefficients, |i, j| design[[i, j]]).qr();
        let condition = condition(&qr);
        if condition > 1.0 / (f64::EPSILON * samples as f64) {
            return Err(RegressionError::RankDeficient { samples, coefficients, condition });
        }
        let q = qr.compute_thin_Q();
        let leverages = (0..samples).map(|i| (0..coefficients).map(|j| q[(i, j)] * q[(i, j)]).sum()).collect();
        Ok(Self { qr, q, leverages, condition })
    }

    /// Number of samples K.
    pub fn samples(&self) -> usize {
        self.q.nrows()
    }

    /// Number of coefficients P.
    pub fn coefficients(&self) -> usize {
        self.q.ncols()
    }

    /// Leverages h_i: the diagonal of A (AᵀA)⁻¹ Aᵀ. They lie in [0, 1] and sum to P.
    pub fn leverages(&self) -> &[f64] {
        &self.leverages
    }

    /// Ratio of the largest to the smallest singular value of the design matrix.
    pub fn condition(&self) -> f64 {
        self.condition
    }

    /// Solves for one response of K values.
    ///
    /// # Errors
    /// Another number of values, or one that is not finite.
    pub fn fit(&self, response: &[f64]) -> Result<Fit, RegressionError> {
        let (samples, count) = (self.samples(), self.coefficients());
        if response.len() != samples {
            return Err(RegressionError::Length { values: response.len(), samples });
        }
        if let Some(sample) = response.iter().position(|y| !y.is_finite()) {
            return Err(RegressionError::NotFinite { sample });
        }
        let y = Mat::from_fn(samples, 1, |i, _| response[i]);
        let projected = self.q.transpose() * &y;
        let residual = &y - &self.q * &projected;
        let mut solution = projected;
        self.qr.thin_R().solve_upper_triangular_in_place(solution.as_mut());
        let residuals: Vec<f64> = (0..samples).map(|i| residual[(i, 0)]).collect();
        Ok(Fit {
            coefficients: (0..count).map(|j| solution[(j, 0)]).collect(),
            leave_one_out: self.leave_one_out(response, &residuals),
            residuals,
        })
    }

    fn leave_one_out(&self, response: &[f64], residuals: &[f64]) -> LeaveOneOut {
        let n = response.len() as f64;
        // Rounding of a leverage, whose square root is the length of a row of an orthonormal matrix.
        let rounding = 8.0 * f64::EPSILON * n;
        let errors: Vec<Option<f64>> = residuals
            .iter()
            .zip(&self.leverages)
            .map(|(residual, leverage)| (1.0 - leverage > rounding).then(|| residual / (1.0 - leverage)))
            .collect();
        let mean = response.iter().sum::<f64>() / n;
        let variance = response.iter().map(|y| (y - mean).powi(2)).sum::<f64>() / (n - 1.0);
        let mean_square = errors.iter().map(|e| e.map(|e| e * e)).sum::<Option<f64>>().map(|sum| sum / n);
        let relative_error = mean_square.filter(|_| variance > 0.0).map(|square| square / variance);
        LeaveOneOut { errors, relative_error }
    }
}

/// Condition number of R, equal to that of the design; infinite when it cannot be computed.
fn condition(qr: &Qr<f64>) -> f64 {
    match qr.thin_R().singular_values() {
        Ok(values) => match (values.first(), values.last()) {
            (Some(largest), Some(smallest)) => largest / smallest,
            _ => 1.0,
        },
        Err(_) => f64::INFINITY,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::random::{standard_normal, stream};
    use ndarray::Array2;

    fn random_design(samples: usize, coefficients: usize) -> Array2<f64> {
        let values = standard_normal(&mut stream(4, "design", 0), samples * coefficients);
        Array2::from_shape_vec((samples, coefficients), values).unwrap()
    }

    #[test]
    fn an_exact_linear_response_is_recovered() {
        let design = random_design(40, 7);
        let truth: Vec<f64> = (0..7).map(|j| f64::from(j) - 2.5).collect();
        let response: Vec<f64> =
            design.rows().into_iter().map(|row| row.iter().zip(&truth).map(|(a, c)| a * c).sum()).collect();
        let fit = LeastSquares::new(design.view()).unwrap().fit(&response).unwrap();
        for (found, wanted) in fit.coefficients.iter().zip(&truth) {
            assert!((found - wanted).abs() < 1e-12);
        }
        assert!(fit.leave_one_out.relative_error.unwrap() < 1e-24);
    }

    #[test]
    fn residuals_are_orthogonal_to_every_column_and_leverages_sum_to_the_rank() {
        let design = random_design(60, 9);
        let response = standard_normal(&mut stream(4, "response", 0), 60);
        let least_squares = LeastSquares::new(design.view()).unwrap();
        let fit = least_squares.fit(&response).unwrap();
        for column in design.columns() {
            let inner: f64 = column.iter().zip(&fit.residuals).map(|(a, r)| a * r).sum();
            assert!(inner.abs() < 1e-12);
        }
        assert!((least_squares.leverages().iter().sum::<f64>() - 9.0).abs() < 1e-12);
    }

    #[test]
    fn leave_one_out_errors_are_those_of_refitting_without_each_sample() {
        let design = random_design(25, 4);
        let response = standard_normal(&mut stream(4, "response", 1), 25);
        let fit = LeastSquares::new(design.view()).unwrap().fit(&response).unwrap();
        for left_out in 0..25 {
            let kept: Vec<usize> = (0..25).filter(|&i| i != left_out).collect();
            let fewer = design.select(ndarray::Axis(0), &kept);
            let values: Vec<f64> = kept.iter().map(|&i| response[i]).collect();
            let refit = LeastSquares::new(fewer.view()).unwrap().fit(&values).unwrap();
            let prediction: f64 = design.row(left_out).iter().zip(&refit.coefficients).map(|(a, c)| a * c).sum();
            let error = fit.leave_one_out.errors[left_out].unwrap();
            assert!((error - (response[left_out] - prediction)).abs() < 1e-12);
        }
    }

    #[test]
    fn a_sample_that_alone_determines_a_coefficient_has_no_leave_one_out_error() {
        let mut design = random_design(12, 3);
        design.column_mut(2).fill(0.0);
        design[[5, 2]] = 1.0;
        let response = standard_normal(&mut stream(4, "response", 2), 12);
        let fit = LeastSquares::new(design.view()).unwrap().fit(&response).unwrap();
        assert_eq!(fit.leave_one_out.undetermined(), 1);
        assert_eq!(fit.leave_one_out.errors[5], None);
        assert_eq!(fit.leave_one_out.relative_error, None);
    }

    #[test]
    fn the_condition_number_of_scaled_orthogonal_columns_is_their_ratio() {
        let mut design = Array2::zeros((8, 2));
        for i in 0..8 {
            design[[i, 0]] = 1.0;
            design[[i, 1]] = if i % 2 == 0 { 1e-6 } else { -1e-6 };
        }
        let condition = LeastSquares::new(design.view()).unwrap().condition();
        assert!((condition / 1e6 - 1.0).abs() < 1e-9, "condition {condition}");
    }

    #[test]
    fn hopeless_problems_are_refused() {
        let error = LeastSquares::new(random_design(5, 5).view()).unwrap_err();
        assert_eq!(error, RegressionError::TooFewSamples { samples: 5, coefficients: 5 });
        let mut twins = random_design(20, 3);
        let first = twins.column(0).to_owned();
        twins.column_mut(2).assign(&first);
        assert!(matches!(LeastSquares::new(twins.view()), Err(RegressionError::RankDeficient { .. })));
        let mut holed = random_design(20, 3);
        holed[[7, 1]] = f64::NAN;
        assert_eq!(LeastSquares::new(holed.view()).unwrap_err(), RegressionError::NotFinite { sample: 7 });
    }
}
