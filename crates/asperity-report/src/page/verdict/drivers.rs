//! The card of the values that decide the verdict.

use asperity_results::{Driver, MachineModel, VerdictResult};

use crate::format::significant;
use crate::markup::{Html, html};
use crate::verdict::is_exact;
use crate::words::{named, unbroken};

/// Number of values on the card.
const SHOWN: usize = 3;
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
    if drivers.is_empty() {
        let reason = if is_exact(verdict) {
            "No value is uncertain. State how well you know damping, friction and load, for example damping_ratio = \"0.03 ± 0.005\", \
             to see which value decides."
        } else {
            "The margin does not follow the uncertain values closely enough to rank them."
        };
        return html!("<p>{}</p>\n", reason);
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
        "Total Sobol’ indices"
    };
    let margin = match verdict.model {
        MachineModel::StickSlip => "damping ratio − limit",
        MachineModel::ModeCoupling => "critical friction coefficient − friction coefficient",
    };
    let others = match drivers.len() {
        count if count > SHOWN => format!("; {} more in the details", count - SHOWN),
        _ => String::new(),
    };
    html!(
        "<ul class=\"bars\">\n{}</ul>\n<p>{}</p>\n<p class=\"note\">{} of the margin, {}: fractions of its variance{}.</p>\n",
        bars.collect::<Html>(),
        next(verdict),
        measure,
        margin,
        others,
    )
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
            "No value is unknown, so there is nothing to measure next. Parts with equal <strong>{}</strong> would shrink the margin’s range \
             by {}.",
            named(&driver.input),
            percent(reduction(&driver)),
        ),
        None => html!("No value is unknown, so there is nothing to measure next."),
    }
}
