//! A friction coefficient that fluctuates along the sliding distance: m(s) with a given law and correlation length.
//!
//! m(s) = σ·(F⁻¹(Φ(g(s))) − mean)/std, a translation of a stationary standard normal process g of correlation e^{−|s|/ℓ} or
//! another [`CorrelationShape`], sampled at knots a fraction of ℓ apart and a straight line between them. A
//! [`FittedProcess`] is what a study or a measured record says of such a process, in SI and as a file.

mod fitted;
mod json;
mod model;
mod moving_average;
mod recorded;
mod shape;
mod spectral;
mod table;

use thiserror::Error;

pub use fitted::{FittedCorrelation, FittedProcess, Origin, OriginKind};
pub use json::ProcessFileError;
pub use model::{Correlation, FrictionProcess, Generator, Path, ProcessModel, window_variance_factor};
pub use recorded::{RecordedPath, RecordedProcess, Steady};
pub use shape::CorrelationShape;

use crate::law::LawError;

/// A realisation of the fluctuation m(s) of a friction coefficient, read knot by knot.
///
/// Knots lie at s = 0, h, 2h, …; between them m is a straight line.
pub trait Fluctuation {
    /// Distance h between knots; none if m = 0 everywhere.
    fn step(&self) -> Option<f64>;

    /// m at the next knot, first at s = 0; none past the end of a record.
    fn next_knot(&mut self) -> Option<f64>;
}

impl<F: Fluctuation + ?Sized> Fluctuation for &mut F {
    fn step(&self) -> Option<f64> {
        (**self).step()
    }

    fn next_knot(&mut self) -> Option<f64> {
        (**self).next_knot()
    }
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
    /// A process that varies lacks a part.
    #[error("`{absent}` is absent, but friction of standard deviation {std} has one")]
    Absent {
        /// The part.
        absent: &'static str,
        /// The standard deviation.
        std: f64,
    },
    /// The generator cannot make the correlation.
    #[error("the {generator} generator cannot make a {correlation} correlation; the {able} one can")]
    Generator {
        /// The generator.
        generator: &'static str,
        /// The correlation.
        correlation: &'static str,
        /// A generator that can.
        able: &'static str,
    },
    /// A window is no whole number of steps.
    #[error("a step of {step} does not go into the window of {window} a whole number of times; {nearest} does")]
    StepInWindow {
        /// The step.
        step: f64,
        /// The window of the correlation.
        window: f64,
        /// The nearest step that does.
        nearest: f64,
    },
    /// The marginal law is no law, or has no finite standard deviation.
    #[error("marginal of the friction coefficient: {0}")]
    Law(#[from] LawError),
}

fn positive(parameter: &'static str, value: f64) -> Result<(), ProcessError> {
    if value.is_finite() && value > 0.0 {
        Ok(())
    } else {
        Err(ProcessError::Parameter { parameter, value, wanted: "positive and finite" })
    }
}
