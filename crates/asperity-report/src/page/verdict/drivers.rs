//! The card of the values that decide the verdict.

use asperity_results::keys::DAMPING_RATIO;
use asperity_results::{Driver, InputValue, MachineModel, TurningPoint, VerdictResult};

use crate::cells::DASH;
use crate::format::{Dimension, significant};
use crate::markup::{Html, html};
use crate::verdict::is_exact;
use crate::words::{named, unbroken};

/// Number of values on the card.
const SHOWN: usize = 3;
/// Damping ratio in the example for a machine without damping.
const EXAMPLE: f64 = 0.03;
/// Relative change that is none.
const LEAST: f64 = 5e-4;
/// Fraction below which the scatter of a value does not decide.
const SMALL: f64 = 0.05;
/// Fraction below which no single measurement narrows the margin.
const LITTLE: f64 = 0.01;

/// Returns a fraction of the variance of the margin: the Shapley effect if values depend on each other, or the total index.
fn fraction(driver: &Driver) -> f64 {
    driver.shapley.unwrap_or(driver.total).clamp(0.0, 1.0)
}

/// Formats a fraction as a percentage.
fn percent(fraction: f64) -> String {
    if fraction > 0.0 && fraction < 1e-3 {
        return unbroken("< 0.1 %");
    }
    unbroken(&format!("{} %", significant(100.0 * fraction, if fraction < 0.01 { 1 } else { 2 })))
}

/// Returns the three largest drivers as bars, and the value to measure next.
pub(super) fn card(verdict: &VerdictResult) -> Html {
    let mut drivers: Vec<&Driver> = verdict.drivers.iter().collect();
    if is_exact(verdict) {
        return one_at_a_time(verdict);
    }
    if drivers.is_empty() {
        return html!("<p>The margin does not follow the uncertain values closely enough to rank them.</p>\n");
    }
    drivers.sort_by(|a, b| fraction(b).total_cmp(&fraction(a)));
    let bars = drivers.iter().take(SHOWN).map(|driver| {
        html!(
            "<li><span>{}</span><svg class=\"track\" viewBox=\"0 0 100 12\" preserveAspectRatio=\"none\" aria-hidden=\"true\"><rect class=\"bar\" width=\"{}\" height=\"12\"/></svg><span>{}</span></li>\n",
            named(&driver.input),
            format!("{:.1}", 100.0 * fraction(driver)),
            percent(fraction(driver)),
        )
    });
    let measure = if drivers.iter().any(|driver| driver.shapley.is_some()) {
        "Shapley effects"
    } else {
        "total Sobol’ indices"
    };
    let margin = match verdict.model {
        MachineModel::StickSlip => "damping ratio − limit",
        MachineModel::ModeCoupling => "critical friction coefficient − friction coefficient",
    };
    let is_unknown = |driver: &Driver| verdict.guesses.iter().any(|guess| guess.input == driver.input);
    let note = match (verdict.guesses.is_empty(), drivers.len()) {
        (false, _) if !is_unknown(drivers[0]) => " What varies from part to part is changed, not measured.".to_owned(),
        (_, count) if count > SHOWN => format!(" {} more values are in the details.", count - SHOWN),
        _ => String::new(),
    };
    let advised =
        verdict.remedies.first().and_then(|remedy| drivers.iter().find(|driver| driver.input == remedy.input));
    let scatter = match advised {
        Some(driver) if fraction(driver) < SMALL => " A value that hardly scatters may still be worth changing.",
        _ => "",
    };
    html!(
        "<ul class=\"bars\">\n{}</ul>\n<p>{}</p>\n<p class=\"note\">Bars: shares of the variance of the margin, {} ({}).{}{}</p>\n",
        bars.collect::<Html>(),
        next(verdict),
        margin,
        measure,
        note,
        scatter,
    )
}

/// Returns the values whose smallest change turns a machine without uncertain values, and how to make one of them uncertain.
fn one_at_a_time(verdict: &VerdictResult) -> Html {
    let points = turning_points(verdict);
    let rows = points.iter().take(SHOWN + 1).map(|&(point, value)| {
        let dimension = Dimension::of_unit(&point.unit);
        let change = significant(100.0 * (value / point.now - 1.0).abs(), 2);
        let change = unbroken(&format!("{}{change} %", if value > point.now { '+' } else { '−' }));
        let change = if point.now == 0.0 { DASH.to_owned() } else { change };
        let [now, then] = [point.now, value].map(|value| dimension.show_short(value));
        html!(
            "<tr><th scope=\"row\">{}</th><td>{}</td><td>{}</td><td>{}</td></tr>\n",
            named(&point.input),
            now,
            then,
            change
        )
    });
    let turns = if verdict.nominal.vibrates { "vibration ends at" } else { "vibration begins at" };
    let damping = verdict.rests_on.iter().find(|input| input.input == DAMPING_RATIO).map(|input| &input.value);
    let damping = match damping {
        Some(InputValue::Number(damping)) if *damping > 0.0 => *damping,
        _ => EXAMPLE,
    };
    let example = format!("damping_ratio = \"{} ± {}\"", significant(damping, 3), significant(0.1 * damping, 1));
    let how = html!(
        "<p class=\"note\">No value is uncertain. For a probability, state how well you know one, for example <code>{}</code> in \
         [vibration].</p>\n",
        example
    );
    if points.is_empty() {
        return how;
    }
    html!(
        "<table>\n<thead><tr><th scope=\"col\">one value alone</th><th scope=\"col\">now</th><th scope=\"col\">{}</th>\
         <th scope=\"col\">change</th></tr></thead>\n<tbody>\n{}</tbody>\n</table>\n{}",
        turns,
        rows.collect::<Html>(),
        how,
    )
}

/// Returns the turning points with their values, the smallest change first.
pub(super) fn turning_points(verdict: &VerdictResult) -> Vec<(&TurningPoint, f64)> {
    let found = verdict.turning_points.iter().filter_map(|point| Some((point, point.value?)));
    // A machine at its limit has no change to state.
    let mut found: Vec<_> = found.filter(|(point, value)| (value - point.now).abs() > LEAST * point.now).collect();
    let size = |(point, value): &(&TurningPoint, f64)| (value / point.now).ln().abs();
    found.sort_by(|a, b| size(a).total_cmp(&size(b)));
    found
}

/// Returns the unknown value whose measurement narrows the margin most. A value that varies from part to part keeps varying however well it is
/// measured, so without unknown values it returns the value whose tolerance matters most.
pub(super) fn next(verdict: &VerdictResult) -> Html {
    let reduction = |driver: &&Driver| driver.range_reduction.unwrap_or(0.0);
    let most = |wanted: &dyn Fn(&&Driver) -> bool| {
        let drivers = verdict.drivers.iter().filter(wanted).filter(|driver| reduction(driver) >= LITTLE);
        drivers.max_by(|a, b| reduction(a).total_cmp(&reduction(b)))
    };
    let is_unknown = |driver: &&Driver| verdict.guesses.iter().any(|guess| guess.input == driver.input);
    if let Some(driver) = most(&is_unknown) {
        if driver.input.ends_with(".scan") {
            return html!("A larger scan would shrink the margin’s range by {}.", percent(reduction(&driver)));
        }
        return html!(
            "Measure the <strong>{}</strong> next: the margin’s range would shrink by {}.",
            named(&driver.input),
            percent(reduction(&driver)),
        );
    }
    if !verdict.guesses.is_empty() {
        return html!("No single measurement of an unknown value would narrow the margin.");
    }
    match most(&|_| true) {
        Some(driver) => html!(
            "No uncertain value is unknown, so there is nothing to measure next. Parts with equal <strong>{}</strong> would shrink the margin’s range \
             by {}.",
            named(&driver.input),
            percent(reduction(&driver)),
        ),
        None => html!("No uncertain value is unknown, so there is nothing to measure next."),
    }
}
