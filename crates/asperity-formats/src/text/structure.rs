//! What a matrix of numbers is: heights alone, heights with labels, or a profile.

use super::rows::Table;
use crate::{Format, FormatError, Result, Shape};

/// Tolerance of labels as a fraction of a step, for coordinates with few digits.
const LABEL_TOLERANCE: f64 = 1e-3;
/// Number of labels from which a single row or column of them cannot be heights that step evenly by chance.
const MANY: usize = 8;

/// Removes labels along the sides of a matrix without a stated size, with a warning.
///
/// Numbers that step evenly along one row or column, and along no other in this direction, are labels: a plane steps evenly everywhere.
///
/// # Errors
/// The numbers are a profile or several matrices, or it is open whether they are labels.
pub(super) fn without_labels(
    table: &mut Table,
    shape: Shape,
    is_corner_empty: bool,
    warnings: &mut Vec<String>,
) -> Result<Shape> {
    let (rows, columns) = shape;
    // Some programs write a blank line after each row.
    if table.gaps > 0 && table.gaps + 1 < rows {
        let found = format!("{} blocks of numbers, divided by blank lines", table.gaps + 1);
        return Err(FormatError::unsupported(
            Format::Text,
            found,
            "one matrix; write each block into a file of its own",
        ));
    }
    if let Some(found) = profile(&table.values, shape) {
        let wanted = "the heights of a map, which asperity needs along x and along y";
        return Err(FormatError::unsupported(Format::Text, format!("a profile: {found}"), wanted));
    }
    if rows <= 2 || columns <= 2 {
        return Ok(shape);
    }
    let line = |row: usize| table.values[row * columns..(row + 1) * columns].to_vec();
    let side = |column: usize| table.values.iter().copied().skip(column).step_by(columns).collect::<Vec<f64>>();
    // The corner is no label. Beside an empty one the numbers may be those of a plane.
    let top = steps_evenly(&line(0)[1..]) && (is_corner_empty || (1..rows).all(|row| !steps_evenly(&line(row)[1..])));
    let left = steps_evenly(&side(0)[1..])
        && (is_corner_empty || (1..columns).all(|column| !steps_evenly(&side(column)[1..])));
    let (top, left, what) = match (top, left) {
        (true, true) if is_corner_empty || rows.min(columns) > 3 => {
            (true, true, "the first row and the first column step")
        }
        _ if is_corner_empty => return Ok(shape),
        (true, false) if steps_evenly(&line(0)) => (true, false, "the first row steps"),
        (false, true) if steps_evenly(&side(0)) => (false, true, "the first column steps"),
        _ => return Ok(shape),
    };
    // Beside three columns they may also be coordinates of points on a line.
    let is_open = columns == 3 || if top { columns < MANY } else { rows < MANY };
    if is_open && !(top && left) {
        let found =
            format!("a matrix of {columns} × {rows} numbers, of which {what} evenly: labels, coordinates or heights");
        let wanted = "heights alone: remove labels, or state the pixel size in the header if they are heights";
        return Err(FormatError::unsupported(Format::Text, found, wanted));
    }
    let (skipped_rows, skipped_columns) = (usize::from(top), usize::from(left));
    let kept = table.values.chunks_exact(columns).skip(skipped_rows).flat_map(|row| &row[skipped_columns..]);
    table.values = kept.copied().collect();
    warnings.push(format!("{what} evenly and count as labels, which were left out"));
    Ok((rows - skipped_rows, columns - skipped_columns))
}

/// Describes a profile; `None` for a map.
fn profile(values: &[f64], (rows, columns): Shape) -> Option<String> {
    let rises = |mut pairs: Vec<f64>| {
        let is_falling = pairs.first() > pairs.last();
        if is_falling {
            pairs.reverse();
        }
        pairs.windows(2).all(|pair| pair[0] < pair[1])
    };
    match (rows, columns) {
        (4.., 1) => Some(format!("a single column of {rows} numbers")),
        (1, 4..) => Some(format!("a single row of {columns} numbers")),
        (4.., 2) if rises(values.iter().copied().step_by(2).collect()) => {
            Some(format!("two columns, of which the first rises or falls over {rows} rows"))
        }
        (2, 4..) if rises(values[..columns].to_vec()) => {
            Some(format!("two rows, of which the first rises or falls over {columns} columns"))
        }
        _ => None,
    }
}

/// Returns whether labels have equal steps.
fn steps_evenly(labels: &[f64]) -> bool {
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
