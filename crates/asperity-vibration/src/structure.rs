//! Deterministic structure: what the motion without fluctuation can end in, and where that changes.
//!
//! - [`slip_cycles`]: cycles that stay slower than the belt, such as the unstable one between ζ_H and ζ_c.
//! - [`forced_cycles`]: cycles with stick under a harmonic force, stable and unstable, with their multipliers.
//! - [`critical_curve`], [`locked_curve`]: the end of the cycle over another parameter.
//! - [`basin`], [`separatrix`], [`smallest_kick`]: which starts end in steady sliding.
//! - [`bifurcation_diagram`]: what a parameter that rises and falls leads through.

mod basin;
mod bifurcation;
mod boundary;
mod forced;
pub(super) mod grazing;
mod locked_curve;
mod parameter;
mod passage;
mod planar;
pub(super) mod slip_cycle;
pub(super) mod tangent;

pub use basin::{Basin, BasinBox, Separatrix, SeparatrixKind, basin, separatrix, smallest_kick};
pub use bifurcation::{
    BifurcationDiagram, BifurcationPoint, BifurcationSettings, Mark, MarkKind, Turnover, bifurcation_diagram,
};
pub use boundary::{Branch, BranchEnd, BranchPoint, CurveSettings, critical_curve};
pub use forced::{ForcedCycle, forced_cycles};
pub use locked_curve::locked_curve;
pub use parameter::Parameter;
pub use slip_cycle::{SlipCycle, slip_cycles};
