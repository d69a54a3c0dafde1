//! Real contact area on a grid, corrected for the bias of counting cells.

use std::f64::consts::{FRAC_1_SQRT_2, FRAC_PI_2};

use ndarray::Array2;

use crate::{Boundary, Solution};

/// Weight of the edges of elastic contact on a free and on a periodic half-space: counted cells exceed the area by this fraction of a cell
/// per edge.
///
/// Measured on Hertz contacts (6 to 96 cells across, mean over positions of the summit), where it is the same on all grids, because the
/// pressure near an edge is always K√d. The two half-spaces differ because the pressure of a cell is uniform on one and a sum of waves on
/// the other. (π − 1 + ln 2)/24 = 0.118 for cells that are cut by a random line is too much for cells that carry load.
const EDGE_WEIGHTS: [f64; 2] = [0.0895, 0.1005];

/// Slope of the overlap inside over that of the gap outside, below which the edge of a spot at the hardness is elastic, and above
/// which it is plastic. On planes the two slopes are equal if there is no elastic ring between.
const SLOPES: [f64; 2] = [0.5, 0.85];

/// πE*s/2H of an edge with the slope s of the gap, below which the ratio of slopes decides, and above which the edge is plastic: the
/// pressure falls from H to 0 over a ring whose width decreases as e^(−πE*s/2H), below a hundredth of the spot.
const STEEPNESS: [f64; 2] = [4.0, 8.0];

/// The four neighbours that share an edge, and the four that share a corner.
const AROUND: [(isize, isize); 8] = [(0, 1), (0, -1), (1, 0), (-1, 0), (1, 1), (1, -1), (-1, 1), (-1, -1)];

/// Returns 0 below a range, 1 above it, and a fraction in it.
fn between(value: f64, [low, high]: [f64; 2]) -> f64 {
    ((value - low) / (high - low)).clamp(0.0, 1.0)
}

impl Solution {
    /// Returns the contact area of every cell in units of its own area. Their sum converges faster with the pitch than
    /// the number of cells in contact, because the cells at the edge of a contact are only partly in contact:
    ///
    /// - An elastic edge between a cell in contact and one without takes 0.0895 of a cell, or 0.1005 on a periodic patch. The cells on both
    ///   sides share this, so that the area of a cell without contact is negative. With unequal pitches each edge weighs dx·dy.
    /// - A cell at its hardness H is whole. A cell with 0 < p < H at the rim of plastic contact, where the pressure is H, has
    ///   the area p/H.
    /// - Between plastic and elastic contact the pressure falls from H to 0 over a ring that may be narrower than a cell. Its width
    ///   decreases as e^(−πE*s/2H) with the slope s of the gap outside, and the overlap inside rises less than the gap. A rim
    ///   is plastic as far as one of the two says so.
    ///
    /// On a periodic patch opposite borders are neighbours; the border of a free patch is no edge.
    ///
    /// # References
    /// Correction by the length of edges: V. A. Yastrebov, G. Anciaux and J.-F. Molinari, *Tribology International* **114**
    /// (2017) 161, <https://doi.org/10.1016/j.triboint.2017.04.023>, whose weight is (π−1+ln 2)/24 for another contact
    /// condition.
    pub fn cell_contact_areas(&self) -> Array2<f64> {
        let shares = Array2::from_shape_fn(self.pressure_pa.dim(), |cell| self.elastic_share(cell));
        let touches = |cell: (usize, usize)| self.pressure_pa[cell] > 0.0;
        let half_weight = 0.5 * EDGE_WEIGHTS[usize::from(self.is_periodic())];
        Array2::from_shape_fn(self.pressure_pa.dim(), |cell| {
            let beside = || AROUND[..4].iter().filter_map(|step| self.neighbour(cell, *step));
            if !touches(cell) {
                return -half_weight * beside().map(|other| shares[other]).sum::<f64>();
            }
            let plastic = self.hardness_pa.map_or(1.0, |hardness_pa| self.pressure_pa[cell] / hardness_pa);
            let edges = beside().filter(|other| !touches(*other)).count() as f64;
            (1.0 - shares[cell]) * plastic + shares[cell] * (1.0 - half_weight * edges)
        })
    }

    /// Returns the contact area over the nominal area: the mean of [`Solution::cell_contact_areas`].
    pub fn corrected_contact_fraction(&self) -> f64 {
        self.cell_contact_areas().sum() / self.grid.points() as f64
    }

    /// Returns how much of a cell's contact is elastic: 0 at the hardness and without contact, 1 elsewhere but at rims.
    fn elastic_share(&self, cell: (usize, usize)) -> f64 {
        let Some(hardness_pa) = self.hardness_pa.filter(|_| self.pressure_pa[cell] > 0.0) else {
            return f64::from(self.pressure_pa[cell] > 0.0);
        };
        if self.is_plastic(cell) {
            return 0.0;
        }
        // Mean overlap of the neighbours inside, and mean gap of those outside, per pitch.
        let (mut inside, mut outside) = ((0.0, 0.0), (0.0, 0.0));
        for (place, step) in AROUND.into_iter().enumerate() {
            let Some(other) = self.neighbour(cell, step) else { continue };
            let per_pitch = if place < 4 { 1.0 } else { FRAC_1_SQRT_2 };
            if self.is_plastic(other) {
                inside = (inside.0 + per_pitch * self.plastic_displacement_at_m(other), inside.1 + 1.0);
            } else if self.pressure_pa[other] == 0.0 {
                outside = (outside.0 + per_pitch * self.gap_at_m(other), outside.1 + 1.0);
            }
        }
        if outside.1 == 0.0 {
            return 1.0;
        }
        // A rim that is plastic ends at p/H of the cell: half a pitch and this from the cell inside.
        let end = self.pressure_pa[cell] / hardness_pa;
        let outward = outside.0 / outside.1 / (1.5 - end);
        let pitch_m = (self.grid.dx_m() * self.grid.dy_m()).sqrt();
        let steepness = FRAC_PI_2 * self.modulus_pa / hardness_pa * outward / pitch_m;
        let inward = if inside.1 > 0.0 { inside.0 / inside.1 / (0.5 + end) } else { 0.0 };
        let plastic = between(steepness, STEEPNESS).max(between(inward, SLOPES.map(|ratio| ratio * outward)));
        if plastic.is_nan() { 1.0 } else { 1.0 - plastic }
    }

    fn is_periodic(&self) -> bool {
        matches!(self.boundary, Boundary::Periodic { .. })
    }

    /// Returns the cell that is `step` rows and columns from another; `None` beyond a free border.
    fn neighbour(&self, cell: (usize, usize), step: (isize, isize)) -> Option<(usize, usize)> {
        let wrap = self.is_periodic();
        let (ny, nx) = self.pressure_pa.dim();
        let along = |at: usize, step: isize, count: usize| match at.checked_add_signed(step) {
            Some(to) if to < count => Some(to),
            _ => wrap.then(|| (at as isize + step).rem_euclid(count as isize) as usize),
        };
        Some((along(cell.0, step.0, ny)?, along(cell.1, step.1, nx)?))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{Residual, SolverStop};
    use asperity_base::map::Grid;

    fn solution(pressure_pa: Array2<f64>, signed_gap_m: Array2<f64>, hardness_pa: Option<f64>, wrap: bool) -> Solution {
        let (ny, nx) = pressure_pa.dim();
        Solution {
            grid: Grid::new(nx, ny, 1.0, 1.0).unwrap(),
            boundary: if wrap { Boundary::Periodic { mean_compliance_m_per_pa: 0.0 } } else { Boundary::Free },
            modulus_pa: 1.0,
            hardness_pa,
            displacement_m: Array2::zeros((ny, nx)),
            pressure_pa,
            signed_gap_m,
            plane_m: 0.0,
            mean_height_m: 0.0,
            highest_m: 0.0,
            iterations: 0,
            residual: Residual { frank_wolfe: 0.0, overlap: 0.0, load: 0.0 },
            stop_reason: SolverStop::Converged,
        }
    }

    /// Returns the area in cells without overlap or gap.
    fn area(pressure_pa: &Array2<f64>, hardness_pa: Option<f64>, wrap: bool) -> f64 {
        let gap = Array2::zeros(pressure_pa.dim());
        solution(pressure_pa.clone(), gap, hardness_pa, wrap).cell_contact_areas().sum()
    }

    #[test]
    fn plastic_cells_and_free_borders_have_no_edges_and_periodic_borders_have() {
        let mut p = Array2::zeros((4, 5));
        p.column_mut(0).fill(1.0);
        assert_eq!(area(&p, Some(1.0), true), 4.0);
        assert!((area(&p, None, false) - (4.0 - 4.0 * EDGE_WEIGHTS[0])).abs() < 1e-14);
        assert!((area(&p, None, true) - (4.0 - 8.0 * EDGE_WEIGHTS[1])).abs() < 1e-14);
        assert!((area(&p, Some(2.0), true) - (4.0 - 8.0 * EDGE_WEIGHTS[1])).abs() < 1e-14);
    }

    #[test]
    fn a_single_cell_has_four_edges_and_two_neighbours_have_six() {
        let mut p = Array2::zeros((5, 5));
        p[[2, 2]] = 1.0;
        assert!((area(&p, None, false) - (1.0 - 4.0 * EDGE_WEIGHTS[0])).abs() < 1e-15);
        p[[2, 3]] = 2.0;
        assert!((area(&p, None, true) - (2.0 - 6.0 * EDGE_WEIGHTS[1])).abs() < 1e-15);
    }

    #[test]
    fn on_a_plane_that_enters_a_plastic_body_the_edge_is_where_the_plane_is() {
        // z = x in pitches: p = H for x < e, and the cell that contains e carries its part of H.
        for end in [3.1, 3.5, 3.9] {
            let centre = |column: usize| column as f64 + 0.5;
            let pressure = Array2::from_shape_fn((3, 8), |(_, column)| 7.0 * (end - column as f64).clamp(0.0, 1.0));
            let gap = Array2::from_shape_fn((3, 8), |(_, column)| if column == 3 { 0.0 } else { centre(column) - end });
            let areas = solution(pressure, gap, Some(7.0), false).cell_contact_areas();
            assert!((areas.sum() - 3.0 * end).abs() < 1e-12, "{areas}");
        }
    }

    #[test]
    fn an_overlap_that_rises_less_than_the_gap_makes_the_rim_elastic() {
        let rows = |row: [f64; 5]| Array2::from_shape_fn((3, 5), |(_, column)| row[column]);
        let with_overlap = |overlap: f64| {
            let (pressure, gap) = (rows([7.0, 7.0, 3.5, 0.0, 0.0]), rows([-2.0 * overlap, -overlap, 0.0, 1.0, 2.0]));
            solution(pressure, gap, Some(7.0), false).cell_contact_areas().sum() / 3.0
        };
        let elastic = 3.0 - EDGE_WEIGHTS[0];
        assert!((with_overlap(0.1) - elastic).abs() < 1e-12);
        assert!((with_overlap(1.0) - 2.5).abs() < 1e-12);
        let half = 0.5 * (SLOPES[0] + SLOPES[1]);
        assert!((with_overlap(half) - 0.5 * (elastic + 2.5)).abs() < 1e-12);
    }

    #[test]
    fn a_single_cell_between_steep_gaps_is_plastic() {
        let mut pressure = Array2::zeros((3, 3));
        pressure[[1, 1]] = 3.5;
        let with_gap = |gap: f64| {
            let mut gaps = Array2::from_elem((3, 3), gap);
            gaps[[1, 1]] = 0.0;
            solution(pressure.clone(), gaps, Some(7.0), false).cell_contact_areas().sum()
        };
        assert!((with_gap(1.0) - (1.0 - 4.0 * EDGE_WEIGHTS[0])).abs() < 1e-15);
        assert!((with_gap(100.0) - 0.5).abs() < 1e-15);
    }
}
