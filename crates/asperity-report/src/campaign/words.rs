//! Members and their values in words.

use std::borrow::Cow;

use asperity_results::{CampaignResults, InputValue, MemberResult, VariedKey};

use crate::cells::{DASH, percent};
use crate::format::{Dimension, Unit, count};
pub(super) use crate::words::capitalised;
use crate::words::named;

/// File with the numbers.
pub(super) const SOURCE: &str = "members.csv";

/// Returns the number of a value in SI; `None` for a text.
pub(super) fn number(value: &InputValue) -> Option<f64> {
    match value {
        InputValue::Integer(number) => Some(*number as f64),
        InputValue::Number(number) => Some(*number),
        InputValue::Name(_) => None,
    }
}

/// Returns the unit in which the values of a key are shown.
pub(super) fn unit_of(key: &VariedKey, values: impl Iterator<Item = f64>) -> Unit {
    Dimension::of_unit(&key.unit).unit(values.map(f64::abs).fold(0.0, f64::max))
}

/// Returns a value with its unit, or a text.
pub(super) fn shown(key: &VariedKey, value: &InputValue) -> String {
    match value {
        InputValue::Integer(number) => number.to_string(),
        InputValue::Number(number) => Dimension::of_unit(&key.unit).show(*number),
        InputValue::Name(text) => text.clone(),
    }
}

/// Returns the name of a key in words.
pub(super) fn key_in_words(key: &VariedKey) -> String {
    match key.key.strip_suffix("_std").filter(|_| key.key != "vibration.friction_std") {
        Some(of) => format!("standard deviation of {}", named(of)),
        None => named(&key.key),
    }
}

/// Returns whether the members have several values of a key.
pub(super) fn differs(results: &CampaignResults, place: usize) -> bool {
    let mut values = results.members.iter().map(|member| &member.values[place]);
    let first = values.next();
    values.any(|value| Some(value) != first)
}

/// Returns the values of a member that differ between members, without that of one key, in words.
pub(super) fn values_in_words(results: &CampaignResults, member: &MemberResult, without: Option<usize>) -> Vec<String> {
    let is_exact = |key: &VariedKey, value: &InputValue| key.key.ends_with("_std") && number(value) == Some(0.0);
    let places = (0..results.keys.len()).filter(|place| Some(*place) != without && differs(results, *place));
    let values = places.map(|place| (&results.keys[place], &member.values[place]));
    let values = values.filter(|(key, value)| !is_exact(key, value));
    values.map(|(key, value)| format!("{} {}", key_in_words(key), shown(key, value))).collect()
}

/// Returns the verdict on a member as one word; a dash without one.
pub(super) fn verdict(member: &MemberResult) -> &'static str {
    match member.answers.vibrates {
        _ if member.failed => "failed",
        Some(true) => "vibrates",
        Some(false) => "quiet",
        None => DASH,
    }
}

/// Formats a probability as a percentage.
pub(super) fn probability(probability: f64) -> Cow<'static, str> {
    match probability {
        p if p > 0.0 && p < 1e-4 => "< 0.01 %".into(),
        p if p > 1.0 - 1e-4 && p < 1.0 => "> 99.99 %".into(),
        p => percent(p, if p > 0.99 { 3 } else { 2 }).into(),
    }
}

/// Returns whether the interval of the probability of a member contains nearly every probability.
pub(super) fn is_undetermined(member: &MemberResult) -> bool {
    member.answers.probability_interval.is_some_and(|[low, high]| high - low > 0.9)
}

/// Returns numbers of members in words, with the first ranges: `members 1 to 4, 6 and 9`.
pub(super) fn members_in_words(members: &[usize]) -> String {
    const MOST: usize = 6;
    let mut ranges: Vec<(usize, usize)> = Vec::new();
    for &member in members {
        match ranges.last_mut() {
            Some((_, last)) if *last + 1 == member => *last = member,
            _ => ranges.push((member, member)),
        }
    }
    let more: usize = ranges.iter().skip(MOST).map(|(first, last)| last - first + 1).sum();
    let words = ranges.iter().take(MOST).map(|(first, last)| match last - first {
        0 => first.to_string(),
        1 => format!("{first}, {last}"),
        _ => format!("{first} to {last}"),
    });
    let noun = if members.len() == 1 { "member" } else { "members" };
    let more = if more > 0 { format!(" and {} more", count(more)) } else { String::new() };
    format!("{noun} {}{more}", words.collect::<Vec<_>>().join(", "))
}
