//! Initial pressure under a prescribed load.

use crate::exact::persson_contact_fraction;
use crate::{ContactProblem, rms_gradient};

/// Number of initially pressed cells over the expected number of cells in contact.
const MARGIN: f64 = 2.0;
/// Fraction of pressed cells above which the initial pressure is uniform.
const NEARLY_ALL: f64 = 0.8;
/// Largest initial pressure over the hardness.
const LARGEST: f64 = 0.9;
/// Number of sampled heights that determine the level, and the least number above it; with fewer, all heights are used.
const SAMPLE: usize = 4096;
const ABOVE: f64 = 64.0;

/// Returns a pressure of mean `pascal` in proportion to the height above a level.
///
/// About twice as many cells exceed the level as Persson's A/A₀ = erf(√2 p̄/(E* h′)) expects in contact, with the rms
/// slope h′. If these are most of the cells, the pressure is uniform.
///
/// # References
/// B. N. J. Persson, *J. Chem. Phys.* **115** (2001) 3840, <https://doi.org/10.1063/1.1388626>.
pub(super) fn under_load(problem: &ContactProblem<'_>, pascal: f64) -> Vec<f64> {
    let heights_m = problem.heights_m();
    let largest_pa = problem.hardness_pa().map_or(f64::INFINITY, |hardness_pa| LARGEST * hardness_pa);
    let uniform = || vec![pascal.min(largest_pa / LARGEST); heights_m.len()];
    let half_space = problem.half_space();
    let slope = rms_gradient(heights_m, half_space.grid(), half_space.boundary());
    let least = problem.hardness_pa().map_or(0.0, |hardness_pa| pascal / hardness_pa);
    let modulus_pa = half_space.modulus_pa();
    let fraction = MARGIN * persson_contact_fraction(pascal, modulus_pa, slope).max(least);
    if !(fraction > 0.0 && fraction < NEARLY_ALL) {
        return uniform();
    }
    let stride = if fraction * SAMPLE as f64 > ABOVE { stride(heights_m.len(), heights_m.ncols()) } else { 1 };
    // First the sample, then the pressure.
    let mut p = Vec::with_capacity(heights_m.len());
    p.extend(heights_m.iter().step_by(stride));
    let place = (((1.0 - fraction) * p.len() as f64) as usize).min(p.len() - 1);
    let (_, level_m, _) = p.select_nth_unstable_by(place, f64::total_cmp);
    let level_m = level_m.min(problem.highest_m() - 1e-3 * problem.rms_height_m());
    p.clear();
    p.extend(heights_m.iter().map(|z| (z - level_m).max(0.0)));
    let scale = pascal * p.len() as f64 / p.iter().sum::<f64>();
    p.iter_mut().for_each(|p| *p *= scale);
    // If the cells can carry the load, the solver's projection restores the pressure that is cut off here.
    let mut capacity = 0.0;
    for p in p.iter_mut().filter(|p| **p > 0.0) {
        *p = p.min(largest_pa);
        capacity += largest_pa;
    }
    if p.iter().all(|p| p.is_finite()) && capacity > pascal * p.len() as f64 { p } else { uniform() }
}

/// Returns a stride through a map that leaves about [`SAMPLE`] points, from all of its columns.
fn stride(points: usize, columns: usize) -> usize {
    let divisor = |mut a: usize, mut b: usize| {
        while b > 0 {
            (a, b) = (b, a % b);
        }
        a
    };
    (points.div_ceil(SAMPLE)..).find(|stride| divisor(*stride, columns) == 1).unwrap_or(1)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{Boundary, Control, HalfSpace};
    use asperity_base::map::{Grid, HeightMap};

    /// Returns the initial pressure on a map under a mean pressure.
    fn start(grid: Grid, heights: impl Fn(f64, f64) -> f64, pascal: f64, hardness_pa: f64) -> Vec<f64> {
        let map = HeightMap::from_function(grid, heights).unwrap();
        let half_space = HalfSpace::new(grid, 1.0, Boundary::Free).unwrap();
        let control = Control::MeanPressure { pascal };
        under_load(&ContactProblem::new(&half_space, map.heights_m(), control, Some(hardness_pa)).unwrap(), pascal)
    }

    #[test]
    fn enough_cells_are_pressed_to_carry_the_load_at_the_hardness() {
        let can_carry = |p: &[f64], pascal: f64, hardness_pa: f64| {
            p.iter().filter(|p| **p > 0.0).count() as f64 * hardness_pa > pascal * p.len() as f64
        };
        // One summit over a plateau. The level is the plateau, and only the summit lies above it.
        let plateau = |x: f64, y: f64| {
            if x + y < 1.0 {
                10.0
            } else if y < 32.0 {
                1.0
            } else {
                0.0
            }
        };
        let p = start(Grid::new(64, 64, 1.0, 1.0).unwrap(), plateau, 1e-6, 1e-5);
        assert!(can_carry(&p, 1e-6, 1e-5));
        // A wave whose crest a stride of one row would miss, and a load on few of many cells.
        let wave = |x: f64, _: f64| (std::f64::consts::TAU * (x - 8.0) / 16.0).cos() + 1e-3 * x;
        let p = start(Grid::new(16, 4096, 1.0, 1.0).unwrap(), wave, 3e-7, 1e-6);
        assert!(can_carry(&p, 3e-7, 1e-6) && p.iter().filter(|p| **p > 0.0).count() < p.len());
        let rough = |x: f64, y: f64| (12.9 * x).sin() * (7.1 * y + 0.3 * x).cos();
        let p = start(Grid::new(256, 256, 1.0, 1.0).unwrap(), rough, 1e-10, 1e-6);
        assert!(can_carry(&p, 1e-10, 1e-6) && p.iter().filter(|p| **p > 0.0).count() < 100);
    }

    #[test]
    fn the_highest_cells_are_pressed_within_the_bounds() {
        let grid = Grid::new(64, 48, 1.0, 1.0).unwrap();
        let waves = |x: f64, y: f64| (0.4 * x).sin() * (0.55 * y).cos() + 0.3 * (1.1 * x + 0.7 * y).sin();
        let map = HeightMap::from_function(grid, waves).unwrap();
        let boundary = Boundary::Periodic { mean_compliance_m_per_pa: 0.0 };
        let half_space = HalfSpace::new(grid, 1.0, boundary).unwrap();
        for (pascal, hardness_pa) in [(1e-4, None), (0.02, None), (0.02, Some(0.1)), (0.02, Some(0.021)), (3.0, None)] {
            let control = Control::MeanPressure { pascal };
            let problem = ContactProblem::new(&half_space, map.heights_m(), control, hardness_pa).unwrap();
            let p = under_load(&problem, pascal);
            assert!(p.iter().all(|p| *p >= 0.0 && *p <= hardness_pa.unwrap_or(f64::INFINITY)));
            let mean = p.iter().sum::<f64>() / p.len() as f64;
            assert!(mean <= pascal * (1.0 + 1e-12) && mean > 0.3 * pascal, "{mean} of {pascal}");
            // Every pressed cell is at least as high as every other cell.
            let range = |pressed: bool| {
                let heights = map.heights_m().iter().zip(&p).filter(|(_, p)| (**p > 0.0) == pressed).map(|(z, _)| *z);
                heights.fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), z| (low.min(z), high.max(z)))
            };
            assert!(range(true).0 >= range(false).1);
        }
    }
}
