//! Random pressure at one cell of a surface.

use serde::{Deserialize, Serialize};

use std::fmt;

use crate::{FailureReason, PressureError, stiffness};
use asperity_contact::{self as contact, Boundary, ContactWorkspace, Control, HalfSpace, Solution, Solver};
use asperity_surface::RandomSurface;

/// The pressure at one cell of a random surface under a rigid plane.
#[derive(Clone, Copy)]
pub struct Problem<'a> {
    surface: &'a dyn RandomSurface,
    half_space: &'a HalfSpace,
    control: Control,
    hardness_pa: Option<f64>,
    cell: (usize, usize),
    solver: Solver,
    stiffness: bool,
}

/// Results of one contact solution at a cell.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct CellObservation {
    /// Pressure in pascal; 0 out of contact.
    pub pressure_pa: f64,
    /// Gap in metre; 0 in contact.
    pub gap_m: f64,
    /// Plastic displacement in metre; 0 where the pressure is below the hardness.
    pub plastic_displacement_m: f64,
    /// Means of pressure, gap and plastic displacement over the four neighbours of the cell, in the same units.
    /// Neighbours across the edges count on a periodic map; on a free map only existing neighbours count.
    pub beside: [f64; 3],
    /// Height of the plane above the mean of the map, in metre.
    pub separation_m: f64,
    /// Fraction A_c/A of the cells in contact.
    pub contact_fraction: f64,
    /// Load over the nominal area in pascal.
    pub mean_pressure_pa: f64,
    /// Mean gap in metre.
    pub mean_gap_m: f64,
    /// Contact stiffness dp̄/dδ in Pa/m, if it was computed.
    pub stiffness_pa_per_m: Option<f64>,
    /// Iterations of the solver.
    pub iterations: usize,
}

impl CellObservation {
    /// Extracts the results of `solution` at `cell`, without the stiffness.
    pub(super) fn from_solution(solution: &Solution, cell: (usize, usize)) -> Self {
        Self {
            pressure_pa: solution.pressure_pa()[cell],
            gap_m: solution.gap_at_m(cell),
            plastic_displacement_m: solution.plastic_displacement_at_m(cell),
            beside: beside(solution, cell),
            separation_m: solution.separation_m(),
            contact_fraction: solution.contact_fraction(),
            mean_pressure_pa: solution.mean_pressure_pa(),
            mean_gap_m: solution.mean_gap_m(),
            stiffness_pa_per_m: None,
            iterations: solution.iterations(),
        }
    }
}

/// Returns the means over the neighbours of a cell.
fn beside(solution: &Solution, (row, column): (usize, usize)) -> [f64; 3] {
    let (ny, nx) = solution.grid().shape();
    let wraps = solution.boundary() != Boundary::Free;
    let step = |place: usize, n: usize, forward: bool| match (forward, place) {
        (true, place) if place + 1 < n => Some(place + 1),
        (false, 1..) => Some(place - 1),
        (true, _) => wraps.then_some(0),
        (false, _) => wraps.then_some(n - 1),
    };
    let mut sums = [0.0; 3];
    let mut count = 0.0_f64;
    for forward in [false, true] {
        let along_x = step(column, nx, forward).map(|column| (row, column));
        let along_y = step(row, ny, forward).map(|row| (row, column));
        for cell in along_x.into_iter().chain(along_y) {
            sums[0] += solution.pressure_pa()[cell];
            sums[1] += solution.gap_at_m(cell);
            sums[2] += solution.plastic_displacement_at_m(cell);
            count += 1.0;
        }
    }
    sums.map(|sum| sum / count.max(1.0))
}

impl fmt::Debug for Problem<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("Problem")
            .field("xi_len", &self.surface.xi_len())
            .field("grid", &self.surface.grid())
            .field("control", &self.control)
            .field("hardness_pa", &self.hardness_pa)
            .field("cell", &self.cell)
            .field("stiffness", &self.stiffness)
            .finish_non_exhaustive()
    }
}

impl<'a> Problem<'a> {
    /// Creates the problem of the pressure at the centre cell `[ny/2, nx/2]`; `hardness_pa = None` is elastic.
    ///
    /// In random studies the plane is fixed in space, [`Control::Plane`]: a plane that X % of the ensemble's heights
    /// exceed lies at the (1 − X/100) quantile of their marginal distribution. Under any other control each map has its
    /// own plane. A control out of range makes every sample fail with its reason.
    ///
    /// # Errors
    /// The surface and the half-space have different grids, or the hardness is not positive.
    pub fn new(
        surface: &'a dyn RandomSurface,
        half_space: &'a HalfSpace,
        control: Control,
        hardness_pa: Option<f64>,
    ) -> Result<Self, PressureError> {
        let grid = surface.grid();
        if grid != half_space.grid() {
            return Err(PressureError::Grid { surface: grid, half_space: half_space.grid() });
        }
        if let Some(value) = hardness_pa.filter(|h| !(h.is_finite() && *h > 0.0)) {
            return Err(PressureError::Parameter { parameter: "hardness", value, wanted: "positive" });
        }
        let cell = (grid.ny() / 2, grid.nx() / 2);
        Ok(Self { surface, half_space, control, hardness_pa, cell, solver: Solver::default(), stiffness: false })
    }

    /// Returns the problem at another cell (row, column).
    ///
    /// # Errors
    /// The cell lies outside the grid.
    pub fn at_cell(self, row: usize, column: usize) -> Result<Self, PressureError> {
        let (ny, nx) = self.surface.grid().shape();
        if row >= ny || column >= nx {
            return Err(PressureError::Cell { row, column, ny, nx });
        }
        Ok(Self { cell: (row, column), ..self })
    }

    /// Returns the problem with another solver.
    pub fn with_solver(self, solver: Solver) -> Self {
        Self { solver, ..self }
    }

    /// Returns the problem with the contact stiffness dp̄/dδ of every contact, where δ is the approach of the plane.
    /// This costs one more linear problem per contact.
    ///
    /// The contact area is held fixed and plastic cells keep their pressure, as during loading. The mean compliance c
    /// of a periodic half-space is included, 1/(dp̄/dδ) = 1/k + c, unlike in
    /// [`StiffnessSolver`](contact::StiffnessSolver), which returns k alone.
    pub fn with_stiffness(self) -> Self {
        Self { stiffness: true, ..self }
    }

    /// Returns the random surface.
    pub fn surface(&self) -> &'a dyn RandomSurface {
        self.surface
    }

    /// Returns the half-space.
    pub fn half_space(&self) -> &'a HalfSpace {
        self.half_space
    }

    /// Returns the prescribed control.
    pub fn control(&self) -> Control {
        self.control
    }

    /// Returns the upper bound of the pressure in pascal, if any.
    pub fn hardness_pa(&self) -> Option<f64> {
        self.hardness_pa
    }

    /// Returns whether the pressures of all cells have the same distribution: a stationary surface on a periodic
    /// half-space.
    pub fn cells_are_alike(&self) -> bool {
        self.half_space.boundary() != Boundary::Free && self.surface.is_periodic_and_stationary()
    }

    /// Returns the solver settings.
    pub fn solver(&self) -> Solver {
        self.solver
    }

    /// Returns whether the stiffness of every contact is computed.
    pub fn has_stiffness(&self) -> bool {
        self.stiffness
    }

    /// Returns the cell (row, column).
    pub fn cell(&self) -> (usize, usize) {
        self.cell
    }

    /// Solves the contact of the map with normal variables `xi`.
    ///
    /// # Errors
    /// The map is incomplete or flat, or the solver did not converge.
    pub fn solve(&self, xi: &[f64], workspace: &mut ContactWorkspace) -> Result<Solution, FailureReason> {
        let map = self.surface.generate(xi);
        let heights_m = map.complete_heights_m()?;
        let problem = contact::ContactProblem::new(self.half_space, heights_m, self.control, self.hardness_pa)?;
        let solution = self.solver.solve_with(&problem, workspace)?;
        if !solution.converged() {
            return Err(FailureReason::NotConverged {
                iterations: solution.iterations(),
                residual: solution.residual().worst(),
                tolerance: self.solver.tolerance,
            });
        }
        Ok(solution)
    }

    /// Solves the contact of the map with normal variables `xi` and returns the results at the cell.
    ///
    /// # Errors
    /// See [`Problem::solve`].
    pub fn observe(&self, xi: &[f64], workspace: &mut ContactWorkspace) -> Result<CellObservation, FailureReason> {
        let solution = self.solve(xi, workspace)?;
        self.observation(&solution, workspace)
    }

    /// Extracts the results of a solution at the cell, with the stiffness if required.
    pub(super) fn observation(
        &self,
        solution: &Solution,
        workspace: &mut ContactWorkspace,
    ) -> Result<CellObservation, FailureReason> {
        let observation = CellObservation::from_solution(solution, self.cell);
        if !self.stiffness {
            return Ok(observation);
        }
        let found = stiffness::approach_stiffness_pa_per_m(self.half_space, solution, stiffness::TOLERANCE, workspace)?;
        match found.short {
            Some(reason) => Err(reason),
            None => Ok(CellObservation { stiffness_pa_per_m: Some(found.pascal_per_m), ..observation }),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::testing::Shape;
    use asperity_base::map::Grid;
    use ndarray::Array2;

    #[test]
    fn the_summit_of_a_lifted_sphere_has_the_pressure_of_hertz() {
        let (radius_m, modulus_pa) = (1e-3, 2e11);
        let grid = Grid::with_size(65, 65, 65e-6, 65e-6).unwrap();
        let sphere = Shape::new(grid, 1e-7, |x, y| -((x - 32.5e-6).powi(2) + (y - 32.5e-6).powi(2)) / (2.0 * radius_m));
        let half_space = HalfSpace::new(grid, modulus_pa, Boundary::Free).unwrap();
        let problem = Problem::new(&sphere, &half_space, Control::Plane { height_m: 0.0 }, None).unwrap();
        for xi in [1.0, 2.0] {
            let observation = problem.observe(&[xi], &mut half_space.workspace()).unwrap();
            // p₀ = 2E*/π · √(δ/R) at the approach δ; the contact radius is 10 and 14 cells.
            let hertz = 2.0 * modulus_pa / std::f64::consts::PI * (xi * 1e-7 / radius_m).sqrt();
            assert!((observation.pressure_pa / hertz - 1.0).abs() < 0.01, "{} {hertz}", observation.pressure_pa);
            assert_eq!(observation.gap_m, 0.0);
        }
        let apart = problem.observe(&[-1.5], &mut half_space.workspace()).unwrap();
        assert_eq!(apart.pressure_pa, 0.0);
        assert!((apart.gap_m - 1.5e-7).abs() < 1e-20);
    }

    #[test]
    fn neighbours_of_a_cell_wrap_around_periodic_maps_only() {
        // Every height differs, so every neighbour has its own pressure or gap.
        let heights_m = Array2::from_shape_fn((4, 6), |(row, column)| 1e-7 * ((7 * row + 3 * column) as f64).sin());
        let grid = Grid::new(6, 4, 1e-6, 1e-6).unwrap();
        let at = |boundary: Boundary, cell: (usize, usize), neighbours: &[(usize, usize)]| {
            let half_space = HalfSpace::new(grid, 1e10, boundary).unwrap();
            let control = Control::MeanPressure { pascal: 3e7 };
            let problem = asperity_contact::ContactProblem::new(&half_space, &heights_m, control, Some(1e8)).unwrap();
            let solution = Solver::default().solve(&problem).unwrap();
            let mean = |value: &dyn Fn((usize, usize)) -> f64| {
                neighbours.iter().map(|cell| value(*cell)).sum::<f64>() / neighbours.len() as f64
            };
            let wanted = [
                mean(&|cell| solution.pressure_pa()[cell]),
                mean(&|cell| solution.gap_at_m(cell)),
                mean(&|cell| solution.plastic_displacement_at_m(cell)),
            ];
            let found = CellObservation::from_solution(&solution, cell).beside;
            assert!((0..3).all(|k| (found[k] - wanted[k]).abs() <= 1e-12 * wanted[k].abs()), "{found:?} {wanted:?}");
            wanted
        };
        let periodic = Boundary::Periodic { mean_compliance_m_per_pa: 0.0 };
        let around = at(periodic, (0, 0), &[(0, 5), (3, 0), (0, 1), (1, 0)]);
        assert!(around.iter().any(|mean| *mean > 0.0));
        at(periodic, (3, 5), &[(3, 4), (2, 5), (3, 0), (0, 5)]);
        at(periodic, (2, 3), &[(2, 2), (1, 3), (2, 4), (3, 3)]);
        at(Boundary::Free, (0, 0), &[(0, 1), (1, 0)]);
        at(Boundary::Free, (3, 2), &[(3, 1), (2, 2), (3, 3)]);
        at(Boundary::Free, (2, 3), &[(2, 2), (1, 3), (2, 4), (3, 3)]);
    }

    #[test]
    fn inconsistent_arguments_are_rejected() {
        let grid = Grid::new(4, 4, 1.0, 1.0).unwrap();
        let shape = Shape::new(grid, 1.0, |x, _| x);
        let other = HalfSpace::new(Grid::new(5, 4, 1.0, 1.0).unwrap(), 1.0, Boundary::Free).unwrap();
        let control = Control::Plane { height_m: 0.0 };
        assert!(matches!(Problem::new(&shape, &other, control, None), Err(PressureError::Grid { .. })));
        let half_space = HalfSpace::new(grid, 1.0, Boundary::Free).unwrap();
        let hardness = Problem::new(&shape, &half_space, control, Some(0.0));
        assert!(matches!(hardness, Err(PressureError::Parameter { parameter: "hardness", .. })));
        let problem = Problem::new(&shape, &half_space, control, None).unwrap();
        assert!(matches!(problem.at_cell(0, 4), Err(PressureError::Cell { column: 4, .. })));
    }
}
