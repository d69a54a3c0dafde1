//! The stiffness of a contact against further approach.

use crate::contact::half_space::MeanMode;
use crate::contact::vectors::sums;
use crate::contact::{Boundary, ContactError, HalfSpace, Solution, Workspace};
use crate::fourier::ROWS_OF_SLAB;

/// Normal stiffness K = dF/dδ of a solved contact: load per approach of the plane, δ growing as it comes down.
///
/// The set in contact is held: where 0 < p < H the surface moves with the plane, where p = H the pressure stays (on the way
/// back it falls, [`Motion`]), and elsewhere it stays zero. With x the pressure per approach, S_cc x = 1 over the cells that
/// move, and K = Σ x ΔA. This is the slope of the load in the discretised problem, which is a piecewise linear function of the
/// approach; cells that enter make K grow in steps. Where no cell moves, K is zero.
///
/// On a periodic half-space δ is the approach of the mean planes, with the mean compliance left out: that belongs to the bulk,
/// in series with the interface (1/K + c/A₀ of both), and has no finite value. As displacements of the interface have mean zero,
/// an elastic contact has K/A₀ = −dp̄/dḡ with the mean gap ḡ. In complete contact the gap cannot change, and K is infinite.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ContactStiffness {
    /// K in N/m; infinite in complete contact on a periodic half-space.
    pub newton_per_m: f64,
    /// K over the nominal area in Pa/m.
    pub pascal_per_m: f64,
    /// Iterations of the solver.
    pub iterations: usize,
    /// Root-mean-square of S_cc x − 1 over the cells, evaluated afresh.
    pub residual: f64,
    /// Whether the residual is within the tolerance.
    pub converged: bool,
}

/// Which way the plane moves.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Motion {
    /// Further down: plastic cells keep flowing at p = H.
    #[default]
    Loading,
    /// Back up: plastic flow stays as it is, and all cells in contact move with the plane.
    Unloading,
}

/// Computes a [`ContactStiffness`] by conjugate gradients, preconditioned by E*|q|/2 on the cells in contact.
///
/// # References
/// G. H. Golub and Q. Ye, *SIAM J. Sci. Comput.* **21** (1999) 1305 (conjugate gradients whose preconditioner varies: it
/// rounds to single precision), <https://doi.org/10.1137/S1064827597323415>.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct StiffnessSolver {
    /// Which way the plane moves; it matters where cells are plastic.
    pub motion: Motion,
    /// Bound on the residual r. K errs by r·S_cc⁻¹r ΔA alone.
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
    /// The stiffness of `solution` on the half-space that it was solved on.
    ///
    /// # Errors
    /// The tolerance is not positive, or the solution does not fit the half-space.
    pub fn solve(&self, half_space: &HalfSpace, solution: &Solution) -> Result<ContactStiffness, ContactError> {
        if !(self.tolerance.is_finite() && self.tolerance > 0.0) {
            let (parameter, unit, wanted) = ("tolerance", "(relative)", "positive");
            return Err(ContactError::Parameter { parameter, value: self.tolerance, unit, wanted });
        }
        let (rows, columns) = solution.grid().shape();
        let (ny, nx) = half_space.grid().shape();
        if (rows, columns) != (ny, nx) {
            return Err(ContactError::Shape { rows, columns, ny, nx });
        }
        let upper = match self.motion {
            Motion::Loading => solution.hardness_pa().unwrap_or(f64::INFINITY),
            Motion::Unloading => f64::INFINITY,
        };
        let moves = |p: f64| p > 0.0 && p < upper;
        let cells: Vec<usize> =
            solution.pressure_pa().iter().enumerate().filter(|(_, p)| moves(**p)).map(|(cell, _)| cell).collect();
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
        let periodic = matches!(half_space.boundary(), Boundary::Periodic { .. });
        if cells.len() == half_space.grid().points() && periodic {
            return Ok(exactly(f64::INFINITY));
        }
        let mut system = System {
            half_space,
            mean: half_space.mean_mode(periodic.then_some(0.0)),
            workspace: half_space.workspace(),
            cells,
            field: vec![0.0; half_space.grid().points()],
            image: vec![0.0; half_space.grid().points()],
        };
        let found = self.descend(&mut system);
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
    fn descend(&self, system: &mut System<'_>) -> Descended {
        let n = system.cells.len();
        let (mut x, mut rest) = (vec![0.0; n], vec![1.0; n]);
        let (mut step, mut image, mut steepest) = (vec![0.0; n], vec![0.0; n], vec![0.0; n]);
        let (mut iterations, mut residual) = (0, 1.0);
        // Anew from the true residual, should the recurrence have drifted away from it.
        while residual > self.tolerance && iterations < self.max_iterations {
            let (mut updated, mut length, mut slope_before) = (residual, 0.0, 1.0);
            while updated > 0.5 * self.tolerance && iterations < self.max_iterations {
                system.precondition(&rest, &mut steepest);
                // The residual last changed by −length·image.
                let share = -length * dot(&steepest, &image) / slope_before;
                step.iter_mut().zip(&steepest).for_each(|(step, steepest)| *step = steepest + share * *step);
                slope_before = dot(&steepest, &rest);
                system.displace(&step, &mut image);
                length = dot(&step, &rest) / dot(&step, &image);
                x.iter_mut().zip(&step).for_each(|(x, step)| *x += length * step);
                rest.iter_mut().zip(&image).for_each(|(rest, image)| *rest -= length * image);
                updated = rms(&rest);
                iterations += 1;
            }
            system.displace(&x, &mut image);
            rest.iter_mut().zip(&image).for_each(|(rest, image)| *rest = 1.0 - image);
            residual = rms(&rest);
        }
        let [sum_pa_per_m] = sums(&x, &rest, |x, rest| [x + x * rest]);
        Descended { sum_pa_per_m, iterations, residual }
    }
}

/// What a descent came to.
struct Descended {
    /// 2 Σ x − x·S_cc x = Σ x (1 + r) with the residual r = 1 − S_cc x: the sum of the exact x less r·S_cc⁻¹r.
    sum_pa_per_m: f64,
    iterations: usize,
    residual: f64,
}

/// The compliance between the cells that move with the plane, and its preconditioner.
struct System<'a> {
    half_space: &'a HalfSpace,
    mean: MeanMode,
    workspace: Workspace,
    cells: Vec<usize>,
    /// Zero but on the cells.
    field: Vec<f64>,
    image: Vec<f64>,
}

impl System<'_> {
    fn spread(&mut self, values: &[f64]) {
        self.cells.iter().zip(values).for_each(|(cell, value)| self.field[*cell] = *value);
    }

    fn displace(&mut self, pressure_pa: &[f64], displacement_m: &mut [f64]) {
        self.spread(pressure_pa);
        self.half_space.displace_as(self.mean, &self.field, &mut self.image, &mut self.workspace);
        displacement_m.iter_mut().zip(&self.cells).for_each(|(out, cell)| *out = self.image[*cell]);
    }

    fn precondition(&mut self, displacement_m: &[f64], pressure_pa: &mut [f64]) {
        self.spread(displacement_m);
        let columns = self.half_space.grid().nx();
        let fill = |row: usize, out: &mut [f32]| {
            let values = &self.field[row * columns..][..columns];
            out.iter_mut().zip(values).for_each(|(out, value)| *out = *value as f32);
            values.iter().any(|value| *value != 0.0)
        };
        self.half_space.stiffness_forward(self.mean, fill, &mut self.workspace);
        let slabs = self.image.chunks_mut(ROWS_OF_SLAB * columns).collect();
        let take = |slab: &mut &mut [f64], row: usize, values: &[f32]| {
            let out = &mut slab[row % ROWS_OF_SLAB * columns..][..columns];
            out.iter_mut().zip(values).for_each(|(out, value)| *out = f64::from(*value));
        };
        self.half_space.stiffness_backward(slabs, take, &mut self.workspace);
        let unit = self.half_space.stiffness_unit_pa_per_m();
        pressure_pa.iter_mut().zip(&self.cells).for_each(|(out, cell)| *out = unit * self.image[*cell]);
    }
}

fn dot(a: &[f64], b: &[f64]) -> f64 {
    let [product] = sums(a, b, |a, b| [a * b]);
    product
}

fn rms(values: &[f64]) -> f64 {
    (dot(values, values) / values.len() as f64).sqrt()
}
