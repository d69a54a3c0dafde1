//! Window that slides along a solved strip.

use ndarray::Array2;
use thiserror::Error;

use asperity_base::map::Grid;
use asperity_base::sentence;

/// Reason why a window does not fit its strip.
#[derive(Debug, Clone, PartialEq, Error)]
#[non_exhaustive]
pub enum WindowError {
    /// The window is not longer than a cell.
    #[error("the window is {} long, the cells {}; a window contains at least two cells", metre(*window_m), metre(*cell_m))]
    TooShort {
        /// Length of the window in metre.
        window_m: f64,
        /// Length of a cell in metre.
        cell_m: f64,
    },
    /// The strip contains too few independent windows.
    #[error("the strip is {} long, the window {}; a strip contains at least ten windows", metre(*strip_m), metre(*window_m))]
    TooLong {
        /// Length of the window in metre.
        window_m: f64,
        /// Length of the strip in metre.
        strip_m: f64,
    },
    /// The window is not wider than a cell.
    #[error("the window is {} wide, the cells {}; a window is at least two cells wide", metre(*window_m), metre(*cell_m))]
    TooNarrow {
        /// Width of the window in metre.
        window_m: f64,
        /// Width of a cell in metre.
        cell_m: f64,
    },
    /// The window is wider than the strip.
    #[error("the window is {} wide, the strip {}; a window is at most as wide as the strip", metre(*window_m), metre(*strip_m))]
    TooWide {
        /// Width of the window in metre.
        window_m: f64,
        /// Width of the strip in metre.
        strip_m: f64,
    },
    /// The window has too many cells.
    #[error("the window has {cells} × {rows} cells; a window has at most {MAX_CELLS} cells")]
    TooManyCells {
        /// Number of cells along x.
        cells: usize,
        /// Number of cells along y.
        rows: usize,
    },
    /// The mask of the window has no cell.
    #[error("the mask of the window has no cell")]
    Empty,
}

/// Largest number of cells of a window, 8192². A strip of ten such windows needs more than a hundred gigabytes to be solved.
const MAX_CELLS: usize = 1 << 26;

fn metre(length_m: f64) -> String {
    sentence::si(length_m, "m")
}

/// Cells `start..end` of one row of a window.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct Run {
    pub(super) row: usize,
    pub(super) start: usize,
    pub(super) end: usize,
}

/// A set of cells that moves along x in steps of a sixteenth of its length, but at least one cell.
///
/// On a periodic strip, as many windows as fit lie side by side on *tracks*, evenly spaced. On a free strip, whose
/// sides are loaded edges, there is one track in the middle. Tracks have no cell in common. Neighbouring tracks are
/// correlated like the heights, and all tracks belong to one strip.
#[derive(Debug, Clone, PartialEq)]
pub struct Window {
    /// Cells along x and along y, and cells of the strip along y.
    cells: usize,
    rows: usize,
    strip_rows: usize,
    step_cells: usize,
    /// Size of a cell along x and along y.
    cell_m: f64,
    row_m: f64,
    runs: Vec<Run>,
}

impl Window {
    /// Creates a rectangle of about `length_m` (rounded to whole cells) and of the whole width of strips of `grid`. It
    /// moves by a sixteenth of its length, rounded down to whole cells.
    ///
    /// # Errors
    /// The window has fewer than two cells, or the strip is shorter than ten windows.
    pub fn new(length_m: f64, grid: Grid) -> Result<Self, WindowError> {
        let (cells, rows) = counted(cells_along(length_m, grid)?, grid.ny())?;
        Ok(Self::box_of(cells, rows, grid))
    }

    /// Creates a rectangle of about `length_m` × `width_m`, rounded to whole cells.
    ///
    /// # Errors
    /// The errors of [`Window::new`]; also if the window is wider than the strip or less than two cells wide.
    pub fn rectangle(length_m: f64, width_m: f64, grid: Grid) -> Result<Self, WindowError> {
        let (cells, rows) = counted(cells_along(length_m, grid)?, rows_across(width_m, grid)?)?;
        Ok(Self::box_of(cells, rows, grid))
    }

    /// Creates an ellipse of the axes `length_m` along x and `width_m` along y: the cells whose centre lies in it.
    ///
    /// # Errors
    /// The errors of [`Window::rectangle`].
    pub fn ellipse(length_m: f64, width_m: f64, grid: Grid) -> Result<Self, WindowError> {
        let (cells, rows) = counted(cells_along(length_m, grid)?, rows_across(width_m, grid)?)?;
        let mask = Array2::from_shape_fn((rows, cells), |(row, column)| {
            let from_centre = |index: usize, count: usize| (2 * index + 1) as f64 / count as f64 - 1.0;
            from_centre(row, rows).powi(2) + from_centre(column, cells).powi(2) <= 1.0
        });
        Ok(Self { runs: runs_of(&mask), ..Self::box_of(cells, rows, grid) })
    }

    /// Creates a window of any set of cells: those that are true in `mask`, of shape [rows, cells], on strips of `grid`.
    ///
    /// # Errors
    /// The errors of [`Window::rectangle`] with the size of the mask, or no cell is true.
    pub fn from_mask(mask: &Array2<bool>, grid: Grid) -> Result<Self, WindowError> {
        let (rows, cells) = mask.dim();
        let cells = cells_along(cells as f64 * grid.dx_m(), grid)?;
        let rows = rows_across(rows as f64 * grid.dy_m(), grid)?;
        let runs = runs_of(mask);
        if runs.is_empty() { Err(WindowError::Empty) } else { Ok(Self { runs, ..Self::box_of(cells, rows, grid) }) }
    }

    fn box_of(cells: usize, rows: usize, grid: Grid) -> Self {
        let (cell_m, row_m) = (grid.dx_m(), grid.dy_m());
        let runs = (0..rows).map(|row| Run { row, start: 0, end: cells }).collect();
        Self { cells, rows, strip_rows: grid.ny(), step_cells: (cells / 16).max(1), cell_m, row_m, runs }
    }

    /// Returns rectangles of a half, a quarter and an eighth of the cells along x and of the same width, as long as
    /// they contain at least four cells along x, for the window study. The window study needs the correlation of a
    /// rectangle. So for a window of another shape the first entry is the rectangle of its whole length.
    pub fn narrower(&self) -> Vec<Self> {
        let whole = if self.is_rectangle() { None } else { Some(self.cells) };
        let parts = [2, 4, 8].map(|part| self.cells / part).into_iter().filter(|cells| *cells >= 4);
        whole
            .into_iter()
            .chain(parts)
            .map(|cells| Self {
                cells,
                step_cells: (cells / 16).max(1),
                runs: (0..self.rows).map(|row| Run { row, start: 0, end: cells }).collect(),
                ..*self
            })
            .collect()
    }

    /// Returns whether every cell within its length and width belongs to it.
    pub fn is_rectangle(&self) -> bool {
        self.runs.len() == self.rows && self.runs.iter().all(|run| run.start == 0 && run.end == self.cells)
    }

    /// Returns the length in metre.
    pub fn length_m(&self) -> f64 {
        self.cells as f64 * self.cell_m
    }

    /// Returns the width in metre.
    pub fn width_m(&self) -> f64 {
        self.rows as f64 * self.row_m
    }

    /// Returns the area of its cells in square metre.
    pub fn area_m2(&self) -> f64 {
        let cells: usize = self.runs.iter().map(|run| run.end - run.start).sum();
        cells as f64 * self.cell_m * self.row_m
    }

    /// Returns the length of a cell along x in metre.
    pub fn cell_m(&self) -> f64 {
        self.cell_m
    }

    /// Returns the number of cells along x.
    pub fn cells(&self) -> usize {
        self.cells
    }

    /// Returns the number of cells along y.
    pub fn rows(&self) -> usize {
        self.rows
    }

    /// Returns the distance between neighbouring positions in metre.
    pub fn step_m(&self) -> f64 {
        self.step_cells as f64 * self.cell_m
    }

    /// Returns a mask of shape [rows, cells] that is true for the cells of the window.
    pub fn mask(&self) -> Array2<bool> {
        let mut mask = Array2::from_elem((self.rows, self.cells), false);
        for run in &self.runs {
            (run.start..run.end).for_each(|column| mask[[run.row, column]] = true);
        }
        mask
    }

    /// Returns the first rows of the tracks on a strip.
    pub fn tracks(&self, periodic: bool) -> Vec<usize> {
        if !periodic {
            return vec![(self.strip_rows - self.rows) / 2];
        }
        let count = self.strip_rows / self.rows;
        (0..count).map(|track| track * self.strip_rows / count).collect()
    }

    /// Returns its cells as runs of rows.
    pub(super) fn runs(&self) -> &[Run] {
        &self.runs
    }

    /// Returns whether the window belongs to strips of a grid.
    pub(super) fn fits(&self, grid: Grid) -> bool {
        grid.ny() == self.strip_rows && grid.dx_m() == self.cell_m
    }

    /// Returns whether sums over whole columns suffice.
    pub(super) fn spans_columns(&self) -> bool {
        self.rows == self.strip_rows && self.is_rectangle()
    }

    /// Returns the first columns of the positions on a strip of `grid`.
    pub(super) fn starts(&self, grid: Grid, periodic: bool) -> Vec<usize> {
        if periodic {
            return (0..grid.nx()).step_by(self.step_cells).collect();
        }
        // Rounding of the pitches must not remove a cell.
        let margin = (grid.height_m() / grid.dx_m() * (1.0 - 1e-9)).ceil() as usize;
        (margin..(grid.nx() + 1).saturating_sub(self.cells + margin)).step_by(self.step_cells).collect()
    }
}

/// Returns the number of cells of a window along x, if it fits.
fn cells_along(length_m: f64, grid: Grid) -> Result<usize, WindowError> {
    let cells = (length_m / grid.dx_m()).round();
    if cells.is_nan() || cells < 2.0 {
        return Err(WindowError::TooShort { window_m: length_m, cell_m: grid.dx_m() });
    }
    // Rounding to whole cells may shorten the tenth window by a fraction.
    if 10.0 * length_m > grid.width_m() * (1.0 + 1e-9) {
        return Err(WindowError::TooLong { window_m: length_m, strip_m: grid.width_m() });
    }
    Ok(cells as usize)
}

/// Returns the number of cells of a window along y, if it fits.
fn rows_across(width_m: f64, grid: Grid) -> Result<usize, WindowError> {
    let rows = (width_m / grid.dy_m()).round();
    if rows.is_nan() || rows < 2.0 {
        return Err(WindowError::TooNarrow { window_m: width_m, cell_m: grid.dy_m() });
    }
    if width_m > grid.height_m() * (1.0 + 1e-9) {
        return Err(WindowError::TooWide { window_m: width_m, strip_m: grid.height_m() });
    }
    Ok(rows as usize)
}

/// Returns the numbers of cells of a window unless there are too many.
fn counted(cells: usize, rows: usize) -> Result<(usize, usize), WindowError> {
    match cells.checked_mul(rows) {
        Some(count) if count <= MAX_CELLS => Ok((cells, rows)),
        _ => Err(WindowError::TooManyCells { cells, rows }),
    }
}

/// Returns the rows of a mask as runs of cells.
fn runs_of(mask: &Array2<bool>) -> Vec<Run> {
    let mut runs = Vec::new();
    for (row, cells) in mask.rows().into_iter().enumerate() {
        let mut start = None;
        for (column, inside) in cells.iter().copied().chain([false]).enumerate() {
            match (start, inside) {
                (None, true) => start = Some(column),
                (Some(first), false) => {
                    runs.push(Run { row, start: first, end: column });
                    start = None;
                }
                _ => {}
            }
        }
    }
    runs
}

#[cfg(test)]
mod tests {
    use std::f64::consts::FRAC_PI_4;

    use super::*;

    fn grid() -> Grid {
        Grid::new(200, 40, 2e-6, 1e-6).unwrap()
    }

    #[test]
    fn an_ellipse_covers_its_area_symmetrically() {
        let window = Window::ellipse(40e-6, 20e-6, grid()).unwrap();
        let mask = window.mask();
        assert_eq!((mask.dim(), window.is_rectangle()), ((20, 20), false));
        for ((row, column), inside) in mask.indexed_iter() {
            assert_eq!(*inside, mask[[19 - row, column]]);
            assert_eq!(*inside, mask[[row, 19 - column]]);
        }
        // A circle of radius 10 cells contains its area except for part of a ring of cells: the error of Gauss' circle
        // problem.
        assert!((window.area_m2() / (FRAC_PI_4 * 40e-6 * 20e-6) - 1.0).abs() < 0.02);
        let lengths: Vec<usize> = window.narrower().iter().map(Window::cells).collect();
        assert_eq!(lengths, [20, 10, 5]);
        assert!(window.narrower().iter().all(|part| part.is_rectangle() && part.rows() == 20));
    }

    #[test]
    fn tracks_lie_side_by_side_on_periodic_strips_and_in_the_middle_of_free_ones() {
        let tracks = |width_m, periodic| Window::rectangle(40e-6, width_m, grid()).unwrap().tracks(periodic);
        assert_eq!(tracks(40e-6, true), [0]);
        assert_eq!(tracks(40e-6, false), [0]);
        assert_eq!(tracks(10e-6, true), [0, 10, 20, 30]);
        assert_eq!(tracks(12e-6, true), [0, 13, 26]);
        assert_eq!(tracks(12e-6, false), [14]);
    }

    #[test]
    fn windows_that_do_not_fit_are_refused() {
        assert!(matches!(Window::rectangle(40e-6, 41e-6, grid()), Err(WindowError::TooWide { .. })));
        // Such sizes fit no memory, and their product no integer.
        let huge = Grid::new(usize::MAX >> 2, usize::MAX >> 2, 1.0, 1.0).unwrap();
        let (length_m, width_m) = (huge.width_m() / 20.0, huge.height_m() / 2.0);
        let windows = [
            Window::new(length_m, huge),
            Window::rectangle(length_m, width_m, huge),
            Window::ellipse(length_m, width_m, huge),
        ];
        for window in windows {
            assert!(matches!(window, Err(WindowError::TooManyCells { .. })));
        }
        assert!(matches!(Window::ellipse(40e-6, 1e-6, grid()), Err(WindowError::TooNarrow { .. })));
        assert!(matches!(Window::rectangle(41e-6, 20e-6, grid()), Err(WindowError::TooLong { .. })));
        let mask = Array2::from_elem((4, 5), false);
        assert_eq!(Window::from_mask(&mask, grid()), Err(WindowError::Empty));
        let ring = Array2::from_shape_fn((4, 5), |(row, column)| row % 3 == 0 || column % 4 == 0);
        let window = Window::from_mask(&ring, grid()).unwrap();
        assert_eq!((window.mask(), window.runs.len()), (ring, 6));
        assert!((window.area_m2() - 14.0 * 2e-12).abs() < 1e-20);
    }
}
