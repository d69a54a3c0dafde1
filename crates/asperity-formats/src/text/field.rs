//! Fields: numbers, marks of missing heights, and errors of spreadsheets.

pub(super) const NO_DATA: &[u8] = b"No Data";

/// Returns whether a field marks a missing height.
pub(super) fn missing(field: &[u8]) -> bool {
    let is_nan = || {
        let unsigned = field.strip_prefix(b"-").unwrap_or(field);
        // C libraries write `-nan(ind)`.
        unsigned.get(..4).is_some_and(|start| start.eq_ignore_ascii_case(b"nan(")) && field.ends_with(b")")
    };
    field.is_empty()
        || field.eq_ignore_ascii_case(b"bad")
        || field.eq_ignore_ascii_case(NO_DATA)
        || spreadsheet_error(field) == Some(field)
        || is_nan()
}

/// Returns the length of a special number of Microsoft's C library (`1.#QNAN`, `-1.#IND00`, `1,#INF`) at the start.
pub(super) fn special_number(bytes: &[u8]) -> Option<usize> {
    let unsigned = bytes.strip_prefix(b"-").unwrap_or(bytes);
    let word = unsigned.strip_prefix(b"1.#").or_else(|| unsigned.strip_prefix(b"1,#"))?;
    let letters = word.iter().position(|byte| !byte.is_ascii_alphabetic()).unwrap_or(word.len());
    let is_mark = [&b"QNAN"[..], b"SNAN", b"IND", b"INF"].iter().any(|mark| word[..letters].eq_ignore_ascii_case(mark));
    let digits = word[letters..].iter().take_while(|byte| byte.is_ascii_digit()).count();
    is_mark.then_some(bytes.len() - word.len() + letters + digits)
}

/// Parses a number: NaN if it is infinite, `None` if it is beyond the range of `f64`.
pub(super) fn number(field: &[u8]) -> Option<f64> {
    let value: f64 = std::str::from_utf8(field).ok()?.parse().ok()?;
    let names_infinity = || field.iter().any(|byte| byte.eq_ignore_ascii_case(&b'n'));
    match value.is_infinite() {
        true => names_infinity().then_some(f64::NAN),
        false => Some(value),
    }
}

/// Errors that spreadsheets export for cells without a value. Their first character would otherwise start a comment.
const SPREADSHEET_ERRORS: [&[u8]; 8] =
    [b"#N/A", b"#DIV/0!", b"#VALUE!", b"#REF!", b"#NAME?", b"#NUM!", b"#NULL!", b"#NV"];

/// Returns the error of a spreadsheet at the start of a field.
pub(super) fn spreadsheet_error(rest: &[u8]) -> Option<&[u8]> {
    let is_end = |byte: Option<&u8>| byte.is_none_or(|byte| matches!(byte, b',' | b';') || byte.is_ascii_whitespace());
    let error = SPREADSHEET_ERRORS.iter().find(|error| rest.starts_with(error) && is_end(rest.get(error.len())))?;
    rest.get(..error.len())
}
