//! The verdict as text, for terminals.

use asperity_results::{AreaAsOne, ErrorCause, MachineModel, VerdictResult};

use crate::cells::{percent, plain};
use crate::format::{count, significant};
use crate::page::data_table::DataTable;
use crate::page::verdict::{
    computed_to, drivers, half_of_the_time, margin_of, over_unknowns, remedies, tables, vibration,
};
use crate::verdict::{RARE, is_exact, largest_error, not_stated, percent as probability, verdict_sentence};

/// Returns the answer of a run in a few sentences: the probability, what the study does not state, what would stop the vibration, what to
/// measure next, and the largest error with what makes it smaller.
pub fn verdict_summary(verdict: &VerdictResult) -> Vec<String> {
    let mut sentences = vec![verdict_sentence(verdict)];
    if verdict.friction_unresolved {
        return sentences;
    }
    sentences.extend(not_stated(verdict).into_iter().map(|value| format!("Not stated: {value}.")));
    sentences.extend(advice(verdict));
    sentences.extend(largest_error(verdict));
    sentences.into_iter().map(|sentence| sentence.replace('\u{a0}', " ")).collect()
}

/// Returns the verdict as text: sentences on the probability, the vibration and the error of the computation, then tables of what
/// decides the verdict, what would change it and what it rests on.
pub fn verdict_text(verdict: &VerdictResult) -> String {
    let mut sentences = vec![verdict_sentence(verdict)];
    sentences.extend(not_stated(verdict).into_iter().map(|value| format!("Not stated: {value}.")));
    if verdict.probability_interval[1] < RARE && !is_exact(verdict) {
        sentences.push(computed_to(verdict));
    }
    sentences.extend(half_of_the_time(verdict).filter(|_| !is_exact(verdict)));
    sentences.extend([over_unknowns(verdict), vibration(verdict)].into_iter().flatten().map(|html| html.text()));
    sentences.extend(advice(verdict));
    if !is_exact(verdict) {
        sentences.push(computation(verdict));
    }
    let mut text = sentences.join("\n") + "\n";
    let first = [margin(verdict), remedies::table(verdict), area_as_one(verdict)];
    for table in first.into_iter().chain(tables(verdict)).filter(|table| !table.rows.is_empty()) {
        text += &format!("\n{table}");
    }
    if !verdict.assumptions.is_empty() {
        text += &format!("\nAssumptions\n  {}\n", verdict.assumptions.join("\n  "));
    }
    text.replace('\u{a0}', " ")
}

/// Returns what would stop the vibration, and what to measure next, in sentences.
fn advice(verdict: &VerdictResult) -> Vec<String> {
    let mut sentences = Vec::new();
    if !verdict.remedies.is_empty() {
        sentences.push(remedies::sentence(verdict).text());
    } else if !verdict.turning_points.is_empty() {
        sentences.push(remedies::of_one_machine(verdict));
    }
    if verdict.drivers.len() > 1 {
        sentences.push(drivers::next(verdict).text());
    }
    sentences
}

/// Returns the parts of the error of the probability.
fn computation(verdict: &VerdictResult) -> String {
    let part = |source: ErrorCause, half_width: f64| format!("{source} up to {}", significant(100.0 * half_width, 2));
    let parts: Vec<String> = verdict.error_sources.iter().map(|error| part(error.source, error.half_width)).collect();
    let mut text = format!("{} machines", count(verdict.evaluations));
    if verdict.model == MachineModel::StickSlip {
        text += &format!(" over {} s", significant(verdict.duration_s, 3));
    }
    if !parts.is_empty() {
        text += &format!("; errors of the probability in percentage points: {}", parts.join(", "));
    }
    if let Some(friction) = &verdict.friction {
        text += &format!(
            "; friction expanded from {} contact solutions, {} of them near the limit, to ±{} %",
            friction.points,
            friction.points_near_limit,
            significant(100.0 * friction.standard_error, 2)
        );
    }
    if let Some(reason) = &verdict.first_failure {
        text += &format!("; {} machines have no answer, the first one because {reason}", count(verdict.failed_samples));
    }
    text + "."
}

/// Returns the quantiles of the margin.
fn margin(verdict: &VerdictResult) -> DataTable {
    let quantiles = verdict.margin_quantiles.iter();
    let rows = quantiles.map(|quantile| vec![percent(quantile.probability, 3), plain(quantile.damping_margin, 3)]);
    let caption = format!("Quantiles of the margin {}", margin_of(verdict.model));
    let rows = if is_exact(verdict) {
        vec![vec!["exact".into(), plain(verdict.nominal.damping_margin, 3)]]
    } else {
        rows.collect()
    };
    DataTable::new(&caption, &["Quantile", "Margin"], rows)
}

/// Returns the probability against the number of windows that share the load.
fn area_as_one(verdict: &VerdictResult) -> DataTable {
    let row = |row: &AreaAsOne| {
        let [low, high] = row.probability_interval.map(probability);
        let found = format!("{} ({low} to {high})", probability(row.probability));
        vec![significant(row.windows, 3), significant(row.friction_std, 3), found]
    };
    let rows = verdict.area_as_one.iter().flatten().map(row).collect();
    let caption =
        "How much of the area acts as one: probability of vibration if so many independent windows share the load";
    DataTable::new(caption, &["Windows", "Standard deviation of friction", "Probability"], rows)
}
