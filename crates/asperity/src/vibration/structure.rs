//! x
pub(super) mod grazing;
pub(super) mod tangent;
