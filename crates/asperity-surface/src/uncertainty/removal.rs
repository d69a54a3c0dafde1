//! What a removed form took along.

use super::heights::HeightSums;
use super::window::Window;

/// The share of a surface's variance that went with the form of a map.
pub(super) struct Removal {
    /// The share.
    pub(super) share: f64,
    /// Its influences on the cells: a map in which long waves happen to be high makes it too large, and is itself too high.
    pub(super) influence: Vec<f64>,
}

impl Removal {
    /// A form of `terms` free coefficients takes as often the variance β of the map's mean, here of heights whose variance is
    /// 1 after the removal: terms·β/(1 + terms·β) of the variance before it.
    pub(super) fn of(window: &Window, sums: &HeightSums, terms: f64) -> Self {
        let (mean_variance, parts) = window.mean_variance(&sums.power[0], terms);
        if mean_variance <= 0.0 {
            return Self::none(parts.len());
        }
        let slope = terms / (1.0 + terms * mean_variance).powi(2);
        let squares = sums.sq_influence();
        let influence = parts
            .iter()
            .zip(&sums.share)
            .zip(squares)
            .map(|((part, share), square)| slope * (part - mean_variance * share - mean_variance * square));
        Self { share: terms * mean_variance / (1.0 + terms * mean_variance), influence: influence.collect() }
    }

    /// Nothing went.
    pub(super) fn none(cells: usize) -> Self {
        Self { share: 0.0, influence: vec![0.0; cells] }
    }
}
