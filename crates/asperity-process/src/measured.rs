//! Friction records from a tribometer: a text file of columns becomes μ(s) at equal steps, and a fitted process.
//!
//! [`ColumnTable`] reads the file, [`MeasuredRecord::new`] makes μ over the sliding distance of its columns, a
//! [`Preparation`] cuts and detrends it, and [`FittedRecord`] says what process it is. Gaps stay gaps: a missing value is
//! NaN, and every step leaves it out.

mod columns;
mod fit;
mod preparation;
mod record;
mod sampling;
mod smoothing;
mod strokes;

use thiserror::Error;

use crate::ProcessError;
use asperity_base::correlation::EstimateError;
use asperity_base::law::LawError;
use asperity_base::stats::StatsError;

pub use columns::ColumnTable;
pub use fit::{FittedRecord, LawChoice, Series};
pub use preparation::{Cut, Detrend, Preparation, Prepared, Removal};
pub use record::{Abscissa, MeasuredRecord, NormalForce, RecordColumns};

/// Why a file of columns makes no friction record, or a record no process.
#[derive(Debug, Clone, PartialEq, Error)]
pub enum MeasuredError {
    /// Nothing to read.
    #[error("no row of numbers; wanted one row per line, separated by semicolons, tabs, commas or spaces")]
    NoRows,
    /// A row is shorter or longer than the first.
    #[error("line {line}: {found} fields, but the rows above have {wanted}")]
    Ragged {
        /// Line, counted from 1.
        line: usize,
        /// Fields found.
        found: usize,
        /// Fields of the first row.
        wanted: usize,
    },
    /// A cell holds no number.
    #[error("line {line}, column {column}{}: `{text}` is not a number", named(name))]
    Cell {
        /// Line, counted from 1.
        line: usize,
        /// Column, counted from 1.
        column: usize,
        /// Its name, if it has one.
        name: String,
        /// What was found.
        text: String,
    },
    /// No column of that name.
    #[error("no column `{wanted}`; the file has {known}")]
    NoColumn {
        /// The name or number.
        wanted: String,
        /// What there is.
        known: String,
    },
    /// A column states no unit.
    #[error("column `{column}` states no unit; state it, such as {example}")]
    NoUnit {
        /// The column.
        column: String,
        /// Such a unit.
        example: &'static str,
    },
    /// A unit of another kind.
    #[error("column `{column}`: `{unit}` is not a unit of {wanted}")]
    WrongUnit {
        /// The column.
        column: String,
        /// The unit.
        unit: String,
        /// What it should measure.
        wanted: &'static str,
    },
    /// Time without a velocity.
    #[error("the record runs over time, friction over the sliding distance: state the sliding velocity")]
    NoVelocity,
    /// A force without the force that presses.
    #[error("column `{column}` is a force: state the normal force, or name its column")]
    NoNormalForce {
        /// The column.
        column: String,
    },
    /// A coefficient with a normal force.
    #[error(
        "column `{column}` is a friction coefficient, which a normal force has nothing to add to; is its unit right?"
    )]
    IdleNormalForce {
        /// The column.
        column: String,
    },
    /// An option lies outside its range.
    #[error("{option} is {value}, but must be {wanted}")]
    Option {
        /// The option.
        option: &'static str,
        /// Value found.
        value: f64,
        /// Values allowed.
        wanted: &'static str,
    },
    /// Time or distance does not rise.
    #[error("line {line}: `{column}` does not rise, {value} after {before}")]
    NotRising {
        /// Line, counted from 1.
        line: usize,
        /// The column.
        column: String,
        /// Value found.
        value: f64,
        /// Value before.
        before: f64,
    },
    /// Time or distance is missing in a row that has a value.
    #[error("line {line}: `{column}` is missing")]
    NoAbscissa {
        /// Line, counted from 1.
        line: usize,
        /// The column.
        column: String,
    },
    /// Steps differ too much.
    #[error(
        "`{column}` is not evenly sampled: at line {line} a step is off by {:.3} % of the usual {step}, more than 1 %; if its \
         digits are rounded, state the sampling rate and leave the column out",
        100.0 * jitter
    )]
    Uneven {
        /// The column.
        column: String,
        /// Line of the worst step, counted from 1.
        line: usize,
        /// Its deviation over the usual step.
        jitter: f64,
        /// The usual step, in the column's unit.
        step: f64,
    },
    /// A gap is longer than all that was measured.
    #[error("line {line}: a gap of {steps} steps before it is too long to be one in a record of {rows} rows")]
    LongGap {
        /// Line, counted from 1.
        line: usize,
        /// Its length in steps.
        steps: f64,
        /// Rows of the record.
        rows: usize,
    },
    /// Neither one direction of sliding nor strokes.
    #[error(
        "friction changes its sign without being strokes to and fro, and its mean is {:.1} % of its mean size: cut one direction \
         out, or take the offset of the force out",
        100.0 * ratio
    )]
    NoDirection {
        /// Mean over mean size.
        ratio: f64,
    },
    /// Too little is left.
    #[error("{present} values {what}; wanted at least {wanted}")]
    TooFew {
        /// Values.
        present: usize,
        /// Of which.
        what: &'static str,
        /// Least number.
        wanted: usize,
    },
    /// The record is too short for its correlation.
    #[error(
        "{present} correlated values are worth {effective:.1} independent ones; wanted at least {wanted}: measure longer, or \
         take a slower trend out"
    )]
    TooShort {
        /// Values.
        present: usize,
        /// Independent values that they are worth.
        effective: f64,
        /// Least number.
        wanted: f64,
    },
    /// A statistic is undefined.
    #[error(transparent)]
    Statistics(#[from] StatsError),
    /// The correlation is undefined.
    #[error(transparent)]
    Correlation(#[from] EstimateError),
    /// The law cannot be fitted.
    #[error("the law of friction: {0}")]
    Law(#[from] LawError),
    /// What was found makes no process.
    #[error(transparent)]
    Process(#[from] ProcessError),
}

impl MeasuredError {
    /// Whether what was asked for is wrong, rather than the file.
    pub fn is_request(&self) -> bool {
        matches!(
            self,
            Self::NoColumn { .. }
                | Self::NoUnit { .. }
                | Self::WrongUnit { .. }
                | Self::NoVelocity
                | Self::NoNormalForce { .. }
                | Self::IdleNormalForce { .. }
                | Self::Option { .. }
        )
    }

    /// Whether too few values are left for an answer.
    pub fn is_too_few(&self) -> bool {
        matches!(self, Self::TooFew { .. } | Self::TooShort { .. })
    }
}

fn named(name: &str) -> String {
    if name.is_empty() { String::new() } else { format!(" (`{name}`)") }
}
