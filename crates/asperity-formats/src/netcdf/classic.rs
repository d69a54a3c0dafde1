//! Classic formats: a header of dimensions, attributes and variables, then the numbers, big-endian.
//!
//! Variables with the record dimension follow the others, record by record. Layout: NetCDF Classic, 64-bit Offset and
//! 64-bit Data Format Specifications.

use super::contents::{Attribute, Contents, Dimension, MAX_ENTRIES, MAX_NUMBERS, Value, Variable, transposed};
use crate::{ByteOrder, Format, Input, Result, Sample, Shape, large};

/// Tags of the three lists.
const DIMENSIONS: u32 = 0x0a;
const VARIABLES: u32 = 0x0b;
const ATTRIBUTES: u32 = 0x0c;
/// Alignment of the parts of a file in bytes.
const ALIGNMENT: usize = 4;
/// Maximum number of dimensions of a variable that is used.
const MAX_RANK: usize = 32;
/// Maximum size of a name in bytes in the netCDF library.
const MAX_NAME_BYTES: usize = 256;

/// Returns the version of a classic file: 1, 2 (64-bit offset) or 5 (64-bit data).
pub(super) fn version(bytes: &[u8]) -> Option<u8> {
    match bytes {
        [b'C', b'D', b'F', version @ (1 | 2 | 5), ..] => Some(*version),
        _ => None,
    }
}

/// Reads the header.
pub(super) fn read(bytes: &[u8]) -> Result<(Input<'_>, Contents)> {
    let input = Input::new(Format::NetCdf, bytes).with_order(ByteOrder::Big);
    let version = version(bytes).ok_or_else(|| input.wrong("version", 3, "other", "1, 2 or 5"))?;
    let mut header = Header { input, at: ALIGNMENT, version, room: MAX_ENTRIES };
    let records_at = header.at;
    let records = header.raw_count("number of records")?;
    let mut contents = Contents::default();
    let mut record_dimension = None;
    for place in 0..header.list("dimensions", DIMENSIONS)? {
        let name = header.name("name of a dimension")?;
        let length = header.count("length of a dimension")?;
        if length == 0 {
            record_dimension = Some(place);
        }
        contents.dimensions.push((name, length));
    }
    contents.attributes = header.attributes()?;
    for _ in 0..header.list("variables", VARIABLES)? {
        let variable = header.variable(&contents.dimensions, record_dimension)?;
        contents.variables.push(variable);
    }
    let mut in_records: Vec<&mut Variable> =
        contents.variables.iter_mut().filter(|variable| variable.record_bytes.is_some()).collect();
    let pads = in_records.len() > 1;
    let record_bytes = in_records.iter().filter_map(|variable| slab(variable, pads)).fold(0, usize::saturating_add);
    let records = match records {
        // A file that is still being written does not state the number of records. They are counted up to the end of
        // the file.
        None => {
            let start = in_records.iter().map(|variable| variable.at).min().unwrap_or(input.len());
            input.len().saturating_sub(start).checked_div(record_bytes).unwrap_or(0)
        }
        Some(found) => usize::try_from(found)
            .map_err(|_| input.wrong("number of records", records_at, found, "as many as the file holds"))?,
    };
    for variable in &mut in_records {
        variable.shape[0] = records;
        variable.record_bytes = Some(record_bytes);
    }
    if let Some(place) = record_dimension {
        contents.dimensions[place].1 = records;
    }
    Ok((input, contents))
}

/// Returns the size in bytes of one record of a variable; `None` for a variable without records. A single variable is
/// not padded.
fn slab(variable: &Variable, pads: bool) -> Option<usize> {
    variable.record_bytes?;
    let size = variable.sample.map_or(1, Sample::size);
    let bytes = variable.shape.iter().skip(1).fold(size, |bytes, &length| bytes.saturating_mul(length));
    Some(if pads { bytes.checked_next_multiple_of(ALIGNMENT).unwrap_or(usize::MAX) } else { bytes })
}

/// Returns the numbers of a variable in row order.
pub(super) fn numbers(input: &Input, variable: &Variable) -> Result<Vec<f64>> {
    let Some(sample) = variable.sample else { return Ok(Vec::new()) };
    let count = variable.shape.iter().copied().fold(1, usize::saturating_mul);
    let Some(record_bytes) = variable.record_bytes else {
        return input.samples(&variable.name, variable.at, count, sample);
    };
    let records = variable.shape.first().copied().unwrap_or_default();
    let bytes = slab(variable, false).unwrap_or_default();
    if count == 0 {
        return Ok(Vec::new());
    }
    // Memory is allocated only if the last record is present.
    input.take(&variable.name, variable.at.saturating_add(record_bytes.saturating_mul(records - 1)), bytes)?;
    let mut values = large::with_capacity(count);
    for record in 0..records {
        let slab = input.take(&variable.name, variable.at + record * record_bytes, bytes)?;
        sample.decode(ByteOrder::Big, slab, &mut values);
    }
    Ok(values)
}

/// Returns the numbers of a map in column order.
pub(super) fn columns(input: &Input, variable: &Variable, shape: Shape) -> Result<Vec<f64>> {
    let Some(sample) = variable.sample.filter(|_| variable.record_bytes.is_none()) else {
        return numbers(input, variable).map(|numbers| transposed(numbers, shape));
    };
    let (rows, columns) = shape;
    let bytes = input.take(&variable.name, variable.at, (rows * columns).saturating_mul(sample.size()))?;
    Ok(sample.decode_columns(ByteOrder::Big, bytes, (columns, rows)))
}

/// Header with the current offset.
struct Header<'a> {
    input: Input<'a>,
    at: usize,
    version: u8,
    /// Number of further dimensions, attributes and variables that are allowed.
    room: usize,
}

impl Header<'_> {
    fn u32(&mut self, field: &str) -> Result<u32> {
        let found = self.input.u32(field, self.at)?;
        self.at += 4;
        Ok(found)
    }

    /// Reads a count; `None` if all its bits are set.
    fn raw_count(&mut self, field: &str) -> Result<Option<u64>> {
        if self.version == 5 {
            let found = self.input.u64(field, self.at)?;
            self.at += 8;
            return Ok((found != u64::MAX).then_some(found));
        }
        let found = self.u32(field)?;
        Ok((found != u32::MAX).then_some(found.into()))
    }

    fn count(&mut self, field: &str) -> Result<usize> {
        let at = self.at;
        let found = self.raw_count(field)?;
        let most = if self.version == 5 { i64::MAX as u64 } else { i32::MAX as u64 };
        let count = found.filter(|&count| count <= most).and_then(|count| usize::try_from(count).ok());
        count.ok_or_else(|| self.input.wrong(field, at, found.unwrap_or(u64::MAX), "no negative number"))
    }

    /// Reads bytes and skips their padding.
    fn padded(&mut self, field: &str, length: usize) -> Result<&[u8]> {
        let bytes = self.input.take(field, self.at, length)?;
        // The padding may be absent at the end of a file.
        self.at = (self.at + length).next_multiple_of(ALIGNMENT);
        Ok(bytes)
    }

    fn name(&mut self, field: &str) -> Result<String> {
        let at = self.at;
        let length = self.count(field)?;
        if length > MAX_NAME_BYTES {
            let wanted = format!("at most {MAX_NAME_BYTES} bytes");
            return Err(self.input.wrong(field, at, format!("{length} bytes long"), &wanted));
        }
        Ok(text(self.padded(field, length)?))
    }

    /// Reads the number of entries of a list. An absent list has the tag 0.
    fn list(&mut self, field: &str, wanted: u32) -> Result<usize> {
        let at = self.at;
        let tag = self.u32(field)?;
        let count = self.count(field)?;
        if tag != wanted && (tag, count) != (0, 0) {
            return Err(self.input.wrong(field, at, format!("tag {tag}"), &format!("tag {wanted}")));
        }
        self.room = self
            .room
            .checked_sub(count)
            .ok_or_else(|| self.input.too_large(&format!("the number of {field}"), at + 4, count, self.room))?;
        Ok(count)
    }

    /// Reads a number type; `None` for characters.
    fn sample(&mut self, field: &str) -> Result<Option<Sample>> {
        let at = self.at;
        Ok(Some(match self.u32(field)? {
            1 => Sample::I8,
            2 => return Ok(None),
            3 => Sample::I16,
            4 => Sample::I32,
            5 => Sample::F32,
            6 => Sample::F64,
            7 => Sample::U8,
            8 => Sample::U16,
            9 => Sample::U32,
            10 => Sample::I64,
            11 => Sample::U64,
            other => return Err(self.input.wrong(field, at, other, "1 to 11")),
        }))
    }

    fn attributes(&mut self) -> Result<Vec<Attribute>> {
        let count = self.list("attributes", ATTRIBUTES)?;
        (0..count).map(|_| self.attribute()).collect()
    }

    fn attribute(&mut self) -> Result<Attribute> {
        let name = self.name("name of an attribute")?;
        let sample = self.sample("type of an attribute")?;
        let count = self.count("elements of an attribute")?;
        let bytes = self.padded(&name, count.saturating_mul(sample.map_or(1, Sample::size)))?;
        let value = match sample {
            None => Value::Text(text(bytes)),
            Some(sample) => {
                let mut numbers = Vec::new();
                sample.decode(ByteOrder::Big, &bytes[..bytes.len().min(MAX_NUMBERS * sample.size())], &mut numbers);
                Value::Numbers(numbers)
            }
        };
        Ok((name, value))
    }

    fn variable(&mut self, known: &[Dimension], record_dimension: Option<usize>) -> Result<Variable> {
        let name = self.name("name of a variable")?;
        let rank = self.count("dimensions of a variable")?;
        let (mut dimensions, mut shape) = (Vec::new(), Vec::new());
        for number in 0..rank {
            let at = self.at;
            let place = self.count("a dimension of a variable")?;
            let dimension = known.get(place).ok_or_else(|| {
                self.input.wrong(&format!("a dimension of {name}"), at, place, &format!("below {}", known.len()))
            })?;
            if number < MAX_RANK {
                dimensions.push(Some(place));
                shape.push(dimension.1);
            }
        }
        let attributes = self.attributes()?;
        let sample = self.sample("type of a variable")?;
        // The size follows from the dimensions. Its field is too small for large variables.
        self.raw_count("size of a variable")?;
        let at = self.at;
        let begin = if self.version == 1 { self.u32("begin")?.into() } else { self.input.u64("begin", at)? };
        self.at = at + if self.version == 1 { 4 } else { 8 };
        let begin = usize::try_from(begin).unwrap_or(usize::MAX);
        let has_records = record_dimension.is_some() && dimensions.first() == Some(&record_dimension);
        let is_unsigned = matches!(
            attributes.iter().find(|(name, _)| name == "_Unsigned").map(|(_, value)| value),
            Some(Value::Text(text)) if text == "true"
        );
        let sample = sample.filter(|_| rank <= MAX_RANK);
        // The classic formats have no unsigned types except characters.
        let unsigned = |sample: Sample| Sample::integer(8 * sample.size() as u64, false).filter(|_| !sample.is_float());
        let sample = if is_unsigned { sample.map(|sample| unsigned(sample).unwrap_or(sample)) } else { sample };
        let record_bytes = has_records.then_some(0);
        Ok(Variable { name, dimensions, shape, attributes, sample, at: begin, record_bytes })
    }
}

/// Decodes UTF-8, or else Latin-1, without zeros at the end.
fn text(bytes: &[u8]) -> String {
    let end = bytes.iter().rposition(|&byte| byte != 0).map_or(0, |last| last + 1);
    let bytes = &bytes[..end];
    std::str::from_utf8(bytes).map_or_else(|_| bytes.iter().map(|&byte| char::from(byte)).collect(), str::to_owned)
}
