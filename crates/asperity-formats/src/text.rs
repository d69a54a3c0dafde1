//! A matrix of numbers as text: one row of heights in metre per line.
//!
//! Values are separated by semicolons, tabs, commas or spaces, whichever of these, in this order, the first row holds.
//! The decimal sign is the point. `#` and `%` start a comment; `name: value` and `name = value` in a comment become
//! metadata. An empty field, `nan` and `inf` are missing heights. The format has no place for a pixel size.

use std::borrow::Cow;
use std::collections::BTreeMap;
use std::fmt::Write;

use ndarray::Array2;

use crate::error::shown;
use crate::format::{Codec, Description, Tested};
use crate::{Format, FormatError, Location, MAX_POINTS, ReadOptions, Scan};

pub(crate) const CODEC: Codec = Codec {
    description: Description {
        format: Format::Text,
        name: "text",
        extensions: &["txt", "dat", "csv", "asc"],
        vendor: "any",
        known_by: "no control characters",
        reads: "one row per line; spaces, tabs, commas or semicolons; `#` and `%` start comments",
        writes: ".csv with commas, others with spaces",
        stores_pitch: false,
        missing_points: "empty, nan, inf",
        orientation: "the first line is row 0",
        tested: Tested::OtherPrograms,
    },
    detect: is_text,
    read,
    write: Some(|scan| Ok(write_text(scan, Separator::Space))),
};

/// Bytes that are looked at to tell text from binary data.
const TEXT_PROBE: usize = 4096;

/// Whether bytes start without control characters.
pub(crate) fn is_text(bytes: &[u8]) -> bool {
    let probe = &bytes[..bytes.len().min(TEXT_PROBE)];
    let is_text = |&byte: &u8| byte >= 0x20 && byte != 0x7f || matches!(byte, b'\t' | b'\n' | b'\r' | 0x0c);
    !probe.is_empty() && probe.iter().all(is_text)
}

/// Rows from which three columns look like points rather than like a map.
const POINT_LIST_ROWS: usize = 16;

/// What stands between two values.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Separator {
    /// One or more spaces or tabs.
    Space,
    /// A comma.
    Comma,
    /// A semicolon.
    Semicolon,
    /// A tab; two in a row enclose an empty field.
    Tab,
}

impl Separator {
    /// The separator of a row.
    fn of(row: &str) -> Self {
        if row.contains(';') {
            Self::Semicolon
        } else if row.contains('\t') {
            Self::Tab
        } else if row.contains(',') {
            Self::Comma
        } else {
            Self::Space
        }
    }

    fn sign(self) -> char {
        match self {
            Self::Space => ' ',
            Self::Comma => ',',
            Self::Semicolon => ';',
            Self::Tab => '\t',
        }
    }

    fn fields(self, row: &str) -> Vec<&str> {
        match self {
            Self::Space => row.split_whitespace().collect(),
            _ => row.split(self.sign()).map(str::trim).collect(),
        }
    }
}

/// Reads a matrix of heights in metre.
///
/// # Errors
/// A field that is no number, rows of different length (naming the line), or no row at all.
fn read(bytes: &[u8], _options: &ReadOptions) -> Result<Scan, FormatError> {
    let bytes = bytes.strip_prefix(b"\xef\xbb\xbf").unwrap_or(bytes);
    // Numbers are ASCII; only comments can hold more, and then in UTF-8 or Latin-1.
    let latin1 = || bytes.iter().map(|&byte| char::from(byte)).collect();
    let text = std::str::from_utf8(bytes).map_or_else(|_| Cow::Owned(latin1()), Cow::Borrowed);
    let line_end = if text.contains('\n') { '\n' } else { '\r' };

    let mut matrix = Matrix::default();
    let mut metadata = BTreeMap::new();
    for (index, line) in text.split(line_end).enumerate() {
        let (row, comment) = match line.find(['#', '%']) {
            Some(start) => (&line[..start], Some(line[start..].trim_start_matches(['#', '%']).trim())),
            None => (line, None),
        };
        if let Some(comment) = comment {
            keep(&mut metadata, comment);
        }
        // A tab is a separator, and one at the start of a line follows an empty field.
        let row = row.trim_matches([' ', '\r', '\u{c}']);
        if !row.is_empty() {
            matrix.push(row, index + 1)?;
        }
    }
    let (heights_m, mut warnings) = matrix.finish()?;
    warnings.extend(unit_warnings(&metadata));
    Ok(Scan { metadata, warnings, ..Scan::new(heights_m, None) })
}

/// Adds what a comment says.
fn keep(metadata: &mut BTreeMap<String, String>, comment: &str) {
    let pair = comment.split_once([':', '=']).map(|(key, value)| (key.trim(), value.trim()));
    let (key, value) = pair.filter(|(key, value)| !key.is_empty() && !value.is_empty()).unwrap_or(("comment", comment));
    if !value.is_empty() {
        let kept = metadata.entry(key.into()).or_default();
        if !kept.is_empty() {
            kept.push('\n');
        }
        kept.push_str(value);
    }
}

/// Doubts where a comment states a unit other than metre.
fn unit_warnings(metadata: &BTreeMap<String, String>) -> impl Iterator<Item = String> {
    let units = metadata.iter().filter(|(key, _)| key.to_lowercase().contains("unit"));
    units
        .filter(|(_, unit)| unit.as_str() != "m")
        .map(|(key, unit)| format!("a comment states `{}: {}`; heights were taken as metre", shown(key), shown(unit)))
}

/// Rows as they are read.
#[derive(Default)]
struct Matrix {
    separator: Option<Separator>,
    columns: usize,
    rows: usize,
    values: Vec<f64>,
    /// Rows that end with a separator.
    open_rows: usize,
}

impl Matrix {
    fn push(&mut self, row: &str, line: usize) -> Result<(), FormatError> {
        let separator = *self.separator.get_or_insert_with(|| Separator::of(row));
        let fields = separator.fields(row);
        if self.rows == 0 {
            self.columns = fields.len();
        } else if fields.len() != self.columns {
            return Err(FormatError::Ragged { line, found: fields.len(), wanted: self.columns });
        }
        self.rows += 1;
        self.open_rows += usize::from(fields.last().is_some_and(|field| field.is_empty()));
        for (column, field) in fields.iter().enumerate() {
            self.values.push(number(field).ok_or_else(|| not_a_number(field, column + 1, line))?);
        }
        if self.values.len() as u64 > MAX_POINTS {
            return Err(FormatError::TooLarge {
                format: Format::Text,
                field: "the number of values".into(),
                at: Location::Line(line),
                found: self.values.len() as u64,
                limit: MAX_POINTS,
            });
        }
        Ok(())
    }

    fn finish(mut self) -> Result<(Array2<f64>, Vec<String>), FormatError> {
        let mut warnings = Vec::new();
        if self.columns > 1 && self.open_rows == self.rows {
            let columns = self.columns;
            let mut column = 0;
            self.values.retain(|_| {
                column = column % columns + 1;
                column < columns
            });
            self.columns -= 1;
            warnings.push("every row ends with a separator; the empty last column was left out".into());
        }
        if self.columns == 3 && self.rows >= POINT_LIST_ROWS {
            warnings.push(format!(
                "a map of 3 columns and {} rows; a list of points x y z is not what this format holds",
                self.rows
            ));
        }
        let nothing = FormatError::MissingField {
            format: Format::Text,
            field: "a row of numbers".into(),
            at: Location::Line(1),
            wanted: "one row of heights per line".into(),
        };
        if self.values.is_empty() {
            return Err(nothing);
        }
        let heights_m = Array2::from_shape_vec((self.rows, self.columns), self.values).map_err(|_| nothing)?;
        Ok((heights_m, warnings))
    }
}

/// The height of a field, NaN where missing, `None` where it is no number or beyond the range of `f64`.
fn number(field: &str) -> Option<f64> {
    if field.is_empty() {
        return Some(f64::NAN);
    }
    let value: f64 = field.parse().ok()?;
    let names_infinity = || field.bytes().any(|byte| byte.eq_ignore_ascii_case(&b'n'));
    (!value.is_infinite() || names_infinity()).then_some(value)
}

fn not_a_number(field: &str, column: usize, line: usize) -> FormatError {
    let hint = match field.replace(',', ".").parse::<f64>() {
        Ok(_) => "a number with a decimal point",
        Err(_) => "a number, an empty field, nan or inf (start comments with # or %)",
    };
    FormatError::Field {
        format: Format::Text,
        field: format!("value {column}"),
        at: Location::Line(line),
        found: shown(field),
        wanted: hint.into(),
    }
}

/// The heights in metre as text, one row per line, each number in the fewest digits that read back to the same `f64`,
/// `nan` where missing. The pixel size and the metadata are not stored.
pub fn write_text(scan: &Scan, separator: Separator) -> Vec<u8> {
    let mut text = String::new();
    for row in scan.heights_m.rows() {
        for (column, &z) in row.iter().enumerate() {
            if column > 0 {
                text.push(separator.sign());
            }
            // Writing to a String cannot fail.
            let _ = if z.is_finite() { write!(text, "{z:e}") } else { write!(text, "nan") };
        }
        text.push('\n');
    }
    text.into_bytes()
}
