//! State and steps of one solve; see [`Solver`](crate::Solver).

use ndarray::{Array2, CowArray, Ix2};

use crate::conditions::Closure;
use crate::half_space::{MOST_KEPT, MeanMode};
use crate::projection::{Extent, Shift, project_to_sum, tangent_multiplier};
use crate::slab::{Advance, Direction, Part, Products, Slab, Step, Summary};
use crate::solution::{Residual, certify};
use crate::{Boundary, ContactProblem, ContactWorkspace, Solution, SolverStop};
use asperity_base::fourier::ROWS_OF_SLAB;
use asperity_base::monitor::Monitor;

/// Height, over the roughness, that is lost in the rounding of displacements.
const NEGLIGIBLE_HEIGHT: f64 = 1e-14;
/// Period, in iterations, of the plain gradient projection that guarantees convergence.
const GRADIENT_PROJECTION_PERIOD: usize = 32;
/// Least optimal length, as a fraction of a clipped step, for which the whole step is taken.
const WHOLE_STEP_FROM: f64 = 0.7;
/// Largest factor on a step under a prescribed sum. The sum of a step is zero only up to rounding.
const LONGEST_STEP: f64 = 1e6;
/// Residual below which steps may consist of rounding errors only.
const ROUNDING_RESIDUAL: f64 = 1e-12;
/// Iterations without halving the residual after which rounding is assumed to dominate below [`ROUNDING_RESIDUAL`].
const WANDERING_ITERATIONS: usize = 100;
/// Least slope of a descent direction, as a fraction of the steepest slope.
const LEAST_SLOPE: f64 = 1e-4;
/// Typical error of a displacement in single precision over the largest displacement.
const SINGLE_PRECISION: f64 = 6e-8;
/// Largest fraction of the residual due to single-precision errors before v is recomputed.
const TOLERABLE_DRIFT: f64 = 0.5;
/// Residuals are bounded from below only while the bound exceeds the tolerance by this factor.
const CLEARLY: f64 = 4.0;
/// Least such bound that is used: it is a difference of sums.
const CANCELLATION: f64 = 1e-10;

/// Tolerance of the residuals, and largest number of iterations.
#[derive(Debug, Clone, Copy)]
pub(super) struct Limits {
    pub(super) tolerance: f64,
    pub(super) max_iterations: usize,
}

/// Iterate of one solve. Heights are counted from their mean, and v = S p − z throughout.
///
/// Steps are displaced in single precision. This halves the cost and adds an error to v that is small against the step.
/// Before the errors matter, v is recomputed in double precision, so the final state has double precision.
///
/// Pressures and v are stored only for the cells near contact, see [`Slab`].
pub(super) struct Descent<'a> {
    problem: &'a ContactProblem<'a>,
    closure: Closure,
    workspace: &'a mut ContactWorkspace,
    mean: MeanMode,
    /// Mean compliance of the half-space beyond that of `mean`, in m/Pa.
    missing_compliance_m_per_pa: f64,
    heights_m: CowArray<'a, f64, Ix2>,
    /// v of all cells as last recomputed, and whether it is current.
    v: Vec<f64>,
    is_fresh: bool,
    /// Least v of a cell without pressure that counts as far from contact.
    bound: f64,
    /// The bound after the next step.
    next_bound: f64,
    lambda: f64,
    summary: Summary,
    products: Products,
    /// Units of the gradient, of the last step and of the image of that step.
    gradient_unit_m: f64,
    step_unit_pa: f64,
    image_unit_m: f64,
    step_length: f64,
    has_history: bool,
    /// Estimated error of v = S p − z, in metre.
    drift_m: f64,
}

/// Kind of search direction.
#[derive(Clone, Copy, PartialEq)]
enum Attempt {
    Conjugate,
    Preconditioned,
    Gradient,
}

impl<'a> Descent<'a> {
    /// Starts from the pressure `start` within the bounds, in whose memory the descent keeps v. On a periodic half-space
    /// the mean compliance in m/Pa can be given.
    pub(super) fn new(
        problem: &'a ContactProblem<'a>,
        closure: Closure,
        start: Vec<f64>,
        mean_compliance: Option<f64>,
        workspace: &'a mut ContactWorkspace,
    ) -> Self {
        let missing_compliance_m_per_pa = match (problem.half_space().boundary(), mean_compliance) {
            (Boundary::Periodic { mean_compliance_m_per_pa }, Some(used)) => mean_compliance_m_per_pa - used,
            _ => 0.0,
        };
        let unit_m = problem.rms_height_m();
        workspace.near.begin(problem.heights_m().ncols(), &start, problem.hardness_pa(), unit_m);
        let uniform = start.first().filter(|first| start.iter().all(|p| p == *first)).copied();
        let mut descent = Self {
            problem,
            closure,
            workspace,
            mean: problem.half_space().mean_mode(mean_compliance),
            missing_compliance_m_per_pa,
            heights_m: problem.heights_m().as_standard_layout(),
            v: start,
            is_fresh: false,
            bound: closure.plane_m().map_or(f64::NEG_INFINITY, |plane_m| -plane_m),
            next_bound: f64::NEG_INFINITY,
            lambda: closure.plane_m().map_or(0.0, |plane_m| -plane_m),
            summary: Summary::NONE,
            products: Products::default(),
            gradient_unit_m: unit_m,
            step_unit_pa: 1.0,
            image_unit_m: 1.0,
            step_length: 1.0,
            has_history: false,
            drift_m: 0.0,
        };
        descent.next_bound = descent.bound;
        descent.refresh(uniform);
        descent
    }

    /// Removes the drift of rounding in the recurrences: restores the prescribed sum by a common shift of the cells
    /// between the bounds, and recomputes v = S p − z. If the pressure is known to be `uniform`, that may need no
    /// transform.
    fn refresh(&mut self, uniform: Option<f64>) {
        if matches!(self.closure, Closure::Sum { .. }) {
            let extent = self.workspace.near.fold(Extent::NONE, Slab::propose_itself, Extent::with);
            let shift = self.shift_to_sum(extent);
            self.workspace.near.each(|slab| {
                slab.restrict(shift);
                slab.step_pressure();
            });
        }
        if self.v.len() > MOST_KEPT {
            self.workspace.near.each(Slab::release_scratch);
        }
        let periodic = matches!(self.problem.half_space().boundary(), Boundary::Periodic { .. });
        let columns = self.heights_m.ncols();
        let (origin_m, bound) = (self.lambda, self.bound);
        let mean_height_m = self.problem.mean_height_m();
        let heights_m = self.heights_m.as_slice().unwrap_or(&[]);
        let chunk = ROWS_OF_SLAB * columns;
        let ContactWorkspace { transforms, near, .. } = &mut *self.workspace;
        let fields = heights_m.chunks(chunk).zip(self.v.chunks_mut(chunk));
        let mut slabs: Vec<_> = near.as_mut_slice().iter_mut().zip(fields).collect();
        type Fields<'s> = (&'s mut Slab, (&'s [f64], &'s mut [f64]));
        let take = |(slab, (heights_m, v)): &mut Fields<'_>, row: usize, values: &[f64]| {
            let piece = row % ROWS_OF_SLAB * columns..(row % ROWS_OF_SLAB + 1) * columns;
            let v = &mut v[piece.clone()];
            for ((v, u), z) in v.iter_mut().zip(values).zip(&heights_m[piece]) {
                *v = u - (z - mean_height_m);
            }
            slab.settle(row, v, origin_m, bound);
        };
        match uniform {
            Some(pressure_pa) if periodic || pressure_pa == 0.0 => {
                let values = vec![self.mean.displacement_m(pressure_pa); columns];
                for row in 0..self.heights_m.nrows() {
                    take(&mut slabs[row / ROWS_OF_SLAB], row, &values);
                }
            }
            _ => {
                let fill = |(slab, _): &mut Fields<'_>, row: usize, out: &mut [f64]| slab.write_pressure(row, out);
                self.problem.half_space().displace_by(self.mean, &mut slabs, fill, take, transforms);
            }
        }
        self.drift_m = 0.0;
        self.is_fresh = true;
        self.sum_up();
    }

    /// Adds the cells of the whole grid whose v is below `bound` to the lists of cells near contact.
    fn look(&mut self, bound: f64) {
        self.bound = bound;
        self.workspace.near.look(bound, self.is_fresh.then_some(self.v.as_slice()));
        self.sum_up();
    }

    fn sum_up(&mut self) {
        self.summary = self.workspace.near.iter().map(|slab| slab.summary).fold(Summary::NONE, Summary::with);
    }

    /// Returns the residuals from the cells near contact, or lower bounds while they are much larger than `tolerance`.
    fn certified(&mut self, tolerance: f64) -> Residual {
        let bound = self.least_residual();
        if bound.worst() > CLEARLY * tolerance.max(CANCELLATION) {
            return bound;
        }
        loop {
            let gap_sum_m = self.gap_sum_m();
            let parts: Vec<Part<'_>> = self.workspace.near.iter().map(Slab::part).collect();
            let (plane_m, residual) = certify(self.problem, self.closure, &parts, gap_sum_m);
            // Cells left out have a gap as long as their v exceeds −plane; their v is at least the bound.
            if -plane_m <= self.bound || self.bound == f64::INFINITY {
                return residual;
            }
            self.look(if plane_m.is_finite() { -plane_m } else { f64::INFINITY });
        }
    }

    /// Returns lower bounds of the residuals, from known sums.
    fn least_residual(&self) -> Residual {
        let Summary { pressure, free, free_v, least_v, .. } = self.summary;
        let rms_height_m = self.problem.rms_height_m();
        let plane_m = self.closure.plane_m().unwrap_or(self.summary.resting_m());
        let lambda = if matches!(self.closure, Closure::Plane { .. }) { -plane_m } else { least_v };
        let frank_wolfe = if pressure > 0.0 { (free_v - lambda * free) / (pressure * rms_height_m) } else { 0.0 };
        let load = if let Closure::Sum { pascal } = self.closure { (pressure / pascal - 1.0).abs() } else { 0.0 };
        Residual { frank_wolfe, overlap: (-(least_v + plane_m)).max(0.0) / rms_height_m, load }
    }

    /// Returns the sum of the gaps of all cells if the residuals need it.
    fn gap_sum_m(&self) -> Option<f64> {
        let Closure::Gap { metre } = self.closure else { return None };
        let gap = |v: f64| v + metre;
        // Displacements and heights have mean zero here, so Σ(v + gap) over all cells is known.
        let all = self.v.len() as f64 * metre;
        let touching = |p: f64, v: f64| if (p > 0.0) | (gap(v) <= 0.0) { gap(v) } else { 0.0 };
        let sum = |part: Part<'_>| part.p.iter().zip(part.v).map(|(p, v)| touching(*p, *v)).sum::<f64>();
        Some(all - self.workspace.near.iter().map(|slab| sum(slab.part())).sum::<f64>())
    }

    /// Iterates until the recomputed residuals are below the tolerance, no progress can be represented, or the monitor
    /// cancels.
    pub(super) fn run(mut self, limits: Limits, monitor: &dyn Monitor) -> Solution {
        let mut iterations = 0;
        let mut last_refuted = f64::INFINITY;
        let (mut least, mut least_at) = (f64::INFINITY, 0);
        if self.closure.plane_m().is_none() {
            self.lambda = self.v.iter().sum::<f64>() / self.v.len() as f64;
        }
        let (stop_reason, residual) = loop {
            let mut residual = self.certified(limits.tolerance);
            let claimed = residual.worst() <= limits.tolerance;
            let tolerable = TOLERABLE_DRIFT * residual.worst().max(limits.tolerance) * self.problem.rms_height_m();
            if !self.is_fresh && (claimed || self.drift_m > tolerable) {
                self.refresh(None);
                residual = self.certified(limits.tolerance);
                // If rounding undoes the progress since the last recomputation, no further progress is possible.
                if claimed && residual.worst() > limits.tolerance {
                    if residual.worst() > 0.5 * last_refuted {
                        break (SolverStop::PrecisionLimit, residual);
                    }
                    last_refuted = residual.worst();
                }
            }
            if residual.worst() <= limits.tolerance {
                break (SolverStop::Converged, residual);
            }
            let field_residual = residual.frank_wolfe.max(residual.overlap);
            if field_residual <= 0.5 * least {
                (least, least_at) = (field_residual, iterations);
            }
            let wanders = field_residual < ROUNDING_RESIDUAL && iterations > least_at + WANDERING_ITERATIONS;
            let cancelled = monitor.cancelled();
            if wanders || cancelled || iterations >= limits.max_iterations {
                self.refresh(None);
                let reason = match (wanders, cancelled) {
                    (true, _) => SolverStop::PrecisionLimit,
                    (_, true) => SolverStop::Cancelled,
                    _ => SolverStop::IterationLimit,
                };
                break (reason, self.certified(f64::INFINITY));
            }
            self.find_multiplier();
            let projection_turn = iterations % GRADIENT_PROJECTION_PERIOD == GRADIENT_PROJECTION_PERIOD - 1;
            let was_fresh = self.is_fresh;
            let descended = self.descend(projection_turn);
            self.rescale();
            if descended {
                iterations += 1;
                continue;
            }
            // A step too small to change any pressure may have changed v.
            self.has_history = false;
            if !self.is_fresh {
                self.refresh(None);
            }
            if was_fresh {
                break (SolverStop::PrecisionLimit, self.certified(f64::INFINITY));
            }
        };
        self.finish(iterations, stop_reason, residual)
    }

    /// Computes the multiplier λ: the negative height of the plane if it is fixed, otherwise the λ for which the
    /// gradient of the cells that may move has mean zero.
    fn find_multiplier(&mut self) {
        if self.closure.plane_m().is_some() {
            return;
        }
        let last_lambda = self.lambda;
        let negligible = NEGLIGIBLE_HEIGHT * self.problem.rms_height_m();
        loop {
            let near = &self.workspace.near;
            self.lambda =
                tangent_multiplier(self.lambda, negligible, |lambda| near.sums(|slab| slab.tangent_sums(lambda)));
            // Cells that were left out count as soon as their v is below the multiplier. They then lower it.
            if self.lambda <= self.bound {
                break;
            }
            self.look(self.lambda);
        }
        // The multiplier of the next iteration is expected within this margin, once it has changed at least once.
        let margin = if self.has_history { 2.0 * (self.lambda - last_lambda).abs() } else { 0.0 };
        self.next_bound = self.lambda + margin;
    }

    /// Takes one step that lowers the energy, or returns false if none can be represented.
    fn descend(&mut self, projection_turn: bool) -> bool {
        self.precondition();
        if projection_turn {
            if self.project_everywhere() {
                return true;
            }
            // The projection may have added cells to the lists.
            self.precondition();
        }
        // A length from an iteration with many clipped steps may be far too large or small later.
        let lengths = [self.step_length, 1.0];
        for &length in if self.step_length == 1.0 { &lengths[..1] } else { &lengths[..] } {
            self.step_length = length;
            for attempt in [Attempt::Conjugate, Attempt::Preconditioned, Attempt::Gradient] {
                if attempt == Attempt::Conjugate && !self.has_history {
                    continue;
                }
                let (step, _) = self.propose(self.direction(attempt));
                let steepest = (self.products.gg * step.square).sqrt();
                // The projected gradient is a descent direction at any angle to the gradient.
                if step.slope < 0.0 && (attempt == Attempt::Gradient || -step.slope >= LEAST_SLOPE * steepest) {
                    return self.take(step);
                }
            }
        }
        false
    }

    /// Preconditions the gradient v − λ of the cells that may move.
    fn precondition(&mut self) {
        let (lambda, unit_m) = (self.lambda, self.gradient_unit_m);
        let fill = |slab: &mut Slab, row: usize, out: &mut [f32]| {
            if row.is_multiple_of(ROWS_OF_SLAB) {
                slab.differentiate(lambda, unit_m, false);
            }
            slab.scatter_gradient(row, out)
        };
        let take = Slab::take_preconditioned;
        let ContactWorkspace { transforms, near, .. } = &mut *self.workspace;
        self.problem.half_space().stiffen(self.mean, near.as_mut_slice(), fill, take, transforms);
        self.products = near.iter().map(|slab| slab.products).fold(Products::default(), Products::with);
    }

    /// Sets the gradient's unit for the next iteration to its root mean square now, so that squares can be represented.
    fn rescale(&mut self) {
        let rms = (self.products.gg / self.products.members).sqrt();
        if rms.is_finite() && rms > 0.0 {
            self.gradient_unit_m *= rms;
        }
    }

    /// Takes a gradient projection over all cells, not only over those that may move.
    fn project_everywhere(&mut self) -> bool {
        let length = self.gradient_length();
        let (lambda, unit_m) = (self.lambda, self.gradient_unit_m);
        loop {
            self.workspace.near.each(|slab| slab.differentiate(lambda, unit_m, true));
            let direction = Direction { gradient: -length * unit_m, ..Direction::default() };
            let (step, shift) = self.propose(direction);
            // A common shift also presses other cells whose gap is smaller than the shift.
            let reached = lambda + shift.largest() / length;
            if reached <= self.bound || self.bound == f64::INFINITY {
                return step.slope < 0.0 && self.take(step);
            }
            self.look(if reached.is_finite() { reached } else { f64::INFINITY });
        }
    }

    /// Returns a length for steps along the gradient, comparable to the length of preconditioned steps.
    fn gradient_length(&self) -> f64 {
        let Products { g, z, gg, gz, .. } = self.products;
        let usual = self.problem.half_space().stiffness_unit_pa_per_m();
        let scale = (gz - self.centre(z) * g) / gg;
        self.step_length * usual * if scale.is_finite() && scale > 0.0 { scale } else { 1.0 }
    }

    /// Returns the mean over the cells that may move of a quantity with this `sum`, if the sum of the pressure is
    /// fixed; steps have mean zero then. Otherwise returns zero.
    fn centre(&self, sum: f64) -> f64 {
        if self.closure.plane_m().is_some() || self.products.members == 0.0 { 0.0 } else { sum / self.products.members }
    }

    /// Returns the unit of the preconditioned gradient.
    fn preconditioned_unit_pa(&self) -> f64 {
        self.problem.half_space().stiffness_unit_pa_per_m() * self.gradient_unit_m
    }

    /// Returns the search direction of an attempt.
    fn direction(&self, attempt: Attempt) -> Direction {
        let length = self.step_length * self.preconditioned_unit_pa();
        let preconditioned = Direction {
            preconditioned: -length,
            constant: length * self.centre(self.products.z),
            ..Direction::default()
        };
        match attempt {
            Attempt::Conjugate => self.conjugate_direction(preconditioned),
            Attempt::Preconditioned => preconditioned,
            Attempt::Gradient => {
                Direction { gradient: -self.gradient_length() * self.gradient_unit_m, ..Direction::default() }
            }
        }
    }

    /// Returns the preconditioned gradient made conjugate to the last realised step, plus the correction of that step's
    /// length. Under a fixed plane the pressure itself is a second such direction, which adjusts the level of the load.
    fn conjugate_direction(&self, preconditioned: Direction) -> Direction {
        let Products { g, z, s, w, gs, sw, zw, .. } = self.products;
        let (mean_s, mean_z) = (self.centre(s), self.centre(z));
        // In the units of gradient, preconditioned gradient, step and image.
        let curvature = sw - mean_s * w;
        let gradient_step = gs - mean_s * g;
        let conjugacy = zw - mean_z * w;
        let by_gradient = self.gradient_unit_m / self.image_unit_m;
        let by_preconditioned = self.preconditioned_unit_pa() / self.step_unit_pa;
        let mut beta = (conjugacy / curvature * by_preconditioned).max(0.0);
        let (mut gamma, mut level) = (-gradient_step / curvature * by_gradient, 0.0);
        // Without cells at the hardness, the cells that may move carry all pressure. u = S p is known as v + z.
        if self.closure.plane_m().is_some() && self.summary.full == 0.0 {
            let [pw, pg, pu] = self.level();
            let curvature = curvature * self.step_unit_pa * self.image_unit_m;
            let gradient_step = gradient_step * self.gradient_unit_m * self.step_unit_pa;
            let determinant = curvature * pu - pw * pw;
            if determinant > 1e-6 * curvature * pu {
                gamma = -(gradient_step * pu - pg * pw) / determinant;
                level = -(pg * curvature - gradient_step * pw) / determinant;
            }
        }
        if !(beta.is_finite() && gamma.is_finite() && level.is_finite()) {
            (beta, gamma, level) = (0.0, 0.0, 0.0);
        }
        let along_step = (self.step_length * beta + gamma) * self.step_unit_pa;
        let constant = preconditioned.constant - along_step * mean_s;
        Direction { pressure: level, step: along_step, constant, ..preconditioned }
    }

    /// Returns Σ p w, Σ p g and Σ p u over the cells that may move.
    fn level(&self) -> [f64; 3] {
        let mean_height_m = self.problem.mean_height_m();
        let heights_m = self.heights_m.as_slice().unwrap_or(&[]);
        let chunks = heights_m.chunks(ROWS_OF_SLAB * self.heights_m.ncols());
        let levels = self.workspace.near.iter().zip(chunks).map(|(slab, z)| slab.level(z, mean_height_m));
        let [pw, pg, pu] = levels.fold([0.0; 3], |sums, terms| std::array::from_fn(|k| sums[k] + terms[k]));
        [pw * self.image_unit_m, pg * self.gradient_unit_m, pu]
    }

    /// Computes the trial step of `direction`, within the bounds and with the prescribed sum. Returns the step and its
    /// shift. With a fixed sum the multiplier drops out of the slope, but keeping it avoids cancellation.
    fn propose(&mut self, direction: Direction) -> (Step, Shift) {
        let extent = self.workspace.near.fold(Extent::NONE, |slab| slab.propose(direction), Extent::with);
        let shift = self.shift_to_sum(extent);
        let restricted = |slab: &mut Slab| {
            slab.restrict(shift);
            slab.step
        };
        let step = self.workspace.near.fold(Step::default(), restricted, Step::with);
        (step, shift)
    }

    /// Returns the shift after which the trial has the prescribed sum, if a sum is prescribed.
    fn shift_to_sum(&self, extent: Extent) -> Shift {
        let Closure::Sum { pascal } = self.closure else { return Shift::NONE };
        let near = &self.workspace.near;
        let [fixed] = near.sums(|slab| [slab.fixed()]);
        project_to_sum(extent, fixed, pascal, |shift| near.sums(|slab| slab.shifted_sum(shift)))
    }

    /// Follows the trial step, whose slope is negative, by a length that lowers the energy.
    fn take(&mut self, step: Step) -> bool {
        let half_space = self.problem.half_space();
        let unit_pa = step.largest;
        let unit_m = half_space.compliance_unit_m_per_pa() * unit_pa;
        let fill = |slab: &mut Slab, row: usize, out: &mut [f32]| slab.scatter_step(row, unit_pa, out);
        let ContactWorkspace { transforms, near, .. } = &mut *self.workspace;
        let energy = half_space.compliance_forward(self.mean, near.as_mut_slice(), fill, transforms);
        let optimal = -step.slope * self.gradient_unit_m / (energy * unit_m * unit_pa);
        if !(optimal.is_finite() && optimal > 0.0) {
            self.has_history = false;
            return false;
        }
        let length = if step.cut > 0.0 {
            if optimal >= WHOLE_STEP_FROM { 1.0 } else { optimal }
        } else if optimal > 1.0 {
            let longest = if self.closure.plane_m().is_some() { f64::INFINITY } else { LONGEST_STEP };
            let feasible = near.fold(f64::INFINITY, |slab| slab.longest_feasible(), f64::min);
            optimal.min(feasible).min(longest)
        } else {
            optimal
        };
        self.bound = self.next_bound;
        let advance = Advance { length, unit_pa, unit_m, bound: self.bound };
        let take = |slab: &mut Slab, row: usize, values: &[f32]| slab.advance(row, advance, values);
        half_space.compliance_backward(near.as_mut_slice(), take, transforms);
        (self.step_unit_pa, self.image_unit_m) = (unit_pa, unit_m);
        self.is_fresh = false;
        self.sum_up();
        self.drift_m += SINGLE_PRECISION * length * unit_m * self.summary.largest_image;
        self.step_length *= optimal.clamp(0.3, 1.5);
        self.has_history = true;
        self.summary.moved
    }

    fn finish(self, iterations: usize, stop_reason: SolverStop, residual: Residual) -> Solution {
        let problem = self.problem;
        let shape = problem.heights_m().dim();
        // What rounding leaves of a pressure that fell to zero is no contact.
        let near = &mut self.workspace.near;
        let largest = near.fold(0.0, |slab| slab.largest_pressure(), f64::max);
        near.each(|slab| slab.drop_below(f64::EPSILON * largest));
        let mut pressure_pa = Array2::zeros(shape);
        for (row, out) in pressure_pa.as_slice_mut().unwrap_or(&mut []).chunks_mut(shape.1).enumerate() {
            self.workspace.near.of_row(row).write_pressure(row, out);
        }
        if self.v.len() > MOST_KEPT {
            self.workspace.near.release();
        }
        let height_m = self.closure.plane_m().unwrap_or(self.summary.resting_m());
        // A mean compliance that was left out moves surface and plane by the same amount.
        let shift_m = self.missing_compliance_m_per_pa * self.summary.pressure / self.v.len() as f64;
        let mean_height_m = problem.mean_height_m();
        let mut v = self.v;
        let displacement_m = v.iter().zip(&self.heights_m).map(|(v, z)| v + (z - mean_height_m) + shift_m).collect();
        v.iter_mut().for_each(|v| *v += height_m);
        let map = |values: Vec<f64>| Array2::from_shape_vec(shape, values).unwrap_or_else(|_| Array2::zeros(shape));
        Solution {
            grid: problem.half_space().grid(),
            boundary: problem.half_space().boundary(),
            modulus_pa: problem.half_space().modulus_pa(),
            hardness_pa: problem.hardness_pa(),
            pressure_pa,
            displacement_m: map(displacement_m),
            signed_gap_m: map(v),
            plane_m: problem.plane_m().unwrap_or(mean_height_m + height_m - shift_m),
            mean_height_m,
            highest_m: problem.highest_m(),
            iterations,
            residual,
            stop_reason,
        }
    }
}
