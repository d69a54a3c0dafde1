//! The plane at which all strips together carry a mean pressure.

use ndarray::Array2;
use rayon::prelude::*;

use crate::FrictionError;
use crate::strip::Strips;
use asperity_base::monitor::{Cancelled, Monitor};
use asperity_contact::{Control, Workspace};

/// Cells of all strips up to which their pressures are kept, to start the next search step from: 256 MiB.
const MOST_KEPT: usize = 1 << 25;
/// Steps before the search is given up, many times those that it takes.
const MOST_STEPS: usize = 60;

/// A plane fixed in space and what it carries.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct PlaneAtLoad {
    /// Height of the plane in the coordinates of the maps, in metre.
    pub plane_m: f64,
    /// Its mean depth below the highest point of the strips, in metre.
    pub penetration_m: f64,
    /// Mean pressure over all strips that it was found to carry, in pascal.
    pub mean_pressure_pa: f64,
    /// Passes over all strips.
    pub passes: usize,
    /// Whether that pressure is the wanted one, to ten times the tolerance of the solver.
    pub converged: bool,
}

/// All strips under one control.
struct Pass {
    mean_pressure_pa: f64,
    penetration_m: f64,
    lowest_m: f64,
    mean_plane_m: f64,
    highest_m: f64,
}

impl Strips<'_> {
    /// The one plane, the same for all strips, under which their mean pressure is `mean_pressure_pa`: the inverse of the load
    /// curve by solving, to ten times the tolerance of the solver; [`PlaneAtLoad::converged`] says whether that was reached.
    ///
    /// Each strip pressed to that pressure alone rests at a plane of its own. At the lowest of these every strip carries at
    /// least that much, at the highest at most, so the plane lies between; the search is by false position in ln p̄ with the
    /// weights of Anderson and Björck, and each solve starts from the last pressure of its strip where memory allows.
    ///
    /// # Errors
    /// A strip could not be solved, or the monitor cancelled.
    ///
    /// # References
    /// N. Anderson and Å. Björck, *BIT* **13** (1973) 253, <https://doi.org/10.1007/BF01951936>.
    pub fn plane_for(&self, mean_pressure_pa: f64, monitor: &dyn Monitor) -> Result<PlaneAtLoad, FrictionError> {
        let keep = self.realisations.saturating_mul(self.half_space.grid().points()) <= MOST_KEPT;
        let mut pressures: Vec<Option<Array2<f64>>> = vec![None; self.realisations];
        let alone = self.pass(Control::MeanPressure { pascal: mean_pressure_pa }, keep, &mut pressures, monitor)?;
        let mut passes = 1;
        let near = |error: f64| error.abs() <= (10.0 * self.solver.tolerance).max(1e-9);
        let mut at = |height_m: f64| -> Result<(f64, PlaneAtLoad), FrictionError> {
            let pass = self.pass(Control::Plane { height_m }, keep, &mut pressures, monitor)?;
            passes += 1;
            let found = PlaneAtLoad {
                plane_m: height_m,
                penetration_m: pass.penetration_m,
                mean_pressure_pa: pass.mean_pressure_pa,
                passes,
                converged: near((pass.mean_pressure_pa / mean_pressure_pa).ln()),
            };
            Ok(((pass.mean_pressure_pa / mean_pressure_pa).ln(), found))
        };
        let (middle, mut best) = at(alone.mean_plane_m)?;
        if near(middle) {
            return Ok(best);
        }
        // ln p̄/p̄₀ falls with the height of the plane: positive at `low`, negative at `high`.
        let other_m = if middle > 0.0 { alone.highest_m } else { alone.lowest_m };
        let (other, found) = at(other_m)?;
        if near(other) {
            return Ok(found);
        }
        let ends = [(alone.mean_plane_m, middle), (other_m, other)];
        let [mut low, mut high] = if middle > 0.0 { ends } else { [ends[1], ends[0]] };
        let mut replaced_low = None;
        for _ in 0..MOST_STEPS {
            let height_m = (low.0 * high.1 - high.0 * low.1) / (high.1 - low.1);
            let (error, found) = at(height_m)?;
            best = found;
            if near(error) {
                break;
            }
            // Where the same end is replaced again, the other counts less, so that it does not stay for ever.
            let replaces_low = error > 0.0;
            let (end, stays) = if replaces_low { (&mut low, &mut high) } else { (&mut high, &mut low) };
            if replaced_low == Some(replaces_low) {
                let share = 1.0 - error / end.1;
                stays.1 *= if share > 0.0 { share } else { 0.5 };
            }
            *end = (height_m, error);
            replaced_low = Some(replaces_low);
        }
        Ok(best)
    }

    /// Solves every strip under one control, starting from its last pressure.
    fn pass(
        &self,
        control: Control,
        keep: bool,
        pressures: &mut [Option<Array2<f64>>],
        monitor: &dyn Monitor,
    ) -> Result<Pass, FrictionError> {
        let solve = |workspace: &mut Workspace, (index, pressure): (usize, &mut Option<Array2<f64>>)| {
            if monitor.cancelled() {
                return Err(FrictionError::Cancelled(Cancelled));
            }
            let failed = |first| FrictionError::TooFewValid {
                valid: self.realisations - 1,
                total: self.realisations,
                wanted: 1.0,
                first,
            };
            let map = self.map(index);
            let heights_m = map.complete_heights_m().map_err(|error| failed(error.to_string()))?;
            let solution = self.solution(heights_m, control, pressure.as_ref(), workspace).map_err(failed)?;
            *pressure = keep.then(|| solution.pressure_pa().clone());
            Ok([solution.mean_pressure_pa(), solution.penetration_m(), solution.plane_m()])
        };
        let strips: Result<Vec<[f64; 3]>, FrictionError> =
            pressures.par_iter_mut().enumerate().map_init(|| self.half_space.workspace(), solve).collect();
        let strips = strips?;
        let mean = |k: usize| strips.iter().map(|strip| strip[k]).sum::<f64>() / strips.len() as f64;
        let planes = || strips.iter().map(|strip| strip[2]);
        Ok(Pass {
            mean_pressure_pa: mean(0),
            penetration_m: mean(1),
            mean_plane_m: mean(2),
            lowest_m: planes().fold(f64::INFINITY, f64::min),
            highest_m: planes().fold(f64::NEG_INFINITY, f64::max),
        })
    }
}
