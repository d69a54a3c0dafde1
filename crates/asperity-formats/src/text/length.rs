//! Lengths in the header of a text.

use super::decimal::{Decimal, in_thousands};
use crate::unit::is_micro;
use crate::{per_metre, warn_if};

/// One or two lengths.
pub(super) struct Lengths {
    pub(super) metre: Vec<f64>,
    pub(super) stated: Vec<f64>,
    pub(super) has_unit: bool,
}

impl Lengths {
    /// Parses lengths such as `0.5 um x 0.25 um`, `1 2 mm` or `(3, 4)`. A unit applies to the numbers before it.
    /// Numbers without a unit are in `unit`, or else in metre. `decimal` decides numbers such as `1,234`. `None` if the text does not
    /// state lengths.
    ///
    /// # Errors
    /// A number that cannot be read whole.
    pub(super) fn parse(text: &str, unit: Option<f64>, decimal: Option<Decimal>) -> Result<Option<Self>, NoNumber> {
        let mut doubt = None;
        match (Self::read(text, unit, decimal, &mut doubt), doubt) {
            (Some(_), Some(doubt)) => Err(doubt),
            (lengths, _) => Ok(lengths),
        }
    }

    /// Reads lengths; the first number that cannot be read whole goes to `doubt`.
    fn read(text: &str, unit: Option<f64>, decimal: Option<Decimal>, doubt: &mut Option<NoNumber>) -> Option<Self> {
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
                let is_open = text[..text.len() - rest.len()].ends_with(['(', '[']);
                let (number, length) = leading_number(rest, decimal, is_open)?;
                if is_space && may_continue(&text[..text.len() - between.len()], &rest[..length]) {
                    doubt.get_or_insert(NoNumber::Thousands);
                }
                lengths.stated.push(number.unwrap_or_else(|reason| {
                    doubt.get_or_insert(reason);
                    f64::NAN
                }));
                rest = &rest[length..];
            } else if let Some(after) = times.or_else(|| rest.strip_prefix("by ")) {
                rest = after;
            } else {
                let length = rest.find([' ', '\t', ',', ';', '(', ')', '[', ']', '*', '×']).unwrap_or(rest.len());
                let (word, after) = rest.split_at(length);
                rest = after;
                if is_micro(word) {
                    doubt.get_or_insert(NoNumber::Prefix);
                }
                let per_metre = per_metre(word).or_else(|| is_micro(word).then_some(1e6))?;
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
    /// Its unit is a prefix alone.
    Prefix,
}

impl NoNumber {
    /// Returns what the file should state.
    pub(super) fn wanted(&self) -> &'static str {
        match self {
            Self::Prefix => "a length with a unit, such as `um` (a stated pixel size replaces it)",
            Self::Signs => "a length (a stated pixel size replaces it)",
            Self::Thousands => {
                "a length without a comma or space that may separate thousands (`--decimal` states the decimal sign, and a stated pixel \
                 size replaces the length)"
            }
        }
    }
}

/// Returns whether a number may be the thousands of the next one, `1 234.5`; two equal numbers are the sides of a square.
fn may_continue(before: &str, next: &str) -> bool {
    let digits = before.len() - before.trim_end_matches(|c: char| c.is_ascii_digit()).len();
    let (text, first) = before.split_at(before.len() - digits);
    let is_whole = text.is_empty() || text.ends_with([' ', '(', '[', 'x', '×', ';']);
    let group = next.find(|c: char| !c.is_ascii_digit()).unwrap_or(next.len());
    let is_plain = !next.contains(['e', 'E']) && first != next;
    is_whole && is_plain && (1..=3).contains(&digits) && !first.starts_with('0') && group == 3
}

/// Returns the number at the start of a text and its length; `None` without one. `1,5` is one number, and so are `1,234.5` and `1.234,5`;
/// a comma or a full stop at the end separates it from the next, and so does the comma of `0.5,0.25` and of `(1,2)`, which `is_open`.
/// `decimal` decides between the two meanings of `1,234`.
pub(super) fn leading_number(
    text: &str,
    decimal: Option<Decimal>,
    is_open: bool,
) -> Option<(Result<f64, NoNumber>, usize)> {
    let sign = usize::from(text.starts_with(['+', '-']));
    let run = text[sign..].find(|c: char| !c.is_ascii_digit() && !matches!(c, ',' | '.')).unwrap_or(text.len() - sign);
    let is_closed = is_open && text[sign + run..].starts_with([')', ']']);
    let mut digits = text[sign..sign + run].trim_end_matches([',', '.']);
    if let Some((first, second)) = digits.split_once(',')
        && (is_closed || first.contains('.') && second.contains('.'))
    {
        digits = first;
    }
    let commas = digits.matches(',').count();
    let full_stops = digits.matches('.').count();
    let has_point = decimal == Some(Decimal::Point) && full_stops == 0;
    let is_grouped = has_point && in_thousands(&digits.split(',').collect::<Vec<_>>());
    // A sign that occurs once, last, is the decimal one.
    let (whole, decimals) = match digits.rfind([',', '.']) {
        Some(place) if !is_grouped && digits.matches(&digits[place..=place]).count() == 1 => {
            (&digits[..place], &digits[place + 1..])
        }
        _ => (digits, ""),
    };
    let groups: Vec<&str> = whole.split([',', '.']).collect();
    let has_exponent = text[sign + digits.len()..].starts_with(['e', 'E']);
    let is_doubtful = match (commas, full_stops) {
        // `1,234`, and `1,234,567`, which may be three numbers.
        (1, 0) => decimal.is_none() && !has_exponent && in_thousands(&[whole, decimals]),
        (2.., 0) => !has_point && in_thousands(&groups),
        _ => false,
    };
    // `5.` is a whole number.
    let ends_with_point =
        !digits.is_empty() && commas + full_stops == 0 && text[sign + digits.len()..sign + run] == *".";
    let length = sign + digits.len() + usize::from(ends_with_point);
    if is_doubtful {
        return Some((Err(NoNumber::Thousands), length));
    }
    let has_both = whole.contains(',') && whole.contains('.');
    if groups.len() > 1 && (has_both || !in_thousands(&groups)) {
        return Some((Err(NoNumber::Signs), length));
    }
    // With the exponent behind the digits.
    let plain = format!("{}{}.{decimals}", &text[..sign], groups.concat());
    let (number, read) = fast_float2::parse_partial::<f64, _>(format!("{plain}{}", &text[length..])).ok()?;
    Some((Ok(number), length + read.saturating_sub(plain.len())))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn metre(text: &str) -> Result<Option<Vec<f64>>, NoNumber> {
        Lengths::parse(text, None, None).map(|lengths| lengths.map(|lengths| lengths.metre))
    }

    #[test]
    fn a_number_is_read_whole_or_the_text_is_refused() {
        for (text, wanted) in [
            ("0.5 um x 0.25 um", vec![0.5e-6, 0.25e-6]),
            ("1 2 mm", vec![1e-3, 2e-3]),
            ("(3, 4)", vec![3.0, 4.0]),
            ("1,5 um", vec![1.5e-6]),
            ("5. um", vec![5e-6]),
            ("0,125 um", vec![0.125e-6]),
            ("12,3456 um", vec![12.3456e-6]),
            ("-1,5", vec![-1.5]),
            ("1,234.5 um", vec![1234.5e-6]),
            ("1.234,5 um", vec![1234.5e-6]),
            ("1,234,567.25 nm", vec![1_234_567.25e-9]),
            ("1.234.567 nm", vec![1_234_567e-9]),
            ("1.234.567,5 nm", vec![1_234_567.5e-9]),
            ("2.5e-3 m", vec![2.5e-3]),
            ("1.234 um", vec![1.234e-6]),
            ("1000 1000 um", vec![1e-3; 2]),
            ("100, 200 um", vec![100e-6, 200e-6]),
            ("0.5,0.25 um", vec![0.5e-6, 0.25e-6]),
            ("(0.5,0.25) um", vec![0.5e-6, 0.25e-6]),
            ("(1,1) um", vec![1e-6; 2]),
            ("100 100 um", vec![100e-6; 2]),
            ("[250 250] nm", vec![250e-9; 2]),
            ("1e-6 200e-9 m", vec![1e-6, 200e-9]),
            ("1.5e3 200 nm", vec![1.5e-6, 200e-9]),
            ("2,5e-07 m", vec![2.5e-7]),
            ("1,234.5e-6 m", vec![1234.5e-6]),
            ("-1.5e2 mm", vec![-0.15]),
            ("1.5 250 um", vec![1.5e-6, 250e-6]),
        ] {
            let found = metre(text).unwrap().unwrap();
            assert_eq!(found.len(), wanted.len(), "{text}: {found:?}");
            assert!(found.iter().zip(&wanted).all(|(a, b)| (a / b - 1.0).abs() < 1e-15), "{text}: {found:?}");
        }
        for text in ["12.34.5", "1,23.4", "1,2,3", "0,234.5", "1234,567.8", "1.234.567,8,9", "1,234.567,890"] {
            assert_eq!(metre(text), Err(NoNumber::Signs), "{text}");
        }
        for text in ["1,234 um", "999,999", "1 234.5 um", "12 345 nm", "500,500,100 nm"] {
            assert_eq!(metre(text), Err(NoNumber::Thousands), "{text}");
        }
        assert_eq!(metre("0.5 µ"), Err(NoNumber::Prefix));
        let stated = |text, decimal| {
            Lengths::parse(text, None, Some(decimal)).map(|lengths| lengths.map(|lengths| lengths.metre))
        };
        for (text, comma, point) in
            [("10,000 um", 10e-6, 0.01), ("-1,234 nm", -1.234e-9, -1234e-9), ("1,5 um", 1.5e-6, 1.5e-6)]
        {
            assert_eq!(stated(text, Decimal::Comma), Ok(Some(vec![comma])), "{text}");
            assert_eq!(stated(text, Decimal::Point), Ok(Some(vec![point])), "{text}");
        }
        assert_eq!(stated("1,234,567 nm", Decimal::Point), Ok(Some(vec![1_234_567e-9])));
        assert_eq!(stated("1,234,567 nm", Decimal::Comma), Err(NoNumber::Thousands));
        for text in ["unknown", "", "um", "1 2 3 4", "v 3", "123,456 bytes", "640 480 px", "1,000 rpm"] {
            assert_eq!(metre(text), Ok(None), "{text}");
        }
    }
}
