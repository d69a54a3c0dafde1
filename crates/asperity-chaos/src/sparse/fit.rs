//! Sparse models and the models that were tried.

use crate::LeaveOneOut;

/// Number of terms that was tried.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Attempt {
    /// Number of terms including the constant.
    pub terms: usize,
    /// Mean square error of selecting and fitting this number of terms by cross-validation, divided by the sample
    /// variance (N − 1) of the response.
    pub error: f64,
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
    /// Cross-validation error of its number of terms, as [`Attempt::error`].
    pub cross_validated: f64,
    /// Ratio of the largest to the smallest singular value of the terms' columns.
    pub condition: f64,
    /// All numbers of terms that were tried.
    pub path: Vec<Attempt>,
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
