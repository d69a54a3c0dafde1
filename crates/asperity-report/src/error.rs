//! Errors of the report.

use thiserror::Error;

/// Reason why a report cannot be rendered.
#[derive(Debug, Clone, PartialEq, Eq, Error)]
#[non_exhaustive]
pub enum ReportError {
    /// A map could not be encoded.
    #[error("a map could not be encoded as PNG: {message}")]
    Image {
        /// The encoder's message.
        message: String,
    },
}
