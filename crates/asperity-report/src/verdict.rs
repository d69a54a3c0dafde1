//! The verdict in words.

use asperity_results::choice::Choice;
use asperity_results::keys::STATIC_FRICTION;
use asperity_results::{Assumed, ErrorCause, ErrorSource, Guess, InputValue, MachineModel, MotionKind, VerdictResult};

use crate::format::{Dimension, significant};
use crate::words::{between, named};

/// Probability below which a number rests on the tails of the assumed distributions.
pub(crate) const RARE: f64 = 1e-3;

/// Effect of an unknown value on the probability, relative to the largest, below which it is not named.
const LITTLE: f64 = 0.1;

/// Words for probabilities close to 0 and 1.
const VERY_UNLIKELY: &str = "very unlikely";
const VERY_LIKELY: &str = "very likely";

/// Change of the probability that turns the answer into its opposite.
const REVERSAL: f64 = 0.5;

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
        let stated = Self::with_intervals(verdict, &|_| String::new());
        let after = stated.after + &condition(verdict);
        Self { after, ..stated }
    }

    /// Returns the verdict. `interval` writes the interval of a number behind it.
    fn with_intervals(verdict: &VerdictResult, interval: &dyn Fn([f64; 2]) -> String) -> Self {
        let noun = noun(verdict);
        if verdict.friction_unresolved {
            let causes = verdict.unresolved_by.iter().map(|cause| match cause {
                ErrorCause::Model => "the random strips do not stand for the scan",
                _ => "the pitch of the strips does not resolve the friction coefficient",
            });
            let causes = match causes.collect::<Vec<_>>().join(", and ") {
                causes if causes.is_empty() => "the friction coefficient is not resolved".into(),
                causes => causes,
            };
            let after = format!(": {causes}; the warnings say what would help.");
            return Self { before: String::new(), answer: "No verdict yet".into(), after };
        }
        if is_exact(verdict) {
            return Self::of_one_machine(verdict, noun, interval);
        }
        // The cycles of machines with fluctuating friction are those without the fluctuation.
        let hertz = verdict.if_vibrating.as_ref().filter(|_| !verdict.friction_fluctuates).and_then(|m| m.frequency_hz);
        let hertz = hertz.map_or_else(String::new, |hertz| {
            format!(" at {}", between(Dimension::Frequency, hertz).0.replace('\u{a0}', " "))
        });
        let before = format!("{noun}{hertz} is ");
        let coupled = verdict.model == MachineModel::ModeCoupling;
        let event =
            if coupled { "flutter".into() } else { format!("{}, once started from standstill", vibrate(verdict)) };
        let range = leading_range(verdict);
        let highest = range.map_or(verdict.probability_interval[1], |[_, high]| high);
        // A wide interval of a small probability reaches above it.
        if highest < RARE {
            let after = format!(
                ": fewer than 1 in 1,000 machines like this one {event}; the number rests on the assumed tails."
            );
            return Self { before, answer: "extremely unlikely".into(), after };
        }
        let own = sampled(verdict.probability, verdict.probability_interval, interval);
        let (word, machines, after) = match range {
            Some([low, high]) => {
                let (word, average) = match [word(low), word(high)] {
                    [VERY_UNLIKELY, VERY_LIKELY] => ("not known", "is your degree of belief"),
                    [low, high] if low == high => (low, "on average"),
                    _ => ("uncertain", "on average"),
                };
                let after = format!("{event}, depending on {}; {own} {average}", unknown_values(verdict));
                (word, format!("{} to {}", percent(low), percent(high)), after)
            }
            None => (word(verdict.probability), own, event),
        };
        if verdict.friction_fluctuates {
            let share = percent(verdict.expected_vibration_share);
            let error = interval(verdict.expected_vibration_share_interval);
            let after = format!("{error} of the time on average; {machines} of machines like this one {after}.");
            return Self { before, answer: format!("{word}: {share}"), after };
        }
        Self { before, answer: format!("{word}: {machines}"), after: format!(" of machines like this one {after}.") }
    }

    /// Returns the verdict on a machine whose values are all exact.
    fn of_one_machine(verdict: &VerdictResult, noun: &str, interval: &dyn Fn([f64; 2]) -> String) -> Self {
        let before = String::from("The machine ");
        let [low, high] = verdict.probability_interval;
        let coupled = verdict.model == MachineModel::ModeCoupling;
        if low < high && (coupled || !verdict.friction_fluctuates) {
            let answer = if coupled { "may squeal" } else { "may vibrate" };
            let after = ": the error of its friction coefficient decides.";
            return Self { before, answer: answer.into(), after: after.into() };
        }
        if coupled {
            let answer = if verdict.nominal.vibrates { "squeals" } else { "does not squeal" };
            let friction =
                verdict.rests_on.iter().find(|input| input.input == STATIC_FRICTION).map(|input| &input.value);
            let of_limit = match friction {
                Some(InputValue::Number(friction)) => {
                    let critical = friction + verdict.nominal.damping_margin;
                    let [friction_text, limit] = [*friction, critical].map(|value| significant(value, 3));
                    format!("of {friction_text} is {} the critical {limit}", part_of(friction / critical))
                }
                _ => {
                    let side = if verdict.nominal.vibrates { "above" } else { "below" };
                    format!("is {} {side} the critical one", significant(verdict.nominal.damping_margin.abs(), 3))
                }
            };
            let after = format!(" by mode coupling: its friction coefficient {of_limit}.");
            return Self { before, answer: answer.into(), after };
        }
        if verdict.friction_fluctuates {
            let answer = format!("vibrates {} of the time", percent(verdict.expected_vibration_share));
            let error = interval(verdict.expected_vibration_share_interval);
            return Self { before, answer, after: format!("{error}, once started from standstill.") };
        }
        let limit = verdict.nominal.limit_damping_ratio.unwrap_or_default();
        let damping = limit + verdict.nominal.damping_margin;
        let [damping_text, limit_text] = [damping, limit].map(|ratio| significant(ratio, 3));
        let damping = format!("its damping ratio of {damping_text} is {}", part_of(damping / limit));
        if verdict.nominal.vibrates {
            let from = match verdict.nominal.steady_sliding_unstable {
                true => "from standstill and from steady sliding",
                false => "once started from standstill",
            };
            let after = format!(" ({}), {from}: {damping} the {limit_text} that it needs.", noun.to_lowercase());
            return Self { before, answer: "vibrates".into(), after };
        }
        let after = if limit > 0.0 { format!(": {damping} the {limit_text} that it needs.") } else { ".".into() };
        Self { before, answer: "does not vibrate".into(), after }
    }
}

/// Returns a sentence on a number that the study does not state if another value of it turns the answer into its opposite; else nothing.
fn condition(verdict: &VerdictResult) -> String {
    let [low, high] = verdict.probability_interval;
    let reverses = |other: &f64| (other - verdict.probability).abs() > REVERSAL;
    let mut reversing = verdict.assumed.iter().filter(|assumed| assumed.probability_at.iter().any(reverses));
    match reversing.next().filter(|_| !verdict.friction_unresolved && high - low <= REVERSAL) {
        Some(assumed) => format!(
            " This holds if the {} is {}, which the study does not state.",
            named(&assumed.input),
            Dimension::None.show(assumed.value)
        ),
        None => String::new(),
    }
}

/// Returns a ratio as a part or a multiple, before the whole.
fn part_of(ratio: f64) -> String {
    match ratio {
        ratio if (ratio - 1.0).abs() < 0.005 => "just about".into(),
        // A percentage would be read as a probability.
        ratio if (ratio - 0.5).abs() < 0.01 => "half of".into(),
        ratio if ratio < 1.0 => format!("{} % of", significant(100.0 * ratio, 2)),
        ratio => format!("{} times", significant(ratio, if ratio < 1.1 { 3 } else { 2 })),
    }
}

/// Returns the word for a probability.
fn word(probability: f64) -> &'static str {
    match probability {
        p if p < 0.05 => VERY_UNLIKELY,
        p if p < 0.45 => "unlikely",
        p if p <= 0.55 => "as likely as not",
        p if p <= 0.95 => "likely",
        _ => VERY_LIKELY,
    }
}

/// Returns the range of the probability over the unknown values, if it is wider than the error of the computation.
pub(crate) fn leading_range(verdict: &VerdictResult) -> Option<[f64; 2]> {
    let width = |[low, high]: [f64; 2]| high - low;
    verdict.probability_range.filter(|range| width(*range) > width(verdict.probability_interval))
}

/// Returns a name for the unknown values that matter: those that change the probability by more than a tenth of what the strongest one does.
pub(crate) fn unknown_values(verdict: &VerdictResult) -> String {
    let effect = |guess: &Guess| (guess.probability_at_q95 - guess.probability_at_q05).abs();
    let most = verdict.guesses.iter().map(effect).fold(0.0, f64::max);
    let decisive: Vec<&Guess> = verdict.guesses.iter().filter(|guess| effect(guess) >= LITTLE * most).collect();
    match decisive.as_slice() {
        [guess] if guess.input.ends_with(".scan") => "the limited scan".into(),
        [guess] => format!("the unknown {}", named(&guess.input)),
        guesses => format!("the {} unknown values", guesses.len()),
    }
}

/// Returns the largest error of the probability in a sentence, with what makes it smaller; `None` for a negligible one and for a
/// machine without uncertain values.
pub(crate) fn largest_error(verdict: &VerdictResult) -> Option<String> {
    let negligible = RARE.min(0.1 * verdict.probability);
    let source = verdict.error_sources.first().filter(|source| source.half_width >= negligible && !is_exact(verdict));
    let ErrorSource { source, half_width } = source?;
    let which = match verdict.error_sources.len() {
        1 => "Error".to_owned(),
        count => format!("Largest of {count} errors"),
    };
    Some(format!(
        "{which} of the probability: {}, up to {} percentage points; to reduce it, {}.",
        source.words(),
        significant(100.0 * half_width, 2),
        source.remedy()
    ))
}

/// Returns a fraction of the time in words: `a tenth of the time`.
pub(crate) fn of_the_time(fraction: f64) -> String {
    let part = match fraction {
        0.1 => "a tenth".into(),
        0.25 => "a quarter".into(),
        0.5 => "half".into(),
        fraction => percent(fraction),
    };
    format!("{part} of the time")
}

/// Returns the event of a machine, as a verb in the plural.
fn vibrate(verdict: &VerdictResult) -> String {
    if verdict.friction_fluctuates {
        format!("vibrate more than {}", of_the_time(verdict.vibration_threshold))
    } else {
        "vibrate".into()
    }
}

/// Returns the event of a machine, as a noun.
pub(crate) fn vibration(verdict: &VerdictResult) -> String {
    if verdict.friction_fluctuates {
        format!("vibration for more than {}", of_the_time(verdict.vibration_threshold))
    } else {
        "vibration".into()
    }
}

/// Returns whether no value of the study is uncertain.
pub(crate) fn is_exact(verdict: &VerdictResult) -> bool {
    verdict.evaluations <= 1
}

/// Sentence of a verdict that leaves out the fluctuation of friction.
pub(crate) const MEAN_FRICTION: &str =
    "The mean friction coefficient decides; its fluctuation along the path is left out.";

/// Returns the part of [`verdict_sentence`] that is the answer.
pub fn verdict_answer(verdict: &VerdictResult) -> String {
    Headline::with_intervals(verdict, &interval_in_words).answer
}

/// Returns the verdict in one sentence, with a second one if it leaves out the fluctuation of friction.
pub fn verdict_sentence(verdict: &VerdictResult) -> String {
    let sentence = probability_sentence(verdict) + &condition(verdict);
    if verdict.leaves_out_fluctuation { format!("{sentence} {MEAN_FRICTION}") } else { sentence }
}

/// Writes the interval of a number behind it; nothing for one that is certain or exact.
fn interval_in_words([low, high]: [f64; 2]) -> String {
    let [low_text, high_text] = [low, high].map(percent);
    match low > 1.0 - RARE || low_text == high_text {
        true => String::new(),
        false => format!(" ({low_text} to {high_text})"),
    }
}

fn probability_sentence(verdict: &VerdictResult) -> String {
    let Headline { before, answer, after } = Headline::with_intervals(verdict, &interval_in_words);
    let sentence = format!("{before}{answer}{after}");
    if verdict.friction_unresolved {
        return sentence;
    }
    if is_exact(verdict) {
        return match steady_sliding(verdict) {
            Some(sliding) => format!("{}; {sliding}. No value is uncertain.", sentence.trim_end_matches('.')),
            None if verdict.nominal.vibrates || verdict.friction_fluctuates => {
                format!("{sentence} No value is uncertain.")
            }
            None => sentence,
        };
    }
    let is_rare = leading_range(verdict).unwrap_or(verdict.probability_interval)[1] < RARE;
    match verdict.probability_from_steady_sliding {
        // Coupled modes flutter however their motion begins.
        Some(sliding) if !is_rare && verdict.model == MachineModel::StickSlip => {
            let sliding =
                sampled_percent(sliding, verdict.probability_from_steady_sliding_interval.unwrap_or([sliding; 2]));
            format!("{}; {sliding} from steady sliding.", sentence.trim_end_matches('.'))
        }
        _ => sentence,
    }
}

/// Returns a phrase on steady sliding in a machine of exact values that vibrates; `None` for a quiet machine.
pub(crate) fn steady_sliding(verdict: &VerdictResult) -> Option<String> {
    let nominal = &verdict.nominal;
    if !nominal.vibrates || verdict.friction_fluctuates || verdict.model == MachineModel::ModeCoupling {
        return None;
    }
    if nominal.steady_sliding_unstable {
        return None;
    }
    let kick = nominal
        .kick_m_per_s
        .map_or_else(String::new, |kick| format!(", unless a kick of {} starts it", Dimension::Velocity.show(kick)));
    Some(format!("steady sliding stays quiet{kick}"))
}

/// Returns each number that the study does not state, with the verdict at both ends of its range:
/// `kinetic over static friction (kinetic_share), assumed 1: 87 % at 0.9, 57 % at 1`. Empty without a verdict.
pub fn not_stated(verdict: &VerdictResult) -> Vec<String> {
    let of_one = |assumed: &Assumed| {
        let key = assumed.input.rsplit('.').next().unwrap_or_default();
        let number = |value: f64| Dimension::None.show(value);
        let [low, high] = [0, 1].map(|end| answer_at(verdict, assumed, end));
        let [from, to] = assumed.range.map(number);
        let effect = match low == high {
            true => format!("{low} at {from} and at {to}"),
            false => format!("{low} at {from}, {high} at {to}"),
        };
        format!("{} ({key}), assumed {}: {effect}", named(&assumed.input), number(assumed.value))
    };
    verdict.assumed.iter().filter(|_| !verdict.friction_unresolved).map(of_one).collect()
}

/// Returns the answer of the headline at one end of the range of a number that the study does not state.
fn answer_at(verdict: &VerdictResult, assumed: &Assumed, end: usize) -> String {
    let (probability, interval) = (assumed.probability_at[end], assumed.probability_interval_at[end]);
    match interval {
        _ if verdict.friction_fluctuates => {
            sampled_percent(assumed.expected_vibration_share_at[end], interval) + " of the time"
        }
        _ if !is_exact(verdict) => sampled_percent(probability, interval),
        [low, high] if low < high => "may vibrate".into(),
        _ if probability < 0.5 => "does not vibrate".into(),
        _ => "vibrates".into(),
    }
}

/// Formats a fraction of sampled machines as a percentage with its interval; if none or all of them vibrate, as the bound of the interval.
fn sampled(fraction: f64, ends: [f64; 2], interval: &dyn Fn([f64; 2]) -> String) -> String {
    let error = if fraction > 0.0 && fraction < 1.0 { interval(ends) } else { String::new() };
    format!("{}{error}", sampled_percent(fraction, ends))
}

/// Formats a fraction of sampled machines as a percentage. If none or all of them vibrate, it is the bound of the interval.
pub(crate) fn sampled_percent(fraction: f64, [low, high]: [f64; 2]) -> String {
    match fraction {
        0.0 if high >= RARE => format!("less than {}", percent(high)),
        1.0 if low <= 1.0 - RARE => format!("more than {}", percent(low)),
        0.0 => percent(high),
        1.0 => percent(low),
        fraction => percent(fraction),
    }
}

/// Returns the noun for the most frequent kind of vibration.
pub(crate) fn noun(verdict: &VerdictResult) -> &'static str {
    if verdict.model == MachineModel::ModeCoupling {
        return "Squeal by mode coupling";
    }
    let kind = verdict
        .if_vibrating
        .as_ref()
        .and_then(|machines| machines.kinds.iter().rev().max_by(|a, b| a.1.total_cmp(b.1)))
        .map_or(verdict.nominal.kind, |(kind, _)| *kind);
    match kind {
        MotionKind::Overtaking => "Vibration faster than the belt",
        MotionKind::SlipCycle => "Vibration without stick",
        MotionKind::StickSlip => "Stick-slip",
        MotionKind::Flutter | MotionKind::Divergence | MotionKind::None => "Vibration",
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
