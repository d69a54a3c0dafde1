//! Wyko (Veeco, Bruker) OPD: a directory of named blocks, then the blocks in the order of the directory.
//!
//! The file starts with two bytes and the directory. An entry consists of a name (16 bytes), a type (`int16`), a
//! length (`int32`) and attributes (`uint16`), little-endian; the first entry describes the directory itself. Blocks
//! of an array start with the number of columns, the number of rows and the size of an element in bytes (`uint16`),
//! followed by the columns, each from the bottom up, as in `ReadOPD.m`, the vendor's own routine, and in Gwyddion.
//!
//! A stored number v is the height v·`Wavelength`/`Mult` in nanometre; `Mult` exists for integers only. `Pixel_size`
//! is the distance between points along x in millimetre (newer files repeat it as `PixelSize` with its unit).
//! Multiplied by `Aspect` it is the distance along y.
//!
//! In the vendor's routine, missing heights are floats from 1e38 on and integers from 32766 on, which are signed. One
//! reader takes the integers as unsigned, another takes only 32767 as missing.

use std::collections::BTreeMap;

use ndarray::Array2;

use crate::input::Kind;
use crate::{
    ByteOrder, Description, Format, Input, ReadOptions, Result, Sample, Scan, Tested, large, latin1, opdx, unique,
};

pub(crate) const CODEC: Description = Description {
    extensions: &["opd"],
    vendor: "Wyko (Veeco, Bruker)",
    known_by: "`\\x01\\x00Directory`",
    reads: "float32, int16, uint8",
    missing_points: "1e38 and above, 32766 and above (int16), NaN",
    orientation: "columns from the bottom up; row 0 is the last number of every column",
    tested: Tested::InstrumentFiles,
    ..Description::new(Format::Opd, |bytes| bytes.starts_with(SIGNATURE), read)
};

/// First bytes of a file: two bytes and the start of the directory's own entry.
const SIGNATURE: &[u8] = b"\x01\x00Directory";
/// Offset of the directory.
const DIRECTORY_START: usize = 2;
const ENTRY_BYTES: usize = 24;
const NAME_BYTES: usize = 16;
/// Maximum number of entries of a directory. Files of the vendor have a thousand.
const MAX_ENTRIES: usize = 1 << 16;
/// Size in bytes of the header of an array.
const ARRAY_HEADER_BYTES: usize = 6;
/// Maximum size in bytes of a text or object.
const MAX_TEXT_BYTES: usize = 4096;

/// Names of the arrays that hold heights.
const HEIGHTS: [&str; 5] = ["RAW_DATA", "RAW DATA", "Raw", "OPD", "SAMPLE_DATA"];
/// Object that names the main array.
const PRIMARY: &str = "PrimaryData2D";

/// Name, type and declared length of a block whose length is wrong.
const MISSTATED: (&str, i16, usize) = ("ImageModificat~0", kind::FLOAT, 40);

/// Lowest float that marks a missing height. The mark is 1e38 or more (2¹²⁷ in new files); 1e38 as `float32` is
/// slightly less.
const BAD_FLOAT: f64 = 9.9e37;
/// Lowest integer that marks a missing height.
const BAD_INT16: f64 = 32766.0;

/// Types of blocks.
mod kind {
    pub(super) const ARRAY: i16 = 3;
    pub(super) const TEXT: i16 = 5;
    pub(super) const SHORT: i16 = 6;
    pub(super) const FLOAT: i16 = 7;
    pub(super) const DOUBLE: i16 = 8;
    pub(super) const LONG: i16 = 12;
    pub(super) const OBJECT: i16 = 15;
}

/// Block of the directory.
struct Block {
    name: String,
    kind: i16,
    /// Offset of its entry.
    entry: usize,
    start: usize,
    length: usize,
}

/// Reads a height map.
///
/// # Errors
/// A damaged directory, no array of heights, no wavelength, and arrays that exceed their blocks or the file.
fn read(bytes: &[u8], options: &ReadOptions) -> Result<Scan> {
    let input = Input::new(Format::Opd, bytes);
    let blocks = directory(&input)?;
    let maps: Vec<&Block> =
        blocks.iter().filter(|block| block.kind == kind::ARRAY && HEIGHTS.contains(&block.name.as_str())).collect();
    if maps.is_empty() {
        let arrays: Vec<&str> =
            blocks.iter().filter(|block| block.kind == kind::ARRAY).map(|block| block.name.as_str()).take(8).collect();
        let found = if arrays.is_empty() { "no array".into() } else { format!("the arrays {}", arrays.join(", ")) };
        return Err(input.unsupported(format!("the file holds {found}"), "heights (RAW_DATA, Raw, OPD or SAMPLE_DATA)"));
    }
    let names = unique(maps.iter().map(|block| block.name.clone()).collect());
    let primary = find(&blocks, PRIMARY).and_then(|block| value(&input, block));
    let main = names.iter().position(|name| Some(name) == primary.as_ref());
    let channel = options.choose_or(Format::Opd, &names, main)?;

    let mut warnings = Vec::new();
    let heights_m = heights(&input, maps[channel], scale_m(&input, &blocks)?)?;
    let pitch_m = pitch(&input, &blocks, &mut warnings)?;
    let lost: Vec<&Block> =
        blocks.iter().filter(|block| block.start.saturating_add(block.length) > bytes.len()).collect();
    if let Some(first) = lost.first() {
        warnings.push(format!("the file ends before {} of its blocks, the first of them `{}`", lost.len(), first.name));
    }
    let metadata = metadata(&input, &blocks);
    Ok(Scan { metadata, warnings, ..Scan::new(heights_m, pitch_m) }.with_channels(names, channel))
}

/// Returns the blocks that are not empty, in the order of the file.
fn directory(input: &Input) -> Result<Vec<Block>> {
    let length_at = DIRECTORY_START + NAME_BYTES + 2;
    let stated = input.i32("the length of the directory", length_at)?;
    let length = usize::try_from(stated).unwrap_or(0);
    if length < ENTRY_BYTES || length % ENTRY_BYTES != 0 || length > MAX_ENTRIES * ENTRY_BYTES {
        let wanted = format!("a multiple of {ENTRY_BYTES}, up to {MAX_ENTRIES} times");
        return Err(input.wrong("the length of the directory", length_at, stated, &wanted));
    }
    input.take("the entries of the directory", DIRECTORY_START, length)?;
    let mut blocks = Vec::new();
    let mut start = DIRECTORY_START + length;
    for entry in (DIRECTORY_START..start).step_by(ENTRY_BYTES).skip(1) {
        // A length that is not positive means that there is no block.
        let length = usize::try_from(input.i32("the length of a block", entry + NAME_BYTES + 2)?).unwrap_or(0);
        let name = input.latin1("the name of a block", entry, NAME_BYTES)?;
        let kind = input.i16("the type of a block", entry + NAME_BYTES)?;
        // A program of the vendor states 40 bytes for a number of 4, as Gwyddion's authors found out.
        let length = if (name.as_str(), kind, length) == MISSTATED { 4 } else { length };
        if length > 0 {
            blocks.push(Block { name, kind, entry, start, length });
        }
        // At most 2¹⁶ times 2³¹.
        start = start.saturating_add(length);
    }
    Ok(blocks)
}

fn find<'a>(blocks: &'a [Block], name: &str) -> Option<&'a Block> {
    blocks.iter().find(|block| block.name == name)
}

/// Returns the number in a block; `None` if there is no such block.
fn number(input: &Input, blocks: &[Block], name: &str) -> Result<Option<f64>> {
    let Some(block) = find(blocks, name) else { return Ok(None) };
    let sample = match block.kind {
        kind::SHORT => Sample::I16,
        kind::FLOAT => Sample::F32,
        kind::LONG => Sample::I32,
        kind::DOUBLE => Sample::F64,
        other => {
            let field = format!("the type of {name}");
            return Err(input.wrong(&field, block.entry + NAME_BYTES, other, "6, 7, 8 or 12 for a number"));
        }
    };
    if block.length < sample.size() {
        let field = format!("the length of {name}");
        return Err(input.wrong(&field, block.entry + NAME_BYTES + 2, block.length, &sample.size().to_string()));
    }
    Ok(input.samples(name, block.start, 1, sample)?.pop())
}

/// Returns the height of a stored 1 in metre.
fn scale_m(input: &Input, blocks: &[Block]) -> Result<f64> {
    let positive = |name: &str, found: Option<f64>| match found {
        Some(found) if found > 0.0 && found.is_finite() => Ok(found),
        Some(found) => {
            let at = find(blocks, name).map_or(0, |block| block.start);
            Err(input.wrong(name, at, found, "a positive number"))
        }
        None => Err(input.missing(name, DIRECTORY_START, "a block with the wavelength in nanometre")),
    };
    let wavelength_nm = positive("Wavelength", number(input, blocks, "Wavelength")?)?;
    let mult = positive("Mult", Some(number(input, blocks, "Mult")?.unwrap_or(1.0)))?;
    Ok(wavelength_nm / mult / 1e9)
}

fn pitch(input: &Input, blocks: &[Block], warnings: &mut Vec<String>) -> Result<Option<(f64, f64)>> {
    let Some(pixel_size_mm) = number(input, blocks, "Pixel_size")? else {
        warnings.push("the file has no block `Pixel_size`; no pixel size was read".into());
        return Ok(None);
    };
    let dx_m = pixel_size_mm / 1e3;
    Ok(Some((dx_m, dx_m * number(input, blocks, "Aspect")?.unwrap_or(1.0))))
}

/// Reads the heights of an array in metre, row 0 at the top.
fn heights(input: &Input, block: &Block, scale_m: f64) -> Result<Array2<f64>> {
    let name = block.name.as_str();
    let (columns, rows) = (input.u16(name, block.start)?, input.u16(name, block.start + 2)?);
    let (field_x, field_y) = (format!("columns of {name}"), format!("rows of {name}"));
    let (ny, nx) = input.shape((&field_y, block.start + 2, rows), (&field_x, block.start, columns))?;
    let (sample, is_height): (Sample, fn(f64) -> bool) = match input.u16(name, block.start + 4)? {
        4 => (Sample::F32, |v| v.abs() < BAD_FLOAT),
        2 => (Sample::I16, |v| v < BAD_INT16),
        1 => (Sample::U8, |_| true),
        found => {
            let field = format!("bytes of an element of {name}");
            return Err(input.wrong(&field, block.start + 4, found, "1, 2 or 4"));
        }
    };
    let data_bytes = nx * ny * sample.size();
    if block.length < ARRAY_HEADER_BYTES + data_bytes {
        let wanted = format!("{} or more for {nx} × {ny} numbers", ARRAY_HEADER_BYTES + data_bytes);
        return Err(input.wrong(&format!("the length of {name}"), block.entry + NAME_BYTES + 2, block.length, &wanted));
    }
    let bytes = input.take(name, block.start + ARRAY_HEADER_BYTES, data_bytes)?;
    let mut heights = sample.decode_columns(ByteOrder::Little, bytes, (ny, nx));
    large::map(&mut heights, |v| if is_height(v) { v * scale_m } else { f64::NAN });
    large::flip(&mut heights, nx);
    input.matrix(name, block.start, (ny, nx), heights)
}

/// Returns texts, numbers and simple objects as metadata.
fn metadata(input: &Input, blocks: &[Block]) -> BTreeMap<String, String> {
    let named = blocks.iter().filter(|block| !block.name.is_empty());
    named.filter_map(|block| Some((block.name.clone(), value(input, block)?))).collect()
}

/// Returns the content of a block as text; `None` for arrays, unknown types and absent blocks.
fn value(input: &Input, block: &Block) -> Option<String> {
    let bytes = input.take(&block.name, block.start, block.length.min(MAX_TEXT_BYTES)).ok()?;
    let whole = Input::new(Format::Opd, bytes);
    match block.kind {
        kind::TEXT => Some(latin1(bytes)),
        kind::SHORT => whole.value("", 0, Kind::I16).ok(),
        kind::FLOAT => whole.value("", 0, Kind::F32).ok(),
        kind::DOUBLE => whole.value("", 0, Kind::F64).ok(),
        kind::LONG => whole.value("", 0, Kind::I32).ok(),
        kind::OBJECT => opdx::object(bytes),
        _ => None,
    }
}
