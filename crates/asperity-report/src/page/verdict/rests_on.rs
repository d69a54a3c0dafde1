//! The card of the inputs of the verdict, by origin.

use asperity_results::{InputKind, InputValue, MachineModel, Quantiles, RestsOn};

use crate::format::Dimension;
use crate::markup::{Html, html};
use crate::page::data_table::DataTable;
use crate::words::{between, in_words, named};

/// Text of an input.
type Words<'a> = &'a dyn Fn(&RestsOn) -> String;

/// Returns the inputs as chips, and what the model covers.
pub(super) fn card(inputs: &[RestsOn], model: MachineModel) -> Html {
    let machine = match model {
        MachineModel::StickSlip => {
            "This model covers stick-slip, groan and judder. For squeal choose the model of two coupled modes."
        }
        MachineModel::ModeCoupling => {
            "This model covers squeal by two coupled modes. For groan and judder choose the model of one mass."
        }
    };
    let chips = match inputs {
        [] => html!("<p>The results of an earlier version do not list the inputs.</p>\n"),
        inputs => chips(inputs),
    };
    html!("{}<p class=\"note\">{}{}</p>\n", chips, ranges(inputs), machine)
}

/// Returns what the ranges of uncertain and unknown inputs are.
pub(crate) fn ranges(inputs: &[RestsOn]) -> &'static str {
    if inputs.iter().any(|input| input.range.is_some()) { "Ranges hold 90 %. " } else { "" }
}

/// Returns a chip for each origin of inputs; scans first.
pub(crate) fn chips(inputs: &[RestsOn]) -> Html {
    let chip = |(class, text): (&str, String)| html!("<li class=\"chip {}\">{}</li>\n", class, text);
    html!("<ul class=\"chips\">\n{}</ul>\n", by_origin(inputs).into_iter().map(chip).collect::<Html>())
}

/// Returns a line for the scans of each body and for the inputs of each other origin, with the class of its chip.
pub(crate) fn by_origin(inputs: &[RestsOn]) -> Vec<(&'static str, String)> {
    let of = |kind: InputKind| inputs.iter().filter(move |input| input.kind == kind);
    let mut lines: Vec<_> = of(InputKind::Measured).map(|input| ("measured", scans(input))).collect();
    let with_value = |input: &RestsOn| format!("{} {}", named(&input.input), value(input));
    let origins: [(InputKind, &str, &str, Words<'_>); 5] = [
        (InputKind::Stated, "stated", "stated", &|input| named(&input.input)),
        (InputKind::Uncertain, "uncertain", "uncertain", &with_value),
        (InputKind::Unknown, "guessed", "unknown", &with_value),
        (InputKind::Example, "guessed", "example values, not yours", &with_value),
        (InputKind::Default, "guessed", "not stated", &default),
    ];
    for (kind, class, word, text) in origins {
        let texts: Vec<String> = of(kind).map(text).collect();
        if !texts.is_empty() {
            lines.push((class, format!("{word}: {}", texts.join(", "))));
        }
    }
    lines
}

/// Returns the number of scans of a body.
fn scans(input: &RestsOn) -> String {
    match input.value {
        InputValue::Number(1.0) => format!("{}: 1 scan; holds for the scanned part only", named(&input.input)),
        InputValue::Number(count) => format!("{}: {count} scans", named(&input.input)),
        InputValue::Integer(_) | InputValue::Name(_) => named(&input.input),
    }
}

/// Formats the value of an input, with its 90 % range if it has one.
fn value(input: &RestsOn) -> String {
    match &input.value {
        InputValue::Integer(number) => number.to_string(),
        InputValue::Number(number) => {
            let dimension = Dimension::of_unit(&input.unit);
            let Some([q05, q95]) = input.range else { return dimension.show(*number) };
            let (central, range) = between(dimension, Quantiles { q05, q50: *number, q95 });
            format!("{}{range}", central.trim_end())
        }
        InputValue::Name(name) => match name.as_str() {
            "stribeck" => "Stribeck".into(),
            "bowden_tabor" => "Bowden–Tabor".into(),
            other => in_words(other),
        },
    }
}

/// Returns a default value. Those of numbers are no measurements.
fn default(input: &RestsOn) -> String {
    if input.input == "material.hardness" {
        return "hardness (contact is elastic)".into();
    }
    let is_word = matches!(input.value, InputValue::Name(_));
    format!("{} {}{}", named(&input.input), value(input), if is_word { "" } else { " (default, not measured)" })
}

/// Returns all inputs with their values.
pub(super) fn table(inputs: &[RestsOn]) -> DataTable {
    let row = |input: &RestsOn| {
        let (text, origin) = match input.kind {
            InputKind::Measured => (scans(input), "measured"),
            InputKind::Stated => (value(input), "stated"),
            InputKind::Uncertain => (value(input), "uncertain"),
            InputKind::Unknown => (value(input), "unknown"),
            InputKind::Default => (value(input), "default"),
            InputKind::Example => (value(input), "example value, not yours"),
        };
        vec![named(&input.input), text, origin.into()]
    };
    let caption = "Inputs of the verdict with their central values";
    DataTable::new(caption, &["Value", "Central value", "Origin"], inputs.iter().map(row).collect())
}
