//! The moving parts of one solve: see [`Solver`].

use ndarray::Array2;

use crate::contact::half_space::MeanMode;
use crate::contact::projection::{may_move, project_to_sum, tangent_multiplier};
use crate::contact::solution::certify;
use crate::contact::solver::{Closure, Solver};
use crate::contact::vectors::{centre, dot, gather, norm, scatter, sums};
use crate::contact::{Boundary, Problem, Solution, StopReason, Workspace};

/// Every so many iterations a plain gradient projection guarantees convergence.
const GRADIENT_PROJECTION_PERIOD: usize = 32;
/// A clipped step is taken whole when its optimal length is at least this share of it.
const WHOLE_STEP_FROM: f64 = 0.7;
/// Under a prescribed sum no step is lengthened more than this, for the sum of a step is zero up to rounding only.
const LONGEST_STEP: f64 = 1e6;
/// Below this residual rounding may be all that is left of the steps,
const ROUNDING_RESIDUAL: f64 = 1e-12;
/// and is taken to be when so many of them have not halved it.
const WANDERING_ITERATIONS: usize = 100;
/// A direction counts as descent when its slope is at least this share of the steepest one's.
const LEAST_SLOPE: f64 = 1e-4;

/// The iterate of one solve. Heights are counted from their mean, and `v` = S p − z throughout.
///
/// Most cells of a rough contact are out of contact and stay so: what concerns the cells that may move is kept in lists
/// over these.
pub(super) struct Descent<'a> {
    problem: &'a Problem<'a>,
    closure: Closure,
    workspace: &'a mut Workspace,
    upper: f64,
    mean: MeanMode,
    /// Mean compliance of the half-space beyond that of `mean`, in m/Pa.
    missing_compliance_m_per_pa: f64,
    heights_m: Vec<f64>,
    p: Vec<f64>,
    v: Vec<f64>,
    /// The last step, zero where nothing moved, and its image under S.
    step: Vec<f64>,
    image: Vec<f64>,
    scratch: Vec<f64>,
    /// Cells that may move.
    members: Vec<usize>,
    /// Sum of the other cells' pressures.
    held_pressure: f64,
    /// Of the members: pressure, gradient, preconditioned gradient, last step and image, and the step on trial.
    pressure: Vec<f64>,
    gradient: Vec<f64>,
    preconditioned: Vec<f64>,
    last_step: Vec<f64>,
    last_image: Vec<f64>,
    trial: Vec<f64>,
    step_length: f64,
    has_history: bool,
}

/// What one attempt at a direction is built from.
#[derive(Clone, Copy, PartialEq)]
enum Direction {
    Conjugate,
    Preconditioned,
    Gradient,
}

impl<'a> Descent<'a> {
    /// Starts from the pressure `p` within the bounds, and on a periodic half-space with the mean compliance given here
    /// if any, in m/Pa.
    pub(super) fn new(
        problem: &'a Problem<'a>,
        closure: Closure,
        p: Vec<f64>,
        mean_compliance: Option<f64>,
        workspace: &'a mut Workspace,
    ) -> Self {
        let n = p.len();
        let missing_compliance_m_per_pa = match (problem.half_space().boundary(), mean_compliance) {
            (Boundary::Periodic { mean_compliance_m_per_pa }, Some(used)) => mean_compliance_m_per_pa - used,
            _ => 0.0,
        };
        let mut descent = Self {
            problem,
            closure,
            workspace,
            upper: problem.hardness_pa().unwrap_or(f64::INFINITY),
            mean: problem.half_space().mean_mode(mean_compliance),
            missing_compliance_m_per_pa,
            heights_m: problem.heights_m().iter().map(|z| z - problem.mean_height_m()).collect(),
            p,
            v: vec![0.0; n],
            step: vec![0.0; n],
            image: vec![0.0; n],
            scratch: vec![0.0; n],
            members: Vec::new(),
            held_pressure: 0.0,
            pressure: Vec::new(),
            gradient: Vec::new(),
            preconditioned: Vec::new(),
            last_step: Vec::new(),
            last_image: Vec::new(),
            trial: Vec::new(),
            step_length: 1.0,
            has_history: false,
        };
        descent.refresh();
        descent
    }

    /// Undoes the drift of rounding in the recurrences: restores the prescribed sum by a common shift of the cells between
    /// the bounds, recomputes v = S p − z, and forgets the last step.
    fn refresh(&mut self) {
        self.has_history = false;
        if let Closure::Sum { pascal } = self.closure {
            let upper = self.upper;
            self.collect(|p, _| p > 0.0 && p < upper);
            project_to_sum(&mut self.pressure, self.upper, pascal - self.held_pressure);
            for (i, p) in self.members.iter().zip(&self.pressure) {
                self.p[*i] = *p;
            }
        }
        if self.p.iter().all(|p| *p == 0.0) {
            self.v.fill(0.0);
        } else {
            self.problem.half_space().displace_as(self.mean, &self.p, &mut self.v, self.workspace);
        }
        for (v, z) in self.v.iter_mut().zip(&self.heights_m) {
            *v -= z;
        }
    }

    /// Iterates until the freshly evaluated residuals are below the tolerance, or no progress can be represented.
    pub(super) fn run(mut self, solver: &Solver) -> Solution {
        let mut lambda = match self.closure.plane_m() {
            Some(height_m) => -height_m,
            None => self.v.iter().sum::<f64>() / self.v.len() as f64,
        };
        let mut iterations = 0;
        let mut is_fresh = true;
        let mut last_refuted = f64::INFINITY;
        let (mut least, mut least_at) = (f64::INFINITY, 0);
        let stop_reason = loop {
            let (_, mut residual) = certify(self.problem, self.closure, &self.p, &self.v);
            if residual.worst() <= solver.tolerance && !is_fresh {
                self.refresh();
                is_fresh = true;
                (_, residual) = certify(self.problem, self.closure, &self.p, &self.v);
                // Rounding that undoes the progress made since it last did so leaves none to be made.
                if residual.worst() > solver.tolerance && residual.worst() > 0.5 * last_refuted {
                    break StopReason::PrecisionLimit;
                }
                last_refuted = residual.worst();
            }
            if residual.worst() <= solver.tolerance {
                break StopReason::Converged;
            }
            let field_residual = residual.frank_wolfe.max(residual.overlap);
            if field_residual <= 0.5 * least {
                (least, least_at) = (field_residual, iterations);
            }
            let wanders = field_residual < ROUNDING_RESIDUAL && iterations > least_at + WANDERING_ITERATIONS;
            if wanders || iterations >= solver.max_iterations {
                self.refresh();
                break if wanders { StopReason::PrecisionLimit } else { StopReason::IterationLimit };
            }
            lambda = self.gradient_on_working_set(lambda);
            let projection_turn = iterations % GRADIENT_PROJECTION_PERIOD == GRADIENT_PROJECTION_PERIOD - 1;
            if self.descend(lambda, projection_turn) {
                iterations += 1;
                is_fresh = false;
            } else if is_fresh {
                break StopReason::PrecisionLimit;
            } else {
                self.refresh();
                is_fresh = true;
            }
        };
        self.finish(iterations, stop_reason)
    }

    /// Makes members of the cells whose pressure and v are `wanted`.
    fn collect(&mut self, wanted: impl Fn(f64, f64) -> bool) {
        self.members.clear();
        self.add_members(wanted);
        self.hold_the_others();
    }

    fn add_members(&mut self, wanted: impl Fn(f64, f64) -> bool) {
        let cells = self.p.iter().zip(&self.v).enumerate();
        self.members.extend(cells.filter(|(_, (p, v))| wanted(**p, **v)).map(|(i, _)| i));
    }

    /// Gathers the members' pressure, and sums up that of the other cells, which are at a bound.
    fn hold_the_others(&mut self) {
        gather(&self.p, &self.members, &mut self.pressure);
        self.held_pressure = 0.0;
        if self.upper < f64::INFINITY {
            let at_upper = |p: &[f64]| p.iter().filter(|p| **p >= self.upper).count();
            let held = at_upper(&self.p) - at_upper(&self.pressure);
            self.held_pressure = held as f64 * self.upper;
        }
    }

    /// Finds the multiplier λ, the cells that may move, and their gradient (centred where the sum is fixed).
    fn gradient_on_working_set(&mut self, last_lambda: f64) -> f64 {
        let upper = self.upper;
        if self.closure.plane_m().is_some() {
            self.collect(|p, v| may_move(p, v - last_lambda, upper));
            self.gradient_of_members(last_lambda);
            return last_lambda;
        }
        // Cells out of contact only lower the multiplier, and only those below it: what the cells in contact have alone
        // bounds it, and few others lie below that.
        self.members.clear();
        self.add_members(|p, _| p > 0.0);
        let bound = self.multiplier_of_members(last_lambda);
        self.add_members(|p, v| (p <= 0.0) & (v < bound));
        let lambda = self.multiplier_of_members(bound);
        let (p, v) = (&self.p, &self.v);
        self.members.retain(|i| may_move(p[*i], v[*i] - lambda, upper));
        self.hold_the_others();
        self.gradient_of_members(lambda);
        centre(&mut self.gradient);
        lambda
    }

    fn multiplier_of_members(&mut self, start: f64) -> f64 {
        gather(&self.p, &self.members, &mut self.pressure);
        gather(&self.v, &self.members, &mut self.gradient);
        tangent_multiplier(&self.pressure, &self.gradient, self.upper, start)
    }

    fn gradient_of_members(&mut self, lambda: f64) {
        self.gradient.clear();
        self.gradient.extend(self.members.iter().map(|i| self.v[*i] - lambda));
    }

    /// Takes one step that lowers the energy, or returns false if none can be represented.
    fn descend(&mut self, lambda: f64, projection_turn: bool) -> bool {
        self.precondition();
        if projection_turn {
            if self.project_everywhere(lambda) {
                return true;
            }
            self.gradient_on_working_set(lambda);
            self.precondition();
        }
        // A length that served where the bounds cut most of the steps may be out of all proportion later on.
        let lengths = [self.step_length, 1.0];
        for &length in if self.step_length == 1.0 { &lengths[..1] } else { &lengths[..] } {
            self.step_length = length;
            for direction in [Direction::Conjugate, Direction::Preconditioned, Direction::Gradient] {
                if direction == Direction::Conjugate && !self.has_history {
                    continue;
                }
                self.propose(direction);
                let clipped = self.restrict();
                let slope = self.slope(lambda);
                let steepest = norm(&self.gradient) * norm(&self.trial);
                // The projected gradient is a descent direction whatever its angle with the gradient.
                if slope < 0.0 && (direction == Direction::Gradient || -slope >= LEAST_SLOPE * steepest) {
                    return self.take(slope, clipped);
                }
            }
        }
        false
    }

    fn precondition(&mut self) {
        scatter(&self.gradient, &self.members, &mut self.scratch);
        self.problem.half_space().stiffen(self.mean, &mut self.scratch, self.workspace);
        gather(&self.scratch, &self.members, &mut self.preconditioned);
        if self.closure.plane_m().is_none() {
            centre(&mut self.preconditioned);
        }
    }

    /// Slope of the energy along the step on trial. With a fixed sum the multiplier drops out, but keeping it avoids
    /// cancellation.
    fn slope(&self, lambda: f64) -> f64 {
        self.members.iter().zip(&self.trial).map(|(i, s)| (self.v[*i] - lambda) * s).sum()
    }

    /// A gradient projection over all cells, not over those that may move alone.
    fn project_everywhere(&mut self, lambda: f64) -> bool {
        let length = self.gradient_length();
        self.collect(|_, _| true);
        self.gradient_of_members(lambda);
        self.trial.clear();
        self.trial.extend(self.gradient.iter().map(|g| -length * g));
        let clipped = self.restrict();
        let slope = self.slope(lambda);
        slope < 0.0 && self.take(slope, clipped)
    }

    /// A length for steps along the gradient that compares with that of the preconditioned one.
    fn gradient_length(&self) -> f64 {
        let scale = dot(&self.gradient, &self.preconditioned) / dot(&self.gradient, &self.gradient);
        self.step_length * if scale.is_finite() && scale > 0.0 { scale } else { 1.0 }
    }

    /// Puts the step of `direction` into `trial`, not yet within the bounds.
    fn propose(&mut self, direction: Direction) {
        self.trial.clear();
        match direction {
            Direction::Conjugate => self.conjugate_direction(),
            Direction::Preconditioned => {
                self.trial.extend(self.preconditioned.iter().map(|z| -self.step_length * z));
            }
            Direction::Gradient => {
                let length = self.gradient_length();
                self.trial.extend(self.gradient.iter().map(|g| -length * g));
            }
        }
    }

    /// Shortens the step on trial where it leaves the bounds, and shifts it to keep a fixed sum; returns whether a bound
    /// cut it.
    fn restrict(&mut self) -> bool {
        for (t, p) in self.trial.iter_mut().zip(&self.pressure) {
            *t += p;
        }
        let upper = self.upper;
        let [outside] = sums(&self.trial, &self.trial, |t, _| [if (t < 0.0) | (t > upper) { 1.0 } else { 0.0 }]);
        if let Closure::Sum { pascal } = self.closure {
            project_to_sum(&mut self.trial, upper, pascal - self.held_pressure);
        } else {
            for t in &mut self.trial {
                *t = t.clamp(0.0, upper);
            }
        }
        for (t, p) in self.trial.iter_mut().zip(&self.pressure) {
            *t -= p;
        }
        outside > 0.0
    }

    /// The preconditioned gradient made conjugate to the last realised step, plus the correction of that step's length;
    /// under a fixed plane the pressure itself is a second such direction, which settles the load level.
    fn conjugate_direction(&mut self) {
        gather(&self.step, &self.members, &mut self.last_step);
        gather(&self.image, &self.members, &mut self.last_image);
        if self.closure.plane_m().is_none() {
            centre(&mut self.last_step);
        }
        let curvature = dot(&self.last_step, &self.last_image);
        let gradient_step = dot(&self.gradient, &self.last_step);
        let conjugacy = dot(&self.preconditioned, &self.last_image);
        let (mut beta, mut gamma, mut level) = ((conjugacy / curvature).max(0.0), -gradient_step / curvature, 0.0);
        // With nothing at the upper bound all pressure is the members'; u = S p is known as v + z.
        if self.closure.plane_m().is_some()
            && self.pressure.iter().all(|p| *p < self.upper)
            && self.held_pressure == 0.0
        {
            let displaced = self.members.iter().zip(&self.pressure);
            let pu: f64 = displaced.map(|(i, p)| p * (self.v[*i] + self.heights_m[*i])).sum();
            let pw = dot(&self.pressure, &self.last_image);
            let pg = dot(&self.pressure, &self.gradient);
            let determinant = curvature * pu - pw * pw;
            if determinant > 1e-6 * curvature * pu {
                gamma = -(gradient_step * pu - pg * pw) / determinant;
                level = -(pg * curvature - gradient_step * pw) / determinant;
            }
        }
        if !(beta.is_finite() && gamma.is_finite() && level.is_finite()) {
            (beta, gamma, level) = (0.0, 0.0, 0.0);
        }
        let along_step = self.step_length * beta + gamma;
        for ((z, s), p) in self.preconditioned.iter().zip(&self.last_step).zip(&self.pressure) {
            self.trial.push(along_step * s + level * p - self.step_length * z);
        }
    }

    /// Goes along `trial`, whose slope is negative, as far as lowers the energy.
    fn take(&mut self, slope: f64, clipped: bool) -> bool {
        scatter(&self.trial, &self.members, &mut self.step);
        self.problem.half_space().displace_as(self.mean, &self.step, &mut self.image, self.workspace);
        gather(&self.image, &self.members, &mut self.last_image);
        let optimal = -slope / dot(&self.trial, &self.last_image);
        if !(optimal.is_finite() && optimal > 0.0) {
            self.has_history = false;
            return false;
        }
        let length = if clipped {
            if optimal >= WHOLE_STEP_FROM { 1.0 } else { optimal }
        } else {
            let longest = if self.closure.plane_m().is_some() { f64::INFINITY } else { LONGEST_STEP };
            optimal.min(self.longest_feasible()).min(longest)
        };
        let mut moved = false;
        for ((i, step), before) in self.members.iter().zip(&self.trial).zip(&self.pressure) {
            // The step was formed as (bound − p), so a whole step lands on the bound exactly up to rounding.
            let mut after = (before + length * step).clamp(0.0, self.upper);
            if length >= 1.0 && *step == -before {
                after = 0.0;
            } else if length >= 1.0 && *step == self.upper - before {
                after = self.upper;
            }
            moved |= after != *before;
            self.p[*i] = after;
        }
        for (v, image) in self.v.iter_mut().zip(&self.image) {
            *v += length * image;
        }
        self.step_length *= optimal.clamp(0.3, 1.5);
        self.has_history = true;
        moved
    }

    /// The largest multiple of the step on trial that stays within the bounds.
    fn longest_feasible(&self) -> f64 {
        let room = |(p, s): (&f64, &f64)| match *s {
            s if s < 0.0 => -p / s,
            s if s > 0.0 => (self.upper - p) / s,
            _ => f64::INFINITY,
        };
        self.pressure.iter().zip(&self.trial).map(room).fold(f64::INFINITY, f64::min)
    }

    fn finish(self, iterations: usize, stop_reason: StopReason) -> Solution {
        let problem = self.problem;
        let (height_m, residual) = certify(problem, self.closure, &self.p, &self.v);
        let shape = problem.heights_m().dim();
        let map = |values: Vec<f64>| {
            let mut iter = values.into_iter();
            Array2::from_shape_simple_fn(shape, || iter.next().unwrap_or(f64::NAN))
        };
        // A mean compliance that was left out moves surface and plane alike.
        let mean_p = self.p.iter().sum::<f64>() / self.p.len() as f64;
        let shift_m = self.missing_compliance_m_per_pa * mean_p;
        let displacement_m = self.v.iter().zip(&self.heights_m).map(|(v, z)| v + z + shift_m).collect();
        let signed_gap_m = self.v.iter().map(|v| v + height_m).collect();
        Solution {
            grid: problem.half_space().grid(),
            boundary: problem.half_space().boundary(),
            hardness_pa: problem.hardness_pa(),
            pressure_pa: map(self.p),
            displacement_m: map(displacement_m),
            signed_gap_m: map(signed_gap_m),
            plane_m: problem.plane_m().unwrap_or(problem.mean_height_m() + height_m - shift_m),
            mean_height_m: problem.mean_height_m(),
            highest_m: problem.highest_m(),
            iterations,
            residual,
            stop_reason,
        }
    }
}
