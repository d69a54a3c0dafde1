//! Correlation: covariance models, and their estimates and fits.

mod model;

pub use model::{CorrelationModel, Covariance, CovarianceError};
