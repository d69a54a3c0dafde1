//! Friction of solved strips at several levels of contact.

use crate::contact::{Control, Solver};
use crate::friction::bowden_tabor::BowdenTabor;
use crate::friction::record::FrictionStatistics;
use crate::friction::strip::{Level, Strips};
use crate::friction::window::Window;
use crate::law::Marginal;
use crate::map::Grid;
use crate::monitor::Monitor;
use crate::stats::Histogram;
use crate::study::config::{FrictionSection, MaterialSection};
use crate::study::pressure_stage::{half_space, plane};
use crate::study::result::{FrictionResult, LevelResult, pair};
use crate::study::surface_stage::{SurfaceModel, law_result};
use crate::study::{Field, StudyError, Table};

/// Contact cells that a window should hold for its area to mean something.
const WANTED_CONTACT_CELLS: f64 = 30.0;

/// One level with its statistics.
pub(super) struct SolvedLevel {
    pub(super) percentile: Option<f64>,
    pub(super) level: Level,
    pub(super) statistics: FrictionStatistics,
}

/// What the friction stage hands on.
pub(super) struct FrictionStage {
    pub(super) window_m: f64,
    pub(super) step_m: f64,
    pub(super) strip_width_m: f64,
    pub(super) levels: Vec<SolvedLevel>,
    pub(super) result: FrictionResult,
    pub(super) tables: Vec<(&'static str, Table)>,
    pub(super) fields: Vec<(&'static str, Field)>,
    pub(super) assumptions: Vec<String>,
    pub(super) warnings: Vec<String>,
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
    let periodic = section.boundary == crate::study::config::BoundaryChoice::Periodic;
    let compliance = section.mean_compliance.map(|c| c.0);
    let (half_space, mean_compliance_m_per_pa) = half_space("friction", grid, material, section.boundary, compliance)?;
    let window = Window::new(section.window.0, grid)?;
    let generated = model.strip(grid, periodic)?;
    let friction = BowdenTabor {
        shear_strength_pa: material.shear_strength.map_or(f64::NAN, |s| s.0),
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
    let mut warnings = generated.warnings.clone();
    let mut levels = Vec::new();
    for (percentile, level) in names.into_iter().zip(strips.solve(&controls, monitor)?) {
        let statistics = FrictionStatistics::of(&level.records, window.length_m(), window.step_m(), seed)?;
        warnings.extend(level_warnings(percentile, &statistics, &level));
        levels.push(SolvedLevel { percentile, level, statistics });
    }
    let lead = leading(&levels, lead);
    let result = FrictionResult {
        window_m: window.length_m(),
        strip_width_m: grid.height_m(),
        mean_compliance_m_per_pa,
        realisations: section.realisations,
        levels: levels.iter().enumerate().map(|(index, level)| level_result(level, index == lead)).collect(),
    };
    let lead = &levels[lead];
    let mut tables = vec![("friction_levels", levels_table(&levels)), ("friction_trace", trace_table(&levels))];
    tables.extend(lead_tables(lead)?);
    let pressure_strip = Field { grid, unit: "Pa", values: lead.level.sample_pressure_pa.clone() };
    let assumptions = vec![sentence(section, &strips, mean_compliance_m_per_pa)];
    Ok(FrictionStage {
        window_m: window.length_m(),
        step_m: window.step_m(),
        strip_width_m: grid.height_m(),
        levels,
        result,
        tables,
        fields: vec![("pressure_strip", pressure_strip)],
        assumptions,
        warnings,
    })
}

/// Index of the level that leads.
fn leading(levels: &[SolvedLevel], lead: Lead) -> usize {
    let wanted = match lead {
        Lead::Deepest => None,
        Lead::Percentile(percentile) => levels.iter().position(|level| level.percentile == Some(percentile)),
        Lead::NominalPressure(_) => levels.iter().position(|level| level.percentile.is_none()),
    };
    wanted.unwrap_or(levels.len() - 1)
}

fn sentence(section: &FrictionSection, strips: &Strips<'_>, mean_compliance_m_per_pa: Option<f64>) -> String {
    let boundary = match mean_compliance_m_per_pa {
        None => "free".to_owned(),
        Some(compliance) => format!("periodic, of mean compliance {compliance:.3e} m/Pa under a fixed plane"),
    };
    let window = strips.window;
    format!(
        "Friction is shear-dominated, μ = τ_max A_c/N with τ_max = {:.3e} Pa and the perimeter-corrected contact area, over \
         a window of {:.3e} m × the width of the strip ({}), moved along x by {:.3e} m. {} strips of {} ({boundary}) were \
         solved, the same at every level; they hold all Fourier modes of their grid. A moving window correlates \
         neighbouring values by itself: correlation lengths are stated with it.",
        strips.friction.shear_strength_pa,
        window.length_m(),
        section.strip[1],
        window.step_m(),
        strips.realisations,
        section.strip[0],
    )
}

fn level_warnings(percentile: Option<f64>, statistics: &FrictionStatistics, level: &Level) -> Vec<String> {
    let name = percentile.map_or_else(|| "the nominal pressure".to_owned(), |p| format!("percentile {p}"));
    let mut warnings = Vec::new();
    if percentile.is_none() && statistics.contact_cells < WANTED_CONTACT_CELLS {
        warnings.push(format!(
            "at {name}, a window holds {:.1} contact cells on average, fewer than {WANTED_CONTACT_CELLS}: the grid is too \
             coarse for that load, and the scatter of μ is partly the grid's",
            statistics.contact_cells
        ));
    }
    if statistics.empty_windows > 0 {
        let empty = statistics.empty_windows;
        warnings.push(format!("at {name}, {empty} windows carry no load and were left out"));
    }
    if !level.failures.is_empty() {
        warnings.push(format!("at {name}, {} strips did not converge and were left out", level.failures.len()));
    }
    warnings
}

fn level_result(solved: &SolvedLevel, leading: bool) -> LevelResult {
    let (level, statistics) = (&solved.level, &solved.statistics);
    let correlation = statistics.correlation.as_ref().ok();
    LevelResult {
        leading,
        percentile: solved.percentile,
        penetration_m: level.penetration_m,
        mean_pressure_pa: level.mean_pressure_pa,
        contact_fraction: level.contact_fraction,
        plastic_share: level.plastic_share,
        mean: statistics.moments.mean,
        mean_interval: pair(statistics.mean_interval),
        std: statistics.moments.std,
        std_interval: pair(statistics.std_interval),
        coefficient_of_variation: statistics.moments.coefficient_of_variation(),
        skewness: statistics.moments.skewness,
        excess_kurtosis: statistics.moments.excess_kurtosis,
        correlation_length_m: correlation.map(|c| c.exponential.length_m),
        correlation_length_without_window_m: correlation.map(|c| c.windowed.length_m),
        marginal: statistics.marginal().map(|fit| law_result(&fit.law)),
        beta: statistics.beta.as_ref().map(|fit| law_result(&fit.law)),
        empty_windows: statistics.empty_windows,
        contact_cells_per_window: statistics.contact_cells,
        effective_windows: statistics.effective_windows,
        failed_samples: level.failures.len(),
    }
}

fn levels_table(levels: &[SolvedLevel]) -> Table {
    let column = |value: &dyn Fn(&SolvedLevel) -> f64| levels.iter().map(value).collect::<Vec<f64>>();
    Table::new([
        ("percentile", column(&|l| l.percentile.unwrap_or(f64::NAN))),
        ("penetration_m", column(&|l| l.level.penetration_m)),
        ("mean_pressure_pa", column(&|l| l.level.mean_pressure_pa)),
        ("mean", column(&|l| l.statistics.moments.mean)),
        ("mean_low", column(&|l| l.statistics.mean_interval.low)),
        ("mean_high", column(&|l| l.statistics.mean_interval.high)),
        ("std", column(&|l| l.statistics.moments.std)),
        ("std_low", column(&|l| l.statistics.std_interval.low)),
        ("std_high", column(&|l| l.statistics.std_interval.high)),
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

/// Histogram and correlation of the leading level.
fn lead_tables(lead: &SolvedLevel) -> Result<Vec<(&'static str, Table)>, StudyError> {
    let mut tables = Vec::new();
    let pooled: Vec<f64> =
        lead.level.records.iter().flat_map(|r| r.friction.iter().copied()).filter(|mu| !mu.is_nan()).collect();
    if lead.statistics.moments.std > 0.0 {
        let histogram = Histogram::of(&pooled)?;
        let centres = histogram.centres();
        let density = |law: Option<&Marginal>| -> Vec<f64> {
            centres.iter().map(|mu| law.map_or(f64::NAN, |law| law.pdf(*mu))).collect()
        };
        let beta = lead.statistics.beta.as_ref().map(|fit| &fit.law);
        let best = lead.statistics.marginal().map(|fit| &fit.law);
        tables.push((
            "friction_histogram",
            Table::new([
                ("mu", centres.clone()),
                ("density", histogram.density()),
                ("beta_density", density(beta)),
                ("fitted_density", density(best)),
            ]),
        ));
    }
    if let Ok(correlation) = &lead.statistics.correlation {
        let estimate = &correlation.estimate;
        let lags: Vec<f64> = (0..estimate.correlation.len()).map(|k| k as f64 * estimate.step_m).collect();
        let window_m = match correlation.windowed.model {
            crate::correlation::RecordModel::WindowedExponential { window_m } => window_m,
            _ => f64::NAN,
        };
        let fit = |fit: &crate::correlation::RecordFit| -> Vec<f64> {
            lags.iter().map(|lag| fit.model.correlation(*lag, fit.length_m)).collect()
        };
        tables.push((
            "friction_acf",
            Table::new([
                ("acf", estimate.correlation.clone()),
                ("fit", fit(&correlation.exponential)),
                ("window_only", lags.iter().map(|lag| (1.0 - lag / window_m).max(0.0)).collect()),
                ("windowed_fit", fit(&correlation.windowed)),
                ("lag_m", lags),
            ]),
        ));
    }
    Ok(tables)
}
