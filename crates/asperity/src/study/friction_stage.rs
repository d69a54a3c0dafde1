//! Friction stage: solved strips at several levels of contact.

mod cost;
mod cutoff;
mod entries;
mod pitch;
mod scan;
mod tables;
mod uncertain_surface;
mod uncertainty;
mod whole_error;
mod words;

pub(super) use self::cost::cost;
use self::cutoff::SolvedCutoffs;
use self::pitch::Pitch;
use self::whole_error::WholeError;
use crate::contact::Control;
use crate::friction::strip::{StripProblem, Strips};
use crate::friction::{FrictionError, LevelControl, OperatingLevel, RoughBody, SolvedLevel, TwoBodyFriction};
use crate::monitor::Monitor;
use crate::quantity::Area;
use crate::study::check::FrictionStudy;
use crate::study::friction_strips::strip_problem;
use crate::study::output::StageOutput;
use crate::study::plausibility::implausible_friction;
use crate::study::result::{FrictionResult, LevelResult};
use crate::study::series::map_field;
use crate::study::surface_stage::SurfaceStage;
use crate::study::{Study, StudyError};
use crate::surface::model::XiOrder;

/// Default nominal area: a brake pad at 3 MPa under 2.5 kN.
const NOMINAL_AREA: Area = Area(833e-6);

impl Study {
    /// Returns the nominal area that `[friction]` or `[vibration]` states.
    pub(super) fn stated_nominal_area(&self) -> Option<Area> {
        let of_vibration = || self.vibration.as_ref().map(|vibration| vibration.machine.nominal_area);
        self.friction.as_ref().and_then(|friction| friction.nominal_area).or_else(of_vibration)
    }
}

/// Output of the friction stage.
pub(super) struct FrictionStage {
    /// Operating level.
    pub(super) level: SolvedLevel,
    pub(super) result: FrictionResult,
    pub(super) output: StageOutput,
}

/// Solves the strips at the levels of the study and at the operating level.
pub(super) fn run(
    study: &FrictionStudy,
    surface: &SurfaceStage,
    operating: OperatingLevel,
    stated_area: Option<Area>,
    seed: u64,
    monitor: &dyn Monitor,
) -> Result<FrictionStage, StudyError> {
    let nominal_area_m2 = stated_area.unwrap_or(NOMINAL_AREA).0;
    let (problem, mean_compliance_m_per_pa) = strip_problem(study)?;
    let grid = problem.grid();
    let generated = surface.model.strip(grid, problem.is_periodic(), XiOrder::Variance)?;
    let mut stated = study.levels.clone();
    if let OperatingLevel::NominalPressure(pascal) = operating {
        stated.push(LevelControl::Nominal(pascal));
    }
    // Pressures rise with every prescribed quantity.
    let rising: Vec<_> = stated.iter().map(|level| (*level, level.value())).collect();
    let strips = Strips {
        stiff_level: Some(operating.index_in(&rising)),
        ..problem.strips(generated.surface.as_ref(), study.realisations, seed)
    };
    let controls: Vec<Control> =
        stated.iter().map(|level| level.contact(|p| surface.model.height_quantile_m(p))).collect();
    let mut solved = Vec::with_capacity(stated.len());
    for (control, strips) in stated.into_iter().zip(strips.solve(&controls, monitor)?) {
        solved.push((control, strips.map_err(failed(control))?));
    }
    let pressures: Vec<_> = solved.iter().map(|(control, strips)| (*control, strips.mean_pressure_pa)).collect();
    let lead = operating.index_in(&pressures);
    let pascal = pressures[lead].1;
    let (scan, of_scan) = scan::run(study, surface, (generated.surface.as_ref(), pascal), seed, monitor)?;
    let pitch_of = |found: &SolvedCutoffs| Pitch::new(&problem, &solved[lead].1, found, scan.as_ref());
    let is_resolved = |found: &SolvedCutoffs| pitch_of(found).is_none_or(|pitch| pitch.is_negligible(&solved[lead].1));
    let (cutoffs, of_cutoffs) =
        SolvedCutoffs::solve(study, surface, (solved.len(), pascal), is_resolved, seed, monitor)?;
    let pitch = cutoffs.as_ref().and_then(pitch_of);
    let strips = Strips { pitch_factor: pitch.as_ref().map_or(1.0, |pitch| pitch.factor), ..strips };
    solved[lead].1.extrapolate(&problem, strips.pitch_factor);
    let level = |(control, strips)| SolvedLevel::new(control, strips, &problem, seed).map_err(failed(control));
    let mut levels = solved.into_iter().map(level).collect::<Result<Vec<_>, _>>()?;
    if study.body == RoughBody::Both {
        let found = TwoBodyFriction::solve(&strips, &levels[lead], controls[lead], monitor);
        levels[lead].two_bodies = found.map_err(failed(levels[lead].control))?;
    }
    if let Some(pitch) = &pitch {
        levels[lead].widen_fluctuation(pitch.fluctuation());
    }
    let uncertain = uncertainty::run(study, &problem, surface, &levels, seed, monitor)?;
    let mean_at_pitch = pitch.as_ref().map_or(levels[lead].mean, |pitch| pitch.mean_at_pitch);
    let (cutoff, of_cutoff) =
        cutoffs.and_then(|found| found.result(study, surface, &levels[lead], mean_at_pitch)).unzip();
    let point = entries::operating_point(&levels[lead], nominal_area_m2);
    let whole = WholeError::new(study, surface, &levels[lead], point, (pitch.as_ref(), scan.as_ref()));
    levels[lead].mean_errors = whole.errors.clone();
    let (uncertainty, of_uncertain) = uncertain.unzip();
    let result = FrictionResult {
        mean_compliance_m_per_pa,
        operating_point: whole.point,
        cutoff,
        scan,
        uncertainty,
        ..result_of_levels(study, &problem, &levels, lead, nominal_area_m2)
    };
    let mut output = output_of_levels(&result.levels, &levels, lead, study.body);
    // What keeps friction from being resolved comes before what concerns single levels.
    output.warnings.splice(0..0, whole.warnings.into_iter().chain(generated.warnings.clone()));
    if let Some(pressure_pa) = &levels[lead].strips.sample_pressure_pa {
        output.fields.push(("pressure_strip", map_field(grid, "Pa", pressure_pa.clone())));
    }
    let assumed =
        || format!("No nominal area is stated; friction is scaled up to {NOMINAL_AREA}, that of a brake pad.");
    output.assumptions.extend(stated_area.is_none().then(assumed));
    output.assumptions.extend(words::sentences(study, &strips, mean_compliance_m_per_pa, &levels[lead]));
    output.assumptions.extend(generated.correction.clone());
    [of_cutoffs, of_cutoff.unwrap_or_default(), of_scan].into_iter().for_each(|part| output.extend(part));
    output.assumptions.extend(whole.sentences);
    output.extend(of_uncertain.unwrap_or_default());
    Ok(FrictionStage { level: levels.swap_remove(lead), result, output })
}

/// Returns a function that names the level of an error.
fn failed(control: LevelControl) -> impl Fn(FrictionError) -> StudyError {
    move |error| StudyError::Friction { level: control.name(), error }
}

/// Returns the geometry of the strips and the results of all levels.
fn result_of_levels(
    study: &FrictionStudy,
    problem: &StripProblem,
    levels: &[SolvedLevel],
    lead: usize,
    nominal_area_m2: f64,
) -> FrictionResult {
    let result = |(index, level)| LevelResult {
        leading: index == lead,
        ..entries::level_result(level, study.body, nominal_area_m2)
    };
    FrictionResult {
        body: study.body,
        window_m: problem.window.length_m(),
        window_width_m: problem.window.width_m(),
        strip_width_m: problem.grid().height_m(),
        realisations: study.realisations,
        levels: levels.iter().enumerate().map(result).collect(),
        ..FrictionResult::default()
    }
}

/// Returns the tables and the warnings of all levels and of the operating level.
fn output_of_levels(results: &[LevelResult], levels: &[SolvedLevel], lead: usize, body: RoughBody) -> StageOutput {
    let mut warnings = Vec::new();
    let level = &levels[lead];
    let place = level.control.name();
    warnings.extend(implausible_friction(level.mean).map(|warning| format!("at {place}, {warning}")));
    if body == RoughBody::Track {
        warnings.extend(words::drift(level));
        warnings.extend(words::correlation(level));
    }
    // The vibration does not use the quotients of single windows.
    warnings.extend(levels.iter().flat_map(words::level_warnings));
    let mut tables = tables::of_levels(results, levels, body);
    tables.extend(tables::of_lead(level, body));
    StageOutput { tables, warnings, ..StageOutput::default() }
}
