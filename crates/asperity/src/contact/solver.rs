//! A bound-constrained preconditioned conjugate gradient method with one operator application per iteration.
//!
//! Each iteration forms a trial direction, preconditioned by E*|q|/2 and made conjugate to the step that was *realised*
//! last; projects the trial point on the bounds; and applies the compliance to the projected step alone. The exact step
//! length along that feasible step is then known, as is the correction that the next trial point needs if this step
//! was not of optimal length. Whatever the preconditioner and the history were, a step is taken only along a feasible
//! descent direction with a length that lowers the energy, and every 32nd step is a full gradient projection, so the
//! iteration converges to the unique solution; once the contact area no longer changes it is the preconditioned
//! conjugate gradient method.
//!
//! Operator and preconditioner are applied to steps in single precision, as in iterative refinement: the displacement of a
//! step errs by some 10⁻⁷ of it, and the displacement of the pressure is computed afresh in double precision before these errors
//! make up a share of the residual, and before convergence is claimed.
//!
//! # References
//! I. A. Polonsky and L. M. Keer, *Wear* **231** (1999) 206 (conjugate gradients on the contact area),
//! <https://doi.org/10.1016/S0043-1648(99)00113-1>.
//! D. G. Luenberger and Y. Ye, *Linear and Nonlinear Programming*, §7.10 (spacer steps).

use crate::contact::descent::Descent;
use crate::contact::{
    Boundary, ContactError, Control, Problem, Solution, Workspace, coarse_start, load_start, mean_gap,
};

/// Solves contact problems to a relative tolerance.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Solver {
    /// Bound on every entry of [`Residual`](crate::contact::Residual).
    pub tolerance: f64,
    /// Iterations, each with one operator application, before giving up.
    pub max_iterations: usize,
}

impl Default for Solver {
    fn default() -> Self {
        Self { tolerance: 1e-8, max_iterations: 2000 }
    }
}

/// What closes the problem. Heights are counted from the mean height of the map.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) enum Closure {
    /// The plane is fixed.
    Plane {
        /// Height in metre.
        height_m: f64,
    },
    /// The plane is fixed at this height and the mean of the displacement is zero, so that this is the mean gap.
    Gap {
        /// Mean gap in metre.
        metre: f64,
    },
    /// The sum of the pressures is fixed.
    Sum {
        /// Sum in pascal.
        pascal: f64,
    },
}

impl Closure {
    /// Height of the plane above the mean height in metre, where it is fixed.
    pub(super) fn plane_m(self) -> Option<f64> {
        match self {
            Self::Plane { height_m } | Self::Gap { metre: height_m } => Some(height_m),
            Self::Sum { .. } => None,
        }
    }
}

impl Solver {
    /// Solves `problem`. A solution that is not converged says so; it is not an error.
    ///
    /// # Errors
    /// The tolerance is not positive.
    pub fn solve(&self, problem: &Problem<'_>) -> Result<Solution, ContactError> {
        self.solve_with(problem, &mut problem.half_space().workspace())
    }

    /// As [`Solver::solve`] with scratch memory that is reused between solves.
    ///
    /// # Errors
    /// The tolerance is not positive.
    pub fn solve_with(&self, problem: &Problem<'_>, workspace: &mut Workspace) -> Result<Solution, ContactError> {
        if !(self.tolerance.is_finite() && self.tolerance > 0.0) {
            let (parameter, unit, wanted) = ("tolerance", "(relative)", "positive");
            return Err(ContactError::Parameter { parameter, value: self.tolerance, unit, wanted });
        }
        let points = problem.heights_m().len();
        if let Some(plane_m) = problem.plane_m() {
            let closure = Closure::Plane { height_m: plane_m - problem.mean_height_m() };
            let start = coarse_start::under_plane(problem, plane_m);
            return Ok(Descent::new(problem, closure, start, None, workspace).run(self));
        }
        if let Control::MeanGap { metre } = problem.control() {
            return Ok(mean_gap::solve(self, problem, metre, workspace));
        }
        // The mean displacement shifts the plane alone: without it, nothing large cancels.
        let pascal = problem.mean_pressure_pa().unwrap_or(0.0);
        let closure = Closure::Sum { pascal: pascal * points as f64 };
        let start = load_start::under_load(problem, pascal);
        Ok(Descent::new(problem, closure, start, rigid_mean(problem), workspace).run(self))
    }
}

/// A mean compliance of zero on the periodic boundary; the free one has no mean mode of its own.
pub(super) fn rigid_mean(problem: &Problem<'_>) -> Option<f64> {
    matches!(problem.half_space().boundary(), Boundary::Periodic { .. }).then_some(0.0)
}
