//! Digital Surf Mountains MNT: a document in the stream `ScopedContents` of an OLE compound file.
//!
//! After its size (`u64`) the stream is a tree of entries: a tag (`u16`), a size (`u64`), and a value or more entries. Texts are UTF-16
//! after the byte 4. The document lists objects by their class numbers. Measured surfaces (9012) hold two axes with the distance of points,
//! a line from integers to heights, the heights in blocks of zlib, and in some a picture with a border of one point that marks measured
//! points by 9. The distance of points is read as stated; see `bcr` for files that Mountains converted. Layers that Mountains derives from a
//! surface are not stored; it computes them when it opens the document.
//!
//! The vendor published no description. SurfaceTopography describes the entries from files of several instruments.

use std::io::{Cursor, Read};

use cfb::CompoundFile;

use crate::archive::{beyond_reason, damaged, may_unpack, unpack};
use crate::foreign::{OLE_MAGIC, is_mountains};
use crate::{
    ByteOrder, ChosenMap, Description, Format, Input, ReadOptions, Result, Sample, Scan, large, per_metre, refuse_if,
    utf16_text,
};

pub(crate) const CODEC: Description = Description {
    extensions: &["mnt"],
    vendor: "Digital Surf",
    known_by: "an OLE file with `ScopedContents`",
    reads: "int16 and int32 of measured surfaces, with the distance of points; no derived layers, which files do not hold",
    missing_points: "a picture of marks",
    orientation: "the first stored line is row 0, as in SUR",
    ..Description::new(Format::Mnt, |bytes| bytes.starts_with(OLE_MAGIC) && is_mountains(bytes), read)
};

const STREAM: &str = "ScopedContents";
/// Size in bytes of the tag and the size before a value, and of a size.
const HEAD_BYTES: usize = 10;
const SIZE_BYTES: usize = 8;
/// Tag of the entries of a base class.
const BASE: u16 = 0xffff;
/// Class numbers.
const SURFACE: u32 = 9012;
const MEASUREMENT: u32 = 9062;
const MASK: u32 = 9056;
/// Mark of a measured point.
const MEASURED: u8 = 9;

/// Reads the heights of a measured surface.
///
/// # Errors
/// Damaged OLE files, entries beyond the end of the stream, documents without a measured surface, and blocks that do not fill it.
fn read(bytes: &[u8], options: &ReadOptions) -> Result<Scan> {
    let stream =
        stream(bytes).map_err(|_| damaged(Format::Mnt, STREAM, "the OLE compound file around it is damaged".into()))?;
    let input = Input::entry(Format::Mnt, STREAM, &stream);
    let list = required(input.from(SIZE_BYTES), &[1, 0x2bd, 2, 1], "a list of objects")?;
    let mut surfaces = Vec::new();
    // Here a size precedes the entries.
    for entry in entries(list, SIZE_BYTES) {
        let (tag, object) = entry?;
        let surface = if tag == 1 && class(object)? == Some(SURFACE) { find(object, &[2])? } else { None };
        surfaces.extend(surface.map(Surface::open).transpose()?.flatten());
    }
    let names = surfaces.iter().map(|surface| (surface.name.clone(), surface.z.unit.clone()));
    let chosen = ChosenMap::new(Format::Mnt, names, options)?;
    let surface = surfaces.swap_remove(chosen.map);
    Ok(chosen.add_to(surface.scan()?))
}

/// Returns the stream of the document.
fn stream(bytes: &[u8]) -> std::io::Result<Vec<u8>> {
    let mut stream = Vec::new();
    // A damaged list of sectors may lead to more bytes than the file has.
    CompoundFile::open(Cursor::new(bytes))?.open_stream(STREAM)?.take(bytes.len() as u64).read_to_end(&mut stream)?;
    Ok(stream)
}

/// Returns the tags and values of all entries, each after `before` bytes.
fn entries(list: Input<'_>, before: usize) -> impl Iterator<Item = Result<(u16, Input<'_>)>> {
    let mut at = before;
    std::iter::from_fn(move || {
        let start = at + HEAD_BYTES;
        (start <= list.len()).then(|| {
            let (tag, size) = (list.u16("a tag", at)?, list.u64("the size of an entry", at + 2)?);
            let size = usize::try_from(size).unwrap_or(usize::MAX);
            // The next entry is beyond the end if this one is.
            at = start.saturating_add(size).saturating_add(before).min(list.len());
            list.take("an entry", start, size)?;
            Ok((tag, list.up_to(start + size).from(start)))
        })
    })
}

/// Returns the value at the end of a path of tags.
fn find<'a>(mut value: Input<'a>, path: &[u16]) -> Result<Option<Input<'a>>> {
    for tag in path {
        let is_wanted = |entry: &Result<(u16, _)>| entry.as_ref().map_or(true, |(found, _)| found == tag);
        match entries(value, 0).find(is_wanted).transpose()? {
            Some((_, inner)) => value = inner,
            None => return Ok(None),
        }
    }
    Ok(Some(value))
}

/// Returns the value at the end of a path of tags.
///
/// # Errors
/// [`FormatError::MissingField`].
fn required<'a>(value: Input<'a>, path: &[u16], wanted: &str) -> Result<Input<'a>> {
    find(value, path)?.ok_or_else(|| value.missing(&format!("entry {path:x?}"), 0, wanted))
}

/// Returns the class number of an object.
fn class(object: Input<'_>) -> Result<Option<u32>> {
    find(object, &[1, 1])?.map(|number| number.u32("class number", 0)).transpose()
}

/// Returns a text, empty if there is none.
fn text(value: Input<'_>, path: &[u16]) -> Result<String> {
    let text = find(value, path)?.and_then(|text| text.bytes.strip_prefix(&[4]));
    Ok(text.map(|text| utf16_text(text, ByteOrder::Little).trim_end_matches('\0').to_owned()).unwrap_or_default())
}

/// Distance of points or of heights whose stored integers differ by one, its unit, and the height of a stored 0 in a unit of its own.
struct Scale {
    step: f64,
    unit: String,
    origin: f64,
    origin_unit: String,
}

impl Scale {
    fn open(axis: Input<'_>) -> Result<Self> {
        let scale = required(axis, &[BASE], "a scale")?;
        let step = required(scale, &[1], "a step")?.f64("step", 0)?;
        let origin = find(scale, &[5])?.map_or(Ok(0.0), |origin| origin.f64("origin", 0))?;
        Ok(Self { step, unit: text(scale, &[2])?, origin, origin_unit: text(scale, &[3])? })
    }

    /// Returns the distance in metre if its unit is one of length.
    fn step_m(&self) -> Option<f64> {
        per_metre(&self.unit).map(|per_metre| self.step / per_metre)
    }
}

/// Measured surface.
struct Surface<'a> {
    name: String,
    z: Scale,
    grid: Input<'a>,
    heights: Input<'a>,
}

impl<'a> Surface<'a> {
    /// Finds the parts of an object; `None` for one of another kind.
    fn open(surface: Input<'a>) -> Result<Option<Self>> {
        let Some(object) = find(surface, &[1])? else { return Ok(None) };
        if class(object)? != Some(MEASUREMENT) {
            return Ok(None);
        }
        let measurement = required(object, &[2, BASE], "a measurement")?;
        let grid = required(measurement, &[BASE], "a grid")?;
        let heights = required(measurement, &[1, 2], "heights")?;
        let z = Scale::open(required(measurement, &[2], "an axis of heights")?)?;
        let mut name = text(grid, &[BASE, BASE, 1])?;
        if name.is_empty() {
            name = text(surface, &[BASE, 4])?;
        }
        Ok(Some(Self { name, z, grid, heights }))
    }

    /// Reads the heights.
    fn scan(self) -> Result<Scan> {
        let axis = |tag| required(self.grid, &[tag, BASE], "an axis");
        let (x, y) = (axis(1)?, axis(2)?);
        let count = |axis| required(axis, &[1], "a number of points")?.u32("points", 0);
        let (nx, ny) = (count(x)?, count(y)?);
        let shape = self.grid.shape(("points along y", 0, ny), ("points along x", 0, nx))?;
        let origin_unit = if self.z.origin_unit.is_empty() { &self.z.unit } else { &self.z.origin_unit };
        let origin_m = self.z.origin / per_metre(origin_unit).unwrap_or(f64::NAN);
        let step_m = self.z.step_m().unwrap_or(f64::NAN);
        if !(origin_m.is_finite() && step_m.is_finite()) {
            let found = format!("a height of {} {} + n · {} {}", self.z.origin, origin_unit, self.z.step, self.z.unit);
            return Err(self.heights.unsupported(found, "finite lengths"));
        }
        let points = shape.0 * shape.1;
        let (bytes, size) = array(self.heights, points)?;
        let sample = if size == 2 { Sample::I16 } else { Sample::I32 };
        refuse_if!(size != sample.size(), self.heights.unsupported(format!("heights of {size} bytes"), "2 or 4"));
        let mut heights = sample.decode_and_map(ByteOrder::Little, &bytes, |z| z * step_m + origin_m);
        drop(bytes);
        if let Some(mask) = find(self.grid, &[3])?
            && class(mask)? == Some(MASK)
        {
            let stride = shape.1 + 2;
            let (marks, size) = array(required(mask, &[2, 5, 2], "an array of marks")?, stride * (shape.0 + 2))?;
            refuse_if!(size != 1, mask.unsupported(format!("marks of {size} bytes"), "1"));
            for (row, marks) in heights.chunks_mut(shape.1).zip(marks[stride..].chunks(stride)) {
                large::hide(row, marks[1..].iter().map(|&mark| mark != MEASURED));
            }
        }
        let heights_m = self.grid.matrix("points along x", 0, shape, heights)?;
        let pitch_m = Scale::open(x)?.step_m().zip(Scale::open(y)?.step_m());
        Ok(Scan { height_unit: Some(self.z.unit), ..Scan::new(heights_m, pitch_m) })
    }
}

/// Returns the bytes of an array of `points` numbers, and the size of a number.
///
/// Its blocks, in any order, state the index of their first number, how many they hold, and their packed size.
fn array(array: Input<'_>, points: usize) -> Result<(Vec<u8>, usize)> {
    let count = required(array, &[1], "a number of points")?.u32("points", 0)?;
    refuse_if!(count as usize != points, array.wrong("the number of points", 0, count, &points.to_string()));
    let data = required(array, &[2], "numbers")?;
    let total = data.u64("the size of an array", 0)?;
    let size = total / points as u64;
    if size * points as u64 != total || !(1..=4).contains(&size) {
        return Err(data.wrong("the size of an array", 0, total, &format!("a multiple of {points} numbers")));
    }
    let (mut blocks, mut at) = (Vec::new(), SIZE_BYTES);
    while at < data.len() {
        let (first, count) = (data.u64("a block", at)?, data.u32("a block", at + 8)?);
        let packed = data.u32("a block", at + 12)? as usize;
        blocks.push((first, u64::from(count) * size, data.take("a block", at + 16, packed)?));
        at += 16 + packed;
    }
    blocks.sort_unstable_by_key(|(first, ..)| *first);
    let mut bytes = Vec::new();
    for (first, length, packed) in blocks {
        if first.checked_mul(size) != Some(bytes.len() as u64) || bytes.len() as u64 + length > total {
            return Err(data.wrong("the first number of a block", 0, first, "the end of another block"));
        }
        if !may_unpack(packed.len() as u64, length / size, length) {
            return Err(beyond_reason(Format::Mnt, "a block", packed.len() as u64, length));
        }
        unpack(packed, length, &mut bytes).map_err(|reason| damaged(Format::Mnt, "a block", reason))?;
    }
    refuse_if!(bytes.len() as u64 != total, data.truncated("the blocks", 0, total as usize));
    Ok((bytes, size as usize))
}
