//! Decimal signs: the point, the comma, and commas between thousands.

use super::field::number;

/// Decimal sign of the numbers in a text.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Decimal {
    /// The comma: `1,234` is 1.234.
    Comma,
    /// The point: `1,234` is 1234.
    Point,
}

impl Decimal {
    /// Returns the decimal sign that a header names.
    pub(super) fn named(text: &str) -> Option<Self> {
        match text.trim_matches(['"', '\'', '`']).to_lowercase().as_str() {
            "comma" | "," => Some(Self::Comma),
            "point" | "dot" | "." => Some(Self::Point),
            _ => None,
        }
    }
}

/// Returns whether groups of digits may be those of thousands: `1`, `234`, `567`.
pub(super) fn in_thousands(groups: &[&str]) -> bool {
    let is_digits = |group: &&str| group.bytes().all(|byte| byte.is_ascii_digit());
    let [first, rest @ ..] = groups else { return false };
    (1..=3).contains(&first.len())
        && !first.starts_with('0')
        && rest.iter().all(|group| group.len() == 3)
        && groups.iter().all(is_digits)
}

/// Returns whether the comma of a number may be a decimal sign or separate thousands, as in `1,234`, but not in `0,5`.
pub(crate) fn is_ambiguous(field: &[u8]) -> bool {
    let text = std::str::from_utf8(field).unwrap_or_default();
    let groups: Vec<&str> = text.strip_prefix(['+', '-']).unwrap_or(text).split(',').collect();
    groups.len() == 2 && in_thousands(&groups)
}

/// Parses a number with commas: one between digits is the decimal sign, unless this is stated to be the point.
pub(super) fn with_comma(field: &[u8], decimal: Option<Decimal>) -> Option<f64> {
    match decimal {
        Some(Decimal::Point) => in_groups(field),
        _ => decimal_comma(field),
    }
}

/// Parses a number with one comma between digits as decimal sign.
fn decimal_comma(field: &[u8]) -> Option<f64> {
    let place = field.iter().position(|&byte| byte == b',')?;
    let is_digit = |place: Option<usize>| place.and_then(|place| field.get(place)).is_some_and(u8::is_ascii_digit);
    if !is_digit(place.checked_sub(1)) || !is_digit(place.checked_add(1)) || field.contains(&b'.') {
        return None;
    }
    let mut field = field.to_vec();
    field[place] = b'.';
    number(&field)
}

/// Parses a number with commas between thousands, `1,234.5`.
fn in_groups(field: &[u8]) -> Option<f64> {
    let text = std::str::from_utf8(field).ok()?;
    let unsigned = text.strip_prefix(['+', '-']).unwrap_or(text);
    let whole = unsigned.find(|c: char| !c.is_ascii_digit() && c != ',').map_or(unsigned, |end| &unsigned[..end]);
    let is_grouped = in_thousands(&whole.split(',').collect::<Vec<_>>());
    let plain = unsigned[whole.len()..].bytes().all(|byte| byte != b',') && is_grouped;
    plain.then(|| number(text.replace(',', "").as_bytes())).flatten()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_comma_may_separate_thousands_before_three_digits() {
        for text in ["1,234", "12,345", "-123,456", "+1,000"] {
            assert!(is_ambiguous(text.as_bytes()), "{text}");
        }
        for text in ["0,5", "12,34", "0,123", "1,2345", "1234,567", "1,234e3", "1,234,567", "1,234.5", ",123", "1,"] {
            assert!(!is_ambiguous(text.as_bytes()), "{text}");
        }
    }

    #[test]
    fn commas_are_read_as_the_decimal_sign_demands() {
        let point = |text: &str| with_comma(text.as_bytes(), Some(Decimal::Point));
        for (text, value) in [("1,234", 1234.0), ("-12,345.5", -12345.5), ("1,234,567", 1_234_567.0), ("1,000e-3", 1.0)]
        {
            assert_eq!(point(text), Some(value), "{text}");
        }
        for text in ["0,5", "1,23", "1234,567", "0,123", "1.5,000", "1,234,56"] {
            assert_eq!(point(text), None, "{text}");
        }
        for decimal in [None, Some(Decimal::Comma)] {
            assert_eq!(with_comma(b"1,234", decimal), Some(1.234));
            assert_eq!(with_comma(b"1,234.5", decimal), None);
        }
    }
}
