//! The law of the random pressure on a patch.

mod entries;
mod indices;
mod maps;
mod tables;

use crate::contact::{self, Boundary, Control, HalfSpace, Solver};
use crate::law::Marginal;
use crate::map::BoundaryKind;
use crate::map::Grid;
use crate::monitor::Monitor;
use crate::pressure::{Problem, Study as Sizes};
use crate::random;
use crate::study::config::{MaterialSection, PressureSection};
use crate::study::output::StageOutput;
use crate::study::result::PressureResult;
use crate::study::{Field, StudyError, sentence};
use crate::surface::RandomSurface;
use crate::surface::model::Generated;
use entries::Posed;

/// Bias over the mean pressure of a method from which it is warned.
const LARGE_BIAS: f64 = 0.25;

/// The half-space of a section, and its mean compliance where it is periodic.
pub(super) fn half_space(
    section: &'static str,
    grid: Grid,
    material: &MaterialSection,
    boundary: BoundaryKind,
    mean_compliance_m_per_pa: Option<f64>,
) -> Result<(HalfSpace, Option<f64>), StudyError> {
    let modulus_pa = contact::contact_modulus_pa(material.youngs_modulus.0, material.poisson_ratio);
    let (boundary, compliance) = match boundary {
        BoundaryKind::Free => (Boundary::Free, None),
        BoundaryKind::Periodic => {
            let usual = HalfSpace::default_mean_compliance_m_per_pa(grid, modulus_pa);
            let mean_compliance_m_per_pa = mean_compliance_m_per_pa.unwrap_or(usual);
            (Boundary::Periodic { mean_compliance_m_per_pa }, Some(mean_compliance_m_per_pa))
        }
    };
    let half_space =
        HalfSpace::new(grid, modulus_pa, boundary).map_err(|error| StudyError::Contact { section, error })?;
    Ok((half_space, compliance))
}

/// The plane that `percent` of the ensemble's heights exceed.
pub(super) fn plane(marginal: &Marginal, percent: f64) -> Control {
    Control::Plane { height_m: marginal.quantile(1.0 - percent / 100.0) }
}

/// What the pressure stage hands on.
pub(super) struct PressureStage {
    pub(super) result: PressureResult,
    pub(super) output: StageOutput,
}

pub(super) fn run(
    section: &PressureSection,
    material: &MaterialSection,
    marginal: &Marginal,
    generated: &Generated,
    seed: u64,
    monitor: &dyn Monitor,
) -> Result<PressureStage, StudyError> {
    let surface = generated.surface.as_ref();
    let grid = surface.grid();
    let compliance = section.mean_compliance.map(|c| c.0);
    let (half_space, mean_compliance_m_per_pa) = half_space("pressure", grid, material, section.boundary, compliance)?;
    let control = match (section.percentile, section.penetration, section.mean_pressure) {
        // Heights that truncation leaves lower have a lower plane.
        (Some(percent), _, _) => match plane(marginal, percent) {
            Control::Plane { height_m } => Control::Plane { height_m: generated.std_share * height_m },
            control => control,
        },
        (_, Some(depth), _) => Control::Penetration { metre: depth.0 },
        (_, _, Some(pressure)) => Control::MeanPressure { pascal: pressure.0 },
        _ => return Err(StudyError::NoStage("pressure")),
    };
    let hardness_pa = material.hardness.map(|h| h.0);
    let solver = Solver { tolerance: section.tolerance, ..Solver::default() };
    let [row, column] = section.cell.unwrap_or([grid.ny() / 2, grid.nx() / 2]);
    let problem = Problem::new(surface, &half_space, control, hardness_pa)?.at_cell(row, column)?.with_solver(solver);
    let sizes = Sizes {
        fine_solves: section.fine_solves,
        reference_samples: section.reference_samples,
        variables: section.variables.min(surface.xi_len()),
        degree: section.degree,
        stiffness: section.stiffness,
        ..Sizes::new(seed)
    };
    let results = sizes.run(&problem, monitor)?;
    let separation_m = match control {
        Control::Plane { height_m } => Some(height_m),
        _ => None,
    };
    let mut warnings = generated.warnings.clone();
    let patch =
        [patch_sentence(section, (row, column), &half_space, hardness_pa), expansion_sentence(section, surface)];
    for method in &results.methods {
        if let Err(reason) = &method.outcome {
            warnings.push(format!("pressure method {} has no estimate: {reason}", method.method.name()));
        }
        let estimate = method.outcome.as_ref().ok().map(|(estimate, _)| estimate);
        let bias = estimate.and_then(|found| found.mean_bias_pa.map(|bias_pa| (found.mean_pa, bias_pa)));
        if let Some((mean_pa, bias_pa)) = bias.filter(|(mean_pa, bias_pa)| bias_pa.abs() > LARGE_BIAS * mean_pa) {
            warnings.push(format!(
                "pressure method {} is biased: samples that it was not fitted to move its mean from {} to {}; its intervals are corrected, \
                 its other numbers are not",
                method.method.name(),
                sentence::si(mean_pa, "Pa"),
                sentence::si(mean_pa - bias_pa, "Pa"),
            ));
        }
    }
    let posed = Posed { cell: (row, column), mean_compliance_m_per_pa, separation_m };
    let result = entries::summary(&results, &posed);
    let mut fields = sample_fields(surface, &half_space, control, hardness_pa, solver, seed)?;
    fields.extend(results.fields.iter().flat_map(maps::fields));
    Ok(PressureStage {
        output: StageOutput {
            tables: tables::tables(&results, &result),
            fields,
            assumptions: patch.into_iter().chain(generated.correction.clone()).collect(),
            warnings,
        },
        result,
    })
}

fn patch_sentence(
    section: &PressureSection,
    (row, column): (usize, usize),
    half_space: &HalfSpace,
    hardness_pa: Option<f64>,
) -> String {
    let boundary = match half_space.boundary() {
        Boundary::Free => "a finite patch on an unloaded half-space".to_owned(),
        Boundary::Periodic { mean_compliance_m_per_pa } => {
            format!("a periodic patch of mean compliance {}", sentence::compliance(mean_compliance_m_per_pa))
        }
    };
    let control = match (section.percentile, section.penetration, section.mean_pressure) {
        (Some(percent), _, _) => {
            format!("a rigid plane fixed in space that {percent} % of the ensemble's heights exceed before deformation")
        }
        (_, Some(depth), _) => {
            format!("a rigid plane {} below the highest point of each patch", sentence::si(depth.0, "m"))
        }
        (_, _, pressure) => {
            let shown = pressure.map_or_else(String::new, |p| sentence::si(p.0, "Pa"));
            format!("a rigid plane under the mean pressure {shown}")
        }
    };
    let grid = half_space.grid();
    let centre = if (row, column) == (grid.ny() / 2, grid.nx() / 2) { "centre " } else { "" };
    format!(
        "The pressure is that of the {centre}cell [{row}, {column}] of {boundary}, {} × {} cells on {}, E* = {}, {}, pressed by \
         {control}.",
        grid.nx(),
        grid.ny(),
        sentence::size(grid.width_m(), grid.height_m()),
        sentence::si(half_space.modulus_pa(), "Pa"),
        hardness_pa.map_or_else(|| "elastic".into(), |h| format!("capped at the hardness {}", sentence::si(h, "Pa"))),
    )
}

fn expansion_sentence(section: &PressureSection, surface: &dyn RandomSurface) -> String {
    let germ = surface.xi_len();
    let variables = section.variables.min(germ);
    format!(
        "The paper’s chaos expansions, eq. (8) and (9), use the {variables} leading of {germ} variables at total degree {}.",
        section.degree
    )
}

/// One random surface and its pressure, to look at.
fn sample_fields(
    surface: &dyn RandomSurface,
    half_space: &HalfSpace,
    control: Control,
    hardness_pa: Option<f64>,
    solver: Solver,
    seed: u64,
) -> Result<Vec<(&'static str, Field)>, StudyError> {
    let germ = random::standard_normal(&mut random::stream(seed, "pressure/sample", 0), surface.xi_len());
    let map = surface.generate(&germ);
    let posed = |error| StudyError::Contact { section: "pressure", error };
    let problem = contact::Problem::new(half_space, map.heights_m(), control, hardness_pa).map_err(posed)?;
    let solution = solver.solve(&problem).map_err(posed)?;
    let grid = map.grid();
    Ok(vec![
        ("surface_sample", Field { grid, unit: "m", values: map.heights_m().clone() }),
        ("pressure_sample", Field { grid, unit: "Pa", values: solution.pressure_pa().clone() }),
    ])
}
