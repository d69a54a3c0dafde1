//! A first guess under a prescribed plane.

use ndarray::Array2;

use crate::descent::Descent;
use crate::solver::Closure;
use crate::{Control, Problem, Solver, Workspace};
use asperity_base::monitor::Monitor;

/// How well the guesses are solved: what is finer than their cells is missing anyway.
const SOLVER: Solver = Solver { tolerance: 1e-2, max_iterations: 100 };

/// Pressure under a plane at `plane_m` on cells twice as wide, found in the same way; zero where the cells cannot be halved.
///
/// Under a prescribed plane the load is unknown, and from zero pressure it builds up slowly, wave by long wave; the coarse
/// grid settles it at a quarter of the cost.
pub(super) fn under_plane(
    problem: &Problem<'_>,
    plane_m: f64,
    workspace: &mut Workspace,
    monitor: &dyn Monitor,
) -> Vec<f64> {
    let none = || vec![0.0; problem.heights_m().len()];
    let Some(coarse) = problem.half_space().coarse() else {
        return none();
    };
    let fine = problem.heights_m();
    let average = |fine: &Array2<f64>| {
        Array2::from_shape_fn(coarse.grid().shape(), |(row, column)| {
            let (i, j) = (2 * row, 2 * column);
            0.25 * (fine[[i, j]] + fine[[i, j + 1]] + fine[[i + 1, j]] + fine[[i + 1, j + 1]])
        })
    };
    let heights_m = average(fine);
    let control = Control::Plane { height_m: plane_m };
    // Averages of a rough map may be flat, which is no guess.
    let Ok(mut guess) = Problem::new(coarse, &heights_m, control, problem.hardness_pa()) else {
        return none();
    };
    let hardness_pa = problem.hardness_field_pa().map(average);
    if let Some(hardness_pa) = &hardness_pa {
        guess = match guess.with_hardness_field(hardness_pa) {
            Ok(guess) => guess,
            Err(_) => return none(),
        };
    }
    let closure = Closure::Plane { height_m: plane_m - guess.mean_height_m() };
    let workspace = &mut **workspace.coarse.get_or_insert_default();
    coarse.claim(workspace);
    let start = under_plane(&guess, plane_m, workspace, monitor);
    let solution = Descent::new(&guess, closure, &start, None, workspace).run(&SOLVER, monitor);
    let refined = |((row, column), _)| solution.pressure_pa[[row / 2, column / 2]];
    let Some(upper) = problem.hardness_by_cell() else {
        return fine.indexed_iter().map(refined).collect();
    };
    fine.indexed_iter().map(refined).enumerate().map(|(place, p)| p.min(upper(place))).collect()
}
