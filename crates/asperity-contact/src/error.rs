//! Errors of contact problems.

use thiserror::Error;

use asperity_base::map::Grid;

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

/// Checks that a quantity is positive and between 1/`most` and `most`. These limits are wide, but products of
/// quantities within them, up to the energy, neither overflow nor underflow.
pub(super) fn positive(parameter: &'static str, value: f64, unit: &'static str, most: f64) -> Result<(), ContactError> {
    let wanted = match most {
        _ if value.is_nan() || value <= 0.0 => "positive",
        1e30 => "between 1e-30 and 1e30",
        1e50 => "between 1e-50 and 1e50",
        _ => "between 1e-100 and 1e100",
    };
    let error = ContactError::Parameter { parameter, value, unit, wanted };
    if (1.0 / most..=most).contains(&value) { Ok(()) } else { Err(error) }
}
