//! Frictionless contact of a rough elastic or elasto-plastic half-space with a rigid flat (paper §2.3, eq. 3–7).
//!
//! With heights z, a plane at height d and the compliance operator S (eq. 5 and 6), the pressure p minimises
//! V*(p) = ½ pᵀSp − pᵀ(z − d) subject to 0 ≤ p ≤ H (eq. 7); H is the hardness, infinite in the elastic case. With the
//! gap g = Sp − z + d the solution satisfies
//!
//! - p = 0 and g ≥ 0 (no contact),
//! - 0 < p < H and g = 0 (elastic contact),
//! - p = H and g ≤ 0 (plastic contact; −g is the plastic displacement).
//!
//! S is positive definite, so the solution is unique.

use thiserror::Error;

use asperity_base::map::{BoundaryKind, Grid};

pub mod area;
mod bodies;
mod clusters;
mod coarse_start;
mod cycle;
mod descent;
mod energy;
pub mod exact;
mod gradient;
mod half_space;
mod load_start;
mod mean_gap;
mod problem;
mod projection;
mod pyramid;
mod slab;
mod solution;
mod solver;
mod stiffness;
mod substrate;

pub use bodies::{Body, Elastic, ElasticPair, Orientation, composite};
pub use clusters::{Clusters, Neighbours};
pub use cycle::{LoadPath, LoadStep, work_of_flat_j};
pub use gradient::{rms_gradient, spectral_rms_gradient};
pub use half_space::{Boundary, ContactWorkspace, HalfSpace, love_coefficient};
pub use problem::{ContactProblem, Control};
pub use solution::{Residual, Solution, SolverStop};
pub use solver::Solver;
pub use stiffness::{ContactStiffness, Motion, StiffnessSolver};
pub use substrate::{Base, Layer, Substrate};

/// Returns the contact modulus E* = E/(1−ν²) in pascal of an elastic body pressed against a rigid one, from Young's
/// modulus E in pascal and Poisson's ratio ν.
pub fn contact_modulus_pa(youngs_modulus_pa: f64, poisson_ratio: f64) -> f64 {
    youngs_modulus_pa / (1.0 - poisson_ratio * poisson_ratio)
}

/// Returns the memory in byte, about, that a contact problem with this number of cells needs with its workspace and
/// solution.
pub fn memory_bytes(cells: usize, boundary: BoundaryKind) -> f64 {
    let bytes_per_cell = match boundary {
        BoundaryKind::Periodic => 90.0,
        // Transforms are padded.
        BoundaryKind::Free => 160.0,
    };
    bytes_per_cell * cells as f64
}

/// Reason why a contact problem could not be posed or solved.
#[derive(Debug, Clone, PartialEq, Error)]
#[non_exhaustive]
pub enum ContactError {
    /// A parameter lies outside its range.
    #[error("{parameter} is {value:e} {unit}, but must be {wanted}")]
    Parameter {
        /// Name of the parameter.
        parameter: &'static str,
        /// Value found.
        value: f64,
        /// Unit of the value.
        unit: &'static str,
        /// Values allowed.
        wanted: &'static str,
    },
    /// The map is flat, so the gap has no length scale.
    #[error("the map has no roughness (all heights are equal); contact of two flats is not a rough contact")]
    Flat,
    /// A height is missing.
    #[error(
        "{missing} of {points} heights are missing; contact needs a complete map (`asperity surface fill` fills one)"
    )]
    Missing {
        /// Missing points.
        missing: usize,
        /// Number of points.
        points: usize,
    },
    /// The map does not fit the half-space.
    #[error("the map has {rows} × {columns} heights, the half-space {ny} × {nx} cells")]
    Shape {
        /// Rows of the map.
        rows: usize,
        /// Columns of the map.
        columns: usize,
        /// Rows of the half-space.
        ny: usize,
        /// Columns of the half-space.
        nx: usize,
    },
    /// Two maps do not lie on the same grid.
    #[error(
        "the lower map has {} × {} points at {:e} m × {:e} m, the upper {} × {} at {:e} m × {:e} m; both must be equal",
        lower.nx(), lower.ny(), lower.dx_m(), lower.dy_m(), upper.nx(), upper.ny(), upper.dx_m(), upper.dy_m()
    )]
    Grids {
        /// Grid of the lower map.
        lower: Box<Grid>,
        /// Grid of the upper map.
        upper: Box<Grid>,
    },
    /// A periodic half-space with zero mean compliance overlaps the prescribed plane.
    #[error(
        "a periodic half-space with zero mean compliance has no solution under an overlapping plane; \
         state a mean compliance, or control the mean pressure, the load or the mean gap"
    )]
    Unbounded,
    /// The mean pressure is not below the hardness.
    #[error("the mean pressure {mean_pressure_pa:e} Pa is not below the hardness {hardness_pa:e} Pa")]
    Overloaded {
        /// Mean pressure asked for.
        mean_pressure_pa: f64,
        /// Hardness.
        hardness_pa: f64,
    },
}

#[cfg(doctest)]
#[doc = include_str!("../README.md")]
struct Readme;
