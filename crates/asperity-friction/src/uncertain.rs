//! Friction of several random surfaces with the same strips: plan and blocks.

use asperity_base::blocks::Task;
use asperity_base::monitor::{Cancelled, Monitor};
use asperity_contact::Control;
use asperity_surface::RandomSurface;

use crate::level_control::LevelControl;
use crate::replicates::MomentReplicates;
use crate::strip::StripProblem;

/// Strips of several random surfaces, each with other parameters. All surfaces use the same random numbers.
#[derive(Debug, Clone, Copy)]
pub struct UncertainPlan<'a> {
    /// Contact problem of the strips.
    pub problem: &'a StripProblem,
    /// Levels; a percentile refers to the heights of each surface.
    pub levels: &'a [LevelControl],
    /// Number of surfaces.
    pub points: usize,
    /// Number of strips of each surface.
    pub realisations: usize,
    /// Seed of the strips.
    pub seed: u64,
}

/// Moments of the friction of one surface by level: of the quotient F/N and at the mean load, or the reason of the failure.
pub type PointMoments = Vec<Result<[MomentReplicates; 2], String>>;

impl UncertainPlan<'_> {
    /// Returns the task of all blocks.
    pub fn task<'t>(&self, monitor: &'t dyn Monitor) -> Task<'t> {
        Task::new(monitor, "friction uncertainty", self.points * self.realisations * self.levels.len())
    }

    /// Solves one block: the strips of one surface, with this quantile of its heights in metre, at all levels.
    ///
    /// # Errors
    /// The monitor cancelled.
    pub fn solve(
        &self,
        surface: &dyn RandomSurface,
        height_quantile_m: impl Fn(f64) -> f64,
        task: &Task<'_>,
    ) -> Result<PointMoments, Cancelled> {
        let strips = self.problem.strips(surface, self.realisations, self.seed);
        let controls: Vec<Control> = self.levels.iter().map(|level| level.contact(&height_quantile_m)).collect();
        let step_m = self.problem.window.step_m();
        let levels = strips.solve_steps(&controls, task)?.into_iter().map(|level| {
            let level = level.map_err(|error| error.to_string())?;
            Ok([MomentReplicates::from_quotients(&level, step_m), MomentReplicates::from_mean_load(&level, step_m)])
        });
        Ok(levels.collect())
    }
}
