//! Orthogonal matching pursuit.

use super::fit::StopReason;
use super::growing_fit::GrowingFit;
use super::path::Path;
use super::search::Search;

/// Adds the column most correlated with the residual, one after the other.
///
/// A new direction q removes q qᵀy from the residual, so the correlations follow from the products with q.
pub(super) fn search<'a, 'c>(start: GrowingFit<'a, 'c>, limit: usize, patience: usize) -> Search<'a, 'c> {
    let mut path = Path::new(start, limit, patience);
    let mut correlations = path.correlations();
    if path.fit.terms().len() >= limit {
        return path.end(StopReason::TermLimit);
    }
    while let Some(column) = path.largest(&correlations) {
        if !path.enter(column) {
            continue;
        }
        let along = path.fit.projections().last().copied().unwrap_or(0.0);
        correlations.iter_mut().zip(&path.products).for_each(|(c, product)| *c -= along * product);
        if let Some(reason) = path.note() {
            return path.end(reason);
        }
    }
    path.end(StopReason::Exhausted)
}
