//! The moving parts of one solve: see [`Solver`].

use ndarray::Array2;

use crate::contact::half_space::MeanMode;
use crate::contact::projection::{Bound, bound, project_to_sum, tangent_multiplier};
use crate::contact::solution::certify;
use crate::contact::solver::{Closure, Solver};
use crate::contact::{Boundary, Problem, Solution, StopReason, Workspace};

/// Every so many iterations a plain gradient projection guarantees convergence.
const GRADIENT_PROJECTION_PERIOD: usize = 32;
/// A clipped step is taken whole when its optimal length is at least this share of it.
const WHOLE_STEP_FROM: f64 = 0.7;
/// Under a prescribed sum no step is lengthened more than this, for the sum of a step is zero up to rounding only.
const LONGEST_STEP: f64 = 1e6;
/// A direction counts as descent when its slope is at least this share of the steepest one's.
const LEAST_SLOPE: f64 = 1e-4;

/// The iterate of one solve. Heights are counted from their mean, and `v` = S p − z throughout.
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
    working: Vec<bool>,
    /// Gradient on the working set, zero elsewhere.
    gradient: Vec<f64>,
    preconditioned: Vec<f64>,
    /// Realised step and its image under S.
    step: Vec<f64>,
    image: Vec<f64>,
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
    /// Gradient projection over all cells, not the working set alone.
    Projection,
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
            working: vec![false; n],
            gradient: vec![0.0; n],
            preconditioned: vec![0.0; n],
            step: vec![0.0; n],
            image: vec![0.0; n],
            trial: vec![0.0; n],
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
            let mut elsewhere = 0.0;
            for (p, working) in self.p.iter().zip(&mut self.working) {
                *working = bound(*p, self.upper) == Bound::Free;
                elsewhere += if *working { 0.0 } else { *p };
            }
            project_to_sum(&mut self.p, &self.working, self.upper, pascal - elsewhere);
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
            if iterations >= solver.max_iterations {
                self.refresh();
                break StopReason::IterationLimit;
            }
            if self.closure.plane_m().is_none() {
                lambda = tangent_multiplier(&self.p, &self.v, self.upper, lambda);
            }
            self.gradient_on_working_set(lambda);
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

    /// Marks the cells that may move, and keeps their gradient (centred where the sum is fixed).
    fn gradient_on_working_set(&mut self, lambda: f64) {
        for i in 0..self.p.len() {
            let g = self.v[i] - lambda;
            self.working[i] = match bound(self.p[i], self.upper) {
                Bound::Free => true,
                Bound::Lower => g < 0.0,
                Bound::Upper => g > 0.0,
            };
            self.gradient[i] = if self.working[i] { g } else { 0.0 };
        }
        if self.closure.plane_m().is_none() {
            centre(&mut self.gradient, &self.working);
        }
    }

    /// Takes one step that lowers the energy, or returns false if none can be represented.
    fn descend(&mut self, lambda: f64, projection_turn: bool) -> bool {
        self.problem.half_space().stiffen(self.mean, &self.gradient, &mut self.preconditioned, self.workspace);
        for (z, working) in self.preconditioned.iter_mut().zip(&self.working) {
            if !working {
                *z = 0.0;
            }
        }
        if self.closure.plane_m().is_none() {
            centre(&mut self.preconditioned, &self.working);
        }
        let attempts = match (projection_turn, self.has_history) {
            (true, _) => &[Direction::Projection, Direction::Gradient][..],
            (false, true) => &[Direction::Conjugate, Direction::Preconditioned, Direction::Gradient][..],
            (false, false) => &[Direction::Preconditioned, Direction::Gradient][..],
        };
        // A length that served where the bounds cut most of the steps may be out of all proportion later on.
        let lengths = [self.step_length, 1.0];
        for &length in if self.step_length == 1.0 { &lengths[..1] } else { &lengths[..] } {
            self.step_length = length;
            for &direction in attempts {
                let clipped = self.propose(direction, lambda);
                // Slope of the energy along the step; with a fixed sum the multiplier drops out, but keeping it avoids
                // cancellation.
                let slope: f64 = (0..self.p.len()).map(|i| (self.v[i] - lambda) * self.trial[i]).sum();
                let is_projected_gradient = matches!(direction, Direction::Gradient | Direction::Projection);
                let steepest = norm(&self.gradient) * norm(&self.trial);
                // The projected gradient is a descent direction whatever its angle with the gradient.
                if slope < 0.0 && (is_projected_gradient || -slope >= LEAST_SLOPE * steepest) {
                    return self.take(slope, clipped);
                }
            }
        }
        false
    }

    /// Puts the feasible step of `direction` into `trial`; returns whether a bound cut it.
    fn propose(&mut self, direction: Direction, lambda: f64) -> bool {
        let n = self.p.len();
        match direction {
            Direction::Conjugate => self.conjugate_direction(),
            Direction::Preconditioned => {
                for i in 0..n {
                    self.trial[i] = -self.step_length * self.preconditioned[i];
                }
            }
            Direction::Gradient | Direction::Projection => {
                // Scaled so that its length compares with the preconditioned step's.
                let scale = dot(&self.gradient, &self.preconditioned) / dot(&self.gradient, &self.gradient);
                let length = self.step_length * if scale.is_finite() && scale > 0.0 { scale } else { 1.0 };
                let everywhere = direction == Direction::Projection;
                for i in 0..n {
                    let g = if everywhere { self.v[i] - lambda } else { self.gradient[i] };
                    self.trial[i] = -length * g;
                }
                if everywhere {
                    self.working.fill(true);
                }
            }
        }
        for i in 0..n {
            self.trial[i] += self.p[i];
        }
        let mut clipped = false;
        for i in 0..n {
            if self.working[i] && (self.trial[i] < 0.0 || self.trial[i] > self.upper) {
                clipped = true;
                break;
            }
        }
        match self.closure {
            Closure::Plane { .. } | Closure::Gap { .. } => {
                for (t, working) in self.trial.iter_mut().zip(&self.working) {
                    if *working {
                        *t = t.clamp(0.0, self.upper);
                    }
                }
            }
            Closure::Sum { pascal } => {
                let fixed: f64 = self.p.iter().zip(&self.working).filter(|(_, w)| !**w).map(|(p, _)| p).sum();
                project_to_sum(&mut self.trial, &self.working, self.upper, pascal - fixed);
            }
        }
        for i in 0..n {
            self.trial[i] = if self.working[i] { self.trial[i] - self.p[i] } else { 0.0 };
        }
        clipped
    }

    /// The preconditioned gradient made conjugate to the last realised step, plus the correction of that step's length;
    /// under a fixed plane the pressure itself is a second such direction, which settles the load level.
    fn conjugate_direction(&mut self) {
        let n = self.p.len();
        for i in 0..n {
            if !self.working[i] {
                self.step[i] = 0.0;
            }
        }
        if self.closure.plane_m().is_none() {
            centre(&mut self.step, &self.working);
        }
        let curvature = dot(&self.step, &self.image);
        let gradient_step = dot(&self.gradient, &self.step);
        let conjugacy = dot(&self.preconditioned, &self.image);
        let (mut beta, mut gamma, mut level) = ((conjugacy / curvature).max(0.0), -gradient_step / curvature, 0.0);
        if self.closure.plane_m().is_some() && self.p.iter().all(|p| *p < self.upper) {
            // u = S p is known as v + z: no further operator application.
            let (mut pu, mut pw, mut pg) = (0.0, 0.0, 0.0);
            for i in 0..n {
                let p = self.p[i];
                if p > 0.0 {
                    pu += p * (self.v[i] + self.heights_m[i]);
                    pw += p * self.image[i];
                    pg += p * self.gradient[i];
                }
            }
            let determinant = curvature * pu - pw * pw;
            if determinant > 1e-6 * curvature * pu {
                gamma = -(gradient_step * pu - pg * pw) / determinant;
                level = -(pg * curvature - gradient_step * pw) / determinant;
            }
        }
        if !(beta.is_finite() && gamma.is_finite() && level.is_finite()) {
            (beta, gamma, level) = (0.0, 0.0, 0.0);
        }
        for i in 0..n {
            let direction = beta * self.step[i] - self.preconditioned[i];
            self.trial[i] = self.step_length * direction + gamma * self.step[i] + level * self.p[i];
            if !self.working[i] {
                self.trial[i] = 0.0;
            }
        }
    }

    /// Goes along `trial`, whose slope is negative, as far as lowers the energy.
    fn take(&mut self, slope: f64, clipped: bool) -> bool {
        std::mem::swap(&mut self.step, &mut self.trial);
        self.problem.half_space().displace_as(self.mean, &self.step, &mut self.image, self.workspace);
        let optimal = -slope / dot(&self.step, &self.image);
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
        for i in 0..self.p.len() {
            let before = self.p[i];
            // `step` was formed as (bound − p), so a whole step lands on the bound exactly up to rounding.
            let after = (before + length * self.step[i]).clamp(0.0, self.upper);
            let after = if self.step[i] == -before && length >= 1.0 { 0.0 } else { after };
            let after = if self.step[i] == self.upper - before && length >= 1.0 { self.upper } else { after };
            moved |= after != before;
            self.p[i] = after;
            self.v[i] += length * self.image[i];
        }
        self.step_length *= optimal.clamp(0.3, 1.5);
        self.has_history = true;
        moved
    }

    /// The largest multiple of `step` that stays within the bounds.
    fn longest_feasible(&self) -> f64 {
        let mut longest = f64::INFINITY;
        for (p, s) in self.p.iter().zip(&self.step) {
            let room = if *s < 0.0 {
                -p / s
            } else if *s > 0.0 {
                (self.upper - p) / s
            } else {
                continue;
            };
            longest = longest.min(room);
        }
        longest
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

fn dot(a: &[f64], b: &[f64]) -> f64 {
    // Four partial sums: the compiler may then use vector registers.
    let mut sums = [0.0; 4];
    let (chunks_a, chunks_b) = (a.chunks_exact(4), b.chunks_exact(4));
    let rest: f64 = chunks_a.remainder().iter().zip(chunks_b.remainder()).map(|(a, b)| a * b).sum();
    for (a, b) in chunks_a.zip(chunks_b) {
        for k in 0..4 {
            sums[k] += a[k] * b[k];
        }
    }
    sums.iter().sum::<f64>() + rest
}

fn norm(a: &[f64]) -> f64 {
    dot(a, a).sqrt()
}

/// Takes the mean over the working set out of `values`, leaving the other cells alone.
fn centre(values: &mut [f64], working: &[bool]) {
    let (mut sum, mut count) = (0.0, 0.0);
    for (value, working) in values.iter().zip(working) {
        if *working {
            sum += value;
            count += 1.0;
        }
    }
    if count > 0.0 {
        let mean = sum / count;
        for (value, working) in values.iter_mut().zip(working) {
            if *working {
                *value -= mean;
            }
        }
    }
}
