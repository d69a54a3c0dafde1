//! State of the surface after unloading.

use asperity::contact::Solution;
use asperity::stats::{Extent, Moments};
use ndarray::Array2;

use crate::output::Answer;

/// Surface after unloading.
pub(super) struct Unloaded {
    pub(super) residual_height_m: Array2<f64>,
    max_plastic_displacement_m: f64,
}

impl Unloaded {
    /// Returns the unloaded surface; `None` if `solution` has not converged, so that its plastic displacement is
    /// undefined.
    pub(super) fn new(solution: &Solution, heights_m: &Array2<f64>) -> Option<Self> {
        solution.converged().then(|| Self {
            residual_height_m: solution.residual_heights_m(heights_m),
            max_plastic_displacement_m: largest(&solution.plastic_displacement_m()),
        })
    }

    /// Adds the keys of unloading to `answer`, null if undefined.
    pub(super) fn add_to(this: Option<&Self>, answer: Answer) -> Answer {
        let rms_m = this.map(|left| Moments::new(&values(&left.residual_height_m)).std);
        let span_m = this.map(|left| span(&left.residual_height_m));
        answer
            .with("max_plastic_displacement_m", this.map(|left| left.max_plastic_displacement_m))
            .with("residual_rms_height_m", rms_m)
            .with("residual_peak_to_valley_m", span_m)
    }
}

fn values(map: &Array2<f64>) -> Vec<f64> {
    map.iter().copied().collect()
}

fn largest(map: &Array2<f64>) -> f64 {
    Extent::new(&values(map)).largest
}

/// Returns the highest minus the lowest value.
pub(super) fn span(map: &Array2<f64>) -> f64 {
    let extent = Extent::new(&values(map));
    extent.largest - extent.least
}
