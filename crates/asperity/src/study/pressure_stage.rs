//! The law of the random pressure on a patch.

use crate::chaos::StepLaw;
use crate::contact::{self, Boundary, Control, HalfSpace, Solver};
use crate::law::Marginal;
use crate::map::Grid;
use crate::monitor::Monitor;
use crate::pressure::{Method, Problem, Results, Study as Sizes};
use crate::random;
use crate::study::config::{BoundaryChoice, MaterialSection, PressureSection};
use crate::study::output::StageOutput;
use crate::study::result::{MethodEntry, PressureResult};
use crate::study::surface_model::Generated;
use crate::study::{Field, StudyError, Table, sentence};
use crate::surface::RandomSurface;

/// The half-space of a section, and its mean compliance where it is periodic.
pub(super) fn half_space(
    section: &'static str,
    grid: Grid,
    material: &MaterialSection,
    boundary: BoundaryChoice,
    mean_compliance_m_per_pa: Option<f64>,
) -> Result<(HalfSpace, Option<f64>), StudyError> {
    let modulus_pa = contact::contact_modulus_pa(material.youngs_modulus.0, material.poisson_ratio);
    let (boundary, compliance) = match boundary {
        BoundaryChoice::Free => (Boundary::Free, None),
        BoundaryChoice::Periodic => {
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
        (Some(percent), _, _) => plane(marginal, percent),
        (_, Some(depth), _) => Control::Penetration { metre: depth.0 },
        (_, _, Some(pressure)) => Control::MeanPressure { pascal: pressure.0 },
        _ => return Err(StudyError::NoStage("pressure")),
    };
    let hardness_pa = material.hardness.map(|h| h.0);
    let solver = Solver { tolerance: section.tolerance, ..Solver::default() };
    let problem = Problem::new(surface, &half_space, control, hardness_pa)?.with_solver(solver);
    let sizes = Sizes {
        fine_solves: section.fine_solves,
        reference_samples: section.reference_samples,
        variables: section.variables.min(surface.germ_len()),
        degree: section.degree,
        ..Sizes::new(seed)
    };
    let results = sizes.run(&problem, monitor)?;
    let separation_m = match control {
        Control::Plane { height_m } => Some(height_m),
        _ => None,
    };
    let mut warnings = generated.warnings.clone();
    let patch = [patch_sentence(section, &half_space, hardness_pa), expansion_sentence(section, surface)];
    for method in &results.methods {
        if let Err(reason) = &method.outcome {
            warnings.push(format!("pressure method {} has no estimate: {reason}", method.method.name()));
        }
    }
    Ok(PressureStage {
        result: summary(&results, mean_compliance_m_per_pa, separation_m),
        output: StageOutput {
            tables: vec![("pressure_cdf", cdf_table(&results))],
            fields: sample_fields(surface, &half_space, control, hardness_pa, solver, seed)?,
            assumptions: patch.into_iter().chain(generated.correction.clone()).collect(),
            warnings,
        },
    })
}

fn patch_sentence(section: &PressureSection, half_space: &HalfSpace, hardness_pa: Option<f64>) -> String {
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
    format!(
        "The pressure is that of the centre cell [{}, {}] of {boundary}, {} × {} cells on {}, E* = {}, {}, pressed by \
         {control}.",
        grid.ny() / 2,
        grid.nx() / 2,
        grid.nx(),
        grid.ny(),
        sentence::size(grid.width_m(), grid.height_m()),
        sentence::si(half_space.modulus_pa(), "Pa"),
        hardness_pa.map_or_else(|| "elastic".into(), |h| format!("capped at the hardness {}", sentence::si(h, "Pa"))),
    )
}

fn expansion_sentence(section: &PressureSection, surface: &dyn RandomSurface) -> String {
    let germ = surface.germ_len();
    let variables = section.variables.min(germ);
    format!("Chaos expansions use the {variables} leading of {germ} variables at total degree {}.", section.degree)
}

fn summary(results: &Results, mean_compliance_m_per_pa: Option<f64>, separation_m: Option<f64>) -> PressureResult {
    let methods = results.methods.iter().map(|method| {
        let outcome = method.outcome.as_ref().ok();
        MethodEntry {
            name: method.method.name().into(),
            fine_solves: method.fine_solves,
            failed_samples: method.failures.len(),
            contact_probability: outcome.map(|(estimate, _)| estimate.contact_probability),
            contact_probability_se: outcome.map(|(estimate, _)| estimate.contact_probability_se),
            ks_distance: outcome.map(|(_, comparison)| comparison.ks_distance),
            wasserstein_1_over_std: outcome.and_then(|(_, comparison)| comparison.wasserstein_1_over_std),
            coefficients: outcome.and_then(|(estimate, _)| estimate.coefficients),
            leave_one_out_error: outcome.and_then(|(estimate, _)| estimate.leave_one_out_error),
            failure: method.outcome.as_ref().err().map(ToString::to_string),
        }
    });
    PressureResult {
        reference_samples: results.reference.samples,
        contact_probability: results.reference.estimate.contact_probability,
        contact_probability_se: results.reference.estimate.contact_probability_se,
        ks_resolution: results.reference.ks_resolution,
        failed_samples: results.reference.failures.len(),
        mean_compliance_m_per_pa,
        separation_m,
        methods: methods.collect(),
    }
}

/// The CDF of every method on one grid of pressures: 0, quantiles of the reference, and even steps between.
fn cdf_table(results: &Results) -> Table {
    const ROWS: usize = 400;
    let reference = &results.reference.estimate.law;
    let atom = reference.cdf(0.0);
    let highest = reference.quantile(1.0);
    let mut pressures = vec![0.0];
    for k in 0..ROWS {
        let share = (k as f64 + 0.5) / ROWS as f64;
        pressures.push(reference.quantile(atom + (1.0 - atom) * share));
        // Evenly too: under a hardness most quantiles are one.
        pressures.push(highest * share);
    }
    pressures.push(highest);
    pressures.sort_by(f64::total_cmp);
    pressures.dedup();
    let column = |law: Option<&StepLaw>| -> Vec<f64> {
        pressures.iter().map(|p| law.map_or(f64::NAN, |law| law.cdf(*p))).collect()
    };
    let mut columns =
        vec![("pressure_pa".to_owned(), pressures.clone()), ("reference".into(), column(Some(reference)))];
    for method in Method::ALL {
        let law = results.estimate(method).map(|(estimate, _)| &estimate.law);
        columns.push((method.name().into(), column(law)));
    }
    Table::new(columns)
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
    let germ = random::standard_normal(&mut random::stream(seed, "pressure/sample", 0), surface.germ_len());
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
