//! Contact of a rough surface with a rigid flat.

use asperity::choice::Choice;
use asperity::contact::{
    Boundary, ContactProblem, Control, Elastic, HalfSpace, Solution, Solver, SolverStop, Substrate, memory_bytes,
};
use asperity::map::{BoundaryKind, Grid};
use numpy::{PyArray2, PyReadonlyArray2};
use pyo3::prelude::*;
use pyo3::types::PyDict;
use serde::Deserialize;

use crate::convert::{from_python, owned};
use crate::errors::{NotConvergedError, Raise, value_error};
use crate::long;
use crate::resources::require_memory;

/// Settings of a contact problem.
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct Settings {
    modulus_pa: Option<f64>,
    youngs_modulus_pa: Option<f64>,
    poisson_ratio: Option<f64>,
    boundary: String,
    mean_compliance_m_per_pa: Option<f64>,
    penetration_m: Option<f64>,
    percentile: Option<f64>,
    mean_pressure_pa: Option<f64>,
    load_n: Option<f64>,
    mean_gap_m: Option<f64>,
    hardness_pa: Option<f64>,
    tolerance: Option<f64>,
}

impl Settings {
    fn control(&self) -> PyResult<Control> {
        let given = [
            self.penetration_m.map(|metre| Control::Penetration { metre }),
            self.percentile.map(|percent| Control::Percentile { percent }),
            self.mean_pressure_pa.map(|pascal| Control::MeanPressure { pascal }),
            self.load_n.map(|newton| Control::Load { newton }),
            self.mean_gap_m.map(|metre| Control::MeanGap { metre }),
        ];
        match given.into_iter().flatten().collect::<Vec<_>>()[..] {
            [control] => Ok(control),
            _ => Err(value_error(
                "state exactly one of penetration_m, percentile, mean_pressure_pa, load_n and mean_gap_m",
            )),
        }
    }

    fn substrate(&self) -> PyResult<Substrate> {
        let modulus_pa = match (self.modulus_pa, self.youngs_modulus_pa, self.poisson_ratio) {
            (Some(modulus_pa), None, None) => modulus_pa,
            (None, Some(youngs_modulus_pa), ratio) => {
                let ratio = ratio.unwrap_or(Elastic::POISSON_RATIO);
                Elastic::new(youngs_modulus_pa, ratio).raise()?.contact_modulus_pa()
            }
            _ => return Err(value_error("state either modulus_pa, or youngs_modulus_pa with poisson_ratio")),
        };
        Ok(Substrate::HalfSpace { modulus_pa })
    }

    /// Returns the boundary, with the usual mean compliance of a periodic one where it matters.
    fn boundary(&self, grid: Grid, substrate: &Substrate, control: Control) -> PyResult<Boundary> {
        match (BoundaryKind::from_name(&self.boundary).raise()?, self.mean_compliance_m_per_pa) {
            (BoundaryKind::Free, None) => Ok(Boundary::Free),
            (BoundaryKind::Free, Some(_)) => {
                Err(value_error("mean_compliance_m_per_pa requires boundary=\"periodic\"; a free surface has its own"))
            }
            (BoundaryKind::Periodic, given) => Ok(substrate.periodic(grid, control, given)),
        }
    }
}

/// Solves a contact problem, from the pressure `start_pa` if it is given. Returns fields and numbers, with the keys of
/// `asperity contact --json`.
#[pyfunction]
#[pyo3(signature = (heights_m, dx_m, dy_m, settings, start_pa))]
pub(crate) fn solve_contact<'py>(
    py: Python<'py>,
    heights_m: PyReadonlyArray2<'py, f64>,
    dx_m: f64,
    dy_m: f64,
    settings: &Bound<'py, PyDict>,
    start_pa: Option<PyReadonlyArray2<'py, f64>>,
) -> PyResult<Bound<'py, PyDict>> {
    let settings: Settings = from_python(settings)?;
    let (control, substrate) = (settings.control()?, settings.substrate()?);
    let (ny, nx) = heights_m.as_array().dim();
    let grid = Grid::new(nx, ny, dx_m, dy_m).raise()?;
    require_memory(
        memory_bytes(grid.points(), BoundaryKind::from_name(&settings.boundary).raise()?),
        "the contact problem",
    )?;
    let (heights_m, start_pa) = (owned(&heights_m), start_pa.as_ref().map(owned));
    let boundary = settings.boundary(grid, &substrate, control)?;
    let mut solver = Solver::default();
    if let Some(tolerance) = settings.tolerance {
        solver.tolerance = tolerance;
    }
    // All of it without the interpreter lock.
    let (numbers, iterations, fields) = long::run_sized(py, grid.points(), move |monitor| {
        let half_space = HalfSpace::with_substrate(substrate, grid, boundary).raise()?;
        let problem = ContactProblem::new(&half_space, &heights_m, control, settings.hardness_pa).raise()?;
        let solution = solver.solve_from(&problem, start_pa.as_ref(), &mut half_space.workspace(), monitor).raise()?;
        require_convergence(&solution, solver.tolerance)?;
        drop((half_space, heights_m));
        let (numbers, iterations) = (numbers(&solution), solution.iterations());
        let (gap_m, plastic_displacement_m) = (solution.gap_m(), solution.plastic_displacement_m());
        let (pressure_pa, displacement_m) = solution.into_fields();
        let fields = [
            ("gap_m", gap_m),
            ("plastic_displacement_m", plastic_displacement_m),
            ("pressure_pa", pressure_pa),
            ("displacement_m", displacement_m),
        ];
        Ok((numbers, iterations, fields))
    })?;
    let answer = PyDict::new(py);
    for (name, value) in numbers {
        answer.set_item(name, value)?;
    }
    let mean_compliance_m_per_pa = match boundary {
        Boundary::Free => None,
        Boundary::Periodic { mean_compliance_m_per_pa } => Some(mean_compliance_m_per_pa),
    };
    answer.set_item("mean_compliance_m_per_pa", mean_compliance_m_per_pa)?;
    answer.set_item("iterations", iterations)?;
    for (name, field) in fields {
        answer.set_item(name, PyArray2::from_owned_array(py, field))?;
    }
    Ok(answer)
}

/// Fails if a solution misses the tolerance.
fn require_convergence(solution: &Solution, tolerance: f64) -> PyResult<()> {
    if solution.converged() {
        return Ok(());
    }
    let why = match solution.stop_reason() {
        SolverStop::PrecisionLimit => "limit of double precision",
        SolverStop::IterationLimit => "iteration limit",
        SolverStop::Converged | SolverStop::Cancelled => "cancelled",
    };
    Err(NotConvergedError::new_err(format!(
        "not converged after {} iterations ({why}): residual {:.1e}, tolerance {tolerance:.1e}",
        solution.iterations(),
        solution.residual().worst(),
    )))
}

/// Returns the numbers of a solution by name.
fn numbers(solution: &Solution) -> [(&'static str, Option<f64>); 10] {
    [
        ("contact_fraction", Some(solution.contact_fraction())),
        ("contact_fraction_corrected", solution.corrected_contact_fraction().into()),
        ("plastic_fraction", Some(solution.plastic_fraction())),
        ("mean_pressure_pa", Some(solution.mean_pressure_pa())),
        ("load_n", Some(solution.load_n())),
        ("max_pressure_pa", Some(solution.max_pressure_pa())),
        ("mean_gap_m", Some(solution.mean_gap_m())),
        ("separation_m", Some(solution.separation_m())),
        ("penetration_m", Some(solution.penetration_m())),
        ("residual", Some(solution.residual().worst())),
    ]
}
