//! A first guess under a prescribed load.

use crate::contact::exact::persson_contact_fraction;
use crate::contact::{Boundary, Problem};

/// Cells pressed at first over those that will be in contact, about.
const MARGIN: f64 = 2.0;
/// Share of pressed cells from which on all are pressed alike.
const NEARLY_ALL: f64 = 0.8;
/// Share of the hardness that no cell exceeds at first.
const CEILING: f64 = 0.9;
/// Heights that tell the level above which cells are pressed.
const SAMPLE: usize = 4096;

/// Pressure of the mean `pascal`: in proportion to the height above a level that about twice as many cells exceed as will be
/// in contact, after Persson's A/A₀ = erf(√2 p̄/(E* h′)) with the rms slope h′; the same everywhere where that are most.
///
/// # References
/// B. N. J. Persson, *J. Chem. Phys.* **115** (2001) 3840, <https://doi.org/10.1063/1.1388626>.
pub(super) fn under_load(problem: &Problem<'_>, pascal: f64) -> Vec<f64> {
    let heights_m = problem.heights_m();
    let uniform = || vec![pascal; heights_m.len()];
    let slope = rms_slope(problem);
    let least = problem.hardness_pa().map_or(0.0, |hardness_pa| pascal / hardness_pa);
    let modulus_pa = problem.half_space().modulus_pa();
    let share = MARGIN * persson_contact_fraction(pascal, modulus_pa, slope).max(least);
    if !(share > 0.0 && share < NEARLY_ALL) {
        return uniform();
    }
    let stride = heights_m.len().div_ceil(SAMPLE);
    let mut sample: Vec<f64> = heights_m.iter().copied().step_by(stride).collect();
    let place = ((1.0 - share) * sample.len() as f64) as usize;
    let place = place.min(sample.len() - 1);
    let (_, level_m, _) = sample.select_nth_unstable_by(place, f64::total_cmp);
    let level_m = level_m.min(problem.highest_m() - 1e-3 * problem.rms_height_m());
    let mut p: Vec<f64> = heights_m.iter().map(|z| (z - level_m).max(0.0)).collect();
    let scale = pascal * p.len() as f64 / p.iter().sum::<f64>();
    p.iter_mut().for_each(|p| *p *= scale);
    // What is cut off here, the solver's projection adds again.
    let ceiling = problem.hardness_pa().map_or(f64::INFINITY, |hardness_pa| CEILING * hardness_pa);
    p.iter_mut().for_each(|p| *p = p.min(ceiling));
    if p.iter().all(|p| p.is_finite()) { p } else { uniform() }
}

/// Root mean square of the slope between neighbours.
fn rms_slope(problem: &Problem<'_>) -> f64 {
    let (grid, heights_m) = (problem.half_space().grid(), problem.heights_m());
    let (ny, nx) = grid.shape();
    let wraps = matches!(problem.half_space().boundary(), Boundary::Periodic { .. });
    let mut sum = 0.0;
    for ((row, column), z) in heights_m.indexed_iter() {
        if column + 1 < nx || wraps {
            sum += ((heights_m[[row, (column + 1) % nx]] - z) / grid.dx_m()).powi(2);
        }
        if row + 1 < ny || wraps {
            sum += ((heights_m[[(row + 1) % ny, column]] - z) / grid.dy_m()).powi(2);
        }
    }
    (sum / heights_m.len() as f64).sqrt()
}
