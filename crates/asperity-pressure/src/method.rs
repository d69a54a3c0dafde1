//! Estimation methods and their errors.

use thiserror::Error;

use asperity_chaos::{BasisError, DiscreteDistributionError, RegressionError, SamplingError};

/// Reason why a method has no estimate.
#[derive(Debug, Clone, PartialEq, Error)]
#[non_exhaustive]
pub enum MethodError {
    /// The expansion could not be fitted to the samples in contact.
    #[error("no expansion: {0}")]
    Regression(#[from] RegressionError),
    /// The basis could not be made.
    #[error("no expansion: {0}")]
    Basis(#[from] BasisError),
    /// The design could not be created.
    #[error(transparent)]
    Sampling(#[from] SamplingError),
    /// A distribution could not be created from its values.
    #[error(transparent)]
    Distribution(#[from] DiscreteDistributionError),
    /// The expansion of the logarithm exceeds the largest floating-point number.
    #[error("the expansion overflows on {overflowed} of {evaluations} fresh samples")]
    Overflow {
        /// Number of samples on which the expansion overflows.
        overflowed: usize,
        /// Number of samples evaluated.
        evaluations: usize,
    },
    /// No rotated variable predicts the pressure of the cell.
    #[error("no normal variable predicts the pressure of the cell")]
    NoVariables,
    /// There are too few samples.
    #[error("{samples} samples are too few; at least {wanted} are needed")]
    TooFewSamples {
        /// Number of samples.
        samples: usize,
        /// Number of samples required.
        wanted: usize,
    },
}
