//! Which random pressure is asked for.

use std::fmt;

use thiserror::Error;

use crate::contact::{self, ContactError, Control, HalfSpace, Solver, Workspace};
use crate::map::{HeightMap, MapError};
use crate::pressure::PressureError;
use crate::surface::RandomSurface;

/// The pressure at one cell of a random surface under a plane fixed in space.
#[derive(Clone, Copy)]
pub struct Problem<'a> {
    surface: &'a dyn RandomSurface,
    half_space: &'a HalfSpace,
    plane_m: f64,
    hardness_pa: Option<f64>,
    cell: (usize, usize),
    solver: Solver,
}

/// What one contact solution says about the cell.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Observation {
    /// Pressure in pascal; 0 out of contact.
    pub pressure_pa: f64,
    /// Gap in metre; 0 in contact.
    pub gap_m: f64,
}

/// Why one contact problem has no answer.
#[derive(Debug, Clone, PartialEq, Error)]
pub enum FailureReason {
    /// The generated map is not complete.
    #[error(transparent)]
    Map(#[from] MapError),
    /// The contact problem could not be posed.
    #[error(transparent)]
    Contact(#[from] ContactError),
    /// The solver stopped before its tolerance.
    #[error("no convergence in {iterations} iterations: residual {residual:.1e}, wanted {tolerance:.1e}")]
    NotConverged {
        /// Iterations made.
        iterations: usize,
        /// Largest residual reached.
        residual: f64,
        /// Tolerance of the solver.
        tolerance: f64,
    },
}

impl fmt::Debug for Problem<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("Problem")
            .field("germ_len", &self.surface.germ_len())
            .field("grid", &self.surface.grid())
            .field("plane_m", &self.plane_m)
            .field("hardness_pa", &self.hardness_pa)
            .field("cell", &self.cell)
            .finish_non_exhaustive()
    }
}

impl<'a> Problem<'a> {
    /// The pressure at the centre cell `[ny/2, nx/2]` under a plane at height `plane_m`; `hardness_pa = None` is
    /// elastic. A plane that X % of the ensemble's heights exceed lies at the (1 − X/100) quantile of their marginal law.
    ///
    /// # Errors
    /// The surface and the half-space have different grids, or the plane or the hardness is out of range.
    pub fn new(
        surface: &'a dyn RandomSurface,
        half_space: &'a HalfSpace,
        plane_m: f64,
        hardness_pa: Option<f64>,
    ) -> Result<Self, PressureError> {
        let grid = surface.grid();
        if grid != half_space.grid() {
            return Err(PressureError::Grid { surface: grid, half_space: half_space.grid() });
        }
        if !plane_m.is_finite() {
            return Err(PressureError::Parameter { parameter: "plane height", value: plane_m, wanted: "finite" });
        }
        if let Some(value) = hardness_pa.filter(|h| !(h.is_finite() && *h > 0.0)) {
            return Err(PressureError::Parameter { parameter: "hardness", value, wanted: "positive" });
        }
        let cell = (grid.ny() / 2, grid.nx() / 2);
        Ok(Self { surface, half_space, plane_m, hardness_pa, cell, solver: Solver::default() })
    }

    /// The same at another cell (row, column).
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

    /// The same with another solver.
    pub fn with_solver(self, solver: Solver) -> Self {
        Self { solver, ..self }
    }

    /// The random surface.
    pub fn surface(&self) -> &'a dyn RandomSurface {
        self.surface
    }

    /// The half-space.
    pub fn half_space(&self) -> &'a HalfSpace {
        self.half_space
    }

    /// Height of the plane in metre.
    pub fn plane_m(&self) -> f64 {
        self.plane_m
    }

    /// Upper bound of the pressure in pascal, if any.
    pub fn hardness_pa(&self) -> Option<f64> {
        self.hardness_pa
    }

    /// The cell (row, column).
    pub fn cell(&self) -> (usize, usize) {
        self.cell
    }

    /// Solves the contact of one germ's map.
    ///
    /// # Errors
    /// The map is incomplete or flat, or the solver did not converge.
    pub fn observe(&self, germ: &[f64], workspace: &mut Workspace) -> Result<Observation, FailureReason> {
        self.observe_map(&self.surface.generate(germ), workspace)
    }

    fn observe_map(&self, map: &HeightMap, workspace: &mut Workspace) -> Result<Observation, FailureReason> {
        let control = Control::Plane { height_m: self.plane_m };
        let problem = contact::Problem::new(self.half_space, map.complete_heights_m()?, control, self.hardness_pa)?;
        let solution = self.solver.solve_with(&problem, workspace)?;
        if !solution.converged() {
            return Err(FailureReason::NotConverged {
                iterations: solution.iterations(),
                residual: solution.residual().worst(),
                tolerance: self.solver.tolerance,
            });
        }
        Ok(Observation { pressure_pa: solution.pressure_pa()[self.cell], gap_m: solution.gap_m()[self.cell] })
    }
}
