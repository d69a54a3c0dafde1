//! Deterministic structure: attractors of the motion without fluctuation, and the parameters at which they change.
//!
//! - [`slip_cycles`]: cycles slower than the belt, such as the unstable cycle between ζ_H and ζ_c.
//! - [`forced_cycles`]: cycles with stick under a harmonic force, stable and unstable, with their multipliers.
//! - [`critical_curve`], [`locked_curve`]: end of the cycle as a function of another parameter.
//! - [`basin`], [`separatrix`], [`smallest_kick`]: starts that end in steady sliding, and their border.
//! - [`bifurcation_diagram`]: attractors over a rising and then falling parameter.

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
pub use parameter::CurveParameter;
pub use slip_cycle::{SlipCycle, slip_cycles};
