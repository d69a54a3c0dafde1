//! x
mod basin;
mod boundary;
mod forced;
mod locked_curve;
pub(super) mod grazing;
mod hopf;
mod parameter;
mod passage;
mod planar;
mod slip_cycle;
pub(super) mod tangent;
pub use basin::{Attractor, Basin, BasinBox, Separatrix, SeparatrixKind, basin, separatrix};
pub use boundary::{Branch, BranchEnd, BranchPoint, CurveSettings, critical_curve};
pub use locked_curve::locked_curve;
pub use forced::{ForcedCycle, forced_cycles};
pub use hopf::{Criticality, HopfPoint, hopf_point};
pub use parameter::Parameter;
pub use slip_cycle::{SlipCycle, slip_cycles};
