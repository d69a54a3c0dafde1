//! Unloading, re-loading and load cycles of an elasto-plastic contact.
//!
//! A contact with hardness H leaves the plastic displacement u_pl where p = H (see [`Problem`]). The surface keeps it:
//! the next load meets the heights z − u_pl. At the same load the pressure p still solves the problem on these heights,
//! with no overlap left, so that
//!
//! - a load that is reached again, or from above, is carried elastically;
//! - a load that rises step by step ends where one step to it does, provided that no cell at the hardness is relieved
//!   on the way. On a half-space none is: the pressure that a further approach Δδ adds is that of a flat punch in the
//!   shape of the contact below the hardness, nowhere negative, and its displacement nowhere exceeds Δδ. (Both follow
//!   from the maximum principle of the potential 1/r, which the response of a layer need not have; on layers the path
//!   may matter.)
//!
//! So repeated equal cycles shake down after the first. Over a path that ends unloaded the work of the flat ∮F dδ is
//! what plastic flow dissipates, Σ H Δu_pl dA: the elastic energy ½ Σ p u dA is that of the current pressure alone.
//!
//! Heights stay in the coordinates of the map as it was: a penetration counts from *its* highest point, a percentile
//! from *its* heights, whatever has been flattened since.
//!
//! # References
//! A. Almqvist, F. Sahlin, R. Larsson and S. Glavatskih, *Tribology International* **40** (2007) 574,
//! <https://doi.org/10.1016/j.triboint.2005.11.008>.

use ndarray::{Array2, Zip};

use crate::{ContactError, Control, HalfSpace, Problem, Solution, Solver, Workspace};
use asperity_base::monitor::{Monitor, Silent};

/// A surface on its way through loads, with the imprint they left.
#[derive(Debug, Clone)]
pub struct LoadPath<'a> {
    half_space: &'a HalfSpace,
    original_heights_m: &'a Array2<f64>,
    hardness_pa: Option<f64>,
    residual_heights_m: Array2<f64>,
    plastic_work_j: f64,
    workspace: Workspace,
}

/// One load on a path.
#[derive(Debug, Clone)]
pub struct LoadStep {
    /// What was asked for.
    pub control: Control,
    /// The contact on the heights that the loads before had left; `None` after complete unloading, where nothing
    /// touches.
    pub solution: Option<Solution>,
    /// Height of the flat in metre, in the coordinates of the map; without load, where it touches the highest point
    /// left.
    pub plane_m: f64,
    /// Load in newton.
    pub load_n: f64,
    /// Largest plastic displacement that this load added, in metre.
    pub largest_increment_m: f64,
    /// Work that this load dissipated, Σ p Δu_pl dA, in joule.
    pub plastic_work_j: f64,
}

impl LoadStep {
    /// Whether the contact is solved; an unloaded surface is.
    pub fn converged(&self) -> bool {
        self.solution.as_ref().is_none_or(Solution::converged)
    }

    /// Elastic energy ½ Σ p u dA in joule. Under a prescribed load on a periodic half-space it contains the mean
    /// compliance's share.
    pub fn elastic_energy_j(&self) -> f64 {
        self.solution.as_ref().map_or(0.0, Solution::elastic_energy_j)
    }
}

impl<'a> LoadPath<'a> {
    /// A surface that has not been loaded yet; `hardness_pa = None` is elastic and keeps no imprint.
    ///
    /// # Errors
    /// As [`Problem::new`].
    pub fn new(
        half_space: &'a HalfSpace,
        heights_m: &'a Array2<f64>,
        hardness_pa: Option<f64>,
    ) -> Result<Self, ContactError> {
        // Refuses heights and a hardness that pose no problem.
        Problem::new(half_space, heights_m, Control::Penetration { metre: 0.0 }, hardness_pa)?;
        Ok(Self {
            half_space,
            original_heights_m: heights_m,
            hardness_pa,
            residual_heights_m: heights_m.clone(),
            plastic_work_j: 0.0,
            workspace: half_space.workspace(),
        })
    }

    /// The problem of pressing on `heights_m`.
    fn problem<'p>(&'p self, heights_m: &'p Array2<f64>, control: Control) -> Result<Problem<'p>, ContactError> {
        Problem::new(self.half_space, heights_m, control, self.hardness_pa)
    }

    /// Presses as `control` says, on the heights left by the loads before, and keeps the imprint. A load or mean
    /// pressure of zero is complete unloading.
    ///
    /// Plastic displacements below the tolerance of the solution are not taken for true; where they are, the next load
    /// meets them again. A solution that is not converged leaves no imprint.
    ///
    /// # Errors
    /// As [`Problem::new`], the map being that of the heights left ([`ContactError::Flat`] if nothing of it is), and
    /// [`Solver::solve`].
    pub fn press(&mut self, control: Control, solver: &Solver) -> Result<LoadStep, ContactError> {
        self.press_with(control, solver, &Silent)
    }

    /// As [`LoadPath::press`]; when the monitor cancels, the solution is not converged and the surface is as it was.
    ///
    /// # Errors
    /// As [`LoadPath::press`].
    pub fn press_with(
        &mut self,
        control: Control,
        solver: &Solver,
        monitor: &dyn Monitor,
    ) -> Result<LoadStep, ContactError> {
        if let Control::Load { newton: 0.0 } | Control::MeanPressure { pascal: 0.0 } = control {
            let plane_m = self.residual_heights_m.iter().copied().fold(f64::NEG_INFINITY, f64::max);
            return Ok(LoadStep {
                control,
                solution: None,
                plane_m,
                load_n: 0.0,
                largest_increment_m: 0.0,
                plastic_work_j: 0.0,
            });
        }
        let fixed = self.in_coordinates_of_the_map(control)?;
        let mut workspace = std::mem::take(&mut self.workspace);
        let problem = self.problem(&self.residual_heights_m, fixed)?;
        let least_m = solver.tolerance * problem.rms_height_m();
        let solution = solver.solve_from(&problem, None, &mut workspace, monitor)?;
        self.workspace = workspace;
        let (mut largest_increment_m, mut plastic_work_j) = (0.0_f64, 0.0);
        if solution.converged() {
            let increment_m = solution.plastic_displacement_m();
            Zip::from(&mut self.residual_heights_m).and(&increment_m).and(solution.pressure_pa()).for_each(
                |z, increment_m, pressure_pa| {
                    if *increment_m > least_m {
                        *z -= increment_m;
                        plastic_work_j += pressure_pa * increment_m;
                        largest_increment_m = largest_increment_m.max(*increment_m);
                    }
                },
            );
            plastic_work_j *= solution.grid().cell_area_m2();
            self.plastic_work_j += plastic_work_j;
        }
        let (plane_m, load_n) = (solution.plane_m(), solution.load_n());
        Ok(LoadStep { control, solution: Some(solution), plane_m, load_n, largest_increment_m, plastic_work_j })
    }

    /// Presses as each of `controls` says, in turn; the steps end early with one that is not converged, as it is when the monitor
    /// cancels.
    ///
    /// # Errors
    /// As [`LoadPath::press`].
    pub fn follow(
        &mut self,
        controls: &[Control],
        solver: &Solver,
        monitor: &dyn Monitor,
    ) -> Result<Vec<LoadStep>, ContactError> {
        let mut steps = Vec::with_capacity(controls.len());
        for control in controls {
            let step = self.press_with(*control, solver, monitor)?;
            let goes_on = step.converged();
            steps.push(step);
            monitor.progress("load path", steps.len(), controls.len());
            if !goes_on {
                break;
            }
        }
        Ok(steps)
    }

    /// The heights that are left without load, z − u_pl, in metre.
    pub fn residual_heights_m(&self) -> &Array2<f64> {
        &self.residual_heights_m
    }

    /// Plastic displacement of all loads together in metre, ≥ 0.
    pub fn plastic_displacement_m(&self) -> Array2<f64> {
        self.original_heights_m - &self.residual_heights_m
    }

    /// Work dissipated by all loads together in joule.
    pub fn plastic_work_j(&self) -> f64 {
        self.plastic_work_j
    }

    /// The control with a plane that depends on the heights fixed in the coordinates of the map as it was.
    fn in_coordinates_of_the_map(&self, control: Control) -> Result<Control, ContactError> {
        let original = self.problem(self.original_heights_m, control)?;
        Ok(original.plane_m().map_or(control, |height_m| Control::Plane { height_m }))
    }
}

impl Solution {
    /// The heights z − u_pl in metre that are left of `heights_m` after complete unloading.
    ///
    /// # Panics
    /// If the heights do not fit the grid.
    pub fn residual_heights_m(&self, heights_m: &Array2<f64>) -> Array2<f64> {
        heights_m - &self.plastic_displacement_m()
    }
}

/// Work −∫F dd in joule that the flat does along `steps`, d being its height, by the trapezoidal rule. With equal steps
/// of the load from first touch on, where the approach rises as F^{2/3}, its error falls with their number to the power
/// 5/3.
pub fn work_of_flat_j(steps: &[LoadStep]) -> f64 {
    steps.windows(2).map(|pair| 0.5 * (pair[0].load_n + pair[1].load_n) * (pair[0].plane_m - pair[1].plane_m)).sum()
}

#[cfg(test)]
mod tests;
