//! The machine of two coupled modes: its answer and its table.

use asperity_results::{CoupledMotion, KindResult, ModeCouplingResult};

use crate::cells::{DASH, plain, shown, yes_or_no};
use crate::format::{Dimension, significant};
use crate::page::answer::Answer;
use crate::page::data_table::DataTable;
use crate::run::RESULTS;
use crate::words::kind_in_words;

/// Answers whether the machine flutters.
pub(super) fn answer(result: &ModeCouplingResult) -> Answer {
    let answer = match result.kind {
        KindResult::Flutter => "Yes: steady sliding is unstable, and two modes grow together",
        KindResult::Divergence => "No, but friction pulls the mass away",
        _ => "No: steady sliding is stable",
    };
    let critical = result.critical_friction.map_or_else(
        || "No friction coefficient makes it unstable.".to_owned(),
        |critical| format!("The critical coefficient is {}.", significant(critical, 4)),
    );
    let cycle = result.cycle.map_or_else(String::new, |cycle| {
        format!(
            " The vibration has {} Hz and a velocity amplitude of {}.",
            significant(cycle.frequency_hz, 4),
            Dimension::Velocity.show(cycle.velocity_amplitude_m_per_s)
        )
    });
    let detail =
        format!("With the mean friction coefficient μ = {}. {critical}{cycle}", significant(result.friction, 4));
    Answer { question: "Does it squeal by mode coupling?", answer: answer.into(), detail }
}

/// Returns the stability of steady sliding and the vibration that follows.
pub(super) fn tables(result: &ModeCouplingResult) -> Vec<DataTable> {
    let number = |value: Option<f64>| plain(value, 4);
    let in_unit = |dimension: Dimension, value: Option<f64>| shown(dimension, value, None);
    let cycle = result.cycle.as_ref();
    let [slow, fast] = result.mode_frequencies_hz;
    let [k11, k12, k22] = result.stiffness;
    let motion = result.motion.map_or(DASH, |motion| match motion {
        CoupledMotion::Cycle => "limit cycle",
        CoupledMotion::Steady => "steady sliding",
        CoupledMotion::Locked => "self-locking",
        CoupledMotion::Irregular => "not periodic",
    });
    let rows = [
        ("Stability of steady sliding", String::new()),
        ("friction coefficient μ", number(Some(result.friction))),
        ("critical friction coefficient μ_c", number(result.critical_friction)),
        ("margin μ_c − μ", number(result.friction_margin)),
        ("damping ratio ζ of the study", number(Some(result.damping_ratio))),
        ("damping ratio that just keeps it stable", number(result.limit_damping_ratio)),
        ("steady sliding is unstable", yes_or_no(Some(result.steady_sliding_unstable)).into()),
        ("kind", kind_in_words(result.kind).into()),
        ("frequency at the critical coefficient in Hz", number(result.onset_frequency_hz)),
        ("frequencies of the modes in Hz", format!("{} and {}", significant(slow, 4), significant(fast, 4))),
        ("Springs, in mω₀²", String::new()),
        (
            "stiffness k₁₁, k₁₂, k₂₂",
            format!("{}, {}, {}", significant(k11, 4), significant(k12, 4), significant(k22, 4)),
        ),
        ("contact spring", number(Some(result.contact_spring))),
        ("Vibration", String::new()),
        ("long-term motion", motion.into()),
        ("frequency in Hz", number(cycle.map(|cycle| cycle.frequency_hz))),
        ("velocity amplitude", in_unit(Dimension::Velocity, cycle.map(|cycle| cycle.velocity_amplitude_m_per_s))),
        ("amplitude along the belt", in_unit(Dimension::Length, cycle.map(|cycle| cycle.displacement_amplitude_m))),
        ("amplitude across the belt", in_unit(Dimension::Length, cycle.map(|cycle| cycle.normal_amplitude_m))),
        ("fraction of the period in stick", number(cycle.map(|cycle| cycle.stick_share))),
        ("fraction of the period off the belt", number(cycle.map(|cycle| cycle.flight_share))),
    ];
    let rows = rows.map(|(name, value)| (name.to_owned(), value)).into_iter();
    vec![DataTable::properties("Mode coupling with the mean friction coefficient", rows, RESULTS)]
}
