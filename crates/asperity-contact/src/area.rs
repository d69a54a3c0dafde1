//! Real contact area on a grid, corrected for the bias of counting cells.

use ndarray::Array2;

use crate::{Boundary, Solution};

/// Weight of the perimeter in the correction of the contact area, (π − 1 + ln 2)/24.
pub const PERIMETER_WEIGHT: f64 = (std::f64::consts::PI - 1.0 + std::f64::consts::LN_2) / 24.0;

/// Returns the contact area in units of cells, corrected for the perimeter: A = A_px − (π−1+ln 2)/24 · S_d Δx.
///
/// A cell counts as contact if p > 0, so cells cut by the edge of a contact count whole. S_d is the length of the
/// edges between contact and non-contact cells. An edge counts only if its contact cell is not at its hardness
/// (`is_plastic`), because such a cell carries load on its whole area. The border of a free patch does not count. On a
/// periodic patch (`wrap`) opposite borders are neighbours. With unequal pitches each edge weighs dx·dy.
fn corrected_cells(pressure_pa: &Array2<f64>, is_plastic: impl Fn((usize, usize)) -> bool, wrap: bool) -> f64 {
    let (ny, nx) = pressure_pa.dim();
    let touches = |p: f64| p > 0.0;
    let mut cells = 0_usize;
    let mut edges = 0_usize;
    let mut edge = |cell: (usize, usize), other: (usize, usize)| {
        let (in_contact, other_too) = (touches(pressure_pa[cell]), touches(pressure_pa[other]));
        if in_contact != other_too && !is_plastic(if in_contact { cell } else { other }) {
            edges += 1;
        }
    };
    for row in 0..ny {
        for column in 0..nx {
            cells += usize::from(touches(pressure_pa[[row, column]]));
            if column + 1 < nx || wrap {
                edge((row, column), (row, (column + 1) % nx));
            }
            if row + 1 < ny || wrap {
                edge((row, column), ((row + 1) % ny, column));
            }
        }
    }
    cells as f64 - PERIMETER_WEIGHT * edges as f64
}

impl Solution {
    /// Returns the contact area over the nominal area, corrected for the perimeter: A = A_px − (π−1+ln 2)/24 · S_d Δx
    /// with the length S_d of the edges between contact and non-contact cells. Edges of cells at their hardness do not
    /// count.
    ///
    /// # References
    /// V. A. Yastrebov, G. Anciaux and J.-F. Molinari, *Tribology International* **114** (2017) 161,
    /// <https://doi.org/10.1016/j.triboint.2017.04.023>.
    pub fn corrected_contact_fraction(&self) -> f64 {
        let wrap = matches!(self.boundary, Boundary::Periodic { .. });
        corrected_cells(&self.pressure_pa, |cell| self.is_plastic(cell), wrap) / self.grid.points() as f64
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Returns the area in cells with one hardness for all of them.
    fn corrected(pressure: &Array2<f64>, hardness: f64, wrap: bool) -> f64 {
        corrected_cells(pressure, |cell| pressure[cell] >= hardness, wrap)
    }

    #[test]
    fn plastic_cells_and_free_borders_have_no_perimeter() {
        let mut p = Array2::zeros((4, 5));
        p.column_mut(0).fill(1.0);
        assert_eq!(corrected(&p, 1.0, true), 4.0);
        let free = corrected(&p, f64::INFINITY, false);
        assert!((free - (4.0 - 4.0 * PERIMETER_WEIGHT)).abs() < 1e-14);
        let periodic = corrected(&p, f64::INFINITY, true);
        assert!((periodic - (4.0 - 8.0 * PERIMETER_WEIGHT)).abs() < 1e-14);
    }

    #[test]
    fn periodic_borders_wrap_and_plastic_cells_have_no_perimeter() {
        use crate::{ContactProblem, Control, HalfSpace, Solver};
        use asperity_base::map::Grid;
        // A ridge of one column at the left border: two lines of edges when periodic, one when free.
        let grid = Grid::new(6, 4, 1.0, 2.0).unwrap();
        let heights = Array2::from_shape_fn((4, 6), |(_, column)| if column == 0 { 1.0 } else { 0.0 });
        let lines = |boundary, hardness| {
            let half_space = HalfSpace::new(grid, 1.0, boundary).unwrap();
            let control = Control::MeanPressure { pascal: 1e-3 };
            let solution = Solver::default()
                .solve(&ContactProblem::new(&half_space, &heights, control, hardness).unwrap())
                .unwrap();
            assert_eq!(solution.contact_fraction(), 4.0 / 24.0);
            (4.0 - 24.0 * solution.corrected_contact_fraction()) / (4.0 * PERIMETER_WEIGHT)
        };
        let periodic = Boundary::Periodic { mean_compliance_m_per_pa: 0.0 };
        assert!((lines(periodic, None) - 2.0).abs() < 1e-12);
        assert!((lines(Boundary::Free, None) - 1.0).abs() < 1e-12);
        // Four cells at the hardness carry exactly this load.
        assert_eq!(lines(periodic, Some(6e-3)), 0.0);
        assert_eq!(lines(Boundary::Free, Some(6e-3)), 0.0);
    }

    #[test]
    fn a_single_cell_has_four_edges_and_two_neighbours_have_six() {
        let mut p = Array2::zeros((5, 5));
        p[[2, 2]] = 1.0;
        assert!((corrected(&p, f64::INFINITY, false) - (1.0 - 4.0 * PERIMETER_WEIGHT)).abs() < 1e-15);
        p[[2, 3]] = 2.0;
        assert!((corrected(&p, f64::INFINITY, true) - (2.0 - 6.0 * PERIMETER_WEIGHT)).abs() < 1e-15);
        // One of the two cells is at the hardness. Only the three edges of the other count.
        assert!((corrected(&p, 2.0, true) - (2.0 - 3.0 * PERIMETER_WEIGHT)).abs() < 1e-15);
    }
}
