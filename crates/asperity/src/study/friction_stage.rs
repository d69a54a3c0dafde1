//! Friction of solved strips at several levels of contact.

use std::collections::BTreeMap;

use crate::contact::{Control, Solver};
use crate::correlation::windowed_exponential;
use crate::friction::bowden_tabor::BowdenTabor;
use crate::friction::statistics::{FrictionStatistics, ReturnLevel, WANTED_CONTACT_CELLS};
use crate::friction::strip::{Level, Record, Strips};
use crate::friction::window::Window;
use crate::friction::window_study::{WindowCorrelation, WindowStudy};
use crate::law::Marginal;
use crate::map::Grid;
use crate::monitor::Monitor;
use crate::stats::{Estimate, Histogram};
use crate::study::config::{BoundaryChoice, FrictionSection, MaterialSection};
use crate::study::output::StageOutput;
use crate::study::pressure_stage::{half_space, plane};
use crate::study::result::{
    AtMeanLoad, FrictionResult, GoodnessResult, LevelResult, Pair, ReturnLevelResult, finite, pair,
};
use crate::study::surface_model::SurfaceModel;
use crate::study::surface_stage::law_result;
use crate::study::{Field, StudyError, Table, sentence};

/// Share of windows with too few contact cells above which a level is warned about.
const SPARSE_SHARE: f64 = 0.1;

/// One level with its statistics.
pub(super) struct SolvedLevel {
    pub(super) percentile: Option<f64>,
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
        percentile: Option<f64>,
        level: Level,
        window: Window,
        periodic: bool,
        seed: u64,
    ) -> Result<Self, StudyError> {
        let failed = |error| StudyError::Friction { level: name_of(percentile), error };
        let statistics = FrictionStatistics::of(&level.records, window.step_m(), periodic, seed).map_err(failed)?;
        let (mean, at_mean_load) = Record::at_mean_load(&level.records);
        let process = FrictionStatistics::of(&at_mean_load, window.step_m(), periodic, seed).map_err(failed)?;
        let mut windows = vec![(window, at_mean_load.clone())];
        windows.extend(level.narrower.iter().map(|(window, records)| (*window, Record::at_mean_load(records).1)));
        let varies = process.moments.std > 0.0;
        let window_study = if varies { WindowStudy::of(&windows).ok() } else { None };
        Ok(Self { percentile, level, statistics, mean, at_mean_load, process, window_study })
    }
}

/// A level in words.
fn name_of(percentile: Option<f64>) -> String {
    percentile.map_or_else(|| "the nominal pressure".to_owned(), |p| format!("percentile {p}"))
}

/// Every level, and the windows that it was seen through.
pub(super) struct SolvedStrips {
    pub(super) window_m: f64,
    pub(super) strip_width_m: f64,
    pub(super) levels: Vec<SolvedLevel>,
}

/// What the friction stage hands on.
pub(super) struct FrictionStage {
    pub(super) solved: SolvedStrips,
    pub(super) result: FrictionResult,
    pub(super) output: StageOutput,
}

/// Which level leads: is shown in full, and handed to the vibration stage.
#[derive(Debug, Clone, Copy)]
pub(super) enum Lead {
    /// The deepest percentile: there is no vibration stage.
    Deepest,
    /// The percentile that the study names.
    Percentile(f64),
    /// One more level, at this mean pressure in pascal.
    NominalPressure(f64),
}

/// Solves the strips at the percentiles of the section and, where it leads, at the nominal pressure.
pub(super) fn run(
    section: &FrictionSection,
    material: &MaterialSection,
    model: &SurfaceModel,
    lead: Lead,
    seed: u64,
    monitor: &dyn Monitor,
) -> Result<FrictionStage, StudyError> {
    let [nx, ny] = section.points;
    let grid = Grid::covering(nx, ny, section.strip[0].0, section.strip[1].0)
        .map_err(|error| StudyError::Grid { section: "friction", error })?;
    let periodic = section.boundary == BoundaryChoice::Periodic;
    let compliance = section.mean_compliance.map(|c| c.0);
    let (half_space, mean_compliance_m_per_pa) = half_space("friction", grid, material, section.boundary, compliance)?;
    let window = Window::new(section.window.0, grid)?;
    let generated = model.strip(grid, periodic)?;
    let friction = BowdenTabor {
        shear_strength_pa: material.shear_strength.ok_or(StudyError::NoStage("material"))?.0,
        hardness_pa: material.hardness.map(|h| h.0),
    };
    let strips = Strips {
        surface: generated.surface.as_ref(),
        half_space: &half_space,
        window,
        friction,
        solver: Solver { tolerance: section.tolerance, ..Solver::default() },
        realisations: section.realisations,
        seed,
    };
    let mut names: Vec<Option<f64>> = section.percentiles.iter().copied().map(Some).collect();
    let mut controls: Vec<Control> = section.percentiles.iter().map(|p| plane(&model.marginal, *p)).collect();
    if let Lead::NominalPressure(pascal) = lead {
        names.push(None);
        controls.push(Control::MeanPressure { pascal });
    }
    let mut output = StageOutput { warnings: generated.warnings.clone(), ..StageOutput::default() };
    let mut levels = Vec::new();
    for (percentile, level) in names.into_iter().zip(strips.solve(&controls, monitor)?) {
        let level = level.map_err(|error| StudyError::Friction { level: name_of(percentile), error })?;
        let level = SolvedLevel::new(percentile, level, window, periodic, seed)?;
        output.warnings.extend(level_warnings(&level));
        levels.push(level);
    }
    let lead = leading(&levels, lead);
    let result = FrictionResult {
        window_m: window.length_m(),
        strip_width_m: grid.height_m(),
        mean_compliance_m_per_pa,
        realisations: section.realisations,
        levels: levels.iter().enumerate().map(|(index, level)| level_result(level, index == lead)).collect(),
    };
    output.tables = vec![("friction_levels", levels_table(&levels)), ("friction_trace", trace_table(&levels))];
    output.tables.extend(lead_tables(&levels[lead], window));
    if let Some(pressure_pa) = &levels[lead].level.sample_pressure_pa {
        output.fields.push(("pressure_strip", Field { grid, unit: "Pa", values: pressure_pa.clone() }));
    }
    output.assumptions = sentences(section, &strips, mean_compliance_m_per_pa, &levels[lead]);
    output.assumptions.extend(generated.correction.clone());
    let solved = SolvedStrips { window_m: window.length_m(), strip_width_m: grid.height_m(), levels };
    Ok(FrictionStage { solved, result, output })
}

/// Index of the level that leads.
fn leading(levels: &[SolvedLevel], lead: Lead) -> usize {
    let deepest = || {
        let depth = |index: &usize| levels[*index].percentile.unwrap_or(0.0);
        (0..levels.len()).max_by(|a, b| depth(a).total_cmp(&depth(b)))
    };
    let wanted = match lead {
        Lead::Deepest => None,
        Lead::Percentile(percentile) => levels.iter().position(|level| level.percentile == Some(percentile)),
        Lead::NominalPressure(_) => levels.iter().position(|level| level.percentile.is_none()),
    };
    wanted.or_else(deepest).unwrap_or(0)
}

fn sentences(
    section: &FrictionSection,
    strips: &Strips<'_>,
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
    let window_m = sentence::si(window.length_m(), "m");
    let name = name_of(lead.percentile);
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
    vec![
        format!(
            "Friction is shear-dominated, μ = τ_max A_c/N with τ_max = {} and the contact area A_c corrected for its \
             perimeter, over a window of {window_m} × the width of the strip, moved by {}.",
            sentence::si(strips.friction.shear_strength_pa, "Pa"),
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
    ]
}

fn level_warnings(solved: &SolvedLevel) -> Vec<String> {
    let (name, statistics) = (name_of(solved.percentile), &solved.statistics);
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

fn level_result(solved: &SolvedLevel, leading: bool) -> LevelResult {
    let (level, statistics) = (&solved.level, &solved.statistics);
    let correlation = statistics.correlation.as_ref().ok();
    let study = solved.window_study.as_ref();
    let process = &solved.process;
    LevelResult {
        leading,
        percentile: solved.percentile,
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
        ("percentile", column(&|l| l.percentile.unwrap_or(f64::NAN))),
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

/// μ(s) of the first strip at every level.
fn trace_table(levels: &[SolvedLevel]) -> Table {
    let first = levels.iter().filter_map(|level| level.level.records.first()).next();
    let mut columns = vec![("position_m".to_owned(), first.map_or_else(Vec::new, |record| record.position_m.clone()))];
    let rows = columns[0].1.len();
    for level in levels {
        let name = match level.percentile {
            Some(percentile) => format!("mu_p{percentile}").replace('.', "_"),
            None => "mu_load".into(),
        };
        let trace = level.level.records.first().filter(|record| record.friction.len() == rows);
        columns.push((name, trace.map_or_else(|| vec![f64::NAN; rows], |record| record.friction.clone())));
    }
    Table::new(columns)
}

/// Law, correlation and window study of the leading level, at the mean load.
fn lead_tables(lead: &SolvedLevel, window: Window) -> Vec<(&'static str, Table)> {
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
