//! Sparse regression: few of many candidate functions, more candidates than samples allowed.
//!
//! [`Candidates`] is the design matrix, [`SparseRegression`] says how terms are found and when to stop, [`SparseFit`] is the
//! model whose error is least by the [`SizeCriterion`]. Where no model predicts the response better than its mean does, the
//! answer is an error, never a constant.
//!
//! ```
//! use asperity_chaos::{Basis, Candidates, Design, SamplingMethod, SparseRegression};
//!
//! let design = Design::new(SamplingMethod::LatinHypercube, 1, "sparse example", 40, 4)?;
//! let samples of Î¾: Vec<Vec<f64>> = (0..design.samples()).map(|i| design.Î¾(i)).collect();
//! let values: Vec<f64> = samples of Î¾.iter().map(|xi| 2.0 + xi[0] + 3.0 * xi[1] * xi[3]).collect();
//! let matrix = Basis::hermite(4, 5)?.design_matrix(&samples of Î¾); // 126 functions on 40 samples
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

/// How terms are found.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum SparseMethod {
    /// The term most correlated with the residual enters, all coefficients are fitted again.
    ///
    /// # References
    /// Pati, Rezaiifar & Krishnaprasad, *Proc. 27th Asilomar Conf.* (1993) 40,
    /// <https://doi.org/10.1109/ACSSC.1993.342465>.
    #[default]
    OrthogonalMatchingPursuit,
    /// Terms enter in the order of least-angle regression; their coefficients are those of least squares (hybrid LARS).
    ///
    /// # References
    /// Efron, Hastie, Johnstone & Tibshirani, *Ann. Statist.* **32** (2004) 407, <https://doi.org/10.1214/009053604000000067>.
    /// Blatman & Sudret, *J. Comput. Phys.* **230** (2011) 2345, <https://doi.org/10.1016/j.jcp.2010.12.021>.
    LeastAngle,
    /// For a given number of terms, the set is exchanged as a whole until the residual no longer falls. Numbers up to
    /// half of that of the samples are tried.
    ///
    /// # References
    /// Dai & Milenkovic, *IEEE Trans. Inf. Theory* **55** (2009) 2230, <https://doi.org/10.1109/TIT.2009.2016006>.
    /// Diaz, Doostan & Hampton, *Comput. Methods Appl. Mech. Eng.* **336** (2018) 640,
    /// <https://doi.org/10.1016/j.cma.2018.03.020>.
    SubspacePursuit,
}

/// How the number of terms is chosen.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum SizeCriterion {
    /// The least corrected leave-one-out error, [`Attempt::corrected`]: one path. It does not know that the terms were
    /// chosen with the sample left out. Where a response has noise, matching pursuit among more candidates than samples finds
    /// models of almost as many terms as samples whose leave-one-out error vanishes, and which predict nothing.
    CorrectedLeaveOneOut,
    /// The least error of terms chosen and fitted without each of `folds` parts of the samples, on that part: a path for
    /// each part, and one of that many terms on all samples. The parts are a fixed random partition.
    ///
    /// # References
    /// Stone, *J. R. Stat. Soc. B* **36** (1974) 111, <https://doi.org/10.1111/j.2517-6161.1974.tb00994.x>.
    CrossValidation {
        /// Parts, at least two; as many as samples at most.
        folds: usize,
    },
}

/// A sparse regression: the method, and when it stops.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SparseRegression {
    /// How terms are found.
    pub method: SparseMethod,
    /// How their number is chosen.
    pub size: SizeCriterion,
    /// Most terms of a model, the constant included; beside it the samples less one are the bound.
    pub max_terms: Option<usize>,
    /// With the corrected leave-one-out error a path ends when it has not reached a new minimum for this share of the largest
    /// number of terms, and for ten terms. With 1 the whole path is walked. Subspace pursuit has no path.
    pub patience: f64,
}

impl Default for SparseRegression {
    fn default() -> Self {
        let size = SizeCriterion::CrossValidation { folds: 10 };
        Self { method: SparseMethod::default(), size, max_terms: None, patience: 0.1 }
    }
}

/// A model that was tried.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Attempt {
    /// Number P of terms, the constant included.
    pub terms: usize,
    /// Mean square error of predicting each of the N samples from all others, divided by the sample variance (N−1) of the
    /// response; `None` when a sample alone determines a coefficient.
    pub leave_one_out: Option<f64>,
    /// The same times N/(N−P) · (1 + tr (AᵀA)⁻¹), for the P columns A of the model: what fitting on the
    /// samples is expected to have taken off the error. The trace supposes functions of unit mean square.
    ///
    /// # References
    /// Chapelle, Vapnik & Bengio, *Mach. Learn.* **48** (2002) 9, <https://doi.org/10.1023/A:1013943418833>;
    /// Blatman & Sudret 2011 (see [`SparseMethod::LeastAngle`]).
    pub corrected: Option<f64>,
    /// Mean square error of choosing and fitting so many terms by cross-validation, divided by the same variance; where it
    /// was computed.
    pub cross_validated: Option<f64>,
}

impl Attempt {
    /// The error by which models are compared; infinite when a sample is undetermined.
    fn error(&self) -> f64 {
        self.cross_validated.or(self.corrected).unwrap_or(f64::INFINITY)
    }
}

/// Why no more models were tried.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum StopReason {
    /// The residual is rounding.
    Exact,
    /// The corrected leave-one-out error had risen for long enough.
    ErrorRose,
    /// As many terms as allowed, or as the samples determine.
    TermLimit,
    /// No candidate is left that the terms do not already span.
    Exhausted,
}

/// The model whose error is least.
#[derive(Debug, Clone, PartialEq)]
pub struct SparseFit {
    /// Columns of the candidates in the order in which they entered; the constant, if there is one, is first.
    pub terms: Vec<usize>,
    /// Least-squares coefficient of each term.
    pub coefficients: Vec<f64>,
    /// Prediction of each sample from all others.
    pub leave_one_out: LeaveOneOut,
    /// Its errors.
    pub chosen: Attempt,
    /// Ratio of the largest to the smallest singular value of the terms' columns.
    pub condition: f64,
    /// All models that were tried.
    pub path: Vec<Attempt>,
    /// Why no more were tried.
    pub stop_reason: StopReason,
}

impl SparseFit {
    /// The coefficients of all candidates, zero for those that are no term.
    ///
    /// # Panics
    /// If a term is not below `candidates`.
    pub fn dense(&self, candidates: usize) -> Vec<f64> {
        let mut all = vec![0.0; candidates];
        self.terms.iter().zip(&self.coefficients).for_each(|(&term, &coefficient)| all[term] = coefficient);
        all
    }
}

/// Why there is no sparse model.
#[derive(Debug, Clone, PartialEq, Error)]
pub enum SparseError {
    /// Nothing can be left out and predicted.
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
    /// The response has another length than the design.
    #[error("{values} response values for {samples} samples")]
    Length {
        /// Values given.
        values: usize,
        /// Samples of the design.
        samples: usize,
    },
    /// The response is the same everywhere, up to rounding.
    #[error("the response is {value} in all samples: there is nothing to explain")]
    ConstantResponse {
        /// Its mean.
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
        /// The best of them, best first.
        attempts: Vec<Attempt>,
    },
}

/// Attempts that an error carries.
const REPORTED: usize = 5;

/// A path ends at the earliest after so many terms without a new minimum.
const LEAST_PATIENCE: usize = 10;

impl SparseRegression {
    /// The best model of one response. See [`SizeCriterion`] for what its errors say.
    ///
    /// A path costs a product with the matrix for each term (for each exchange, of subspace pursuit), and memory for the square of
    /// the number of samples. The same bits for any number of threads.
    ///
    /// # Errors
    /// A response of another length, not finite, or constant; no candidate that varies; no model better than the mean.
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

    /// Most terms of a model; one sample more than terms is needed to estimate an error.
    fn term_limit(&self, candidates: &Candidates<'_>) -> usize {
        let constant = usize::from(candidates.constant().is_some());
        let all = (candidates.selectable() + constant).min(candidates.samples() - 1);
        self.max_terms.map_or(all, |terms| terms.min(all))
    }
}

/// What a method found: the fit of the largest or best model, and all attempts.
struct Search<'a, 'c> {
    fit: GrowingFit<'a, 'c>,
    /// Terms of `fit` that make the best model.
    best: usize,
    path: Vec<Attempt>,
    stop_reason: StopReason,
}

impl<'a, 'c> Search<'a, 'c> {
    /// A model that was searched for alone.
    fn from_single(fit: GrowingFit<'a, 'c>) -> Self {
        let stop_reason = if fit.is_exact() { StopReason::Exact } else { StopReason::TermLimit };
        Self { best: fit.terms().len(), path: vec![fit.assess()], fit, stop_reason }
    }

    /// The best model, unless the mean alone is better.
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

/// Mean, and the length of what differs from it.
fn mean_and_spread(values: &[f64]) -> (f64, f64) {
    let mean = values.iter().sum::<f64>() / values.len() as f64;
    (mean, values.iter().map(|y| (y - mean).powi(2)).sum::<f64>().sqrt())
}
