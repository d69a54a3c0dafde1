//! Lengths in the header of a text.

use super::field::decimal_comma;
use crate::{per_metre, warn_if};

/// One or two lengths.
pub(super) struct Lengths {
    pub(super) metre: Vec<f64>,
    pub(super) stated: Vec<f64>,
    pub(super) has_unit: bool,
}

impl Lengths {
    /// Parses lengths such as `0.5 um x 0.25 um`, `1 2 mm` or `(3, 4)`. A unit applies to the numbers before it.
    /// Numbers without a unit are in `unit`, or else in metre.
    pub(super) fn parse(text: &str, unit: Option<f64>) -> Option<Self> {
        let mut lengths = Self { metre: Vec::new(), stated: Vec::new(), has_unit: true };
        let (mut scaled, mut rest) = (0, text);
        loop {
            rest = rest.trim_start_matches([' ', '\t', ',', ';', '(', ')', '[', ']', '*', '×']);
            let Some(first) = rest.chars().next() else { break };
            if lengths.stated.len() > 2 {
                return None;
            }
            let times = rest.strip_prefix(['x', 'X']).filter(|after| !after.starts_with(char::is_alphabetic));
            if first.is_ascii_digit() || matches!(first, '+' | '-' | '.') {
                let (number, length) = leading_number(rest)?;
                lengths.stated.push(number);
                rest = &rest[length..];
            } else if let Some(after) = times.or_else(|| rest.strip_prefix("by ")) {
                rest = after;
            } else {
                let length = rest.find([' ', '\t', ',', ';', '(', ')', '[', ']', '*', '×']).unwrap_or(rest.len());
                let (word, after) = rest.split_at(length);
                rest = after;
                let per_metre = per_metre(word)?;
                lengths.metre.extend(lengths.stated[scaled..].iter().map(|number| number / per_metre));
                scaled = lengths.stated.len();
            }
        }
        lengths.has_unit = unit.is_some() || scaled == lengths.stated.len();
        lengths.metre.extend(lengths.stated[scaled..].iter().map(|number| number / unit.unwrap_or(1.0)));
        (1..=2).contains(&lengths.metre.len()).then_some(lengths)
    }

    /// Returns the lengths along x and y. A single length applies to both.
    pub(super) fn pair(&self, warnings: &mut Vec<String>) -> (f64, f64) {
        warn_if!(warnings, !self.has_unit, "the header states a pixel size without a unit; metre was assumed");
        (self.metre[0], self.metre[self.metre.len() - 1])
    }
}

/// Returns the number at the start of a text and its length; `1,5` is one number.
fn leading_number(text: &str) -> Option<(f64, usize)> {
    let comma = text.find(|c: char| !c.is_ascii_digit() && c != ',').unwrap_or(text.len());
    match decimal_comma(&text.as_bytes()[..comma]) {
        Some(number) => Some((number, comma)),
        None => fast_float2::parse_partial(text).ok(),
    }
}
