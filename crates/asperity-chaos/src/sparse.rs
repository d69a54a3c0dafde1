//! Sparse regression: selects few of many candidate functions; there may be more candidates than samples.
//!
//! [`Candidates`] is the design matrix, [`SparseRegression`] sets the selection method and the stopping rule, and
//! [`SparseFit`] is the model with the smallest error by the [`SizeCriterion`]. If no model predicts the response
//! better than its mean, the result is an error, never a constant.
//!
//! ```
//! use asperity_chaos::{Basis, Candidates, Design, SamplingMethod, SparseRegression};
//!
//! let design = Design::new(SamplingMethod::LatinHypercube, 1, "sparse example", 40, 4)?;
//! let xi_samples: Vec<Vec<f64>> = (0..design.samples()).map(|i| design.xi(i)).collect();
//! let values: Vec<f64> = xi_samples.iter().map(|xi| 2.0 + xi[0] + 3.0 * xi[1] * xi[3]).collect();
//! let matrix = Basis::hermite(4, 5)?.design_matrix(&xi_samples); // 126 functions on 40 samples
//! let fit = SparseRegression::default().select(&Candidates::new(matrix.view())?, &values)?;
//! assert_eq!(fit.terms.len(), 3);
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```

mod candidates;
mod cross_validation;
mod error;
mod fit;
mod growing_fit;
mod least_angle;
mod matching_pursuit;
mod path;
mod search;
mod settings;
#[cfg(test)]
mod tests;

pub use candidates::Candidates;
pub use error::SparseError;
pub use fit::{Attempt, SparseFit, StopReason};
use growing_fit::{GrowingFit, mean_and_spread};
pub use settings::{SizeCriterion, SparseMethod, SparseRegression};

/// Minimum number of terms without a new minimum before a path ends.
const LEAST_PATIENCE: usize = 10;

impl SparseRegression {
    /// Selects the best model of one response; see [`SizeCriterion`] for the meaning of its errors.
    ///
    /// A path costs one product with the matrix per term, and memory proportional to the square of the number of
    /// samples. The result is bit-identical for any number of threads.
    ///
    /// # Errors
    /// The response has the wrong length, is not finite or constant, no candidate varies, or no model is better than
    /// the mean.
    pub fn select(&self, candidates: &Candidates<'_>, response: &[f64]) -> Result<SparseFit, SparseError> {
        let samples = candidates.samples();
        if response.len() != samples {
            return Err(SparseError::Length { values: response.len(), samples });
        }
        if let Some(sample) = response.iter().position(|y| !y.is_finite()) {
            return Err(SparseError::NotFinite { sample });
        }
        let (mean, spread) = mean_and_spread(response);
        let length = response.iter().map(|y| y * y).sum::<f64>().sqrt();
        if spread <= candidates::ROUNDING * length {
            return Err(SparseError::ConstantResponse { value: mean });
        }
        if candidates.selectable() == 0 {
            return Err(SparseError::NoCandidates { columns: candidates.columns() });
        }
        let limit = self.term_limit(candidates);
        match self.size {
            SizeCriterion::CorrectedLeaveOneOut => {
                let patience = LEAST_PATIENCE.max((self.patience * limit as f64).ceil() as usize);
                let n = samples as f64;
                // P = 1, AᵀA = n, and every leverage 1/n.
                let of_the_mean = (n / (n - 1.0)).powi(2) * (1.0 + 1.0 / n);
                self.method.search(GrowingFit::new(candidates, response), limit, patience).finish(response, of_the_mean)
            }
            SizeCriterion::CrossValidation { folds } => {
                cross_validation::select(self.method, candidates, response, limit, folds)
            }
        }
    }

    /// Returns the maximum number of terms. Estimating an error requires one more sample than terms.
    fn term_limit(&self, candidates: &Candidates<'_>) -> usize {
        let constant = usize::from(candidates.constant().is_some());
        let all = (candidates.selectable() + constant).min(candidates.samples() - 1);
        self.max_terms.map_or(all, |terms| terms.min(all))
    }
}
