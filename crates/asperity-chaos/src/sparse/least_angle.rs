//! Least-angle regression.

use super::fit::StopReason;
use super::growing_fit::GrowingFit;
use super::path::Path;
use super::search::Search;

/// Adds terms in the order of least-angle regression.
///
/// All terms keep the same absolute correlation C with the residual of the least-angle fit while it moves along u. The
/// product of u with each standardised term is the sign s of its correlation. With A = QR and u = Qt this is Rᵀt =
/// (s_j‖x_j‖). A new term appends one entry to t and leaves the others unchanged, so the products with all columns
/// follow from the products with the last direction.
pub(super) fn search<'a, 'c>(start: GrowingFit<'a, 'c>, limit: usize, patience: usize) -> Search<'a, 'c> {
    let mut path = Path::new(start, limit, patience);
    let mut correlations = path.correlations();
    // The constant does not contribute to u.
    let mut t = vec![0.0; path.fit.terms().len()];
    let mut slopes = vec![0.0; correlations.len()];
    if t.len() >= limit {
        return path.end(StopReason::TermLimit);
    }
    let Some(first) = path.largest(&correlations) else { return path.end(StopReason::Exhausted) };
    let (mut next, mut level) = (Some(first), correlations[first].abs());
    while let Some(column) = next {
        if path.enter(column) {
            let sign = correlations[column].signum();
            let length = path.fit.candidates().norm(column);
            let triangle = path.fit.triangle_column(t.len());
            let known: f64 = triangle.iter().zip(&t).map(|(r, t)| r * t).sum();
            let entry = (sign * length - known) / triangle[t.len()];
            t.push(entry);
            slopes.iter_mut().zip(&path.products).for_each(|(slope, product)| *slope += entry * product);
            if let Some(reason) = path.note() {
                return path.end(reason);
            }
        }
        let mut distance = level;
        next = None;
        for column in path.open() {
            let reached = meets(level, correlations[column], slopes[column]);
            if reached < distance {
                (distance, next) = (reached, Some(column));
            }
        }
        level -= distance;
        correlations.iter_mut().zip(&slopes).for_each(|(c, slope)| *c -= distance * slope);
    }
    path.end(StopReason::Exhausted)
}

/// Returns the distance that the fit moves until a correlation c − γ·slope has the absolute value `level` − γ.
fn meets(level: f64, correlation: f64, slope: f64) -> f64 {
    let when = |gap: f64, closing: f64| if closing > 0.0 { gap.max(0.0) / closing } else { f64::INFINITY };
    when(level - correlation, 1.0 - slope).min(when(level + correlation, 1.0 + slope))
}
