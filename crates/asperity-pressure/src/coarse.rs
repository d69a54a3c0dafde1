//! Cheaper models of a contact: the same map on fewer points, solved to a looser tolerance.

use ndarray::{Array2, s};

use crate::{CellObservation, Problem, stiffness};
use asperity_base::map::{Grid, HeightMap};
use asperity_contact::{self as contact, ContactWorkspace, Control, HalfSpace, Solver};

/// Strides along either side, coarsest first. Stride 1 is the full grid with a looser tolerance.
const STRIDES: [usize; 3] = [4, 2, 1];
/// Minimum number of points along a side.
const LEAST_POINTS: usize = 8;
/// Tolerance of coarse solutions; their error is dominated by the grid.
const TOLERANCE: f64 = 1e-2;
/// Minimum ratio to the fine tolerance for which the full grid also serves as a coarse model.
const LOOSER: f64 = 30.0;

/// Contact on every n-th point of the map along either side, including the cell of interest.
#[derive(Debug)]
pub(super) struct CoarseModel {
    half_space: HalfSpace,
    stride: usize,
    first: (usize, usize),
    cell: (usize, usize),
}

impl CoarseModel {
    /// Returns the coarse models of a problem, coarsest first; empty if the grid cannot be divided.
    pub(super) fn all(problem: &Problem<'_>) -> Vec<Self> {
        STRIDES.iter().filter_map(|stride| Self::new(problem, *stride)).collect()
    }

    fn new(problem: &Problem<'_>, stride: usize) -> Option<Self> {
        let grid = problem.half_space().grid();
        let (nx, ny) = (grid.nx() / stride, grid.ny() / stride);
        if stride == 1 && problem.solver().tolerance * LOOSER > TOLERANCE {
            return None;
        }
        if nx * stride != grid.nx() || ny * stride != grid.ny() || nx.min(ny) < LEAST_POINTS {
            return None;
        }
        let pitch = stride as f64;
        let grid = Grid::new(nx, ny, pitch * grid.dx_m(), pitch * grid.dy_m()).ok()?;
        let fine = problem.half_space();
        let half_space = HalfSpace::with_substrate(fine.substrate(), grid, fine.boundary()).ok()?;
        let (row, column) = problem.cell();
        let first = (row % stride, column % stride);
        Some(Self { half_space, stride, first, cell: (row / stride, column / stride) })
    }

    /// Returns the number of points along either side.
    pub(super) fn shape(&self) -> (usize, usize) {
        self.half_space.grid().shape()
    }

    pub(super) fn workspace(&self) -> ContactWorkspace {
        self.half_space.workspace()
    }

    /// Solves the contact of a map under the plane of the full map, whatever its residual, because the result is a
    /// predictor only.
    ///
    /// Returns `None` if the contact cannot be posed.
    pub(super) fn observe(
        &self,
        problem: &Problem<'_>,
        map: &HeightMap,
        workspace: &mut ContactWorkspace,
    ) -> Option<CellObservation> {
        let heights_m = map.complete_heights_m().ok()?;
        let control = match problem.control() {
            control @ (Control::Penetration { .. } | Control::Percentile { .. }) => {
                let fine =
                    contact::ContactProblem::new(problem.half_space(), heights_m, control, problem.hardness_pa())
                        .ok()?;
                Control::Plane { height_m: fine.plane_m()? }
            }
            control => control,
        };
        let (row, column) = self.first;
        let heights_m: Array2<f64> = heights_m.slice(s![row..;self.stride, column..;self.stride]).to_owned();
        let coarse = contact::ContactProblem::new(&self.half_space, &heights_m, control, problem.hardness_pa()).ok()?;
        let solver = Solver { tolerance: TOLERANCE, ..problem.solver() };
        let solution = solver.solve_with(&coarse, workspace).ok()?;
        let mut observation = CellObservation::from_solution(&solution, self.cell);
        if problem.has_stiffness() {
            let tolerance = stiffness::LOOSE_TOLERANCE;
            let found =
                stiffness::approach_stiffness_pa_per_m(&self.half_space, &solution, tolerance, workspace).ok()?;
            observation.stiffness_pa_per_m = Some(found.pascal_per_m);
        }
        Some(observation)
    }
}

/// Work of one iteration relative to a transform of the map, and work per solution besides its iterations in the same
/// units. Measured once with a profiler; only the allocation of samples depends on them.
const TRANSFORMS_PER_ITERATION: f64 = 4.0;
const WORK_PER_SOLUTION: f64 = 6e4;

/// Returns the work of generating a map, in floating-point operations of transforms.
pub(super) fn generation_work(shape: (usize, usize)) -> f64 {
    let points = (shape.0 * shape.1) as f64;
    points * points.log2()
}

/// Returns the work of a solution with the given number of iterations, in the same units.
pub(super) fn solution_work(shape: (usize, usize), iterations: f64) -> f64 {
    TRANSFORMS_PER_ITERATION * (iterations + 2.0) * generation_work(shape) + WORK_PER_SOLUTION
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::testing::{Shape, gaussian_surface};
    use asperity_contact::Boundary;

    #[test]
    fn a_coarse_contact_of_a_smooth_map_is_nearly_the_fine_one() {
        // The contact is two to six cells wide on the coarsest grid; its load has an error of some per cent.
        let grid = Grid::with_size(64, 64, 1.0, 1.0).unwrap();
        let wave = |x: f64| (std::f64::consts::TAU * x).cos();
        let shape = Shape::new(grid, 1.0, |x, y| wave(x - 32.5 / 64.0) * wave(y - 32.5 / 64.0));
        let boundary = Boundary::Periodic { mean_compliance_m_per_pa: 0.3 };
        let half_space = HalfSpace::new(grid, 1.0, boundary).unwrap();
        for control in [
            Control::Plane { height_m: 0.7 },
            Control::Penetration { metre: 0.3 },
            Control::Percentile { percent: 20.0 },
            Control::MeanPressure { pascal: 0.2 },
        ] {
            let problem = Problem::new(&shape, &half_space, control, None).unwrap();
            let ladder = CoarseModel::all(&problem);
            assert_eq!(ladder.iter().map(CoarseModel::shape).collect::<Vec<_>>(), [(16, 16), (32, 32), (64, 64)]);
            let map = HeightMap::new(grid, shape.heights_m.clone()).unwrap();
            let fine = problem.observe(&[0.0], &mut half_space.workspace()).unwrap();
            for (coarse, tolerance) in ladder.iter().zip([0.1, 0.05, 0.02]) {
                let found = coarse.observe(&problem, &map, &mut coarse.workspace()).unwrap();
                assert!(
                    (found.pressure_pa / fine.pressure_pa - 1.0).abs() < tolerance,
                    "{control:?} {found:?} {fine:?}"
                );
                assert!((found.mean_pressure_pa / fine.mean_pressure_pa - 1.0).abs() < tolerance, "{control:?}");
                assert!((found.mean_gap_m - fine.mean_gap_m).abs() < 0.02, "{control:?}");
            }
        }
    }

    #[test]
    fn the_cell_is_among_the_selected_points() {
        let (surface, half_space) = gaussian_surface(32, 30);
        let problem = Problem::new(&surface, &half_space, Control::Plane { height_m: -9.0 }, None).unwrap();
        let problem = problem.at_cell(13, 22).unwrap();
        let coarse = CoarseModel::new(&problem, 4).unwrap();
        assert_eq!((coarse.first, coarse.cell), ((1, 2), (3, 5)));
        assert!(CoarseModel::new(&problem, 8).is_none());
        assert!(
            CoarseModel::all(&Problem::new(&surface, &half_space, Control::Plane { height_m: 0.0 }, None).unwrap())
                .len()
                == 3
        );
    }
}
