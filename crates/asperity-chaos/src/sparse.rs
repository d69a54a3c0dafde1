//! Sparse regression: selects few of many candidate functions; there may be more candidates than samples.
//!
//! [`Candidates`] is the design matrix. Orthogonal matching pursuit orders the terms: the one most correlated with the
//! residual enters, then all coefficients are refitted. [`SparseFit`] has the number of terms with the smallest
//! cross-validation error. If no model predicts the response better than its mean, the result is an error, never a
//! constant.
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
mod matching_pursuit;
#[cfg(test)]
mod tests;

pub use candidates::Candidates;
pub use error::SparseError;
pub use fit::{Attempt, SparseFit};
use growing_fit::mean_and_spread;

/// Selection of terms by orthogonal matching pursuit, and of their number by cross-validation.
///
/// Terms are selected and fitted without each of some parts of the samples and tested on that part; one more path with
/// the selected number of terms uses all samples. The parts are a fixed random partition. A leave-one-out error would ignore
/// that the sample left out took part in the selection: pursuit finds models of almost as many terms as samples for pure
/// noise.
///
/// # References
/// Pati, Rezaiifar & Krishnaprasad, *Proc. 27th Asilomar Conf.* (1993) 40, <https://doi.org/10.1109/ACSSC.1993.342465>;
/// Stone, *J. R. Stat. Soc. B* **36** (1974) 111, <https://doi.org/10.1111/j.2517-6161.1974.tb00994.x>.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SparseRegression {
    /// Number of parts of the samples, between two and the number of samples.
    pub folds: usize,
    /// Maximum number of terms of a model including the constant. It is also limited by the number of samples less one.
    pub max_terms: Option<usize>,
}

impl Default for SparseRegression {
    fn default() -> Self {
        Self { folds: 10, max_terms: None }
    }
}

/// Returns the value of a response that is constant up to rounding.
pub(super) fn constant_value(response: &[f64]) -> Option<f64> {
    let first = *response.first()?;
    if response.iter().all(|y| *y == first) {
        return Some(first);
    }
    let (mean, spread) = mean_and_spread(response);
    let length = response.iter().map(|y| y * y).sum::<f64>().sqrt();
    (spread <= candidates::ROUNDING * length).then_some(mean)
}

impl SparseRegression {
    /// Selects the best model of one response.
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
        if let Some(value) = constant_value(response) {
            return Err(SparseError::ConstantResponse { value });
        }
        if candidates.selectable() == 0 {
            return Err(SparseError::NoCandidates { columns: candidates.columns() });
        }
        cross_validation::select(candidates, response, self.term_limit(candidates), self.folds)
    }

    /// Returns the maximum number of terms. Estimating an error requires one more sample than terms.
    fn term_limit(&self, candidates: &Candidates<'_>) -> usize {
        let constant = usize::from(candidates.constant().is_some());
        let all = (candidates.selectable() + constant).min(candidates.samples() - 1);
        self.max_terms.map_or(all, |terms| terms.min(all))
    }
}
