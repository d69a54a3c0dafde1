//! The machine of two coupled modes: its answer and its table.

use asperity_results::{ModeCouplingResult, MotionKind};

use crate::format::{Dimension, significant};
use crate::page::answer::Answer;
use crate::page::answer_table::all;
use crate::page::data_table::DataTable;

/// Answers whether the machine flutters.
pub(super) fn answer(result: &ModeCouplingResult) -> Answer {
    let answer = match result.kind {
        MotionKind::Flutter => "Yes: steady sliding is unstable, and two modes grow together",
        MotionKind::Divergence => "No, but friction pulls the mass away",
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
    vec![DataTable::of("Mode coupling with the mean friction coefficient", result, all)]
}
