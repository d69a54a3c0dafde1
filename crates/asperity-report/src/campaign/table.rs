//! The table of the members: answers first, then the values that differ.

use asperity_results::choice::Choice;
use asperity_results::{CampaignResults, InputValue, MemberResult, Pair};

use crate::campaign::words::{
    capitalised, is_undetermined, key_in_words, number, probability, shown, unit_of, verdict,
};
use crate::cells::DASH;
use crate::format::{Unit, significant};
use crate::markup::{Html, html};

/// Columns that are left out if all their numbers are 0.
const MAY_VANISH: [&str; 2] = ["Its standard deviation", "Warnings"];

/// Column of the table: its title and the cells, each with the number by which it is sorted.
struct Column {
    title: String,
    cells: Vec<(Html, Option<f64>)>,
    is_input: bool,
}

impl Column {
    fn new(title: &str, cells: impl Iterator<Item = (Html, Option<f64>)>) -> Self {
        Self { title: title.into(), cells: cells.collect(), is_input: false }
    }

    /// Returns a column of numbers in one unit, which the title names.
    fn numbers(title: &str, unit: &Unit, values: impl Iterator<Item = Option<f64>>) -> Self {
        let title = if unit.symbol.is_empty() { title.to_owned() } else { format!("{title} ({})", unit.symbol) };
        Self::new(
            &title,
            values.map(|value| (value.map_or(DASH.into(), |v| significant(v / unit.si, 4)).into(), value)),
        )
    }

    fn texts(title: &str, texts: impl Iterator<Item = String>) -> Self {
        Self::new(title, texts.map(|text| (text.into(), None)))
    }

    fn is_empty(&self) -> bool {
        let zeros =
            MAY_VANISH.contains(&self.title.as_str()) && self.cells.iter().all(|(_, value)| *value == Some(0.0));
        zeros || self.cells.iter().all(|(text, _)| text.text() == DASH)
    }

    fn class(&self) -> &'static str {
        if self.is_input { "input" } else { "" }
    }
}

/// Returns the table of the first members.
pub(super) fn table(results: &CampaignResults, shown: usize) -> Html {
    let members = &results.members[..shown];
    let mut columns = answers(members);
    columns.extend(inputs(results, members).into_iter().map(|column| Column { is_input: true, ..column }));
    columns.retain(|column| !column.is_empty());
    let inputs = columns.iter().filter(|column| column.is_input).count();
    let groups = [("Answers", "", columns.len() - inputs), ("Values of the member", "input", inputs)];
    let groups = groups.into_iter().filter(|(.., count)| *count > 0).map(|(title, class, count)| {
        html!("<th scope=\"colgroup\" class=\"{}\" colspan=\"{}\">{}</th>", class, count.to_string(), title)
    });
    let headers = columns
        .iter()
        .map(|column| html!("<th scope=\"col\" class=\"{}\" data-sort=\"\">{}</th>", column.class(), &column.title));
    let cell = |column: &Column, row: usize| match &column.cells[row] {
        (text, Some(value)) => {
            let value = format!("{value:?}");
            html!(
                "<td class=\"{}\" data-value=\"{}\" data-name=\"{}\">{}</td>",
                column.class(),
                value,
                &column.title,
                text
            )
        }
        (text, None) => html!("<td class=\"{}\" data-name=\"{}\">{}</td>", column.class(), &column.title, text),
    };
    let rows = (0..shown).map(|row| {
        let cells = columns.iter().map(|column| cell(column, row));
        html!("<tr>{}</tr>\n", cells.collect::<Html>())
    });
    html!(
        "<div class=\"table\" role=\"region\" tabindex=\"0\" aria-label=\"Members\">\n<table class=\"sortable\">\n<thead><tr class=\"group\">{}</tr>\n<tr>{}</tr></thead>\n<tbody>\n{}</tbody>\n\
         </table>\n</div>\n",
        groups.collect::<Html>(),
        headers.collect::<Html>(),
        rows.collect::<Html>(),
    )
}

fn answers(members: &[MemberResult]) -> Vec<Column> {
    let plain = Unit::none();
    let of = |answer: fn(&MemberResult) -> Option<f64>| members.iter().map(answer);
    // Numbers of members have no digits to round.
    let numbers = (1..=members.len()).map(|number| (number.to_string().into(), Some(number as f64)));
    vec![
        Column::new("Member", numbers),
        Column::new("Verdict", members.iter().map(|member| (chip(member), None))),
        Column::new("Probability of vibration", members.iter().map(|m| (probability_cell(m), m.answers.probability))),
        Column::texts(
            "Motion",
            members.iter().map(|member| member.answers.kind.map_or_else(|| DASH.into(), Choice::words)),
        ),
        Column::numbers("Limit damping ratio", &plain, of(|member| member.answers.limit_damping_ratio)),
        Column::numbers("Margin ζ − ζ_v", &plain, of(|member| member.answers.damping_margin)),
        Column::numbers("Friction coefficient", &plain, of(|member| member.answers.friction_mean)),
        Column::numbers("Its standard deviation", &plain, of(|member| member.answers.friction_std)),
        Column::numbers("Warnings", &plain, of(|member| Some(member.answers.warnings? as f64))),
    ]
}

/// Returns the verdict as a chip, with the reason of a failure. Beside a probability, the verdict on central values would be another answer to
/// the same question.
fn chip(member: &MemberResult) -> Html {
    let word = if member.answers.probability.is_some() { DASH } else { verdict(member) };
    let chip = if word == DASH { DASH.into() } else { html!("<span class=\"chip {}\">{}</span>", word, word) };
    let reason = member.reason.as_ref().map(|reason| html!(" <small class=\"reason\">{}</small>", reason));
    html!("{}{}", chip, reason.unwrap_or_default())
}

/// Returns the probability with its interval, unless both are shown alike.
fn probability_cell(member: &MemberResult) -> Html {
    let Some(own) = member.answers.probability else { return DASH.into() };
    if is_undetermined(member) {
        return "not determined".into();
    }
    let part = |ends: Option<Pair>, words: &str| {
        let [low, high] = ends.map(|ends| ends.map(probability)).filter(|[low, high]| low != high)?;
        Some(html!("<small>{} to {}{}</small>", low, high, words))
    };
    let of_values = part(member.answers.probability_range, " over the unknown values");
    let parts = [part(member.answers.probability_interval, ""), of_values];
    html!("{}{}", probability(own), parts.into_iter().flatten().collect::<Html>())
}

/// Returns the columns of the scans and of the keys.
fn inputs(results: &CampaignResults, members: &[MemberResult]) -> Vec<Column> {
    let scans = members.iter().map(|member| member.scan.clone().unwrap_or_else(|| DASH.into()));
    let mut columns = vec![Column::texts("Scan", scans)];
    for (place, key) in results.keys.iter().enumerate() {
        let values = || members.iter().map(|member| &member.values[place]);
        let title = capitalised(key_in_words(key));
        let numbers: Option<Vec<f64>> = values().map(number).collect();
        columns.push(match numbers {
            Some(numbers) if values().all(|value| matches!(value, InputValue::Number(_))) => {
                let unit = unit_of(key, numbers.iter().copied());
                Column::numbers(&title, &unit, numbers.into_iter().map(Some))
            }
            _ => Column::new(&title, values().map(|value| (shown(key, value).into(), number(value)))),
        });
    }
    columns
}
