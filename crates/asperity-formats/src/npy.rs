//! NumPy array files: a magic word, a header that is a Python dictionary, and the array.
//!
//! Two-dimensional arrays of integers or floats are heights in metre; the format has no place for a pixel size.
//! Layout: <https://numpy.org/doc/stable/reference/generated/numpy.lib.format.html>.

use ndarray::{Array2, ShapeBuilder};

use crate::error::shown;
use crate::sample::{ByteOrder, Sample};
use crate::scan::{Dimension, shape};
use crate::{Format, FormatError, Location, Scan};

/// First bytes of every file.
pub(crate) const MAGIC: &[u8] = b"\x93NUMPY";
/// Bytes before the header's length: magic word and version.
const VERSION_END: usize = 8;
/// The array starts at a multiple of this many bytes.
const ALIGNMENT: usize = 64;
/// What can be read, for messages.
const WANTED_TYPE: &str = "integers or floats: i1 i2 i4 i8 u1 u2 u4 u8 f4 f8, with < or > before";

/// What the header's dictionary says.
struct Header {
    sample: Sample,
    order: ByteOrder,
    column_major: bool,
    rows: i64,
    columns: i64,
}

fn header_at() -> Location {
    Location::Byte(VERSION_END as u64)
}

fn wrong(field: &str, found: &str, wanted: &str) -> FormatError {
    FormatError::Field {
        format: Format::Npy,
        field: field.into(),
        at: header_at(),
        found: shown(found),
        wanted: wanted.into(),
    }
}

fn truncated(part: &str, at: usize, found: usize, wanted: usize) -> FormatError {
    FormatError::Truncated {
        format: Format::Npy,
        part: part.into(),
        at: Location::Byte(at as u64),
        found: found as u64,
        wanted: wanted as u64,
    }
}

/// Reads a two-dimensional array as heights in metre.
///
/// # Errors
/// Versions other than 1 to 3, headers that are no dictionary of the three known keys, other element types, other than
/// two dimensions, and data that end early.
pub(crate) fn read(bytes: &[u8]) -> Result<Scan, FormatError> {
    let (text, data_start) = header_text(bytes)?;
    let header = parse_header(&text)?;
    let at = header_at();
    let (rows, columns) = shape(
        Format::Npy,
        &Dimension { field: "rows", at: at.clone(), found: header.rows },
        &Dimension { field: "columns", at, found: header.columns },
    )?;
    let wanted = rows * columns * header.sample.size();
    let present = bytes.get(data_start..).unwrap_or_default();
    let data = present.get(..wanted).ok_or_else(|| truncated("the array", data_start, present.len(), wanted))?;
    let mut values = Vec::with_capacity(rows * columns);
    header.sample.decode(header.order, data, &mut values);
    let heights_m = Array2::from_shape_vec((rows, columns).set_f(header.column_major), values)
        .map_err(|error| wrong("shape", &format!("({rows}, {columns})"), &error.to_string()))?;
    let mut scan = Scan::new(heights_m.as_standard_layout().into_owned(), None);
    if present.len() > wanted {
        scan.warnings.push(format!("{} bytes after the array were left out", present.len() - wanted));
    }
    Ok(scan)
}

/// The dictionary and the byte where the array starts.
fn header_text(bytes: &[u8]) -> Result<(String, usize), FormatError> {
    let short = || truncated("the header", MAGIC.len(), bytes.len().saturating_sub(MAGIC.len()), 4);
    let version = *bytes.get(MAGIC.len()).ok_or_else(short)?;
    let rest = bytes.get(VERSION_END..).unwrap_or_default();
    let (length, start) = match version {
        1 => rest.first_chunk().map(|&raw| (usize::from(u16::from_le_bytes(raw)), VERSION_END + 2)),
        // A length beyond the address space is beyond the bytes as well.
        2 | 3 => rest
            .first_chunk()
            .map(|&raw| (usize::try_from(u32::from_le_bytes(raw)).unwrap_or(usize::MAX), VERSION_END + 4)),
        _ => {
            let found = format!("version {version}");
            return Err(FormatError::Unsupported { format: Format::Npy, found, wanted: "version 1, 2 or 3" });
        }
    }
    .ok_or_else(short)?;
    let present = &bytes[start..];
    let header = present.get(..length).ok_or_else(|| truncated("the header", start, present.len(), length))?;
    let text = match version {
        3 => String::from_utf8_lossy(header).into_owned(),
        _ => header.iter().map(|&byte| char::from(byte)).collect(),
    };
    Ok((text, start + length))
}

/// Reads `{'descr': '<f8', 'fortran_order': False, 'shape': (2, 3), }`.
fn parse_header(text: &str) -> Result<Header, FormatError> {
    let inner = text.trim().strip_prefix('{').and_then(|text| text.strip_suffix('}'));
    let entries = inner.and_then(entries).ok_or_else(|| wrong("header", text, "a dictionary of text keys"))?;
    let value = |key: &str| {
        let found = entries.iter().find(|(name, _)| *name == key).map(|(_, value)| *value);
        found.ok_or_else(|| FormatError::MissingField {
            format: Format::Npy,
            field: key.into(),
            at: header_at(),
            wanted: "the keys descr, fortran_order and shape".into(),
        })
    };
    let (sample, order) = element_type(value("descr")?)?;
    let column_major = match value("fortran_order")? {
        "True" => true,
        "False" => false,
        other => return Err(wrong("fortran_order", other, "True or False")),
    };
    let shape = value("shape")?;
    let (rows, columns) = dimensions(shape).ok_or_else(|| wrong("shape", shape, "two whole numbers"))?;
    Ok(Header { sample, order, column_major, rows, columns })
}

/// Splits the inside of a dictionary at its outermost commas and colons; `None` when it is no such thing.
fn entries(text: &str) -> Option<Vec<(&str, &str)>> {
    let mut entries = Vec::new();
    for item in split_outermost(text, ',')? {
        if item.trim().is_empty() {
            continue;
        }
        let [key, value] = split_outermost(item, ':')?.try_into().ok()?;
        entries.push((quoted(key.trim())?, value.trim()));
    }
    Some(entries)
}

/// Splits at separators that stand outside of quotes and brackets; `None` when those do not close.
fn split_outermost(text: &str, separator: char) -> Option<Vec<&str>> {
    let (mut parts, mut start, mut depth, mut quote) = (Vec::new(), 0, 0_usize, None);
    for (position, c) in text.char_indices() {
        match (quote, c) {
            (Some(open), _) if c == open => quote = None,
            (Some(_), _) => (),
            (None, '\'' | '"') => quote = Some(c),
            (None, '(' | '[' | '{') => depth += 1,
            (None, ')' | ']' | '}') => depth = depth.checked_sub(1)?,
            (None, _) if c == separator && depth == 0 => {
                parts.push(&text[start..position]);
                start = position + c.len_utf8();
            }
            _ => (),
        }
    }
    parts.push(&text[start..]);
    (depth == 0 && quote.is_none()).then_some(parts)
}

/// The inside of a Python text literal without escapes.
fn quoted(text: &str) -> Option<&str> {
    ['\'', '"'].into_iter().find_map(|quote| text.strip_prefix(quote)?.strip_suffix(quote))
}

fn element_type(literal: &str) -> Result<(Sample, ByteOrder), FormatError> {
    let refused = || FormatError::Unsupported {
        format: Format::Npy,
        found: format!("the element type is {}", shown(literal)),
        wanted: WANTED_TYPE,
    };
    let descr = quoted(literal).ok_or_else(refused)?;
    let sample = match descr.get(1..).ok_or_else(refused)? {
        "i1" => Sample::I8,
        "u1" => Sample::U8,
        "i2" => Sample::I16,
        "u2" => Sample::U16,
        "i4" => Sample::I32,
        "u4" => Sample::U32,
        "i8" => Sample::I64,
        "u8" => Sample::U64,
        "f4" => Sample::F32,
        "f8" => Sample::F64,
        _ => return Err(refused()),
    };
    let order = match (&descr[..1], sample.size()) {
        ("<", _) | ("|", 1) => ByteOrder::Little,
        (">", _) => ByteOrder::Big,
        _ => return Err(refused()),
    };
    Ok((sample, order))
}

/// The two numbers of `(rows, columns)`.
fn dimensions(literal: &str) -> Option<(i64, i64)> {
    let inner = literal.strip_prefix('(')?.strip_suffix(')')?;
    let inner = inner.trim_end().strip_suffix(',').unwrap_or(inner);
    let (rows, columns) = inner.split_once(',')?;
    Some((rows.trim().parse().ok()?, columns.trim().parse().ok()?))
}

/// The heights in metre as a NumPy array file, version 1.0, little-endian `f8` in row order, NaN where missing.
///
/// The pixel size and the metadata are not stored.
pub fn write_npy(scan: &Scan) -> Vec<u8> {
    let (rows, columns) = scan.heights_m.dim();
    let mut header = format!("{{'descr': '<f8', 'fortran_order': False, 'shape': ({rows}, {columns}), }}");
    let unpadded = VERSION_END + 2 + header.len() + 1;
    header.push_str(&" ".repeat(unpadded.next_multiple_of(ALIGNMENT) - unpadded));
    header.push('\n');
    let mut bytes = Vec::with_capacity(VERSION_END + 2 + header.len() + 8 * scan.heights_m.len());
    bytes.extend(MAGIC);
    bytes.extend([1, 0]);
    // Two dimensions of at most 20 digits keep the header far below the 65535 bytes of version 1.0.
    bytes.extend((header.len() as u16).to_le_bytes());
    bytes.extend(header.as_bytes());
    for &z in &scan.heights_m {
        bytes.extend(if z.is_finite() { z } else { f64::NAN }.to_le_bytes());
    }
    bytes
}
