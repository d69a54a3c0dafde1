//! Reasons why a contact problem has no solution.

use thiserror::Error;

use asperity_base::map::MapError;
use asperity_contact::ContactError;

/// Reason why a contact problem has no solution.
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
        /// Number of iterations.
        iterations: usize,
        /// Largest residual reached.
        residual: f64,
        /// Tolerance of the solver.
        tolerance: f64,
    },
    /// The stiffness of the contact did not converge.
    #[error("no stiffness in {iterations} iterations: residual {residual:.1e}, wanted {tolerance:.1e}")]
    Stiffness {
        /// Iterations made.
        iterations: usize,
        /// Residual reached.
        residual: f64,
        /// Residual wanted.
        tolerance: f64,
    },
}
