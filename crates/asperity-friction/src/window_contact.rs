//! Contact of windows that slide along a solved strip.
//!
//! [`window_contacts`] computes it from sums over the cells of the strip.

use std::ops::{AddAssign, Sub};

use ndarray::Array2;

use crate::window::{Run, Window};
use asperity_base::map::Grid;
use asperity_contact::{Boundary, Solution};

/// Contact in a window.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct WindowContact {
    /// Position of the centre of the window in metre.
    pub position_m: f64,
    /// Number of cells with p > 0.
    pub contact_cells: f64,
    /// Contact area in square metre: the sum over its cells of [`Solution::cell_contact_areas`], so that the areas of
    /// adjoining windows add up.
    pub area_m2: f64,
    /// Least area that carries the load at the hardness, ∫p/H dA, in square metre; 0 without a hardness.
    pub least_area_m2: f64,
    /// Load in newton.
    pub load_n: f64,
    /// ∫p|∂z/∂x| dA over the cells with p = H, in newton; 0 if the friction law does not use it.
    pub ploughing_n: f64,
}

impl WindowContact {
    /// Returns whether the window carries load.
    pub fn loaded(&self) -> bool {
        self.load_n > 0.0
    }

    /// Returns the corrected contact area in square metre, but at least the area that carries the load at the hardness.
    /// The two are equal if all contact is plastic. For a few small contacts the correction of elastic edges may exceed
    /// the contact area.
    pub fn bearing_area_m2(&self) -> f64 {
        self.area_m2.max(self.least_area_m2)
    }
}

/// Computes the contact of windows that slide along a solved strip: of each window by track and position, in the order of
/// sliding.
///
/// On a periodic strip a window wraps around. A free strip is a punch with loaded ends; positions nearer to an end than the
/// strip is wide are left out. The undeformed heights of the strip, in metre, are required for
/// [`WindowContact::ploughing_n`] only, which is 0 without them.
///
/// # Panics
/// If a window belongs to strips of another grid, or the heights do not have the shape of the solution.
pub fn window_contacts(
    solution: &Solution,
    windows: &[&Window],
    ploughing_heights_m: Option<&Array2<f64>>,
) -> Vec<Vec<Vec<WindowContact>>> {
    let sums = StripSums::new(solution, ploughing_heights_m, windows);
    windows.iter().map(|window| sums.slide(window)).collect()
}

/// Prefix sums along x of the window sums: of every row or, if all windows span the strip, of whole columns.
///
/// A window is a set of runs of cells, and each run is the difference of two prefixes.
#[derive(Debug, Clone)]
struct StripSums {
    grid: Grid,
    hardness_pa: Option<f64>,
    periodic: bool,
    /// Whether the sums are over whole columns.
    of_columns: bool,
    /// Prefixes, nx + 1 per row.
    prefixes: Vec<Tally>,
}

/// Sums over cells.
#[derive(Debug, Clone, Copy, Default)]
struct Tally {
    /// Number of cells with p > 0.
    contact: f64,
    /// Contact area in cells.
    area: f64,
    pressure_pa: f64,
    /// Sum of p|∂z/∂x| where p = H.
    ploughing_pa: f64,
}

impl AddAssign for Tally {
    fn add_assign(&mut self, other: Self) {
        self.contact += other.contact;
        self.area += other.area;
        self.pressure_pa += other.pressure_pa;
        self.ploughing_pa += other.ploughing_pa;
    }
}

impl Sub for Tally {
    type Output = Self;

    fn sub(self, other: Self) -> Self {
        Self {
            contact: self.contact - other.contact,
            area: self.area - other.area,
            pressure_pa: self.pressure_pa - other.pressure_pa,
            ploughing_pa: self.ploughing_pa - other.ploughing_pa,
        }
    }
}

impl StripSums {
    /// Computes the sums that `windows` need on a solved strip; see [`window_contacts`].
    fn new(solution: &Solution, ploughing_heights_m: Option<&Array2<f64>>, windows: &[&Window]) -> Self {
        let p = solution.pressure_pa();
        let (ny, nx) = p.dim();
        assert!(
            ploughing_heights_m.is_none_or(|heights| heights.dim() == (ny, nx)),
            "the heights do not fit the strip"
        );
        let grid = solution.grid();
        let periodic = matches!(solution.boundary(), Boundary::Periodic { .. });
        let of_columns = windows.iter().all(|window| window.spans_columns());
        let areas = solution.cell_contact_areas();
        let tally = |cell: (usize, usize)| {
            let pressure_pa = p[cell];
            let ploughed = ploughing_heights_m.filter(|_| solution.is_plastic(cell));
            Tally {
                contact: f64::from(pressure_pa > 0.0),
                area: areas[cell],
                pressure_pa,
                ploughing_pa: ploughed.map_or(0.0, |z| pressure_pa * slope_x(z, cell, grid.dx_m(), periodic).abs()),
            }
        };
        let stride = nx + 1;
        let mut prefixes = vec![Tally::default(); stride * if of_columns { 1 } else { ny }];
        for row in 0..ny {
            let sums = if of_columns { &mut prefixes[..] } else { &mut prefixes[row * stride..][..stride] };
            for column in 0..nx {
                sums[column + 1] += tally((row, column));
            }
        }
        for sums in prefixes.chunks_mut(stride) {
            for column in 0..nx {
                let before = sums[column];
                sums[column + 1] += before;
            }
        }
        Self { grid, hardness_pa: solution.hardness_pa(), periodic, of_columns, prefixes }
    }

    /// Computes the contact of every position of a window, track by track.
    fn slide(&self, window: &Window) -> Vec<Vec<WindowContact>> {
        assert!(window.fits(self.grid), "the window belongs to another strip");
        let runs = if self.of_columns { &window.runs()[..1] } else { window.runs() };
        let starts = window.starts(self.grid, self.periodic);
        let centre_m = |start: usize| (start as f64 + 0.5 * window.cells() as f64) * window.cell_m();
        window
            .tracks(self.periodic)
            .into_iter()
            .map(|track| starts.iter().map(|&start| self.window(runs, track, start, centre_m(start))).collect())
            .collect()
    }

    /// Computes the contact in a window of these runs with first row `track` and first column `start`.
    fn window(&self, runs: &[Run], track: usize, start: usize, position_m: f64) -> WindowContact {
        let (nx, stride) = (self.grid.nx(), self.grid.nx() + 1);
        let rows = self.prefixes.len() / stride;
        let mut sum = Tally::default();
        for run in runs {
            let prefix = &self.prefixes[(track + run.row) % rows * stride..][..stride];
            let (first, end) = (start + run.start, start + run.end);
            match (first / nx, (end - 1) / nx) {
                (a, b) if a == b => sum += prefix[end - b * nx] - prefix[first - a * nx],
                (a, b) => {
                    sum += prefix[nx] - prefix[first - a * nx];
                    sum += prefix[end - b * nx];
                }
            }
        }
        let cell_m2 = self.grid.cell_area_m2();
        WindowContact {
            position_m,
            contact_cells: sum.contact,
            area_m2: sum.area * cell_m2,
            least_area_m2: self.hardness_pa.map_or(0.0, |hardness_pa| sum.pressure_pa * cell_m2 / hardness_pa),
            load_n: sum.pressure_pa * cell_m2,
            ploughing_n: sum.ploughing_pa * cell_m2,
        }
    }
}

/// Returns ∂z/∂x of a cell by central differences; one-sided at the ends of a free strip.
fn slope_x(heights_m: &Array2<f64>, (row, column): (usize, usize), dx_m: f64, periodic: bool) -> f64 {
    let nx = heights_m.ncols();
    let (before, after) = if periodic {
        ((column + nx - 1) % nx, (column + 1) % nx)
    } else {
        (column.saturating_sub(1), (column + 1).min(nx - 1))
    };
    let apart = if periodic { 2 } else { after - before };
    (heights_m[[row, after]] - heights_m[[row, before]]) / (apart as f64 * dx_m)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn slopes_are_exact_on_parabolas_inside_and_on_lines_at_free_ends() {
        let parabola = Array2::from_shape_fn((1, 6), |(_, column)| (column as f64 * 0.5).powi(2));
        for column in 1..5 {
            for periodic in [false, true] {
                assert!((slope_x(&parabola, (0, column), 0.5, periodic) - column as f64).abs() < 1e-14);
            }
        }
        let line = Array2::from_shape_fn((1, 6), |(_, column)| 3.0 * column as f64);
        assert_eq!([slope_x(&line, (0, 0), 1.0, false), slope_x(&line, (0, 5), 1.0, false)], [3.0, 3.0]);
        // On a periodic strip the line drops by five steps at the end.
        assert_eq!(slope_x(&line, (0, 0), 1.0, true), (3.0 - 15.0) / 2.0);
    }
}
