//! Distribution of the random contact pressure (paper §3).
//!
//! A random surface is pressed against a rigid plane. The pressure p at one cell is a random variable with a point mass
//! at zero, P(p = 0) = 1 − P(contact), and a continuous part. [`Problem`] defines the pressure, [`solve`] evaluates it
//! on a design of samples ξ, and [`MethodComparison`] estimates its distribution by several [`PressureMethod`]s with the same
//! number of contact solutions and compares each with an independent Monte Carlo reference.

mod band;
mod coarse;
mod comparison;
mod directions;
mod estimate;
mod expansion;
mod failure;
mod field;
mod field_samples;
mod homogeneity;
mod likeness;
mod method;
mod multilevel;
mod nested;
mod predictor;
mod problem;
mod rotated_variables;
mod sample;
mod sensitivity;
mod stiffness;
#[doc(hidden)]
pub mod surrogate;
#[cfg(test)]
mod testing;

pub use asperity_results::PressureMethod;
pub use band::{Band, QuantileResult};
#[doc(hidden)]
pub use comparison::Solutions;
pub use comparison::{
    ComparisonResults, MethodComparison, MethodResult, Reference, ScalarResult, pooled_pressures, stratified_designs,
};
pub use estimate::{PressureEstimate, ReferenceDistances};
pub use failure::FailureReason;
pub use field::{FieldDistributions, GlobalExpansion, QuantileMap};
pub use homogeneity::Homogeneity;
pub use likeness::ContactLikeness;
pub use method::MethodError;
#[doc(hidden)]
pub use nested::NestedSamples;
pub use nested::{CoarseSolves, Quantity};
pub use problem::{CellObservation, Problem};
pub use sample::{Failure, Samples, Sampling, solve};
pub use sensitivity::{Sensitivity, SensitivityError, SensitivityIndices, VariableSet};

use thiserror::Error;

use asperity_base::map::Grid;
use asperity_base::monitor::Cancelled;
use asperity_chaos::{BasisError, DiscreteDistributionError, SamplingError};

/// Reason why a distribution of the pressure could not be computed.
#[derive(Debug, Error)]
#[non_exhaustive]
pub enum PressureError {
    /// The surface and the half-space have different grids.
    #[error("the surface lives on {surface:?}, the half-space on {half_space:?}")]
    Grid {
        /// Grid of the surface.
        surface: Grid,
        /// Grid of the half-space.
        half_space: Grid,
    },
    /// The cell lies outside the grid.
    #[error("cell (row {row}, column {column}) lies outside the {ny} × {nx} grid")]
    Cell {
        /// Row of the cell.
        row: usize,
        /// Column of the cell.
        column: usize,
        /// Rows of the grid.
        ny: usize,
        /// Columns of the grid.
        nx: usize,
    },
    /// A setting lies outside its range.
    #[error("{parameter} is {value}, but must be {wanted}")]
    Parameter {
        /// Name of the setting.
        parameter: &'static str,
        /// Value found.
        value: f64,
        /// Values allowed.
        wanted: &'static str,
    },
    /// Too many contact problems have no converged solution.
    #[error(
        "{stage}: only {valid} of {samples} contact problems were solved, {wanted_percent} % are wanted \
         (`valid_share`); the first failure, sample {first_index}: {first_reason}"
    )]
    TooFewValid {
        /// Name of the sampled run.
        stage: String,
        /// Number of converged samples.
        valid: usize,
        /// Total number of samples.
        samples: usize,
        /// Required fraction in percent.
        wanted_percent: f64,
        /// Index of the first failed sample.
        first_index: usize,
        /// Reason of the first failure.
        first_reason: String,
    },
    /// The design could not be created.
    #[error(transparent)]
    Sampling(#[from] SamplingError),
    /// The basis could not be created.
    #[error(transparent)]
    Basis(#[from] BasisError),
    /// A distribution could not be created from its values.
    #[error(transparent)]
    Distribution(#[from] DiscreteDistributionError),
    /// A method has no estimate.
    #[error(transparent)]
    Method(#[from] MethodError),
    /// The monitor stopped the run.
    #[error(transparent)]
    Cancelled(#[from] Cancelled),
}

#[cfg(doctest)]
#[doc = include_str!("../README.md")]
struct Readme;
