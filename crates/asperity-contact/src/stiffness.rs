//! Stiffness of a contact against further approach.

use crate::{Boundary, ContactError, ContactWorkspace, HalfSpace, Solution};
use asperity_base::fourier::ROWS_OF_SLAB;
use asperity_base::monitor::{Monitor, Silent};
use asperity_base::numeric::dot;

/// Normal stiffness K = dF/dδ of a solved contact: load per approach of the plane. δ grows as the plane comes down.
///
/// The set of cells in contact is fixed. Where 0 < p < H the surface moves with the plane. Where p = H the pressure is
/// constant (or falls on unloading, see [`Motion`]). Elsewhere it stays zero. With x the pressure per approach, S_cc x
/// = 1 over the cells that move, and K = Σ x ΔA. This is the slope of the load in the discretised problem, which is
/// piecewise linear in the approach. Cells that come into contact increase K in steps. If no cell moves, K is zero.
///
/// On a periodic half-space δ is the approach of the mean planes without the mean compliance c. The mean compliance
/// belongs to the bulk, in series with the interface (1/K + c/A₀ in total), and has no finite value. Displacements of
/// the interface have mean zero, so an elastic contact has K/A₀ = −dp̄/dḡ with the mean gap ḡ. In complete contact the
/// gap cannot change, and K is infinite.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ContactStiffness {
    /// K in N/m; infinite in complete contact on a periodic half-space.
    pub newton_per_m: f64,
    /// K over the nominal area in Pa/m.
    pub pascal_per_m: f64,
    /// Iterations of the solver.
    pub iterations: usize,
    /// Root-mean-square of S_cc x − 1 over the cells, recomputed from the final x.
    pub residual: f64,
    /// Whether the residual is within the tolerance.
    pub converged: bool,
}

/// Direction of motion of the plane.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Motion {
    /// Downwards: plastic cells keep flowing at p = H.
    #[default]
    Loading,
    /// Upwards: the plastic displacement is fixed, and all cells in contact move with the plane.
    Unloading,
}

/// Computes a [`ContactStiffness`] by conjugate gradients with the preconditioner of the contact solver.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct StiffnessSolver {
    /// Direction of motion of the plane; it matters if cells are plastic.
    pub motion: Motion,
    /// Bound on the residual r. The error of K is r·S_cc⁻¹r ΔA.
    pub tolerance: f64,
    /// Iterations, each with one operator application, before giving up.
    pub max_iterations: usize,
}

impl Default for StiffnessSolver {
    fn default() -> Self {
        Self { motion: Motion::Loading, tolerance: 1e-8, max_iterations: 500 }
    }
}

impl StiffnessSolver {
    /// Computes the stiffness of `solution` on the half-space on which it was solved.
    ///
    /// # Errors
    /// The tolerance is not positive, or the solution does not fit the half-space.
    pub fn solve(&self, half_space: &HalfSpace, solution: &Solution) -> Result<ContactStiffness, ContactError> {
        self.solve_with(half_space, solution, &Silent)
    }

    /// Computes the stiffness like [`StiffnessSolver::solve`]. If the monitor cancels, the result is not converged.
    ///
    /// # Errors
    /// The errors of [`StiffnessSolver::solve`].
    pub fn solve_with(
        &self,
        half_space: &HalfSpace,
        solution: &Solution,
        monitor: &dyn Monitor,
    ) -> Result<ContactStiffness, ContactError> {
        self.solve_in(half_space, solution, &mut half_space.workspace(), monitor)
    }

    /// Computes the stiffness like [`StiffnessSolver::solve_with`], in a workspace that may be the one of the contact.
    ///
    /// # Errors
    /// The errors of [`StiffnessSolver::solve`].
    pub fn solve_in(
        &self,
        half_space: &HalfSpace,
        solution: &Solution,
        workspace: &mut ContactWorkspace,
        monitor: &dyn Monitor,
    ) -> Result<ContactStiffness, ContactError> {
        if !(self.tolerance.is_finite() && self.tolerance > 0.0) {
            let (parameter, unit, wanted) = ("tolerance", "(relative)", "positive");
            return Err(ContactError::Parameter { parameter, value: self.tolerance, unit, wanted });
        }
        let (rows, columns) = solution.grid().shape();
        let (ny, nx) = half_space.grid().shape();
        if (rows, columns) != (ny, nx) {
            return Err(ContactError::Shape { rows, columns, ny, nx });
        }
        let moves = |cell: (usize, usize), p: f64| match self.motion {
            Motion::Loading => p > 0.0 && !solution.is_plastic(cell),
            Motion::Unloading => p > 0.0,
        };
        let pressures = solution.pressure_pa().indexed_iter().enumerate();
        let cells: Vec<usize> = pressures.filter(|(_, (cell, p))| moves(*cell, **p)).map(|(place, _)| place).collect();
        let area_m2 = half_space.grid().area_m2();
        let exactly = |newton_per_m: f64| ContactStiffness {
            newton_per_m,
            pascal_per_m: newton_per_m / area_m2,
            iterations: 0,
            residual: 0.0,
            converged: true,
        };
        if cells.is_empty() {
            return Ok(exactly(0.0));
        }
        let periodic = half_space.boundary() != Boundary::Free;
        if cells.len() == half_space.grid().points() && periodic {
            return Ok(exactly(f64::INFINITY));
        }
        let mut system = System::new(half_space, workspace, cells);
        let found = self.descend(&mut system, monitor);
        let newton_per_m = found.sum_pa_per_m * half_space.grid().cell_area_m2();
        Ok(ContactStiffness {
            newton_per_m,
            pascal_per_m: newton_per_m / area_m2,
            iterations: found.iterations,
            residual: found.residual,
            converged: found.residual <= self.tolerance,
        })
    }

    /// Solves S_cc x = 1.
    fn descend(&self, system: &mut System<'_>, monitor: &dyn Monitor) -> CgResult {
        let n = system.cells.len();
        let (mut x, mut residuals) = (vec![0.0; n], vec![1.0; n]);
        let (mut step, mut image, mut steepest) = (vec![0.0; n], vec![0.0; n], vec![0.0; n]);
        let (mut iterations, mut residual) = (0, 1.0);
        // Each outer iteration restarts from the true residual, in case the recurrence has drifted away from it.
        let continues = |iterations: usize| iterations < self.max_iterations && !monitor.cancelled();
        while residual > self.tolerance && continues(iterations) {
            let (mut updated, mut slope_before) = (residual, f64::INFINITY);
            while updated > 0.5 * self.tolerance && continues(iterations) {
                system.precondition(&residuals, &mut steepest);
                let slope = dot(&residuals, &steepest);
                let ratio = slope / slope_before;
                step.iter_mut().zip(&steepest).for_each(|(step, steepest)| *step = steepest + ratio * *step);
                system.displace(&step, &mut image);
                let length = slope / dot(&step, &image);
                x.iter_mut().zip(&step).for_each(|(x, step)| *x += length * step);
                residuals.iter_mut().zip(&image).for_each(|(residuals, image)| *residuals -= length * image);
                (updated, slope_before) = (rms(&residuals), slope);
                iterations += 1;
            }
            system.displace(&x, &mut image);
            residuals.iter_mut().zip(&image).for_each(|(residuals, image)| *residuals = 1.0 - image);
            residual = rms(&residuals);
        }
        let sum_pa_per_m = x.iter().zip(&residuals).map(|(x, residuals)| x + x * residuals).sum();
        CgResult { sum_pa_per_m, iterations, residual }
    }
}

/// Result of the conjugate gradient iteration.
struct CgResult {
    /// 2 Σ x − x·S_cc x = Σ x (1 + r) with the residual r = 1 − S_cc x: the sum of the exact x minus r·S_cc⁻¹r.
    sum_pa_per_m: f64,
    iterations: usize,
    residual: f64,
}

/// The compliance between the cells that move with the plane, and its preconditioner.
struct System<'a> {
    half_space: &'a HalfSpace,
    workspace: &'a mut ContactWorkspace,
    cells: Vec<usize>,
    /// Values on the cells; zero elsewhere.
    field: Vec<f64>,
    image: Vec<f64>,
}

impl<'a> System<'a> {
    fn new(half_space: &'a HalfSpace, workspace: &'a mut ContactWorkspace, cells: Vec<usize>) -> Self {
        let points = half_space.grid().points();
        Self { half_space, workspace, cells, field: vec![0.0; points], image: vec![0.0; points] }
    }

    fn spread(&mut self, values: &[f64]) {
        self.cells.iter().zip(values).for_each(|(cell, value)| self.field[*cell] = *value);
    }

    fn gather(&self, out: &mut [f64]) {
        out.iter_mut().zip(&self.cells).for_each(|(out, cell)| *out = self.image[*cell]);
    }

    /// Computes the displacement by pressures on the cells; on the periodic boundary it is counted from its mean.
    fn displace(&mut self, pressure_pa: &[f64], displacement_m: &mut [f64]) {
        self.spread(pressure_pa);
        self.half_space.displace(&self.field, &mut self.image, self.workspace);
        self.gather(displacement_m);
        if let Boundary::Periodic { mean_compliance_m_per_pa } = self.half_space.boundary() {
            let mean_m = mean_compliance_m_per_pa * pressure_pa.iter().sum::<f64>() / self.field.len() as f64;
            displacement_m.iter_mut().for_each(|u| *u -= mean_m);
        }
    }

    /// Applies the solver's preconditioner on the cells, in single precision over the unit of both. The mean is rigid.
    fn precondition(&mut self, displacement_m: &[f64], pressure_pa: &mut [f64]) {
        self.spread(displacement_m);
        let unit_m = rms(displacement_m);
        let columns = self.half_space.grid().nx();
        let unit_pa = self.half_space.stiffness_unit_pa_per_m() * unit_m;
        let piece = |row: usize| row % ROWS_OF_SLAB * columns..(row % ROWS_OF_SLAB + 1) * columns;
        type Fields<'s> = (&'s [f64], &'s mut [f64]);
        let chunk = ROWS_OF_SLAB * columns;
        let mut slabs: Vec<Fields<'_>> = self.field.chunks(chunk).zip(self.image.chunks_mut(chunk)).collect();
        let fill = |(field, _): &mut Fields<'_>, row: usize, out: &mut [f32]| {
            out.iter_mut().zip(&field[piece(row)]).for_each(|(out, u)| *out = (u / unit_m) as f32);
            true
        };
        let take = |(_, image): &mut Fields<'_>, row: usize, values: &[f32]| {
            image[piece(row)].iter_mut().zip(values).for_each(|(p, value)| *p = unit_pa * f64::from(*value));
        };
        self.half_space.prepare(self.workspace);
        let mean = self.half_space.mean_mode(Some(0.0));
        self.half_space.stiffen(mean, &mut slabs, fill, take, &mut self.workspace.transforms);
        self.gather(pressure_pa);
    }
}

fn rms(values: &[f64]) -> f64 {
    (dot(values, values) / values.len() as f64).sqrt()
}
