//! The verdict in words.

use asperity_results::{ModelResult, VerdictResult};

use crate::format::{Dimension, significant};

/// Probability below which a number rests on the tails of the assumed distributions.
const RARE: f64 = 1e-3;

/// Returns the verdict in one sentence.
pub fn verdict_sentence(verdict: &VerdictResult) -> String {
    let nominal = &verdict.nominal;
    let kind = verdict
        .if_vibrating
        .as_ref()
        .and_then(|machines| machines.kinds.iter().max_by(|a, b| a.1.total_cmp(b.1)))
        .map_or(nominal.kind.name(), |(name, _)| name.as_str());
    let coupled = verdict.model == ModelResult::ModeCoupling;
    let noun = if coupled { "Squeal by mode coupling" } else { noun(kind) };
    if verdict.evaluations <= 1 {
        return if coupled { exact_coupled(verdict) } else { exact(verdict, noun) };
    }
    let event = if coupled { "flutter" } else { "vibrate, once started from standstill" };
    let [low, high] = verdict.probability_interval;
    let p = verdict.probability;
    let sliding = verdict.probability_from_steady_sliding;
    // A wide interval of a small probability reaches above it.
    if high < RARE {
        return format!(
            "{noun} is very improbable: fewer than 1 in 1,000 machines like this one {event}; the number \
             rests on the assumed tails."
        );
    }
    let word = match p {
        p if p < 0.05 => "improbable",
        p if p < 0.35 => "unlikely",
        p if p < 0.65 => "as likely as not",
        p if p < 0.95 => "likely",
        _ => "almost certain",
    };
    // Coupled modes flutter however their motion begins.
    let from_sliding = if coupled { String::new() } else { format!("; {} from steady sliding", percent(sliding)) };
    format!(
        "{noun} is {word}: {} ({} to {}) of machines like this one {event}{from_sliding}.",
        percent(p),
        percent(low),
        percent(high)
    )
}

/// Returns the verdict on a machine of two coupled modes whose values are all exact.
fn exact_coupled(verdict: &VerdictResult) -> String {
    let margin = verdict.nominal.damping_margin;
    let distance = significant(margin.abs(), 3);
    if verdict.nominal.vibrates {
        format!(
            "The machine squeals by mode coupling: its friction coefficient is {distance} above the critical one. No value is uncertain."
        )
    } else {
        format!(
            "The machine does not squeal by mode coupling: its friction coefficient is {distance} below the critical one."
        )
    }
}

/// Returns the verdict on a machine whose values are all exact.
fn exact(verdict: &VerdictResult, noun: &str) -> String {
    let nominal = &verdict.nominal;
    let limit = nominal.limit_damping_ratio.map_or_else(String::new, |limit| significant(limit, 3));
    if !nominal.vibrates {
        return format!("The machine does not vibrate: its damping ratio is above the limit of {limit}.");
    }
    let sliding = if nominal.steady_sliding_unstable {
        "from steady sliding, too".to_owned()
    } else {
        let kick = nominal.kick_m_per_s.map_or_else(String::new, |kick| {
            format!(", unless a kick of {} starts it", Dimension::Velocity.show(kick))
        });
        format!("steady sliding stays quiet{kick}")
    };
    format!(
        "The machine vibrates ({}), once started from standstill; {sliding}. No value is uncertain.",
        noun.to_lowercase()
    )
}

fn noun(kind: &str) -> &'static str {
    match kind {
        "overtaking" => "Vibration faster than the belt",
        "slip_cycle" => "Vibration without stick",
        "stick_slip" => "Stick–slip",
        _ => "Vibration",
    }
}

fn percent(probability: f64) -> String {
    if probability <= 0.0 {
        return "0 %".into();
    }
    if probability < 1e-3 {
        return "less than 0.1 %".into();
    }
    if probability > 1.0 - RARE && probability < 1.0 {
        return "more than 99.9 %".into();
    }
    format!("{} %", significant(100.0 * probability, if probability > 0.99 { 3 } else { 2 }))
}
