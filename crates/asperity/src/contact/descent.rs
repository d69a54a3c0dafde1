//! The moving parts of one solve: see [`Solver`].

use ndarray::{Array2, CowArray, Ix2};

use crate::contact::cells::Cells;
use crate::contact::half_space::MeanMode;
use crate::contact::projection::{may_move, project_to_sum, tangent_multiplier};
use crate::contact::solution::{Residual, certify};
use crate::contact::solver::{Closure, Solver};
use crate::contact::vectors::{centre, dot, norm, sums};
use crate::contact::{Boundary, Problem, Solution, StopReason, Workspace};
use crate::fourier::ROWS_OF_SLAB;

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
/// Typical error of a displacement in single precision over the largest displacement.
const SINGLE_PRECISION: f64 = 6e-8;
/// Share of the residual that such errors may make up before they are undone.
const TOLERABLE_DRIFT: f64 = 0.5;
/// Cells that are looked at together for whether one of them is near contact.
const GROUP: usize = 8;

/// The iterate of one solve. Heights are counted from their mean, and `v` = S p − z throughout.
///
/// Steps are displaced in single precision, which costs half as much and adds an error to v that is small against the step.
/// Where the errors would matter v is computed afresh in double precision, so what a solve ends on is known in that.
pub(super) struct Descent<'a> {
    problem: &'a Problem<'a>,
    closure: Closure,
    workspace: &'a mut Workspace,
    upper: f64,
    mean: MeanMode,
    /// Mean compliance of the half-space beyond that of `mean`, in m/Pa.
    missing_compliance_m_per_pa: f64,
    heights_m: CowArray<'a, f64, Ix2>,
    p: Vec<f64>,
    v: Vec<f64>,
    /// The cells with pressure, and those without whose v is below `bound`.
    near: Near,
    bound: f64,
    /// The same of every slab of rows.
    slabs: Vec<Near>,
    /// Cells that may move.
    members: Cells,
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
    /// How far v may be from S p − z, in metre.
    drift_m: f64,
}

/// Cells in row order, with their pressure, v, and the last step and its image under S.
#[derive(Debug, Clone, Default)]
struct Near {
    places: Vec<u32>,
    p: Vec<f64>,
    v: Vec<f64>,
    step: Vec<f64>,
    image: Vec<f64>,
    /// Sum of the gaps of all cells out of contact, where the mean gap is prescribed.
    gap_sum_m: f64,
    /// Scratch: the step in a row of the grid.
    row: Vec<f64>,
}

impl Near {
    fn clear(&mut self) {
        self.places.clear();
        for list in [&mut self.p, &mut self.v, &mut self.step, &mut self.image] {
            list.clear();
        }
        self.gap_sum_m = 0.0;
    }

    fn push(&mut self, place: usize, p: f64, v: f64, step: f64, image: f64) {
        self.places.push(place as u32);
        self.p.push(p);
        self.v.push(v);
        self.step.push(step);
        self.image.push(image);
    }

    fn append(&mut self, other: &Self) {
        self.places.extend_from_slice(&other.places);
        self.p.extend_from_slice(&other.p);
        self.v.extend_from_slice(&other.v);
        self.step.extend_from_slice(&other.step);
        self.image.extend_from_slice(&other.image);
        self.gap_sum_m += other.gap_sum_m;
    }

    /// Takes up those cells of a piece of a row that carry pressure or whose v is below `bound`.
    fn take_up(
        &mut self,
        first: usize,
        p: &[f64],
        v: &[f64],
        bound: f64,
        history: impl Fn(&Self, usize) -> (f64, f64),
    ) {
        for (group, (p, v)) in p.chunks(GROUP).zip(v.chunks(GROUP)).enumerate() {
            let is_near = |p: f64, v: f64| (p > 0.0) | (v < bound);
            if p.iter().zip(v).fold(false, |any, (p, v)| any | is_near(*p, *v)) {
                for (i, (p, v)) in p.iter().zip(v).enumerate().filter(|(_, (p, v))| is_near(**p, **v)) {
                    let column = group * GROUP + i;
                    let (step, image) = history(self, column);
                    self.push(first + column, *p, *v, step, image);
                }
            }
        }
    }
}

/// Sum of the gaps under the plane of the cells that carry no pressure.
fn gap_sum_m(p: &[f64], v: &[f64], plane_m: f64) -> f64 {
    let [sum] = sums(p, v, |p, v| [if (p <= 0.0) & (v + plane_m > 0.0) { v + plane_m } else { 0.0 }]);
    sum
}

/// The rows of a slab while a step is taken.
struct Slab<'s> {
    v: &'s mut [f64],
    p: &'s [f64],
    near: &'s mut Near,
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
        let (rows, columns) = problem.heights_m().dim();
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
            heights_m: problem.heights_m().as_standard_layout(),
            p,
            v: vec![0.0; n],
            near: Near::default(),
            bound: f64::NEG_INFINITY,
            slabs: vec![Near { row: vec![0.0; columns], ..Near::default() }; problem.half_space().slabs()],
            members: Cells::none(rows, columns),
            held_pressure: 0.0,
            pressure: Vec::new(),
            gradient: Vec::new(),
            preconditioned: Vec::new(),
            last_step: Vec::new(),
            last_image: Vec::new(),
            trial: Vec::new(),
            step_length: 1.0,
            has_history: false,
            drift_m: 0.0,
        };
        descent.look(closure.plane_m().map_or(f64::NEG_INFINITY, |plane_m| -plane_m));
        descent.refresh();
        descent
    }

    /// Undoes the drift of rounding in the recurrences: restores the prescribed sum by a common shift of the cells between
    /// the bounds, and computes v = S p − z afresh.
    fn refresh(&mut self) {
        if let Closure::Sum { pascal } = self.closure {
            let upper = self.upper;
            self.choose(|p, _| p > 0.0 && p < upper, 0.0);
            project_to_sum(&mut self.pressure, self.upper, pascal - self.held_pressure);
            for (place, p) in self.members.places().iter().zip(&self.pressure) {
                self.p[*place as usize] = *p;
            }
        }
        if let Some(u) = self.uniform_displacement_m() {
            self.v.fill(u);
        } else {
            self.problem.half_space().displace_as(self.mean, &self.p, &mut self.v, self.workspace);
        }
        let mean_height_m = self.problem.mean_height_m();
        for (v, z) in self.v.iter_mut().zip(&self.heights_m) {
            *v -= z - mean_height_m;
        }
        self.drift_m = 0.0;
        self.look(self.bound);
    }

    /// The displacement where it is the same everywhere and needs no transform.
    fn uniform_displacement_m(&self) -> Option<f64> {
        let first = self.p.first().copied()?;
        let periodic = matches!(self.problem.half_space().boundary(), Boundary::Periodic { .. });
        let is_uniform = (periodic || first == 0.0) && self.p.iter().all(|p| *p == first);
        is_uniform.then(|| self.mean.displacement_m(first))
    }

    /// Looks for the cells near contact all over the grid: those with pressure, and those whose v is below `bound`.
    fn look(&mut self, bound: f64) {
        self.bound = bound;
        let before = std::mem::take(&mut self.near);
        let mut next = 0;
        let mut near = Near::default();
        for (place, (p, v)) in self.p.iter().zip(&self.v).enumerate().filter(|(_, (p, v))| **p > 0.0 || **v < bound) {
            while before.places.get(next).is_some_and(|known| (*known as usize) < place) {
                next += 1;
            }
            let known = before.places.get(next) == Some(&(place as u32));
            let (step, image) = if known { (before.step[next], before.image[next]) } else { (0.0, 0.0) };
            near.push(place, *p, *v, step, image);
        }
        if let Closure::Gap { metre } = self.closure {
            near.gap_sum_m = gap_sum_m(&self.p, &self.v, metre);
        }
        self.near = near;
    }

    /// Height of the plane and residuals, by the cells near contact.
    fn certified(&mut self) -> Residual {
        loop {
            let gap_sum_m = matches!(self.closure, Closure::Gap { .. }).then_some(self.near.gap_sum_m);
            let (plane_m, residual) = certify(self.problem, self.closure, &self.near.p, &self.near.v, gap_sum_m);
            // What was left out lies apart from the plane as long as its v, which is at least the bound, does.
            if -plane_m <= self.bound {
                return residual;
            }
            self.look(if plane_m.is_finite() { -plane_m } else { f64::INFINITY });
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
            let mut residual = self.certified();
            let claimed = residual.worst() <= solver.tolerance;
            let tolerable = TOLERABLE_DRIFT * residual.worst().max(solver.tolerance) * self.problem.rms_height_m();
            if !is_fresh && (claimed || self.drift_m > tolerable) {
                self.refresh();
                is_fresh = true;
                residual = self.certified();
                // Rounding that undoes the progress made since it last did so leaves none to be made.
                if claimed && residual.worst() > solver.tolerance {
                    if residual.worst() > 0.5 * last_refuted {
                        break StopReason::PrecisionLimit;
                    }
                    last_refuted = residual.worst();
                }
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
                self.has_history = false;
                self.refresh();
                is_fresh = true;
            }
        };
        self.finish(iterations, stop_reason)
    }

    /// Makes members of the cells near contact whose pressure and v are `wanted`, with v − λ as their gradient.
    fn choose(&mut self, wanted: impl Fn(f64, f64) -> bool, lambda: f64) {
        let Self { near, members, pressure, gradient, last_step, last_image, .. } = self;
        for list in [&mut *pressure, &mut *gradient, &mut *last_step, &mut *last_image] {
            list.clear();
        }
        let mut held = 0_usize;
        let upper = self.upper;
        let cells = near.places.iter().zip(&near.p).zip(&near.v).zip(&near.step).zip(&near.image);
        members.replace(cells.filter_map(|((((place, p), v), step), image)| {
            if !wanted(*p, *v) {
                held += usize::from(*p >= upper);
                return None;
            }
            pressure.push(*p);
            gradient.push(v - lambda);
            last_step.push(*step);
            last_image.push(*image);
            Some(*place)
        }));
        self.held_pressure = if held > 0 { held as f64 * upper } else { 0.0 };
    }

    /// Finds the multiplier λ, the cells that may move, and their gradient (centred where the sum is fixed).
    fn gradient_on_working_set(&mut self, last_lambda: f64) -> f64 {
        let upper = self.upper;
        if self.closure.plane_m().is_some() {
            self.choose(|p, v| may_move(p, v - last_lambda, upper), last_lambda);
            return last_lambda;
        }
        let mut lambda = tangent_multiplier(&self.near.p, &self.near.v, upper, last_lambda);
        // Cells that were left out count as soon as their v is below the multiplier, and then lower it.
        while lambda > self.bound {
            self.look(lambda);
            lambda = tangent_multiplier(&self.near.p, &self.near.v, upper, lambda);
        }
        self.choose(|p, v| may_move(p, v - lambda, upper), lambda);
        centre(&mut self.gradient);
        // Where the multiplier may well be next time.
        self.bound = lambda + (lambda - last_lambda).abs();
        lambda
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
                let (clipped, _) = self.restrict();
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
        let Self { mean, members, gradient, preconditioned, workspace, .. } = self;
        self.problem.half_space().stiffen(*mean, members, gradient, preconditioned, workspace);
        if self.closure.plane_m().is_none() {
            centre(&mut self.preconditioned);
        }
    }

    /// Slope of the energy along the step on trial. With a fixed sum the multiplier drops out, but keeping it avoids
    /// cancellation.
    fn slope(&self, lambda: f64) -> f64 {
        let v = |place: &u32| self.v[*place as usize];
        self.members.places().iter().zip(&self.trial).map(|(place, s)| (v(place) - lambda) * s).sum()
    }

    /// A gradient projection over all cells, not over those that may move alone.
    fn project_everywhere(&mut self, lambda: f64) -> bool {
        let length = self.gradient_length();
        loop {
            self.choose(|_, _| true, lambda);
            self.trial.clear();
            self.trial.extend(self.gradient.iter().map(|g| -length * g));
            let (clipped, shift) = self.restrict();
            // A common shift presses those other cells that lie apart by less than it is worth.
            let reached = lambda + shift / length;
            if reached <= self.bound || self.bound == f64::INFINITY {
                let slope = self.slope(lambda);
                return slope < 0.0 && self.take(slope, clipped);
            }
            self.look(if reached.is_finite() { reached } else { f64::INFINITY });
        }
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
    /// cut it, and the shift.
    fn restrict(&mut self) -> (bool, f64) {
        for (t, p) in self.trial.iter_mut().zip(&self.pressure) {
            *t += p;
        }
        let upper = self.upper;
        let [outside] = sums(&self.trial, &self.trial, |t, _| [if (t < 0.0) | (t > upper) { 1.0 } else { 0.0 }]);
        let mut shift = 0.0;
        if let Closure::Sum { pascal } = self.closure {
            shift = project_to_sum(&mut self.trial, upper, pascal - self.held_pressure);
        } else {
            for t in &mut self.trial {
                *t = t.clamp(0.0, upper);
            }
        }
        for (t, p) in self.trial.iter_mut().zip(&self.pressure) {
            *t -= p;
        }
        (outside > 0.0, shift)
    }

    /// The preconditioned gradient made conjugate to the last realised step, plus the correction of that step's length;
    /// under a fixed plane the pressure itself is a second such direction, which settles the load level.
    fn conjugate_direction(&mut self) {
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
            let pu = self.work_of_members();
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

    /// Σ p u over the members.
    fn work_of_members(&self) -> f64 {
        let mean_height_m = self.problem.mean_height_m();
        let columns = self.heights_m.ncols();
        let displacement =
            |place: usize| self.v[place] + self.heights_m[[place / columns, place % columns]] - mean_height_m;
        self.members.places().iter().zip(&self.pressure).map(|(place, p)| p * displacement(*place as usize)).sum()
    }

    /// Goes along `trial`, whose slope is negative, as far as lowers the energy.
    fn take(&mut self, slope: f64, clipped: bool) -> bool {
        let half_space = self.problem.half_space();
        let optimal = -slope / half_space.energy_of_step(self.mean, &self.members, &self.trial, self.workspace);
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
        for ((place, step), before) in self.members.places().iter().zip(&self.trial).zip(&self.pressure) {
            // The step was formed as (bound − p), so a whole step lands on the bound exactly up to rounding.
            let mut after = (before + length * step).clamp(0.0, self.upper);
            if length >= 1.0 && *step == -before {
                after = 0.0;
            } else if length >= 1.0 && *step == self.upper - before {
                after = self.upper;
            }
            moved |= after != *before;
            self.p[*place as usize] = after;
        }
        self.displace(length);
        self.step_length *= optimal.clamp(0.3, 1.5);
        self.has_history = true;
        moved
    }

    /// Adds the displacement by `length` times the step on trial, and notes which cells are near contact then.
    fn displace(&mut self, length: f64) {
        let half_space = self.problem.half_space();
        let (columns, unit_m, bound) = (self.heights_m.ncols(), half_space.unit_of_step_m(&self.trial), self.bound);
        let (members, trial) = (&self.members, &self.trial);
        let gap_m = if let Closure::Gap { metre } = self.closure { Some(metre) } else { None };
        let chunk = ROWS_OF_SLAB * columns;
        let fields = self.v.chunks_mut(chunk).zip(self.p.chunks(chunk));
        let slabs = fields.zip(&mut self.slabs).map(|((v, p), near)| {
            near.clear();
            Slab { v, p, near }
        });
        let take = |slab: &mut Slab<'_>, row: usize, values: &[f32]| {
            let piece = row % ROWS_OF_SLAB * columns..(row % ROWS_OF_SLAB + 1) * columns;
            let (v, p, near) = (&mut slab.v[piece.clone()], &slab.p[piece], &mut *slab.near);
            for (v, value) in v.iter_mut().zip(values) {
                *v += length * (unit_m * f64::from(*value));
            }
            for (column, step) in members.columns(row).zip(&trial[members.rows(row, row + 1)]) {
                near.row[column] = *step;
            }
            near.take_up(row * columns, p, v, bound, |near, i| (near.row[i], unit_m * f64::from(values[i])));
            members.columns(row).for_each(|column| near.row[column] = 0.0);
            if let Some(metre) = gap_m {
                near.gap_sum_m += gap_sum_m(p, v, metre);
            }
        };
        half_space.displace_by_step(slabs.collect(), take, self.workspace);
        self.near.clear();
        for slab in &self.slabs {
            self.near.append(slab);
        }
        let largest = self.near.image.iter().fold(0.0_f64, |largest, image| largest.max(image.abs()));
        self.drift_m += SINGLE_PRECISION * length * largest;
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
        let (height_m, residual) = certify(problem, self.closure, &self.p, &self.v, None);
        let shape = problem.heights_m().dim();
        let map = |values: Vec<f64>| {
            let mut iter = values.into_iter();
            Array2::from_shape_simple_fn(shape, || iter.next().unwrap_or(f64::NAN))
        };
        // A mean compliance that was left out moves surface and plane alike.
        let mean_p = self.p.iter().sum::<f64>() / self.p.len() as f64;
        let shift_m = self.missing_compliance_m_per_pa * mean_p;
        let mean_height_m = problem.mean_height_m();
        let displacement_m =
            self.v.iter().zip(&self.heights_m).map(|(v, z)| v + (z - mean_height_m) + shift_m).collect();
        let signed_gap_m = self.v.iter().map(|v| v + height_m).collect();
        Solution {
            grid: problem.half_space().grid(),
            boundary: problem.half_space().boundary(),
            hardness_pa: problem.hardness_pa(),
            pressure_pa: map(self.p),
            displacement_m: map(displacement_m),
            signed_gap_m: map(signed_gap_m),
            plane_m: problem.plane_m().unwrap_or(mean_height_m + height_m - shift_m),
            mean_height_m,
            highest_m: problem.highest_m(),
            iterations,
            residual,
            stop_reason,
        }
    }
}
