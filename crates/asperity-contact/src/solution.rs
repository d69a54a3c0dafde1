//! Solution of a contact problem, with its residuals.

use ndarray::Array2;

use crate::conditions::Closure;
use crate::slab::Part;
use crate::{Boundary, ContactProblem};
use asperity_base::map::Grid;

/// Reason why a solver stopped.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum SolverStop {
    /// All residuals, recomputed from the pressure, are below the tolerance.
    Converged,
    /// No further descent can be represented in double precision.
    PrecisionLimit,
    /// The iteration limit was reached.
    IterationLimit,
    /// The [`Monitor`](asperity_base::monitor::Monitor) cancelled the solve.
    Cancelled,
}

/// Normalised violations of the optimality conditions, computed from the pressure alone.
///
/// Notation: v = S p − z, plane height d, gap g = v + d, standard deviation h_rms of the heights.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Residual {
    /// Σ p·max(g′, 0) / (Σ p · h_rms): a bound on the energy gap (Frank–Wolfe). g′ is the gap if the plane is
    /// prescribed or searched for a mean gap. Otherwise g′ is v counted from its least value over cells with p < H.
    pub frank_wolfe: f64,
    /// Largest overlap −g over cells with p < H, divided by h_rms.
    pub overlap: f64,
    /// |mean(p)/p̄ − 1| if a load is prescribed; relative error of the mean gap if that is prescribed.
    pub load: f64,
}

impl Residual {
    /// Returns the largest of the three; NaN if one is NaN.
    pub fn worst(&self) -> f64 {
        let worse = |a: f64, b: f64| if a > b || a.is_nan() { a } else { b };
        worse(self.frank_wolfe, worse(self.overlap, self.load))
    }
}

/// A solved contact: fields of shape `[ny, nx]`, row 0 at the top.
#[derive(Debug, Clone)]
pub struct Solution {
    pub(super) grid: Grid,
    pub(super) boundary: Boundary,
    /// Contact modulus E* at the surface.
    pub(super) modulus_pa: f64,
    pub(super) hardness_pa: Option<f64>,
    pub(super) pressure_pa: Array2<f64>,
    pub(super) displacement_m: Array2<f64>,
    pub(super) signed_gap_m: Array2<f64>,
    pub(super) plane_m: f64,
    pub(super) mean_height_m: f64,
    pub(super) highest_m: f64,
    pub(super) iterations: usize,
    pub(super) residual: Residual,
    pub(super) stop_reason: SolverStop,
}

impl Solution {
    /// Returns the grid.
    pub fn grid(&self) -> Grid {
        self.grid
    }

    /// Returns the condition beyond the edge of the grid.
    pub fn boundary(&self) -> Boundary {
        self.boundary
    }

    /// Hardness in pascal, the upper bound of the pressure, if there is one.
    pub fn hardness_pa(&self) -> Option<f64> {
        self.hardness_pa
    }

    /// Returns the normal pressure in pascal, ≥ 0 in compression.
    pub fn pressure_pa(&self) -> &Array2<f64> {
        &self.pressure_pa
    }

    /// Returns the elastic displacement u = S p in metre, positive away from the flat.
    pub fn displacement_m(&self) -> &Array2<f64> {
        &self.displacement_m
    }

    /// Returns the pressure and the elastic displacement without a copy.
    pub fn into_fields(self) -> (Array2<f64>, Array2<f64>) {
        (self.pressure_pa, self.displacement_m)
    }

    /// Returns the distance between the deformed surface and the plane in metre: ≥ 0, and 0 in elastic and in plastic
    /// contact.
    pub fn gap_m(&self) -> Array2<f64> {
        Array2::from_shape_fn(self.pressure_pa.dim(), |cell| self.gap_at_m(cell))
    }

    /// Returns the plastic displacement in metre: the overlap that elastic deformation alone leaves where p = H; 0
    /// elsewhere.
    pub fn plastic_displacement_m(&self) -> Array2<f64> {
        Array2::from_shape_fn(self.pressure_pa.dim(), |cell| self.plastic_displacement_at_m(cell))
    }

    /// Returns [`Solution::gap_m`] of the cell (row, column).
    pub fn gap_at_m(&self, cell: (usize, usize)) -> f64 {
        if self.pressure_pa[cell] > 0.0 { 0.0 } else { self.signed_gap_m[cell].max(0.0) }
    }

    /// Returns [`Solution::plastic_displacement_m`] of the cell (row, column).
    pub fn plastic_displacement_at_m(&self, cell: (usize, usize)) -> f64 {
        if self.is_plastic(cell) { (-self.signed_gap_m[cell]).max(0.0) } else { 0.0 }
    }

    /// Returns whether p = H in the cell (row, column).
    pub fn is_plastic(&self, cell: (usize, usize)) -> bool {
        self.hardness_pa.is_some_and(|hardness_pa| self.pressure_pa[cell] >= hardness_pa)
    }

    /// Returns the fraction of all cells with p > 0. Counting cells overestimates the area; see
    /// [`Solution::corrected_contact_fraction`].
    pub fn contact_fraction(&self) -> f64 {
        self.pressure_pa.iter().filter(|p| **p > 0.0).count() as f64 / self.grid.points() as f64
    }

    /// Returns the fraction of all cells with p = H.
    pub fn plastic_fraction(&self) -> f64 {
        let plastic = self.pressure_pa.indexed_iter().filter(|(cell, _)| self.is_plastic(*cell)).count();
        plastic as f64 / self.grid.points() as f64
    }

    /// Returns the mean pressure over all cells in pascal.
    pub fn mean_pressure_pa(&self) -> f64 {
        self.pressure_pa.sum() / self.grid.points() as f64
    }

    /// Returns the load on the patch in newton.
    pub fn load_n(&self) -> f64 {
        self.pressure_pa.sum() * self.grid.cell_area_m2()
    }

    /// Returns the highest pressure in pascal.
    pub fn max_pressure_pa(&self) -> f64 {
        self.pressure_pa.iter().copied().fold(0.0, f64::max)
    }

    /// Returns the mean gap in metre over all cells.
    pub fn mean_gap_m(&self) -> f64 {
        self.gap_m().sum() / self.grid.points() as f64
    }

    /// Returns the height of the plane in the coordinates of the map, in metre.
    pub fn plane_m(&self) -> f64 {
        self.plane_m
    }

    /// Returns the height of the plane above the mean of the undeformed heights, in metre.
    pub fn separation_m(&self) -> f64 {
        self.plane_m - self.mean_height_m
    }

    /// Returns the depth of the plane below the highest undeformed point, in metre.
    pub fn penetration_m(&self) -> f64 {
        self.highest_m - self.plane_m
    }

    /// Iterations of the solver.
    pub fn iterations(&self) -> usize {
        self.iterations
    }

    /// Returns the residuals, recomputed from the final pressure.
    pub fn residual(&self) -> Residual {
        self.residual
    }

    /// Returns the reason why the solver stopped.
    pub fn stop_reason(&self) -> SolverStop {
        self.stop_reason
    }

    /// Returns whether all residuals are below the tolerance.
    pub fn converged(&self) -> bool {
        self.stop_reason == SolverStop::Converged
    }
}

/// Computes the height of the plane above the mean height and the residuals of the pressure `p` from the definitions,
/// with v = S p − z and z counted from the mean height.
///
/// Cells without pressure that are out of contact may be left out; then `gap_sum_m` is the sum of all gaps.
pub(super) fn certify(
    problem: &ContactProblem<'_>,
    closure: Closure,
    parts: &[Part<'_>],
    gap_sum_m: Option<f64>,
) -> (f64, Residual) {
    let rms_height_m = problem.rms_height_m();
    let least = |part: &Part<'_>| {
        part.cells().filter(|(p, _, hardness)| p < hardness).map(|(_, v, _)| v).fold(f64::INFINITY, f64::min)
    };
    let least_v = parts.iter().map(least).fold(f64::INFINITY, f64::min);
    let [sum_p, sum_free, sum_free_v] = sums_of_parts(parts, |p, v, hardness| {
        let free = if p < hardness { p } else { 0.0 };
        [p, free, free * v]
    });
    // The plane is known, or rests on the elastic contact. Without elastic contact it rests on the cell that touches
    // next.
    let resting_m = if sum_free > 0.0 { -sum_free_v / sum_free } else { -least_v };
    let plane_m = closure.plane_m().unwrap_or(resting_m);
    let lambda = if matches!(closure, Closure::Plane { .. }) { -plane_m } else { least_v };
    let [work, gap_sum] = sums_of_parts(parts, |p, v, _| {
        let (apart, gap) = (v - lambda, v + plane_m);
        [if apart > 0.0 { p * apart } else { 0.0 }, if (p <= 0.0) & (gap > 0.0) { gap } else { 0.0 }]
    });
    let frank_wolfe = if sum_p > 0.0 { work / (sum_p * rms_height_m) } else { 0.0 };
    let load = match closure {
        Closure::Plane { .. } => 0.0,
        Closure::Gap { metre } => {
            let mean_gap_m = gap_sum_m.unwrap_or(gap_sum) / problem.heights_m().len() as f64;
            (mean_gap_m / metre - 1.0).abs()
        }
        Closure::Sum { pascal } => (sum_p / pascal - 1.0).abs(),
    };
    // If all cells are at the hardness, none counts as overlapping.
    let overlap = (-(least_v + plane_m)).max(0.0) / rms_height_m;
    (plane_m, Residual { frank_wolfe, overlap, load })
}

/// Sums over all cells, part by part. Rounding errors grow with the number of terms that are added in sequence.
fn sums_of_parts<const K: usize>(parts: &[Part<'_>], term: impl Fn(f64, f64, f64) -> [f64; K]) -> [f64; K] {
    let add = |total: [f64; K], terms: [f64; K]| std::array::from_fn(|k| total[k] + terms[k]);
    let of_part =
        |part: &Part<'_>| part.cells().fold([0.0; K], |total, (p, v, hardness)| add(total, term(p, v, hardness)));
    parts.iter().map(of_part).fold([0.0; K], add)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{Control, HalfSpace};
    use ndarray::array;

    fn solution() -> Solution {
        Solution {
            grid: Grid::new(3, 2, 2.0, 0.5).unwrap(),
            boundary: Boundary::Free,
            modulus_pa: 1.0,
            hardness_pa: Some(4.0),
            pressure_pa: array![[4.0, 1.0, 0.0], [0.0, 4.0, 0.0]],
            displacement_m: Array2::zeros((2, 3)),
            // Overlaps within the tolerance count as zero gap.
            signed_gap_m: array![[-0.5, 1e-12, 3.0], [-1e-12, 0.0, 6.0]],
            plane_m: 10.0,
            mean_height_m: 7.0,
            highest_m: 12.5,
            iterations: 3,
            residual: Residual { frank_wolfe: 1e-9, overlap: 3e-9, load: 2e-9 },
            stop_reason: SolverStop::Converged,
        }
    }

    #[test]
    fn fields_and_sums_follow_their_definitions() {
        let solution = solution();
        assert_eq!(solution.gap_m(), array![[0.0, 0.0, 3.0], [0.0, 0.0, 6.0]]);
        assert_eq!(solution.plastic_displacement_m(), array![[0.5, 0.0, 0.0], [0.0, 0.0, 0.0]]);
        assert_eq!((solution.contact_fraction(), solution.plastic_fraction()), (0.5, 2.0 / 6.0));
        assert_eq!((solution.mean_pressure_pa(), solution.max_pressure_pa(), solution.load_n()), (1.5, 4.0, 9.0));
        assert_eq!(solution.mean_gap_m(), 1.5);
        assert_eq!((solution.plane_m(), solution.separation_m(), solution.penetration_m()), (10.0, 3.0, 2.5));
        assert_eq!(
            (solution.hardness_pa(), solution.boundary(), solution.iterations()),
            (Some(4.0), Boundary::Free, 3)
        );
        assert_eq!(solution.grid().shape(), solution.displacement_m().dim());
        assert_eq!(solution.residual().worst(), 3e-9);
        assert!(solution.converged());
        let unfinished = Solution { stop_reason: SolverStop::PrecisionLimit, ..solution.clone() };
        assert!(!unfinished.converged() && unfinished.stop_reason() == SolverStop::PrecisionLimit);
        // Without a hardness no cell is plastic.
        let elastic = Solution { hardness_pa: None, ..solution };
        assert_eq!((elastic.plastic_fraction(), elastic.plastic_displacement_m().sum()), (0.0, 0.0));
    }

    #[test]
    fn a_nan_residual_stays_nan() {
        for residual in [
            Residual { frank_wolfe: f64::NAN, overlap: 0.0, load: 0.0 },
            Residual { frank_wolfe: 0.0, overlap: f64::NAN, load: 0.0 },
            Residual { frank_wolfe: 0.0, overlap: 0.0, load: f64::NAN },
        ] {
            assert!(residual.worst().is_nan());
        }
    }

    /// Returns the plane and the residuals of pressure `p` with v on four cells of unit rms height.
    fn certified(hardness_pa: Option<f64>, closure: Closure, p: [f64; 4], v: [f64; 4]) -> (f64, Residual) {
        let grid = Grid::new(2, 2, 1.0, 1.0).unwrap();
        let half_space = HalfSpace::new(grid, 1.0, Boundary::Free).unwrap();
        let heights = array![[1.0, -1.0], [1.0, -1.0]];
        let control = Control::MeanPressure { pascal: 0.1 };
        certify(
            &ContactProblem::new(&half_space, &heights, control, hardness_pa).unwrap(),
            closure,
            &[Part { p: &p, v: &v, hardness_pa }],
            None,
        )
    }

    #[test]
    fn residuals_follow_their_definitions() {
        // An exact elastic contact: v equals −plane in contact, and is larger elsewhere.
        let load = Closure::Sum { pascal: 4.0 };
        let (plane, residual) = certified(None, load, [1.0, 0.0, 3.0, 0.0], [-2.0, 1.0, -2.0, 5.0]);
        assert_eq!((plane, residual.worst()), (2.0, 0.0));
        // The load is too high by one half, one cell in contact by 0.4. The plane is the mean weighted by pressure.
        let (plane, residual) = certified(None, load, [2.0, 0.0, 4.0, 0.0], [-2.0, 1.0, -1.6, 5.0]);
        assert!((plane - (2.0 * 2.0 + 1.6 * 4.0) / 6.0).abs() < 1e-15);
        assert!((residual.frank_wolfe - 4.0 * 0.4 / 6.0).abs() < 1e-15);
        assert!((residual.overlap - (2.0 - plane)).abs() < 1e-15);
        assert_eq!(residual.load, 0.5);
        // Cells at the hardness may overlap. They neither set the plane nor count as violations.
        let (plane, residual) = certified(Some(3.0), load, [1.0, 0.0, 3.0, 0.0], [-2.0, 1.0, -9.0, 5.0]);
        assert_eq!((plane, residual.worst()), (2.0, 0.0));
        // Without elastic cells the plane rests on the cell that touches next.
        let closure = Closure::Sum { pascal: 3.0 };
        let (plane, residual) = certified(Some(3.0), closure, [0.0, 0.0, 3.0, 0.0], [-2.0, 1.0, -9.0, 5.0]);
        assert_eq!((plane, residual.worst()), (2.0, 0.0));
        // A prescribed plane 0.5 above the cells in contact: all cells have a gap.
        let closure = Closure::Plane { height_m: 2.5 };
        let (plane, residual) = certified(None, closure, [1.0, 0.0, 3.0, 0.0], [-2.0, 1.0, -2.0, 5.0]);
        assert_eq!((plane, residual.frank_wolfe, residual.overlap, residual.load), (2.5, 0.5, 0.0, 0.0));
        // The mean gap includes the cells out of contact: (3 + 7)/4.
        let closure = Closure::Gap { metre: 2.0 };
        let (plane, residual) = certified(None, closure, [1.0, 0.0, 3.0, 0.0], [-2.0, 1.0, -2.0, 5.0]);
        assert_eq!((plane, residual.frank_wolfe, residual.overlap, residual.load), (2.0, 0.0, 0.0, 0.25));
        let (_, residual) = certified(None, Closure::Plane { height_m: 0.0 }, [0.0; 4], [1.0; 4]);
        assert_eq!(residual.worst(), 0.0);
    }
}
