//! The page of a campaign: a table of its members, and a figure of their answer over the values.

use asperity_results::{CampaignResults, InputValue, MemberResult, Provenance, VariedKey};

use crate::Report;
use crate::figures::CaptionedFigure;
use crate::format::{Unit, count, significant};
use crate::markup::{Html, html};
use crate::page::{Answer, DASH, Page, Section, dimension, kind_in_words, named, percent, yes_or_no};
use crate::plot::{Axis, BLUE, Chart, Mark, pen, range};

/// Script that sorts the table.
const SORT: &str = include_str!("page/sort.js");
/// Largest number of rows of the page.
const MOST_ROWS: usize = 5000;
/// Largest number of curves in the figure.
const MOST_CURVES: usize = 9;
/// File with the numbers.
const SOURCE: &str = "members.csv";

/// The data of the page of a campaign.
#[derive(Debug, Clone, Default)]
pub struct CampaignRun {
    /// Name of the campaign.
    pub name: String,
    /// The content of `results.json`.
    pub results: CampaignResults,
    /// The content of `provenance.json`.
    pub provenance: Option<Provenance>,
}

/// Renders the page of a campaign. It is a pure function.
pub fn render_campaign(run: &CampaignRun) -> Report {
    let results = &run.results;
    let shown = results.members.len().min(MOST_ROWS);
    let rest = match results.members.len() - shown {
        0 => String::new(),
        more => format!(" {} more are in {SOURCE}.", count(more)),
    };
    let lead = format!("A click on the head of a column sorts the table.{rest}");
    let figures = figure(results).into_iter().collect();
    let sections = [
        Section::new("comparison", "Comparison", "", Vec::new(), figures),
        Some(Section::of_html("members", "Members", lead, table(results, shown))),
        Section::provenance(run.provenance.as_ref()),
    ];
    let page = Page {
        title: run.name.clone(),
        intro: "One study with many values: report of a campaign by asperity.",
        first_screen: None,
        answers: answers(results),
        warnings: &results.warnings,
        sections: sections.into_iter().flatten().collect(),
        appendix: Vec::new(),
        script: SORT,
    };
    page.render()
}

fn answers(results: &CampaignResults) -> Vec<Answer> {
    let members = &results.members;
    let failed = members.iter().filter(|member| member.failed).count();
    let mut answers = vec![Answer {
        question: "How many members are compared?",
        answer: count(members.len()),
        detail: match failed {
            0 => "All have an answer.".into(),
            failed => format!("{} have none; the table states the reasons.", count(failed)),
        },
    }];
    let vibrating = members.iter().filter(|member| member.answers.vibrates == Some(true)).count();
    let judged = members.iter().filter(|member| member.answers.vibrates.is_some()).count();
    if judged > 0 {
        answers.push(Answer {
            question: "How many vibrate?",
            answer: format!("{} of {}", count(vibrating), count(judged)),
            detail: "Motion begins in stick; uncertain values are at their centres.".into(),
        });
    }
    let probabilities = members.iter().enumerate().filter_map(|(i, member)| Some((i + 1, member.answers.probability?)));
    let least = probabilities.clone().min_by(|a, b| a.1.total_cmp(&b.1));
    let largest = probabilities.max_by(|a, b| a.1.total_cmp(&b.1));
    if let (Some((least, low)), Some((largest, high))) = (least, largest) {
        answers.push(Answer {
            question: "How probable is vibration?",
            answer: format!("{} to {}", percent(low, 3), percent(high, 3)),
            detail: format!("Least in member {least}, largest in member {largest}."),
        });
    }
    answers
}

/// Column of the table: its title and the cells, each with the number by which it is sorted.
struct Column {
    title: String,
    cells: Vec<(String, Option<f64>)>,
}

impl Column {
    /// Returns a column of numbers in one unit, which the title names.
    fn numbers(title: &str, unit: &Unit, values: impl Iterator<Item = Option<f64>>) -> Self {
        let title = if unit.symbol.is_empty() { title.to_owned() } else { format!("{title} ({})", unit.symbol) };
        let cell = |value: Option<f64>| (value.map_or(DASH.into(), |v| significant(v / unit.si, 4)), value);
        Self { title, cells: values.map(cell).collect() }
    }

    fn texts(title: &str, texts: impl Iterator<Item = String>) -> Self {
        Self { title: title.into(), cells: texts.map(|text| (text, None)).collect() }
    }

    fn is_empty(&self) -> bool {
        self.cells.iter().all(|(text, _)| text == DASH)
    }
}

/// Returns the number of a value in SI; `None` for a text.
fn number(value: &InputValue) -> Option<f64> {
    match value {
        InputValue::Number(number) => Some(*number),
        InputValue::Name(_) => None,
    }
}

/// Returns the unit in which the values of a key are shown.
fn unit_of(key: &VariedKey, values: impl Iterator<Item = f64>) -> Unit {
    dimension(&key.unit).unit(values.map(f64::abs).fold(0.0, f64::max))
}

/// Returns a value with its unit, or a text.
fn shown(key: &VariedKey, value: &InputValue) -> String {
    match value {
        InputValue::Number(number) => dimension(&key.unit).show(*number),
        InputValue::Name(text) => text.clone(),
    }
}

/// Returns the table of the first members.
fn table(results: &CampaignResults, shown: usize) -> Html {
    let members = &results.members[..shown];
    let plain = Unit::none();
    let of = |answer: fn(&MemberResult) -> Option<f64>| members.iter().map(answer);
    let text = |answer: fn(&MemberResult) -> String| members.iter().map(answer);
    let mut columns = vec![
        Column::numbers("Member", &plain, (1..=shown).map(|number| Some(number as f64))),
        Column::texts("Scan", text(|member| member.scan.clone().unwrap_or_else(|| DASH.into()))),
    ];
    // Numbers of members have no digits to round.
    columns[0].cells.iter_mut().enumerate().for_each(|(place, cell)| cell.0 = (place + 1).to_string());
    for (place, key) in results.keys.iter().enumerate() {
        let values = || members.iter().map(|member| &member.values[place]);
        let title = named(&key.key);
        columns.push(match values().map(number).collect::<Option<Vec<f64>>>() {
            Some(numbers) => {
                let unit = unit_of(key, numbers.iter().copied());
                Column::numbers(&title, &unit, numbers.into_iter().map(Some))
            }
            None => Column::texts(&title, values().map(|value| self::shown(key, value))),
        });
    }
    columns.extend([
        Column::numbers("Friction coefficient", &plain, of(|member| member.answers.friction_mean)),
        Column::numbers("Its standard deviation", &plain, of(|member| member.answers.friction_std)),
        Column::numbers("Limit damping ratio", &plain, of(|member| member.answers.limit_damping_ratio)),
        Column::texts("Motion", text(|member| member.answers.kind.map_or(DASH, kind_in_words).into())),
        Column::texts("Vibrates", text(|member| yes_or_no(member.answers.vibrates).into())),
        Column {
            title: "Probability of vibration".into(),
            cells: of(|member| member.answers.probability).map(|p| (percent(p, 3), p)).collect(),
        },
        Column::texts(
            "95 % interval",
            text(|member| {
                let interval = member.answers.probability_interval;
                interval.map_or(DASH.into(), |[low, high]| format!("{} to {}", percent(low, 3), percent(high, 3)))
            }),
        ),
        Column::numbers("Warnings", &plain, of(|member| Some(member.answers.warnings? as f64))),
        Column::texts("Reason of the failure", text(|member| member.reason.clone().unwrap_or_else(|| DASH.into()))),
    ]);
    columns.retain(|column| !column.is_empty());
    let headers = columns.iter().map(|column| html!("<th scope=\"col\" data-sort=\"\">{}</th>", &column.title));
    let cell = |(text, value): &(String, Option<f64>)| match value {
        Some(value) => html!("<td data-value=\"{}\">{}</td>", format!("{value:?}"), text),
        None => html!("<td>{}</td>", text),
    };
    let rows = (0..shown).map(|row| {
        let cells = columns.iter().map(|column| cell(&column.cells[row]));
        html!("<tr>{}</tr>\n", cells.collect::<Html>())
    });
    html!(
        "<div class=\"table\">\n<table class=\"sortable\">\n<thead><tr>{}</tr></thead>\n<tbody>\n{}</tbody>\n</table>\n\
         <p class=\"source\">Source: <code>{}</code></p>\n</div>\n",
        headers.collect::<Html>(),
        rows.collect::<Html>(),
        SOURCE,
    )
}

/// Main answer of a member, by title and value.
type Quantity = (&'static str, fn(&MemberResult) -> Option<f64>);

/// Answers in the order in which the figure prefers them.
const QUANTITIES: [Quantity; 3] = [
    ("Probability of vibration", |member| member.answers.probability),
    ("Limit damping ratio", |member| member.answers.limit_damping_ratio),
    ("Friction coefficient", |member| member.answers.friction_mean),
];

/// Draws the main answer over the first key whose values are numbers, one curve for each choice of the other values; or over the members.
fn figure(results: &CampaignResults) -> Option<CaptionedFigure> {
    let members = &results.members;
    let (title, answer) = QUANTITIES.into_iter().find(|(_, answer)| members.iter().any(|m| answer(m).is_some()))?;
    let is_number = |place: usize| {
        let mut values = members.iter().map(|member| number(&member.values[place]));
        let first = values.next().flatten();
        first.is_some() && values.clone().all(|value| value.is_some()) && values.any(|value| value != first)
    };
    let over = (0..results.keys.len()).find(|place| is_number(*place));
    let at = |index: usize, member: &MemberResult| match over {
        Some(place) => number(&member.values[place]).unwrap_or(f64::NAN),
        None => (index + 1) as f64,
    };
    // Names of the curves in the order of their members, with their points.
    let mut curves: Vec<(String, Vec<(f64, f64)>)> = Vec::new();
    let is_sampled = over.is_some_and(|place| results.keys[place].sampled);
    for (index, member) in members.iter().enumerate() {
        let others = results.keys.iter().enumerate().filter(|(place, _)| Some(*place) != over && over.is_some());
        let words = others.map(|(place, key)| format!("{} {}", named(&key.key), shown(key, &member.values[place])));
        let name = words.chain(member.scan.clone().filter(|_| over.is_some())).collect::<Vec<_>>().join(", ");
        let name = if is_sampled { String::new() } else { name };
        let point = (at(index, member), answer(member).unwrap_or(f64::NAN));
        let known = curves.iter().rposition(|(known, _)| *known == name);
        match known {
            Some(place) => curves[place].1.push(point),
            None if curves.len() <= MOST_CURVES => curves.push((name, vec![point])),
            // Too many curves: they become points.
            None => curves[0].1.push(point),
        }
    }
    let is_curves = over.is_some() && !is_sampled && curves.len() <= MOST_CURVES;
    let all = || curves.iter().flat_map(|(_, points)| points);
    let x_ends = range(&all().map(|(x, _)| *x).collect::<Vec<_>>())?;
    let y_ends = range(&all().map(|(_, y)| *y).collect::<Vec<_>>())?;
    let x = match over.map(|place| &results.keys[place]) {
        Some(key) => {
            let mut name = named(&key.key);
            name.get_mut(..1).into_iter().for_each(str::make_ascii_uppercase);
            Axis::padded(&name, unit_of(key, [x_ends.0, x_ends.1].into_iter()), x_ends, 0.03)
        }
        None => Axis::padded("Member", Unit::none(), x_ends, 0.03),
    };
    let y = match title {
        "Probability of vibration" => Axis::linear(title, Unit::none(), (0.0, 1.0)),
        _ => Axis::padded(title, Unit::none(), y_ends, 0.06),
    };
    let mut chart = Chart::new(x, y);
    if is_curves {
        for (place, (name, mut points)) in curves.into_iter().enumerate() {
            points.sort_by(|a, b| a.0.total_cmp(&b.0));
            let (x, y): (Vec<f64>, Vec<f64>) = points.into_iter().unzip();
            chart.points(name, &x, &y, pen(place));
        }
    } else {
        let (x, y): (Vec<f64>, Vec<f64>) = curves.into_iter().flat_map(|(_, points)| points).unzip();
        chart.add("", Mark::Dots { x, y, radius: 3.0, colour: BLUE, opacity: 0.7 });
    }
    let failed = members.iter().filter(|member| answer(member).is_none()).count();
    let mut caption = match over {
        Some(_) if is_curves => "One point for each member.".to_owned(),
        Some(_) => "One point for each member; the members differ in other values as well.".to_owned(),
        None => "One point for each member, in the order of the table.".to_owned(),
    };
    match failed {
        0 => {}
        1 => caption += " One member has no value.",
        failed => caption += &format!(" {} members have no value.", count(failed)),
    }
    let figure = CaptionedFigure::from_charts("members", title, caption, 1, &[chart], &[]);
    figure.map(|figure| CaptionedFigure { sources: vec![SOURCE.into()], ..figure })
}

#[cfg(test)]
mod tests {
    use asperity_results::MemberAnswers;

    use super::*;

    /// Returns a campaign of two hardnesses and three damping ratios, the last of which has no answer.
    fn campaign() -> CampaignResults {
        let key = |key: &str, unit: &str| VariedKey { key: key.into(), unit: unit.into(), sampled: false };
        let member = |hardness_pa: f64, damping: f64| MemberResult {
            values: vec![InputValue::Number(damping), InputValue::Number(hardness_pa)],
            answers: MemberAnswers { probability: Some(0.9 - damping), ..MemberAnswers::default() },
            ..MemberResult::default()
        };
        let mut members: Vec<_> =
            [0.05, 0.1, 0.2].into_iter().flat_map(|d| [member(1e8, d), member(1.5e8, d)]).collect();
        let last = &mut members[5];
        (last.failed, last.reason, last.answers) = (true, Some("a <reason>".into()), MemberAnswers::default());
        CampaignResults {
            keys: vec![key("vibration.damping_ratio", ""), key("material.hardness", "Pa")],
            members,
            ..CampaignResults::default()
        }
    }

    #[test]
    fn the_page_has_a_sortable_row_for_each_member_and_a_curve_for_each_second_value() {
        let run = CampaignRun { name: "sweep".into(), results: campaign(), provenance: None };
        let Report { html, figures } = render_campaign(&run);
        assert_eq!(html.matches("<tr><td data-value=").count(), 6, "{html}");
        assert!(html.contains("<td data-value=\"150000000.0\">150</td>") && html.contains("hardness (MPa)"));
        assert!(html.contains("a &lt;reason&gt;") && html.contains("85 %") && !html.contains("Vibrates</th>"));
        let [figure] = figures.as_slice() else { panic!("{} figures", figures.len()) };
        for name in ["hardness 100", "hardness 150", "Damping ratio", "Probability of vibration"] {
            assert!(figure.svg.contains(name), "{name} is missing: {}", figure.svg);
        }
    }

    #[test]
    fn only_the_script_of_the_page_may_run() {
        let page = render_campaign(&CampaignRun { results: campaign(), ..CampaignRun::default() }).html;
        assert_eq!(page.matches("<script>").count(), 1);
        assert!(page.contains("default-src 'none'") && page.contains("script-src 'sha256-"), "{page}");
        let run = crate::render(&crate::Run::default()).unwrap().html;
        assert!(!run.contains("script"));
    }

    #[test]
    fn members_without_numbers_are_drawn_in_their_order() {
        let mut results = campaign();
        for member in &mut results.members {
            (member.scan, member.values) = (Some("a.x3p".into()), Vec::new());
        }
        results.keys.clear();
        let drawn = figure(&results).unwrap();
        assert!(drawn.svg.contains("Member") && drawn.caption.contains("One member has no value"), "{}", drawn.caption);
    }
}
