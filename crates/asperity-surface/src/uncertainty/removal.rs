//! Variance removed with a form.

use super::heights::HeightSums;
use super::window::Window;

/// Fraction of a surface's variance that was removed with the form of a map.
pub(super) struct Removal {
    /// The fraction.
    pub(super) fraction: f64,
    /// Influences on the cells. A map whose long waves happen to be high gives too large a fraction, and is itself too
    /// high.
    pub(super) influence: Vec<f64>,
}

impl Removal {
    /// Computes the fraction for a form of `terms` free coefficients. Each removes the variance β of the map's mean,
    /// for heights of variance 1 after the removal: in total terms·β/(1 + terms·β) of the variance before it.
    pub(super) fn of(window: &Window, sums: &HeightSums, terms: f64) -> Self {
        let (mean_variance, parts) = window.mean_variance(&sums.power[0], terms);
        if mean_variance <= 0.0 {
            return Self::none(parts.len());
        }
        let slope = terms / (1.0 + terms * mean_variance).powi(2);
        let squares = sums.sq_influence();
        let influence = parts
            .iter()
            .zip(&sums.fraction)
            .zip(squares)
            .map(|((part, fraction), square)| slope * (part - mean_variance * fraction - mean_variance * square));
        Self { fraction: terms * mean_variance / (1.0 + terms * mean_variance), influence: influence.collect() }
    }

    /// Returns a removal of zero.
    pub(super) fn none(cells: usize) -> Self {
        Self { fraction: 0.0, influence: vec![0.0; cells] }
    }
}
