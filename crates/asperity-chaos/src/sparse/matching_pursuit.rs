//! Orthogonal matching pursuit.

use super::growing_fit::GrowingFit;

/// Squared remaining fraction of a standardised column that counts as rounding.
const SPANNED: f64 = 1e-13;

/// Adds the column most correlated with the residual, one after the other, up to `limit` terms, a residual at the level of rounding,
/// or until the terms span all columns.
///
/// A new direction q removes q qᵀy from the residual, so the correlations follow from the products with q.
pub(super) fn pursue<'a, 'c>(mut fit: GrowingFit<'a, 'c>, limit: usize) -> GrowingFit<'a, 'c> {
    let candidates = fit.candidates();
    let columns = candidates.columns();
    let (mut correlations, mut products) = (vec![0.0; columns], vec![0.0; columns]);
    candidates.correlate(fit.residual(), &mut correlations);
    // Squared length of the part of each standardised column outside the span of the terms; negative for columns that may not enter.
    let mut beside: Vec<f64> = (0..columns).map(|j| if candidates.norm(j) > 0.0 { 1.0 } else { -1.0 }).collect();
    while fit.terms().len() < limit
        && let Some(column) = largest(&correlations, &beside)
    {
        beside[column] = -1.0;
        if !fit.enter(column) {
            continue;
        }
        candidates.correlate(fit.last_direction(), &mut products);
        let along = fit.projections().last().copied().unwrap_or(0.0);
        for ((beside, correlation), product) in beside.iter_mut().zip(&mut correlations).zip(&products) {
            *correlation -= along * product;
            *beside -= product * product;
            if *beside < SPANNED {
                *beside = -1.0;
            }
        }
        if fit.is_exact() {
            break;
        }
    }
    fit
}

/// Returns the column that may enter with the largest absolute correlation, the first of equal ones.
fn largest(correlations: &[f64], beside: &[f64]) -> Option<usize> {
    let mut best: Option<usize> = None;
    for column in (0..correlations.len()).filter(|column| beside[*column] > 0.0) {
        if best.is_none_or(|best| correlations[column].abs() > correlations[best].abs()) {
            best = Some(column);
        }
    }
    best
}
