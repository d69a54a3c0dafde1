//! One-dimensional laws: densities, quantiles, fits.

mod marginal;

pub use marginal::{LawError, Marginal, standard_normal_cdf, standard_normal_quantile};
