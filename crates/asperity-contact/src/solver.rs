//! A bound-constrained preconditioned conjugate gradient method with one operator application per iteration.
//!
//! Each iteration forms a trial direction. It is preconditioned by about E*|q|/2 (a pyramid of stencils if cells are
//! square and can be halved, otherwise a transform) and conjugate to the *realised* last step. The trial point is
//! projected on the bounds, and the compliance is applied to the projected step alone. This gives the exact step length
//! along that feasible step. If the step was not of optimal length, it also gives the correction that the next trial
//! point needs.
//!
//! Every step follows a feasible descent direction with a length that lowers the energy, whatever the preconditioner
//! and the history are. Every 32nd step is a full gradient projection. So the iteration converges to the unique
//! solution. Once the contact area no longer changes, it is the preconditioned conjugate gradient method.
//!
//! Operator and preconditioner are applied to steps in single precision, as in iterative refinement. The displacement
//! of a step has a relative error of about 10⁻⁷. The displacement of the pressure is recomputed in double precision
//! before these errors reach a fraction of the residual, and before the solver reports convergence.
//!
//! # References
//! I. A. Polonsky and L. M. Keer, *Wear* **231** (1999) 206 (conjugate gradients on the contact area),
//! <https://doi.org/10.1016/S0043-1648(99)00113-1>.
//! D. G. Luenberger and Y. Ye, *Linear and Nonlinear Programming*, §7.10 (spacer steps).

use ndarray::Array2;

use crate::conditions::Closure;
use crate::descent::{Descent, Limits};
use crate::{ContactError, ContactProblem, ContactWorkspace, Control, Solution, coarse_start, load_start, mean_gap};
use asperity_base::monitor::{Monitor, Silent};

/// Solves contact problems to a relative tolerance.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Solver {
    /// Bound on every entry of [`Residual`](crate::Residual).
    pub tolerance: f64,
    /// Iterations, each with one operator application, before giving up.
    pub max_iterations: usize,
}

impl Default for Solver {
    fn default() -> Self {
        Self { tolerance: 1e-8, max_iterations: 2000 }
    }
}

impl Solver {
    /// Solves `problem`. A solution that did not converge is not an error; see [`Solution::converged`].
    ///
    /// # Errors
    /// The tolerance is not positive.
    pub fn solve(&self, problem: &ContactProblem<'_>) -> Result<Solution, ContactError> {
        self.solve_with(problem, &mut problem.half_space().workspace())
    }

    /// Solves `problem` like [`Solver::solve`], with scratch memory that is reused between solves.
    ///
    /// # Errors
    /// The tolerance is not positive.
    pub fn solve_with(
        &self,
        problem: &ContactProblem<'_>,
        workspace: &mut ContactWorkspace,
    ) -> Result<Solution, ContactError> {
        self.solve_from(problem, None, workspace, &Silent)
    }

    /// Solves `problem` like [`Solver::solve_with`], from the pressure `start` in pascal of shape `[ny, nx]`, if given.
    /// Stops with [`SolverStop::Cancelled`](crate::SolverStop::Cancelled) when the monitor cancels.
    ///
    /// The pressure of a similar problem saves some iterations if the loads differ by a few percent. It is clipped to
    /// the bounds and scaled to the prescribed load. It does not change the solution beyond the tolerance. A prescribed
    /// mean gap whose plane has to be searched does not use it.
    ///
    /// # Errors
    /// The tolerance is not positive, or the start does not fit the map.
    pub fn solve_from(
        &self,
        problem: &ContactProblem<'_>,
        start: Option<&Array2<f64>>,
        workspace: &mut ContactWorkspace,
        monitor: &dyn Monitor,
    ) -> Result<Solution, ContactError> {
        if !(self.tolerance.is_finite() && self.tolerance > 0.0) {
            let (parameter, unit, wanted) = ("tolerance", "(relative)", "positive");
            return Err(ContactError::Parameter { parameter, value: self.tolerance, unit, wanted });
        }
        problem.half_space().prepare(workspace);
        let points = problem.heights_m().len();
        let start = start.map(|start| warm_start(problem, start)).transpose()?.flatten();
        if let Some(plane_m) = problem.plane_m() {
            let closure = Closure::Plane { height_m: plane_m - problem.mean_height_m() };
            let start = start.unwrap_or_else(|| coarse_start::under_plane(problem, plane_m, workspace, monitor));
            return Ok(Descent::new(problem, closure, start, None, workspace).run(self.limits(), monitor));
        }
        if let Control::MeanGap { metre } = problem.control() {
            return Ok(mean_gap::solve(self.limits(), problem, metre, workspace, monitor));
        }
        // The mean displacement shifts the plane alone. Without it, no large numbers cancel.
        let pascal = problem.mean_pressure_pa().unwrap_or(0.0);
        let closure = Closure::Sum { pascal: pascal * points as f64 };
        let start = start.unwrap_or_else(|| load_start::under_load(problem, pascal));
        let descent = Descent::new(problem, closure, start, problem.rigid_mean_m_per_pa(), workspace);
        Ok(descent.run(self.limits(), monitor))
    }

    fn limits(&self) -> Limits {
        Limits { tolerance: self.tolerance, max_iterations: self.max_iterations }
    }
}

/// Returns the pressure `start` within the bounds and scaled to the prescribed load, or `None` if it cannot be used.
fn warm_start(problem: &ContactProblem<'_>, start: &Array2<f64>) -> Result<Option<Vec<f64>>, ContactError> {
    let ((rows, columns), (ny, nx)) = (start.dim(), problem.heights_m().dim());
    if (rows, columns) != (ny, nx) {
        return Err(ContactError::Shape { rows, columns, ny, nx });
    }
    let pressed = |p: f64| if p > 0.0 && p.is_finite() { p } else { 0.0 };
    let mut p: Vec<f64> = start.iter().map(|p| pressed(*p)).collect();
    let sum: f64 = p.iter().sum();
    let wanted = problem.mean_pressure_pa().map_or(sum, |pascal| pascal * p.len() as f64);
    let hardness_pa = problem.hardness_pa().unwrap_or(f64::INFINITY);
    let mut capacity = 0.0;
    for p in p.iter_mut().filter(|p| **p > 0.0) {
        *p = (*p * (wanted / sum)).min(hardness_pa);
        capacity += hardness_pa;
    }
    // The pressed cells must be able to carry the load.
    let serves = sum > 0.0 && sum.is_finite() && p.iter().all(|p| p.is_finite()) && capacity > wanted;
    Ok(serves.then_some(p))
}
