//! The machine of two coupled modes: its answer and its table.

use asperity_results::{ModeCouplingResult, MotionKind};

use crate::page::answer_table::all;
use crate::page::data_table::DataTable;

/// Answers whether the machine flutters.
pub(super) fn answer(result: &ModeCouplingResult) -> &'static str {
    match result.kind {
        MotionKind::Flutter => "Yes: steady sliding is unstable, and two modes grow together",
        MotionKind::Divergence => "No, but friction pulls the mass away",
        _ => "No: steady sliding is stable",
    }
}

/// Returns the stability of steady sliding and the vibration that follows.
pub(super) fn tables(result: &ModeCouplingResult) -> Vec<DataTable> {
    vec![DataTable::of("Mode coupling with the mean friction coefficient", result, all)]
}
