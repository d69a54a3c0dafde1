//! Common parts of the Gaussian generators.

use ndarray::Array2;
use thiserror::Error;

use super::RandomSurface;
use asperity_base::map::{Grid, HeightMap, MapError};

/// Reason why a generator of random surfaces could not be created.
#[derive(Debug, PartialEq, Error)]
#[non_exhaustive]
pub enum GeneratorError {
    /// A parameter lies outside its range.
    #[error("{parameter} is {value}, but must be {wanted}")]
    Parameter {
        /// Name of the parameter.
        parameter: &'static str,
        /// Value found.
        value: f64,
        /// Values allowed.
        wanted: &'static str,
    },
    /// The requested number of modes exceeds the number of points.
    #[error("{wanted} modes were requested, but {points} points allow 1 to {points}")]
    Modes {
        /// Number of requested modes.
        wanted: usize,
        /// Number of points of the grid.
        points: usize,
    },
    /// A size and a number of points are needed for each of one or two directions.
    #[error("found {sizes} sizes and {points} numbers of points, but one or two of each are needed, equally many")]
    Dimensions {
        /// Number of sizes found.
        sizes: usize,
        /// Number of numbers of points found.
        points: usize,
    },
    /// The iterative eigensolver did not reach its tolerance.
    #[error(
        "{converged} of {wanted} modes converged in a subspace of {subspace} vectors: residual {residual:.1e}, wanted \
         {tolerance:.1e} of the first eigenvalue"
    )]
    NotConverged {
        /// Number of requested modes.
        wanted: usize,
        /// Number of modes below the tolerance.
        converged: usize,
        /// Number of vectors in the subspace.
        subspace: usize,
        /// Largest residual relative to the first eigenvalue.
        residual: f64,
        /// Requested residual.
        tolerance: f64,
    },
    /// The dense eigensolver failed, which happens for values that are not finite.
    #[error("the eigenproblem of {points} points could not be solved: the covariance is not finite or not symmetric")]
    Eigen {
        /// Size of the matrix.
        points: usize,
    },
    /// The field hardly varies at a point, so it cannot have a marginal distribution there.
    #[error("the Gaussian field keeps {fraction:.1e} of its variance at row {row}, column {column}; use more modes")]
    NoVariance {
        /// Row of the point.
        row: usize,
        /// Column of the point.
        column: usize,
        /// Pointwise variance over the largest one.
        fraction: f64,
    },
    /// The grid is not valid.
    #[error(transparent)]
    Grid(#[from] MapError),
}

/// A random surface whose heights are jointly Gaussian with mean zero: linear in ξ.
pub trait GaussianSurface: RandomSurface {
    /// Returns the standard deviation at each point in metre, shape `[ny, nx]`.
    fn pointwise_std_m(&self) -> Array2<f64>;

    /// Returns the covariance of the heights with the height at (`row`, `column`), in m², shape `[ny, nx]`.
    fn covariance_with_m2(&self, row: usize, column: usize) -> Array2<f64>;
}

impl<S: RandomSurface + ?Sized> RandomSurface for Box<S> {
    fn xi_len(&self) -> usize {
        (**self).xi_len()
    }

    fn grid(&self) -> Grid {
        (**self).grid()
    }

    fn generate(&self, xi: &[f64]) -> HeightMap {
        (**self).generate(xi)
    }

    fn generate_from(&self, xi: Vec<f64>) -> HeightMap {
        (**self).generate_from(xi)
    }

    fn xi_response(&self, weights: &Array2<f64>) -> Option<Vec<f64>> {
        (**self).xi_response(weights)
    }
}

impl<S: GaussianSurface + ?Sized> GaussianSurface for Box<S> {
    fn pointwise_std_m(&self) -> Array2<f64> {
        (**self).pointwise_std_m()
    }

    fn covariance_with_m2(&self, row: usize, column: usize) -> Array2<f64> {
        (**self).covariance_with_m2(row, column)
    }
}

/// Checks the length of ξ and that its values are finite.
pub(super) fn check_xi(xi: &[f64], len: usize) {
    assert_eq!(xi.len(), len, "ξ has the wrong length");
    assert!(xi.iter().all(|xi| xi.is_finite()), "ξ has a value that is not finite");
}

/// Checks the shape of weights and returns them in row order.
pub(super) fn row_order(weights: &Array2<f64>, grid: Grid) -> Vec<f64> {
    assert_eq!(weights.dim(), grid.shape(), "the weights have the wrong shape");
    weights.iter().copied().collect()
}

/// Creates a map of finite heights in row order.
pub(super) fn map_of(grid: Grid, heights_m: Vec<f64>) -> HeightMap {
    let map = Array2::from_shape_vec(grid.shape(), heights_m).map(|heights| HeightMap::new(grid, heights));
    match map {
        Ok(Ok(map)) => map,
        _ => unreachable!("a generator fills its grid with finite heights"),
    }
}
