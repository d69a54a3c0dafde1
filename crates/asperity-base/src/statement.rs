//! Inputs of a study that a law reads, and the law that follows from them.

use thiserror::Error;

/// Statement of a law of the type L in a study.
#[derive(Debug)]
pub struct Statement<L> {
    /// Inputs of a study that the law reads, with their sections.
    pub inputs: &'static [&'static str],
    /// Makes the law.
    pub law: fn(&dyn Stated) -> Result<L, StatementError>,
}

/// Stated values in the units of the law.
pub trait Stated {
    /// Returns the number of an input, or its default.
    fn number(&self, input: &str) -> Option<f64>;

    /// Returns the kinetic friction coefficient; a study states other coefficients relative to it.
    fn kinetic(&self) -> f64 {
        1.0
    }

    /// Returns the points of an input that is a table.
    fn points(&self, input: &str) -> Option<Vec<[f64; 2]>>;
}

/// A law that cannot be made.
#[derive(Debug, Error)]
#[error("{reason}")]
pub struct StatementError {
    /// Input that is missing or wrong.
    pub input: &'static str,
    /// Why.
    pub reason: String,
}
