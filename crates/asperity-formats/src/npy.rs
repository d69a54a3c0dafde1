//! NumPy array files: a magic word, a header that is a Python dictionary, and the array.
//!
//! Two-dimensional arrays of integers or floats are heights in metre; the format has no place for a pixel size.
//! One-dimensional arrays are records along a path.
//! Layout: <https://numpy.org/doc/stable/reference/generated/numpy.lib.format.html>.

use ndarray::{Array2, ShapeBuilder};

use crate::error::shown;
use crate::format::{Codec, Description, Tested};
use crate::sample::{ByteOrder, Sample};
use crate::scan::{Dimension, shape};
use crate::{Format, FormatError, Location, ReadOptions, Scan};

pub(crate) const CODEC: Codec = Codec {
    description: Description {
        format: Format::Npy,
        name: "NPY",
        extensions: &["npy"],
        vendor: "NumPy",
        known_by: "`\\x93NUMPY`",
        reads: "versions 1 to 3; i1 i2 i4 i8 u1 u2 u4 u8 f4 f8, either byte order, C and Fortran order, two dimensions",
        writes: "float64",
        stores_pitch: false,
        missing_points: "NaN, ±inf",
        orientation: "the first index is the row",
        tested: Tested::OtherPrograms,
    },
    detect: |bytes| bytes.starts_with(MAGIC),
    read,
    write: Some(|scan| Ok(write_npy(scan))),
};

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
    shape: String,
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
fn read(bytes: &[u8], _options: &ReadOptions) -> Result<Scan, FormatError> {
    let (text, data_start) = header_text(bytes)?;
    let header = parse_header(&text)?;
    let [rows, columns] =
        dimensions(&header.shape).ok_or_else(|| wrong("shape", &header.shape, "two whole numbers"))?;
    let at = header_at();
    let (rows, columns) = shape(
        Format::Npy,
        &Dimension { field: "rows", at: at.clone(), found: rows },
        &Dimension { field: "columns", at, found: columns },
    )?;
    let (values, left_over) = array(bytes, data_start, &header, rows * columns)?;
    let heights_m = Array2::from_shape_vec((rows, columns).set_f(header.column_major), values)
        .map_err(|error| wrong("shape", &format!("({rows}, {columns})"), &error.to_string()))?;
    let heights_m = if header.column_major { heights_m.as_standard_layout().into_owned() } else { heights_m };
    let mut scan = Scan::new(heights_m, None);
    if left_over > 0 {
        scan.warnings.push(format!("{left_over} bytes after the array were left out"));
    }
    Ok(scan)
}

/// Reads a one-dimensional array of numbers.
///
/// # Errors
/// As [`read`], for other than one dimension, and for bytes after the array.
pub(crate) fn read_series(bytes: &[u8]) -> Result<Vec<f64>, FormatError> {
    let (text, data_start) = header_text(bytes)?;
    let header = parse_header(&text)?;
    let [length] = dimensions(&header.shape).ok_or_else(|| wrong("shape", &header.shape, "one whole number"))?;
    let (rows, columns) = shape(
        Format::Npy,
        &Dimension { field: "length", at: header_at(), found: length },
        &Dimension { field: "columns", at: header_at(), found: 1 },
    )?;
    let (values, left_over) = array(bytes, data_start, &header, rows * columns)?;
    if left_over > 0 {
        return Err(wrong("shape", &header.shape, "an array that ends with the file"));
    }
    Ok(values)
}

/// The `points` numbers of the array in the file's order, and the number of bytes behind them.
fn array(bytes: &[u8], start: usize, header: &Header, points: usize) -> Result<(Vec<f64>, usize), FormatError> {
    let wanted = points * header.sample.size();
    let present = bytes.get(start..).unwrap_or_default();
    let data = present.get(..wanted).ok_or_else(|| truncated("the array", start, present.len(), wanted))?;
    Ok((header.sample.decode_all(header.order, data), present.len() - wanted))
}

/// The dictionary and the byte where the array starts.
fn header_text(bytes: &[u8]) -> Result<(String, usize), FormatError> {
    let short = || truncated("the bytes of the header", MAGIC.len(), bytes.len().saturating_sub(MAGIC.len()), 4);
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
    let header =
        present.get(..length).ok_or_else(|| truncated("the bytes of the header", start, present.len(), length))?;
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
    Ok(Header { sample, order, column_major, shape: value("shape")?.to_owned() })
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

/// The numbers of `(rows, columns)` or `(length,)`, if there are as many as wanted.
fn dimensions<const N: usize>(literal: &str) -> Option<[i64; N]> {
    let inner = literal.strip_prefix('(')?.strip_suffix(')')?.trim_end();
    let inner = inner.strip_suffix(',').unwrap_or(inner);
    let numbers: Option<Vec<i64>> = inner.split(',').map(|number| number.trim().parse().ok()).collect();
    numbers?.try_into().ok()
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
