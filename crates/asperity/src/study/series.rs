//! Fields of maps, and lines as tables.

use asperity_results::{Field, Table};
use ndarray::Array2;

use crate::map::Grid;

/// Returns the values of a map as a field.
pub(super) fn map_field(grid: Grid, unit: &str, values: Array2<f64>) -> Field {
    Field::new([grid.dx_m(), grid.dy_m()], unit, values)
}

/// Returns the points of numbered lines, with the level of each if lines have levels.
pub(super) fn lines_table<'a>(
    [x, y]: [&str; 2],
    lines: impl Iterator<Item = (f64, &'a Vec<[f64; 2]>)>,
    levels: bool,
) -> Table {
    let mut columns = [(); 4].map(|()| Vec::new());
    for (number, (level, line)) in lines.enumerate() {
        for place in line {
            let row = [level, number as f64, place[0], place[1]];
            columns.iter_mut().zip(row).for_each(|(column, value)| column.push(value));
        }
    }
    let names = ["level", "line", x, y];
    Table::new(names.into_iter().zip(columns).skip(usize::from(!levels)))
}
