//! Conversion of columns to μ over the sliding distance.

use super::columns::{Chosen, ColumnTable};
use super::sampling::{Grid, even};
use super::strokes::{Signs, Strokes, signs};
use super::units::{force_factor, is_none, length_factor, time_factor};
use super::{MAX_FRICTION, MIN_FRICTION, MeasuredError, sampling};
use crate::model::STEPS;

/// Columns of a file that contain the record, by name or by number counted from 1.
///
/// A unit given here takes precedence over the unit of the header.
#[derive(Debug, Clone, PartialEq)]
pub struct RecordColumns {
    /// Column of the friction force or coefficient.
    pub column: String,
    /// Unit of the column; for a coefficient none, `1` or `-`.
    pub unit: Option<String>,
    /// Independent variable of the values.
    pub abscissa: Abscissa,
    /// Sliding velocity in m/s, which converts time to distance.
    pub velocity_m_per_s: Option<f64>,
    /// Normal force, which converts a friction force to a coefficient.
    pub normal_force: Option<NormalForce>,
}

/// Independent variable of the values of a record.
#[derive(Debug, Clone, PartialEq)]
pub enum Abscissa {
    /// A column of times.
    Time {
        /// Name of the column.
        column: String,
        /// Unit of the column.
        unit: Option<String>,
    },
    /// A column of sliding distances.
    Distance {
        /// Name of the column.
        column: String,
        /// Unit of the column.
        unit: Option<String>,
    },
    /// Equal time steps.
    SamplingRate {
        /// Sampling rate in hertz.
        hertz: f64,
    },
}

/// Normal force.
#[derive(Debug, Clone, PartialEq)]
pub enum NormalForce {
    /// Constant force.
    Constant {
        /// Force in newton.
        newton: f64,
    },
    /// A column of the file.
    Column {
        /// Name of the column.
        column: String,
        /// Unit of the column.
        unit: Option<String>,
    },
}

/// Friction coefficient at equal steps of the sliding distance; NaN in gaps.
#[derive(Debug, Clone, PartialEq)]
pub struct MeasuredRecord {
    /// Distance of the first value in metre, in the coordinates of the file.
    pub start_m: f64,
    /// Step in metre.
    pub step_m: f64,
    /// Friction coefficient μ.
    pub friction: Vec<f64>,
    /// Sliding velocity in m/s, if known.
    pub velocity_m_per_s: Option<f64>,
    /// Distances in metre of the starts of the strokes of a reciprocating machine, except the first.
    pub strokes_m: Vec<f64>,
    /// Changes made to the record, in words.
    pub warnings: Vec<String>,
}

/// Returns the factor to SI of a column with a known dimension.
fn factor(
    chosen: &Chosen<'_>,
    stated: Option<&str>,
    of: fn(&str) -> Option<f64>,
    wanted: &'static str,
    example: &'static str,
) -> Result<f64, MeasuredError> {
    let column = || chosen.name.to_owned();
    let unit = stated.or(chosen.unit).ok_or_else(|| MeasuredError::NoUnit { column: column(), example })?;
    of(unit).ok_or_else(|| MeasuredError::WrongUnit { column: column(), unit: unit.into(), wanted })
}

impl MeasuredRecord {
    /// Computes μ over the sliding distance from the columns of a file.
    ///
    /// A friction force F is divided by the normal force N row by row; rows with N ≤ 0 are gaps. Times are multiplied
    /// by the sliding velocity. Rows that are missing from an even sampling are gaps. Steps that differ by less than
    /// 1 % are resampled with a warning; larger differences are an error. A negative record, from sliding in the other
    /// direction, is reversed with a warning. Strokes of alternating sign become |μ| stroke by stroke, with gaps at
    /// their reversals, also with a warning.
    ///
    /// # Errors
    /// Fails if columns are missing or contain text, if units are absent or have the wrong dimension, if the velocity
    /// for a time or the normal force for a force is missing, if the sampling is uneven, if there are fewer than 2
    /// rows, if the distance between values is not between 1e-15 and 1e15 m or the largest friction coefficient not
    /// between 1e-30 and 1e30, or if values lie on both sides of zero without being strokes.
    pub fn new(table: &ColumnTable, columns: &RecordColumns) -> Result<Self, MeasuredError> {
        if table.rows() < 2 {
            return Err(MeasuredError::TooFew { present: table.rows(), what: "are in the file", wanted: 2 });
        }
        let mut warnings = Vec::new();
        let values = coefficient(table, columns, &mut warnings)?;
        let velocity = columns.velocity_m_per_s;
        if let Some(value) = velocity.filter(|value| !(value.is_finite() && *value > 0.0)) {
            return Err(MeasuredError::Option { option: "sliding velocity", value, wanted: "positive and finite" });
        }
        let Grid { start, step, values } = match &columns.abscissa {
            Abscissa::SamplingRate { hertz } => {
                if !(hertz.is_finite() && *hertz > 0.0) {
                    let (option, wanted) = ("sampling rate", "positive and finite");
                    return Err(MeasuredError::Option { option, value: *hertz, wanted });
                }
                Grid { start: 0.0, step: hertz.recip(), values }
            }
            Abscissa::Time { column, unit } => {
                let chosen = table.column(column)?;
                let factor = factor(&chosen, unit.as_deref(), time_factor, "time", "s or ms")?;
                scaled(even(table, &chosen, values, &mut warnings)?, factor)
            }
            Abscissa::Distance { column, unit } => {
                let chosen = table.column(column)?;
                let factor = factor(&chosen, unit.as_deref(), length_factor, "length", "m or mm")?;
                scaled(even(table, &chosen, values, &mut warnings)?, factor)
            }
        };
        let per_axis = match columns.abscissa {
            Abscissa::Distance { .. } => 1.0,
            Abscissa::Time { .. } | Abscissa::SamplingRate { .. } => velocity.ok_or(MeasuredError::NoVelocity)?,
        };
        let mut friction = values;
        let present = sampling::sum(&friction).1;
        if present == 0 {
            return Err(MeasuredError::TooFew { present, what: "are present in the column", wanted: 2 });
        }
        let (start_m, step_m) = (start * per_axis, step * per_axis);
        check_scales(step_m, &friction)?;
        let mut starts = Vec::new();
        match signs(&friction) {
            Signs::One { reversed: false } => {}
            Signs::One { reversed: true } => {
                friction.iter_mut().for_each(|mu| *mu = -*mu);
                warnings.push("friction is negative on average: its sign was reversed".into());
            }
            Signs::Strokes(Strokes { friction: sizes, starts: found, reversal_fraction }) => {
                warnings.push(format!(
                    "friction alternates its sign: |μ| of {} reciprocating strokes is analysed as pieces of one process, \
                     without the reversals ({:.1} % of the values); strokes over the same track are correlated, which the \
                     intervals ignore",
                    found.len() + 1,
                    100.0 * reversal_fraction
                ));
                (friction, starts) = (sizes, found);
            }
            Signs::None { ratio } => return Err(MeasuredError::NoDirection { ratio }),
        }
        let gaps = friction.len() - present;
        if gaps > 0 {
            let fraction = 100.0 * gaps as f64 / friction.len() as f64;
            warnings.push(format!("{gaps} of {} values are missing ({fraction:.2} %) and remain gaps", friction.len()));
        }
        Ok(Self {
            start_m,
            step_m,
            friction,
            velocity_m_per_s: velocity,
            strokes_m: starts.iter().map(|index| start_m + step_m * *index as f64).collect(),
            warnings,
        })
    }

    /// Returns the record, or its strokes one by one, without missing values at their ends.
    pub fn pieces(&self) -> Vec<&[f64]> {
        let index = |position_m: &f64| ((position_m - self.start_m) / self.step_m).ceil().max(0.0) as usize;
        let n = self.friction.len();
        let mut ends: Vec<usize> = self.strokes_m.iter().map(index).map(|end| end.min(n)).collect();
        ends.push(n);
        let mut start = 0;
        let mut pieces = Vec::new();
        for end in ends {
            let piece = &self.friction[start.min(end)..end];
            let first = piece.iter().position(|mu| !mu.is_nan());
            let last = piece.iter().rposition(|mu| !mu.is_nan());
            pieces.extend(first.zip(last).map(|(first, last)| &piece[first..=last]));
            start = end;
        }
        pieces
    }

    /// Returns the number of present values.
    pub fn present(&self) -> usize {
        sampling::sum(&self.friction).1
    }

    /// Returns the distance in metre of the value `index`.
    pub fn position_m(&self, index: usize) -> f64 {
        self.start_m + self.step_m * index as f64
    }
}

fn scaled(grid: Grid, factor: f64) -> Grid {
    Grid { start: grid.start * factor, step: grid.step * factor, values: grid.values }
}

/// Returns μ row by row.
fn coefficient(
    table: &ColumnTable,
    columns: &RecordColumns,
    warnings: &mut Vec<String>,
) -> Result<Vec<f64>, MeasuredError> {
    let chosen = table.column(&columns.column)?;
    let unit = columns.unit.as_deref().or(chosen.unit);
    let column = || chosen.name.to_owned();
    let force = match unit {
        Some(unit) if is_none(unit) => None,
        Some("%") => return Ok(chosen.values.iter().map(|mu| 0.01 * mu).collect()),
        Some(unit) => Some(force_factor(unit).ok_or_else(|| MeasuredError::WrongUnit {
            column: column(),
            unit: unit.into(),
            wanted: "force; a friction coefficient has no unit (- or 1)",
        })?),
        // Without a unit the column is a coefficient, unless a normal force is given.
        None if columns.normal_force.is_some() => {
            return Err(MeasuredError::NoUnit { column: column(), example: "N or mN" });
        }
        None => None,
    };
    let Some(newton) = force else {
        return match columns.normal_force {
            Some(_) => Err(MeasuredError::IdleNormalForce { column: column() }),
            None => Ok(chosen.values.to_vec()),
        };
    };
    match &columns.normal_force {
        None => Err(MeasuredError::NoNormalForce { column: column() }),
        Some(NormalForce::Constant { newton: normal }) => {
            if !(normal.is_finite() && *normal > 0.0) {
                let (option, wanted) = ("normal force", "positive and finite");
                return Err(MeasuredError::Option { option, value: *normal, wanted });
            }
            Ok(chosen.values.iter().map(|force| force * newton / normal).collect())
        }
        Some(NormalForce::Column { column, unit }) => {
            let pressing = table.column(column)?;
            let normal_newton = factor(&pressing, unit.as_deref(), force_factor, "force", "N or mN")?;
            if !pressing.values.iter().any(|normal| *normal > 0.0) {
                return Err(MeasuredError::NoCompression { column: pressing.name.into() });
            }
            let idle = pressing.values.iter().filter(|normal| **normal <= 0.0).count();
            if idle > 0 {
                warnings.push(format!("in {idle} rows the normal force is not above zero; these rows are gaps"));
            }
            let quotient = |(force, normal): (&f64, &f64)| {
                if *normal > 0.0 { force * newton / (normal * normal_newton) } else { f64::NAN }
            };
            Ok(chosen.values.iter().zip(pressing.values).map(quotient).collect())
        }
    }
}

/// Checks that sums over distances and powers of the friction coefficient are exact.
pub(super) fn check_scales(step_m: f64, friction: &[f64]) -> Result<(), MeasuredError> {
    if !STEPS.contains(&step_m) {
        return Err(MeasuredError::Step { step_m });
    }
    let largest = friction.iter().map(|mu| mu.abs()).fold(0.0, f64::max);
    if largest != 0.0 && !(MIN_FRICTION..=MAX_FRICTION).contains(&largest) {
        return Err(MeasuredError::Magnitude { largest });
    }
    Ok(())
}
