//! The verdict: its answer and its tables.

use asperity_results::{Driver, Guess, ModelResult, Quantiles, Reach, Remedy, VerdictResult};

use super::cells::{percent, plain, shown};
use super::{Answer, DataTable};
use crate::format::Dimension;
use crate::verdict_sentence;

const SOURCE: &str = "results.json";

/// Returns the headline answer.
pub(super) fn answer(verdict: &VerdictResult) -> Answer {
    let mut detail = String::new();
    if let Some(Quantiles { q05, q95, .. }) = verdict.probability_over_unknowns {
        detail += &format!("With the unknown values, it lies between {} and {}. ", percent(q05, 2), percent(q95, 2));
    }
    if let Some(machines) = &verdict.if_vibrating {
        let between =
            |Quantiles { q05, q50, q95 }: Quantiles, dimension: Dimension| shown(dimension, q50, Some([q05, q95]));
        detail += &format!(
            "Machines that vibrate: {} Hz, {}, {} (medians; brackets hold 90 % of them). ",
            between(machines.frequency_hz, Dimension::None),
            between(machines.velocity_amplitude_m_per_s, Dimension::Velocity),
            between(machines.displacement_amplitude_m, Dimension::Length),
        );
    }
    if let Some(driver) = verdict.drivers.iter().max_by(|a, b| a.total.total_cmp(&b.total)) {
        detail += &format!("What decides it most: {}. ", words(&driver.input));
    }
    if let Some(Guess { input, .. }) = verdict.guesses.first() {
        detail += &format!("It rests on {}, which is unknown.", words(input));
    }
    Answer {
        question: "Does a machine like this one vibrate?",
        answer: verdict_sentence(verdict).replace(" %", "\u{a0}%"),
        detail,
    }
}

/// Returns the tables.
pub(super) fn tables(verdict: &VerdictResult) -> Vec<DataTable> {
    let driver = |driver: &Driver| {
        vec![
            words(&driver.input),
            shown(Dimension::None, driver.first_order, Some(driver.first_order_interval)),
            shown(Dimension::None, driver.total, Some(driver.total_interval)),
            shown(Dimension::None, driver.shapley, driver.shapley_interval),
            percent(driver.range_reduction, 2),
        ]
    };
    let headers = ["Value", "First order", "Total", "Shapley effect", "Range narrows by"];
    let drivers = |caption: &str, drivers: &[Driver]| {
        DataTable::new(caption, &headers, drivers.iter().map(driver).collect(), SOURCE).without_empty_columns()
    };
    let guesses = verdict.guesses.iter().map(|guess| {
        vec![words(&guess.input), percent(guess.probability_at_q05, 2), percent(guess.probability_at_q95, 2)]
    });
    vec![
        DataTable::new(
            "Changes after which vibration is improbable; brackets are the 95 % interval of the computation",
            &["Change", "Now", "Probability", "Value", "Friction coefficient left"],
            verdict.remedies.iter().flat_map(remedy).collect(),
            SOURCE,
        ),
        drivers(
            &format!(
                "Sensitivity of the margin {}: fractions of its variance, and how much the 5–95 % range narrows once the value is known",
                margin(verdict.model)
            ),
            &verdict.drivers,
        ),
        drivers("Sensitivity of the event that a machine vibrates", &verdict.event_drivers),
        DataTable::new(
            "Probability of vibration if an unknown value were at its 5 % or its 95 % quantile",
            &["Value", "At 5 %", "At 95 %"],
            guesses.collect(),
            SOURCE,
        ),
    ]
}

fn remedy(remedy: &Remedy) -> Vec<Vec<String>> {
    let dimension = dimension(&remedy.unit);
    let row = |reach: &Reach| {
        vec![
            words(&remedy.input),
            shown(dimension, remedy.now, None),
            percent(reach.probability, 2),
            if reach.value.is_some() {
                shown(dimension, reach.value, reach.value_interval)
            } else {
                "not in the range".into()
            },
            plain(reach.friction_coefficient, 3),
        ]
    };
    remedy.reach.iter().map(row).collect()
}

/// Returns the formula of the margin.
fn margin(model: ModelResult) -> &'static str {
    match model {
        ModelResult::StickSlip => "ζ − ζ_v",
        ModelResult::ModeCoupling => "μ_c − μ",
    }
}

/// Returns the section's first sentences.
pub(super) fn lead(model: ModelResult) -> String {
    let event = match model {
        ModelResult::StickSlip => "A machine vibrates if its damping ratio ζ is below the limit ζ_v.",
        ModelResult::ModeCoupling => "A machine flutters if its friction coefficient μ is above the critical one μ_c.",
    };
    format!(
        "How probable vibration is over the uncertain values of the study, what decides it, and what changes it. {event}"
    )
}

/// Returns the dimension of an SI unit.
pub(crate) fn dimension(unit: &str) -> Dimension {
    match unit {
        "m" => Dimension::Length,
        "m^2" => Dimension::Area,
        "Pa" => Dimension::Pressure,
        "kg" => Dimension::Mass,
        "N" => Dimension::Force,
        "m/s" => Dimension::Velocity,
        "rad/s" => Dimension::AngularFrequency,
        "s/m" => Dimension::Other("s/m"),
        _ => Dimension::None,
    }
}

/// Returns the words of a value's name, `vibration.damping_ratio`.
pub(crate) fn words(input: &str) -> String {
    input.rsplit_once('.').map_or(input, |(_, key)| key).replace('_', " ")
}
