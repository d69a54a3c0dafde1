//! Contact of a rough surface with a rigid flat.

use asperity::choice::Choice;
use asperity::contact::{
    Base, Boundary, ContactNumbers, ContactProblem, ContactStiffness, Control, Elastic, ElasticPair, HalfSpace, Layer,
    Neighbours, Orientation, Solution, Solver, SolverStop, StiffnessSolver, Substrate, composite, memory_bytes,
};
use asperity::map::{BoundaryKind, Grid, HeightMap};
use numpy::{PyArray2, PyReadonlyArray2};
use pyo3::prelude::*;
use pyo3::types::PyDict;
use serde::Deserialize;

use crate::convert::{from_python, owned, to_python};
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
    counterface_as_laid: bool,
    counterface_youngs_modulus_pa: Option<f64>,
    counterface_poisson_ratio: Option<f64>,
    layer_thickness_m: Option<f64>,
    base_youngs_modulus_pa: Option<f64>,
    base_poisson_ratio: Option<f64>,
    boundary: String,
    mean_compliance_m_per_pa: Option<f64>,
    penetration_m: Option<f64>,
    percentile: Option<f64>,
    mean_pressure_pa: Option<f64>,
    load_n: Option<f64>,
    mean_gap_m: Option<f64>,
    hardness_pa: Option<f64>,
    stiffness: bool,
    tolerance: Option<f64>,
}

/// Returns the material of a body, rigid without a modulus.
fn elastic(youngs_modulus_pa: Option<f64>, poisson_ratio: Option<f64>, body: &str) -> PyResult<Option<Elastic>> {
    match (youngs_modulus_pa, poisson_ratio) {
        (None, None) => Ok(None),
        (None, Some(_)) => {
            Err(value_error(format_args!("{body}poisson_ratio is given without {body}youngs_modulus_pa")))
        }
        (Some(modulus_pa), ratio) => {
            Elastic::new(modulus_pa, ratio.unwrap_or(Elastic::POISSON_RATIO)).raise().map(Some)
        }
    }
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
        let counterface = elastic(self.counterface_youngs_modulus_pa, self.counterface_poisson_ratio, "counterface_")?;
        let base = elastic(self.base_youngs_modulus_pa, self.base_poisson_ratio, "base_")?;
        let surface = match (self.modulus_pa, elastic(self.youngs_modulus_pa, self.poisson_ratio, "")?) {
            (Some(modulus_pa), None) if counterface.is_none() && base.is_none() && self.layer_thickness_m.is_none() => {
                return Ok(Substrate::HalfSpace { modulus_pa });
            }
            (None, Some(surface)) => surface,
            _ => {
                return Err(value_error(
                    "state either modulus_pa, or youngs_modulus_pa with poisson_ratio; a layer and an elastic counterface need \
                     the latter",
                ));
            }
        };
        match (self.layer_thickness_m, counterface) {
            (Some(_), Some(_)) => Err(value_error("a layer is pressed against a rigid counterface")),
            (Some(thickness_m), None) => {
                let base = base.map_or(Base::Rigid, Base::Elastic);
                Ok(Substrate::Layer(Layer { thickness_m, material: surface, base }))
            }
            (None, _) if base.is_some() => Err(value_error("a base needs a layer: state layer_thickness_m")),
            (None, own) => {
                let pair = ElasticPair::new(surface, own.unwrap_or(Elastic::RIGID)).raise()?;
                Ok(Substrate::HalfSpace { modulus_pa: pair.contact_modulus_pa() })
            }
        }
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

/// Solves a contact problem, with a rough counterface and from the pressure `start_pa` if they are given. Returns fields
/// and numbers, with the keys of `asperity contact --json`.
#[pyfunction]
#[pyo3(signature = (heights_m, dx_m, dy_m, settings, counterface_m, start_pa))]
pub(crate) fn solve_contact<'py>(
    py: Python<'py>,
    heights_m: PyReadonlyArray2<'py, f64>,
    dx_m: f64,
    dy_m: f64,
    settings: &Bound<'py, PyDict>,
    counterface_m: Option<PyReadonlyArray2<'py, f64>>,
    start_pa: Option<PyReadonlyArray2<'py, f64>>,
) -> PyResult<Bound<'py, PyAny>> {
    let settings: Settings = from_python(settings)?;
    let (control, substrate) = (settings.control()?, settings.substrate()?);
    let (ny, nx) = heights_m.as_array().dim();
    let grid = Grid::new(nx, ny, dx_m, dy_m).raise()?;
    require_memory(
        memory_bytes(grid.points(), BoundaryKind::from_name(&settings.boundary).raise()?),
        "the contact problem",
    )?;
    let (heights_m, start_pa) = (owned(&heights_m), start_pa.as_ref().map(owned));
    let heights_m = match &counterface_m {
        None => heights_m,
        Some(counterface_m) => {
            let map = |heights_m| HeightMap::measured(grid, heights_m).raise();
            let laid = if settings.counterface_as_laid { Orientation::Aligned } else { Orientation::Mirrored };
            composite(&map(heights_m)?, &map(owned(counterface_m))?, laid).raise()?.into_heights_m()
        }
    };
    let boundary = settings.boundary(grid, &substrate, control)?;
    let mut solver = Solver::default();
    if let Some(tolerance) = settings.tolerance {
        solver.tolerance = tolerance;
    }
    // All of it without the interpreter lock.
    let (numbers, labels, fields) = long::run_sized(py, grid.points(), move |monitor| {
        let half_space = HalfSpace::with_substrate(substrate, grid, boundary).raise()?;
        let problem = ContactProblem::new(&half_space, &heights_m, control, settings.hardness_pa).raise()?;
        let solution = solver.solve_from(&problem, start_pa.as_ref(), &mut half_space.workspace(), monitor).raise()?;
        require_convergence(&solution, solver.tolerance)?;
        let clusters = solution.clusters(Neighbours::Edges);
        let stiffness = settings.stiffness.then(|| stiffness(&half_space, &solution)).transpose()?;
        let numbers = ContactNumbers::new(&problem, &solution, &clusters, stiffness);
        drop((half_space, heights_m));
        let (gap_m, plastic_displacement_m) = (solution.gap_m(), solution.plastic_displacement_m());
        let (pressure_pa, displacement_m) = solution.into_fields();
        let fields = [
            ("gap_m", gap_m),
            ("plastic_displacement_m", plastic_displacement_m),
            ("pressure_pa", pressure_pa),
            ("displacement_m", displacement_m),
        ];
        Ok((numbers, clusters.into_labels(), fields))
    })?;
    let answer = to_python(py, &numbers)?;
    answer.set_item("cluster_labels", PyArray2::from_owned_array(py, labels))?;
    for (name, field) in fields {
        answer.set_item(name, PyArray2::from_owned_array(py, field))?;
    }
    Ok(answer)
}

/// Returns the contact stiffness. Fails if it does not converge.
fn stiffness(half_space: &HalfSpace, solution: &Solution) -> PyResult<ContactStiffness> {
    let found = StiffnessSolver::default().solve(half_space, solution).raise()?;
    if found.converged {
        return Ok(found);
    }
    Err(NotConvergedError::new_err(format!(
        "the contact stiffness did not converge in {} iterations: residual {:.1e}",
        found.iterations, found.residual
    )))
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
