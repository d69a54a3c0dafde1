//! Tables of how solutions depend on tolerance and grid, and of how residuals fall.

use asperity::contact::{Boundary, ContactProblem, Control, HalfSpace, Solution, Solver, SolverStop};
use asperity::map::Grid;
use asperity_validation::contact::rough;
use ndarray::Array2;

use crate::Result;

/// Mean pressures over E* h′ for about 1, 11 and 57 % of contact.
const LOADS: [f64; 3] = [0.004, 0.047, 0.335];
/// Hardness over E* h′.
const HARDNESS: f64 = 0.6;
/// Shortest wave of the surface in the comparison of grids, in cycles per side.
const CYCLES: f64 = 32.0;
/// Points per side at which this surface is generated.
const FINEST: usize = 1024;
/// Largest number of iterations of a history.
const MOST_ITERATIONS: usize = 100;

/// Load on a surface of unit side, modulus and rms gradient, so that pressures are relative to E* h′.
#[derive(Debug, Clone, Copy)]
struct State {
    load: f64,
    hardness: Option<f64>,
}

const STATES: [State; 6] = [
    State { load: LOADS[0], hardness: None },
    State { load: LOADS[1], hardness: None },
    State { load: LOADS[2], hardness: None },
    State { load: LOADS[0], hardness: Some(HARDNESS) },
    State { load: LOADS[1], hardness: Some(HARDNESS) },
    State { load: LOADS[2], hardness: Some(HARDNESS) },
];

impl State {
    fn solve(self, heights: &Array2<f64>, solver: Solver) -> Result<Solution> {
        let grid = Grid::with_size(heights.ncols(), heights.nrows(), 1.0, 1.0)?;
        let half_space = HalfSpace::new(grid, 1.0, Boundary::Periodic { mean_compliance_m_per_pa: 0.0 })?;
        let control = Control::MeanPressure { pascal: self.load };
        Ok(solver.solve(&ContactProblem::new(&half_space, heights, control, self.hardness)?)?)
    }

    fn name(self, contact: f64) -> String {
        let body = if self.hardness.is_some() { "H = 0.6 E\\*h′" } else { "elastic" };
        format!("{:.1} %, {body}", 100.0 * contact)
    }

    /// Returns μ of the corrected contact area in units of τ/(E*h′), at least that of fully plastic contact.
    fn friction(self, solution: &Solution) -> f64 {
        let least = self.hardness.map_or(0.0, |hardness| self.load / hardness);
        solution.corrected_contact_fraction().max(least) / self.load
    }
}

fn to(tolerance: f64) -> Solver {
    Solver { tolerance, max_iterations: 2000 }
}

/// Formats a value with one digit, and zero as `0`.
pub(crate) fn short(value: f64) -> String {
    if value == 0.0 { "0".into() } else { format!("{value:.0e}") }
}

/// Returns the mean of ½pu − pz.
fn energy(solution: &Solution, heights: &Array2<f64>) -> f64 {
    let fields = solution.pressure_pa().iter().zip(solution.displacement_m()).zip(heights);
    fields.map(|((p, u), z)| p * (0.5 * u - z)).sum::<f64>() / heights.len() as f64
}

/// Returns the section on tolerances.
pub(crate) fn tolerances() -> Result<String> {
    let heights = rough(FINEST, CYCLES, FINEST / 256)?;
    let rms = (heights.mapv(|z| z * z).sum() / heights.len() as f64).sqrt();
    let ladder: Vec<i32> = (2..=10).collect();
    let mut text = "## Tolerance

A periodic surface, self-affine with H = 0.8 from a quarter to 1/32 of its side and flat beyond, on 256 × 256 cells (8 to the shortest
wave), under a prescribed mean pressure. Errors are relative to the solution at the tolerance 1e-12. Since the load is met exactly, μ = τ A_c/N and
the corrected contact area A_c have the same error. *Energy* is the error of the energy over its bound, N times the Frank–Wolfe
residual times h_rms.
"
    .to_owned();
    let mut summary = vec![Vec::new(); ladder.len()];
    let mut names = Vec::new();
    for (place, state) in STATES.into_iter().enumerate() {
        let exact = state.solve(&heights, to(1e-12))?;
        let relative =
            |part: &dyn Fn(&Solution) -> f64, solution: &Solution| (part(solution) / part(&exact) - 1.0).abs();
        names.push(state.name(exact.contact_fraction()));
        let detailed = place == 1;
        if detailed {
            text += &format!(
                "\n**Contact {}**, {:.2} % corrected, μ = {:.4} τ/(E\\*h′):\n\n| tolerance | iterations | Frank–Wolfe | overlap | contact, counted | corrected, and μ | largest pressure | separation | energy |\n|---|---:|---:|---:|---:|---:|---:|---:|---:|\n",
                names[place],
                100.0 * exact.corrected_contact_fraction(),
                state.friction(&exact),
            );
        }
        for (row, digits) in ladder.iter().enumerate() {
            let solution = state.solve(&heights, to(10.0_f64.powi(-digits)))?;
            let friction = relative(&|s| state.friction(s), &solution);
            let friction = short(friction);
            summary[row].push(format!("{} | {friction}", solution.iterations()));
            if detailed {
                let residual = solution.residual();
                let (energy_now, least) = (energy(&solution, &heights), energy(&exact, &heights));
                let (error, allowed) = (energy_now - least, state.load * residual.frank_wolfe * rms);
                // The energies themselves are rounded.
                let is_known = error > 1e-14 * least.abs();
                text += &format!(
                    "| 1e-{digits} | {} | {:.0e} | {:.0e} | {} | {friction} | {:.0e} | {:.0e} | {} |\n",
                    solution.iterations(),
                    residual.frank_wolfe,
                    residual.overlap,
                    short(relative(&Solution::contact_fraction, &solution)),
                    relative(&Solution::max_pressure_pa, &solution),
                    relative(&Solution::separation_m, &solution),
                    if is_known { short(error / allowed) } else { "rounding".into() },
                );
            }
        }
    }
    text += &format!(
        "\nIterations and relative error of μ at other loads, without and with a hardness:\n\n| tolerance | {} | |\n|---|{}\n",
        names.join(" | | "),
        "---:|---:|".repeat(names.len())
    );
    for (digits, cells) in ladder.iter().zip(summary) {
        text += &format!("| 1e-{digits} | {} |\n", cells.join(" | "));
    }
    Ok(text)
}

/// Returns the section on grids.
pub(crate) fn grids() -> Result<String> {
    let mut text = "## Grid

The same surface on other grids: the same function at more or fewer points. The contact is in percent, by counting cells and corrected
for the perimeter; μ is in units of τ/(E\\*h′).

| cells | per shortest wave | load over E\\*h′ | hardness | contact, counted | corrected | μ | against 1024² | counted, against 1024² corrected |
|---:|---:|---:|---|---:|---:|---:|---:|---:|
"
    .to_owned();
    for state in STATES {
        let mut rows = Vec::new();
        for stride in [8, 4, 2, 1] {
            let heights = rough(FINEST, CYCLES, stride)?;
            let solution = state.solve(&heights, Solver::default())?;
            rows.push((
                heights.nrows(),
                solution.contact_fraction(),
                solution.corrected_contact_fraction(),
                state.friction(&solution),
            ));
        }
        let [.., (_, _, finest, finest_friction)] = rows[..] else { continue };
        for (cells, counted, corrected, friction) in rows {
            let hardness = state.hardness.map_or("none".into(), |hardness| format!("{hardness} E\\*h′"));
            text += &format!(
                "| {cells}² | {:.0} | {} | {hardness} | {:.3} | {:.3} | {friction:.4} | {:+.1} % | {:+.1} % |\n",
                cells as f64 / CYCLES,
                state.load,
                100.0 * counted,
                100.0 * corrected,
                100.0 * (friction / finest_friction - 1.0),
                100.0 * (counted / finest - 1.0),
            );
        }
    }
    Ok(text)
}

/// Residuals of a solve after each iteration.
#[derive(Debug)]
pub(crate) struct History {
    pub(crate) cells: usize,
    pub(crate) load: usize,
    pub(crate) yields: bool,
    pub(crate) contact: f64,
    plastic: f64,
    pub(crate) residuals: Vec<f64>,
}

/// Solves each state again with one more iteration each time, down to a residual of 1e-12.
pub(crate) fn histories() -> Result<Vec<History>> {
    let mut histories = Vec::new();
    for (cells, heights) in [(256, rough(FINEST, CYCLES, FINEST / 256)?), (512, rough(512, 64.0, 1)?)] {
        for (place, state) in STATES.into_iter().enumerate() {
            let mut residuals = Vec::new();
            let last = loop {
                let solution = state.solve(&heights, Solver { tolerance: 1e-12, max_iterations: residuals.len() })?;
                residuals.push(solution.residual().worst());
                if solution.stop_reason() != SolverStop::IterationLimit || residuals.len() > MOST_ITERATIONS {
                    break solution;
                }
            };
            eprintln!(
                "{cells}², {state:?}: {:?} after {}, {:?}",
                last.stop_reason(),
                last.iterations(),
                last.residual()
            );
            let (load, yields) = (place % LOADS.len(), state.hardness.is_some());
            let (contact, plastic) = (last.contact_fraction(), last.plastic_fraction() / last.contact_fraction());
            histories.push(History { cells, load, yields, contact, plastic, residuals });
        }
    }
    Ok(histories)
}

/// Returns the section on convergence.
pub(crate) fn convergence(histories: &[History]) -> String {
    let mut text = "## Convergence

![Largest residual against iterations](../figures/contact_convergence.svg)

Periodic surfaces with eight cells to the shortest wave under a mean pressure, from a cold start. An iteration applies the operator once.
The table states the iterations until the largest residual is below a value; the residual is evaluated anew after each iteration.

| cells | contact | plastic | 1e-2 | 1e-4 | 1e-6 | 1e-8 | 1e-10 | 1e-12 |
|---:|---:|---:|---:|---:|---:|---:|---:|---:|
"
    .to_owned();
    for History { cells, contact, plastic, residuals, .. } in histories {
        let reached = |digits: i32| {
            let place = residuals.iter().position(|r| *r <= 10.0_f64.powi(-digits));
            place.map_or("–".to_owned(), |place| place.to_string())
        };
        let counts: Vec<String> = [2, 4, 6, 8, 10, 12].map(reached).into();
        text +=
            &format!("| {cells}² | {:.1} % | {:.0} % | {} |\n", 100.0 * contact, 100.0 * plastic, counts.join(" | "));
    }
    text + "\n*Plastic* is the percentage of the contact at the hardness of 0.6 E\\*h′; 0 is elastic.\n"
}
