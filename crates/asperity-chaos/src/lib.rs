//! Designs of experiments, orthonormal polynomial expansions, least squares and distances of distributions.
//!
//! A random quantity is a function f(ξ) of independent standard variables ξ. [`sampling`] creates designs, [`Basis`]
//! (products in a [`MultiIndexSet`]) and [`LeastSquares`] fit an [`Expansion`] to the values at the design points, and
//! [`DiscreteDistribution`] compares the resulting distributions. [`Resamples`] estimates the errors of Sobol' indices;
//! [`propagation`] propagates uncertain parameters through a noisy response. [`inputs`] describes dependent uncertain
//! inputs, and [`drivers`] computes how much each of them matters. The crate contains no tribology.

mod basis;
pub mod distance;
pub mod drivers;
mod expansion;
mod horner;
pub mod inputs;
mod multi_index;
pub mod polynomial;
pub mod propagation;
pub mod rare;
mod regression;
mod resamples;
pub mod sampling;
mod sensitivity;
mod sparse;

pub use basis::{Basis, BasisError};
pub use distance::{DiscreteDistribution, DiscreteDistributionError};
pub use drivers::{DriverError, Drivers, NestedSampling, PickFreeze, ProbabilityOverUnknowns, UnknownEffect};
pub use expansion::Expansion;
pub use inputs::{InputError, Redraw, UncertainInput, UncertainInputs};
pub use multi_index::{Factor, MAX_TERMS, MultiIndexError, MultiIndexSet, Truncation, number_of_terms};
pub use polynomial::{OrthonormalPolynomials, PolynomialFamily};
pub use propagation::{
    NoIndices, Noise, Observed, Parameter, ParameterIndices, Propagated, Propagation, PropagationError,
};
pub use regression::{Fits, LeastSquares, LeastSquaresFit, LeaveOneOut, RegressionError};
pub use resamples::{Resamples, ResamplesError, SampleEstimate};
pub use sampling::{Design, SamplingError, SamplingMethod};
pub use sensitivity::{IndexError, IndexEstimates};
pub use sparse::{Attempt, Candidates, SparseError, SparseFit, SparseRegression};

#[cfg(doctest)]
#[doc = include_str!("../README.md")]
struct Readme;
