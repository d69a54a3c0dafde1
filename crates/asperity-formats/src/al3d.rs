//! Alicona (Bruker) AL3D: a line of text, tags of 52 bytes, a comment of 256 bytes, and images at the offsets in the
//! tags.
//!
//! A tag consists of a key of 20 bytes, a value of 30 bytes, both with a zero at the end, and a line end. The first
//! two tags are `Version` and `TagCount`, the number of the tags after them. The depth image is `f32` in metre,
//! little-endian. Its rows, and the rows of the planes of the texture, are padded to a multiple of 8 bytes. Readers
//! that ignore the padding shear maps of an odd number of columns.
//!
//! `InvalidPixelValue` and all depths above it are missing. Its text is rounded (`3.000000028082e+15` for the `f32`
//! next to 3e15), so a comparison for equality finds no missing point.
//!
//! One plane of the texture may hold the repeatability of every depth: n · `DepthResShiftVal` + `DepthResMinVal`. The
//! vendor's program hides depths with a repeatability above `DepthResFilterVal`; here they are missing, with a
//! warning.

use std::collections::BTreeMap;

use crate::sections::Section;
use crate::unit::in_words;
use crate::{Description, Format, Input, ReadOptions, Result, Sample, Scan, Shape, Tested, large, refuse_if, warn_if};

pub(crate) const CODEC: Description = Description {
    extensions: &["al3d"],
    vendor: "Alicona (Bruker)",
    known_by: "`AliconaImaging\\0\\r\\n`",
    reads: "the depth image; no files of a texture alone",
    missing_points: "NaN, InvalidPixelValue and above, repeatability beyond DepthResFilterVal",
    orientation: "the first stored row is row 0, as in the texture beside it",
    tested: Tested::InstrumentFiles,
    ..Description::new(Format::Al3d, |bytes| bytes.starts_with(MAGIC), read)
};

/// First bytes of every file.
const MAGIC: &[u8] = b"AliconaImaging\0\r\n";
/// Sizes in bytes of a tag and of its parts.
const TAG_BYTES: usize = 52;
const KEY_BYTES: usize = 20;
const VALUE_BYTES: usize = 30;
/// End of a tag.
const LINE_END: &[u8] = b"\r\n";
/// Maximum number of tags. Instruments write about twenty.
const MAX_TAGS: i64 = 1000;
/// Size in bytes of the comment after the tags.
const COMMENT_BYTES: usize = 256;
/// Alignment of the rows of images in bytes.
const ROW_ALIGNMENT: usize = 8;
/// Lowest invalid depth if no tag states one.
const INVALID: f64 = 3e15;
/// Relative error of an `f32` with a rounded text, and of the `f32` itself.
const INVALID_TOLERANCE: f64 = 2e-7;

/// Tags of a file.
struct Header<'a> {
    input: Input<'a>,
    tags: Section<'static>,
    /// Offset of the end of the tags.
    end: usize,
}

impl<'a> Header<'a> {
    fn new(input: Input<'a>) -> Result<Self> {
        let tags = Section::new(Format::Al3d, input.at(MAGIC.len()), "a tag of this key");
        let mut header = Self { input, tags, end: MAGIC.len() };
        for key in ["Version", "TagCount"] {
            let at = header.end;
            let found = header.next_tag()?;
            refuse_if!(found != key, input.wrong("the key of a tag", at, found, key));
        }
        let count = header.tags.number::<i64>("TagCount")?;
        refuse_if!(!(0..=MAX_TAGS).contains(&count), header.tags.wrong("TagCount", &format!("0 to {MAX_TAGS}")));
        for _ in 0..count {
            header.next_tag()?;
        }
        Ok(header)
    }

    /// Reads a tag and returns its key.
    fn next_tag(&mut self) -> Result<String> {
        let (input, at) = (self.input, self.end);
        input.take("the bytes of a tag", at, TAG_BYTES)?;
        let key = input.latin1("the key of a tag", at, KEY_BYTES)?;
        let value = input.latin1("the value of a tag", at + KEY_BYTES, VALUE_BYTES)?;
        let line_end_at = at + KEY_BYTES + VALUE_BYTES;
        let line_end = input.take("the end of a tag", line_end_at, LINE_END.len())?;
        if line_end != LINE_END {
            let found = line_end.escape_ascii();
            return Err(input.wrong(&format!("the end of the tag {key}"), line_end_at, found, "\\r\\n"));
        }
        self.end += TAG_BYTES;
        // An empty tag counts as absent.
        if !value.is_empty() {
            self.tags.push(key.clone(), value, input.at(at));
        }
        Ok(key)
    }

    /// Returns a finite number; `None` if there is no such tag.
    fn number(&self, key: &str) -> Result<Option<f64>> {
        let Some(text) = self.tags.field(key) else { return Ok(None) };
        let number = text.parse().ok().filter(|number: &f64| number.is_finite());
        number.map(Some).ok_or_else(|| self.tags.wrong(key, "a finite number"))
    }

    /// Returns the offset of an image; `None` if there is none (no tag, or 0).
    fn offset(&self, key: &str) -> Result<Option<usize>> {
        let Some(offset) = self.tags.optional::<i64>(key)?.filter(|&offset| offset != 0) else { return Ok(None) };
        let behind_tags = usize::try_from(offset).ok().filter(|&offset| offset >= self.end);
        let wanted = || format!("0 or a byte after the tags, {} or more", self.end);
        behind_tags.map(Some).ok_or_else(|| self.tags.wrong(key, &wanted()))
    }

    /// Returns the numbers of an image.
    fn image(&self, part: &str, at: usize, shape: Shape, sample: Sample) -> Result<Vec<f64>> {
        self.input.padded(part, at, shape, stride(shape.1, sample), sample)
    }
}

/// Returns the number of bytes from one row of an image to the next.
fn stride(nx: usize, sample: Sample) -> usize {
    (nx * sample.size()).next_multiple_of(ROW_ALIGNMENT)
}

/// Reads the depth image.
///
/// # Errors
/// Damaged tags, files without a depth image, and images beyond the end of the file.
fn read(bytes: &[u8], _options: &ReadOptions) -> Result<Scan> {
    let input = Input::new(Format::Al3d, bytes);
    let header = Header::new(input)?;
    let mut warnings = Vec::new();
    let start = header.offset("DepthImageOffset")?.ok_or_else(|| {
        input.unsupported("the file holds no depth image (DepthImageOffset), only a texture", "a depth image")
    })?;
    let (ny, nx) = header.tags.shape("Rows", "Cols")?;

    let mut depths = header.image("the depths", start, (ny, nx), Sample::F32)?;
    let stride = stride(nx, Sample::F32);
    let texture = header.offset("TextureImageOffset")?;
    let others = [texture, header.offset("IconOffset")?];
    let room = others.into_iter().flatten().filter_map(|other| other.checked_sub(start)).min();
    if let Some(room) = room.filter(|&room| room != ny * stride) {
        warnings.push(format!("the depths take {} bytes, but another image starts after {room}", ny * stride));
    }
    let is_missing = invalid(&header);
    large::map(&mut depths, |z| if is_missing(z) { f64::NAN } else { z });
    if let Some(texture) = texture {
        filter_by_repeatability(&header, texture, (ny, nx), &mut depths, &mut warnings);
    }
    // Sides of a pixel: n of them make the field of view.
    let pitch_m = header.number("PixelSizeXMeter")?.zip(header.number("PixelSizeYMeter")?);
    warn_if!(warnings, pitch_m.is_none(), "there is no tag PixelSizeXMeter or PixelSizeYMeter; no pixel size was read");
    let heights_m = input.matrix("Cols", 0, (ny, nx), depths)?;
    Ok(Scan { metadata: metadata(&header), warnings, ..Scan::new(heights_m, pitch_m) })
}

/// Returns a test for the depths that the tag `InvalidPixelValue` marks as missing.
fn invalid(header: &Header) -> impl Fn(f64) -> bool + use<> {
    let value = header.tags.field("InvalidPixelValue").and_then(|text| text.parse().ok());
    let value = value.filter(|value: &f64| value.is_finite()).unwrap_or(INVALID);
    let tolerance = INVALID_TOLERANCE * value.abs();
    // A bound at or below zero would exclude every depth, so only the value itself is missing.
    move |z: f64| z.is_nan() || if value > 0.0 { z >= value - tolerance } else { (z - value).abs() <= tolerance }
}

/// Returns the repeatability of every depth in metre, and the largest one that the vendor's program shows; `None` if there is no such
/// plane, no filter, or a filter of 0, which would exclude every depth.
fn repeatability(header: &Header, texture: usize, (ny, nx): Shape) -> Result<Option<(Vec<f64>, f64)>> {
    let filter = header.number("DepthResFilterVal")?.filter(|&filter| filter > 0.0);
    let Some((filter, plane)) = filter.zip(header.tags.optional::<i64>("DepthImageResPtr")?) else { return Ok(None) };
    let plane = usize::try_from(plane).map_err(|_| header.tags.wrong("DepthImageResPtr", "the number of a plane"))?;
    let start = plane.saturating_mul(stride(nx, Sample::U8) * ny).saturating_add(texture);
    let mut values = header.image("the repeatabilities", start, (ny, nx), Sample::U8)?;
    let shift = header.number("DepthResShiftVal")?.unwrap_or(0.0);
    let low = header.number("DepthResMinVal")?.unwrap_or(0.0);
    large::map(&mut values, |code| code * shift + low);
    Ok(Some((values, filter)))
}

/// Sets depths to NaN that are less repeatable than the file's filter allows.
///
/// Damaged tags or a damaged plane give a warning: the depths do not depend on them.
fn filter_by_repeatability(
    header: &Header,
    texture: usize,
    shape: Shape,
    depths: &mut [f64],
    warnings: &mut Vec<String>,
) {
    let (values, filter) = match repeatability(header, texture, shape) {
        Ok(Some(found)) => found,
        Ok(None) => return,
        Err(error) => return warnings.push(format!("no depth was left out for its repeatability: {error}")),
    };
    let poor = depths.iter_mut().zip(values).filter(|(z, value)| *value > filter && !z.is_nan());
    let filtered = poor.map(|(z, _)| *z = f64::NAN).count();
    if filtered > 0 {
        let filter = in_words(filter);
        warnings.push(format!("{filtered} depths were left out: less repeatable than DepthResFilterVal, {filter}"));
    }
}

/// Returns all tags with text values, and the comment.
fn metadata(header: &Header) -> BTreeMap<String, String> {
    let comment = header.input.latin1("the comment", header.end, COMMENT_BYTES).unwrap_or_default();
    let tags = header.tags.all().map(|(key, value)| (key.to_owned(), value.to_owned()));
    // Some tags only fill space, with bytes that are not text.
    tags.chain([("Comment".to_owned(), comment)])
        .filter(|(_, value)| !value.contains(|c: char| c.is_control() && !c.is_whitespace()))
        .collect()
}
