//! Answer of the command for coupled modes.

use asperity::vibration::mode_coupling::{CoupledEnsemble, CoupledRegime, EigenvalueScan, GrowthRates, Model, modes};
use serde_json::{Value, json};

use crate::output::Answer;

/// Returns where the modes meet, and the modes of the stated machine.
pub(super) fn modes_answer(model: &Model, scan: &EigenvalueScan) -> Answer {
    let friction = model.sliding_friction();
    let [first, second] = modes(model, friction);
    let critical = scan.critical;
    Answer::default()
        .with("friction", friction)
        .with("belt_velocity", model.belt_velocity())
        .with("coalescence", scan.coalescence)
        .with("critical_friction", critical.map(|c| c.friction))
        .with("critical_instability", critical.map_or(Value::Null, |c| json!(c.instability)))
        .with("critical_frequency", critical.map(|c| c.frequency))
        .with("growth_1", first.growth)
        .with("frequency_1", first.frequency)
        .with("growth_2", second.growth)
        .with("frequency_2", second.frequency)
}

/// Returns the motion of the stated machine without fluctuation.
pub(super) fn motion_answer(regime: &CoupledRegime) -> Answer {
    let cycle = regime.cycle();
    let motion = match regime {
        CoupledRegime::Cycle(_) => "cycle",
        CoupledRegime::Steady => "steady",
        CoupledRegime::Locked => "locked",
        CoupledRegime::Irregular => "irregular",
    };
    Answer::default()
        .with("motion", motion)
        .with("period", cycle.map(|c| c.period))
        .with("tangential", json!(cycle.map(|c| c.tangential)))
        .with("normal", json!(cycle.map(|c| c.normal)))
        .with("normal_force_max", cycle.map(|c| c.normal_force_max))
        .with("stick_share", cycle.map(|c| c.stick_share))
        .with("flight_share", cycle.map(|c| c.flight_share))
        .with("detachments", cycle.map(|c| c.detachments))
        .with("lift_offs", cycle.map(|c| c.lift_offs))
}

/// Returns the growth of small motions and the vibration beyond the amplitude `threshold` with a fluctuation of friction.
pub(super) fn fluctuation_answer(growth: &GrowthRates, threshold: f64, ensemble: &CoupledEnsemble) -> Answer {
    Answer::default()
        .with("growth_rate", growth.deterministic)
        .with("growth_rate_mean", growth.mean)
        .with("growth_rate_se", growth.se)
        .with("growth_rate_std", growth.std)
        .with("growth_rate_quantiles", json!(growth.quantiles))
        .with("growing_share", growth.growing)
        .with("growing_share_interval", json!(growth.growing_interval))
        .with("threshold", threshold)
        .with("passed_share", ensemble.passed)
        .with("passed_share_interval", json!(ensemble.passed_interval))
        .with("passage_time_mean", ensemble.passage_time.map(|time| time.mean))
        .with("passage_time_se", ensemble.passage_time.map(|time| time.se))
        .with("sustained_share", ensemble.sustained)
        .with("sustained_share_interval", json!(ensemble.sustained_interval))
        .with("amplitude_mean", ensemble.amplitude.mean)
        .with("amplitude_se", ensemble.amplitude.se)
        .with("stick_share_mean", ensemble.stick_share.mean)
        .with("flight_share_mean", ensemble.flight_share.mean)
}

/// Returns the modes at every friction coefficient.
pub(super) fn scan(scan: &EigenvalueScan) -> Value {
    json!({ "friction": scan.friction, "modes": scan.modes })
}

/// Returns a message about a motion without cycle.
pub(super) fn note(regime: &CoupledRegime) -> Option<&'static str> {
    match regime {
        CoupledRegime::Cycle(_) => None,
        CoupledRegime::Steady => Some("no limit cycle: the mass comes to rest in space"),
        CoupledRegime::Locked => Some("no limit cycle: the belt carries the mass away (self-locking)"),
        CoupledRegime::Irregular => Some("no limit cycle: the motion is not periodic"),
    }
}
