//! Friction of solved strips at several levels of contact.

use std::collections::BTreeMap;

use crate::contact::{Control, HalfSpace, Solver};
use crate::correlation::windowed_exponential;
use crate::friction::law::FrictionLaw;
use crate::friction::load_curve::LoadPoint;
use crate::friction::statistics::{FrictionStatistics, ReturnLevel, WANTED_CONTACT_CELLS};
use crate::friction::strip::{Level, Record, Strips};
use crate::friction::upscaling::{exponential, variance_reduction};
use crate::friction::window::Window;
use crate::friction::window_study::{WindowCorrelation, WindowStudy};
use crate::law::Marginal;
use crate::map::Grid;
use crate::monitor::Monitor;
use crate::stats::{Estimate, Histogram};
use crate::study::config::{BoundaryChoice, FrictionSection, MaterialSection, WindowShape};
use crate::study::friction_law::friction_law;
use crate::study::friction_uncertainty;
use crate::study::level_control::{Lead, LevelControl};
use crate::study::output::StageOutput;
use crate::study::pressure_stage::half_space;
use crate::study::result::{
    AreaScatter, AtMeanLoad, FrictionResult, GoodnessResult, LevelResult, Pair, PaperScatter, ReturnLevelResult,
    SurfaceResult, UpscalingResult, finite, pair,
};
use crate::study::surface_model::SurfaceModel;
use crate::study::surface_stage::law_result;
use crate::study::{Field, StudyError, Table, sentence};
use crate::surface::RandomSurface;

/// Share of windows with too few contact cells above which a level is warned about.
const SPARSE_SHARE: f64 = 0.1;

/// One level with its statistics.
pub(super) struct SolvedLevel {
    pub(super) control: LevelControl,
    pub(super) level: Level,
    /// Of the quotient F/N of each window.
    statistics: FrictionStatistics,
    /// μ̄ = ΣF/ΣN.
    pub(super) mean: f64,
    /// Windows at the mean load.
    at_mean_load: Vec<Record>,
    /// Of the windows at the mean load.
    pub(super) process: FrictionStatistics,
    /// Absent where friction does not vary.
    pub(super) window_study: Option<WindowStudy>,
}

impl SolvedLevel {
    fn new(
        control: LevelControl,
        level: Level,
        window: &Window,
        periodic: bool,
        seed: u64,
    ) -> Result<Self, StudyError> {
        let failed = |error| StudyError::Friction { level: control.name(), error };
        let statistics = FrictionStatistics::of(&level.records, window.step_m(), periodic, seed).map_err(failed)?;
        let (mean, at_mean_load) = Record::at_mean_load(&level.records);
        let process = FrictionStatistics::of(&at_mean_load, window.step_m(), periodic, seed).map_err(failed)?;
        // The study knows the correlation under rectangles.
        let own = window.is_rectangle().then(|| (window.clone(), at_mean_load.clone()));
        let narrower = level.narrower.iter().map(|(window, records)| (window.clone(), Record::at_mean_load(records).1));
        let windows: Vec<(Window, Vec<Record>)> = own.into_iter().chain(narrower).collect();
        let varies = process.moments.std > 0.0;
        let window_study = if varies { WindowStudy::of(&windows).ok() } else { None };
        Ok(Self { control, level, statistics, mean, at_mean_load, process, window_study })
    }

    /// Variance of μ over the nominal area over that of one window, by the correlation that is left without the window.
    pub(super) fn variance_reduction(&self, window: &Window, nominal_area_m2: f64) -> f64 {
        let length_m = self.window_study.as_ref().map_or(0.0, |study| study.length_m);
        // Windows of another shape count as rectangles of their area and width.
        let rectangle_m = window.area_m2() / window.width_m();
        variance_reduction(rectangle_m, window.width_m(), nominal_area_m2, &exponential(length_m))
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
        let grid = Grid::covering(nx, ny, section.strip[0].0, section.strip[1].0)
            .map_err(|error| StudyError::Grid { section: "friction", error })?;
        let compliance = section.mean_compliance.map(|c| c.0);
        let (half_space, mean_compliance_m_per_pa) =
            half_space("friction", grid, material, section.boundary, compliance)?;
        let window = match section.window_shape {
            WindowShape::Rectangle => Window::rectangle(section.window.0, section.window_width().0, grid)?,
            WindowShape::Ellipse => Window::ellipse(section.window.0, section.window_width().0, grid)?,
        };
        let (law, law_in_words) = friction_law(section, material)?;
        Ok(Self {
            grid,
            periodic: section.boundary == BoundaryChoice::Periodic,
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
    (model, surface): (&SurfaceModel, &SurfaceResult),
    lead: Lead,
    nominal_area_m2: Option<f64>,
    seed: u64,
    monitor: &dyn Monitor,
) -> Result<FrictionStage, StudyError> {
    let setup = Setup::new(section, material)?;
    let &Setup { grid, periodic, mean_compliance_m_per_pa, .. } = &setup;
    let generated = model.strip(grid, periodic)?;
    let strips = setup.strips(generated.surface.as_ref(), section.realisations, seed);
    let stated = LevelControl::of(section, lead);
    let controls: Vec<Control> = stated.iter().map(|level| level.contact(&model.marginal)).collect();
    let mut output = StageOutput { warnings: generated.warnings.clone(), ..StageOutput::default() };
    let mut levels = Vec::new();
    for (control, level) in stated.into_iter().zip(strips.solve(&controls, monitor)?) {
        let level = level.map_err(|error| StudyError::Friction { level: control.name(), error })?;
        let level = SolvedLevel::new(control, level, &setup.window, periodic, seed)?;
        output.warnings.extend(level_warnings(&level));
        levels.push(level);
    }
    let pressures: Vec<_> = levels.iter().map(|level| (level.control, level.level.mean_pressure_pa)).collect();
    let lead = lead.among(&pressures);
    let uncertain = friction_uncertainty::run(section, &setup, (model, surface), &levels, seed, monitor)?;
    let window = &setup.window;
    let mut result = FrictionResult {
        window_m: window.length_m(),
        window_width_m: window.width_m(),
        strip_width_m: grid.height_m(),
        mean_compliance_m_per_pa,
        realisations: section.realisations,
        levels: levels
            .iter()
            .enumerate()
            .map(|(index, level)| LevelResult {
                leading: index == lead,
                upscaling: nominal_area_m2.map(|area_m2| level.upscaling(window, area_m2)),
                ..level_result(level)
            })
            .collect(),
        uncertainty: None,
    };
    output.tables = vec![
        ("friction_levels", levels_table(&levels)),
        ("friction_load_curve", load_curve_table(&levels)),
        ("friction_trace", trace_table(&levels)),
    ];
    output.tables.extend(lead_tables(&levels[lead], window));
    if let Some(pressure_pa) = &levels[lead].level.sample_pressure_pa {
        output.fields.push(("pressure_strip", Field { grid, unit: "Pa", values: pressure_pa.clone() }));
    }
    output.assumptions = sentences(section, &strips, &setup.law_in_words, mean_compliance_m_per_pa, &levels[lead]);
    output.assumptions.extend(generated.correction.clone());
    if let Some((found, own)) = uncertain {
        output.extend(own);
        result.uncertainty = Some(found);
    }
    let solved = SolvedStrips { window: setup.window, levels, lead };
    Ok(FrictionStage { solved, result, output })
}

fn sentences(
    section: &FrictionSection,
    strips: &Strips<'_>,
    law: &str,
    mean_compliance_m_per_pa: Option<f64>,
    lead: &SolvedLevel,
) -> Vec<String> {
    let boundary = match mean_compliance_m_per_pa {
        None => "free, windows nearer to an end than the strip is wide left out".to_owned(),
        Some(m_per_pa) => {
            format!("periodic, of mean compliance {} under a fixed plane", sentence::compliance(m_per_pa))
        }
    };
    let window = strips.window;
    let name = lead.control.name();
    let correlation = match &lead.window_study {
        None => format!("At {name} friction does not vary, so it has no correlation."),
        Some(study) => format!(
            "A moving window correlates neighbouring values by itself, so a correlation length is only stated with its \
             window. Windows of {} together leave a length of {} (95 %: {} to {}) at {name}{}.",
            study.windows.iter().map(|seen| sentence::si(seen.window_m, "m")).collect::<Vec<_>>().join(", "),
            sentence::si(study.length_m, "m"),
            sentence::si(study.interval.low, "m"),
            sentence::si(study.interval.high, "m"),
            if study.window_only() { ": the correlation is the window's alone" } else { " beside the window's" }
        ),
    };
    let shape = match section.window_shape {
        WindowShape::Rectangle => "a window",
        WindowShape::Ellipse => "an elliptic window",
    };
    let width = match lead.level.lanes {
        1 if window.width_m() > strips.half_space.grid().height_m() * (1.0 - 1e-9) => {
            "the width of the strip".to_owned()
        }
        1 => sentence::si(window.width_m(), "m"),
        lanes => format!("{}, {lanes} side by side", sentence::si(window.width_m(), "m")),
    };
    let mut sentences = vec![
        format!(
            "{law}, over {shape} of {} × {width}, moved by {}.",
            sentence::si(window.length_m(), "m"),
            sentence::si(window.step_m(), "m"),
        ),
        format!(
            "{} strips of {} ({boundary}) were solved, the same at every level. They hold all Fourier modes of their grid, \
             since a truncated expansion cannot hold the variance of a long strip.",
            strips.realisations,
            sentence::size(section.strip[0].0, section.strip[1].0),
        ),
        "Levels are described by the quotient F/N of each window; the law and the correlation of the leading level are drawn \
         at the mean load, μ̄ + (F − μ̄N)/N̄, where a window counts by the load it carries."
            .into(),
        correlation,
    ];
    if !section.penetrations.is_empty() {
        sentences.push(
            "A percentile is of the ensemble: one plane in space, to which strips are pressed more or less. A penetration is \
             counted from the highest point of each strip, so that the plane differs from strip to strip."
                .into(),
        );
    }
    sentences
}

fn level_warnings(solved: &SolvedLevel) -> Vec<String> {
    let (name, statistics) = (solved.control.name(), &solved.statistics);
    let mut warnings = Vec::new();
    if statistics.contact_cells < WANTED_CONTACT_CELLS || statistics.sparse_share > SPARSE_SHARE {
        warnings.push(format!(
            "at {name}, {} % of the windows hold fewer than {WANTED_CONTACT_CELLS} contact cells ({} on average): the grid is \
             too coarse or the window too short for that load, and the scatter of F/N is partly the grid's",
            sentence::digits(100.0 * statistics.sparse_share),
            sentence::digits(statistics.contact_cells)
        ));
    }
    if statistics.empty_windows > 0 {
        let windows = sentence::count(statistics.empty_windows, "window carries", "windows carry");
        warnings.push(format!("at {name}, {windows} no load, and F/N leaves them out"));
    }
    if !solved.level.failures.is_empty() {
        let strips = sentence::count(solved.level.failures.len(), "strip", "strips");
        warnings.push(format!("at {name}, {strips} did not converge and were left out"));
    }
    warnings
}

fn level_result(solved: &SolvedLevel) -> LevelResult {
    let (level, statistics) = (&solved.level, &solved.statistics);
    let correlation = statistics.correlation.as_ref().ok();
    let study = solved.window_study.as_ref();
    let process = &solved.process;
    LevelResult {
        leading: false,
        control: solved.control.key(),
        percentile: solved.control.percentile(),
        penetration_m: level.penetration_m,
        mean_pressure_pa: level.mean_pressure_pa,
        contact_fraction: level.contact_fraction,
        plastic_share: level.plastic_share,
        mean: statistics.moments.mean,
        mean_interval: interval(statistics.estimates.mean),
        std: statistics.moments.std,
        std_interval: interval(statistics.estimates.std),
        coefficient_of_variation: statistics.moments.coefficient_of_variation(),
        coefficient_of_variation_interval: interval(statistics.estimates.coefficient_of_variation),
        skewness: finite(statistics.moments.skewness),
        skewness_interval: interval(statistics.estimates.skewness),
        excess_kurtosis: finite(statistics.moments.excess_kurtosis),
        excess_kurtosis_interval: interval(statistics.estimates.excess_kurtosis),
        correlation_length_m: correlation.map(|c| c.exponential.length_m),
        correlation_length_without_window_m: study.map(|s| s.length_m),
        correlation_length_without_window_interval: study.map(|s| pair(s.interval)),
        window_only: study.map(WindowStudy::window_only),
        marginal: statistics.marginal().map(|fit| law_result(&fit.law)),
        marginal_parameter_intervals: parameter_intervals(statistics),
        gof: goodness(statistics),
        return_levels: statistics
            .tail
            .as_ref()
            .map_or_else(Vec::new, |tail| tail.return_levels.iter().map(return_level).collect()),
        beta: statistics.beta.as_ref().map(|fit| law_result(&fit.law)),
        at_mean_load: AtMeanLoad {
            mean: solved.mean,
            std: process.moments.std,
            std_interval: interval(process.estimates.std),
            skewness: finite(process.moments.skewness),
            excess_kurtosis: finite(process.moments.excess_kurtosis),
            correlation_length_m: process.correlation.as_ref().ok().map(|c| c.exponential.length_m),
            marginal: process.marginal().map(|fit| law_result(&fit.law)),
            marginal_parameter_intervals: parameter_intervals(process),
            gof: goodness(process),
            effective_windows: process.effective_windows,
        },
        upscaling: None,
        empty_windows: statistics.empty_windows,
        contact_cells_per_window: statistics.contact_cells,
        sparse_window_share: statistics.sparse_share,
        effective_windows: statistics.effective_windows,
        failed_samples: level.failures.len(),
    }
}

fn interval(estimate: Option<Estimate>) -> Option<Pair> {
    estimate.map(|estimate| pair(estimate.interval))
}

/// Of the parameters of the marginal law; `null` where there is none.
fn parameter_intervals(statistics: &FrictionStatistics) -> BTreeMap<String, Option<Pair>> {
    let parameters = statistics.marginal_place().map_or(&[][..], |place| &statistics.parameters[place]);
    parameters.iter().map(|p| (p.name.to_owned(), interval(p.estimate))).collect()
}

fn goodness(statistics: &FrictionStatistics) -> Option<GoodnessResult> {
    let found = statistics.marginals.goodness.get(statistics.marginal_place()?)?;
    Some(GoodnessResult {
        kolmogorov_smirnov: found.kolmogorov_smirnov.statistic,
        kolmogorov_smirnov_p: found.kolmogorov_smirnov.p_value,
        anderson_darling: found.anderson_darling.map(|distance| distance.statistic),
        anderson_darling_p: found.anderson_darling.map(|distance| distance.p_value),
    })
}

fn return_level(level: &ReturnLevel) -> ReturnLevelResult {
    ReturnLevelResult { distance_m: level.distance_m, mu: level.mu, interval: level.interval.map(pair) }
}

fn levels_table(levels: &[SolvedLevel]) -> Table {
    let column = |value: &dyn Fn(&SolvedLevel) -> f64| levels.iter().map(value).collect::<Vec<f64>>();
    Table::new([
        ("percentile", column(&|l| l.control.percentile().unwrap_or(f64::NAN))),
        ("penetration_m", column(&|l| l.level.penetration_m)),
        ("mean_pressure_pa", column(&|l| l.level.mean_pressure_pa)),
        ("mean", column(&|l| l.statistics.moments.mean)),
        ("mean_low", column(&|l| l.statistics.estimates.mean.map_or(f64::NAN, |e| e.interval.low))),
        ("mean_high", column(&|l| l.statistics.estimates.mean.map_or(f64::NAN, |e| e.interval.high))),
        ("std", column(&|l| l.statistics.moments.std)),
        ("std_low", column(&|l| l.statistics.estimates.std.map_or(f64::NAN, |e| e.interval.low))),
        ("std_high", column(&|l| l.statistics.estimates.std.map_or(f64::NAN, |e| e.interval.high))),
        ("coefficient_of_variation", column(&|l| l.statistics.moments.coefficient_of_variation())),
    ])
}

/// Load against depth, from the shallowest level.
fn load_curve_table(levels: &[SolvedLevel]) -> Table {
    let mut points: Vec<LoadPoint> = levels.iter().map(|level| LoadPoint::of(&level.level)).collect();
    points.sort_by(|a, b| a.penetration_m.total_cmp(&b.penetration_m));
    let column = |value: &dyn Fn(&LoadPoint) -> f64| points.iter().map(value).collect::<Vec<f64>>();
    Table::new([
        ("penetration_m", column(&|p| p.penetration_m)),
        ("mean_pressure_pa", column(&|p| p.mean_pressure_pa)),
        ("low", column(&|p| p.interval.low)),
        ("high", column(&|p| p.interval.high)),
        ("contact_fraction", column(&|p| p.contact_fraction)),
    ])
}

/// μ(s) of the first strip at every level.
fn trace_table(levels: &[SolvedLevel]) -> Table {
    let first = levels.iter().filter_map(|level| level.level.records.first()).next();
    let mut columns = vec![("position_m".to_owned(), first.map_or_else(Vec::new, |record| record.position_m.clone()))];
    let rows = columns[0].1.len();
    for level in levels {
        let trace = level.level.records.first().filter(|record| record.friction.len() == rows);
        columns.push((
            level.control.column(),
            trace.map_or_else(|| vec![f64::NAN; rows], |record| record.friction.clone()),
        ));
    }
    Table::new(columns)
}

/// Law, correlation and window study of the leading level, at the mean load.
fn lead_tables(lead: &SolvedLevel, window: &Window) -> Vec<(&'static str, Table)> {
    let mut tables = Vec::new();
    let process = &lead.process;
    let pooled: Vec<f64> = lead.at_mean_load.iter().flat_map(|record| record.friction.iter().copied()).collect();
    // Values that are all equal have no histogram.
    if let Ok(histogram) = Histogram::of(&pooled) {
        let centres = histogram.centres();
        let density = |law: Option<&Marginal>| -> Vec<f64> {
            centres.iter().map(|mu| law.map_or(f64::NAN, |law| law.pdf(*mu))).collect()
        };
        let beta = density(process.beta.as_ref().map(|fit| &fit.law));
        let best = density(process.marginal().map(|fit| &fit.law));
        tables.push((
            "friction_histogram",
            Table::new([
                ("density", histogram.density()),
                ("beta_density", beta),
                ("fitted_density", best),
                ("mu", centres),
            ])
            .led_by("mu"),
        ));
    }
    if let Ok(correlation) = &process.correlation {
        let estimate = &correlation.estimate;
        let lags: Vec<f64> = (0..estimate.correlation.len()).map(|k| k as f64 * estimate.step_m).collect();
        let under_window = |length_m: f64| -> Vec<f64> {
            lags.iter().map(|lag| windowed_exponential(*lag, window.length_m(), length_m)).collect()
        };
        let exponential = correlation.exponential;
        let mut columns = vec![
            ("acf", estimate.correlation.clone()),
            ("fit", lags.iter().map(|lag| exponential.model.correlation(*lag, exponential.length_m)).collect()),
            ("window_only", under_window(0.0)),
        ];
        columns.extend(lead.window_study.as_ref().map(|study| ("windowed_fit", under_window(study.length_m))));
        columns.push(("lag_m", lags));
        tables.push(("friction_acf", Table::new(columns).led_by("lag_m")));
    }
    if let Some(study) = &lead.window_study {
        let column = |value: &dyn Fn(&WindowCorrelation) -> f64| study.windows.iter().map(value).collect::<Vec<f64>>();
        tables.push((
            "friction_windows",
            Table::new([
                ("window_m", column(&|seen| seen.window_m)),
                ("std", column(&|seen| seen.std)),
                ("correlation_length_m", column(&|seen| seen.length_m)),
            ]),
        ));
    }
    tables
}
