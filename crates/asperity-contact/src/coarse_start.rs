//! Initial pressure under a prescribed plane.

use ndarray::Array2;

use crate::conditions::Closure;
use crate::descent::{Descent, Limits};
use crate::{ContactProblem, ContactWorkspace, Control};
use asperity_base::monitor::Monitor;

/// Limits of the coarse problems. The tolerance is loose because coarse cells lack the fine waves anyway.
const COARSE: Limits = Limits { tolerance: 1e-2, max_iterations: 100 };

/// Returns the pressure under a plane at `plane_m`, solved on cells twice as wide and recursively on coarser ones; zero
/// if the cells cannot be halved.
///
/// Under a prescribed plane the load is unknown. From zero pressure it builds up slowly through the long waves. The
/// coarse grid determines it at a quarter of the cost.
pub(super) fn under_plane(
    problem: &ContactProblem<'_>,
    plane_m: f64,
    workspace: &mut ContactWorkspace,
    monitor: &dyn Monitor,
) -> Vec<f64> {
    let none = || vec![0.0; problem.heights_m().len()];
    let Some(coarse) = problem.half_space().coarse() else {
        return none();
    };
    let fine = problem.heights_m();
    let heights_m = Array2::from_shape_fn(coarse.grid().shape(), |(row, column)| {
        let (i, j) = (2 * row, 2 * column);
        0.25 * (fine[[i, j]] + fine[[i, j + 1]] + fine[[i + 1, j]] + fine[[i + 1, j + 1]])
    });
    let control = Control::Plane { height_m: plane_m };
    // Averages of a rough map may be flat; then there is no coarse problem.
    let Ok(guess) = ContactProblem::new(coarse, &heights_m, control, problem.hardness_pa()) else {
        return none();
    };
    let closure = Closure::Plane { height_m: plane_m - guess.mean_height_m() };
    let workspace = &mut **workspace.coarse.get_or_insert_default();
    coarse.prepare(workspace);
    let start = under_plane(&guess, plane_m, workspace, monitor);
    let solution = Descent::new(&guess, closure, start, None, workspace).run(COARSE, monitor);
    let hardness_pa = problem.hardness_pa().unwrap_or(f64::INFINITY);
    fine.indexed_iter().map(|((row, column), _)| solution.pressure_pa[[row / 2, column / 2]].min(hardness_pa)).collect()
}
