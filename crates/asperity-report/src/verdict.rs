//! The verdict in words.

use asperity_results::{ModelResult, VerdictResult};

use crate::format::{Dimension, significant};

/// Probability below which a number rests on the tails of the assumed distributions.
pub(crate) const RARE: f64 = 1e-3;

/// The verdict in one sentence of three parts.
pub(crate) struct Headline {
    pub(crate) before: String,
    /// The answer.
    pub(crate) answer: String,
    pub(crate) after: String,
}

impl Headline {
    /// Returns the verdict without the errors of its numbers.
    pub(crate) fn new(verdict: &VerdictResult) -> Self {
        let (noun, p) = (noun(verdict), verdict.probability);
        let part = str::to_owned;
        let coupled = verdict.model == ModelResult::ModeCoupling;
        if is_exact(verdict) && coupled {
            let distance = significant(verdict.nominal.damping_margin.abs(), 3);
            let (answer, side) =
                if verdict.nominal.vibrates { ("squeals", "above") } else { ("does not squeal", "below") };
            let after = format!(" by mode coupling: its friction coefficient is {distance} {side} the critical one.");
            return Self { before: part("The machine "), answer: part(answer), after };
        }
        if is_exact(verdict) {
            return if verdict.nominal.vibrates {
                let after = format!(" ({}), once started from standstill.", noun.to_lowercase());
                Self { before: part("The machine "), answer: part("vibrates"), after }
            } else {
                let limit = verdict.nominal.limit_damping_ratio.map_or_else(String::new, |limit| significant(limit, 3));
                let after = format!(": its damping ratio is not below the limit of {limit}.");
                Self { before: part("The machine "), answer: part("does not vibrate"), after }
            };
        }
        let before = format!("{noun} is ");
        let event = if coupled { "flutter" } else { "vibrate, once started from standstill" };
        // A wide interval of a small probability reaches above it.
        if verdict.probability_interval[1] < RARE {
            let after = format!(
                ": fewer than 1 in 1,000 machines like this one {event}; the number rests on the assumed tails."
            );
            return Self { before, answer: part("very improbable"), after };
        }
        let word = match p {
            p if p < 0.05 => "improbable",
            p if p < 0.35 => "unlikely",
            p if p < 0.65 => "as likely as not",
            p if p < 0.95 => "likely",
            _ => "almost certain",
        };
        let after = format!(" of machines like this one {event}.");
        Self { before, answer: format!("{word}: {}", percent(p)), after }
    }
}

/// Returns whether no value of the study is uncertain.
pub(crate) fn is_exact(verdict: &VerdictResult) -> bool {
    verdict.evaluations <= 1
}

/// Sentence of a verdict that leaves out the fluctuation of friction.
pub(crate) const MEAN_FRICTION: &str =
    "The mean friction coefficient decides; its fluctuation along the path is left out.";

/// Returns the verdict in one sentence, with a second one if it leaves out the fluctuation of friction.
pub fn verdict_sentence(verdict: &VerdictResult) -> String {
    let sentence = probability_sentence(verdict);
    if verdict.leaves_out_fluctuation { format!("{sentence} {MEAN_FRICTION}") } else { sentence }
}

fn probability_sentence(verdict: &VerdictResult) -> String {
    let Headline { before, answer, after } = Headline::new(verdict);
    let sentence = format!("{before}{answer}{after}");
    if is_exact(verdict) {
        return match steady_sliding(verdict) {
            Some(sliding) => format!("{}; {sliding}. No value is uncertain.", sentence.trim_end_matches('.')),
            None if verdict.nominal.vibrates => format!("{sentence} No value is uncertain."),
            None => sentence,
        };
    }
    let [low, high] = verdict.probability_interval;
    if high < RARE {
        return sentence;
    }
    let interval = match low > 1.0 - RARE {
        true => String::new(),
        false => format!(" ({} to {})", percent(low), percent(high)),
    };
    if verdict.model == ModelResult::ModeCoupling {
        // Coupled modes flutter however their motion begins.
        return format!("{before}{answer}{interval}{after}");
    }
    let after = after.trim_end_matches('.');
    let sliding = percent(verdict.probability_from_steady_sliding);
    format!("{before}{answer}{interval}{after}; {sliding} from steady sliding.")
}

/// Returns a phrase on steady sliding in a machine of exact values that vibrates; `None` for a quiet machine.
pub(crate) fn steady_sliding(verdict: &VerdictResult) -> Option<String> {
    let nominal = &verdict.nominal;
    if !nominal.vibrates || verdict.model == ModelResult::ModeCoupling {
        return None;
    }
    if nominal.steady_sliding_unstable {
        return Some("from steady sliding, too".into());
    }
    let kick = nominal
        .kick_m_per_s
        .map_or_else(String::new, |kick| format!(", unless a kick of {} starts it", Dimension::Velocity.show(kick)));
    Some(format!("steady sliding stays quiet{kick}"))
}

/// Returns the noun for the most frequent kind of vibration.
pub(crate) fn noun(verdict: &VerdictResult) -> &'static str {
    if verdict.model == ModelResult::ModeCoupling {
        return "Squeal by mode coupling";
    }
    let kind = verdict
        .if_vibrating
        .as_ref()
        .and_then(|machines| machines.kinds.iter().max_by(|a, b| a.1.total_cmp(b.1)))
        .map_or(verdict.nominal.kind.name(), |(name, _)| name.as_str());
    match kind {
        "overtaking" => "Vibration faster than the belt",
        "slip_cycle" => "Vibration without stick",
        "stick_slip" => "Stick-slip",
        _ => "Vibration",
    }
}

/// Formats a probability as a percentage.
pub(crate) fn percent(probability: f64) -> String {
    if probability <= 0.0 {
        return "0 %".into();
    }
    if probability < RARE {
        return "less than 0.1 %".into();
    }
    if probability > 1.0 - RARE && probability < 1.0 {
        return "more than 99.9 %".into();
    }
    format!("{} %", significant(100.0 * probability, if probability > 0.99 { 3 } else { 2 }))
}
