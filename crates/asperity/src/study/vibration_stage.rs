//! Stick-slip of a mass on a belt under the friction process.

use crate::friction::process::{CorrelationShape, FrictionProcess, Generator, ProcessModel, Steady};
use crate::law::Marginal;
use crate::monitor::Monitor;
use crate::stats::Histogram;
use crate::study::config::{Upscaling, VibrationSection};
use crate::study::output::StageOutput;
use crate::study::result::{
    CrossingResult, CycleResult, DampingResult, EnsembleResult, MotionResult, PointsResult, VibrationResult, finite,
};
use crate::study::surface_stage::law_result;
use crate::study::window_friction::WindowFriction;
use crate::study::{StudyError, Table, sentence};
use crate::vibration::{
    Crossing, DampingSweep, Drive, Ensemble, EnsembleSettings, Method, Oscillator, PhasePoint, SampleLaw, Scales,
    Trajectory, TrajectorySettings, VibrationError, critical_damping, cycle_portrait, limit_cycle, trajectory_portrait,
};

/// Points of a plotted limit cycle and trajectory, and the length τ of the latter.
const CYCLE_POINTS: usize = 600;
const TRAJECTORY_POINTS: usize = 6000;
const TRAJECTORY_SPAN: f64 = 120.0;
/// Shares of the number of cycles whose damping ratios are told.
const SHARES: [f64; 3] = [0.95, 0.5, 0.05];
/// Slip speeds to be prepared for, over the expected ones.
const SPEEDS: [f64; 3] = [1.0, 5.0, 25.0];
/// Scatter of μ below which friction counts as constant.
const NO_SCATTER: f64 = 1e-12;

/// The fluctuation of friction under one upscaling.
struct Scatter {
    name: &'static str,
    std: f64,
    marginal: Marginal,
}

/// What the vibration stage hands on.
pub(super) struct VibrationStage {
    pub(super) result: VibrationResult,
    pub(super) output: StageOutput,
}

/// The units of the machine.
pub(super) fn scales(section: &VibrationSection) -> Result<Scales, StudyError> {
    Ok(Scales::new(section.mass.0, section.natural_frequency.0, section.normal_force.0)?)
}

pub(super) fn run(
    section: &VibrationSection,
    window: &WindowFriction,
    seed: u64,
    monitor: &dyn Monitor,
) -> Result<VibrationStage, StudyError> {
    let scales = scales(section)?;
    let belt_velocity = match (section.belt_velocity, section.dimensionless_belt_velocity) {
        (Some(velocity), _) => velocity.0 / scales.velocity_m_per_s(),
        (None, Some(value)) => value,
        (None, None) => return Err(StudyError::NoStage("vibration")),
    };
    let oscillator = Oscillator::stribeck(window.mean, window.stribeck, section.damping_ratio, belt_velocity)?;
    let correlation_length = window.length_m / scales.length_m();
    let shape = window.shape.in_unit(scales.length_m());
    let ensembles = Ensembles { section, oscillator: oscillator.clone(), window, shape, correlation_length, seed };
    let mut warnings = window.warnings.clone();
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
    let assumptions = ensembles.sentences(area_std);
    let result = VibrationResult {
        damping_ratio: section.damping_ratio,
        belt_velocity,
        static_friction: window.mean,
        level_percentile: window.level_percentile,
        level_mean_pressure_pa: window.level_mean_pressure_pa,
        friction_correlation_length_m: window.length_m,
        correlation_length,
        marginal: (window.std >= NO_SCATTER).then(|| law_result(&window.marginal)),
        variance_reduction: window.variance_reduction,
        critical_damping_ratio: critical.map(|c| c.critical_damping_ratio),
        hopf_damping_ratio: critical.map(|c| c.hopf_damping_ratio),
        cycle: cycle_result(&oscillator)?,
        upscaling: lead.name.into(),
        paper,
        area,
    };
    Ok(VibrationStage { result, output: StageOutput { tables, fields: Vec::new(), assumptions, warnings } })
}

/// The ensembles of one study.
struct Ensembles<'a> {
    section: &'a VibrationSection,
    oscillator: Oscillator,
    window: &'a WindowFriction,
    shape: CorrelationShape,
    correlation_length: f64,
    seed: u64,
}

impl Ensembles<'_> {
    /// The process of a scatter; `None` where friction is constant.
    fn process(&self, scatter: &Scatter, speeds: f64) -> Result<Option<FrictionProcess>, StudyError> {
        if scatter.std < NO_SCATTER {
            return Ok(None);
        }
        let model = ProcessModel {
            shape: self.shape,
            generator: Generator::of(self.shape),
            correlation: self.window.correlation,
            least: Some(self.least(speeds)),
            ..ProcessModel::new(scatter.marginal.clone(), scatter.std, self.correlation_length)
        };
        Ok(Some(FrictionProcess::new(model)?))
    }

    /// Least fluctuation that leaves the kinetic coefficient positive at the fastest slip to be expected: displacements
    /// scale with μ_st, so |v_rel| hardly exceeds V + μ_st, or `speeds` times that under violent friction.
    fn least(&self, speeds: f64) -> f64 {
        let fastest = speeds * (self.oscillator.belt_velocity() + self.window.mean);
        -0.9 * self.window.mean / (1.0 + self.window.stribeck * fastest)
    }

    fn settings(&self) -> EnsembleSettings {
        EnsembleSettings::new(self.section.trajectories, self.section.duration, self.seed)
    }

    fn followed(&self) -> TrajectorySettings {
        TrajectorySettings {
            duration: self.section.duration,
            start: None,
            drive: Drive::default(),
            method: Method::Taylor,
        }
    }

    /// Ensembles over the sweep, and the one at the study's own damping ratio. Where slips turn out faster than expected,
    /// so that friction would change its sign, the process is cut off higher, and the result says so.
    fn run(
        &self,
        scatter: &Scatter,
        monitor: &dyn Monitor,
        warnings: &mut Vec<String>,
    ) -> Result<(EnsembleResult, Option<Ensemble>), StudyError> {
        let mut ended = self.run_clamped(scatter, SPEEDS[0], monitor, warnings);
        for speeds in &SPEEDS[1..] {
            if let Err(StudyError::Vibration(VibrationError::TooFewValid { .. })) = ended {
                ended = self.run_clamped(scatter, *speeds, monitor, warnings);
            }
        }
        ended
    }

    fn run_clamped(
        &self,
        scatter: &Scatter,
        speeds: f64,
        monitor: &dyn Monitor,
        warnings: &mut Vec<String>,
    ) -> Result<(EnsembleResult, Option<Ensemble>), StudyError> {
        let (from, to, count) = self.section.damping_sweep;
        let ratios = (0..count).map(|k| from + (to - from) * k as f64 / (count - 1) as f64);
        let name = scatter.name;
        let Some(process) = self.process(scatter, speeds)? else {
            return Ok((self.without_scatter(scatter.std, ratios)?, None));
        };
        let (mut damping_ratios, mut ensembles) = (Vec::with_capacity(count), Vec::with_capacity(count));
        let mut clamped = 0;
        let task = format!("vibration ({name})");
        for (done, damping_ratio) in ratios.enumerate() {
            monitor.progress(&task, done, count + 1);
            let oscillator = self.oscillator.with_damping(damping_ratio)?;
            let settings = EnsembleSettings { sample_capacity: 0, ..self.settings() };
            let ensemble = Ensemble::simulate(&oscillator, &process, &settings, &Quiet(monitor))?;
            clamped += ensemble.clamped_knots;
            damping_ratios.push(damping_ratio);
            ensembles.push(ensemble);
        }
        monitor.progress(&task, count, count + 1);
        let lead = Ensemble::simulate(&self.oscillator, &process, &self.settings(), &Quiet(monitor))?;
        monitor.progress(&task, count + 1, count + 1);
        if clamped > 0 {
            warnings.push(format!(
                "with the {name} upscaling, {} of the friction process over the damping sweep lay lower than {} below the mean and \
                 were raised to there, so that friction stays positive: the least values of its law are cut off",
                sentence::count(clamped as usize, "value", "values"),
                sentence::digits(-self.least(speeds))
            ));
        }
        let sweep = DampingSweep { damping_ratios, ensembles };
        let result = EnsembleResult {
            friction_std: scatter.std,
            damping: sweep.damping_ratios.iter().zip(&sweep.ensembles).map(|(d, e)| damping_result(*d, e)).collect(),
            crossings: SHARES.iter().filter_map(|share| sweep.falls_through(*share)).map(crossing_result).collect(),
            reattachment: points_result(&lead.reattachments),
            release: points_result(&lead.releases),
            motion: Some(motion_result(&lead)),
        };
        Ok((result, Some(lead)))
    }

    /// The same of constant friction: every trajectory is the deterministic one.
    fn without_scatter(&self, std: f64, ratios: impl Iterator<Item = f64>) -> Result<EnsembleResult, StudyError> {
        let mut damping = Vec::new();
        for damping_ratio in ratios {
            let oscillator = self.oscillator.with_damping(damping_ratio)?;
            let settings = self.followed();
            let cycles = Trajectory::simulate(&oscillator, Steady, &settings)?.slips.cycles;
            let cycling = limit_cycle(&oscillator)?.cycle().is_some_and(|cycle| cycle.slips > 0);
            damping.push(DampingResult {
                damping_ratio,
                cycles_deterministic: cycles,
                cycles_mean: cycles as f64,
                cycles_se: 0.0,
                difference_mean: 0.0,
                difference_interval: [0.0, 0.0],
                share_in_cycle: if cycling { 1.0 } else { 0.0 },
                sustained_share: if cycling { 1.0 } else { 0.0 },
                sustained_share_interval: if cycling { [1.0, 1.0] } else { [0.0, 0.0] },
                failed_samples: 0,
            });
        }
        let (reattachment, release) = (PointsResult::default(), PointsResult::default());
        Ok(EnsembleResult { friction_std: std, damping, crossings: Vec::new(), reattachment, release, motion: None })
    }

    /// The limit cycle, and the end of one trajectory, for a phase portrait.
    fn portraits(&self, scatter: &Scatter) -> Result<Vec<(&'static str, Table)>, StudyError> {
        let table = |points: Vec<PhasePoint>| {
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
        let settings = self.followed();
        let from = (settings.duration - TRAJECTORY_SPAN).max(0.0);
        for speeds in SPEEDS {
            let Some(process) = self.process(scatter, speeds)? else { break };
            let path = process.path(self.seed, 0);
            match trajectory_portrait(&self.oscillator, path, &settings, from, TRAJECTORY_POINTS) {
                Ok(points) => {
                    tables.push(("trajectory", table(points)));
                    break;
                }
                Err(VibrationError::FrictionNotPositive { .. }) => {}
                Err(error) => return Err(error.into()),
            }
        }
        Ok(tables)
    }

    fn sentences(&self, area_std: f64) -> Vec<String> {
        let (section, window) = (self.section, self.window);
        let mut sentences = vec![format!(
            "The oscillator slides with μ_st/(1 + a|v|) + μ_s, a = {} per unit of dimensionless velocity, at V = {}. Cycles are \
             slips that reach a negative velocity within τ = {}, starting in stick.",
            sentence::digits(window.stribeck),
            sentence::digits(self.oscillator.belt_velocity()),
            section.duration
        )];
        if window.std < NO_SCATTER {
            sentences.push(format!(
                "Friction ({}) is constant at {}: every trajectory is the deterministic one.",
                window.origin,
                sentence::digits(window.mean)
            ));
            return sentences;
        }
        sentences.push(format!(
            "Friction ({}) has mean {}, standard deviation {} for one window, and correlation length {} over the sliding \
             distance, λ = ℓ_μ c/N = {}.",
            window.origin,
            sentence::digits(window.mean),
            sentence::digits(window.std),
            sentence::si(window.length_m, "m"),
            sentence::digits(self.correlation_length)
        ));
        sentences.extend(window.area_m2.map(|area_m2| {
            format!(
                "Upscaling: with `paper` one window carries the whole normal force of {}, {} on its area. With `area` the \
                 windows of a square nominal area of {} average, so that the scatter falls to {}{}. Both keep the correlation \
                 length of one window.",
                section.normal_force,
                sentence::si(section.normal_force.0 / area_m2, "Pa"),
                section.nominal_area,
                sentence::digits(area_std),
                if window.holds_many() { " and its law becomes normal" } else { "" }
            )
        }));
        sentences
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
    DampingResult {
        damping_ratio,
        cycles_deterministic: ensemble.cycles_deterministic,
        cycles_mean: ensemble.cycles.mean,
        cycles_se: ensemble.cycles.se,
        difference_mean: ensemble.difference_mean,
        difference_interval: ensemble.difference_interval,
        share_in_cycle: ensemble.passages.share_in_cycle,
        sustained_share: ensemble.passages.sustained.value,
        sustained_share_interval: ensemble.passages.sustained.interval,
        failed_samples: ensemble.failures.len(),
    }
}

fn crossing_result(crossing: Crossing) -> CrossingResult {
    let Crossing { share, damping_ratio, interval } = crossing;
    CrossingResult { share, damping_ratio, damping_ratio_interval: interval }
}

fn points_result(points: &SampleLaw) -> PointsResult {
    PointsResult {
        count: points.count,
        mean: finite(points.mean),
        std: finite(points.std),
        skewness: finite(points.skewness),
        excess_kurtosis: finite(points.excess_kurtosis),
        normality_p: points.normality_p,
    }
}

fn motion_result(ensemble: &Ensemble) -> MotionResult {
    let passages = &ensemble.passages;
    MotionResult {
        period_mean: finite(ensemble.periods.mean),
        period_std: finite(ensemble.periods.std),
        stick_share: ensemble.stick_share.mean,
        stick_share_se: ensemble.stick_share.se,
        share_in_cycle: passages.share_in_cycle,
        exit_rate: passages.exit_rate.map(|rate| rate.value),
        exit_rate_interval: passages.exit_rate.map(|rate| rate.interval),
        entry_rate: passages.entry_rate.map(|rate| rate.value),
        entry_rate_interval: passages.entry_rate.map(|rate| rate.interval),
        left_share: passages.left.value,
        left_share_interval: passages.left.interval,
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
        columns.push((format!("{name}_sustained_share"), column(result, &|d| d.sustained_share)));
        columns.push((format!("{name}_sustained_share_low"), column(result, &|d| d.sustained_share_interval[0])));
        columns.push((format!("{name}_sustained_share_high"), column(result, &|d| d.sustained_share_interval[1])));
    }
    Table::new(columns)
}

/// Histogram of the re-attachment points beside the normal density of equal mean and standard deviation.
fn reattachment_table(ensemble: &Ensemble) -> Option<Table> {
    let points = &ensemble.reattachments;
    let histogram = Histogram::of(&points.sample).ok()?;
    let normal = Marginal::normal(points.mean, points.std).ok()?;
    let centres = histogram.centres();
    Some(
        Table::new([
            ("normal_density", centres.iter().map(|x| normal.pdf(*x)).collect()),
            ("density", histogram.density()),
            ("displacement", centres),
        ])
        .led_by("displacement"),
    )
}
