//! Friction records of a tribometer: converts a text file of columns to μ(s) at equal steps and to a fitted process.
//!
//! [`ColumnTable`] reads the file, [`MeasuredRecord::new`] computes μ over the sliding distance from its columns, a
//! [`RecordPreparation`] cuts and detrends the record, and [`FittedRecord`] fits a process. Gaps are never filled: a missing
//! value is NaN, and every step omits it.

mod columns;
mod drift;
mod fit;
mod preparation;
mod record;
mod sampling;
mod smoothing;
mod strokes;
mod units;

use thiserror::Error;

use crate::ProcessError;
use crate::model::STEPS;
use asperity_base::correlation::EstimateError;
use asperity_base::distribution::DistributionError;
use asperity_base::stats::StatsError;

pub use columns::ColumnTable;
pub use fit::{DistributionChoice, FittedRecord, Series};
pub use preparation::{Cut, Detrend, PreparedRecord, RecordPreparation, Removal};
pub use record::{Abscissa, MeasuredRecord, NormalForce, RecordColumns};

/// Largest friction coefficients of a record whose moments are accurate in double precision.
const MIN_FRICTION: f64 = 1e-30;
const MAX_FRICTION: f64 = 1e30;

/// Error of reading a friction record or of fitting a process to it.
#[derive(Debug, Clone, PartialEq, Error)]
#[non_exhaustive]
pub enum MeasuredError {
    /// The file has no rows.
    #[error("no row of numbers found; wanted one row per line, separated by semicolons, tabs, commas or spaces")]
    NoRows,
    /// A row is shorter or longer than the first.
    #[error("line {line}: {found} fields, but the rows above have {wanted}")]
    Ragged {
        /// Line, counted from 1.
        line: usize,
        /// Number of fields found.
        found: usize,
        /// Number of fields of the first row.
        wanted: usize,
    },
    /// A cell is not a number.
    #[error("line {line}, column {column}{}: `{text}` is not a number", named(name))]
    Cell {
        /// Line, counted from 1.
        line: usize,
        /// Column, counted from 1.
        column: usize,
        /// Name of the column, if there is one.
        name: String,
        /// Text found.
        text: String,
    },
    /// A comma may separate thousands or be a decimal sign.
    #[error(
        "line {line}, column {column}{}: the comma of `{text}` may separate thousands or be a decimal sign; write numbers without \
         thousands separators and with decimal points",
        named(name)
    )]
    Comma {
        /// Line, counted from 1.
        line: usize,
        /// Column, counted from 1.
        column: usize,
        /// Name of the column, if there is one.
        name: String,
        /// Text found.
        text: String,
    },
    /// Several columns have that name.
    #[error("there are several columns `{wanted}`; the file has {known}; give a number")]
    TwoColumns {
        /// Requested name.
        wanted: String,
        /// Columns of the file.
        known: String,
    },
    /// No normal force is above zero.
    #[error("no value of the normal force, column `{column}`, is above zero; write compression as positive")]
    NoCompression {
        /// The column.
        column: String,
    },
    /// There is no column of that name.
    #[error("no column `{wanted}`; the file has {known}")]
    NoColumn {
        /// Requested name or number.
        wanted: String,
        /// Columns of the file.
        known: String,
    },
    /// A column has no unit.
    #[error("column `{column}` has no unit; state it, for example {example}")]
    NoUnit {
        /// Name of the column.
        column: String,
        /// Example of a unit.
        example: &'static str,
    },
    /// A unit has the wrong dimension.
    #[error("column `{column}`: `{unit}` is not a unit of {wanted}")]
    WrongUnit {
        /// Name of the column.
        column: String,
        /// Unit found.
        unit: String,
        /// Required dimension.
        wanted: &'static str,
    },
    /// The record is over time, but the velocity is missing.
    #[error("the record is over time, but friction is analysed over the sliding distance: state the sliding velocity")]
    NoVelocity,
    /// The ends of a cut are times, but the record is over distance.
    #[error(
        "the cut is from one time to another, but the record is over the sliding distance: give two distances, or state the \
         sliding velocity"
    )]
    CutOfTime,
    /// The distance between values is outside the range of exact sums.
    #[error(
        "the distance between values is {step_m:e} m, but must be {:e} to {:e} m; check the units",
        STEPS.start(),
        STEPS.end()
    )]
    Step {
        /// Distance in metre.
        step_m: f64,
    },
    /// The friction coefficient is outside the range of its moments.
    #[error(
        "the largest friction coefficient is {largest:e}, but must be {MIN_FRICTION:e} to {MAX_FRICTION:e}; check the units of \
         friction and normal force"
    )]
    Magnitude {
        /// Largest absolute value.
        largest: f64,
    },
    /// The column is a friction force, but the normal force is missing.
    #[error("column `{column}` is a force: state the normal force, or name its column")]
    NoNormalForce {
        /// Name of the column.
        column: String,
    },
    /// The column is a friction coefficient, but a normal force is given.
    #[error(
        "column `{column}` is a friction coefficient and needs no normal force; omit the normal force, or correct the unit"
    )]
    IdleNormalForce {
        /// Name of the column.
        column: String,
    },
    /// An option is outside its range.
    #[error("{option} is {value}, but must be {wanted}")]
    Option {
        /// Name of the option.
        option: &'static str,
        /// Value found.
        value: f64,
        /// Values allowed.
        wanted: &'static str,
    },
    /// Time or distance does not increase.
    #[error("line {line}: `{column}` does not rise, {value} after {before}")]
    NotRising {
        /// Line, counted from 1.
        line: usize,
        /// Name of the column.
        column: String,
        /// Value found.
        value: f64,
        /// Previous value.
        before: f64,
    },
    /// Time or distance is missing in a row that has a value.
    #[error("line {line}: `{column}` is missing")]
    NoAbscissa {
        /// Line, counted from 1.
        line: usize,
        /// Name of the column.
        column: String,
    },
    /// The steps differ too much.
    #[error(
        "`{column}` is not evenly sampled: at line {line} a step differs by {:.3} % from the usual {step}, more than 1 %; if its \
         digits are rounded, state the sampling rate and leave the column out",
        100.0 * jitter
    )]
    Uneven {
        /// Name of the column.
        column: String,
        /// Line of the worst step, counted from 1.
        line: usize,
        /// Relative deviation of that step from the usual one.
        jitter: f64,
        /// Usual step, in the unit of the column.
        step: f64,
    },
    /// A gap is longer than the measured part.
    #[error("line {line}: the gap of {steps} steps before this line is too long for a record of {rows} rows")]
    LongGap {
        /// Line, counted from 1.
        line: usize,
        /// Length of the gap in steps.
        steps: f64,
        /// Number of rows of the record.
        rows: usize,
    },
    /// The record has neither one direction of sliding nor strokes.
    #[error(
        "friction changes its sign but not in reciprocating strokes, and its mean is {:.1} % of its mean absolute value: cut \
         out one direction, or remove the offset of the force",
        100.0 * ratio
    )]
    NoDirection {
        /// Ratio of the mean to the mean absolute value.
        ratio: f64,
    },
    /// Too few values are left.
    #[error("{present} values {what}; wanted at least {wanted}")]
    TooFew {
        /// Number of values.
        present: usize,
        /// Description of the counted values.
        what: &'static str,
        /// Least number.
        wanted: usize,
    },
    /// The record is too short for its correlation.
    #[error(
        "{present} correlated values correspond to {effective:.1} independent ones; wanted at least {wanted}: measure longer, or \
         take a slower trend out"
    )]
    TooShort {
        /// Number of values.
        present: usize,
        /// Effective sample size.
        effective: f64,
        /// Least effective sample size.
        wanted: f64,
    },
    /// A statistic is undefined.
    #[error(transparent)]
    Statistics(#[from] StatsError),
    /// The correlation is undefined.
    #[error(transparent)]
    Correlation(#[from] EstimateError),
    /// The distribution cannot be fitted.
    #[error("distribution of friction: {0}")]
    Distribution(#[from] DistributionError),
    /// The fitted values are not a valid process.
    #[error(transparent)]
    Process(#[from] ProcessError),
}

impl MeasuredError {
    /// Returns whether the request is wrong, rather than the file.
    pub fn is_request(&self) -> bool {
        matches!(
            self,
            Self::NoColumn { .. }
                | Self::NoUnit { .. }
                | Self::WrongUnit { .. }
                | Self::NoVelocity
                | Self::CutOfTime
                | Self::Step { .. }
                | Self::Magnitude { .. }
                | Self::NoNormalForce { .. }
                | Self::IdleNormalForce { .. }
                | Self::Option { .. }
        )
    }

    /// Returns whether too few values are left for a result.
    pub fn is_too_few(&self) -> bool {
        matches!(self, Self::TooFew { .. } | Self::TooShort { .. })
    }
}

fn named(name: &str) -> String {
    if name.is_empty() { String::new() } else { format!(" (`{name}`)") }
}
