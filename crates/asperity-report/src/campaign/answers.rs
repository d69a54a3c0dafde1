//! The first screen of a campaign: how probable vibration is and which value changes that, or how many members vibrate and where the verdict
//! changes, and the ranges of the other answers.

use std::collections::BTreeMap;

use asperity_results::keys::DAMPING_RATIO;
use asperity_results::{CampaignResults, InputKind, InputValue, MemberRemedy, MemberResult, Pair};

use crate::campaign::words::{
    capitalised, differs, is_undetermined, key_in_words, members_in_words, number, probability, shown, values_in_words,
};
use crate::format::{Dimension, count, significant};
use crate::page::answer::Answer;
use crate::page::verdict::rests_on::by_origin;
use crate::words::{named, unbroken};

/// Difference of probabilities below which a value hardly matters.
const SMALL: f64 = 0.05;
/// Largest number of names in a sentence.
const MOST_NAMES: usize = 4;
/// Question after the values in common.
pub(super) const RESTS_ON: &str = "What does it rest on, beside the values that differ?";

/// Returns the answers, the most important first.
pub(super) fn answers(results: &CampaignResults) -> Vec<Answer> {
    // Beside probabilities, the verdicts on central values would be other answers to the same question.
    let found = match results.members.iter().any(|member| member.answers.probability.is_some()) {
        true => [effects(results), probabilities(results), certainty(results)],
        false => [limits_of_members(results).or_else(|| change(results)), verdicts(results), None],
    };
    let stops = remedies(results).or_else(|| limits(results));
    // Where there is a verdict, the friction coefficients are in the table.
    let friction = friction(results).filter(|_| found.iter().all(Option::is_none));
    let found = found.into_iter().chain([stops, friction]);
    let on_one_line = |found: Answer| Answer {
        answer: unbroken(&found.answer),
        detail: unbroken(&found.detail),
        question: found.question,
    };
    let found: Vec<Answer> = found.flatten().map(on_one_line).collect();
    if !found.is_empty() {
        return found;
    }
    let failed = results.members.iter().filter(|member| member.failed).count();
    vec![Answer {
        question: "How many members are compared?",
        answer: count(results.members.len()),
        detail: if failed == 0 { "All were computed.".into() } else { failures(failed) },
    }]
}

fn failures(failed: usize) -> String {
    match failed {
        0 => String::new(),
        1 => " One member has no answer; the table states the reason.".into(),
        failed => format!(" {} members have no answer; the table states the reasons.", count(failed)),
    }
}

/// Returns the numbers of the members for which a condition holds, counted from 1.
fn numbers(results: &CampaignResults, holds: impl Fn(&MemberResult) -> bool) -> Vec<usize> {
    let members = results.members.iter().enumerate().filter(|(_, member)| holds(member));
    members.map(|(index, _)| index + 1).collect()
}

/// Answers how many members vibrate.
fn verdicts(results: &CampaignResults) -> Option<Answer> {
    let vibrating = numbers(results, |member| member.answers.vibrates == Some(true));
    let judged = numbers(results, |member| member.answers.vibrates.is_some()).len();
    let failed = numbers(results, |member| member.failed).len();
    let which = match vibrating.len() {
        0 => "No member vibrates.".into(),
        all if all == judged => "All that have an answer vibrate.".into(),
        _ => format!("{}.", capitalised(members_in_words(&vibrating))),
    };
    (judged > 0).then(|| Answer {
        question: "How many vibrate?",
        answer: format!("{} of {}", count(vibrating.len()), count(judged)),
        detail: format!(
            "{which} Each is started from standstill. No value is uncertain, so there is no probability.{}",
            failures(failed)
        ),
    })
}

/// Effect of one value on the verdict.
struct Decision {
    /// Number of members whose verdict follows from this value alone.
    members: usize,
    answer: String,
    detail: String,
}

/// Answers where the verdict changes: at the value that alone decides most members.
fn change(results: &CampaignResults) -> Option<Answer> {
    let judged: Vec<(&MemberResult, bool)> =
        results.members.iter().filter_map(|member| Some((member, member.answers.vibrates?))).collect();
    let is_mixed = judged.iter().any(|(_, vibrates)| *vibrates) && judged.iter().any(|(_, vibrates)| !vibrates);
    if !is_mixed {
        return None;
    }
    let keys = (0..results.keys.len()).filter(|place| differs(results, *place));
    let of_key = |place: usize| {
        let is_number = |(member, _): &(&MemberResult, bool)| matches!(member.values[place], InputValue::Number(_));
        match judged.iter().all(is_number) {
            true => threshold(results, place, &judged),
            false => {
                let name = |member: &MemberResult| shown(&results.keys[place], &member.values[place]);
                choices(&key_in_words(&results.keys[place]), &judged, name)
            }
        }
    };
    let scans = judged.iter().all(|(member, _)| member.scan.is_some());
    let of_scans = scans.then(|| choices("scan", &judged, |member| member.scan.clone().unwrap_or_default()));
    let best =
        keys.map(of_key).chain(of_scans).reduce(|best, next| if next.members > best.members { next } else { best });
    let best = best.filter(|best| best.members > 0);
    let (answer, detail) = match best {
        Some(Decision { members, answer, detail }) if 2 * members >= judged.len() => (answer, detail),
        Some(Decision { detail, .. }) => ("Several values decide together".into(), detail),
        None => (
            "Several values decide together".into(),
            "The table has the members of each verdict together if it is sorted by it.".into(),
        ),
    };
    Some(Answer { question: "Where does the verdict change?", answer, detail })
}

/// Returns how far a number decides: all members on one side of it vibrate, or none on the other.
fn threshold(results: &CampaignResults, place: usize, judged: &[(&MemberResult, bool)]) -> Decision {
    let key = &results.keys[place];
    let values = |wanted: bool| {
        let own = judged.iter().filter(move |(_, vibrates)| *vibrates == wanted);
        own.filter_map(|(member, _)| number(&member.values[place]))
    };
    let ends = |wanted: bool| values(wanted).fold((f64::INFINITY, f64::NEG_INFINITY), |(l, h), v| (l.min(v), h.max(v)));
    // Verdict below and above.
    let orientation = |below: bool| {
        let ((first_above, _), (_, last_below)) = (ends(!below), ends(below));
        let last = values(below).filter(|value| *value < first_above).reduce(f64::max);
        let first = values(!below).filter(|value| *value > last_below).reduce(f64::min);
        let members = values(below).filter(|value| *value < first_above).count()
            + values(!below).filter(|value| *value > last_below).count();
        (members, below, last, first)
    };
    let [one, other] = [true, false].map(orientation);
    let (members, below, last, first) = if other.0 > one.0 { other } else { one };
    let name = key_in_words(key);
    let value = |number: f64| shown(key, &InputValue::Number(number));
    let how_many = |vibrates: bool| if vibrates { "all members vibrate" } else { "no member vibrates" };
    let sides = [
        last.map(|last| format!("up to {name} {} {}", value(last), how_many(below))),
        first.map(|first| format!("from {} on {}", value(first), how_many(!below))),
    ];
    let sides = sides.into_iter().flatten().collect::<Vec<_>>().join("; ");
    let rest = if members < judged.len() { " Elsewhere other values decide, too." } else { "" };
    let answer = match (last, first) {
        (Some(last), Some(first)) => format!("Between {name} {} and {}", value(last), value(first)),
        (Some(last), None) => format!("Above {name} {}", value(last)),
        (None, Some(first)) => format!("Below {name} {}", value(first)),
        (None, None) => String::new(),
    };
    Decision { members, answer, detail: format!("{}.{rest}", capitalised(sides)) }
}

/// Returns how far a choice decides: all members with it vibrate, or none does.
fn choices(what: &str, judged: &[(&MemberResult, bool)], name: impl Fn(&MemberResult) -> String) -> Decision {
    // Names in the order of the members, with the numbers of members and of those that vibrate.
    let mut groups: Vec<(String, usize, usize)> = Vec::new();
    for (member, vibrates) in judged {
        let own = name(member);
        let place = groups.iter().position(|(known, ..)| *known == own).unwrap_or_else(|| {
            groups.push((own, 0, 0));
            groups.len() - 1
        });
        groups[place].1 += 1;
        groups[place].2 += usize::from(*vibrates);
    }
    let of = |wanted: fn(usize, usize) -> bool| {
        let own: Vec<&(String, usize, usize)> =
            groups.iter().filter(|(_, all, vibrating)| wanted(*all, *vibrating)).collect();
        let names: Vec<&str> = own.iter().take(MOST_NAMES).map(|(name, ..)| name.as_str()).collect();
        let more = if own.len() > MOST_NAMES { format!(" and {} more", own.len() - MOST_NAMES) } else { String::new() };
        (own.iter().map(|(_, all, _)| all).sum::<usize>(), format!("{}{more}", names.join(", ")))
    };
    let (with, all) = of(|all, vibrating| vibrating == all);
    let (without, none) = of(|_, vibrating| vibrating == 0);
    let mut sentences = Vec::new();
    if with > 0 {
        sentences.push(format!("All members with {what} {all} vibrate."));
    }
    if without > 0 {
        sentences.push(format!("No member with {what} {none} vibrates."));
    }
    let members = with + without;
    if members < judged.len() {
        sentences.push("Elsewhere other values decide, too.".into());
    }
    Decision { members, answer: format!("With the {what}"), detail: sentences.join(" ") }
}

/// Mean probability of the members with one value.
struct Level {
    name: String,
    number: Option<f64>,
    members: f64,
    probability: f64,
    /// Half the width of the 95 % interval.
    error: f64,
}

/// Answers how much each value changes the probability while the others stay, the largest effect first.
fn effects(results: &CampaignResults) -> Option<Answer> {
    let keys = (0..results.keys.len()).filter(|place| differs(results, *place) && !results.keys[*place].sampled);
    let of_key = |place: usize| {
        let key = &results.keys[place];
        let value = |member: &MemberResult| (shown(key, &member.values[place]), number(&member.values[place]));
        let others = |member: &MemberResult| {
            [values_in_words(results, member, Some(place)), member.scan.iter().cloned().collect()]
        };
        effect(&key_in_words(key), results, &value, &|member| others(member).concat())
    };
    let scan = |member: &MemberResult| (member.scan.clone().unwrap_or_default(), None);
    let of_scan = effect("scan", results, &scan, &|member| values_in_words(results, member, None));
    let mut found: Vec<(f64, String)> = keys.filter_map(of_key).chain(of_scan).collect();
    found.sort_by(|a, b| b.0.total_cmp(&a.0));
    let mut sentences = found.into_iter().map(|(_, sentence)| capitalised(sentence));
    let answer = sentences.next()?;
    let mut detail: Vec<String> = sentences.map(|sentence| format!("{sentence}.")).collect();
    if results.members.len() > 2 && !detail.is_empty() {
        detail.push("Percentages are averaged over the other values.".into());
    }
    Some(Answer { question: "What changes the probability of vibration?", answer, detail: detail.join(" ") })
}

/// Returns the largest difference between the mean probabilities of a value's levels, and a sentence on it; `None` for a single level.
///
/// Members with the same `others` form a group. Groups in which a level has no probability do not count.
fn effect(
    what: &str,
    results: &CampaignResults,
    value: &dyn Fn(&MemberResult) -> (String, Option<f64>),
    others: &dyn Fn(&MemberResult) -> Vec<String>,
) -> Option<(f64, String)> {
    let own = |member: &MemberResult| probable(member).filter(|_| !is_undetermined(member));
    let members: Vec<_> = results.members.iter().filter_map(|member| Some((member, own(member)?))).collect();
    let mut levels: Vec<Level> = Vec::new();
    let mut groups: BTreeMap<Vec<String>, Vec<String>> = BTreeMap::new();
    for (member, _) in &members {
        let (name, number) = value(member);
        groups.entry(others(member)).or_default().push(name.clone());
        if levels.iter().all(|level| level.name != name) {
            levels.push(Level { name, number, members: 0.0, probability: 0.0, error: 0.0 });
        }
    }
    let is_complete = |member: &MemberResult| levels.iter().all(|level| groups[&others(member)].contains(&level.name));
    let complete: Vec<_> = members.into_iter().filter(|(member, _)| is_complete(member)).collect();
    for level in &mut levels {
        for (member, own) in complete.iter().filter(|(member, _)| value(member).0 == level.name) {
            level.members += 1.0;
            level.probability += own;
            level.error += member.answers.probability_interval.map_or(0.0, |[low, high]| 0.5 * (high - low));
        }
        (level.probability, level.error) = (level.probability / level.members, level.error / level.members);
    }
    let mut ends = [levels.iter().min_by(by_probability)?, levels.iter().max_by(by_probability)?];
    if levels.len() < 2 || complete.is_empty() {
        return None;
    }
    let (size, error) = (ends[1].probability - ends[0].probability, ends[0].error.hypot(ends[1].error));
    if ends[0].number > ends[1].number {
        ends.swap(0, 1);
    }
    let matters = match size {
        size if size + error < SMALL && size <= error => "has no effect beyond the errors",
        size if size <= error => "has no resolved effect",
        size if size < SMALL => "hardly matters",
        _ => "matters",
    };
    let [from, to] = ends;
    let (low, high) = (probability(from.probability), probability(to.probability));
    Some((size, format!("{what} {matters}: {low} vibrate at {}, {high} at {}", from.name, to.name)))
}

/// Returns the probability of a member; that of a machine of exact values is 0 or 1.
fn probable(member: &MemberResult) -> Option<f64> {
    member.answers.probability.or(member.answers.vibrates.map(f64::from))
}

fn by_probability(a: &&Level, b: &&Level) -> std::cmp::Ordering {
    a.probability.total_cmp(&b.probability)
}

/// Answers how probable vibration is: the numbers of members in ranges of the probability.
fn probabilities(results: &CampaignResults) -> Option<Answer> {
    let of = |holds: fn(f64) -> bool| {
        numbers(results, |member| !is_undetermined(member) && probable(member).is_some_and(holds))
    };
    let (low, between, high) = (of(|p| p < 0.05), of(|p| (0.05..=0.95).contains(&p)), of(|p| p > 0.95));
    let open = numbers(results, is_undetermined);
    let groups = [("below 5 %", &low), ("5 % to 95 %", &between), ("above 95 %", &high), ("not determined", &open)];
    let groups: Vec<_> = groups.into_iter().filter(|(_, members)| !members.is_empty()).collect();
    let own = |member: &MemberResult| probable(member).filter(|_| !is_undetermined(member));
    let extremes = extremes(results, own);
    let answer = match (groups.as_slice(), &extremes) {
        ([], _) => return None,
        ([("not determined", _)], _) => "Not determined".into(),
        ([_], Some([(_, low), (_, high)])) if probability(*low) == probability(*high) => probability(*low).into(),
        ([_], Some([(_, low), (_, high)])) => format!("{} to {}", probability(*low), probability(*high)),
        (groups, _) => {
            let words = groups.iter().map(|(words, members)| format!("{words} in {}", count(members.len())));
            format!("{} of {} members", capitalised(words.collect::<Vec<_>>().join(", ")), count(results.members.len()))
        }
    };
    let detail = match extremes {
        Some([(least, low), (largest, high)]) if probability(low) != probability(high) => {
            format!("{} in {least}, {} in {largest}.", probability(low), probability(high))
        }
        _ => String::new(),
    };
    let determined =
        if open.is_empty() { "" } else { " Intervals that contain nearly every probability are not determined." };
    Some(Answer {
        question: "How probable is vibration?",
        answer,
        detail: format!("{detail}{determined}").trim_start().to_owned(),
    })
}

/// Answers how sure the probabilities are: the widest interval of the computation, and the widest range over values that are not known.
fn certainty(results: &CampaignResults) -> Option<Answer> {
    let widest = |ends: &dyn Fn(&MemberResult) -> Option<Pair>| {
        let members = results.members.iter().enumerate().filter(|(_, member)| !is_undetermined(member));
        let found = members.filter_map(|(index, member)| Some((member_in_words(results, index), ends(member)?)));
        found.max_by(|(_, a), (_, b)| (a[1] - a[0]).total_cmp(&(b[1] - b[0])))
    };
    let (_, [low, high]) = widest(&|member| member.answers.probability_interval)?;
    let points = format!("± {} percentage points", significant((50.0 * (high - low)).max(0.01), 2));
    let range = widest(&|member| member.answers.probability_range).filter(|(_, ends)| ends[1] - ends[0] > high - low);
    let (answer, detail) = match range {
        // The wider range comes first.
        Some((member, ends)) => {
            let [low, high] = ends.map(probability);
            let unknown = results.rests_on.iter().filter(|input| input.kind == InputKind::Unknown);
            let unknown: Vec<String> = unknown.map(|input| named(&input.input)).collect();
            let [values, measure] = match unknown.is_empty() {
                true => [String::new(), String::new()],
                false => [format!(" ({})", unknown.join(", ")), "; a measurement would narrow it".into()],
            };
            let detail = format!(
                "The widest 90 % range over what is not known{values}, that of {member}{measure}. The computation itself is sure to {points}."
            );
            (format!("{low} to {high} in one member"), detail)
        }
        None => (format!("Computed to {points}"), String::new()),
    };
    Some(Answer { question: "How sure is that?", answer, detail })
}

/// Answers what would stop vibration: the damping ratios at which it ends. Beside probabilities these are no safe values.
fn remedies(results: &CampaignResults) -> Option<Answer> {
    let known = || results.members.iter().filter_map(|member| member.answers.remedy.as_ref());
    let MemberRemedy { input, unit, probability: wanted, .. } = known().next()?;
    if known().any(|other| (&other.input, other.probability) != (input, *wanted)) {
        return None;
    }
    let ends = extremes(results, |member| member.answers.remedy.as_ref()?.value);
    let dimension = Dimension::of_unit(unit);
    let without = known().filter(|remedy| remedy.value.is_none()).count();
    let unreached = match without {
        0 => String::new(),
        1 => " No value in the range of the study is enough for one member.".into(),
        some => format!(" No value in the range of the study is enough for {} members.", count(some)),
    };
    let (answer, detail) = match ends {
        None => (format!("No {} in the range of the study", named(input)), String::new()),
        Some([(least, low), (largest, high)]) => {
            let [low, high] = [low, high].map(|value| dimension.show_short(value));
            match low == high {
                true => (format!("{} {low}", capitalised(named(input))), String::new()),
                false => (
                    format!("{} of {low} to {high}, by member", capitalised(named(input))),
                    format!(" {} in {least}, {} in {largest}.", capitalised(low), capitalised(high)),
                ),
            }
        }
    };
    let is_met = format!("At most {} vibrate at this value.", probability(*wanted));
    Some(Answer { question: "What would stop it?", answer, detail: format!("{is_met}{detail}{unreached}") })
}

/// Damping ratios at which the vibration of the members ends, of exact values.
struct Limits {
    low: f64,
    high: f64,
    /// Sentence with the members of both.
    sentence: String,
}

impl Limits {
    fn new(results: &CampaignResults) -> Option<Self> {
        let of = |member: &MemberResult| member.answers.limit_damping_ratio;
        let [(least, low), (largest, high)] = extremes_by(results, of, with_values_but_damping)?;
        let sentence = match low < high {
            true => {
                format!("Vibration ends at {} {least} and at {} {largest}.", significant(low, 3), significant(high, 3))
            }
            false => "Vibration ends there.".into(),
        };
        (high > 0.0).then_some(Self { low, high, sentence })
    }

    /// Returns `a damping ratio of 0.04 to 0.06`.
    fn span(&self) -> String {
        let [low, high] = [self.low, self.high].map(|limit| significant(limit, 3));
        if low == high { format!("a damping ratio of {high}") } else { format!("a damping ratio of {low} to {high}") }
    }
}

/// Answers where the verdict changes by the damping ratios at which vibration ends, if the members differ in the damping ratio.
fn limits_of_members(results: &CampaignResults) -> Option<Answer> {
    let damping = results.keys.iter().position(|key| key.key == DAMPING_RATIO)?;
    let limits = Limits::new(results).filter(|_| differs(results, damping))?;
    let (answer, detail) = (format!("At {}", limits.span()), limits.sentence);
    Some(Answer { question: "Where does the verdict change?", answer, detail })
}

/// Answers what would stop vibration: the damping ratios at which it ends. Beside probabilities these are no safe values.
fn limits(results: &CampaignResults) -> Option<Answer> {
    let limits = Limits::new(results)?;
    if results.members.iter().all(|member| member.answers.probability.is_none()) {
        let answer = format!("A damping ratio above {}", significant(limits.high, 3));
        return Some(Answer { question: "What would stop it?", answer, detail: "Every member is quiet there.".into() });
    }
    Some(Answer {
        question: "Where does it end with all values at their centres?",
        answer: format!("At {}", limits.span()),
        detail: limits.sentence + " Values that vary need more damping.",
    })
}

/// Answers how the friction coefficient differs.
fn friction(results: &CampaignResults) -> Option<Answer> {
    let [(least, low), (largest, high)] = extremes(results, |member| member.answers.friction_mean)?;
    (low < high).then(|| Answer {
        question: "What is the friction coefficient?",
        answer: format!("{} to {}", significant(low, 3), significant(high, 3)),
        detail: format!("Least in {least}, largest in {largest}."),
    })
}

/// Answers on which values in common the answers of the members rest.
pub(super) fn inputs(results: &CampaignResults) -> Option<Answer> {
    let lines: Vec<String> = by_origin(&results.rests_on).into_iter().map(|(_, line)| capitalised(line)).collect();
    let (first, others) = lines.split_first()?;
    Some(Answer {
        question: RESTS_ON,
        answer: first.clone(),
        detail: others.iter().map(|line| format!("{line}.")).collect::<Vec<_>>().join(" "),
    })
}

/// Returns the members with the least and the largest answer, and these answers.
fn extremes(results: &CampaignResults, answer: impl Fn(&MemberResult) -> Option<f64>) -> Option<[(String, f64); 2]> {
    extremes_by(results, answer, member_in_words)
}

/// Returns the words of the members with the least and the largest answer, and these answers.
fn extremes_by(
    results: &CampaignResults,
    answer: impl Fn(&MemberResult) -> Option<f64>,
    words: fn(&CampaignResults, usize) -> String,
) -> Option<[(String, f64); 2]> {
    let found = || results.members.iter().enumerate().filter_map(|(index, member)| Some((index, answer(member)?)));
    let least = found().min_by(|a, b| a.1.total_cmp(&b.1))?;
    let largest = found().max_by(|a, b| a.1.total_cmp(&b.1))?;
    Some([least, largest].map(|(index, value)| (words(results, index), value)))
}

/// Returns the values of a member without its damping ratio, `with hardness 100 MPa`, or the member if it has no other.
fn with_values_but_damping(results: &CampaignResults, index: usize) -> String {
    let (member, damping) = (&results.members[index], results.keys.iter().position(|key| key.key == DAMPING_RATIO));
    let values = values_in_words(results, member, damping);
    let words: Vec<String> = member.scan.iter().cloned().chain(values).take(MOST_NAMES).collect();
    if words.is_empty() { format!("in member {}", index + 1) } else { format!("with {}", words.join(", ")) }
}

/// Returns a member with its first values: `member 5 (damping ratio 0.2, a.x3p)`.
fn member_in_words(results: &CampaignResults, index: usize) -> String {
    let member = &results.members[index];
    let values = values_in_words(results, member, None);
    let words: Vec<String> = member.scan.iter().cloned().chain(values).take(MOST_NAMES).collect();
    if words.is_empty() {
        format!("member {}", index + 1)
    } else {
        format!("member {} ({})", index + 1, words.join(", "))
    }
}
