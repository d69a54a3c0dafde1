//! Friction stage: solved strips at several levels of contact.

pub(super) mod cutoff;
mod entries;
mod tables;
mod words;

use std::sync::Arc;

pub(super) use self::words::no_variance;

use crate::contact::{Control, Solver};
use crate::friction::replicates::MomentReplicates;
use crate::friction::strip::{StripProblem, Strips};
use crate::friction::{LevelControl, OperatingLevel, RoughBody, SolvedLevel, TwoBodyFriction};
use crate::monitor::Monitor;
use crate::study::check::FrictionStudy;
use crate::study::friction_uncertainty;
use crate::study::output::StageOutput;
use crate::study::plausibility::implausible_friction;
use crate::study::pressure_stage::half_space;
use crate::study::result::{
    AreaScatter, FrictionResult, LevelResult, PaperScatter, Prescribed, RoughBodyResult, UpscalingResult,
};
use crate::study::surface_stage::SurfaceStage;
use crate::study::{QuantityMap, StudyError};
use crate::surface::model::{CompositeModel, XiOrder};

/// Returns the variability over the nominal area by both upscalings.
fn upscaling(solved: &SolvedLevel, nominal_area_m2: f64) -> UpscalingResult {
    let (std, variance_reduction) = (solved.process.moments.std, solved.variance_reduction(nominal_area_m2));
    UpscalingResult {
        paper: PaperScatter { std },
        area: AreaScatter {
            nominal_area_m2,
            windows: nominal_area_m2 / solved.window.area_m2(),
            variance_reduction,
            std: std * variance_reduction.sqrt(),
        },
    }
}

/// Returns the kind of a level in results.
pub(super) fn prescribed(level: LevelControl) -> Prescribed {
    match level {
        LevelControl::Percentile(_) => Prescribed::Percentile,
        LevelControl::MeanPressure(_) | LevelControl::Nominal(_) => Prescribed::MeanPressure,
        LevelControl::Penetration(_) => Prescribed::Penetration,
    }
}

/// Returns the rough bodies in results.
fn rough_body(body: RoughBody) -> RoughBodyResult {
    match body {
        RoughBody::Track => RoughBodyResult::Track,
        RoughBody::Slider => RoughBodyResult::Slider,
        RoughBody::Both => RoughBodyResult::Both,
    }
}

/// Output of the friction stage.
pub(super) struct FrictionStage {
    /// Operating level.
    pub(super) level: SolvedLevel,
    pub(super) result: FrictionResult,
    pub(super) output: StageOutput,
}

/// Returns the contact problem of the strips with its mean compliance, in m/Pa.
fn strip_problem(study: &FrictionStudy) -> Result<(StripProblem, Option<f64>), StudyError> {
    let ((grid, window), material) = (study.strip()?, &study.material);
    let compliance = study.mean_compliance.map(|c| c.0);
    let (half_space, mean_compliance_m_per_pa) =
        half_space("friction", grid, material.contact_modulus_pa, study.boundary, compliance)?;
    let solver = Solver { tolerance: study.tolerance, ..Solver::default() };
    let law = Arc::clone(&study.law);
    let problem = StripProblem {
        half_space,
        window,
        law,
        hardness_pa: material.hardness_pa,
        solver,
        valid_share: study.valid_share,
    };
    Ok((problem, mean_compliance_m_per_pa))
}

/// Solves a few strips at one level and returns the moments of friction at the mean load; `None` if they have no solution. All surfaces
/// are drawn from the same random numbers.
pub(super) fn solve_level(
    study: &FrictionStudy,
    model: &CompositeModel,
    level: LevelControl,
    realisations: usize,
    seed: u64,
    monitor: &dyn Monitor,
) -> Result<Option<MomentReplicates>, StudyError> {
    let (problem, _) = strip_problem(study)?;
    let generated = model.strip(problem.grid(), problem.is_periodic(), XiOrder::Wavevector)?;
    let strips = Strips { stiff_level: Some(0), ..problem.strips(generated.surface.as_ref(), realisations, seed) };
    let solved = strips.solve(&[level.contact(|probability| model.height_quantile_m(probability))], monitor)?;
    let step_m = problem.window.step_m();
    Ok(solved.into_iter().flatten().next().map(|level| MomentReplicates::from_mean_load(&level, step_m)))
}

/// Solves the strips at the levels of the study and at the operating level.
pub(super) fn run(
    study: &FrictionStudy,
    surface: &SurfaceStage,
    operating: OperatingLevel,
    nominal_area_m2: f64,
    seed: u64,
    monitor: &dyn Monitor,
) -> Result<FrictionStage, StudyError> {
    let (problem, mean_compliance_m_per_pa) = strip_problem(study)?;
    let grid = problem.grid();
    let generated = surface.model.strip(grid, problem.is_periodic(), XiOrder::Variance)?;
    let nominal = match operating {
        OperatingLevel::NominalPressure(pascal) => Some(LevelControl::Nominal(pascal)),
        OperatingLevel::Deepest | OperatingLevel::Percentile(_) => None,
    };
    let stated: Vec<LevelControl> = study.levels.iter().copied().chain(nominal).collect();
    // Pressures rise with every prescribed quantity.
    let rising: Vec<_> = stated.iter().map(|level| (*level, level.value())).collect();
    let strips = Strips {
        stiff_level: Some(operating.index_in(&rising)),
        ..problem.strips(generated.surface.as_ref(), study.realisations, seed)
    };
    let controls: Vec<Control> =
        stated.iter().map(|level| level.contact(|p| surface.model.height_quantile_m(p))).collect();
    let mut output = StageOutput { warnings: generated.warnings.clone(), ..StageOutput::default() };
    let mut levels = Vec::new();
    for (control, solved) in stated.into_iter().zip(strips.solve(&controls, monitor)?) {
        let level = solved
            .and_then(|solved| SolvedLevel::new(control, solved, &problem, seed))
            .map_err(|error| StudyError::Friction { level: control.name(), error })?;
        output.warnings.extend(words::level_warnings(&level));
        levels.push(level);
    }
    let pressures: Vec<_> = levels.iter().map(|level| (level.control, level.strips.mean_pressure_pa)).collect();
    let lead = operating.index_in(&pressures);
    if study.body == RoughBody::Both {
        let found = TwoBodyFriction::solve(&strips, &levels[lead], controls[lead], monitor);
        levels[lead].two_bodies =
            found.map_err(|error| StudyError::Friction { level: levels[lead].control.name(), error })?;
    }
    let uncertain = friction_uncertainty::run(study, &problem, surface, &levels, seed, monitor)?;
    let (cutoff, of_cutoff) = cutoff::run(study, surface, (&levels, lead), seed, monitor)?;
    let window = &problem.window;
    let mut result = FrictionResult {
        body: rough_body(study.body),
        window_m: window.length_m(),
        window_width_m: window.width_m(),
        strip_width_m: grid.height_m(),
        mean_compliance_m_per_pa,
        realisations: study.realisations,
        operating_point: entries::operating_point(&levels[lead], nominal_area_m2),
        levels: levels
            .iter()
            .enumerate()
            .map(|(index, level)| LevelResult {
                leading: index == lead,
                ..entries::level_result(level, study.body, upscaling(level, nominal_area_m2))
            })
            .collect(),
        cutoff,
        uncertainty: None,
    };
    output.tables = tables::of_levels(&levels, study.body);
    output.tables.extend(tables::of_lead(&levels[lead], study.body));
    let place = levels[lead].control.name();
    output.warnings.extend(implausible_friction(levels[lead].mean).map(|warning| format!("at {place}, {warning}")));
    if study.body == RoughBody::Track {
        output.warnings.extend(words::drift(&levels[lead]));
        output.warnings.extend(words::correlation(&levels[lead]));
    }
    if let Some(pressure_pa) = &levels[lead].strips.sample_pressure_pa {
        output.fields.push(("pressure_strip", QuantityMap { grid, unit: "Pa", values: pressure_pa.clone() }));
    }
    output.assumptions = words::sentences(study, &strips, mean_compliance_m_per_pa, &levels[lead]);
    output.assumptions.extend(generated.correction.clone());
    output.extend(of_cutoff);
    if let Some((found, own)) = uncertain {
        output.extend(own);
        result.uncertainty = Some(found);
    }
    Ok(FrictionStage { level: levels.swap_remove(lead), result, output })
}
