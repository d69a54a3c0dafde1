//! Sparse models and the models that were tried.

use crate::LeaveOneOut;

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
    /// Blatman & Sudret 2011 (see [`SparseMethod::LeastAngle`](super::SparseMethod::LeastAngle)).
    pub corrected: Option<f64>,
    /// Mean square error of selecting and fitting this number of terms by cross-validation, divided by the same
    /// variance, if computed.
    pub cross_validated: Option<f64>,
}

impl Attempt {
    /// Returns the error by which models are compared; infinite if a sample is undetermined.
    pub(super) fn error(&self) -> f64 {
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
