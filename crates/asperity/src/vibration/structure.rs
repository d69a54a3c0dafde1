//! x
pub(super) mod grazing;
mod hopf;
mod parameter;
mod planar;
mod slip_cycle;
pub(super) mod tangent;
pub use hopf::{Criticality, HopfPoint, hopf_point};
pub use parameter::Parameter;
pub use slip_cycle::{SlipCycle, slip_cycles};
