//! NumPy array files: a magic word, a header in the form of a Python dictionary, and the array.
//!
//! Two-dimensional arrays of integers or floats are heights in metre. The format does not store a pixel size.
//! One-dimensional arrays are records along a path. Layout:
//! <https://numpy.org/doc/stable/reference/generated/numpy.lib.format.html>.

use crate::sample::stored;
use crate::{
    ByteOrder, Description, Format, FormatError, Input, ReadOptions, Result, Sample, Scan, Tested, refuse_if, shown,
    warn_if,
};

pub(crate) const CODEC: Description = Description {
    extensions: &["npy"],
    vendor: "NumPy",
    known_by: "`\\x93NUMPY`",
    reads: "versions 1 to 3; i1 i2 i4 i8 u1 u2 u4 u8 f4 f8, either byte order, C and Fortran order, two dimensions",
    writes: "float64",
    stores_pitch: false,
    missing_points: "NaN, ±inf",
    orientation: "the first index is the row",
    write: Some(|scan| Ok(write_npy(scan))),
    tested: Tested::OtherPrograms,
    ..Description::new(Format::Npy, |bytes| bytes.starts_with(MAGIC), read)
};

/// First bytes of every file.
pub(crate) const MAGIC: &[u8] = b"\x93NUMPY";
/// Offset of the length of the header, after magic word and version.
const VERSION_END: usize = 8;
/// Maximum size of the dictionary in bytes. NumPy itself refuses more than 10,000 characters.
const MAX_HEADER_BYTES: usize = 1 << 16;
/// Alignment of the array in bytes.
const ALIGNMENT: usize = 64;
/// Supported types, for messages.
const WANTED_TYPE: &str = "integers or floats: i1 i2 i4 i8 u1 u2 u4 u8 f4 f8, with < or > before";

/// Header of a file.
pub(crate) struct Header {
    pub(crate) sample: Sample,
    pub(crate) order: ByteOrder,
    /// Whether the first index varies fastest.
    pub(crate) column_major: bool,
    /// Literal of the shape, such as `(2, 3)`.
    shape: String,
    /// Offset of the array.
    pub(crate) start: usize,
}

/// Reads a two-dimensional array as heights in metre.
///
/// # Errors
/// Versions other than 1 to 3, headers that are not a dictionary of the three known keys, other element types, other
/// than two dimensions, and data that end early.
fn read(bytes: &[u8], _options: &ReadOptions) -> Result<Scan> {
    let input = Input::new(Format::Npy, bytes);
    let header = Header::parse(&input)?;
    let (rows, columns) = header.matrix(&input)?;
    let (bytes, left_over) = array(&input, &header, rows * columns)?;
    let values = match header.column_major {
        true => header.sample.decode_columns(header.order, bytes, (rows, columns)),
        false => header.sample.decode_all(header.order, bytes),
    };
    let heights_m = input.matrix("shape", VERSION_END, (rows, columns), values)?;
    let mut scan = Scan::new(heights_m, None);
    warn_if!(scan.warnings, left_over > 0, "{left_over} bytes after the array were left out");
    Ok(scan)
}

/// Reads a one-dimensional array of numbers.
///
/// # Errors
/// As [`read`], for other than one dimension, and for bytes after the array.
pub(crate) fn read_series(bytes: &[u8]) -> Result<Vec<f64>> {
    let input = Input::new(Format::Npy, bytes);
    let header = Header::parse(&input)?;
    let Some([length]) = header.dimensions().and_then(|all| <[i64; 1]>::try_from(all).ok()) else {
        return Err(wrong(&input, "shape", &header.shape, "one whole number"));
    };
    let (rows, columns) = input.shape(("length", VERSION_END, length), ("columns", VERSION_END, 1))?;
    let (bytes, left_over) = array(&input, &header, rows * columns)?;
    refuse_if!(left_over > 0, wrong(&input, "shape", &header.shape, "an array that ends with the file"));
    Ok(header.sample.decode_all(header.order, bytes))
}

fn wrong(input: &Input, field: &str, found: &str, wanted: &str) -> FormatError {
    input.wrong(field, VERSION_END, found, wanted)
}

/// Returns the bytes of an array of `points` numbers, and the number of bytes after them.
fn array<'a>(input: &Input<'a>, header: &Header, points: usize) -> Result<(&'a [u8], usize)> {
    let length = points.saturating_mul(header.sample.size());
    let bytes = input.take("the array", header.start, length)?;
    Ok((bytes, input.len() - header.start - length))
}

impl Header {
    /// Parses the header at the start of a file.
    ///
    /// # Errors
    /// As [`read`], except for the array.
    pub(crate) fn parse(input: &Input) -> Result<Self> {
        let (text, start) = header_text(input)?;
        let inner = text.trim().strip_prefix('{').and_then(|text| text.strip_suffix('}'));
        let entries =
            inner.and_then(entries).ok_or_else(|| wrong(input, "header", &text, "a dictionary of text keys"))?;
        let value = |key: &str| {
            let found = entries.iter().find(|(name, _)| *name == key).map(|(_, value)| *value);
            found.ok_or_else(|| input.missing(key, VERSION_END, "the keys descr, fortran_order and shape"))
        };
        let (sample, order) = element_type(input, value("descr")?)?;
        let column_major = match value("fortran_order")? {
            "True" => true,
            "False" => false,
            other => return Err(wrong(input, "fortran_order", other, "True or False")),
        };
        Ok(Self { sample, order, column_major, shape: value("shape")?.to_owned(), start })
    }

    /// Returns the numbers of `()`, `(length,)`, `(rows, columns)`, …; `None` if they are not whole numbers.
    pub(crate) fn dimensions(&self) -> Option<Vec<i64>> {
        let inner = self.shape.strip_prefix('(')?.strip_suffix(')')?.trim();
        if inner.is_empty() {
            return Some(Vec::new());
        }
        inner.strip_suffix(',').unwrap_or(inner).split(',').map(|number| number.trim().parse().ok()).collect()
    }

    /// Returns the checked rows and columns of a two-dimensional array.
    ///
    /// # Errors
    /// Other than two dimensions, and shapes that [`Input::shape`] refuses.
    pub(crate) fn matrix(&self, input: &Input) -> Result<(usize, usize)> {
        match self.dimensions().as_deref() {
            Some(&[rows, columns]) => input.shape(("rows", VERSION_END, rows), ("columns", VERSION_END, columns)),
            _ => Err(wrong(input, "shape", &self.shape, "two whole numbers")),
        }
    }
}

/// Returns the dictionary and the offset of the array.
fn header_text(input: &Input) -> Result<(String, usize)> {
    const PART: &str = "the bytes of the header";
    let start = input.take(PART, 0, VERSION_END)?;
    refuse_if!(!start.starts_with(MAGIC), input.wrong("signature", 0, start.escape_ascii(), "\\x93NUMPY"));
    let version = input.u8(PART, MAGIC.len())?;
    let (length, start) = match version {
        1 => (usize::from(input.u16(PART, VERSION_END)?), VERSION_END + 2),
        // A length beyond the address space is also beyond the end of the file.
        2 | 3 => (usize::try_from(input.u32(PART, VERSION_END)?).unwrap_or(usize::MAX), VERSION_END + 4),
        _ => return Err(input.unsupported(format!("version {version}"), "version 1, 2 or 3")),
    };
    if length > MAX_HEADER_BYTES {
        return Err(input.too_large("the length of the header", VERSION_END, length, MAX_HEADER_BYTES));
    }
    let header = input.take(PART, start, length)?;
    let text = match version {
        3 => String::from_utf8_lossy(header).into_owned(),
        _ => header.iter().map(|&byte| char::from(byte)).collect(),
    };
    Ok((text, start + length))
}

/// Splits the content of a dictionary at its outermost commas and colons; `None` if it is not a dictionary.
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

/// Splits at separators outside of quotes and brackets; `None` if one of these does not close.
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

/// Returns the content of a Python text literal without escapes.
fn quoted(text: &str) -> Option<&str> {
    ['\'', '"'].into_iter().find_map(|quote| text.strip_prefix(quote)?.strip_suffix(quote))
}

fn element_type(input: &Input, literal: &str) -> Result<(Sample, ByteOrder)> {
    let refused = || input.unsupported(format!("the element type is {}", shown(literal)), WANTED_TYPE);
    let Some(&[order, kind, size]) = quoted(literal).map(str::as_bytes) else { return Err(refused()) };
    let bits = 8 * u64::from(size.wrapping_sub(b'0'));
    let sample = match kind {
        b'i' | b'u' => Sample::integer(bits, kind == b'i'),
        b'f' => Sample::float(bits),
        _ => None,
    };
    let sample = sample.ok_or_else(refused)?;
    match (order, sample.size()) {
        (b'<', _) | (b'|', 1) => Ok((sample, ByteOrder::Little)),
        (b'>', _) => Ok((sample, ByteOrder::Big)),
        _ => Err(refused()),
    }
}

/// Writes the heights in metre as a NumPy array file: version 1.0, little-endian `f8` in row order, NaN for missing
/// points.
///
/// The pixel size and the metadata are not stored.
pub fn write_npy(scan: &Scan) -> Vec<u8> {
    let (rows, columns) = scan.heights_m.dim();
    array_file(&format!("{rows}, {columns}"), scan.heights_m.len(), scan.heights_m.iter())
}

/// Writes a record along a path as a one-dimensional NumPy array file for [`crate::read_series`]; NaN for missing
/// values.
pub fn write_series(values: &[f64]) -> Vec<u8> {
    array_file(&format!("{},", values.len()), values.len(), values.iter())
}

fn array_file<'v>(shape: &str, length: usize, values: impl Iterator<Item = &'v f64>) -> Vec<u8> {
    let mut header = format!("{{'descr': '<f8', 'fortran_order': False, 'shape': ({shape}), }}");
    let unpadded = VERSION_END + 2 + header.len() + 1;
    header.push_str(&" ".repeat(unpadded.next_multiple_of(ALIGNMENT) - unpadded));
    header.push('\n');
    let mut bytes = Vec::with_capacity(VERSION_END + 2 + header.len() + 8 * length);
    bytes.extend(MAGIC);
    bytes.extend([1, 0]);
    // Two dimensions of at most 20 digits keep the header far below the 65535 bytes of version 1.0.
    bytes.extend((header.len() as u16).to_le_bytes());
    bytes.extend(header.as_bytes());
    for z in values {
        bytes.extend(stored(z));
    }
    bytes
}
