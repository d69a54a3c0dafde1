//! Conversion factors of heights in the header of a text.

use super::decimal::Decimal;
use super::header::{COMMENT, Header, Pair, bare, is_one_of, unit};
use super::length::leading_number;
use crate::Result;

const BIT_TO_NM: &str = "bit2nm";
const FACTOR: &str = "conversion factor";
/// Words beside it in keys that convert heights.
const OF_HEIGHTS: &str = "height|heights|z|data|value|values";

/// Conversion factor of heights.
#[derive(Clone, Copy)]
pub(super) struct Factor<'a> {
    pub(super) pair: &'a Pair,
    pub(super) value: f64,
    /// Unit before the conversion, if the header names it.
    pub(super) source: Option<&'a str>,
    /// Unit after the conversion and its number per metre, if the header names it.
    pub(super) target: Option<(&'a str, Option<f64>)>,
}

/// Conversion factors of a header.
pub(super) struct Factors<'a> {
    /// Factor to apply.
    pub(super) used: Option<Factor<'a>>,
    /// Pairs with factors that are not applied.
    pub(super) unused: Vec<&'a Pair>,
}

impl Pair {
    /// Returns whether this pair states a conversion factor.
    fn is_factor(&self) -> bool {
        self.name == BIT_TO_NM
            || self.name.contains(FACTOR)
            || self.name == COMMENT && self.value.to_lowercase().contains(FACTOR)
    }

    /// Returns the factor for heights; `None` for another factor. Its value is NaN if it is not a number.
    fn factor(&self, decimal: Option<Decimal>) -> Option<Factor<'_>> {
        let (value, behind) = factor_value(&self.value, decimal).unwrap_or((f64::NAN, ""));
        if self.name == BIT_TO_NM {
            return Some(Factor { pair: self, value, source: None, target: Some(("nm", Some(1e9))) });
        }
        let (before, after) = self.name.split_once(FACTOR)?;
        if !before.split_whitespace().chain(after.split_whitespace()).all(|word| is_one_of(OF_HEIGHTS, word)) {
            return None;
        }
        let bracket = self.key.split_once(['(', '[']).map_or("", |(_, bracket)| bracket);
        let (stated, other) = (units_of_factor(bracket), units_of_factor(behind));
        let target = match [stated.1, other.1].map(|name| name.map(|name| (name, unit(name)))) {
            // Units that contradict each other are ignored.
            [Some((name, per_metre)), Some((_, other))] => Some((name, per_metre.filter(|_| per_metre == other))),
            [target, other] => target.or(other),
        };
        Some(Factor { pair: self, value, source: stated.0.or(other.0), target })
    }
}

/// Returns the number at the start of a text and the text after it; `None` for a number that cannot be read whole.
fn factor_value(text: &str, decimal: Option<Decimal>) -> Option<(f64, &str)> {
    let (value, length) = leading_number(text, decimal, false)?;
    let behind = &text[length..];
    (!behind.starts_with([',', '.'])).then_some((value.ok()?, behind.trim()))
}

/// Returns the units before and after a conversion: `V -> nm`, `-> nm`, `nm/V` or `nm`.
fn units_of_factor(text: &str) -> (Option<&str>, Option<&str>) {
    let arrow = ["->", "→"].into_iter().find_map(|arrow| text.split_once(arrow));
    let (source, target) = match (arrow, text.split_once('/')) {
        (Some((source, target)), _) | (None, Some((target, source))) => (source, target),
        (None, None) => ("", text),
    };
    let named = |unit| Some(bare(unit)).filter(|unit| !unit.is_empty());
    (named(source), named(target))
}

/// Returns whether two units are equal.
fn is_same_unit(one: &str, other: &str) -> bool {
    bare(one).eq_ignore_ascii_case(bare(other)) || unit(one).is_some_and(|one| unit(other) == Some(one))
}

impl Header {
    /// Returns the factor that converts numbers to heights, and the pairs of other factors.
    ///
    /// `Bit2nm` of SPIP converts to nanometre, `height conversion factor (-> m)` to any unit, unless the numbers are
    /// already in it. A factor without a unit converts to metre if it is the only one and no unit of length is
    /// stated.
    ///
    /// # Errors
    /// A factor that is not a number or is 0, if no unit of length is stated.
    pub(super) fn factors(&self, decimal: Option<Decimal>) -> Result<Factors<'_>, &Pair> {
        let stated = self.height_unit();
        let length = stated.and_then(|(_, _, per_metre)| per_metre);
        let (mut known, mut unused) = (Vec::new(), Vec::new());
        for pair in self.pairs.iter().filter(|pair| pair.is_factor()) {
            let Some(factor) = pair.factor(decimal) else {
                unused.push(pair);
                continue;
            };
            let is_bit = pair.name == BIT_TO_NM;
            let leads_nowhere = matches!(factor.target, Some((_, None)));
            // Koala states the factor of phases also for heights.
            let is_done =
                length.is_some() && !is_bit && factor.target.map_or(Some(1.0), |(_, target)| target) == length;
            let is_of_other_unit =
                stated.zip(factor.source).is_some_and(|((_, unit, _), source)| !is_same_unit(unit, source));
            if is_done && !factor.source.is_some_and(|source| unit(source) == length) {
                continue;
            }
            if leads_nowhere || is_of_other_unit || factor.target.is_none() && length.is_some() {
                unused.push(pair);
            } else if factor.value.is_finite() && factor.value != 0.0 {
                known.push(factor);
            } else if length.is_some() && !is_bit {
                unused.push(pair);
            } else {
                return Err(pair);
            }
        }
        let named = known.iter().position(|factor| factor.pair.name == BIT_TO_NM);
        let named = named.or_else(|| known.iter().position(|factor| factor.target.is_some()));
        let place = named.or_else(|| Some(0).filter(|_| known.len() == 1));
        let used = place.map(|place| known.remove(place));
        unused.extend(known.iter().map(|factor| factor.pair));
        Ok(Factors { used, unused })
    }
}
