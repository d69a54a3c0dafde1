//! Unloading, re-loading and load cycles of an elasto-plastic contact.
//!
//! A contact with hardness H leaves the plastic displacement u_pl where p = H (see [`ContactProblem`]). It is permanent: the
//! next load acts on the heights z − u_pl. At the same load the pressure p still solves the problem on these heights,
//! now without overlap. Two consequences follow.
//!
//! - A load that is reached again, or from above, is carried elastically.
//! - A load that rises step by step ends in the state of a single step, if the pressure of no cell at the hardness falls
//!   on the way. On a half-space this holds: the pressure added by a further approach Δδ is that of a flat punch in the
//!   shape of the contact below the hardness. It is nowhere negative, and its displacement nowhere exceeds Δδ. (Both follow
//!   from the maximum principle of the potential 1/r. The response of a layer need not obey it, so on layers the path
//!   may matter.)
//!
//! So repeated equal cycles shake down after the first. Over a path that ends unloaded, the work of the flat ∮F dδ
//! equals the plastic dissipation Σ H Δu_pl dA, because the elastic energy ½ Σ p u dA depends only on the current
//! pressure.
//!
//! Heights stay in the coordinates of the original map: a penetration counts from *its* highest point and a percentile
//! from *its* heights, also after plastic flattening.
//!
//! # References
//! A. Almqvist, F. Sahlin, R. Larsson and S. Glavatskih, *Tribology International* **40** (2007) 574,
//! <https://doi.org/10.1016/j.triboint.2005.11.008>.

use ndarray::{Array2, Zip};

use crate::{ContactError, ContactProblem, ContactWorkspace, Control, HalfSpace, Solution, Solver};
use asperity_base::monitor::{Monitor, Silent};

/// A surface on a load path, with the imprint of the loads so far.
#[derive(Debug, Clone)]
pub struct LoadPath<'a> {
    half_space: &'a HalfSpace,
    original_heights_m: &'a Array2<f64>,
    hardness_pa: Option<f64>,
    residual_heights_m: Array2<f64>,
    plastic_work_j: f64,
    workspace: ContactWorkspace,
}

/// One load on a path.
#[derive(Debug, Clone)]
pub struct LoadStep {
    /// Prescribed load or position.
    pub control: Control,
    /// The contact on the heights that the loads before had left; `None` after complete unloading, when nothing
    /// touches.
    pub solution: Option<Solution>,
    /// Height of the flat in metre, in the coordinates of the map. Without load the flat touches the highest remaining
    /// point.
    pub plane_m: f64,
    /// Load in newton.
    pub load_n: f64,
    /// Largest plastic displacement that this load added, in metre.
    pub largest_increment_m: f64,
    /// Work that this load dissipated, Σ p Δu_pl dA, in joule.
    pub plastic_work_j: f64,
}

impl LoadStep {
    /// Returns whether the contact converged; true for an unloaded surface.
    pub fn converged(&self) -> bool {
        self.solution.as_ref().is_none_or(Solution::converged)
    }

    /// Returns the elastic energy ½ Σ p u dA in joule. Under a prescribed load on a periodic half-space it includes the
    /// energy of the mean compliance.
    pub fn elastic_energy_j(&self) -> f64 {
        self.solution.as_ref().map_or(0.0, Solution::elastic_energy_j)
    }
}

impl<'a> LoadPath<'a> {
    /// Creates a surface that has not been loaded yet; `hardness_pa = None` is elastic and keeps no imprint.
    ///
    /// # Errors
    /// As [`ContactProblem::new`].
    pub fn new(
        half_space: &'a HalfSpace,
        heights_m: &'a Array2<f64>,
        hardness_pa: Option<f64>,
    ) -> Result<Self, ContactError> {
        // Validates heights and hardness.
        ContactProblem::new(half_space, heights_m, Control::Penetration { metre: 0.0 }, hardness_pa)?;
        Ok(Self {
            half_space,
            original_heights_m: heights_m,
            hardness_pa,
            residual_heights_m: heights_m.clone(),
            plastic_work_j: 0.0,
            workspace: half_space.workspace(),
        })
    }

    /// Returns the contact problem on `heights_m`.
    fn problem<'p>(&'p self, heights_m: &'p Array2<f64>, control: Control) -> Result<ContactProblem<'p>, ContactError> {
        ContactProblem::new(self.half_space, heights_m, control, self.hardness_pa)
    }

    /// Applies `control` to the heights left by the loads before, and keeps the imprint. A load or mean
    /// pressure of zero is complete unloading.
    ///
    /// Plastic displacements below the tolerance of the solution are not added to the imprint; if they are real, the
    /// next load produces them again. A solution that did not converge leaves no imprint.
    ///
    /// # Errors
    /// The errors of [`ContactProblem::new`] on the remaining heights ([`ContactError::Flat`] if they are flat) and of
    /// [`Solver::solve`].
    pub fn press(&mut self, control: Control, solver: &Solver) -> Result<LoadStep, ContactError> {
        self.press_with(control, solver, &Silent)
    }

    /// Applies a load like [`LoadPath::press`]. When the monitor cancels, the solution is not converged and no imprint
    /// is kept.
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

    /// Applies each of `controls` in turn. The steps end early at one that does not converge, for example when the
    /// monitor cancels.
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

    /// Returns the heights without load, z − u_pl, in metre.
    pub fn residual_heights_m(&self) -> &Array2<f64> {
        &self.residual_heights_m
    }

    /// Returns the plastic displacement of all loads together in metre, ≥ 0.
    pub fn plastic_displacement_m(&self) -> Array2<f64> {
        self.original_heights_m - &self.residual_heights_m
    }

    /// Returns the work dissipated by all loads together in joule.
    pub fn plastic_work_j(&self) -> f64 {
        self.plastic_work_j
    }

    /// Replaces a control that depends on the heights by the height of its plane in the coordinates of the original map.
    fn in_coordinates_of_the_map(&self, control: Control) -> Result<Control, ContactError> {
        let original = self.problem(self.original_heights_m, control)?;
        Ok(original.plane_m().map_or(control, |height_m| Control::Plane { height_m }))
    }
}

impl Solution {
    /// Returns the heights z − u_pl in metre that remain of `heights_m` after complete unloading.
    ///
    /// # Panics
    /// If the heights do not fit the grid.
    pub fn residual_heights_m(&self, heights_m: &Array2<f64>) -> Array2<f64> {
        heights_m - &self.plastic_displacement_m()
    }
}

#[cfg(test)]
mod tests;
