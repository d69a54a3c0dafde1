//! Contact under a prescribed mean gap.
//!
//! On a periodic half-space without plastic cells the mean displacement is known, so the gap fixes the plane. Otherwise
//! a search finds the plane of this gap. The mean gap rises continuously with the height of the plane, even where the
//! required pressure does not change (a rigid-plastic contact).

use crate::conditions::Closure;
use crate::descent::{Descent, Limits};
use crate::{Boundary, ContactProblem, ContactWorkspace, HalfSpace, Solution, SolverStop};
use asperity_base::monitor::Monitor;

/// Largest number of planes that are tried.
const MOST_PLANES: usize = 200;
/// Tolerance of the first solution under each plane.
const COARSEST_TOLERANCE: f64 = 1e-3;
/// Ratio of the gap error to the tolerance of the fields above which its sign is trusted; below it the tolerance is
/// tightened.
const CLEAR_MISS: f64 = 30.0;
/// Factor by which the tolerance is tightened.
const TIGHTENING: f64 = 0.03;

/// Solves `problem` for the mean gap `gap_m`.
pub(super) fn solve(
    limits: Limits,
    problem: &ContactProblem<'_>,
    gap_m: f64,
    workspace: &mut ContactWorkspace,
    monitor: &dyn Monitor,
) -> Solution {
    let points = problem.heights_m().len();
    let untouched = gap_m >= problem.highest_m() - problem.mean_height_m();
    let periodic = matches!(problem.half_space().boundary(), Boundary::Periodic { .. });
    if untouched || (periodic && problem.hardness_pa().is_none()) {
        let closure = Closure::Gap { metre: gap_m };
        return Descent::new(problem, closure, vec![0.0; points], problem.rigid_mean_m_per_pa(), workspace)
            .run(limits, monitor);
    }
    let mut search = Search::new(limits, problem, gap_m, workspace, monitor);
    if periodic {
        // If no cell is plastic, the hardness does not matter.
        let usual = search.mean_compliance.replace(0.0);
        let (_, solution) = search.at(gap_m, vec![0.0; points], COARSEST_TOLERANCE);
        if search.is_met(&solution) || search.is_over() {
            return search.finish(solution);
        }
        search.mean_compliance = usual;
    }
    let mut solution = search.run(COARSEST_TOLERANCE);
    if solution.stop_reason == SolverStop::PrecisionLimit {
        // A gap error trusted too early may have spoiled the bracket.
        solution = search.run(0.0);
    }
    solution
}

/// A tried plane: its height above the mean height, and the mean gap under it minus the prescribed one.
#[derive(Clone, Copy)]
struct Trial {
    height_m: f64,
    miss_m: f64,
}

struct Search<'a> {
    limits: Limits,
    problem: &'a ContactProblem<'a>,
    gap_m: f64,
    workspace: &'a mut ContactWorkspace,
    monitor: &'a dyn Monitor,
    /// Mean compliance of a periodic half-space. The solution does not depend on it; the usual value is well
    /// conditioned.
    mean_compliance: Option<f64>,
    iterations: usize,
}

impl<'a> Search<'a> {
    fn new(
        limits: Limits,
        problem: &'a ContactProblem<'a>,
        gap_m: f64,
        workspace: &'a mut ContactWorkspace,
        monitor: &'a dyn Monitor,
    ) -> Self {
        let half_space = problem.half_space();
        let usual = HalfSpace::default_mean_compliance_m_per_pa(half_space.grid(), half_space.modulus_pa());
        let mean_compliance = matches!(half_space.boundary(), Boundary::Periodic { .. }).then_some(usual);
        Self { limits, problem, gap_m, workspace, monitor, mean_compliance, iterations: 0 }
    }

    /// Searches the plane; `coarsest` is the tolerance of the first solution under each plane.
    fn run(&mut self, coarsest: f64) -> Solution {
        // Displacements have a positive mean, so the gap under this plane is not below the prescribed one.
        let points = self.problem.heights_m().len();
        let (mut high, mut best) = self.at(self.gap_m, vec![0.0; points], coarsest);
        let mut low: Option<Trial> = None;
        let mut step_m = 0.0_f64;
        let mut last_side = 0;
        for _ in 0..MOST_PLANES {
            if self.is_met(&best) {
                break;
            }
            let height_m = match low {
                // The gap falls by at most the descent of the plane, divided by the fraction of cells out of contact.
                None => {
                    step_m = (2.0 * step_m).max(2.0 * high.miss_m / (1.0 - best.contact_fraction()).max(0.05));
                    high.height_m - step_m
                }
                Some(low) => {
                    let secant =
                        high.height_m - high.miss_m * (high.height_m - low.height_m) / (high.miss_m - low.miss_m);
                    let inside = secant > low.height_m && secant < high.height_m;
                    if inside { secant } else { 0.5 * (low.height_m + high.height_m) }
                }
            };
            let exhausted = low.is_some_and(|low| height_m <= low.height_m) || height_m >= high.height_m;
            if exhausted || self.is_over() {
                break;
            }
            let (trial, solution) = self.at(height_m, best.pressure_pa.iter().copied().collect(), coarsest);
            best = solution;
            // False position, with the retained end's miss lowered when it is retained twice (Anderson and Björck).
            if trial.miss_m > 0.0 {
                if let (Some(low), 1) = (&mut low, last_side) {
                    low.miss_m *= retained_factor(trial.miss_m, high.miss_m);
                }
                high = trial;
                last_side = 1;
            } else {
                if last_side == -1
                    && let Some(low) = low
                {
                    high.miss_m *= retained_factor(trial.miss_m, low.miss_m);
                }
                low = Some(trial);
                last_side = -1;
            }
        }
        self.finish(best)
    }

    /// Solves the contact under a plane at `height_m` above the mean height, as accurately as the error of its gap
    /// requires.
    fn at(&mut self, height_m: f64, start: Vec<f64>, coarsest: f64) -> (Trial, Solution) {
        let rms_height_m = self.problem.rms_height_m();
        // A gap far below the roughness needs fields that are accurate to a fraction of the gap.
        let finest = (0.1 * self.limits.tolerance * (self.gap_m / rms_height_m).min(1.0)).max(f64::EPSILON);
        let mut tolerance = coarsest.max(finest);
        let mut pressure_pa = start;
        loop {
            let max_iterations = self.limits.max_iterations.saturating_sub(self.iterations);
            let closure = Closure::Plane { height_m };
            let descent = Descent::new(self.problem, closure, pressure_pa, self.mean_compliance, self.workspace);
            let mut solution = descent.run(Limits { tolerance, max_iterations }, self.monitor);
            self.iterations += solution.iterations;
            // Cells that are about to lose contact still have a gap, which the solution counts as zero.
            let mean_gap_m = solution.signed_gap_m.iter().map(|g| g.max(0.0)).sum::<f64>() / self.points();
            let miss_m = mean_gap_m - self.gap_m;
            solution.residual.load = miss_m.abs().max((solution.mean_gap_m() - self.gap_m).abs()) / self.gap_m;
            let is_clear = miss_m.abs() > CLEAR_MISS * tolerance * rms_height_m;
            let blur_m = (solution.mean_gap_m() - mean_gap_m).abs();
            let least = if blur_m > 0.5 * self.limits.tolerance * self.gap_m { f64::EPSILON } else { finest };
            if is_clear || tolerance <= least || !solution.converged() {
                return (Trial { height_m, miss_m }, solution);
            }
            tolerance = (TIGHTENING * tolerance).max(if tolerance > finest { finest } else { least });
            pressure_pa = solution.pressure_pa.iter().copied().collect();
        }
    }

    fn points(&self) -> f64 {
        self.problem.heights_m().len() as f64
    }

    fn is_met(&self, solution: &Solution) -> bool {
        solution.residual.worst() <= self.limits.tolerance
    }

    /// Returns whether the iteration limit is reached or the monitor cancelled.
    fn is_over(&self) -> bool {
        self.iterations >= self.limits.max_iterations || self.monitor.cancelled()
    }

    fn finish(&self, mut solution: Solution) -> Solution {
        solution.iterations = self.iterations;
        solution.stop_reason = if self.is_met(&solution) {
            SolverStop::Converged
        } else if self.monitor.cancelled() {
            SolverStop::Cancelled
        } else if self.iterations >= self.limits.max_iterations {
            SolverStop::IterationLimit
        } else {
            SolverStop::PrecisionLimit
        };
        solution
    }
}

/// Returns the factor on the miss of the retained end of a bracket, from the present and the last miss at the moving
/// end.
fn retained_factor(now: f64, before: f64) -> f64 {
    let factor = 1.0 - now / before;
    if factor > 0.0 { factor } else { 0.5 }
}
