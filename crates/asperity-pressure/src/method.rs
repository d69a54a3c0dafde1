//! Estimation methods and their errors.

use thiserror::Error;

use asperity_chaos::{BasisError, DiscreteDistributionError, RegressionError, SamplingError};

/// Method that estimates the distribution of the pressure.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Method {
    /// Empirical distribution of independent samples.
    MonteCarlo,
    /// Mean of the empirical distributions of ten Latin hypercubes.
    LatinHypercube,
    /// Mean of the empirical distributions of ten randomisations of Sobol' points.
    Sobol,
    /// Eq. (8): chaos expansion of the pressure in contact in the leading variables ξ, on the Latin hypercubes.
    PolynomialChaos,
    /// Eq. (9): chaos expansion of the logarithm of the pressure in contact, on the same samples.
    PolynomialChaosLog,
    /// Eq. (8) on the Monte Carlo samples, in variables ξ rotated to the cell.
    PolynomialChaosLocal,
    /// Multilevel estimator: Monte Carlo samples, coarse grids that predict them, and normal variables rotated to the
    /// cell that predict the coarse results.
    Default,
}

impl Method {
    /// All methods, in the order of reports.
    pub const ALL: [Self; 7] = [
        Self::MonteCarlo,
        Self::LatinHypercube,
        Self::Sobol,
        Self::PolynomialChaos,
        Self::PolynomialChaosLog,
        Self::PolynomialChaosLocal,
        Self::Default,
    ];

    /// Returns the name in result files.
    pub fn name(self) -> &'static str {
        match self {
            Self::MonteCarlo => "monte_carlo",
            Self::LatinHypercube => "latin_hypercube",
            Self::Sobol => "sobol",
            Self::PolynomialChaos => "polynomial_chaos",
            Self::PolynomialChaosLog => "polynomial_chaos_log",
            Self::PolynomialChaosLocal => "polynomial_chaos_local",
            Self::Default => "default",
        }
    }
}

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
