//! Errors of uncertain inputs.

use thiserror::Error;

use asperity_base::distribution::DistributionError;

/// Reason why inputs cannot be uncertain as stated.
#[derive(Debug, Clone, PartialEq, Error)]
#[non_exhaustive]
pub enum InputError {
    /// The distribution of an input is invalid.
    #[error("`{name}`: {source}")]
    Distribution {
        /// Name of the input.
        name: String,
        /// Error of the distribution.
        source: DistributionError,
    },
    /// Too much of a distribution lies beyond the bounds of the input.
    #[error(
        "`{name}`: {:.3} % of its distribution lies outside [{low}, {high}]; choose a distribution \
         within these bounds, for instance lognormal or triangular",
        100.0 * .mass
    )]
    Mass {
        /// Name of the input.
        name: String,
        /// Probability outside the bounds.
        mass: f64,
        /// Lower bound.
        low: f64,
        /// Upper bound.
        high: f64,
    },
    /// The requested central value is impossible.
    #[error("`{name}`: the central value {central} does not lie between {low} and {high}")]
    Central {
        /// Name of the input.
        name: String,
        /// Requested central value.
        central: f64,
        /// Lower bound.
        low: f64,
        /// Upper bound.
        high: f64,
    },
    /// A correlation joins an input to itself.
    #[error("a correlation of `{name}` with itself; name two different inputs")]
    SameInput {
        /// Name of the input.
        name: String,
    },
    /// Two correlations are stated for one pair.
    #[error("the correlation of `{first}` and `{second}` is stated twice; keep one")]
    SamePair {
        /// Name of the first input.
        first: String,
        /// Name of the second input.
        second: String,
    },
    /// A rank correlation is not between −1 and 1.
    #[error("the correlation of `{first}` and `{second}` is {spearman}; it must lie between -1 and 1, both excluded")]
    Correlation {
        /// Name of the first input.
        first: String,
        /// Name of the second input.
        second: String,
        /// Stated correlation.
        spearman: f64,
    },
    /// A correlation joins a varying and an unknown input.
    #[error(
        "`{unknown}` is unknown and `{varying}` varies: one unknown value cannot correlate with values that differ from \
         part to part; let both vary, or neither"
    )]
    UnknownWithVarying {
        /// Name of the unknown input.
        unknown: String,
        /// Name of the varying input.
        varying: String,
    },
    /// No joint distribution has these correlations.
    #[error("the correlations contradict each other (their matrix is not positive definite); reduce them")]
    NotPositiveDefinite,
}
