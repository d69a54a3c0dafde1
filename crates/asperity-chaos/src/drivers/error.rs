//! Errors of drivers.

use thiserror::Error;

use crate::SamplingError;

/// Largest number of inputs.
pub(super) const MAX_INPUTS: usize = 64;

/// Reason why drivers could not be estimated.
#[derive(Debug, Clone, PartialEq, Error)]
#[non_exhaustive]
pub enum DriverError {
    /// The design could not be created.
    #[error(transparent)]
    Design(#[from] SamplingError),
    /// There are too many inputs.
    #[error("{inputs} uncertain inputs; drivers are estimated for at most {MAX_INPUTS}")]
    TooManyInputs {
        /// Number of inputs.
        inputs: usize,
    },
    /// The response is not a finite number.
    #[error("the response is {value} at the standard normal variables {z:?}; it must be finite everywhere")]
    NotFinite {
        /// Value of the response.
        value: f64,
        /// Independent standard normal variables.
        z: Vec<f64>,
    },
    /// The response is the same at all points.
    #[error("the response does not depend on the inputs")]
    Constant,
}
