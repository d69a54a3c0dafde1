//! The card of the changes that make vibration improbable.

use std::cmp::Ordering;

use asperity_results::keys::{DAMPING_RATIO, INERTIA, STATIC_FRICTION};
use asperity_results::{MachineModel, Reach, Remedy, VerdictResult};

use crate::cells::{DASH, plain, shown};
use crate::format::{Dimension, significant};
use crate::markup::{Html, html};
use crate::page::data_table::DataTable;
use crate::page::verdict::drivers::turning_points;
use crate::page::verdict::risk;
use crate::verdict::{is_exact, percent, vibration};
use crate::words::{capitalised, named, unbroken};

/// Relative change of the friction coefficient from which it is stated.
const VISIBLE: f64 = 0.005;

/// Returns one change in a sentence and the table of all of them.
pub(super) fn card(verdict: &VerdictResult) -> Html {
    let Some(first) = verdict.remedies.first() else { return unstated(verdict) };
    let headers = first.reach.iter().map(|reach| html!("<th scope=\"col\">for {}</th>", target(reach.probability)));
    html!(
        "<p>{}</p>\n<div class=\"remedies\"><div>\n<div class=\"scroll\" role=\"region\" tabindex=\"0\" aria-label=\"Remedies\"><table>\n<thead><tr><th scope=\"col\">change</th><th scope=\"col\">now</th>{}\
         {}</tr></thead>\n<tbody>\n{}</tbody>\n</table></div>\n\
         <p class=\"note\">Brackets are 95 % intervals of the computation.</p>\n</div>\n{}</div>\n",
        sentence(verdict),
        headers.collect::<Html>(),
        if changes_friction(verdict) { html!("<th scope=\"col\">friction left</th>") } else { Html::default() },
        verdict.remedies.iter().map(|remedy| row(remedy, changes_friction(verdict))).collect::<Html>(),
        risk::picture(verdict),
    )
}

fn target(probability: f64) -> String {
    unbroken(&format!("{} %", significant(100.0 * probability, 2)))
}

/// Returns the change that reaches the first target that is not met: the one whose curve is drawn, or else the smallest relative change.
pub(super) fn sentence(verdict: &VerdictResult) -> Html {
    let Some(first) = verdict.remedies.first() else { return Html::default() };
    let Some(place) = first.reach.iter().position(|reach| reach.probability < verdict.probability) else {
        let least = first.reach.iter().map(|reach| reach.probability).fold(1.0, f64::min);
        let (what, least_text) = (vibration(verdict), target(least));
        let most = verdict.probability_range.map_or(0.0, |[_, high]| high).max(verdict.probability_interval[1]);
        let text = if most > least && is_exact(verdict) {
            "At the printed friction coefficient nothing needs to change.".into()
        } else if most > least {
            format!(
                "On average nothing needs to change: {what} is at most {least_text} probable, but it may be {}.",
                percent(most)
            )
        } else {
            format!("Nothing needs to change: {what} is at most {least_text} probable.")
        };
        return html!("{}", text);
    };
    let wanted = first.reach[place].probability;
    let found = verdict.remedies.iter().filter_map(|remedy| Some((remedy, remedy.reach.get(place)?)));
    let size = |(remedy, reach): &(&Remedy, &Reach)| reach.value.map(|value| (value / remedy.now).ln().abs());
    let reached = found.filter_map(|change| Some((size(&change)?, change)));
    let order = |(size, (remedy, _)): &(f64, (&Remedy, &Reach))| (remedy.risk.is_empty(), *size);
    let Some((_, (remedy, reach))) = reached.min_by(|a, b| order(a).partial_cmp(&order(b)).unwrap_or(Ordering::Equal))
    else {
        return html!("{}", not_reached(&verdict.remedies, wanted));
    };
    let dimension = Dimension::of_unit(&remedy.unit);
    let then = reach
        .value
        .map_or_else(|| DASH.into(), |value| dimension.show_within(value, reach.value_interval.map(Into::into)));
    let short = |value: f64| dimension.show_short(value);
    let now = short(remedy.now);
    if reach.value.is_some_and(|value| short(value) == now) {
        let target = target(wanted);
        return html!(
            "The {} of {} hardly needs to change: {} is about {} probable.",
            named(&remedy.input),
            now,
            vibration(verdict),
            target
        );
    }
    let verb = if reach.value.is_some_and(|value| value > remedy.now) { "Raise" } else { "Lower" };
    let friction = match (remedy.friction_coefficient_now, reach.friction_coefficient) {
        (Some(now), Some(left)) if remedy.input != STATIC_FRICTION && (left / now - 1.0).abs() > VISIBLE => {
            format!(" The friction coefficient goes from {} to {}.", significant(now, 3), significant(left, 3))
        }
        _ => String::new(),
    };
    html!(
        "{} the <strong>{}</strong>{} from {} to <strong>{}</strong>: {} is then {} probable.{}",
        verb,
        named(&remedy.input),
        held(remedy),
        shown(dimension, remedy.now, None),
        then,
        vibration(verdict),
        target(wanted),
        friction,
    )
}

/// Returns the damping that a change of mass or natural frequency leaves as it is, behind the name of the input; empty for other inputs, which
/// change neither.
fn held(remedy: &Remedy) -> &'static str {
    match remedy.held.as_deref().filter(|_| INERTIA.contains(&remedy.input.as_str())) {
        Some("damper") => " (same damper in N s/m)",
        Some(_) => " (same damping ratio)",
        None => "",
    }
}

/// Returns that no remedy reaches a probability, in a sentence.
fn not_reached(remedies: &[Remedy], wanted: f64) -> String {
    let [remedy] = remedies else {
        return format!("No change reaches {} within its range.", target(wanted));
    };
    let [low, high] = remedy.range.map(|value| Dimension::of_unit(&remedy.unit).show_short(value));
    let name = named(&remedy.input);
    format!("No {name}{} from {low} to {high} reaches {}.", held(remedy), target(wanted))
}

/// Returns whether a change leaves another friction coefficient than the present one.
fn changes_friction(verdict: &VerdictResult) -> bool {
    let differs = |now: f64, left: f64| (left / now - 1.0).abs() > VISIBLE;
    verdict.remedies.iter().filter(|remedy| remedy.input != STATIC_FRICTION).any(|remedy| {
        let left = remedy.reach.iter().filter_map(|reach| reach.friction_coefficient);
        remedy.friction_coefficient_now.is_some_and(|now| left.into_iter().any(|left| differs(now, left)))
    })
}

fn row(remedy: &Remedy, with_friction: bool) -> Html {
    let mut cells = cells(remedy);
    cells.truncate(cells.len() - usize::from(!with_friction));
    let values = cells[1..].iter().map(|cell| html!("<td>{}</td>", cell));
    html!("<tr><th scope=\"row\">{}</th>{}</tr>\n", &cells[0], values.collect::<Html>())
}

/// Returns the change, the present value, the value for each target, and the friction coefficient that is left.
fn cells(remedy: &Remedy) -> Vec<String> {
    let dimension = Dimension::of_unit(&remedy.unit);
    let value = |reach: &Reach| match reach.value {
        Some(value) if value == remedy.now => "as it is".into(),
        Some(value) => shown(dimension, value, reach.value_interval),
        None => {
            let [low, high] = remedy.range.map(|value| dimension.show_short(value));
            format!("none from {low} to {high}")
        }
    };
    let left = remedy.reach.iter().find_map(|reach| reach.friction_coefficient).or(remedy.friction_coefficient_now);
    let mut cells = vec![format!("{}{}", named(&remedy.input), held(remedy)), shown(dimension, remedy.now, None)];
    cells.extend(remedy.reach.iter().map(value));
    cells.push(plain(left, 3));
    cells
}

/// Returns the table of all changes.
pub(super) fn table(verdict: &VerdictResult) -> DataTable {
    let targets = verdict.remedies.first().map_or(&[][..], |first| &first.reach);
    let mut headers = vec!["Change".to_owned(), "Now".into()];
    headers.extend(targets.iter().map(|reach| format!("For {}", target(reach.probability))));
    headers.push("Friction left".into());
    let headers: Vec<&str> = headers.iter().map(String::as_str).collect();
    DataTable::new("What would stop it", &headers, verdict.remedies.iter().map(cells).collect())
}

/// Returns the changes of damping and load that end the vibration of a machine without uncertain values, or that may be made without
/// starting it.
pub(super) fn of_one_machine(verdict: &VerdictResult) -> String {
    let [low, high] = verdict.probability_interval;
    let quiet = if low < high { "At the printed friction coefficient nothing" } else { "Nothing" };
    let usual = verdict.model.usual_changes();
    let changes = turning_points(verdict).into_iter().filter(|(point, _)| usual.contains(&point.input.as_str()));
    let changes = changes.map(|(point, value)| {
        let dimension = Dimension::of_unit(&point.unit);
        let [now, mut then] = [point.now, value].map(|value| dimension.show_short(value));
        if let Some(safe) = safe_damping(verdict).filter(|_| point.input == DAMPING_RATIO) {
            then = format!("{then} ({} with the error of the computation)", significant(safe, 3));
        }
        match (verdict.nominal.vibrates, value > point.now) {
            (true, true) => format!("a {} above {then} instead of {now}", named(&point.input)),
            (true, false) => format!("a {} below {then} instead of {now}", named(&point.input)),
            (false, true) => format!("the {} may rise from {now} to {then}", named(&point.input)),
            (false, false) => format!("the {} may fall from {now} to {then}", named(&point.input)),
        }
    });
    let changes: Vec<String> = changes.collect();
    match (changes.is_empty(), verdict.nominal.vibrates) {
        (true, true) => {
            format!("No change of {} or {} up to ten times ends the vibration.", named(usual[0]), named(usual[1]))
        }
        (true, false) => format!("{quiet} needs to change."),
        (false, true) => unbroken(&format!("{}.", capitalised(changes.join(", or ")))),
        (false, false) => unbroken(&format!("{quiet} needs to change: {}.", changes.join(", and "))),
    }
}

/// Returns the upper end of the interval of the damping ratio at which the vibration of one machine ends.
fn safe_damping(verdict: &VerdictResult) -> Option<f64> {
    let [low, _] = verdict.nominal.damping_margin_interval?;
    let limit = verdict.nominal.limit_damping_ratio.filter(|_| verdict.model == MachineModel::StickSlip)?;
    Some(limit + verdict.nominal.damping_margin - low)
}

/// Returns what to change of a machine without uncertain values, or how to ask for changes.
fn unstated(verdict: &VerdictResult) -> Html {
    const STATE: &str = "State remedies in [verdict] to compute changes of any value, with their intervals.";
    if is_exact(verdict) && !(verdict.friction_fluctuates && verdict.turning_points.is_empty()) {
        let fluctuates = "These are values of the mean friction coefficient: where friction fluctuates, vibration ends little by little. ";
        let how = if verdict.friction_fluctuates { fluctuates } else { "" };
        return html!("<p>{}</p>\n<p class=\"note\">{}{}</p>\n", of_one_machine(verdict), how, STATE);
    }
    let why = match verdict.friction_fluctuates {
        true => "Where friction fluctuates, changes take minutes and are computed only if the study states them. ",
        false => "The study asks for no changes. ",
    };
    html!("<p>{}{}</p>\n", why, STATE)
}
