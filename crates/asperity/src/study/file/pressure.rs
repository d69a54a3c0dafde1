//! The sections `[material]` and `[pressure]`.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use crate::contact::Elastic;
use crate::map::BoundaryKind;
use crate::pressure::PressureMethod;
use crate::quantity::{Compliance, Length, Pressure};

/// The section `[material]`.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct MaterialSection {
    /// Young's modulus.
    pub youngs_modulus: Pressure,
    /// Poisson's ratio.
    #[serde(default = "poisson_ratio")]
    pub poisson_ratio: f64,
    /// Hardness, the largest pressure; contact is elastic when left out.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub hardness: Option<Pressure>,
    /// Shear strength τ_max of the contacts; required by friction.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub shear_strength: Option<Pressure>,
}

/// The section `[pressure]`.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct PressureSection {
    /// Size (x, y) of a patch.
    pub size: [Length; 2],
    /// Points (x, y) of a patch.
    pub points: [usize; 2],
    /// Boundary of a patch.
    #[serde(default = "free")]
    pub boundary: BoundaryKind,
    /// Cell [row, column] of the studied pressure, counted from 0 at the top left; the centre [ny/2, nx/2] when left
    /// out.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub cell: Option<[usize; 2]>,
    /// Mean compliance of a periodic patch.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub mean_compliance: Option<Compliance>,
    /// Percentage of the heights (of the ensemble) above the plane before deformation.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub percentile: Option<f64>,
    /// Depth of the plane below the highest point of each patch.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub penetration: Option<Length>,
    /// Mean pressure on each patch.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub mean_pressure: Option<Pressure>,
    /// Methods beside `default`, whose estimate is the answer. With others, a reference is computed and all are compared with it.
    #[serde(default = "methods")]
    pub methods: Vec<PressureMethod>,
    /// Number of contact solutions for each method.
    #[serde(default = "fine_solves")]
    pub fine_solves: usize,
    /// Number of contact solutions of the reference run, 5000 when left out; needs other methods than `default`.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub reference_samples: Option<usize>,
    /// Number of leading variables of the chaos expansion.
    #[serde(default = "variables")]
    pub variables: usize,
    /// Total degree of the chaos expansion.
    #[serde(default = "degree")]
    pub degree: usize,
    /// Whether to estimate the normal stiffness of the contact too.
    #[serde(default)]
    pub stiffness: bool,
    /// Relative tolerance of each contact solve.
    #[serde(default = "solve_tolerance")]
    pub tolerance: f64,
}

pub(super) fn solve_tolerance() -> f64 {
    1e-6
}
fn poisson_ratio() -> f64 {
    Elastic::POISSON_RATIO
}
fn free() -> BoundaryKind {
    BoundaryKind::Free
}
fn fine_solves() -> usize {
    500
}
fn methods() -> Vec<PressureMethod> {
    vec![PressureMethod::Default]
}
fn variables() -> usize {
    8
}
fn degree() -> usize {
    3
}
