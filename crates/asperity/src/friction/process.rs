//! A friction coefficient that fluctuates along the sliding distance: m(s) with a given law and correlation length.

mod recorded;

use thiserror::Error;

pub use recorded::{RecordedPath, RecordedProcess, Steady};

/// A realisation of the fluctuation m(s) of a friction coefficient, read knot by knot.
///
/// Knots lie at s = 0, h, 2h, …; between them m is a straight line.
pub trait Fluctuation {
    /// Distance h between knots; none if m = 0 everywhere.
    fn step(&self) -> Option<f64>;

    /// m at the next knot, first at s = 0; none past the end of a record.
    fn next_knot(&mut self) -> Option<f64>;
}

/// Why a friction process could not be made.
#[derive(Debug, Clone, PartialEq, Error)]
pub enum ProcessError {
    /// A parameter lies outside its range.
    #[error("{parameter} is {value}, but must be {wanted}")]
    Parameter {
        /// Name of the parameter.
        parameter: &'static str,
        /// Value found.
        value: f64,
        /// Values allowed.
        wanted: &'static str,
    },
}

fn positive(parameter: &'static str, value: f64) -> Result<(), ProcessError> {
    if value.is_finite() && value > 0.0 {
        Ok(())
    } else {
        Err(ProcessError::Parameter { parameter, value, wanted: "positive and finite" })
    }
}
