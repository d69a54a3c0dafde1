//! How a distribution can be estimated, and why it cannot.

use thiserror::Error;

use asperity_chaos::{BasisError, DiscreteDistributionError, RegressionError, SamplingError};

/// How the distribution of the pressure is estimated.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Method {
    /// The empirical distribution of independent samples.
    MonteCarlo,
    /// The mean of the empirical distributions of ten Latin hypercubes.
    LatinHypercube,
    /// The mean of the empirical distributions of ten randomisations of Sobol' points.
    Sobol,
    /// Eq. (8): a chaos expansion of the pressure in contact in the leading normal variables, on the Latin hypercubes.
    PolynomialChaos,
    /// Eq. (9): the same of the logarithm of the pressure in contact.
    PolynomialChaosLog,
    /// Eq. (8) on the Monte Carlo samples, in the variables of the ξ rotated to the cell.
    PolynomialChaosLocal,
    /// Multilevel estimator: the Monte Carlo samples, coarse grids that predict them, and normal variables rotated to the cell
    /// that predict the coarse results.
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

/// Why a method has no estimate.
#[derive(Debug, Clone, PartialEq, Error)]
pub enum MethodError {
    /// The expansion could not be fitted to the samples in contact.
    #[error("no expansion: {0}")]
    Regression(#[from] RegressionError),
    /// The basis could not be made.
    #[error("no expansion: {0}")]
    Basis(#[from] BasisError),
    /// The design does not exist.
    #[error(transparent)]
    Sampling(#[from] SamplingError),
    /// A distribution could not be made from its values.
    #[error(transparent)]
    Law(#[from] DiscreteDistributionError),
    /// The expansion of the logarithm exceeds the largest floating-point number.
    #[error("the expansion overflows on {overflowed} of {evaluations} fresh samples")]
    Overflow {
        /// Samples of ξ on which it overflows.
        overflowed: usize,
        /// Samples of ξ evaluated.
        evaluations: usize,
    },
    /// No variable of the ξ predicts the pressure of the cell.
    #[error("no normal variable predicts the pressure of the cell")]
    NoVariables,
    /// There are too few samples.
    #[error("{samples} samples are too few; at least {wanted} are needed")]
    TooFewSamples {
        /// Samples there are.
        samples: usize,
        /// Samples needed.
        wanted: usize,
    },
}
