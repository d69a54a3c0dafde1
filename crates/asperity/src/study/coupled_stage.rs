//! Mode coupling of a mass on a belt with two degrees of freedom, with the mean friction coefficient.

use crate::friction::WindowFriction;
use crate::study::check::VibrationStudy;
use crate::study::file::ContactSpring;
use crate::study::motion_entries::{coupled_cycle_result, instability_result};
use crate::study::output::StageOutput;
use crate::study::result::{CoupledCycleResult, CoupledMotion, ModeCouplingResult, ModesOverFriction, MotionKind};
use crate::study::{StudyError, Table, sentence};
use crate::vibration::mode_coupling::{
    CoupledRegime, EigenvalueScan, Mode, Model, SCAN_POINTS, eigenvalue_scan, instability, limit_cycle, modes, onset,
    scan_end,
};
use crate::vibration::{Scales, VibrationError};

/// Output of the stage.
pub(super) struct CoupledStage {
    pub(super) result: ModeCouplingResult,
    pub(super) output: StageOutput,
}

/// Returns the long-term motion with its cycle in SI.
fn motion(
    model: &Model,
    regime: CoupledRegime,
    scales: &Scales,
) -> Result<(CoupledMotion, Option<CoupledCycleResult>), VibrationError> {
    Ok(match regime {
        CoupledRegime::Cycle(cycle) => (CoupledMotion::Cycle, Some(coupled_cycle_result(model, &cycle, scales)?)),
        CoupledRegime::Steady => (CoupledMotion::Steady, None),
        CoupledRegime::Locked => (CoupledMotion::Locked, None),
        CoupledRegime::Irregular => (CoupledMotion::Irregular, None),
    })
}

/// Returns a table of the modes over the friction coefficient.
pub fn modes_table(scan: &EigenvalueScan) -> Table {
    let of = |value: &dyn Fn(&[Mode; 2]) -> f64| scan.modes.iter().map(value).collect();
    Table::from(ModesOverFriction {
        friction: (&scan.friction).into(),
        growth_1: of(&|modes| modes[0].growth),
        frequency_1: of(&|modes| modes[0].frequency),
        growth_2: of(&|modes| modes[1].growth),
        frequency_2: of(&|modes| modes[1].frequency),
    })
}

/// Computes the stability of steady sliding and the vibration that follows. `model` is the machine with this friction.
pub(super) fn run(study: &VibrationStudy, model: &Model, window: &WindowFriction) -> Result<CoupledStage, StudyError> {
    let (scales, friction) = (&study.machine.scales, model.sliding_friction());
    let hertz = |frequency: f64| frequency / (std::f64::consts::TAU * scales.time_s());
    let critical = onset(model)?;
    let kind = instability_result(instability(model)?);
    let found = modes(model, friction);
    // Without damping a motion about stable steady sliding goes on for ever.
    let neutral = model.damping() == [0.0; 3] && kind == MotionKind::None;
    let motion = if neutral || model.steady(friction).is_none() {
        None
    } else {
        Some(motion(model, limit_cycle(model, None)?, scales)?)
    };
    let contact_spring = model.parameters().contact_stiffness;
    let result = ModeCouplingResult {
        damping_ratio: study.machine.damping_ratio,
        belt_velocity: model.belt_velocity(),
        friction,
        stiffness: model.stiffness(),
        contact_spring,
        contact_stiffness_n_per_m: contact_spring * scales.stiffness_n_per_m(),
        coalescence: model.coalescence(),
        critical_friction: critical.map(|critical| critical.friction),
        friction_margin: critical.map(|critical| critical.friction - friction),
        limit_damping_ratio: model.limit_damping_ratio(friction),
        steady_sliding_unstable: kind != MotionKind::None,
        kind,
        onset_frequency_hz: critical.filter(|critical| critical.frequency > 0.0).map(|c| hertz(c.frequency)),
        mode_frequencies_hz: found.map(|mode| hertz(mode.frequency)),
        mode_growth_rates_per_s: found.map(|mode| mode.growth / scales.time_s()),
        motion: motion.as_ref().map(|(motion, _)| *motion),
        cycle: motion.and_then(|(_, cycle)| cycle),
    };
    let most = scan_end(model, critical.map(|critical| critical.friction));
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
    if study.machine.coupled.is_some_and(|coupled| coupled.contact_spring == ContactSpring::Surface) {
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
