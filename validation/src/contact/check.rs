//! Solutions of random problems, each checked from its pressure alone.

use std::error::Error;

use asperity::contact::{Boundary, ContactProblem, Control, Residual, Solver, SolverStop, love_coefficient};

use super::contact_check::{Operator, evaluate};
use super::problems::{RandomProblem, random_problem};

/// Number of cells up to which displacements are also summed directly.
const DENSE_UP_TO: usize = 600;
/// Largest difference between two ways to transform, over the standard deviation of the heights.
const ROUNDING: f64 = 1e-11;

/// A random problem, its solution and an independent check.
pub struct CheckedSolution {
    number: u64,
    /// The problem.
    pub problem: RandomProblem,
    /// Prescribed load or position.
    pub control: Control,
    /// Whether the problem has a hardness.
    pub yields: bool,
    /// Iterations of the solver.
    pub iterations: usize,
    /// Reason why the solver stopped.
    pub stop_reason: SolverStop,
    /// Contact fraction.
    pub contact: f64,
    /// Fraction of the contact cells that yield.
    pub plastic: f64,
    /// Residual of the solver.
    pub claimed: Residual,
    /// Residual evaluated from the pressure by other transforms; `load` is the relative error of the prescribed quantity.
    pub found: Residual,
    /// Frank–Wolfe residual with gaps relative to the plane.
    from_plane: f64,
    /// Whether 0 ≤ p ≤ H in every cell.
    within_bounds: bool,
    /// Largest difference between the displacements and their direct sum, over the largest displacement; small grids only.
    pub from_dense: Option<f64>,
}

impl CheckedSolution {
    /// Solves problem `number` and checks the solution.
    ///
    /// # Errors
    /// The problem is invalid or the solver fails.
    pub fn new(number: u64, solver: Solver) -> Result<Self, Box<dyn Error>> {
        let random = random_problem(number)?;
        let problem = random.problem()?;
        let solution = solver.solve(&problem)?;
        let half_space = &random.half_space;
        let operator = Operator::new(half_space.grid(), half_space.modulus_pa(), half_space.boundary());
        let hardness_pa = problem.hardness_pa().unwrap_or(f64::INFINITY);
        let p: Vec<f64> = solution.pressure_pa().iter().copied().collect();
        let from_dense = (p.len() <= DENSE_UP_TO).then(|| {
            let (wanted, found) = (dense(&problem, &p), solution.displacement_m());
            let largest = wanted.iter().fold(0.0_f64, |a, b| a.max(b.abs()));
            let miss = wanted.iter().zip(found).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
            if largest > 0.0 { miss / largest } else { miss }
        });
        let contact = solution.contact_fraction();
        let evaluated = evaluate(&operator, &problem, &solution);
        let found =
            Residual { frank_wolfe: evaluated.frank_wolfe, overlap: evaluated.overlap, load: evaluated.prescribed };
        let (control, yields) = (problem.control(), problem.hardness_pa().is_some());
        let gaps = operator.displace(&p).into_iter().zip(problem.heights_m()).map(|(u, z)| u - z + solution.plane_m());
        let work: f64 = gaps.zip(&p).map(|(gap, p)| p * gap.max(0.0)).sum();
        let sum: f64 = p.iter().sum();
        Ok(Self {
            number,
            control,
            yields,
            iterations: solution.iterations(),
            stop_reason: solution.stop_reason(),
            contact,
            plastic: if contact > 0.0 { solution.plastic_fraction() / contact } else { 0.0 },
            claimed: solution.residual(),
            found,
            from_plane: if sum > 0.0 { work / (sum * problem.rms_height_m()) } else { 0.0 },
            within_bounds: p.iter().all(|p| (0.0..=hardness_pa).contains(p)),
            from_dense,
            problem: random,
        })
    }

    /// Returns the largest difference between the residuals that the solver reports and those evaluated here.
    pub fn difference(&self) -> f64 {
        let miss = |found: f64| (self.claimed.frank_wolfe - found).abs();
        let frank_wolfe = miss(self.found.frank_wolfe);
        let overlap = (self.claimed.overlap - self.found.overlap).abs();
        let load = self.found.load - self.claimed.load;
        match self.control {
            // Gaps are relative to the plane if the solver searches for it, otherwise to the smallest gap. Overlaps within
            // the tolerance enter the reported mean gap in two ways, of which the solver reports the larger error.
            Control::MeanGap { .. } => frank_wolfe.min(miss(self.from_plane)).max(overlap).max(load),
            _ => frank_wolfe.max(overlap).max(load.abs()),
        }
    }

    /// Describes a wrong answer; `None` if the answer is correct.
    pub fn failure(&self, solver: Solver) -> Option<String> {
        let found = self.found.frank_wolfe.max(self.found.overlap).max(self.found.load);
        let is_correct = self.stop_reason == SolverStop::Converged
            && self.within_bounds
            && self.claimed.worst() <= solver.tolerance
            && found <= solver.tolerance + ROUNDING
            && self.difference() <= ROUNDING
            && self.from_dense.is_none_or(|miss| miss <= ROUNDING);
        (!is_correct).then(|| {
            let Self { number, control, yields, iterations, stop_reason, claimed, found, from_dense, .. } = self;
            let (kind, half_space) = (self.problem.kind.name(), &self.problem.half_space);
            format!(
                "problem {number}, {kind}: {:?}, {:?}, {control:?}, yields {yields}: {stop_reason:?} after {iterations}, \
                 {claimed:?}, {found:?}, direct sum {from_dense:?}",
                half_space.grid(),
                half_space.boundary()
            )
        })
    }
}

/// Returns the displacements as the sum over all pairs of cells, from the kernel at every lag: Love's coefficient, or the
/// sum of all waves.
fn dense(problem: &ContactProblem<'_>, p: &[f64]) -> Vec<f64> {
    let half_space = problem.half_space();
    let (grid, modulus_pa) = (half_space.grid(), half_space.modulus_pa());
    let (nx, ny) = (grid.nx(), grid.ny());
    let kernel: Vec<f64> = match half_space.boundary() {
        Boundary::Free => (0..nx * ny)
            .map(|lag| {
                let (x_m, y_m) = ((lag % nx) as f64 * grid.dx_m(), (lag / nx) as f64 * grid.dy_m());
                love_coefficient(x_m, y_m, grid.dx_m(), grid.dy_m(), modulus_pa)
            })
            .collect(),
        Boundary::Periodic { mean_compliance_m_per_pa } => {
            let signed = |k: usize, n: usize| if 2 * k > n { k as f64 - n as f64 } else { k as f64 };
            let wave = |k: usize| {
                let q = (signed(k % nx, nx) / grid.width_m()).hypot(signed(k / nx, ny) / grid.height_m());
                if k == 0 { mean_compliance_m_per_pa } else { 2.0 / (modulus_pa * std::f64::consts::TAU * q) }
            };
            let waves: Vec<f64> = (0..nx * ny).map(wave).collect();
            let at = |lag: usize| {
                let phase =
                    |k: usize| (k % nx * (lag % nx)) as f64 / nx as f64 + (k / nx * (lag / nx)) as f64 / ny as f64;
                let sum: f64 = (0..nx * ny).map(|k| waves[k] * (std::f64::consts::TAU * phase(k)).cos()).sum();
                sum / (nx * ny) as f64
            };
            (0..nx * ny).map(at).collect()
        }
    };
    // Both kernels are even in x and in y.
    let lag = |i: usize, j: usize| (i / nx).abs_diff(j / nx) * nx + (i % nx).abs_diff(j % nx);
    (0..nx * ny).map(|i| (0..nx * ny).map(|j| kernel[lag(i, j)] * p[j]).sum()).collect()
}
