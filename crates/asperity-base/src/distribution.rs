//! One-dimensional distributions: densities, quantiles, moments, fits, goodness of fit, and translation from the normal
//! distribution.

mod chi_square;
mod condensed;
mod empirical;
mod error;
pub mod fit;
pub mod goodness;
mod johnson;
mod marginal;
mod moments;
mod special;
mod text;
pub mod translation;
mod triangular;

#[doc(hidden)]
pub use chi_square::chi_square_quantile;
use condensed::condensed;
pub use error::DistributionError;
pub use johnson::{Johnson, JohnsonSystem};
pub use marginal::Marginal;
pub use special::{standard_normal_cdf, standard_normal_pdf, standard_normal_quantile};
