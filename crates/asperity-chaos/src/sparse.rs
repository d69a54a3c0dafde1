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
mod growing_fit;
mod least_angle;
mod matching_pursuit;
mod path;
mod subspace_pursuit;
#[cfg(test)]
mod tests;

use thiserror::Error;

use super::LeaveOneOut;
pub use candidates::Candidates;
use growing_fit::GrowingFit;

/// Method that selects terms.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum SparseMethod {
    /// The term most correlated with the residual enters; then all coefficients are refitted.
    ///
    /// # References
    /// Pati, Rezaiifar & Krishnaprasad, *Proc. 27th Asilomar Conf.* (1993) 40,
    /// <https://doi.org/10.1109/ACSSC.1993.342465>.
    #[default]
    OrthogonalMatchingPursuit,
    /// Terms enter in the order of least-angle regression; their coefficients are fitted by least squares (hybrid
    /// LARS).
    ///
    /// # References
    /// Efron, Hastie, Johnstone & Tibshirani, *Ann. Statist.* **32** (2004) 407, <https://doi.org/10.1214/009053604000000067>.
    /// Blatman & Sudret, *J. Comput. Phys.* **230** (2011) 2345, <https://doi.org/10.1016/j.jcp.2010.12.021>.
    LeastAngle,
    /// For a given number of terms, the whole set is exchanged until the residual stops decreasing. Up to half as many
    /// terms as samples are tried.
    ///
    /// # References
    /// Dai & Milenkovic, *IEEE Trans. Inf. Theory* **55** (2009) 2230, <https://doi.org/10.1109/TIT.2009.2016006>.
    /// Diaz, Doostan & Hampton, *Comput. Methods Appl. Mech. Eng.* **336** (2018) 640,
    /// <https://doi.org/10.1016/j.cma.2018.03.020>.
    SubspacePursuit,
}

/// Criterion that selects the number of terms.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum SizeCriterion {
    /// The smallest corrected leave-one-out error, [`Attempt::corrected`], on one path. It ignores that the left-out
    /// sample took part in the selection. For noisy responses and more candidates than samples, matching pursuit finds
    /// models of almost as many terms as samples whose leave-one-out error vanishes but which predict nothing.
    CorrectedLeaveOneOut,
    /// The smallest cross-validation error: terms are selected and fitted without each of `folds` parts of the samples
    /// and tested on that part. One more path with the selected number of terms uses all samples. The parts are a fixed
    /// random partition.
    ///
    /// # References
    /// Stone, *J. R. Stat. Soc. B* **36** (1974) 111, <https://doi.org/10.1111/j.2517-6161.1974.tb00994.x>.
    CrossValidation {
        /// Number of parts, between two and the number of samples.
        folds: usize,
    },
}

/// Settings of a sparse regression.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SparseRegression {
    /// Method that selects terms.
    pub method: SparseMethod,
    /// Criterion that selects the number of terms.
    pub size: SizeCriterion,
    /// Maximum number of terms of a model including the constant. It is also limited by the number of samples less one.
    pub max_terms: Option<usize>,
    /// Fraction of the largest number of terms after which a path without a new minimum of the corrected leave-one-out
    /// error ends (at least ten terms). With 1 the whole path is evaluated. Subspace pursuit has no path.
    pub patience: f64,
}

impl Default for SparseRegression {
    fn default() -> Self {
        let size = SizeCriterion::CrossValidation { folds: 10 };
        Self { method: SparseMethod::default(), size, max_terms: None, patience: 0.1 }
    }
}

/// Model that was tried.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Attempt {
    /// Number P of terms including the constant.
    pub terms: usize,
    /// Mean square error of predicting each of the N samples from all others, divided by the sample variance (N − 1) of
    /// the response; `None` if a sample alone determines a coefficient.
    pub leave_one_out: Option<f64>,
    /// Leave-one-out error times N/(N−P) · (1 + tr (AᵀA)⁻¹) with the P columns A of the model. The factor corrects for
    /// the expected reduction of the error by fitting. The trace assumes functions of unit mean square.
    ///
    /// # References
    /// Chapelle, Vapnik & Bengio, *Mach. Learn.* **48** (2002) 9, <https://doi.org/10.1023/A:1013943418833>;
    /// Blatman & Sudret 2011 (see [`SparseMethod::LeastAngle`]).
    pub corrected: Option<f64>,
    /// Mean square error of selecting and fitting this number of terms by cross-validation, divided by the same
    /// variance, if computed.
    pub cross_validated: Option<f64>,
}

impl Attempt {
    /// Returns the error by which models are compared; infinite if a sample is undetermined.
    fn error(&self) -> f64 {
        self.cross_validated.or(self.corrected).unwrap_or(f64::INFINITY)
    }
}

/// Reason why no more models were tried.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum StopReason {
    /// The residual is at the level of rounding.
    Exact,
    /// The corrected leave-one-out error has risen for the required number of terms.
    ErrorRose,
    /// The allowed number of terms, or the number that the samples determine, is reached.
    TermLimit,
    /// The terms span all remaining candidates.
    Exhausted,
}

/// Model with the smallest error.
#[derive(Debug, Clone, PartialEq)]
pub struct SparseFit {
    /// Columns of the candidates in the order in which they entered; a constant column is first.
    pub terms: Vec<usize>,
    /// Least-squares coefficient of each term.
    pub coefficients: Vec<f64>,
    /// Leave-one-out prediction errors.
    pub leave_one_out: LeaveOneOut,
    /// Errors of the chosen model.
    pub chosen: Attempt,
    /// Ratio of the largest to the smallest singular value of the terms' columns.
    pub condition: f64,
    /// All models that were tried.
    pub path: Vec<Attempt>,
    /// Reason why no more models were tried.
    pub stop_reason: StopReason,
}

impl SparseFit {
    /// Returns the coefficients of all candidates, zero for unselected ones.
    ///
    /// # Panics
    /// If a term is not below `candidates`.
    pub fn dense(&self, candidates: usize) -> Vec<f64> {
        let mut all = vec![0.0; candidates];
        self.terms.iter().zip(&self.coefficients).for_each(|(&term, &coefficient)| all[term] = coefficient);
        all
    }
}

/// Reason why there is no sparse model.
#[derive(Debug, Clone, PartialEq, Error)]
#[non_exhaustive]
pub enum SparseError {
    /// There are too few samples to leave one out.
    #[error("{samples} samples; at least three are needed")]
    TooFewSamples {
        /// Number of samples.
        samples: usize,
    },
    /// A value of the design matrix or of the response is not finite.
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
    /// The response is constant up to rounding.
    #[error("the response is {value} in all samples: there is nothing to explain")]
    ConstantResponse {
        /// Mean of the response.
        value: f64,
    },
    /// No column of the design varies.
    #[error("none of the {columns} candidates varies over the samples")]
    NoCandidates {
        /// Columns of the design.
        columns: usize,
    },
    /// No model predicts better than the mean of the response.
    #[error(
        "none of {tried} models predicts the response better than its mean: error {:.4} at best, {of_the_mean:.4} of the mean",
        attempts.first().map_or(f64::INFINITY, Attempt::error)
    )]
    NothingPredicts {
        /// Number of models tried.
        tried: usize,
        /// Error of the mean by the same criterion.
        of_the_mean: f64,
        /// The best attempts, in order of increasing error.
        attempts: Vec<Attempt>,
    },
}

/// Number of attempts that an error reports.
const REPORTED: usize = 5;

/// Minimum number of terms without a new minimum before a path ends.
const LEAST_PATIENCE: usize = 10;

impl SparseRegression {
    /// Selects the best model of one response; see [`SizeCriterion`] for the meaning of its errors.
    ///
    /// A path costs one product with the matrix per term (per exchange for subspace pursuit), and memory proportional
    /// to the square of the number of samples. The result is bit-identical for any number of threads.
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
                self.search(GrowingFit::new(candidates, response), limit, patience).finish(response, of_the_mean)
            }
            SizeCriterion::CrossValidation { folds } => {
                cross_validation::select(self, candidates, response, limit, folds)
            }
        }
    }

    fn search<'a, 'c>(&self, start: GrowingFit<'a, 'c>, limit: usize, patience: usize) -> Search<'a, 'c> {
        match self.method {
            SparseMethod::OrthogonalMatchingPursuit => matching_pursuit::search(start, limit, patience),
            SparseMethod::LeastAngle => least_angle::search(start, limit, patience),
            SparseMethod::SubspacePursuit => subspace_pursuit::search(start, limit),
        }
    }

    /// Returns the maximum number of terms. Estimating an error requires one more sample than terms.
    fn term_limit(&self, candidates: &Candidates<'_>) -> usize {
        let constant = usize::from(candidates.constant().is_some());
        let all = (candidates.selectable() + constant).min(candidates.samples() - 1);
        self.max_terms.map_or(all, |terms| terms.min(all))
    }
}

/// Result of a search: the fit of the largest or best model, and all attempts.
struct Search<'a, 'c> {
    fit: GrowingFit<'a, 'c>,
    /// Number of leading terms of `fit` that form the best model.
    best: usize,
    path: Vec<Attempt>,
    stop_reason: StopReason,
}

impl<'a, 'c> Search<'a, 'c> {
    /// Creates the result of a search for a single model.
    fn from_single(fit: GrowingFit<'a, 'c>) -> Self {
        let stop_reason = if fit.is_exact() { StopReason::Exact } else { StopReason::TermLimit };
        Self { best: fit.terms().len(), path: vec![fit.assess()], fit, stop_reason }
    }

    /// Returns the best model, or an error if the mean is better.
    fn finish(self, response: &[f64], of_the_mean: f64) -> Result<SparseFit, SparseError> {
        let best = self.path.iter().copied().min_by(|a, b| a.error().total_cmp(&b.error()));
        let Some(chosen) = best.filter(|best| best.error() < of_the_mean) else {
            let mut attempts = self.path;
            let tried = attempts.len();
            attempts.sort_by(|a, b| a.error().total_cmp(&b.error()));
            attempts.truncate(REPORTED);
            return Err(SparseError::NothingPredicts { tried, of_the_mean, attempts });
        };
        let (residuals, leverages) = self.fit.residuals_and_leverages(response, self.best);
        Ok(SparseFit {
            terms: self.fit.terms()[..self.best].to_vec(),
            coefficients: self.fit.coefficients(self.best),
            leave_one_out: LeaveOneOut::new(response, &residuals, &leverages),
            chosen: Attempt { terms: self.best, ..chosen },
            condition: self.fit.condition(self.best),
            path: self.path,
            stop_reason: self.stop_reason,
        })
    }
}

/// Returns the mean and the length of the deviation from it.
fn mean_and_spread(values: &[f64]) -> (f64, f64) {
    let mean = values.iter().sum::<f64>() / values.len() as f64;
    (mean, values.iter().map(|y| (y - mean).powi(2)).sum::<f64>().sqrt())
}
