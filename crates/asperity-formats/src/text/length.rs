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
    /// Numbers without a unit are in `unit`, or else in metre. `None` if the text does not state lengths.
    ///
    /// # Errors
    /// A number that cannot be read whole.
    pub(super) fn parse(text: &str, unit: Option<f64>) -> Result<Option<Self>, NoNumber> {
        let mut doubt = None;
        let lengths = Self::read(text, unit, &mut doubt);
        doubt.map_or(Ok(lengths), Err)
    }

    fn read(text: &str, unit: Option<f64>, doubt: &mut Option<NoNumber>) -> Option<Self> {
        let mut lengths = Self { metre: Vec::new(), stated: Vec::new(), has_unit: true };
        let (mut scaled, mut rest) = (0, text);
        loop {
            let between = rest;
            rest = rest.trim_start_matches([' ', '\t', ',', ';', '(', ')', '[', ']', '*', '×']);
            let is_space = between.len() == rest.len() + 1 && between.starts_with(' ');
            let Some(first) = rest.chars().next() else { break };
            if lengths.stated.len() > 2 {
                return None;
            }
            let times = rest.strip_prefix(['x', 'X']).filter(|after| !after.starts_with(char::is_alphabetic));
            if first.is_ascii_digit() || matches!(first, '+' | '-' | '.') {
                let (number, length) = match leading_number(rest) {
                    Ok(Some((_, length)))
                        if is_space && may_continue(&text[..text.len() - between.len()], &rest[..length]) =>
                    {
                        *doubt = Some(NoNumber::Thousands);
                        return None;
                    }
                    Ok(found) => found?,
                    Err(reason) => {
                        *doubt = Some(reason);
                        return None;
                    }
                };
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

/// Why a number cannot be read whole.
#[derive(Debug, PartialEq)]
pub(super) enum NoNumber {
    /// It has one decimal sign too many, or groups of other than three digits.
    Signs,
    /// Its comma may be a decimal sign or separate thousands, or a space may separate thousands or two numbers.
    Thousands,
}

impl NoNumber {
    /// Returns what the file should state.
    pub(super) fn wanted(&self) -> &'static str {
        match self {
            Self::Signs => "a length (a stated pixel size replaces it)",
            Self::Thousands => {
                "a length without a comma or space that may separate thousands (a stated pixel size replaces it)"
            }
        }
    }
}

/// Returns whether a number may be the thousands of the next one, `1 234.5`.
fn may_continue(before: &str, next: &str) -> bool {
    let digits = before.len() - before.trim_end_matches(|c: char| c.is_ascii_digit()).len();
    let first = &before[before.len() - digits..];
    let is_whole = !before[..before.len() - digits].ends_with([',', '.']);
    let group = next.find(|c: char| !c.is_ascii_digit()).unwrap_or(next.len());
    is_whole && (1..=3).contains(&digits) && !first.starts_with('0') && group == 3
}

/// Returns the number at the start of a text and its length; `None` without one. `1,5` is one number, and so are `1,234.5` and `1.234,5`;
/// a comma or a full stop at the end separates it from the next.
fn leading_number(text: &str) -> Result<Option<(f64, usize)>, NoNumber> {
    let sign = usize::from(text.starts_with(['+', '-']));
    let run = text[sign..].find(|c: char| !c.is_ascii_digit() && !matches!(c, ',' | '.')).unwrap_or(text.len() - sign);
    let digits = text[sign..sign + run].trim_end_matches([',', '.']);
    let length = sign + digits.len();
    let first = digits.find([',', '.']).map(|place| digits.as_bytes()[place]);
    let other = if first == Some(b',') { '.' } else { ',' };
    let (whole, decimals) = digits.split_once(other).unwrap_or((digits, ""));
    let groups: Vec<&str> = whole.split([',', '.']).collect();
    let in_thousands = groups.len() > 1
        && (1..=3).contains(&groups[0].len())
        && !groups[0].starts_with('0')
        && groups[1..].iter().all(|group| group.len() == 3);
    let is_one_of_both = whole.len() < digits.len();
    match (groups.len(), first) {
        // A number without or with one decimal sign, and its exponent.
        (1, _) | (2, Some(b'.')) if !is_one_of_both => Ok(fast_float2::parse_partial(text).ok()),
        (2, Some(b',')) if !is_one_of_both && in_thousands => Err(NoNumber::Thousands),
        (2, Some(b',')) if !is_one_of_both => Ok(decimal_comma(digits.as_bytes())
            .map(|number| (if text.starts_with('-') { -number } else { number }, length))),
        _ if in_thousands && !decimals.contains([',', '.']) => {
            let number = format!("{}{}.{decimals}", &text[..sign], groups.concat());
            Ok(number.parse().ok().map(|number| (number, length)))
        }
        _ => Err(NoNumber::Signs),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn metre(text: &str) -> Result<Option<Vec<f64>>, NoNumber> {
        Lengths::parse(text, None).map(|lengths| lengths.map(|lengths| lengths.metre))
    }

    #[test]
    fn a_number_is_read_whole_or_the_text_is_refused() {
        for (text, wanted) in [
            ("0.5 um x 0.25 um", vec![0.5e-6, 0.25e-6]),
            ("1 2 mm", vec![1e-3, 2e-3]),
            ("(3, 4)", vec![3.0, 4.0]),
            ("1,5 um", vec![1.5e-6]),
            ("0,125 um", vec![0.125e-6]),
            ("12,3456 um", vec![12.3456e-6]),
            ("-1,5", vec![-1.5]),
            ("1,234.5 um", vec![1234.5e-6]),
            ("1.234,5 um", vec![1234.5e-6]),
            ("1,234,567.25 nm", vec![1_234_567.25e-9]),
            ("1.234.567 nm", vec![1_234_567e-9]),
            ("2.5e-3 m", vec![2.5e-3]),
            ("1.234 um", vec![1.234e-6]),
            ("1000 1000 um", vec![1e-3; 2]),
            ("100, 200 um", vec![100e-6, 200e-6]),
            ("1.5 250 um", vec![1.5e-6, 250e-6]),
        ] {
            let found = metre(text).unwrap().unwrap();
            assert_eq!(found.len(), wanted.len(), "{text}: {found:?}");
            assert!(found.iter().zip(&wanted).all(|(a, b)| (a / b - 1.0).abs() < 1e-15), "{text}: {found:?}");
        }
        for text in ["12.34.5", "1,23.4", "1,2,3", "0,234.5", "1234,567.8", "1.234,567.8"] {
            assert_eq!(metre(text), Err(NoNumber::Signs), "{text}");
        }
        for text in ["1,234 um", "999,999", "1 234.5 um", "12 345 nm"] {
            assert_eq!(metre(text), Err(NoNumber::Thousands), "{text}");
        }
        for text in ["unknown", "", "um", "1 2 3 4", "v 3"] {
            assert_eq!(metre(text), Ok(None), "{text}");
        }
    }
}
