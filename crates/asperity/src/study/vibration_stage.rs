//! Stick-slip of a mass on a belt under the friction process.

use crate::friction::process::{FrictionProcess, ProcessModel, Steady};
use crate::friction::record::FrictionStatistics;
use crate::friction::strip::Record;
use crate::friction::upscaling::variance_reduction;
use crate::law::Marginal;
use crate::monitor::Monitor;
use crate::stats::{Histogram, NORMAL_95};
use crate::study::config::{FrictionSection, Upscaling, VibrationSection};
use crate::study::friction_stage::{FrictionStage, SolvedLevel};
use crate::study::result::{CycleResult, DampingResult, EnsembleResult, ReattachmentResult, VibrationResult};
use crate::study::surface_stage::law_result;
use crate::study::{StudyError, Table};
use crate::vibration::{
    Drive, Ensemble, EnsembleSettings, Oscillator, Scales, TrajectorySettings, VibrationError, critical_damping,
    cycle_portrait, limit_cycle, trajectory_portrait,
};

/// Points of a plotted limit cycle and trajectory, and the length τ of the latter.
const CYCLE_POINTS: usize = 600;
const TRAJECTORY_POINTS: usize = 6000;
const TRAJECTORY_SPAN: f64 = 120.0;
/// Scatter of μ below which friction counts as constant.
const NO_SCATTER: f64 = 1e-12;

/// The friction of one window as a process.
struct WindowFriction {
    mean: f64,
    std: f64,
    length_m: f64,
    marginal: Marginal,
    level_percentile: Option<f64>,
    level_mean_pressure_pa: Option<f64>,
    variance_reduction: f64,
    origin: String,
}

/// Windows above which their mean counts as normal, whatever the law of one.
const MANY_WINDOWS: f64 = 30.0;

impl WindowFriction {
    /// Law of the mean over the nominal area: normal where that holds many windows, by the central limit theorem.
    fn area_marginal(&self) -> Marginal {
        if self.variance_reduction * MANY_WINDOWS < 1.0 { Marginal::STANDARD_NORMAL } else { self.marginal.clone() }
    }
}

/// The fluctuation of friction under one upscaling.
struct Scatter {
    name: &'static str,
    std: f64,
    marginal: Marginal,
}

/// What the vibration stage hands on.
pub(super) struct VibrationStage {
    pub(super) result: VibrationResult,
    pub(super) tables: Vec<(&'static str, Table)>,
    pub(super) assumptions: Vec<String>,
    pub(super) warnings: Vec<String>,
}

pub(super) fn run(
    section: &VibrationSection,
    friction: Option<&FrictionStage>,
    seed: u64,
    monitor: &dyn Monitor,
) -> Result<VibrationStage, StudyError> {
    let scales = Scales::new(section.mass.0, section.natural_frequency.0, section.normal_force.0)?;
    let belt_velocity = match (section.belt_velocity, section.dimensionless_belt_velocity) {
        (Some(velocity), _) => velocity.0 / scales.velocity_m_per_s(),
        (None, value) => value.unwrap_or(f64::NAN),
    };
    let window = match friction {
        Some(stage) => from_stage(section, stage, seed)?,
        None => stated(section)?,
    };
    let oscillator = Oscillator::stribeck(window.mean, section.stribeck, section.damping_ratio, belt_velocity)?;
    let correlation_length = window.length_m / scales.length_m();
    let ensembles = Ensembles { section, oscillator, window: &window, correlation_length, seed };
    let mut warnings = Vec::new();
    let paper_scatter = Scatter { name: "paper", std: window.std, marginal: window.marginal.clone() };
    let area_std = window.std * window.variance_reduction.sqrt();
    let area_scatter = Scatter { name: "area", std: area_std, marginal: window.area_marginal() };
    let (paper, paper_lead) = ensembles.run(&paper_scatter, monitor, &mut warnings)?;
    let (area, area_lead) = ensembles.run(&area_scatter, monitor, &mut warnings)?;
    let critical = match critical_damping(&oscillator) {
        Ok(found) => Some(found),
        Err(VibrationError::NotFound { .. }) => None,
        Err(error) => return Err(error.into()),
    };
    let lead = match section.upscaling {
        Upscaling::Area => &area_scatter,
        Upscaling::Paper => &paper_scatter,
    };
    let mut tables = vec![("cycles_over_damping", damping_table(&paper, &area))];
    tables.extend(ensembles.portraits(lead)?);
    for (name, lead) in [("reattachment_paper", &paper_lead), ("reattachment_area", &area_lead)] {
        if let Some(table) = lead.as_ref().and_then(reattachment_table) {
            tables.push((name, table));
        }
    }
    let assumptions = vec![ensembles.sentence(belt_velocity, correlation_length, area_std)];
    let result = VibrationResult {
        damping_ratio: section.damping_ratio,
        belt_velocity,
        static_friction: window.mean,
        level_percentile: window.level_percentile,
        level_mean_pressure_pa: window.level_mean_pressure_pa,
        friction_correlation_length_m: window.length_m,
        correlation_length,
        marginal: law_result(&window.marginal),
        variance_reduction: window.variance_reduction,
        critical_damping_ratio: critical.map(|c| c.critical_damping_ratio),
        hopf_damping_ratio: critical.map(|c| c.hopf_damping_ratio),
        cycle: cycle_result(&oscillator)?,
        upscaling: lead.name.into(),
        paper,
        area,
    };
    Ok(VibrationStage { result, tables, assumptions, warnings })
}

/// The friction of the level that the study names, or of the one at the nominal pressure.
fn from_stage(section: &VibrationSection, stage: &FrictionStage, seed: u64) -> Result<WindowFriction, StudyError> {
    let solved: &SolvedLevel =
        stage.levels.iter().find(|level| level.percentile == section.level).ok_or(StudyError::NoStage("friction"))?;
    let (mean, records) = Record::at_mean_load(&solved.level.records);
    let statistics = FrictionStatistics::of(&records, stage.window_m, stage.step_m, seed)?;
    let std = statistics.moments.std;
    // Constant friction has no correlation and no law; any will do, since nothing is drawn.
    let correlation = statistics.correlation.as_ref().ok();
    let length_m = correlation.map_or(stage.window_m, |c| c.exponential.length_m);
    let without_window_m = correlation.map_or(0.0, |c| c.windowed.length_m);
    let marginal = statistics.marginal().map_or(Marginal::STANDARD_NORMAL, |fit| fit.law.clone());
    let origin = solved.percentile.map_or_else(
        || format!("at the mean pressure {:.3e} Pa of the nominal area", solved.level.mean_pressure_pa),
        |percentile| format!("at percentile {percentile}"),
    );
    Ok(WindowFriction {
        mean,
        std,
        length_m,
        marginal,
        level_percentile: solved.percentile,
        level_mean_pressure_pa: Some(solved.level.mean_pressure_pa),
        variance_reduction: variance_reduction(
            stage.window_m,
            stage.strip_width_m,
            without_window_m,
            section.nominal_area.0,
        ),
        origin,
    })
}

/// The friction that the study states, of a window of the customary size.
fn stated(section: &VibrationSection) -> Result<WindowFriction, StudyError> {
    let usual = FrictionSection::default();
    let length_m = section.friction_correlation_length.map_or(f64::NAN, |length| length.0);
    let (window_m, width_m) = (usual.window.0, usual.strip[1].0);
    Ok(WindowFriction {
        mean: section.static_friction.unwrap_or(f64::NAN),
        std: section.friction_std.unwrap_or(f64::NAN),
        length_m,
        marginal: section.friction_marginal.as_deref().unwrap_or("normal").parse()?,
        level_percentile: None,
        level_mean_pressure_pa: None,
        variance_reduction: variance_reduction(window_m, width_m, length_m, section.nominal_area.0),
        origin: format!("stated, of a window of {window_m:.3e} m × {width_m:.3e} m"),
    })
}

/// The ensembles of one study.
struct Ensembles<'a> {
    section: &'a VibrationSection,
    oscillator: Oscillator,
    window: &'a WindowFriction,
    correlation_length: f64,
    seed: u64,
}

impl Ensembles<'_> {
    /// The process of a scatter; `None` where friction is constant.
    fn process(&self, scatter: &Scatter) -> Result<Option<FrictionProcess>, StudyError> {
        if scatter.std < NO_SCATTER {
            return Ok(None);
        }
        let mut model = ProcessModel::new(scatter.marginal.clone(), scatter.std, self.correlation_length);
        model.least = Some(self.least());
        Ok(Some(FrictionProcess::new(model)?))
    }

    /// Least fluctuation that leaves the kinetic coefficient positive at the fastest slip to be expected: displacements
    /// scale with μ_st, so |v_rel| hardly exceeds V + μ_st.
    fn least(&self) -> f64 {
        let fastest = self.oscillator.belt_velocity() + self.window.mean;
        -0.9 * self.window.mean / (1.0 + self.section.stribeck * fastest)
    }

    fn settings(&self) -> EnsembleSettings {
        EnsembleSettings::new(self.section.trajectories, self.section.duration, self.seed)
    }

    fn followed(&self) -> TrajectorySettings {
        TrajectorySettings { duration: self.section.duration, start: None, drive: Drive::default() }
    }

    /// Ensembles over the sweep, and the one at the study's own damping ratio.
    fn run(
        &self,
        scatter: &Scatter,
        monitor: &dyn Monitor,
        warnings: &mut Vec<String>,
    ) -> Result<(EnsembleResult, Option<Ensemble>), StudyError> {
        let (from, to, count) = self.section.damping_sweep;
        let ratios = (0..count).map(|k| from + (to - from) * k as f64 / (count - 1) as f64);
        let name = scatter.name;
        let Some(process) = self.process(scatter)? else {
            return Ok((self.without_scatter(scatter.std, ratios)?, None));
        };
        let mut damping = Vec::with_capacity(count);
        let mut clamped = 0;
        let task = format!("vibration ({name})");
        for (done, damping_ratio) in ratios.enumerate() {
            monitor.progress(&task, done, count + 1);
            let oscillator = self.oscillator.with_damping(damping_ratio)?;
            let ensemble = Ensemble::simulate(&oscillator, &process, &self.settings(), &Quiet(monitor))?;
            clamped += ensemble.clamped_knots;
            damping.push(damping_result(damping_ratio, &ensemble));
        }
        monitor.progress(&task, count, count + 1);
        let lead = Ensemble::simulate(&self.oscillator, &process, &self.settings(), &Quiet(monitor))?;
        monitor.progress(&task, count + 1, count + 1);
        if clamped > 0 {
            warnings.push(format!(
                "with the {name} upscaling {clamped} values of the friction process were raised to {:.4} below the mean, so \
                 that friction stays positive",
                -self.least()
            ));
        }
        let points = &lead.reattachments;
        let reattachment = ReattachmentResult {
            count: points.count,
            mean: finite(points.mean),
            std: finite(points.std),
            skewness: finite(points.skewness),
            excess_kurtosis: finite(points.excess_kurtosis),
            normality_p: points.normality_p,
        };
        Ok((EnsembleResult { friction_std: scatter.std, damping, reattachment }, Some(lead)))
    }

    /// The same of constant friction: every trajectory is the deterministic one.
    fn without_scatter(&self, std: f64, ratios: impl Iterator<Item = f64>) -> Result<EnsembleResult, StudyError> {
        let mut damping = Vec::new();
        for damping_ratio in ratios {
            let oscillator = self.oscillator.with_damping(damping_ratio)?;
            let settings = self.followed();
            let cycles = crate::vibration::Trajectory::simulate(&oscillator, Steady, &settings)?.slips.cycles;
            damping.push(DampingResult {
                damping_ratio,
                cycles_deterministic: cycles,
                cycles_mean: cycles as f64,
                cycles_se: 0.0,
                difference_mean: 0.0,
                difference_interval: [0.0, 0.0],
                failed_samples: 0,
            });
        }
        Ok(EnsembleResult { friction_std: std, damping, reattachment: ReattachmentResult::default() })
    }

    /// The limit cycle, and the end of one trajectory, for a phase portrait.
    fn portraits(&self, scatter: &Scatter) -> Result<Vec<(&'static str, Table)>, StudyError> {
        let table = |points: Vec<crate::vibration::PhasePoint>| {
            Table::new([
                ("tau", points.iter().map(|p| p.tau).collect()),
                ("displacement", points.iter().map(|p| p.displacement).collect()),
                ("velocity", points.iter().map(|p| p.velocity).collect::<Vec<f64>>()),
            ])
        };
        let mut tables = Vec::new();
        if let Some(points) = cycle_portrait(&self.oscillator, CYCLE_POINTS)? {
            tables.push(("limit_cycle", table(points)));
        }
        if let Some(process) = self.process(scatter)? {
            let settings = self.followed();
            let from = (settings.duration - TRAJECTORY_SPAN).max(0.0);
            let path = process.path(self.seed, 0);
            let points = trajectory_portrait(&self.oscillator, path, &settings, from, TRAJECTORY_POINTS)?;
            tables.push(("trajectory", table(points)));
        }
        Ok(tables)
    }

    fn sentence(&self, belt_velocity: f64, correlation_length: f64, area_std: f64) -> String {
        format!(
            "The oscillator slides with μ_st/(1 + a|v|) + μ_s, a = {} per unit of dimensionless velocity, at V = \
             {belt_velocity:.4e}. Friction is {}: mean {:.4}, standard deviation {:.3e} for one window, correlation length \
             {:.3e} m (λ = {correlation_length:.3e}). Paper: one window carries the whole normal force. Area: windows \
             average over the nominal area of {}, whose scatter is {area_std:.3e} and normal where it holds many windows. Both \
             keep the same correlation length, over the sliding distance. Window values are taken at the mean load, \
             μ̄ + (F − μ̄N)/N̄. Cycles are slips that reach a negative velocity within τ = \
             {}, starting in stick.",
            self.section.stribeck,
            self.window.origin,
            self.window.mean,
            self.window.std,
            self.window.length_m,
            self.section.nominal_area,
            self.section.duration,
        )
    }
}

/// Hands cancellation on, and keeps the progress of inner loops to itself.
struct Quiet<'a>(&'a dyn Monitor);

impl Monitor for Quiet<'_> {
    fn progress(&self, _what: &str, _done: usize, _total: usize) {}

    fn cancelled(&self) -> bool {
        self.0.cancelled()
    }
}

fn finite(value: f64) -> Option<f64> {
    value.is_finite().then_some(value)
}

fn cycle_result(oscillator: &Oscillator) -> Result<CycleResult, StudyError> {
    let regime = limit_cycle(oscillator)?;
    let cycle = regime.cycle();
    Ok(CycleResult {
        damping_ratio: oscillator.damping_ratio(),
        limit_cycle: cycle.is_some(),
        period: cycle.map(|c| c.period),
        slip_duration: cycle.map(|c| c.slip_duration),
        reattachment_displacement: cycle.and_then(|c| c.reattachment_displacement),
        displacement_min: cycle.map(|c| c.displacement_min),
        displacement_max: cycle.map(|c| c.displacement_max),
        velocity_min: cycle.map(|c| c.velocity_min),
    })
}

fn damping_result(damping_ratio: f64, ensemble: &Ensemble) -> DampingResult {
    let half_width = NORMAL_95 * ensemble.cycles.se;
    DampingResult {
        damping_ratio,
        cycles_deterministic: ensemble.cycles_deterministic,
        cycles_mean: ensemble.cycles.mean,
        cycles_se: ensemble.cycles.se,
        difference_mean: ensemble.difference_mean,
        difference_interval: [ensemble.difference_mean - half_width, ensemble.difference_mean + half_width],
        failed_samples: ensemble.failures.len(),
    }
}

fn damping_table(paper: &EnsembleResult, area: &EnsembleResult) -> Table {
    let column = |result: &EnsembleResult, value: &dyn Fn(&DampingResult) -> f64| -> Vec<f64> {
        result.damping.iter().map(value).collect()
    };
    let mut columns = vec![
        ("damping_ratio".to_owned(), column(paper, &|d| d.damping_ratio)),
        ("cycles_deterministic".into(), column(paper, &|d| d.cycles_deterministic as f64)),
    ];
    for (name, result) in [("paper", paper), ("area", area)] {
        columns.push((format!("{name}_cycles_mean"), column(result, &|d| d.cycles_mean)));
        columns.push((format!("{name}_difference_mean"), column(result, &|d| d.difference_mean)));
        columns.push((format!("{name}_difference_low"), column(result, &|d| d.difference_interval[0])));
        columns.push((format!("{name}_difference_high"), column(result, &|d| d.difference_interval[1])));
    }
    Table::new(columns)
}

/// Histogram of the re-attachment points beside the normal density of equal mean and standard deviation.
fn reattachment_table(ensemble: &Ensemble) -> Option<Table> {
    let points = &ensemble.reattachments;
    let histogram = Histogram::of(&points.sample).ok()?;
    let normal = Marginal::normal(points.mean, points.std).ok()?;
    let centres = histogram.centres();
    Some(Table::new([
        ("normal_density", centres.iter().map(|x| normal.pdf(*x)).collect()),
        ("density", histogram.density()),
        ("displacement", centres),
    ]))
}
