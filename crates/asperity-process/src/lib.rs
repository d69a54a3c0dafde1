//! Friction coefficient that fluctuates along the sliding distance: m(s) with a given distribution and correlation
//! length.
//!
//! The default model is m(s) = σ·(F⁻¹(Φ(g(s))) − mean)/std, a translation of a stationary standard normal process g
//! with the correlation e^{−|s|/ℓ} or another [`CorrelationShape`]. It is sampled at grid points a fraction of ℓ apart
//! and is linear between them. Alternatives are a diffusion with a Beta distribution and a process with jumps
//! ([`Generator`]). A [`FittedProcess`] stores the process of a study or of a measured record in SI, also as a file.

mod cancellable;
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

use thiserror::Error;

pub use cancellable::Cancellable;
pub use fitted::{FittedCorrelation, FittedProcess, Origin, OriginKind};
pub use generator::Generator;
pub use json::ProcessFileError;
pub use model::{FrictionProcess, ProcessModel};
pub use path::Path;
pub use recorded::{RecordedPath, RecordedProcess, Steady};
pub use shape::CorrelationShape;

pub use asperity_base::translation::TranslationKind;

use asperity_base::distribution::DistributionError;

/// Mean friction coefficient above which a value or a record is implausible.
///
/// Dry contacts have 0.05 to 1. A larger coefficient is possible where clean metals or rubber adhere, but one above this
/// limit is more often a wrong unit of force, or a friction force and a normal force that were exchanged.
pub const IMPLAUSIBLE_FRICTION: f64 = 1.5;

/// Interval of the sliding distance on which m is linear.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Cell {
    /// End of the interval, counted from the start of the realisation so that rounding does not accumulate; infinite if
    /// m is linear to infinity.
    pub end: f64,
    /// Length of the interval.
    pub length: f64,
    /// Value of m at the start. If it differs from `right` of the previous cell, m jumps.
    pub left: f64,
    /// Value of m at the end.
    pub right: f64,
}

impl Cell {
    /// Returns dm/ds.
    #[inline]
    pub fn slope(&self) -> f64 {
        (self.right - self.left) / self.length
    }
}

/// Realisation of the fluctuation m(s) of a friction coefficient, read cell by cell.
pub trait Fluctuation {
    /// Returns the next cell, starting at s = 0; none after the end of a record.
    fn next_cell(&mut self) -> Option<Cell>;
}

impl<F: Fluctuation + ?Sized> Fluctuation for &mut F {
    #[inline]
    fn next_cell(&mut self) -> Option<Cell> {
        (**self).next_cell()
    }
}

/// Cells between values at equal distances.
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

    /// Returns the next cell, given m at its ends; `left` must equal the previous `right`.
    #[inline]
    fn close(&mut self, left: f64, right: f64) -> Cell {
        self.last = Some(right);
        self.index += 1;
        Cell { end: self.index as f64 * self.step, length: self.step, left, right }
    }
}

/// Error of the construction of a friction process.
#[derive(Debug, Clone, PartialEq, Error)]
#[non_exhaustive]
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
    /// A part of a varying process is missing.
    #[error("`{absent}` is absent, but friction with standard deviation {std} requires it")]
    Absent {
        /// Name of the part.
        absent: &'static str,
        /// Standard deviation of the process.
        std: f64,
    },
    /// The generator does not support the correlation.
    #[error("the {generator} generator does not support a {correlation} correlation; use {able}")]
    Generator {
        /// Name of the generator.
        generator: &'static str,
        /// Name of the correlation.
        correlation: &'static str,
        /// Name of a generator that supports it.
        able: &'static str,
    },
    /// The generator does not support the marginal distribution.
    #[error(
        "the {generator} generator supports only {wanted} distributions, not {distribution}; use autoregressive or renewal"
    )]
    Marginal {
        /// Name of the generator.
        generator: &'static str,
        /// Name of the distribution.
        distribution: &'static str,
        /// Name of the supported distribution.
        wanted: &'static str,
    },
    /// The window is not a whole number of steps.
    #[error("the window of {window} is not a multiple of the step {step}; the nearest suitable step is {nearest}")]
    StepInWindow {
        /// Step.
        step: f64,
        /// Window of the correlation.
        window: f64,
        /// Nearest step that divides the window.
        nearest: f64,
    },
    /// The marginal distribution is invalid, or has no finite standard deviation.
    #[error("marginal distribution of the friction coefficient: {0}")]
    Distribution(#[from] DistributionError),
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
