//! FRT MicroProf: a magic word, then blocks of a tag, a size and data.
//!
//! Numbers are little-endian. Sizes of blocks are u32 in version 1.00 and u64 in 1.01. These blocks define the heights:
//!
//! | tag | block |
//! |---|---|
//! | 0x000b | the current image alone: 16 bits are unsigned, 32 bits signed |
//! | 0x0066 | its points along x and y, bits per point |
//! | 0x0067 | x range, y range in metre |
//! | 0x006c | code of the measuring range, metre per step of z |
//! | 0x0070 | lowest and highest valid number |
//! | 0x007d | all images, each with type, points along x and y, bits per point |
//!
//! If block 0x007d holds images, block 0x000b repeats one of them, of any type, and is ignored.
//!
//! The number 1 marks a missing point. Files do not state this mark, but the published readers that support missing
//! points agree on it. Numbers outside of the valid range are missing as well.
//!
//! A range is the number of points times their distance: only then have published files of 500 points on 12 mm, 150 on
//! 30 mm and 300 on 60 mm round distances.

mod blocks;
mod image;
mod metadata;

use self::blocks::{
    BLOCK_COUNT, BUFFERS, Blocks, CURRENT_IMAGE, IMAGE_SIZE, IMAGES, ROUNDNESS, SCAN_SIZE, SENSOR, SIGNATURE,
    VALID_VALUES, VERSION_BYTES, Z_UNIT, blocks,
};
use self::image::{Image, TOPOGRAPHY, images};
use crate::unit::in_words;
use crate::{Description, Format, Input, ReadOptions, Result, Sample, Scan, Shape, large, unique, warn_if};

pub(crate) const CODEC: Description = Description {
    extensions: &["frt"],
    vendor: "FRT MicroProf",
    known_by: "`FRTM_GLIDERV`",
    reads: "versions 1.00 and 1.01; topography, thickness and AFM images of 16 and 32 bits",
    missing_points: "1, numbers outside of the valid range that the file states",
    orientation: "the last stored line is row 0",
    ..Description::new(Format::Frt, |bytes| bytes.starts_with(SIGNATURE), read)
};

/// Number that marks a missing point.
const VOID: f64 = 1.0;

/// Reads an image of heights.
///
/// # Errors
/// Other versions, profiles, files without images of heights, and blocks beyond the end of the file.
fn read(bytes: &[u8], options: &ReadOptions) -> Result<Scan> {
    let input = Input::new(Format::Frt, bytes);
    let size_bytes = match input.take("the version", SIGNATURE.len(), VERSION_BYTES)? {
        b"1.00" => 4,
        b"1.01" => 8,
        other => return Err(input.unsupported(format!("version {}", other.escape_ascii()), "version 1.00 or 1.01")),
    };
    let mut warnings = Vec::new();
    let blocks = blocks(input, size_bytes, &mut warnings)?;
    let several = match blocks.get(&IMAGES) {
        Some(&block) => images(block, &mut warnings)?,
        None => Vec::new(),
    };
    let (names, channel, image) = match several.as_slice() {
        [] => (Vec::new(), 0, single_image(input, &blocks, &mut warnings)?),
        several => choose(input, several, options)?,
    };
    let (ny, nx) = image.shape;
    if ny == 1 || nx == 1 {
        return Err(input.unsupported(format!("the file holds a profile of {} points", nx * ny), "a surface"));
    }
    let mut heights = image.numbers.samples("the numbers of an image", 0, nx * ny, image.sample)?;
    scale(input, &blocks, image.sample, &mut heights, &mut warnings)?;
    // The first stored line is at the bottom of the image.
    large::flip(&mut heights, nx);
    let pitch_m = pitch(&blocks, image.shape, &mut warnings)?;
    warn_about_axes(&blocks, &mut warnings);
    let heights_m = image.numbers.matrix("the numbers of an image", 0, (ny, nx), heights)?;
    let scan = Scan { metadata: metadata::metadata(&blocks), warnings, ..Scan::new(heights_m, pitch_m) };
    Ok(scan.with_channels(names, channel))
}

/// Reads the image of block 0x000b.
fn single_image<'a>(input: Input<'a>, blocks: &Blocks<'a>, warnings: &mut Vec<String>) -> Result<Image<'a>> {
    let missing = |what: &str| input.missing(what, BLOCK_COUNT + 2, "an image");
    let numbers = *blocks.get(&CURRENT_IMAGE).ok_or_else(|| missing("block 0x000b or an image in block 0x007d"))?;
    let size = *blocks.get(&IMAGE_SIZE).ok_or_else(|| missing("block 0x0066 (image size)"))?;
    let image = Image::new(TOPOGRAPHY, size, numbers)?;
    if image.bytes() < numbers.len() {
        let more = numbers.len() - image.bytes();
        warnings.push(format!("block 0x000b is {more} bytes longer than its image; they were left out"));
    }
    Ok(image)
}

/// Returns the names of all images of heights, the index of the selected one, and this image.
fn choose<'a>(
    input: Input<'a>,
    images: &[Image<'a>],
    options: &ReadOptions,
) -> Result<(Vec<String>, usize, Image<'a>)> {
    let (names, maps): (Vec<String>, Vec<Image>) =
        images.iter().filter_map(|image| Some((image.name()?, *image))).unzip();
    if names.is_empty() {
        return Err(input.unsupported("the file holds no topography, only other images", "an image of heights"));
    }
    let names = unique(names);
    let channel = options.choose_or(Format::Frt, &names, maps.iter().position(Image::is_topography))?;
    Ok((names, channel, maps[channel]))
}

/// Converts stored numbers to metre; NaN for missing points.
fn scale(input: Input, blocks: &Blocks, sample: Sample, heights: &mut [f64], warnings: &mut Vec<String>) -> Result<()> {
    let sensor = blocks
        .get(&SENSOR)
        .ok_or_else(|| input.missing("block 0x006c (sensor)", BLOCK_COUNT + 2, "the scale of heights"))?;
    let scale_m = sensor.factor("z scale", 4, sensor.f64("z scale", 4)?)?;
    let valid = blocks.get(&VALID_VALUES).and_then(|block| {
        let limit = |offset| block.u32("valid value", offset).ok();
        let (first, last) = (limit(0)?, limit(4)?);
        // The limits have the width and sign of the numbers.
        let range = match sample {
            Sample::I32 => (f64::from(first as i32), f64::from(last as i32)),
            _ => (f64::from(first), f64::from(last)),
        };
        (range.0 < range.1).then_some(range)
    });
    let (first, last) = valid.unwrap_or((f64::NEG_INFINITY, f64::INFINITY));
    let outside = large::count(heights, |z| {
        let is_void = *z == VOID;
        let is_outside = !is_void && (*z < first || *z > last);
        *z = if is_void || is_outside { f64::NAN } else { *z * scale_m };
        is_outside
    });
    if outside > 0 {
        warnings.push(format!(
            "{outside} numbers are outside of the valid range that the file states, {first} to {last}; they count as missing"
        ));
    }
    if let Some(buffers) = blocks.get(&BUFFERS)
        && let Some(own) = own_scale(buffers, scale_m)
    {
        let scale = in_words(scale_m);
        warnings.push(format!("block 0x00ab states {own} for a buffer; heights were scaled by {scale} as for all"));
    }
    Ok(())
}

/// Describes a scale or offset in block 0x00ab that differs from the common ones.
///
/// The meaning of the aliases of buffers is unknown, so none can be applied.
fn own_scale(buffers: &Input, scale_m: f64) -> Option<String> {
    let count = buffers.u32("number of buffers", 0).ok()?;
    for buffer in 0..usize::try_from(count).ok()? {
        // Alias, scale, offset, absolute.
        let offset = 4 + buffer.checked_mul(24)?;
        let (scale, shift) = (buffers.f64("scale", offset + 4).ok()?, buffers.f64("offset", offset + 12).ok()?);
        if ![0.0, 1.0, scale_m].contains(&scale) || shift != 0.0 {
            return Some(format!("the scale {} and the offset {}", in_words(scale), in_words(shift)));
        }
    }
    None
}

/// Returns the distance between points in metre.
fn pitch(blocks: &Blocks, (ny, nx): Shape, warnings: &mut Vec<String>) -> Result<Option<(f64, f64)>> {
    let Some(size) = blocks.get(&SCAN_SIZE) else {
        warnings.push("block 0x0067 (scan size) is missing; no pixel size was read".into());
        return Ok(None);
    };
    let (x_m, y_m) = (size.f64("x range", 0)?, size.f64("y range", 8)?);
    for (axis, range_m) in [("x", x_m), ("y", y_m)] {
        let range = in_words(range_m);
        warn_if!(warnings, range_m < 0.0, "the {axis} range is {range}; its magnitude was used");
    }
    Ok(Some((x_m.abs() / nx as f64, y_m.abs() / ny as f64)))
}

/// Warns if the axes may not be lengths.
fn warn_about_axes(blocks: &Blocks, warnings: &mut Vec<String>) {
    if blocks.get(&ROUNDNESS).is_some_and(|block| block.u32("roundness", 0).is_ok_and(|flag| flag != 0)) {
        warnings.push("the file states a measurement of roundness; its axes count as lengths".into());
    }
    if let Some(unit) = blocks.get(&Z_UNIT).and_then(metadata::z_unit)
        && crate::unit::per_metre(&unit).is_none()
    {
        warnings.push(format!(
            "the z unit is `{}`, which is not a length; heights count as metre",
            crate::error::shown(&unit)
        ));
    }
}
