//! Even sampling: finds gaps, resamples small jitter and refuses larger jitter.

use super::MeasuredError;
use super::columns::{Chosen, ColumnTable};
use asperity_base::numeric::Line;
use asperity_base::stats::upper_median;

/// Largest relative deviation of a step from the usual one that is resampled.
const LARGEST_JITTER: f64 = 0.01;
/// Distance from an even grid, in steps, up to which values count as being on it.
const ON_GRID: f64 = 1e-3;

/// Values at equal steps, in the unit of the file.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Grid {
    pub(super) start: f64,
    pub(super) step: f64,
    pub(super) values: Vec<f64>,
}

/// Returns the sum and the number of the present values.
pub(super) fn sum(values: &[f64]) -> (f64, usize) {
    values.iter().filter(|value| !value.is_nan()).fold((0.0, 0), |(sum, n), value| (sum + value, n + 1))
}

/// Assigns the values of a column to an even grid.
///
/// The usual step is the median; a step of about k usual ones leaves a gap of k − 1 values. Positions on the grid
/// follow from the least-squares line through (number of steps, position).
pub(super) fn even(
    table: &ColumnTable,
    column: &Chosen<'_>,
    values: Vec<f64>,
    warnings: &mut Vec<String>,
) -> Result<Grid, MeasuredError> {
    let name = || column.name.to_owned();
    // Rows without position and value are gaps; the next position determines their length.
    let rows: Vec<usize> = (0..values.len()).filter(|row| !column.values[*row].is_nan()).collect();
    if let Some(row) = (0..values.len()).find(|row| column.values[*row].is_nan() && !values[*row].is_nan()) {
        return Err(MeasuredError::NoAbscissa { line: table.line(row), column: name() });
    }
    if rows.len() < 2 {
        return Err(MeasuredError::TooFew { present: rows.len(), what: "have a position", wanted: 2 });
    }
    let at = |place: usize| column.values[rows[place]];
    let line = |place: usize| table.line(rows[place]);
    let mut steps: Vec<f64> = (1..rows.len()).map(|place| at(place) - at(place - 1)).collect();
    if let Some(place) = (1..rows.len()).find(|place| steps[place - 1] <= 0.0) {
        return Err(MeasuredError::NotRising {
            line: line(place),
            column: name(),
            value: at(place),
            before: at(place - 1),
        });
    }
    let usual = upper_median(&mut steps.clone()).unwrap_or(f64::NAN);
    let mut worst = (0.0, 0);
    let mut index = vec![0.0];
    for (place, step) in steps.drain(..).enumerate() {
        let count = (step / usual).round().max(1.0);
        let jitter = (step / usual - count).abs();
        if jitter > worst.0 {
            worst = (jitter, place + 1);
        }
        if count > rows.len() as f64 {
            return Err(MeasuredError::LongGap { line: line(place + 1), steps: count, rows: rows.len() });
        }
        index.push(index[place] + count);
    }
    if worst.0 > LARGEST_JITTER {
        return Err(MeasuredError::Uneven { column: name(), line: line(worst.1), jitter: worst.0, step: usual });
    }
    // Otherwise gaps in every row would still fill the memory.
    let total = index[rows.len() - 1];
    if total > 100.0 * rows.len() as f64 {
        return Err(MeasuredError::LongGap { line: line(rows.len() - 1), steps: total, rows: rows.len() });
    }
    let (start, step) = line_through(&index, at);
    let offset = |place: usize| (at(place) - start) / step - index[place];
    let off = (0..rows.len()).map(|place| offset(place).abs()).fold(0.0, f64::max);
    let mut even = vec![f64::NAN; total as usize + 1];
    if off <= ON_GRID {
        for (place, row) in rows.iter().enumerate() {
            even[index[place] as usize] = values[*row];
        }
        return Ok(Grid { start, step, values: even });
    }
    warnings.push(format!(
        "`{}` is slightly uneven: steps differ by up to {:.2} % and positions by {off:.2} steps; values were interpolated \
         linearly, which smooths them slightly",
        column.name,
        100.0 * worst.0
    ));
    let points: Vec<(f64, f64)> = rows.iter().map(|row| (column.values[*row], values[*row])).collect();
    interpolate(&points, &index, |k| start + step * k as f64, &mut even);
    Ok(Grid { start, step, values: even })
}

/// Interpolates linearly between neighbouring points (position, value), but never across a gap.
fn interpolate(points: &[(f64, f64)], index: &[f64], position: impl Fn(usize) -> f64, even: &mut [f64]) {
    let mut place = 0;
    for (k, value) in even.iter_mut().enumerate() {
        let wanted = position(k);
        while place + 2 < points.len() && points[place + 1].0 < wanted {
            place += 1;
        }
        let ((low, a), (high, b)) = (points[place], points[place + 1]);
        let fraction = (wanted - low) / (high - low);
        let joined = index[place + 1] - index[place] == 1.0;
        if joined && (-1.0..=2.0).contains(&fraction) {
            *value = match fraction.clamp(0.0, 1.0) {
                0.0 => a,
                1.0 => b,
                fraction => a + fraction * (b - a),
            };
        }
    }
}

/// Returns start and step of the least-squares line through positions over their indices.
fn line_through(index: &[f64], position: impl Fn(usize) -> f64) -> (f64, f64) {
    // Relative to the first position, so that large clock values lose no digits.
    let first = position(0);
    let points: Vec<(f64, f64)> = index.iter().enumerate().map(|(place, k)| (*k, position(place) - first)).collect();
    let Line { x, y, slope } = Line::through(&points);
    (first + y - slope * x, slope)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn read(text: &str) -> (Result<Grid, MeasuredError>, Vec<String>) {
        let table = ColumnTable::read(format!("t;mu\n{text}").as_bytes()).unwrap();
        let mut warnings = Vec::new();
        let values = table.column("mu").unwrap().values.to_vec();
        (even(&table, &table.column("t").unwrap(), values, &mut warnings), warnings)
    }

    #[test]
    fn missing_rows_are_gaps_of_their_length() {
        let (grid, warnings) = read("1.5;1\n1.6;2\n1.9;5\n2.0;\n2.1;7\n");
        let grid = grid.unwrap();
        assert!((grid.start - 1.5).abs() < 1e-12 && (grid.step - 0.1).abs() < 1e-12 && warnings.is_empty());
        assert_eq!(grid.values.len(), 7);
        for (k, wanted) in [(0, 1.0), (1, 2.0), (4, 5.0), (6, 7.0)] {
            assert_eq!(grid.values[k], wanted);
        }
        assert!([2, 3, 5].iter().all(|k| grid.values[*k].is_nan()));
    }

    #[test]
    fn small_jitter_is_interpolated_with_a_warning() {
        // μ = t, which linear interpolation keeps exactly.
        let times: Vec<f64> = (0..200).map(|i| f64::from(i) + 0.004 * f64::from(i).sin()).collect();
        let text: String = times.iter().map(|t| format!("{t:?};{t:?}\n")).collect();
        let (grid, warnings) = read(&text);
        let Grid { start, step, values } = grid.unwrap();
        assert!(warnings[0].contains("interpolated"), "{warnings:?}");
        for (k, value) in values.iter().enumerate().take(199).skip(1) {
            assert!((value - (start + step * k as f64)).abs() < 1e-12);
        }
    }

    #[test]
    fn uneven_decreasing_and_long_clocks_are_refused_with_their_line() {
        let (found, _) = read("0;1\n1;1\n2;1\n3.05;1\n4;1\n5;1\n");
        assert!(
            matches!(found, Err(MeasuredError::Uneven { line: 5, jitter, .. }) if (jitter - 0.05).abs() < 1e-9),
            "{found:?}"
        );
        let (found, _) = read("0;1\n1;1\n1;1\n2;1\n");
        assert!(matches!(found, Err(MeasuredError::NotRising { line: 4, .. })), "{found:?}");
        let (found, _) = read("0;1\n1;1\n2;1\n1e12;1\n");
        assert!(matches!(found, Err(MeasuredError::LongGap { line: 5, .. })), "{found:?}");
        let (found, _) = read("0;1\n;1\n2;1\n");
        assert!(matches!(found, Err(MeasuredError::NoAbscissa { line: 3, .. })), "{found:?}");
    }
}
