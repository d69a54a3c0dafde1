//! Paths that add one term at a time.

use super::fit::{Attempt, StopReason};
use super::growing_fit::GrowingFit;
use super::search::Search;

/// Squared remaining fraction of a standardised column that counts as rounding.
const SPANNED: f64 = 1e-13;

/// Fit that grows until its corrected leave-one-out error has risen for the required number of terms.
pub(super) struct Path<'a, 'c> {
    pub(super) fit: GrowingFit<'a, 'c>,
    /// Products of all standardised columns with the last orthonormal direction.
    pub(super) products: Vec<f64>,
    /// Squared length of the part of each standardised column outside the span of the terms; negative for columns that
    /// may not enter.
    beside: Vec<f64>,
    attempts: Vec<Attempt>,
    best: usize,
    least: f64,
    limit: usize,
    patience: usize,
}

impl<'a, 'c> Path<'a, 'c> {
    pub(super) fn new(fit: GrowingFit<'a, 'c>, limit: usize, patience: usize) -> Self {
        let candidates = fit.candidates();
        let columns = candidates.columns();
        let beside = (0..columns).map(|j| if candidates.norm(j) > 0.0 { 1.0 } else { -1.0 }).collect();
        let products = vec![0.0; columns];
        Self { fit, products, beside, attempts: Vec::new(), best: 0, least: f64::INFINITY, limit, patience }
    }

    /// Returns the products of the standardised columns with the residual.
    pub(super) fn correlations(&self) -> Vec<f64> {
        let mut correlations = vec![0.0; self.products.len()];
        self.fit.candidates().correlate(self.fit.residual(), &mut correlations);
        correlations
    }

    /// Returns the columns that may enter.
    pub(super) fn open(&self) -> impl Iterator<Item = usize> + '_ {
        self.beside.iter().enumerate().filter(|(_, beside)| **beside > 0.0).map(|(column, _)| column)
    }

    /// Returns the open column with the largest absolute value, the first of equal ones.
    pub(super) fn largest(&self, values: &[f64]) -> Option<usize> {
        let mut best: Option<usize> = None;
        for column in self.open() {
            if best.is_none_or(|best| values[column].abs() > values[best].abs()) {
                best = Some(column);
            }
        }
        best
    }

    /// Adds a term and computes the products with its direction. Returns `false` if the other terms span its column.
    pub(super) fn enter(&mut self, column: usize) -> bool {
        self.beside[column] = -1.0;
        if !self.fit.enter(column) {
            return false;
        }
        self.fit.candidates().correlate(self.fit.last_direction(), &mut self.products);
        for (beside, product) in self.beside.iter_mut().zip(&self.products) {
            *beside -= product * product;
            if *beside < SPANNED {
                *beside = -1.0;
            }
        }
        true
    }

    /// Records the errors of the model. Returns the reason if the path ends with it.
    pub(super) fn note(&mut self) -> Option<StopReason> {
        let attempt = self.fit.assess();
        self.attempts.push(attempt);
        if attempt.error() < self.least {
            (self.best, self.least) = (attempt.terms, attempt.error());
        }
        if self.fit.is_exact() {
            Some(StopReason::Exact)
        } else if attempt.terms >= self.limit {
            Some(StopReason::TermLimit)
        } else if attempt.terms >= self.best + self.patience {
            Some(StopReason::ErrorRose)
        } else {
            None
        }
    }

    pub(super) fn end(self, stop_reason: StopReason) -> Search<'a, 'c> {
        Search { fit: self.fit, best: self.best, path: self.attempts, stop_reason }
    }
}
