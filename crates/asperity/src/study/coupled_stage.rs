//! Mode coupling of a mass on a belt with two degrees of freedom, with the mean friction coefficient.

use crate::friction::WindowFriction;
use crate::friction::process::Steady;
use crate::study::check::VibrationStudy;
use crate::study::file::ContactSpring;
use crate::study::output::StageOutput;
use crate::study::result::{CoupledCycleResult, CoupledMotion, KindResult, ModeCouplingResult};
use crate::study::{CsvTable, StudyError, sentence};
use crate::vibration::mode_coupling::{
    CoupledCycle, CoupledRegime, CoupledTrajectory, CoupledTrajectorySettings, Critical, EigenvalueScan, Instability,
    Mode, Model, critical_friction, eigenvalue_scan, limit_cycle, limit_cycle_within, modes,
};
use crate::vibration::{Scales, VibrationError};

/// Friction coefficient up to which the loss of stability is searched for; a machine that is stable there counts as critical at it.
const LARGEST_FRICTION: f64 = 1e3;
/// Points of one period from which the velocity amplitude is read.
const PERIOD_POINTS: usize = 1024;
/// Number of waves after which the motion of a sampled machine counts as irregular.
const MOST_WAVES: usize = 2_000;
/// Friction coefficients of the table of modes, and its end relative to the largest coefficient of interest.
const SCAN_POINTS: usize = 401;
const SCAN_MARGIN: f64 = 1.25;

/// Output of the stage.
pub(super) struct CoupledStage {
    pub(super) result: ModeCouplingResult,
    pub(super) output: StageOutput,
}

/// Returns the least friction coefficient at which steady sliding is unstable; `None` if it is stable up to 1,000.
pub(super) fn onset(model: &Model) -> Result<Option<Critical>, VibrationError> {
    critical_friction(model, LARGEST_FRICTION)
}

/// Returns the margin μ_c − μ. It is at most 1,000 − μ.
pub(super) fn margin(model: &Model) -> Result<f64, VibrationError> {
    Ok(onset(model)?.map_or(LARGEST_FRICTION, |critical| critical.friction) - model.sliding_friction())
}

/// Returns the kind of motion by the stability of steady sliding.
pub(super) fn kind(model: &Model) -> Result<KindResult, VibrationError> {
    Ok(match onset(model)? {
        Some(critical) if critical.friction < model.sliding_friction() => match critical.instability {
            Instability::Flutter => KindResult::Flutter,
            Instability::Divergence => KindResult::Divergence,
        },
        _ => KindResult::None,
    })
}

/// Returns the long-term motion with its cycle in SI.
fn motion(
    model: &Model,
    regime: CoupledRegime,
    scales: &Scales,
) -> Result<(CoupledMotion, Option<CoupledCycleResult>), VibrationError> {
    Ok(match regime {
        CoupledRegime::Cycle(cycle) => (CoupledMotion::Cycle, Some(in_si(model, &cycle, scales)?)),
        CoupledRegime::Steady => (CoupledMotion::Steady, None),
        CoupledRegime::Locked => (CoupledMotion::Locked, None),
        CoupledRegime::Irregular => (CoupledMotion::Irregular, None),
    })
}

fn in_si(model: &Model, cycle: &CoupledCycle, scales: &Scales) -> Result<CoupledCycleResult, VibrationError> {
    let settings = CoupledTrajectorySettings { duration: cycle.period, start: Some(cycle.start) };
    let points = CoupledTrajectory::portrait(model, Steady, &settings, 0.0, PERIOD_POINTS)?;
    let velocities = points.iter().map(|point| point.state.tangential_velocity);
    let (least, largest) =
        velocities.fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), v| (low.min(v), high.max(v)));
    let half = |[low, high]: [f64; 2]| 0.5 * (high - low);
    Ok(CoupledCycleResult {
        frequency_hz: 1.0 / (cycle.period * scales.time_s()),
        velocity_amplitude_m_per_s: half([least, largest]) * scales.velocity_m_per_s(),
        displacement_amplitude_m: half(cycle.tangential) * scales.length_m(),
        normal_amplitude_m: half(cycle.normal) * scales.length_m(),
        stick_share: cycle.stick_share,
        flight_share: cycle.flight_share,
    })
}

/// Returns the cycle of the motion, started 1 % away from steady sliding, in SI; `None` if it has not repeated after 2,000 waves.
pub(super) fn cycle(model: &Model, scales: &Scales) -> Result<Option<CoupledCycleResult>, VibrationError> {
    Ok(motion(model, limit_cycle_within(model, None, MOST_WAVES)?, scales)?.1)
}

/// Returns a table of the modes over the friction coefficient.
pub fn modes_table(scan: &EigenvalueScan) -> CsvTable {
    let of = |value: &dyn Fn(&[Mode; 2]) -> f64| scan.modes.iter().map(value).collect::<Vec<f64>>();
    CsvTable::new([
        ("friction", scan.friction.clone()),
        ("growth_1", of(&|modes| modes[0].growth)),
        ("frequency_1", of(&|modes| modes[0].frequency)),
        ("growth_2", of(&|modes| modes[1].growth)),
        ("frequency_2", of(&|modes| modes[1].frequency)),
    ])
}

/// Computes the stability of steady sliding and the vibration that follows. `model` is the machine with this friction.
pub(super) fn run(study: &VibrationStudy, model: &Model, window: &WindowFriction) -> Result<CoupledStage, StudyError> {
    let (scales, friction) = (&study.scales, model.sliding_friction());
    let hertz = |frequency: f64| frequency / (std::f64::consts::TAU * scales.time_s());
    let critical = onset(model)?;
    let kind = kind(model)?;
    let found = modes(model, friction);
    // Without damping a motion about stable steady sliding goes on for ever.
    let neutral = model.damping() == [0.0; 3] && kind == KindResult::None;
    let motion = if neutral || model.steady(friction).is_none() {
        None
    } else {
        Some(motion(model, limit_cycle(model, None)?, scales)?)
    };
    let contact_spring = model.parameters().contact_stiffness;
    let result = ModeCouplingResult {
        damping_ratio: study.damping_ratio,
        belt_velocity: model.belt_velocity(),
        friction,
        stiffness: model.stiffness(),
        contact_spring,
        contact_stiffness_n_per_m: contact_spring * scales.stiffness_n_per_m(),
        coalescence: model.coalescence(),
        critical_friction: critical.map(|critical| critical.friction),
        friction_margin: critical.map(|critical| critical.friction - friction),
        limit_damping_ratio: model.limit_damping_ratio(friction),
        steady_sliding_unstable: kind != KindResult::None,
        kind,
        onset_frequency_hz: critical.filter(|critical| critical.frequency > 0.0).map(|c| hertz(c.frequency)),
        mode_frequencies_hz: found.map(|mode| hertz(mode.frequency)),
        mode_growth_rates_per_s: found.map(|mode| mode.growth / scales.time_s()),
        motion: motion.as_ref().map(|(motion, _)| *motion),
        cycle: motion.and_then(|(_, cycle)| cycle),
    };
    let most = SCAN_MARGIN * critical.map_or(friction, |critical| critical.friction.max(friction));
    let tables = vec![("modes_over_friction", modes_table(&eigenvalue_scan(model, most, SCAN_POINTS)?))];
    let mut output = StageOutput { tables, ..StageOutput::default() };
    output.assumptions = sentences(study, window, &result);
    output.warnings.extend(window.warnings.iter().cloned());
    Ok(CoupledStage { result, output })
}

/// Returns the assumptions of the machine.
fn sentences(study: &VibrationStudy, window: &WindowFriction, result: &ModeCouplingResult) -> Vec<String> {
    let mut sentences = vec![format!(
        "Two inclined springs hold the mass, and a contact spring of {} N/m presses it on the belt (Hoffmann and others, 2002); \
         friction ({}) is constant at {}. Springs are in units of mω₀².",
        sentence::digits(result.contact_stiffness_n_per_m),
        window.origin,
        sentence::digits(result.friction)
    )];
    if study.coupled.is_some_and(|coupled| coupled.contact_spring == ContactSpring::Surface) {
        sentences.push("The contact spring is the stiffness of the rough contact over the nominal area.".into());
    }
    if window.std > 0.0 {
        sentences.push(
            "Mode coupling uses the mean friction coefficient; its fluctuation along the path is left out.".to_owned(),
        );
    }
    if window.stribeck.is_some() {
        sentences.push("The dependence of the friction process on the velocity is left out.".into());
    }
    sentences
}
