//! Errors of sparse regression.

use thiserror::Error;

use super::fit::Attempt;

/// Reason why there is no sparse model.
#[derive(Debug, Clone, PartialEq, Error)]
#[non_exhaustive]
pub enum SparseError {
    /// There are too few samples to leave one out.
    #[error("{samples} samples; at least three are needed")]
    TooFewSamples {
        /// Number of samples.
        samples: usize,
    },
    /// A value of the design matrix or of the response is not finite.
    #[error("sample {sample} is not a finite number")]
    NotFinite {
        /// Index of the first such sample.
        sample: usize,
    },
    /// The response and the design differ in length.
    #[error("{values} response values for {samples} samples")]
    Length {
        /// Values given.
        values: usize,
        /// Samples of the design.
        samples: usize,
    },
    /// The response is constant up to rounding.
    #[error("the response is {value} in all samples: there is nothing to explain")]
    ConstantResponse {
        /// Mean of the response.
        value: f64,
    },
    /// No column of the design varies.
    #[error("no candidate varies over the samples ({columns} candidates)")]
    NoCandidates {
        /// Columns of the design.
        columns: usize,
    },
    /// No model predicts better than the mean of the response.
    #[error(
        "no model predicts the response better than its mean ({tried} tried): error {:.4} at best, {of_the_mean:.4} of the mean",
        attempts.first().map_or(f64::INFINITY, |attempt| attempt.error)
    )]
    NothingPredicts {
        /// Numbers of terms that were tried.
        tried: usize,
        /// Cross-validation error of the mean.
        of_the_mean: f64,
        /// The best attempts, in order of increasing error.
        attempts: Vec<Attempt>,
    },
}
