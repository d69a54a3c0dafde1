//! The verdict: the first screen of a page and the tables of its section.

mod drivers;
mod margin;
mod remedies;
pub(crate) mod rests_on;
mod risk;
pub(crate) mod text;

use asperity_results::{Assumed, Driver, InputKind, MachineModel, Quantiles, VerdictResult};

use crate::Run;
use crate::cells::{percent as table_percent, shown};
use crate::format::{Dimension, significant};
use crate::markup::{Html, html, with_code};
use crate::page::data_table::DataTable;
use crate::page::verdict::margin::Limits;
use crate::verdict::{
    Headline, MEAN_FRICTION, RARE, is_exact, largest_error, leading_range, not_stated, percent, sampled_percent,
    steady_sliding, unknown_values, vibration as vibration_event,
};
use crate::words::{between, capitalised, named, unbroken};

/// Returns the first screen: the verdict in one sentence, its numbers, and four cards. `chain` is shown below them.
pub(super) fn first_screen(run: &Run, verdict: &VerdictResult, chain: &Html) -> Html {
    let limits = Limits::new(run, verdict);
    let Headline { before, answer, after } = Headline::new(verdict);
    let class = match verdict.probability {
        p if p < 0.05 => "quiet",
        p if p < 0.35 => "unlikely",
        _ => "vibrates",
    };
    if verdict.friction_unresolved {
        return html!(
            "<section id=\"answer\" aria-label=\"Verdict\">\n<p class=\"headline\">{}<strong class=\"unlikely\">{}</strong>{}</p>\n\
             <div class=\"cards\">\n{}</div>\n{}</section>\n",
            before,
            answer,
            after,
            card("What it rests on", &rests_on::card(&verdict.rests_on, verdict.model)),
            chain,
        );
    }
    html!(
        "<section id=\"answer\" aria-label=\"Verdict\">\n<p class=\"headline\">{}<strong class=\"{}\">{}</strong>{}</p>\n\
         {}<div class=\"cards\">\n<div class=\"column\">\n{}{}</div>\n<div class=\"column\">\n{}{}</div>\n\
         </div>\n{}</section>\n",
        before,
        class,
        unbroken(&answer),
        after,
        numbers(run, verdict),
        card(&limits.title(run, verdict), &limits.picture(verdict)),
        card("What would stop it", &remedies::card(verdict)),
        card("What decides it", &drivers::card(verdict)),
        card("What it rests on", &rests_on::card(&verdict.rests_on, verdict.model)),
        chain,
    )
}

pub(crate) fn card(title: &str, content: &Html) -> Html {
    html!("<section class=\"card\">\n<h2>{}</h2>\n{}</section>\n", title, content)
}

/// Returns the lines below the headline: errors of the probability and steady sliding, what is not stated, and the vibration.
fn numbers(run: &Run, verdict: &VerdictResult) -> Html {
    let (mut sentences, mut lines) = (Vec::new(), Vec::new());
    let text = |text: String| Html::from(unbroken(&text));
    if is_exact(verdict) {
        sentences.extend(steady_sliding(verdict).map(|sliding| text(format!("{}.", capitalised(sliding)))));
        sentences.push(text(exact_values(run, verdict)));
    } else {
        if verdict.probability > 0.0 && verdict.probability < 1.0 {
            sentences.push(text(computed_to(verdict)));
        }
        sentences.extend(largest_error(verdict).map(|text| with_code(&unbroken(&text))));
        sentences.extend(half_of_the_time(verdict).map(text));
        sentences.extend(over_unknowns(verdict));
        let sliding = verdict.probability_from_steady_sliding.filter(|_| verdict.model == MachineModel::StickSlip);
        let interval = |sliding| verdict.probability_from_steady_sliding_interval.unwrap_or([sliding; 2]);
        sentences.extend(sliding.map(|sliding| {
            text(format!("Started from steady sliding: {}.", sampled_percent(sliding, interval(sliding))))
        }));
    }
    if verdict.leaves_out_fluctuation {
        sentences.push(text(MEAN_FRICTION.into()));
    }
    lines.push(("sub", sentences));
    lines.push(("sub", vibration(verdict).into_iter().collect()));
    let assumed = not_stated(verdict).into_iter().map(|value| text(format!("Not stated: {value}.")));
    let examples = verdict.rests_on.iter().filter(|input| input.kind == InputKind::Example).count();
    let examples = (examples > 0).then(|| format!("Not yours: {examples} of the values are those of the example."));
    lines.push(("sub assumed", examples.map(text).into_iter().chain(assumed).collect()));
    let line = |(class, sentences): (&'static str, Vec<Html>)| match sentences.len() {
        0 => Html::default(),
        _ => {
            let spaced = sentences.iter().map(|sentence| html!("{} ", sentence));
            html!("<p class=\"{}\">{}</p>\n", class, spaced.collect::<Html>())
        }
    };
    lines.into_iter().map(line).collect()
}

/// Returns how sure the answer of a machine of exact values is in sentences.
fn exact_values(run: &Run, verdict: &VerdictResult) -> String {
    let point = run.results.friction.as_ref().map(|friction| &friction.operating_point);
    let computed = point.filter(|point| point.mean_interval.is_some()).map_or_else(String::new, |point| {
        let mean = shown(Dimension::None, point.mean, point.mean_interval);
        format!(" The friction coefficient is computed: {mean}, with its 95 % interval.")
    });
    let sure = verdict.nominal.damping_margin_interval.map_or_else(String::new, |[low, high]| {
        let decided = low.signum() == high.signum();
        let follows = if decided { "do not change the answer" } else { "may change the answer" };
        let limit = verdict.nominal.limit_damping_ratio.filter(|_| verdict.model == MachineModel::StickSlip);
        let moved = limit.map_or_else(String::new, |limit| {
            let damping_ratio = limit + verdict.nominal.damping_margin;
            let [least, most] = [damping_ratio - high, damping_ratio - low].map(|limit| significant(limit, 3));
            format!(" put the limit between {least} and {most} and")
        });
        format!(" All errors of the computation{moved} {follows}, with 95 % confidence.")
    });
    format!("The study states no uncertain value, so there is no probability.{computed}{sure}")
}

/// Returns how many machines vibrate for at least half of the time in a sentence; `None` if friction does not fluctuate.
fn half_of_the_time(verdict: &VerdictResult) -> Option<String> {
    let found = percent(verdict.probability_half);
    verdict.friction_fluctuates.then(|| format!("{found} of the machines vibrate at least half of the time."))
}

/// Returns the range of the probability over the unknown values in a sentence, unless the headline states it.
fn over_unknowns(verdict: &VerdictResult) -> Option<Html> {
    let [low, high] = verdict.probability_range.filter(|_| leading_range(verdict).is_none())?;
    let (low, high) = (percent(low), percent(high));
    if low == high {
        return None;
    }
    let ends = format!("{low} and {high}");
    Some(html!("Over {} the probability lies between <strong>{}</strong>.", unknown_values(verdict), unbroken(&ends)))
}

/// Returns frequency and amplitudes of the machines that vibrate in a sentence.
fn vibration(verdict: &VerdictResult) -> Option<Html> {
    let machines = verdict.if_vibrating.as_ref()?;
    let shown = |dimension, quantiles: Option<Quantiles>| quantiles.map(|quantiles| between(dimension, quantiles));
    let (hertz, wide) = shown(Dimension::Frequency, machines.frequency_hz).unwrap_or_default();
    let amplitudes: Vec<String> = [
        shown(Dimension::Velocity, machines.velocity_amplitude_m_per_s),
        shown(Dimension::Length, machines.displacement_amplitude_m),
    ]
    .into_iter()
    .flatten()
    .map(|(middle, range)| format!("{middle}{range}"))
    .collect();
    let amplitudes = match amplitudes.is_empty() {
        true => String::new(),
        false => format!(", with amplitudes of {}", amplitudes.join(" and ")),
    };
    let (when, ranges) = match (verdict.friction_fluctuates, is_exact(verdict)) {
        // The cycles are those of machines with constant friction.
        (true, exact) => ("Its cycle without the fluctuation:", if exact { "" } else { "; ranges hold 90 %" }),
        (false, true) => ("It vibrates at", ""),
        (false, false) => ("If it vibrates:", "; ranges hold 90 %"),
    };
    Some(html!("{} <strong>{}</strong>{}{}{}.", when, hertz, wide, amplitudes, unbroken(ranges)))
}

/// Returns the error of the computation in a sentence: half the width of a symmetric interval, or the interval.
fn computed_to(verdict: &VerdictResult) -> String {
    let ([low, high], p) = (verdict.probability_interval, verdict.probability);
    if high < RARE {
        let [p, low, high] = [p, low, high].map(|p| significant(p, 2));
        return format!("The probability is {p} ({low} to {high}).");
    }
    let (below, above) = (p - low, high - p);
    let symmetric = below.min(above) > 0.7 * below.max(above);
    if symmetric && (0.05..0.95).contains(&p) {
        format!("Computed to ±{} percentage points (95 % interval).", significant(100.0 * below.max(above), 2))
    } else {
        // Two digits do not separate ends that are both near 1.
        let is_near_one = |p: f64| low > 0.9 && p < 0.999;
        let end = |p: f64| if is_near_one(p) { format!("{} %", significant(100.0 * p, 3)) } else { percent(p) };
        format!("Computed to between {} and {} (95 % interval).", end(low), end(high))
    }
}

/// Returns the tables of the section.
pub(super) fn tables(verdict: &VerdictResult) -> Vec<DataTable> {
    let driver = |driver: &Driver| {
        vec![
            named(&driver.input),
            shown(Dimension::None, driver.first_order, Some(driver.first_order_interval)),
            shown(Dimension::None, driver.total, Some(driver.total_interval)),
            shown(Dimension::None, driver.shapley, driver.shapley_interval),
            // The scatter of the samples makes a range that no value narrows slightly wider.
            table_percent(driver.range_reduction.map(|reduction| reduction.max(0.0)), 2),
        ]
    };
    let headers = ["Value", "First order", "Total", "Shapley effect", "Range narrows by"];
    let drivers = |caption: &str, drivers: &[Driver]| {
        DataTable::new(caption, &headers, drivers.iter().map(driver).collect()).without_empty_columns()
    };
    let guesses = verdict.guesses.iter().map(|guess| {
        vec![
            named(&guess.input),
            table_percent(guess.probability_at_q05, 2),
            table_percent(guess.probability_at_q95, 2),
        ]
    });
    vec![
        drivers(
            &format!(
                "Sensitivity of the margin {}: fractions of its variance, and how much the 5–95 % range narrows once the value is known",
                margin_of(verdict.model)
            ),
            &verdict.drivers,
        ),
        drivers(&format!("Sensitivity of the event: {}", vibration_event(verdict)), &verdict.event_drivers),
        DataTable::new(
            "Probability of vibration if an unknown value were at its 5 % or its 95 % quantile",
            &["Value", "At 5 %", "At 95 %"],
            guesses.collect(),
        ),
        DataTable::new(
            &format!(
                "Probability of {} with a number that the study does not state at the ends of its range",
                vibration_event(verdict)
            ),
            &["Value", "Default", "At the low end", "At the high end"],
            verdict.assumed.iter().map(assumed).collect(),
        ),
        rests_on::table(&verdict.rests_on),
    ]
}

/// Returns a number that the study does not state, with the probability at both ends of its range.
fn assumed(assumed: &Assumed) -> Vec<String> {
    let number = |value: f64| Dimension::None.show(value);
    let at = |end: usize| {
        let interval = assumed.probability_interval_at[end];
        let found =
            format!("{}: {}", number(assumed.range[end]), sampled_percent(assumed.probability_at[end], interval));
        let [low, high] = interval.map(percent);
        if low == high { found } else { format!("{found} ({low} to {high})") }
    };
    vec![named(&assumed.input), number(assumed.value), at(0), at(1)]
}

/// Returns the formula of the margin.
fn margin_of(model: MachineModel) -> &'static str {
    match model {
        MachineModel::StickSlip => "ζ − ζ_v",
        MachineModel::ModeCoupling => "μ_c − μ",
    }
}

/// Returns the section's first sentences.
pub(super) fn lead(model: MachineModel) -> &'static str {
    match model {
        MachineModel::StickSlip => {
            "How much each uncertain value decides, and every input. A machine vibrates if its damping ratio ζ is below the limit ζ_v."
        }
        MachineModel::ModeCoupling => {
            "How much each uncertain value decides, and every input. A machine flutters if its friction coefficient μ is above the \
             critical one μ_c."
        }
    }
}
