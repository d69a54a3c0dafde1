//! The page of the answer of a vibration command.

use std::collections::BTreeMap;

use serde_json::Value;

use crate::figures::vibration;
use crate::format::Dimension;
use crate::page::Page;
use crate::page::data_table::DataTable;
use crate::page::section::Section;
use crate::{Report, ReportError, Table};

/// Renders the page of a vibration command, such as `map`, from the JSON object that `--json` prints and its tables. It is a pure
/// function.
///
/// # Errors
/// The columns of a table differ in length, or the PNG encoder failed.
pub fn render_vibration(
    command: &str,
    answer: &Value,
    tables: &BTreeMap<String, Table>,
) -> Result<Report, ReportError> {
    crate::run::validate(tables.iter().map(|(name, table)| (name.as_str(), table)), [])?;
    let warnings: Vec<String> = answer["warnings"]
        .as_array()
        .map_or_else(Vec::new, |warnings| warnings.iter().filter_map(Value::as_str).map(str::to_owned).collect());
    let units = "Displacement, time and velocity are dimensionless: X = xc/N, τ = ω₀t and dX/dτ.";
    let source = "answer.json";
    let table = DataTable::properties("Numbers of the answer", rows(answer), source);
    let sections = [
        Section::new("figures", "Figures", units, Vec::new(), vibration::of_answer(answer, tables)?),
        Section::new("answer", "Answer", "", vec![table], Vec::new()),
    ];
    let page = Page {
        title: format!("Vibration: {}", command.replace('-', " ")),
        intro: "Answer of one vibration command of asperity.",
        first_screen: None,
        answers: Vec::new(),
        warnings: &warnings,
        sections: sections.into_iter().flatten().collect(),
        appendix: Vec::new(),
        script: "",
        machine: None,
    };
    Ok(page.render())
}

/// Returns the numbers, words and decisions of the answer with their units; lists have tables of their own.
fn rows(answer: &Value) -> Vec<(String, String)> {
    let value = |dimension: Dimension, value: &Value| match value {
        Value::Bool(holds) => Some(if *holds { "yes" } else { "no" }.to_owned()),
        Value::Number(number) => number.as_f64().map(|number| dimension.show(number)),
        Value::String(text) => Some(text.replace('_', " ")),
        _ => None,
    };
    let row = |(key, own): (&String, &Value)| {
        let (name, dimension) = Dimension::of_key(key);
        Some((name.replace('_', " "), value(dimension, own)?))
    };
    answer.as_object().into_iter().flatten().filter_map(row).collect()
}
