//! A bound-constrained preconditioned conjugate gradient method with one operator application per iteration.
//!
//! Each iteration forms a trial direction, preconditioned by E*|q|/2 and made conjugate to the step that was *realised*
//! last; projects the trial point on the bounds; and applies the compliance to the projected step alone. The exact step
//! length along that feasible step is then known, as is the correction that the next trial point needs if this step
//! was not of optimal length. Whatever the preconditioner and the history were, a step is taken only along a feasible
//! descent direction with a length that lowers the energy, and every [`GRADIENT_PROJECTION_PERIOD`]th step is a
//! full gradient projection, so the iteration converges to the unique solution; once the contact area no longer changes
//! it is the preconditioned conjugate gradient method.
//!
//! # References
//! I. A. Polonsky and L. M. Keer, *Wear* **231** (1999) 206 (conjugate gradients on the contact area),
//! <https://doi.org/10.1016/S0043-1648(99)00113-1>.
//! D. G. Luenberger and Y. Ye, *Linear and Nonlinear Programming*, §7.10 (spacer steps).

use ndarray::Array2;

use crate::contact::projection::{Bound, bound, project_to_sum, tangent_multiplier};
use crate::contact::solution::certify;
use crate::contact::{Boundary, ContactError, Control, Problem, Solution, StopReason, Workspace};

/// Every so many iterations a plain gradient projection guarantees convergence.
const GRADIENT_PROJECTION_PERIOD: usize = 32;
/// A clipped step is taken whole when its optimal length is at least this share of it.
const WHOLE_STEP_FROM: f64 = 0.7;
/// A direction counts as descent when its slope is at least this share of the steepest one's.
const LEAST_SLOPE: f64 = 1e-4;

/// Solves contact problems to a relative tolerance.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Solver {
    /// Bound on every entry of [`Residual`](crate::contact::Residual).
    pub tolerance: f64,
    /// Operator applications before giving up.
    pub max_iterations: usize,
}

impl Default for Solver {
    fn default() -> Self {
        Self { tolerance: 1e-8, max_iterations: 2000 }
    }
}

/// What closes the problem: a fixed plane, or a fixed sum of the pressures.
#[derive(Debug, Clone, Copy)]
enum Closure {
    Plane { height_m: f64 },
    Sum { pascal: f64 },
}

impl Solver {
    /// Solves `problem`. A solution that is not converged says so; it is not an error.
    ///
    /// # Errors
    /// The tolerance is not positive.
    pub fn solve(&self, problem: &Problem<'_>) -> Result<Solution, ContactError> {
        self.solve_with(problem, &mut problem.half_space().workspace())
    }

    /// As [`Solver::solve`] with scratch memory that is reused between solves.
    ///
    /// # Errors
    /// The tolerance is not positive.
    pub fn solve_with(&self, problem: &Problem<'_>, workspace: &mut Workspace) -> Result<Solution, ContactError> {
        if !(self.tolerance.is_finite() && self.tolerance > 0.0) {
            let (parameter, unit, wanted) = ("tolerance", "(relative)", "positive");
            return Err(ContactError::Parameter { parameter, value: self.tolerance, unit, wanted });
        }
        if let Control::MeanGap { metre } = problem.control() {
            return Ok(self.solve_mean_gap(problem, metre, workspace));
        }
        let points = problem.heights_m().len();
        let (closure, start_pa) = match (problem.plane_m(), problem.mean_pressure_pa()) {
            (Some(height_m), _) => (Closure::Plane { height_m }, 0.0),
            (None, mean_pa) => {
                let pascal = mean_pa.unwrap_or(0.0);
                (Closure::Sum { pascal: pascal * points as f64 }, pascal)
            }
        };
        let start = match closure {
            Closure::Plane { height_m } => coarse_start(problem, height_m),
            Closure::Sum { .. } => vec![start_pa; points],
        };
        Ok(State::new(problem, start, 0.0, workspace).run(self, closure))
    }

    /// Prescribed mean gap. On an elastic periodic half-space the mean displacement is known, so the gap fixes the
    /// plane; otherwise the mean pressure that leaves this gap is sought, since the gap falls monotonically with it.
    fn solve_mean_gap(&self, problem: &Problem<'_>, gap_m: f64, workspace: &mut Workspace) -> Solution {
        let points = problem.heights_m().len();
        let untouched_m = problem.highest_m() - problem.mean_height_m();
        if gap_m >= untouched_m {
            let state = State::new(problem, vec![0.0; points], 0.0, workspace);
            return state.run(self, Closure::Plane { height_m: problem.mean_height_m() + gap_m });
        }
        if let (Boundary::Periodic { mean_compliance_m_per_pa }, None) =
            (problem.half_space().boundary(), problem.hardness_pa())
        {
            let state = State::new(problem, vec![0.0; points], mean_compliance_m_per_pa, workspace);
            return state.run(self, Closure::Plane { height_m: problem.mean_height_m() + gap_m });
        }
        let ceiling = problem.hardness_pa().unwrap_or(f64::INFINITY);
        let (grid, modulus_pa) = (problem.half_space().grid(), problem.half_space().modulus_pa());
        let mut iterations = 0;
        let mut at = |pascal: f64, start: Option<&Solution>| {
            let total = pascal * points as f64;
            let mut p = start.map_or_else(|| vec![pascal; points], |s| s.pressure_pa.iter().copied().collect());
            project_to_sum(&mut p, &vec![true; points], ceiling, total);
            let state = State::new(problem, p, 0.0, workspace);
            let mut solution = state.run(self, Closure::Sum { pascal: total });
            iterations += solution.iterations;
            solution.iterations = iterations;
            let error = solution.mean_gap_m() / gap_m - 1.0;
            solution.residual.load = error.abs();
            (error, solution)
        };
        // Bracket the mean pressure by decades about E* h_rms / L, then close in by the Illinois variant of false position.
        let mut low = 0.0;
        let mut error_low = untouched_m / gap_m - 1.0;
        let mut high = (modulus_pa * problem.rms_height_m() / grid.width_m().max(grid.height_m())).min(0.5 * ceiling);
        let (mut error_high, mut best) = at(high, None);
        while error_high > 0.0 {
            (low, error_low) = (high, error_high);
            high = if 4.0 * high < ceiling { 4.0 * high } else { 0.5 * (high + ceiling) };
            (error_high, best) = at(high, Some(&best));
            if high >= ceiling * (1.0 - 1e-9) || !best.converged() {
                break;
            }
        }
        let mut kept = 0_i32;
        for _ in 0..200 {
            if best.residual.load <= self.tolerance || !best.converged() {
                break;
            }
            let pascal = if low == 0.0 && error_low > 1e3 * -error_high {
                0.1 * high
            } else {
                high - error_high * (high - low) / (error_high - error_low)
            };
            let (error, solution) = at(pascal, Some(&best));
            best = solution;
            if error > 0.0 {
                (low, error_low) = (pascal, error);
                error_high *= if kept == 1 { 0.5 } else { 1.0 };
                kept = 1;
            } else {
                (high, error_high) = (pascal, error);
                error_low *= if kept == -1 { 0.5 } else { 1.0 };
                kept = -1;
            }
        }
        if best.residual.load > self.tolerance && best.converged() {
            best.stop_reason = StopReason::PrecisionLimit;
        }
        best
    }
}

/// Tolerance of the first guesses on coarse grids.
const COARSE_TOLERANCE: f64 = 1e-2;

/// A first guess of the pressure under a plane: the solution on cells twice as wide, found in the same way.
///
/// Under a prescribed plane the load is unknown, and from zero pressure it builds up slowly, wave by long wave; the coarse
/// grid settles it at a quarter of the cost.
fn coarse_start(problem: &Problem<'_>, height_m: f64) -> Vec<f64> {
    let none = || vec![0.0; problem.heights_m().len()];
    let Some(coarse) = problem.half_space().coarse() else {
        return none();
    };
    let fine = problem.heights_m();
    let heights_m = Array2::from_shape_fn(coarse.grid().shape(), |(row, column)| {
        let (i, j) = (2 * row, 2 * column);
        0.25 * (fine[[i, j]] + fine[[i, j + 1]] + fine[[i + 1, j]] + fine[[i + 1, j + 1]])
    });
    let Ok(guess) = Problem::new(coarse, &heights_m, Control::Plane { height_m }, problem.hardness_pa()) else {
        return none();
    };
    let solver = Solver { tolerance: COARSE_TOLERANCE, max_iterations: 100 };
    let mut workspace = coarse.workspace();
    let state = State::new(&guess, coarse_start(&guess, height_m), 0.0, &mut workspace);
    let solution = state.run(&solver, Closure::Plane { height_m });
    fine.indexed_iter().map(|((row, column), _)| solution.pressure_pa[[row / 2, column / 2]]).collect()
}

/// The moving parts of one solve. `v` = S p − z throughout.
struct State<'a> {
    problem: &'a Problem<'a>,
    workspace: &'a mut Workspace,
    upper: f64,
    /// Mean compliance that is taken out of the operator, in m/Pa.
    dropped_mean_m_per_pa: f64,
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

impl<'a> State<'a> {
    fn new(problem: &'a Problem<'a>, p: Vec<f64>, dropped_mean_m_per_pa: f64, workspace: &'a mut Workspace) -> Self {
        let n = p.len();
        let mut state = Self {
            problem,
            workspace,
            upper: problem.hardness_pa().unwrap_or(f64::INFINITY),
            dropped_mean_m_per_pa,
            heights_m: problem.heights_m().iter().copied().collect(),
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
        state.refresh();
        state
    }

    /// Recomputes v = S p − z.
    fn refresh(&mut self) {
        if self.p.iter().all(|p| *p == 0.0) {
            self.v.fill(0.0);
        } else {
            displace(self.problem, self.dropped_mean_m_per_pa, &self.p, &mut self.v, self.workspace);
        }
        for (v, z) in self.v.iter_mut().zip(&self.heights_m) {
            *v -= z;
        }
    }

    fn run(mut self, solver: &Solver, closure: Closure) -> Solution {
        let prescribed_plane_m = match closure {
            Closure::Plane { height_m } => Some(height_m),
            Closure::Sum { .. } => None,
        };
        let mut lambda = match closure {
            Closure::Plane { height_m } => -height_m,
            Closure::Sum { .. } => self.v.iter().sum::<f64>() / self.v.len() as f64,
        };
        let mut iterations = 0;
        let mut stuck = false;
        let stop_reason = loop {
            let (_, residual) = certify(self.problem, &self.p, &self.v, prescribed_plane_m);
            if residual.worst() <= solver.tolerance {
                // The recurrence of v drifts by rounding: only a fresh evaluation may declare success.
                self.refresh();
                self.has_history = false;
                let (_, fresh) = certify(self.problem, &self.p, &self.v, prescribed_plane_m);
                if fresh.worst() <= solver.tolerance {
                    break StopReason::Converged;
                }
                if stuck {
                    break StopReason::PrecisionLimit;
                }
                stuck = true;
            }
            if iterations >= solver.max_iterations {
                self.refresh();
                break StopReason::IterationLimit;
            }
            if let Closure::Sum { .. } = closure {
                lambda = tangent_multiplier(&self.p, &self.v, self.upper, lambda);
            }
            self.gradient_on_working_set(lambda, closure);
            let projection_turn = iterations % GRADIENT_PROJECTION_PERIOD == GRADIENT_PROJECTION_PERIOD - 1;
            match self.descend(lambda, closure, projection_turn) {
                true => iterations += 1,
                false if stuck => {
                    self.refresh();
                    break StopReason::PrecisionLimit;
                }
                false => {
                    self.refresh();
                    self.has_history = false;
                    stuck = true;
                }
            }
        };
        self.finish(prescribed_plane_m, iterations, stop_reason)
    }

    /// Marks the cells that may move, and keeps their gradient (centred where the sum is fixed).
    fn gradient_on_working_set(&mut self, lambda: f64, closure: Closure) {
        for i in 0..self.p.len() {
            let g = self.v[i] - lambda;
            self.working[i] = match bound(self.p[i], self.upper) {
                Bound::Free => true,
                Bound::Lower => g < 0.0,
                Bound::Upper => g > 0.0,
            };
            self.gradient[i] = if self.working[i] { g } else { 0.0 };
        }
        if let Closure::Sum { .. } = closure {
            centre(&mut self.gradient, &self.working);
        }
    }

    /// Takes one step that lowers the energy, or returns false if none can be represented.
    fn descend(&mut self, lambda: f64, closure: Closure, projection_turn: bool) -> bool {
        self.problem.half_space().stiffen(&self.gradient, &mut self.preconditioned, self.workspace);
        for (z, working) in self.preconditioned.iter_mut().zip(&self.working) {
            if !working {
                *z = 0.0;
            }
        }
        if let Closure::Sum { .. } = closure {
            centre(&mut self.preconditioned, &self.working);
        }
        let attempts = match (projection_turn, self.has_history) {
            (true, _) => &[Direction::Projection, Direction::Gradient][..],
            (false, true) => &[Direction::Conjugate, Direction::Preconditioned, Direction::Gradient][..],
            (false, false) => &[Direction::Preconditioned, Direction::Gradient][..],
        };
        for &direction in attempts {
            let clipped = self.propose(direction, lambda, closure);
            // Slope of the energy along the step; with a fixed sum the multiplier drops out, but keeping it avoids
            // cancellation.
            let slope: f64 = (0..self.p.len()).map(|i| (self.v[i] - lambda) * self.trial[i]).sum();
            let steepest = norm(&self.gradient) * norm(&self.trial);
            if slope < 0.0 && (-slope >= LEAST_SLOPE * steepest || direction == Direction::Projection) {
                return self.take(slope, clipped);
            }
        }
        false
    }

    /// Puts the feasible step of `direction` into `trial`; returns whether a bound cut it.
    fn propose(&mut self, direction: Direction, lambda: f64, closure: Closure) -> bool {
        let n = self.p.len();
        match direction {
            Direction::Conjugate => self.conjugate_direction(closure),
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
        match closure {
            Closure::Plane { .. } => {
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
    fn conjugate_direction(&mut self, closure: Closure) {
        let n = self.p.len();
        for i in 0..n {
            if !self.working[i] {
                self.step[i] = 0.0;
            }
        }
        if let Closure::Sum { .. } = closure {
            centre(&mut self.step, &self.working);
        }
        let curvature = dot(&self.step, &self.image);
        let gradient_step = dot(&self.gradient, &self.step);
        let conjugacy = dot(&self.preconditioned, &self.image);
        let (mut beta, mut gamma, mut level) = ((conjugacy / curvature).max(0.0), -gradient_step / curvature, 0.0);
        if let Closure::Plane { .. } = closure
            && self.p.iter().all(|p| *p < self.upper)
        {
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
        displace(self.problem, self.dropped_mean_m_per_pa, &self.step, &mut self.image, self.workspace);
        let optimal = -slope / dot(&self.step, &self.image);
        if !(optimal.is_finite() && optimal > 0.0) {
            self.has_history = false;
            return false;
        }
        let length = if clipped {
            if optimal >= WHOLE_STEP_FROM { 1.0 } else { optimal }
        } else {
            optimal.min(self.longest_feasible())
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

    fn finish(self, prescribed_plane_m: Option<f64>, iterations: usize, stop_reason: StopReason) -> Solution {
        let problem = self.problem;
        let (plane_m, residual) = certify(problem, &self.p, &self.v, prescribed_plane_m);
        let shape = problem.heights_m().dim();
        let map = |values: Vec<f64>| {
            let mut iter = values.into_iter();
            Array2::from_shape_simple_fn(shape, || iter.next().unwrap_or(f64::NAN))
        };
        // A mean compliance that was taken out of the operator moves surface and plane alike.
        let mean_p = self.p.iter().sum::<f64>() / self.p.len() as f64;
        let shift_m = self.dropped_mean_m_per_pa * mean_p;
        let displacement_m = self.v.iter().zip(&self.heights_m).map(|(v, z)| v + z + shift_m).collect();
        let signed_gap_m = self.v.iter().map(|v| v + plane_m).collect();
        Solution {
            grid: problem.half_space().grid(),
            boundary: problem.half_space().boundary(),
            hardness_pa: problem.hardness_pa(),
            pressure_pa: map(self.p),
            displacement_m: map(displacement_m),
            signed_gap_m: map(signed_gap_m),
            plane_m: plane_m - shift_m,
            mean_height_m: problem.mean_height_m(),
            highest_m: problem.highest_m(),
            iterations,
            residual,
            stop_reason,
        }
    }
}

fn displace(problem: &Problem<'_>, dropped: f64, p: &[f64], u: &mut [f64], workspace: &mut Workspace) {
    problem.half_space().displace(p, u, workspace);
    if dropped != 0.0 {
        let mean = dropped * p.iter().sum::<f64>() / p.len() as f64;
        for u in u {
            *u -= mean;
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
