//! Park Systems TIFF: a picture whose private fields hold a header and the heights.
//!
//! A stored number n is (n · scale + offset) · gain in the unit of the data, µm if none is stated. Lines are stored from the bottom up.
//!
//! Layout of the header: Park Systems, *TIFF Format of XEI*; Gwyddion and SurfaceTopography read the same fields.

use super::{Directory, Tag};
use crate::{ByteOrder, ChosenMap, FormatError, Input, ReadOptions, Result, Sample, Scan, refuse_if, utf16_text};

const MAGIC: Tag = Tag(50432, "magic number of Park Systems");
const VERSION: Tag = Tag(50433, "version");
const DATA: Tag = Tag(50434, "data");
const HEADER: Tag = Tag(50435, "header");
/// Version from which on the header states the type of the numbers; before it was `int16`.
const SECOND_VERSION: u64 = 0x0100_0002;
const MAP: u32 = 0;
/// Sizes of texts of 8 and of 32 letters in bytes.
const SHORT_TEXT: usize = 16;
const LONG_TEXT: usize = 64;

/// Returns whether a page is of Park Systems.
pub(super) fn is_park(page: &Directory) -> bool {
    page.length(MAGIC) > 0 && page.length(DATA) > 0 && page.length(HEADER) > 0
}

/// Reads the heights of a page.
///
/// # Errors
/// Profiles and spectra, another unit than one of length, another type of numbers, and fields beyond the end of the file.
pub(super) fn read(page: &Directory, options: &ReadOptions) -> Result<Scan> {
    let header = part(page, HEADER)?;
    let text = |field, at, length| {
        let text = utf16_text(header.take(field, at, length)?, ByteOrder::Little);
        Ok::<_, FormatError>(text.split('\0').next().unwrap_or_default().trim().to_owned())
    };
    let kind = header.u32("type of image", 0)?;
    refuse_if!(kind != MAP, header.unsupported(format!("the image is of type {kind}"), "a map (type 0)"));
    let name = text("name of the channel", 4, LONG_TEXT)?;
    let unit =
        Some(text("unit of the data", 244, SHORT_TEXT)?).filter(|unit| !unit.is_empty()).unwrap_or_else(|| "um".into());
    let chosen = ChosenMap::new(header.format, [(name, unit.clone())], options)?;
    let (columns, rows) = (header.u32("columns", 100)?, header.u32("rows", 104)?);
    let (ny, nx) = header.shape(("rows", 104, rows), ("columns", 100, columns))?;
    let sample = if page.integer(VERSION)?.unwrap_or(0) < SECOND_VERSION {
        Sample::I16
    } else {
        match header.u32("type of numbers", 348)? {
            0 => Sample::I16,
            1 => Sample::I32,
            2 => Sample::F32,
            other => return Err(header.wrong("type of numbers", 348, other, "0, 1 or 2")),
        }
    };
    let [gain, scale, offset] = [220, 228, 236].map(|at| header.f64("scale of the data", at));
    let (gain, scale, offset) = (gain?, scale?, offset?);
    let scale = if scale == 0.0 { 1.0 } else { scale };
    let data = part(page, DATA)?;
    let in_metre = |n| (n * scale + offset) * gain / chosen.per_metre;
    let heights_m = data.heights_upwards("data", 0, (ny, nx), sample, in_metre)?;
    // Sizes are in micrometre.
    let pitch = |at, points: usize| Ok::<_, FormatError>(header.f64("size", at)? / points as f64 / 1e6);
    let mut scan = Scan { height_unit: Some(unit), ..Scan::new(heights_m, Some((pitch(140, nx)?, pitch(148, ny)?))) };
    scan.metadata.insert("image mode".into(), text("image mode", 68, SHORT_TEXT)?);
    scan.metadata.insert("scan rate".into(), header.f64("scan rate", 172)?.to_string());
    Ok(chosen.add_to(scan))
}

/// Returns the bytes of a field, whose numbers are little-endian.
fn part<'a>(page: &Directory<'a>, tag: Tag) -> Result<Input<'a>> {
    let (start, length) = page.place(tag).ok_or_else(|| page.input.missing(tag.1, page.offset, "a field"))?;
    page.input.take(tag.1, start, length)?;
    Ok(page.input.up_to(start + length).from(start).with_order(ByteOrder::Little))
}
