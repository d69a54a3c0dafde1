//! Contact of a map with a rigid flat.

use asperity::choice::ByName;
use asperity::contact::{
    Boundary, ContactProblem, Control, Elastic, HalfSpace, Solution, Solver, SolverStop, Substrate,
};
use asperity::map::{BoundaryKind, Grid, HeightMap};
use asperity::random;
use asperity::study::Field;
use asperity::surface::{FillOptions, Filling, RandomSurface};
use asperity_report::live;
use ndarray::s;
use serde::Deserialize;
use serde_json::json;

use super::{Origin, Surface, with_size};
use crate::answer::{Answer, Failure, read};
use crate::monitor::Progress;

/// Largest number of points along a side of a pressed map.
const PRESSED_POINTS: usize = 256;

/// Elastic body, hardness, and the prescribed position or load: exactly one of `penetration_m` and `mean_pressure_pa`.
#[derive(Debug, Clone, Copy, Deserialize)]
pub(super) struct Press {
    youngs_modulus_pa: f64,
    poisson_ratio: f64,
    pub(super) hardness_pa: Option<f64>,
    penetration_m: Option<f64>,
    mean_pressure_pa: Option<f64>,
}

impl Press {
    fn substrate(&self) -> Result<Substrate, Failure> {
        let modulus_pa = Elastic::new(self.youngs_modulus_pa, self.poisson_ratio)?.contact_modulus_pa();
        Ok(Substrate::HalfSpace { modulus_pa })
    }

    pub(super) fn control(&self) -> Result<Control, Failure> {
        match (self.penetration_m, self.mean_pressure_pa) {
            (Some(metre), None) => Ok(Control::Penetration { metre }),
            (None, Some(pascal)) => Ok(Control::MeanPressure { pascal }),
            _ => Err(Failure("state either penetration_m or mean_pressure_pa".into())),
        }
    }

    pub(super) fn half_space(&self, grid: Grid, boundary: BoundaryKind) -> Result<HalfSpace, Failure> {
        let (substrate, control) = (self.substrate()?, self.control()?);
        let boundary = match boundary {
            BoundaryKind::Free => Boundary::Free,
            BoundaryKind::Periodic => substrate.periodic(grid, control, None),
        };
        Ok(HalfSpace::with_substrate(substrate, grid, boundary)?)
    }
}

/// Request for a contact solution.
#[derive(Debug, Deserialize)]
struct Request {
    boundary: ByName<BoundaryKind>,
    tolerance: Option<f64>,
    #[serde(flatten)]
    press: Press,
}

impl Surface {
    /// Solves the contact of the map.
    pub(super) fn pressed(&self, request: &str) -> Result<Answer, Failure> {
        let Request { boundary: ByName(boundary), tolerance, press } = read(request)?;
        let (map, filled) = self.complete_part()?;
        let half_space = press.half_space(map.grid(), boundary)?;
        let problem = ContactProblem::new(&half_space, map.heights_m(), press.control()?, press.hardness_pa)?;
        let mut solver = Solver::default();
        solver.tolerance = tolerance.unwrap_or(solver.tolerance);
        let solution = solver.solve_from(&problem, None, &mut half_space.workspace(), &Progress)?;
        require_convergence(&solution, solver.tolerance)?;
        let numbers = json!({
            "whole": map.grid() == self.map.grid(),
            "filled_points": filled,
            "contact_fraction": solution.contact_fraction(),
            "contact_fraction_corrected": solution.corrected_contact_fraction(),
            "plastic_fraction": solution.plastic_fraction(),
            "mean_pressure_pa": solution.mean_pressure_pa(),
            "mean_gap_m": solution.mean_gap_m(),
            "penetration_m": solution.penetration_m(),
            "tolerance": solver.tolerance,
        });
        let mut numbers = with_size(map.grid(), numbers);
        let pitch_m = [map.grid().dx_m(), map.grid().dy_m()];
        numbers["svg"] = live::pressure(&Field::new(pitch_m, "Pa", solution.into_fields().0))?.into();
        Answer::new(&numbers)
    }

    /// Returns the central part of the map without missing heights, and how many were filled in; fills them at the first call.
    fn complete_part(&self) -> Result<&(HeightMap, usize), Failure> {
        if let Some(part) = self.pressed.get() {
            return Ok(part);
        }
        let part = central(&self.map, PRESSED_POINTS)?;
        let complete = match &self.origin {
            Origin::Scan { settings, .. } if part.missing_points() > 0 => {
                let options = FillOptions { level: settings.level, ..FillOptions::default() };
                let filling = Filling::new(&part, options, &Progress)?;
                let mut stream = random::stream(self.seed, "fill", 0);
                (filling.generate(&random::standard_normal(&mut stream, filling.xi_len())), filling.filled_points())
            }
            _ => (part, 0),
        };
        Ok(self.pressed.get_or_init(|| complete))
    }
}

/// Returns the central part of a map with at most `points` points along a side.
fn central(map: &HeightMap, points: usize) -> Result<HeightMap, Failure> {
    let (grid, (ny, nx)) = (map.grid(), map.grid().shape());
    let (rows, columns) = (ny.min(points), nx.min(points));
    let (top, left) = ((ny - rows) / 2, (nx - columns) / 2);
    let part = map.heights_m().slice(s![top..top + rows, left..left + columns]).to_owned();
    Ok(HeightMap::new(Grid::new(columns, rows, grid.dx_m(), grid.dy_m())?, part)?)
}

fn require_convergence(solution: &Solution, tolerance: f64) -> Result<(), Failure> {
    if solution.converged() {
        return Ok(());
    }
    let why = match solution.stop_reason() {
        SolverStop::PrecisionLimit => "limit of double precision",
        _ => "iteration limit",
    };
    Err(Failure(format!(
        "not converged after {} iterations ({why}): residual {:.1e}, tolerance {tolerance:.1e}",
        solution.iterations(),
        solution.residual().worst(),
    )))
}
