//! Units of the columns of records.

use asperity_base::quantity::{Force, Length, Time};

/// Returns whether a text is a unit supported by this module.
pub(super) fn is_unit(text: &str) -> bool {
    is_none(text) || [time_factor(text), length_factor(text), force_factor(text)].iter().any(Option::is_some)
}

/// Returns whether a text is the unit of a coefficient.
pub(super) fn is_none(unit: &str) -> bool {
    matches!(unit, "" | "1" | "-" | "–" | "—" | "[-]")
}

/// Returns the size of a unit of a time, in second; `None` for other units.
pub(super) fn time_factor(unit: &str) -> Option<f64> {
    let unit = if unit == "sec" { "s" } else { unit };
    format!("1 {unit}").parse::<Time>().ok().map(|time| time.0)
}

/// Returns the size of a unit of a length, in metre; `None` for other units.
pub(super) fn length_factor(unit: &str) -> Option<f64> {
    format!("1 {unit}").parse::<Length>().ok().map(|length| length.0)
}

/// Returns the size of a unit of a force, in newton; `None` for other units.
pub(super) fn force_factor(unit: &str) -> Option<f64> {
    format!("1 {unit}").parse::<Force>().ok().map(|force| force.0)
}
