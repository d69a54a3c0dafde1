//! What is left after unloading.

use asperity::contact::Solution;
use asperity::stats::{Extent, Moments};
use ndarray::Array2;

use crate::output::Answer;

/// A surface without load after the one of a solution.
pub(super) struct Unloaded {
    pub(super) residual_height_m: Array2<f64>,
    max_plastic_displacement_m: f64,
}

impl Unloaded {
    /// What `solution` left of `heights_m`; `None` if it is not converged, so that its plastic displacement is none.
    pub(super) fn after(solution: &Solution, heights_m: &Array2<f64>) -> Option<Self> {
        solution.converged().then(|| Self {
            residual_height_m: solution.residual_heights_m(heights_m),
            max_plastic_displacement_m: largest(&solution.plastic_displacement_m()),
        })
    }

    /// Adds the keys of unloading to `answer`, null where nothing is known.
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

/// Highest less lowest value.
pub(super) fn span(map: &Array2<f64>) -> f64 {
    let extent = Extent::new(&values(map));
    extent.largest - extent.least
}
