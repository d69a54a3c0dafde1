//! Cells of tables: numbers with unit and interval, or a dash.

use asperity_results::Pair;

use crate::format::{Dimension, significant};

/// Text of an undefined value.
pub(crate) const DASH: &str = "–";

/// Formats a number with its unit and its interval, or a dash.
pub(crate) fn shown(dimension: Dimension, value: impl Into<Option<f64>>, interval: Option<Pair>) -> String {
    value.into().map_or_else(|| DASH.into(), |value| dimension.show_interval(value, interval.map(Into::into)))
}

/// Formats a number without unit, or a dash.
pub(crate) fn plain(value: impl Into<Option<f64>>, digits: usize) -> String {
    value.into().map_or_else(|| DASH.into(), |value| significant(value, digits))
}

/// Formats a fraction as a percentage, or a dash.
pub(crate) fn percent(fraction: impl Into<Option<f64>>, digits: usize) -> String {
    fraction.into().map_or_else(|| DASH.into(), |fraction| format!("{} %", significant(100.0 * fraction, digits)))
}
