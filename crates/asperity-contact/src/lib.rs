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

use asperity_base::map::BoundaryKind;

mod area;
mod bodies;
mod clusters;
mod coarse_start;
mod conditions;
mod cycle;
mod descent;
mod elastic;
mod energy;
mod error;
pub mod exact;
mod gradient;
mod half_space;
mod load_start;
mod mean_gap;
mod numbers;
mod problem;
mod projection;
mod pyramid;
mod slab;
mod slabs;
mod solution;
mod solver;
mod stiffness;
mod substrate;

pub use bodies::{Body, ElasticPair, Orientation, composite};
pub use clusters::{Clusters, Neighbours};
pub use conditions::{Boundary, Control};
pub use cycle::{LoadPath, LoadStep};
pub use elastic::{Elastic, contact_modulus_pa};
pub use error::ContactError;
pub use gradient::{rms_gradient, spectral_rms_gradient};
pub use half_space::{ContactWorkspace, HalfSpace, love_coefficient};
pub use numbers::ContactNumbers;
pub use problem::ContactProblem;
pub use solution::{Residual, Solution, SolverStop};
pub use solver::Solver;
pub use stiffness::{ContactStiffness, Motion, StiffnessSolver};
pub use substrate::{Base, Layer, Substrate};

/// Returns the memory in byte, about, that a contact problem with this number of cells needs with its workspace and
/// solution.
pub fn memory_bytes(cells: usize, boundary: BoundaryKind) -> f64 {
    let bytes_per_cell = match boundary {
        BoundaryKind::Periodic => 70.0,
        // Transforms are padded.
        BoundaryKind::Free => 95.0,
    };
    bytes_per_cell * cells as f64
}

#[cfg(doctest)]
#[doc = include_str!("../README.md")]
struct Readme;
