//! Errors of small probabilities.

use thiserror::Error;

use asperity_base::monitor::Cancelled;

/// Reason why a small probability could not be estimated.
#[derive(Debug, Clone, PartialEq, Error)]
#[non_exhaustive]
pub enum RareError<E> {
    /// The limit state could not be evaluated.
    #[error(transparent)]
    Evaluation(E),
    /// The limit state is NaN.
    #[error("the limit state is not a number at {point:?}")]
    NotANumber {
        /// Standard normal variables of the point.
        point: Vec<f64>,
    },
    /// A setting is out of range.
    #[error("{name} is {value}; it must be {wanted}")]
    Setting {
        /// Name of the setting.
        name: &'static str,
        /// Value given.
        value: f64,
        /// Values that are possible.
        wanted: &'static str,
    },
    /// The monitor cancelled.
    #[error("cancelled")]
    Cancelled,
}

impl<E> From<Cancelled> for RareError<E> {
    fn from(_: Cancelled) -> Self {
        Self::Cancelled
    }
}
