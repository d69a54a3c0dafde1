//! What a matrix of numbers is: heights alone, or heights with labels.

use super::rows::Table;
use crate::{Format, FormatError, Result, Shape, refuse_if};

/// Tolerance of labels as a fraction of a step, for coordinates with few digits.
const LABEL_TOLERANCE: f64 = 1e-3;
/// Number of labels from which a row and a column of them cannot be heights that step evenly by chance.
const MANY: usize = 8;
/// Fraction of the other rows or columns that may step evenly by chance beside labels. Those of a plane all do.
const BY_CHANCE: f64 = 0.1;

/// First value of a matrix.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Corner {
    /// No value: row and column beside it are labels.
    Empty,
    Number,
}

/// Removes labels along the sides of a matrix without a stated shape, with a warning.
///
/// Beside an empty corner numbers that step evenly are labels. Otherwise they are labels if they step evenly along one row or column and along
/// few others in this direction, and if they cannot be heights; a header with the size of the map (`has_extent`) belongs to heights alone.
///
/// # Errors
/// The numbers are several matrices, or it is open whether they are labels.
pub(super) fn without_labels(
    table: &mut Table,
    shape: Shape,
    corner: Corner,
    has_extent: bool,
    warnings: &mut Vec<String>,
) -> Result<Shape> {
    let (rows, columns) = shape;
    // Some programs write a blank line after each row, or after a row of labels.
    refuse_if!(table.gaps > usize::from(table.is_first_divided) && table.gaps + 1 < rows, blocks(table));
    if rows <= 2 || columns <= 2 || corner == Corner::Number && has_extent {
        return Ok(shape);
    }
    let line = |row: usize| table.values[row * columns..(row + 1) * columns].to_vec();
    let side = |column: usize| table.values.iter().copied().skip(column).step_by(columns).collect::<Vec<f64>>();
    let is_empty = corner == Corner::Empty;
    let alone = |others: &mut dyn Iterator<Item = Vec<f64>>, count: usize| {
        let even = others.filter(|line| steps_evenly(&line[1..])).count();
        is_empty || even as f64 <= BY_CHANCE * count as f64
    };
    let (first_row, first_column) = (line(0), side(0));
    let top = steps_evenly(&first_row[1..]) && alone(&mut (1..rows).map(line), rows - 1);
    let left = steps_evenly(&first_column[1..]) && alone(&mut (1..columns).map(side), columns - 1);
    let (skipped, what, are_labels) = match (top, left) {
        (true, true) if !is_empty && rows.min(columns) < 4 => return Ok(shape),
        (true, true) => {
            // The numbers of a cone step evenly along both sides, corner included.
            let is_run = steps_evenly(&first_row) && steps_evenly(&first_column);
            ([1, 1], "the first row and the first column step", is_empty || !is_run && rows.min(columns) > MANY)
        }
        _ if is_empty => return Ok(shape),
        (true, false) if steps_evenly(&first_row) => {
            ([1, 0], "the first row steps", are_indices(&first_row, &table.values[columns..]))
        }
        (false, true) if steps_evenly(&first_column) => {
            let rest: Vec<f64> = table.values.chunks_exact(columns).flat_map(|row| &row[1..]).copied().collect();
            ([0, 1], "the first column steps", columns > 3 && are_indices(&first_column, &rest))
        }
        _ => return Ok(shape),
    };
    if !are_labels {
        let found =
            format!("a matrix of {columns} × {rows} numbers, of which {what} evenly: labels, coordinates or heights");
        let wanted = "heights alone: remove labels, or state the pixel size in the header if they are heights";
        return Err(FormatError::unsupported(Format::Text, found, wanted));
    }
    let kept = table.values.chunks_exact(columns).skip(skipped[0]).flat_map(|row| &row[skipped[1]..]);
    table.values = kept.copied().collect();
    warnings.push(format!("{what} evenly: labels, which were left out"));
    Ok((rows - skipped[0], columns - skipped[1]))
}

/// Returns the error for blocks of numbers.
pub(super) fn blocks(table: &Table) -> FormatError {
    let found = format!("{} blocks of numbers, divided by blank lines", table.gaps + 1);
    let wanted = "one matrix; write each block into a file of its own";
    FormatError::unsupported(Format::Text, found, wanted)
}

/// Returns whether labels are the numbers of rows or columns, counted from 0 or 1, beside values that are no such numbers.
fn are_indices(labels: &[f64], others: &[f64]) -> bool {
    let from_first = |first: f64| labels.iter().enumerate().all(|(place, label)| *label == first + place as f64);
    (from_first(0.0) || from_first(1.0)) && others.iter().any(|value| value.fract() != 0.0)
}

/// Returns whether labels have equal steps.
pub(crate) fn steps_evenly(labels: &[f64]) -> bool {
    match labels {
        [] | [_] => false,
        // Any two numbers have equal steps.
        [first, second] => matches!((*first, *second), (0.0, 1.0) | (1.0, 2.0)),
        [first, second, ..] => {
            let (step, tolerance) = (second - first, LABEL_TOLERANCE * (second - first).abs());
            let fits = |(place, label): (usize, &f64)| (label - first - step * place as f64).abs() <= tolerance;
            step != 0.0 && labels.iter().enumerate().all(fits)
        }
    }
}
