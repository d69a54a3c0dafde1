//! The moving parts of one solve: see [`Solver`].

use ndarray::{Array2, CowArray, Ix2};

use crate::contact::half_space::MeanMode;
use crate::contact::projection::{Shift, project_to_sum, tangent_multiplier};
use crate::contact::slab::{Direction, Extent, Products, Rows, Slab, Slabs};
use crate::contact::solution::{Part, Residual, certify};
use crate::contact::solver::{Closure, Solver};
use crate::contact::vectors::sums;
use crate::contact::{Boundary, Problem, Solution, StopReason, Workspace};
use crate::fourier::ROWS_OF_SLAB;

/// Height over the roughness that is lost in the rounding of displacements.
const NEGLIGIBLE_HEIGHT: f64 = 1e-14;
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
    near: Slabs,
    bound: f64,
    /// The bound after the next step.
    next_bound: f64,
    products: Products,
    step_length: f64,
    has_history: bool,
    /// How far v may be from S p − z, in metre.
    drift_m: f64,
}

/// What one attempt at a direction is built from.
#[derive(Clone, Copy, PartialEq)]
enum Attempt {
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
            near: Slabs::new(rows, columns),
            bound: f64::NEG_INFINITY,
            next_bound: closure.plane_m().map_or(f64::NEG_INFINITY, |plane_m| -plane_m),
            products: Products::default(),
            step_length: 1.0,
            has_history: false,
            drift_m: 0.0,
        };
        descent.look(descent.next_bound);
        descent.refresh();
        descent
    }

    /// Undoes the drift of rounding in the recurrences: restores the prescribed sum by a common shift of the cells between
    /// the bounds, and computes v = S p − z afresh.
    fn refresh(&mut self) {
        if matches!(self.closure, Closure::Sum { .. }) {
            let upper = self.upper;
            let extents = self.near.map(|slab| slab.propose_itself(upper));
            let extent = extents.into_iter().fold(Extent::NONE, Extent::with);
            let shift = self.shift_to_sum(extent);
            self.near.map(|slab| slab.restrict(shift, 0.0, upper));
            self.near.write_stepped(&mut self.p, upper);
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
        self.near.look(&self.p, &self.v, bound);
    }

    /// Residuals, by the cells near contact.
    fn certified(&mut self) -> Residual {
        let gap_sum_m = if let Closure::Gap { metre } = self.closure {
            let [sum] = sums(&self.p, &self.v, |p, v| [if (p <= 0.0) & (v + metre > 0.0) { v + metre } else { 0.0 }]);
            Some(sum)
        } else {
            None
        };
        loop {
            let parts: Vec<Part<'_>> = self.near.iter().map(|slab| Part { p: &slab.p, v: &slab.v }).collect();
            let (plane_m, residual) = certify(self.problem, self.closure, &parts, gap_sum_m);
            // What was left out lies apart from the plane as long as its v, which is at least the bound, does.
            if -plane_m <= self.bound || self.bound == f64::INFINITY {
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
            lambda = self.multiplier(lambda);
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
        self.finish(iterations, stop_reason, solver.tolerance)
    }

    /// The multiplier λ: the negative height of the plane, or the one for which the gradient of the cells that may move has no
    /// mean.
    fn multiplier(&mut self, last_lambda: f64) -> f64 {
        if self.closure.plane_m().is_some() {
            return last_lambda;
        }
        let negligible = NEGLIGIBLE_HEIGHT * self.problem.rms_height_m();
        let upper = self.upper;
        let find = |near: &mut Slabs, start: f64| {
            near.map(|slab| slab.sort_by_bound(upper));
            tangent_multiplier(start, negligible, |lambda| near.sums(|slab| slab.tangent_sums(lambda)))
        };
        let mut lambda = find(&mut self.near, last_lambda);
        // Cells that were left out count as soon as their v is below the multiplier, and then lower it.
        while lambda > self.bound {
            self.look(lambda);
            lambda = find(&mut self.near, lambda);
        }
        // Where the multiplier may well be next time.
        self.next_bound = lambda + 2.0 * (lambda - last_lambda).abs();
        lambda
    }

    /// Takes one step that lowers the energy, or returns false if none can be represented.
    fn descend(&mut self, lambda: f64, projection_turn: bool) -> bool {
        self.precondition(lambda);
        if projection_turn {
            if self.project_everywhere(lambda) {
                return true;
            }
            // Other cells may have been looked up.
            self.precondition(lambda);
        }
        // A length that served where the bounds cut most of the steps may be out of all proportion later on.
        let lengths = [self.step_length, 1.0];
        for &length in if self.step_length == 1.0 { &lengths[..1] } else { &lengths[..] } {
            self.step_length = length;
            for attempt in [Attempt::Conjugate, Attempt::Preconditioned, Attempt::Gradient] {
                if attempt == Attempt::Conjugate && !self.has_history {
                    continue;
                }
                let direction = self.direction(attempt, lambda);
                let (clipped, _, [slope, square]) = self.propose(direction, lambda, false);
                let steepest = (self.products.gg * square).sqrt();
                // The projected gradient is a descent direction whatever its angle with the gradient.
                if slope < 0.0 && (attempt == Attempt::Gradient || -slope >= LEAST_SLOPE * steepest) {
                    return self.take(slope, clipped);
                }
            }
        }
        false
    }

    /// Preconditions the gradient v − λ of the cells that may move.
    fn precondition(&mut self, lambda: f64) {
        let (upper, near) = (self.upper, &self.near);
        let unit_m = self.problem.rms_height_m();
        let fill = |row: usize, out: &mut [f32]| near.of_row(row).scatter_gradient(row, lambda, upper, unit_m, out);
        let half_space = self.problem.half_space();
        half_space.stiffness_forward(self.mean, fill, self.workspace);
        let unit_pa = half_space.stiffness_unit_pa_per_m() * unit_m;
        let take = |slab: &mut &mut Slab, row: usize, values: &[f32]| slab.take_preconditioned(row, values, unit_pa);
        half_space.stiffness_backward(self.near.iter_mut().collect(), take, self.workspace);
        let products = self.near.map(|slab| slab.products(lambda, upper));
        self.products = products.into_iter().fold(Products::default(), Products::with);
    }

    /// A gradient projection over all cells, not over those that may move alone.
    fn project_everywhere(&mut self, lambda: f64) -> bool {
        let length = self.gradient_length();
        let direction = Direction { gradient: -length, ..Direction::default() };
        loop {
            let (clipped, shift, [slope, _]) = self.propose(direction, lambda, true);
            // A common shift presses those other cells that lie apart by less than it is worth.
            let reached = lambda + shift.largest() / length;
            if reached <= self.bound || self.bound == f64::INFINITY {
                return slope < 0.0 && self.take(slope, clipped);
            }
            self.look(if reached.is_finite() { reached } else { f64::INFINITY });
            // Cells looked up anew have no preconditioned gradient, and a gradient projection needs none.
            self.near.map(Slab::forget_preconditioned);
        }
    }

    /// A length for steps along the gradient that compares with that of the preconditioned one.
    fn gradient_length(&self) -> f64 {
        let Products { gg, gz, .. } = self.products;
        let scale = (gz - self.centre(self.products.z) * self.products.g) / gg;
        let usual = self.problem.half_space().stiffness_unit_pa_per_m();
        self.step_length * if scale.is_finite() && scale > 0.0 { scale } else { usual }
    }

    /// The mean of what sums up to `sum` over the cells that may move, where the sum of the pressure is fixed: steps are without.
    fn centre(&self, sum: f64) -> f64 {
        if self.closure.plane_m().is_some() || self.products.members == 0.0 { 0.0 } else { sum / self.products.members }
    }

    /// The step of an attempt.
    fn direction(&self, attempt: Attempt, lambda: f64) -> Direction {
        let length = self.step_length;
        let preconditioned = Direction {
            preconditioned: -length,
            constant: length * self.centre(self.products.z),
            ..Direction::default()
        };
        match attempt {
            Attempt::Conjugate => self.conjugate_direction(preconditioned, lambda),
            Attempt::Preconditioned => preconditioned,
            Attempt::Gradient => Direction { gradient: -self.gradient_length(), ..Direction::default() },
        }
    }

    /// The preconditioned gradient made conjugate to the last realised step, plus the correction of that step's length;
    /// under a fixed plane the pressure itself is a second such direction, which settles the load level.
    fn conjugate_direction(&self, preconditioned: Direction, lambda: f64) -> Direction {
        let Products { g, z, s, w, gs, sw, zw, pw, pg, at_upper, .. } = self.products;
        let (mean_s, mean_z) = (self.centre(s), self.centre(z));
        let curvature = sw - mean_s * w;
        let gradient_step = gs - mean_s * g;
        let conjugacy = zw - mean_z * w;
        let (mut beta, mut gamma, mut level) = ((conjugacy / curvature).max(0.0), -gradient_step / curvature, 0.0);
        // With nothing at the upper bound all pressure is that of the cells that may move; u = S p is known as v + z.
        if self.closure.plane_m().is_some() && at_upper == 0.0 {
            let pu = self.work(lambda);
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
        let constant = preconditioned.constant - along_step * mean_s;
        Direction { pressure: level, step: along_step, constant, ..preconditioned }
    }

    /// Σ p u over the cells that may move.
    fn work(&self, lambda: f64) -> f64 {
        let mean_height_m = self.problem.mean_height_m();
        let heights_m = self.heights_m.as_slice().unwrap_or(&[]);
        let chunks = heights_m.chunks(ROWS_OF_SLAB * self.heights_m.ncols());
        self.near.iter().zip(chunks).map(|(slab, z)| slab.work(z, mean_height_m, lambda, self.upper)).sum()
    }

    /// Puts the step of `direction`, within the bounds and with the prescribed sum, on trial; returns whether a bound cut it, by
    /// how much it was shifted, and its slope and squared norm. With a fixed sum the multiplier drops out of the slope, but
    /// keeping it avoids cancellation.
    fn propose(&mut self, direction: Direction, lambda: f64, all: bool) -> (bool, Shift, [f64; 2]) {
        let upper = self.upper;
        let extents = self.near.map(|slab| slab.propose(direction, lambda, upper, all));
        let extent = extents.into_iter().fold(Extent::NONE, Extent::with);
        let shift = self.shift_to_sum(extent);
        let sums = self.near.map(|slab| slab.restrict(shift, lambda, upper));
        let sums = sums.into_iter().fold([0.0; 2], |sum, part| [sum[0] + part[0], sum[1] + part[1]]);
        (shift.cuts(extent, upper), shift, sums)
    }

    /// The shift after which the trial has the prescribed sum, if any is.
    fn shift_to_sum(&self, extent: Extent) -> Shift {
        let Closure::Sum { pascal } = self.closure else { return Shift::NONE };
        let upper = self.upper;
        let held = if upper < f64::INFINITY { self.near.sums(|slab| [slab.held(upper)])[0] } else { 0.0 };
        let near = &self.near;
        project_to_sum(extent, held, upper, pascal, |shift| near.sums(|slab| slab.shifted_sum(shift, upper)))
    }

    /// Goes along the step on trial, whose slope is negative, as far as lowers the energy.
    fn take(&mut self, slope: f64, clipped: bool) -> bool {
        let (half_space, upper, near) = (self.problem.half_space(), self.upper, &self.near);
        let unit_pa = near.iter().map(Slab::largest_step).fold(0.0, f64::max);
        let fill = |row: usize, out: &mut [f32]| near.of_row(row).scatter_step(row, unit_pa, out);
        let energy = half_space.compliance_forward(self.mean, fill, self.workspace);
        let unit_m = half_space.compliance_unit_m_per_pa() * unit_pa;
        let optimal = -slope / (energy * unit_m * unit_pa);
        if !(optimal.is_finite() && optimal > 0.0) {
            self.has_history = false;
            return false;
        }
        let length = if clipped {
            if optimal >= WHOLE_STEP_FROM { 1.0 } else { optimal }
        } else if optimal > 1.0 {
            let longest = if self.closure.plane_m().is_some() { f64::INFINITY } else { LONGEST_STEP };
            let feasible = self.near.map(|slab| slab.longest_feasible(upper)).into_iter().fold(f64::INFINITY, f64::min);
            optimal.min(feasible).min(longest)
        } else {
            optimal
        };
        self.bound = self.next_bound;
        let bound = self.bound;
        let mut rows = self.near.rows(&mut self.p, &mut self.v);
        let take = |rows: &mut &mut Rows<'_>, row: usize, values: &[f32]| {
            rows.advance(row, length, unit_m, values, bound, upper);
        };
        half_space.compliance_backward(rows.iter_mut().collect(), take, self.workspace);
        let moved = rows.iter().any(|rows| rows.moved);
        self.near.turn();
        let largest = self.near.map(|slab| slab.largest_image()).into_iter().fold(0.0, f64::max);
        self.drift_m += SINGLE_PRECISION * length * largest;
        self.step_length *= optimal.clamp(0.3, 1.5);
        self.has_history = true;
        moved
    }

    fn finish(self, iterations: usize, stop_reason: StopReason, tolerance: f64) -> Solution {
        let problem = self.problem;
        let (height_m, residual) = certify(problem, self.closure, &[Part { p: &self.p, v: &self.v }], None);
        // Sums over all cells round otherwise than those over the cells near contact.
        let refuted = stop_reason == StopReason::Converged && residual.worst() > tolerance;
        let stop_reason = if refuted { StopReason::PrecisionLimit } else { stop_reason };
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
