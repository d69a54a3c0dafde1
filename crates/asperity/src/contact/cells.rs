//! Lists of cells.
//!
//! Most cells of a rough contact are out of contact and stay so. What concerns those that may move is kept in lists over
//! them alone.

use std::ops::Range;

/// Cells of a grid in row order.
#[derive(Debug, Clone, Default)]
pub(super) struct Cells {
    columns_of_grid: usize,
    /// Places in the grid.
    places: Vec<u32>,
    /// Where the cells of a row begin, with the end of the last one.
    starts: Vec<u32>,
}

impl Cells {
    /// No cells of a grid of `rows` × `columns`.
    pub(super) fn none(rows: usize, columns: usize) -> Self {
        Self { columns_of_grid: columns, places: Vec::new(), starts: vec![0; rows + 1] }
    }

    /// Takes the cells at `places` in their place, which must rise.
    pub(super) fn replace(&mut self, places: impl Iterator<Item = u32>) {
        self.places.clear();
        self.places.extend(places);
        let columns = self.columns_of_grid as u32;
        let mut next = 0;
        for (row, start) in self.starts.iter_mut().enumerate() {
            let end = row as u32 * columns;
            while next < self.places.len() && self.places[next] < end {
                next += 1;
            }
            *start = next as u32;
        }
    }

    /// Places in the grid.
    pub(super) fn places(&self) -> &[u32] {
        &self.places
    }

    /// Where the cells of the rows from `first` up to `end` stand in the list.
    pub(super) fn rows(&self, first: usize, end: usize) -> Range<usize> {
        self.starts[first] as usize..self.starts[end] as usize
    }

    /// Columns of the cells of a row.
    pub(super) fn columns(&self, row: usize) -> impl Iterator<Item = usize> + '_ {
        let offset = row * self.columns_of_grid;
        self.places[self.rows(row, row + 1)].iter().map(move |place| *place as usize - offset)
    }

    /// Writes `factor` times the values of the cells of a row into it; false if it has none.
    pub(super) fn scatter(&self, row: usize, values: &[f64], factor: f64, out: &mut [f32]) -> bool {
        let cells = self.rows(row, row + 1);
        for (column, value) in self.columns(row).zip(&values[cells.clone()]) {
            out[column] = (factor * value) as f32;
        }
        !cells.is_empty()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn cells_stand_row_by_row() {
        let mut cells = Cells::none(4, 3);
        cells.replace([1, 2, 8, 9, 11].into_iter());
        let columns = |row: usize| cells.columns(row).collect::<Vec<_>>();
        assert_eq!((columns(0), columns(1), columns(2), columns(3)), (vec![1, 2], vec![], vec![2], vec![0, 2]));
        assert_eq!((cells.rows(1, 3), cells.places().len()), (2..3, 5));
        let mut row = [0.0; 3];
        assert!(
            cells.scatter(3, &[1.0, 2.0, 3.0, 4.0, 5.0], 0.5, &mut row) && !cells.scatter(1, &[1.0, 2.0], 1.0, &mut row)
        );
        assert_eq!(row, [2.0, 0.0, 2.5]);
        cells.replace(std::iter::empty());
        assert_eq!((cells.places().len(), cells.rows(0, 4)), (0, 0..0));
    }
}
