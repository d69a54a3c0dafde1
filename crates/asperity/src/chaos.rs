//! Designs of experiments, orthonormal polynomial expansions, least squares and distances of laws. Knows no tribology.
//!
//! A random quantity is a function f(ξ) of a *germ*, a vector of independent standard variables. [`sampling`] says where
//! to evaluate it, [`Basis`] and [`LeastSquares`] turn the values into an [`Expansion`], and [`StepLaw`] compares the
//! laws that come out.

mod basis;
pub mod distance;
mod expansion;
mod multi_index;
pub mod polynomial;
mod regression;
pub mod sampling;

pub use basis::{Basis, BasisError};
pub use distance::{DistanceError, StepLaw};
pub use expansion::Expansion;
pub use multi_index::{MultiIndexError, MultiIndexSet, number_of_terms};
pub use polynomial::Family;
pub use regression::{Fit, LeastSquares, LeaveOneOut, RegressionError};
pub use sampling::{Design, SamplingError, SamplingMethod};
