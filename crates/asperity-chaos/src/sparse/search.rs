//! Result of a search for terms.

use super::error::SparseError;
use super::fit::{Attempt, SparseFit, StopReason};
use super::growing_fit::GrowingFit;
use crate::LeaveOneOut;

/// Number of attempts that an error reports.
const REPORTED: usize = 5;

/// Result of a search: the fit of the largest or best model, and all attempts.
pub(super) struct Search<'a, 'c> {
    pub(super) fit: GrowingFit<'a, 'c>,
    /// Number of leading terms of `fit` that form the best model.
    pub(super) best: usize,
    pub(super) path: Vec<Attempt>,
    pub(super) stop_reason: StopReason,
}

impl Search<'_, '_> {
    /// Returns the best model, or an error if the mean is better.
    pub(super) fn finish(self, response: &[f64], of_the_mean: f64) -> Result<SparseFit, SparseError> {
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
