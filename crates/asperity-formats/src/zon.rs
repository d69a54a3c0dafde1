//! Keyence ZON of the macroscopes VR: a picture, then a zip archive of XML descriptions and arrays, each named by a number.
//!
//! An array starts with the numbers of columns and rows, the bytes of a number and the bytes of a row, which may be longer than its numbers.
//! Heights are `int32` in units that the description states in metre, as it does for the size of a pixel. A second array marks points
//! without height by its two lowest bits. Files that start with `KPK1` pack each file of the archive with Zstandard.
//!
//! The vendor published no description. SurfaceTopography and Gwyddion agree on the layout.

use crate::archive::unpack_zstandard;
use crate::scan::MAX_POINTS;
use crate::{
    Archive, Description, Document, Format, FormatError, Input, ReadOptions, Result, Sample, Scan, Shape, large,
    refuse_if,
};

pub(crate) const CODEC: Description = Description {
    extensions: &["zon"],
    vendor: "Keyence",
    known_by: "`KPK0`, `KPK1`",
    reads: "int32; also packed with Zstandard",
    missing_points: "the two lowest bits of the second array",
    orientation: "the first stored line is row 0",
    ..Description::new(Format::Zon, |bytes| bytes.starts_with(b"KPK0") || bytes.starts_with(PACKED), read)
};

const PACKED: &[u8] = b"KPK1";
const SCALES: &str = "686613b8-27b5-4a29-8ffc-438c2780873e";
const HEIGHTS: &str = "4cdb0c75-5706-48cc-a9a1-adf395d609ae";
const MARKS: &str = "9e7ca6dd-0e6a-4d7b-8986-f0a7b773c916";
/// Size in bytes of the header of an array.
const HEADER_BYTES: usize = 16;
/// Largest sizes of the description and of an array in bytes.
const MAX_XML_BYTES: u64 = 1 << 20;
const MAX_ARRAY_BYTES: u64 = HEADER_BYTES as u64 + 2 * 8 * MAX_POINTS;
const INVALID: u8 = 3;

/// Reads the heights.
///
/// # Errors
/// Damaged archives, descriptions without scales, and arrays that do not fill their dimensions.
fn read(bytes: &[u8], _options: &ReadOptions) -> Result<Scan> {
    let input = Input::new(Format::Zon, bytes);
    // The directory at the end leads to the archive, whether its offsets count the picture or not.
    let (mut archive, is_packed) = (Archive::open(Format::Zon, bytes)?, bytes.starts_with(PACKED));
    let has_marks = archive.contains(MARKS);
    let mut file = |name: &'static str, limit: u64| {
        let bytes = archive.read_whole(name, limit)?;
        if is_packed { unpack_zstandard(Format::Zon, name, &bytes, limit) } else { Ok(bytes) }
    };
    let document = Document::parse(Format::Zon, SCALES, &file(SCALES, MAX_XML_BYTES)?, "")?;
    let scale = |path: &str| document.number(path)?.ok_or_else(|| document.missing(path, "a number of metre"));
    let (pixel_m, unit_m) = (scale("XYCalibration/MeterPerPixel")?, scale("ZCalibration/MeterPerUnit")?);
    let (shape, mut heights) = array(HEIGHTS, &file(HEIGHTS, MAX_ARRAY_BYTES)?, Sample::I32)?;
    large::map(&mut heights, |z| z * unit_m);
    if has_marks {
        let (of_marks, marks) = array(MARKS, &file(MARKS, MAX_ARRAY_BYTES)?, Sample::U8)?;
        if of_marks != shape {
            let found = format!("the marks of {} × {} points", of_marks.1, of_marks.0);
            return Err(FormatError::unsupported(Format::Zon, found, "as many as heights"));
        }
        large::hide(&mut heights, marks.into_iter().map(|mark| mark as u8 & INVALID != 0));
    }
    let heights_m = input.matrix("columns", 0, shape, heights)?;
    Ok(Scan::new(heights_m, Some((pixel_m, pixel_m))))
}

/// Reads an array.
fn array(name: &str, bytes: &[u8], sample: Sample) -> Result<(Shape, Vec<f64>)> {
    let input = Input::entry(Format::Zon, name, bytes);
    let field = |name, at| Ok::<_, FormatError>((name, at, input.i32(name, at)?));
    let shape = input.shape(field("rows", 4)?, field("columns", 0)?)?;
    let (.., size) = field("bytes of a number", 8)?;
    refuse_if!(size as usize != sample.size(), input.wrong("bytes of a number", 8, size, &sample.size().to_string()));
    let (.., stride) = field("bytes of a row", 12)?;
    let row = shape.1 * sample.size();
    let stride = usize::try_from(stride).unwrap_or(0);
    refuse_if!(stride < row, input.wrong("bytes of a row", 12, stride, &format!("{row} or more")));
    Ok((shape, input.padded("the array", HEADER_BYTES, shape, stride, sample)?))
}
