//! A friction coefficient that fluctuates along the sliding distance: m(s) with a given law and correlation length.
//!
//! m(s) = σ·(F⁻¹(Φ(g(s))) − mean)/std, a translation of a stationary standard normal process g of correlation e^{−|s|/ℓ} or
//! another [`CorrelationShape`], sampled at knots a fraction of ℓ apart and a straight line between them. Other ways to make
//! m(s) are a diffusion of Beta law and values that jump ([`Generator`]). A [`FittedProcess`] is what a study or a measured
//! record says of such a process, in SI and as a file.

pub mod diagnostics;
mod fitted;
mod generator;
mod jacobi;
mod json;
pub mod measured;
mod model;
mod moving_average;
mod path;
mod recorded;
mod renewal;
mod shape;
mod spectral;
mod table;
mod watched;

use thiserror::Error;

pub use fitted::{FittedCorrelation, FittedProcess, Origin, OriginKind};
pub use generator::Generator;
pub use json::ProcessFileError;
pub use model::{Correlation, FrictionProcess, ProcessModel, window_variance_factor};
pub use path::Path;
pub use recorded::{RecordedPath, RecordedProcess, Steady};
pub use shape::CorrelationShape;
pub use watched::Watched;

use asperity_base::law::LawError;

/// A stretch of the sliding distance on which m is a straight line.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Cell {
    /// Where it ends, counted from the start of the realisation so that rounding does not add up; infinite if m stays a
    /// straight line for ever.
    pub end: f64,
    /// Its length.
    pub length: f64,
    /// m where it begins. If that is not `right` of the cell before, m jumps.
    pub left: f64,
    /// m where it ends.
    pub right: f64,
}

impl Cell {
    /// dm/ds.
    #[inline]
    pub fn slope(&self) -> f64 {
        (self.right - self.left) / self.length
    }
}

/// A realisation of the fluctuation m(s) of a friction coefficient, read cell by cell.
pub trait Fluctuation {
    /// The next cell, the first from s = 0 on; none past the end of a record.
    fn next_cell(&mut self) -> Option<Cell>;
}

impl<F: Fluctuation + ?Sized> Fluctuation for &mut F {
    #[inline]
    fn next_cell(&mut self) -> Option<Cell> {
        (**self).next_cell()
    }
}

/// Makes cells of values at equal distances.
#[derive(Debug, Clone, Copy)]
struct EqualCells {
    step: f64,
    index: usize,
    last: Option<f64>,
}

impl EqualCells {
    fn new(step: f64) -> Self {
        Self { step, index: 0, last: None }
    }

    /// The next cell, given its ends; `left` is the last `right`.
    #[inline]
    fn close(&mut self, left: f64, right: f64) -> Cell {
        self.last = Some(right);
        self.index += 1;
        Cell { end: self.index as f64 * self.step, length: self.step, left, right }
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
    /// The generator cannot make the marginal law.
    #[error("the {generator} generator makes a {wanted} law, not a {law} one; autoregressive and renewal make any")]
    Marginal {
        /// The generator.
        generator: &'static str,
        /// The law.
        law: &'static str,
        /// The law that it makes.
        wanted: &'static str,
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

#[cfg(doctest)]
#[doc = include_str!("../README.md")]
struct Readme;
