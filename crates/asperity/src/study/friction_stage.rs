//! Friction of solved strips at several levels of contact.

pub(super) mod cutoff;
mod entries;
mod tables;
mod words;

pub(super) use self::words::no_variance;

use crate::contact::{Control, HalfSpace, Solver, contact_modulus_pa};
use crate::correlation::{LengthSettings, RecordEnds};
use crate::friction::analysis::{MODELS, ProcessAnalysis, record_ends};
use crate::friction::law::FrictionLaw;
use crate::friction::statistics::{FrictionStatistics, HeavyTail};
use crate::friction::strip::{Level, Record, Strips};
use crate::friction::upscaling::variance_reduction;
use crate::friction::window::Window;
use crate::friction::window_study::WindowStudy;
use crate::map::BoundaryKind;
use crate::map::Grid;
use crate::monitor::Monitor;
use crate::stats::{Interval, Layout, ProcessMoments};
use crate::study::file::{FrictionSection, MaterialSection, WindowShape};
use crate::study::friction_law::friction_law;
use crate::study::friction_uncertainty;
use crate::study::level_control::{Lead, LevelControl};
use crate::study::output::StageOutput;
use crate::study::plausibility::implausible_friction;
use crate::study::pressure_stage::half_space;
use crate::study::result::{AreaScatter, FrictionResult, LevelResult, PaperScatter, UpscalingResult};
use crate::study::surface_stage::SurfaceStage;
use crate::study::{Field, StudyError};
use crate::surface::RandomSurface;

/// One level with its statistics.
pub(super) struct SolvedLevel {
    pub(super) control: LevelControl,
    pub(super) level: Level,
    /// Of the quotient F/N of each window.
    statistics: FrictionStatistics,
    /// Where the quotient has no variance.
    pub(super) heavy_tail: Option<HeavyTail>,
    /// Contact area over nominal area with its 95 % interval.
    contact_fraction: (f64, Option<Interval>),
    /// μ̄ = ΣF/ΣN.
    pub(super) mean: f64,
    /// Windows at the mean load.
    at_mean_load: Vec<Record>,
    /// Of the windows at the mean load.
    pub(super) process: FrictionStatistics,
    /// Of the windows at the mean load.
    analysis: ProcessAnalysis,
    /// Absent where friction does not vary.
    pub(super) window_study: Option<WindowStudy>,
}

impl SolvedLevel {
    fn new(
        control: LevelControl,
        level: Level,
        window: &Window,
        periodic: bool,
        strip_m: f64,
        seed: u64,
    ) -> Result<Self, StudyError> {
        let failed = |error| StudyError::Friction { level: control.name(), error };
        let (tracks, layout) = (level.tracks, Layout { periodic, tracks: level.tracks });
        let statistics = FrictionStatistics::new(&level.records, window.step_m(), layout, seed).map_err(failed)?;
        let (mean, at_mean_load) = Record::at_mean_load(&level.records);
        let process = FrictionStatistics::new(&at_mean_load, window.step_m(), layout, seed).map_err(failed)?;
        // The study knows the correlation under rectangles.
        let own = window.is_rectangle().then(|| (window.clone(), at_mean_load.clone()));
        let narrower = level.narrower.iter().map(|(window, records)| (window.clone(), Record::at_mean_load(records).1));
        let windows: Vec<(Window, Vec<Record>)> = own.into_iter().chain(narrower).collect();
        let varies = process.moments.std > 0.0;
        let whole = |(window, records): &(Window, Vec<Record>)| record_ends(records, window, periodic, strip_m);
        let round = windows.iter().all(|seen| whole(seen) == RecordEnds::Periodic);
        let ends = if round { RecordEnds::Periodic } else { RecordEnds::Free };
        let settings = LengthSettings { ends, ..LengthSettings::default() };
        let study = || WindowStudy::with_models(&windows, tracks, &MODELS, settings).ok();
        let window_study = if varies { study() } else { None };
        let analysis = ProcessAnalysis::new(&at_mean_load, window, layout, strip_m);
        let heavy_tail = statistics.heavy_tail();
        let contact_fraction = contact_fraction(&level, layout);
        Ok(Self {
            control,
            level,
            statistics,
            heavy_tail,
            contact_fraction,
            mean,
            at_mean_load,
            process,
            analysis,
            window_study,
        })
    }

    /// Mean of the quotient F/N, where it exists.
    fn quotient_mean(&self) -> Option<f64> {
        self.heavy_tail.is_none_or(|tail| tail.has_mean()).then_some(self.statistics.moments.mean)
    }

    /// Variance of μ over the nominal area over that of one window, by the correlation that is left without the window.
    pub(super) fn variance_reduction(&self, window: &Window, nominal_area_m2: f64) -> f64 {
        let correlation = |lag_m: f64| match &self.window_study {
            Some(study) if study.length_m > 0.0 => study.model.correlation(lag_m, study.length_m),
            _ => 0.0,
        };
        // Windows of another shape count as rectangles of their area and width.
        let rectangle_m = window.area_m2() / window.width_m();
        variance_reduction(rectangle_m, window.width_m(), nominal_area_m2, &correlation)
    }

    /// Both upscalings.
    fn upscaling(&self, window: &Window, nominal_area_m2: f64) -> UpscalingResult {
        let (std, variance_reduction) = (self.process.moments.std, self.variance_reduction(window, nominal_area_m2));
        UpscalingResult {
            paper: PaperScatter { std },
            area: AreaScatter {
                nominal_area_m2,
                windows: nominal_area_m2 / window.area_m2(),
                variance_reduction,
                std: std * variance_reduction.sqrt(),
            },
        }
    }
}

/// Contact area over nominal area, with the relative error of the mean contact area of the windows.
fn contact_fraction(level: &Level, layout: Layout) -> (f64, Option<Interval>) {
    let areas_m2: Vec<&[f64]> = level.records.iter().map(|record| record.area_m2.as_slice()).collect();
    let moments = ProcessMoments::new(&areas_m2, layout);
    let share = level.contact_fraction / moments.moments.mean;
    let interval =
        moments.mean.map(|mean| Interval { low: share * mean.interval.low, high: share * mean.interval.high });
    (level.contact_fraction, interval)
}

/// Every level, and the windows that it was seen through.
pub(super) struct SolvedStrips {
    pub(super) window: Window,
    pub(super) levels: Vec<SolvedLevel>,
    /// Index of the level that leads.
    pub(super) lead: usize,
}

/// What the friction stage hands on.
pub(super) struct FrictionStage {
    pub(super) solved: SolvedStrips,
    pub(super) result: FrictionResult,
    pub(super) output: StageOutput,
}

/// What is the same for all random surfaces.
pub(super) struct Setup {
    pub(super) grid: Grid,
    pub(super) periodic: bool,
    pub(super) window: Window,
    half_space: HalfSpace,
    mean_compliance_m_per_pa: Option<f64>,
    law: Box<dyn FrictionLaw>,
    law_in_words: String,
    hardness_pa: Option<f64>,
    solver: Solver,
}

impl Setup {
    pub(super) fn new(section: &FrictionSection, material: &MaterialSection) -> Result<Self, StudyError> {
        let [nx, ny] = section.points;
        let grid = Grid::with_size(nx, ny, section.strip[0].0, section.strip[1].0)
            .map_err(|error| StudyError::Grid { section: "friction", error })?;
        let compliance = section.mean_compliance.map(|c| c.0);
        let modulus_pa = contact_modulus_pa(material.youngs_modulus.0, material.poisson_ratio);
        let (half_space, mean_compliance_m_per_pa) =
            half_space("friction", grid, modulus_pa, section.boundary, compliance)?;
        let window = match section.window_shape {
            WindowShape::Rectangle => Window::rectangle(section.window.0, section.window_width().0, grid)?,
            WindowShape::Ellipse => Window::ellipse(section.window.0, section.window_width().0, grid)?,
        };
        let (law, law_in_words) = friction_law(section, material)?;
        Ok(Self {
            grid,
            periodic: section.boundary == BoundaryKind::Periodic,
            window,
            half_space,
            mean_compliance_m_per_pa,
            law,
            law_in_words,
            hardness_pa: material.hardness.map(|h| h.0),
            solver: Solver { tolerance: section.tolerance, ..Solver::default() },
        })
    }

    /// So many strips of a random surface.
    pub(super) fn strips<'a>(&'a self, surface: &'a dyn RandomSurface, realisations: usize, seed: u64) -> Strips<'a> {
        Strips {
            surface,
            half_space: &self.half_space,
            window: &self.window,
            law: self.law.as_ref(),
            hardness_pa: self.hardness_pa,
            solver: self.solver,
            realisations,
            seed,
        }
    }
}

/// Solves the strips at the levels of the section and, where it leads, at the nominal pressure.
pub(super) fn run(
    section: &FrictionSection,
    material: &MaterialSection,
    surface: &SurfaceStage,
    lead: Lead,
    nominal_area_m2: f64,
    seed: u64,
    monitor: &dyn Monitor,
) -> Result<FrictionStage, StudyError> {
    let setup = Setup::new(section, material)?;
    let &Setup { grid, periodic, mean_compliance_m_per_pa, .. } = &setup;
    let generated = surface.model.strip(grid, periodic)?;
    let strips = setup.strips(generated.surface.as_ref(), section.realisations, seed);
    let stated = LevelControl::of(section, lead);
    let controls: Vec<Control> = stated.iter().map(|level| level.contact(&surface.model.marginal)).collect();
    let mut output = StageOutput { warnings: generated.warnings.clone(), ..StageOutput::default() };
    let mut levels = Vec::new();
    for (control, level) in stated.into_iter().zip(strips.solve(&controls, monitor)?) {
        let level = level.map_err(|error| StudyError::Friction { level: control.name(), error })?;
        let level = SolvedLevel::new(control, level, &setup.window, periodic, grid.width_m(), seed)?;
        output.warnings.extend(words::level_warnings(&level));
        levels.push(level);
    }
    let pressures: Vec<_> = levels.iter().map(|level| (level.control, level.level.mean_pressure_pa)).collect();
    let lead = lead.among(&pressures);
    let uncertain = friction_uncertainty::run(section, &setup, surface, &levels, seed, monitor)?;
    let (cutoff, of_cutoff) = cutoff::run(section, material, surface, (&levels, lead), seed, monitor)?;
    let window = &setup.window;
    let mut result = FrictionResult {
        window_m: window.length_m(),
        window_width_m: window.width_m(),
        strip_width_m: grid.height_m(),
        mean_compliance_m_per_pa,
        realisations: section.realisations,
        operating_point: entries::operating_point(&levels[lead], window, nominal_area_m2),
        levels: levels
            .iter()
            .enumerate()
            .map(|(index, level)| LevelResult {
                leading: index == lead,
                ..entries::level_result(level, level.upscaling(window, nominal_area_m2))
            })
            .collect(),
        cutoff,
        uncertainty: None,
    };
    output.tables = tables::of_levels(&levels);
    output.tables.extend(tables::of_lead(&levels[lead], window));
    let place = levels[lead].control.name();
    output.warnings.extend(implausible_friction(levels[lead].mean).map(|warning| format!("at {place}, {warning}")));
    output.warnings.extend(words::drift(&levels[lead]));
    output.warnings.extend(words::correlation(&levels[lead]));
    if let Some(pressure_pa) = &levels[lead].level.sample_pressure_pa {
        output.fields.push(("pressure_strip", Field { grid, unit: "Pa", values: pressure_pa.clone() }));
    }
    output.assumptions =
        words::sentences(section, &strips, &setup.law_in_words, mean_compliance_m_per_pa, &levels[lead]);
    output.assumptions.extend(generated.correction.clone());
    output.extend(of_cutoff);
    if let Some((found, own)) = uncertain {
        output.extend(own);
        result.uncertainty = Some(found);
    }
    let solved = SolvedStrips { window: setup.window, levels, lead };
    Ok(FrictionStage { solved, result, output })
}
