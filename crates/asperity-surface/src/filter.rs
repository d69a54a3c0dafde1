//! Filters: outliers become missing points, Gaussian filters take out small or large scales.

mod gaussian;
mod outliers;
mod waves;

use thiserror::Error;

use asperity_base::map::MapError;
use asperity_base::sentence;

pub use gaussian::{GaussianFilter, Regression, Smoothed};
pub use outliers::{Filtered, reject_outliers};
pub use waves::{Edges, Respaced};

/// √(ln 2/π): with it the filter transmits half the amplitude of a wave of the cutoff's length.
pub(crate) const ALPHA: f64 = 0.469_718_639_349_825_5;

fn metre(length_m: f64) -> String {
    sentence::si(length_m, "m")
}

/// Reason why a map could not be filtered.
#[derive(Debug, Clone, PartialEq, Error)]
#[non_exhaustive]
pub enum FilterError {
    /// The threshold is not positive and finite.
    #[error("the outlier threshold is {found} standard deviations, but must be positive and finite")]
    Threshold {
        /// Threshold found.
        found: f64,
    },
    /// The cutoff is shorter than a pixel or longer than the field.
    #[error("the cutoff is {}, but must lie between the pixel, {}, and the field, {}", metre(*found_m), metre(*low_m), metre(*high_m))]
    Cutoff {
        /// Cutoff found in metre.
        found_m: f64,
        /// Least one, the longer pitch, in metre.
        low_m: f64,
        /// Largest one, the shorter side, in metre.
        high_m: f64,
    },
    /// The robust weights did not converge.
    #[error("the robust filter did not converge in {iterations} iterations")]
    NotConverged {
        /// Iterations done.
        iterations: usize,
    },
    /// The filter would remove all heights.
    #[error(transparent)]
    Map(#[from] MapError),
}
