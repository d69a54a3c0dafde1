//! Pressure stage: distribution of the random pressure on a patch.

mod cost;
mod entries;
mod indices;
mod maps;
mod scalars;
mod tables;

pub(super) use self::cost::cost;
use crate::contact::{Boundary, ContactProblem, Control, HalfSpace, Solver};
use crate::friction::LevelControl;
use crate::map::HeightMap;
use crate::monitor::Monitor;
use crate::pressure::PressureMethod::{LatinHypercube, MonteCarlo, PolynomialChaos, PolynomialChaosLog, Sobol};
use crate::pressure::{MethodComparison, PressureError, Problem};
use crate::random;
use crate::study::check::PressureStudy;
use crate::study::half_space::half_space;
use crate::study::output::{StageOutput, left_out};
use crate::study::result::PressureResult;
use crate::study::series::map_field;
use crate::study::{Field, StudyError, sentence};
use crate::surface::RandomSurface;
use crate::surface::model::{CompositeModel, Generated};
use entries::Prescribed;

/// Bias of a method over the mean pressure above which the stage warns.
const LARGE_BIAS: f64 = 0.25;

/// Output of the pressure stage.
pub(super) struct PressureStage {
    pub(super) result: PressureResult,
    pub(super) output: StageOutput,
}

pub(super) fn run(
    study: &PressureStudy,
    model: &CompositeModel,
    generated: &Generated,
    seed: u64,
    monitor: &dyn Monitor,
) -> Result<PressureStage, StudyError> {
    let surface = generated.surface.as_ref();
    let (grid, material) = (surface.grid(), &study.material);
    let compliance = study.mean_compliance.map(|c| c.0);
    let (half_space, mean_compliance_m_per_pa) =
        half_space("pressure", grid, material.contact_modulus_pa, study.boundary, compliance)?;
    let control = match study.control.contact(|p| model.height_quantile_m(p)) {
        // Truncation lowers the heights, so the plane is scaled down too.
        Control::Plane { height_m } => Control::Plane { height_m: generated.std_share * height_m },
        control => control,
    };
    let solver = Solver { tolerance: study.tolerance, ..Solver::default() };
    let (row, column) = study.cell;
    let problem =
        Problem::new(surface, &half_space, control, material.hardness_pa)?.at_cell(row, column)?.with_solver(solver);
    let sizes = MethodComparison {
        methods: study.methods.clone(),
        fine_solves: study.fine_solves,
        reference_samples: study.reference_samples,
        variables: study.variables.min(surface.xi_len()),
        degree: study.degree,
        stiffness: study.stiffness,
        valid_fraction: study.valid_fraction,
        ..MethodComparison::new(seed)
    };
    let results = sizes.run(&problem, monitor)?;
    let separation_m = match control {
        Control::Plane { height_m } => Some(height_m),
        _ => None,
    };
    let mut warnings = generated.warnings.clone();
    let failed = results.reference.as_ref().map_or(0, |reference| reference.failures.len());
    warnings.extend(left_out("contact solutions of the reference", failed, study.reference_samples));
    for design in [MonteCarlo, LatinHypercube, Sobol] {
        let Some(method) = results.methods.iter().find(|found| found.method.design() == design) else { continue };
        let what = format!("contact solutions of {}", design.name().replace('_', " "));
        warnings.extend(left_out(&what, method.failures.len(), method.fine_solves));
    }
    let expands = [PolynomialChaos, PolynomialChaosLog].iter().any(|method| study.methods.contains(method));
    let expansion = expands.then(|| expansion_sentence(study, surface));
    let patch = [Some(patch_sentence(study, &half_space)), expansion];
    for method in &results.methods {
        let name = method.method.name().replace('_', " ");
        if let Err(reason) = &method.outcome {
            warnings.push(format!("pressure method {name} has no estimate: {reason}"));
        }
        let estimate = method.outcome.as_ref().ok().map(|(estimate, _)| estimate);
        let bias = estimate.and_then(|found| found.mean_bias_pa.map(|bias_pa| (found.mean_pa, bias_pa)));
        if let Some((mean_pa, bias_pa)) = bias.filter(|(mean_pa, bias_pa)| bias_pa.abs() > LARGE_BIAS * mean_pa) {
            warnings.push(format!(
                "pressure method {name} is biased: samples that it was not fitted to move its mean from {} to {}; its intervals are corrected, \
                 its other numbers are not",
                sentence::si(mean_pa, "Pa"),
                sentence::si(mean_pa - bias_pa, "Pa"),
            ));
        }
    }
    let prescribed = Prescribed { cell: (row, column), mean_compliance_m_per_pa, separation_m };
    let answer = results.answer().map_err(PressureError::from)?;
    let result = entries::summary(&results, answer, &prescribed);
    let mut fields = sample_fields(&problem, seed)?;
    fields.extend(results.fields.iter().flat_map(maps::fields));
    Ok(PressureStage {
        output: StageOutput {
            tables: tables::tables(&results, answer, &result),
            fields,
            assumptions: patch.into_iter().flatten().chain(generated.correction.clone()).collect(),
            warnings,
        },
        result,
    })
}

fn patch_sentence(study: &PressureStudy, half_space: &HalfSpace) -> String {
    let boundary = match half_space.boundary() {
        Boundary::Free => "a finite patch on an unloaded half-space".to_owned(),
        Boundary::Periodic { mean_compliance_m_per_pa } => {
            format!("a periodic patch of mean compliance {}", sentence::compliance(mean_compliance_m_per_pa))
        }
    };
    let control = match study.control {
        LevelControl::Percentile(percent) => {
            format!("a rigid plane fixed in space that {percent} % of the ensemble's heights exceed before deformation")
        }
        LevelControl::Penetration(depth_m) => {
            format!("a rigid plane {} below the highest point of each patch", sentence::si(depth_m, "m"))
        }
        LevelControl::MeanPressure(pascal) | LevelControl::Nominal(pascal) => {
            format!("a rigid plane under the mean pressure {}", sentence::si(pascal, "Pa"))
        }
    };
    let hardness = study.material.hardness_pa;
    let ((row, column), grid) = (study.cell, half_space.grid());
    let centre = if (row, column) == (grid.ny() / 2, grid.nx() / 2) { "centre " } else { "" };
    format!(
        "The pressure is that of the {centre}cell [{row}, {column}] of {boundary}, {} × {} cells on {}, E* = {}, {}, pressed by \
         {control}.",
        grid.nx(),
        grid.ny(),
        sentence::size(grid.width_m(), grid.height_m()),
        sentence::si(half_space.modulus_pa(), "Pa"),
        hardness.map_or_else(|| "elastic".into(), |h| format!("capped at the hardness {}", sentence::si(h, "Pa"))),
    )
}

fn expansion_sentence(study: &PressureStudy, surface: &dyn RandomSurface) -> String {
    let xi_len = surface.xi_len();
    let variables = study.variables.min(xi_len);
    format!(
        "The paper’s chaos expansions, eq. (8) and (9), use the {variables} leading of {xi_len} variables at total degree {}.",
        study.degree
    )
}

/// Returns one random surface, with its counterface if that is rough, and its pressure, as an example.
fn sample_fields(problem: &Problem<'_>, seed: u64) -> Result<Vec<(&'static str, Field)>, StudyError> {
    let surface = problem.surface();
    let xi = random::standard_normal(&mut random::stream(seed, "pressure/sample", 0), surface.xi_len());
    let map = surface.generate(&xi);
    let prescribed = |error| StudyError::Contact { section: "pressure", error };
    let (half_space, control) = (problem.half_space(), problem.control());
    let contact =
        ContactProblem::new(half_space, map.heights_m(), control, problem.hardness_pa()).map_err(prescribed)?;
    let solution = problem.solver().solve(&contact).map_err(prescribed)?;
    let grid = map.grid();
    let heights = |map: HeightMap| map_field(grid, "m", map.heights_m().clone());
    let pressure = ("pressure_sample", map_field(grid, "Pa", solution.pressure_pa().clone()));
    Ok(match surface.bodies(&xi) {
        None => vec![("surface_sample", heights(map)), pressure],
        Some([own, counterface]) => {
            vec![("surface_sample", heights(own)), ("counterface_sample", heights(counterface)), pressure]
        }
    })
}
