//! A window that slides along a solved strip.

use thiserror::Error;

use crate::contact::{Boundary, Solution, area::PERIMETER_WEIGHT};
use crate::map::Grid;

/// Why a window does not fit its strip.
#[derive(Debug, Clone, PartialEq, Error)]
pub enum WindowError {
    /// The window is not longer than a cell.
    #[error("the window is {window_m:e} m long, the cells {cell_m:e} m; a window holds at least two cells")]
    TooShort {
        /// Length of the window in metre.
        window_m: f64,
        /// Length of a cell in metre.
        cell_m: f64,
    },
    /// The strip holds too few independent windows.
    #[error("the strip is {strip_m:e} m long, the window {window_m:e} m; the strip must hold at least ten windows")]
    TooLong {
        /// Length of the window in metre.
        window_m: f64,
        /// Length of the strip in metre.
        strip_m: f64,
    },
}

/// Window of whole cells along x and of the whole strip along y, moved along x by at most an eighth of its length.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Window {
    cells: usize,
    step_cells: usize,
    cell_m: f64,
}

impl Window {
    /// A window of about `length_m` (rounded to whole cells) on strips of `grid`, moved by a sixteenth of its length,
    /// rounded down to whole cells.
    ///
    /// # Errors
    /// The window holds fewer than two cells, or the strip fewer than ten windows.
    pub fn new(length_m: f64, grid: Grid) -> Result<Self, WindowError> {
        let cells = (length_m / grid.dx_m()).round();
        if cells.is_nan() || cells < 2.0 {
            return Err(WindowError::TooShort { window_m: length_m, cell_m: grid.dx_m() });
        }
        // Rounding to whole cells may cost a fraction of the tenth window.
        if 10.0 * length_m > grid.width_m() * (1.0 + 1e-9) {
            return Err(WindowError::TooLong { window_m: length_m, strip_m: grid.width_m() });
        }
        let cells = cells as usize;
        Ok(Self { cells, step_cells: (cells / 16).max(1), cell_m: grid.dx_m() })
    }

    /// Windows of a half, a quarter and an eighth of the cells, as far as they hold four.
    pub fn narrower(&self) -> Vec<Self> {
        let halves = [2, 4, 8].map(|part| self.cells / part).into_iter().filter(|cells| *cells >= 4);
        halves.map(|cells| Self { cells, step_cells: (cells / 16).max(1), cell_m: self.cell_m }).collect()
    }

    /// Length in metre.
    pub fn length_m(&self) -> f64 {
        self.cells as f64 * self.cell_m
    }

    /// Cells along x.
    pub fn cells(&self) -> usize {
        self.cells
    }

    /// Distance between neighbouring positions in metre.
    pub fn step_m(&self) -> f64 {
        self.step_cells as f64 * self.cell_m
    }

    /// Positions on a strip of `grid`; on a free one those nearer to an end than the strip is wide are left out.
    fn starts(&self, grid: Grid, periodic: bool) -> Vec<usize> {
        if periodic {
            return (0..grid.nx()).step_by(self.step_cells).collect();
        }
        // Rounding of the pitches must not cost a cell.
        let margin = (grid.height_m() / grid.dx_m() * (1.0 - 1e-9)).ceil() as usize;
        (margin..(grid.nx() + 1).saturating_sub(self.cells + margin)).step_by(self.step_cells).collect()
    }

    /// Contact and load of every position on a solved strip, in the order of sliding.
    ///
    /// On a periodic strip the window wraps around; on a free one, which is a punch with loaded ends, positions nearer to
    /// an end than the strip is wide are left out.
    pub fn slide(&self, solution: &Solution) -> Vec<WindowContact> {
        let grid = solution.grid();
        let columns = ColumnSums::of(solution);
        let periodic = matches!(solution.boundary(), Boundary::Periodic { .. });
        self.starts(grid, periodic).into_iter().map(|start| columns.window(start, self.cells, grid)).collect()
    }
}

/// What a window sees.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct WindowContact {
    /// Position of the centre of the window in metre.
    pub position_m: f64,
    /// Cells with p > 0.
    pub contact_cells: f64,
    /// Contact area in square metre, corrected for the perimeter.
    pub area_m2: f64,
    /// Load in newton.
    pub load_n: f64,
}

/// Contact, perimeter and pressure summed over each column of a strip.
struct ColumnSums {
    contact: Vec<f64>,
    /// Contact/non-contact edges between rows of the column.
    edges_within: Vec<f64>,
    /// The same between the column and the next.
    edges_to_next: Vec<f64>,
    pressure_pa: Vec<f64>,
}

impl ColumnSums {
    fn of(solution: &Solution) -> Self {
        let p = solution.pressure_pa();
        let upper = solution.hardness_pa().unwrap_or(f64::INFINITY);
        let periodic = matches!(solution.boundary(), Boundary::Periodic { .. });
        let (ny, nx) = p.dim();
        let edge = |a: f64, b: f64| f64::from((a > 0.0) != (b > 0.0) && a.max(b) < upper);
        let zeros = || vec![0.0; nx];
        let mut sums = Self { contact: zeros(), edges_within: zeros(), edges_to_next: zeros(), pressure_pa: zeros() };
        for row in 0..ny {
            for column in 0..nx {
                let here = p[[row, column]];
                sums.contact[column] += f64::from(here > 0.0);
                sums.pressure_pa[column] += here;
                if row + 1 < ny || periodic {
                    sums.edges_within[column] += edge(here, p[[(row + 1) % ny, column]]);
                }
                if column + 1 < nx || periodic {
                    sums.edges_to_next[column] += edge(here, p[[row, (column + 1) % nx]]);
                }
            }
        }
        sums
    }

    /// Sums over `cells` columns from `start`. Edges on the window's own ends belong half to it, so that adjoining
    /// windows add up to the whole strip.
    fn window(&self, start: usize, cells: usize, grid: Grid) -> WindowContact {
        let nx = self.contact.len();
        let (mut contact, mut edges, mut pressure_pa) = (0.0, 0.0, 0.0);
        for k in start..start + cells {
            let column = k % nx;
            let previous = (column + nx - 1) % nx;
            contact += self.contact[column];
            pressure_pa += self.pressure_pa[column];
            edges += self.edges_within[column] + 0.5 * (self.edges_to_next[column] + self.edges_to_next[previous]);
        }
        WindowContact {
            position_m: (start as f64 + 0.5 * cells as f64) * grid.dx_m(),
            contact_cells: contact,
            area_m2: (contact - PERIMETER_WEIGHT * edges) * grid.cell_area_m2(),
            load_n: pressure_pa * grid.cell_area_m2(),
        }
    }
}
