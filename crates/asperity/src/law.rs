//! One-dimensional laws: densities, quantiles, moments, fits, goodness of fit, and translation from the normal law.

pub mod fit;
pub mod goodness;
mod marginal;
mod moments;
mod special;
mod text;
pub mod translation;
mod translator;

pub use marginal::{LawError, Marginal};
pub use special::{standard_normal_cdf, standard_normal_pdf, standard_normal_quantile};
pub use translator::Translator;
