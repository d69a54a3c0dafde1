//! Values that are out of range.

use std::fmt::Display;

use thiserror::Error;

/// Error of a well-formed value that is invalid.
#[derive(Debug, Clone, PartialEq, Error)]
#[error("{}{key}: {message}", prefix(section))]
pub struct InvalidValue {
    /// Section of the value, such as `friction.uncertainty`; empty above the sections.
    pub section: &'static str,
    /// Key of the value.
    pub key: &'static str,
    pub(super) message: String,
}

fn prefix(section: &str) -> String {
    if section.is_empty() { String::new() } else { format!("[{section}] ") }
}

pub(super) fn invalid(section: &'static str, key: &'static str, message: impl Into<String>) -> InvalidValue {
    InvalidValue { section, key, message: message.into() }
}

/// Fails unless `value`, a number or a quantity in SI, lies in the stated range.
pub(super) fn within<T: Copy + Display + Into<f64>>(
    section: &'static str,
    key: &'static str,
    value: T,
    fits: impl Fn(f64) -> bool,
    expected: &str,
) -> Result<(), InvalidValue> {
    if value.into().is_finite() && fits(value.into()) {
        Ok(())
    } else {
        Err(invalid(section, key, format!("found {value}, expected {expected}")))
    }
}

pub(super) fn at_least(
    section: &'static str,
    key: &'static str,
    value: usize,
    least: usize,
) -> Result<(), InvalidValue> {
    within(section, key, value as f64, |value| value >= least as f64, &format!("at least {least}"))
}

/// Fails if a value of a list occurs twice.
pub(super) fn once<T: PartialEq + Display>(
    section: &'static str,
    key: &'static str,
    values: &[T],
) -> Result<(), InvalidValue> {
    let repeated = values.iter().enumerate().find(|(index, value)| values[..*index].contains(value));
    repeated.map_or(Ok(()), |(_, value)| Err(invalid(section, key, format!("found {value} twice"))))
}

pub(super) const POSITIVE: &str = "a positive value";
pub(super) const PERCENT: &str = "a percentage strictly between 0 and 100";

pub(super) fn positive(value: f64) -> bool {
    value > 0.0
}
