//! VK3 and VK4: a header, a table of offsets, measurement conditions, and images at the offsets.
//!
//! All numbers are u32, little-endian. A stored height n is n · (z length per digit), unsigned; lengths are in
//! picometre. The length per pixel is the distance between points: Keyence's programs state (n − 1) of them as the size
//! of n points.
//!
//! VK3 lacks the last, reserved entry of the table; offsets count from the start of the file, so nothing else differs.
//! The field for compression is set in some files whose heights are not compressed. Only the size in bytes tells.

use ndarray::Array2;

use super::metadata::metadata;
use crate::input::Input;
use crate::large;
use crate::sample::Sample;
use crate::scan::FITTING_SHAPE;
use crate::{Format, FormatError, ReadOptions, Scan};

/// First bytes of the two versions.
const SIGNATURES: [&[u8]; 2] = [b"VK3_", b"VK4_"];
/// Where the type of the file stands, after the version of Keyence's library.
const FILE_TYPE: usize = 8;
/// Where the table of offsets starts.
const OFFSETS: usize = 12;
/// Entries of the table.
const CONDITIONS_ENTRY: usize = 0;
const HEIGHT_ENTRIES: [usize; 3] = [6, 7, 8];
/// Fields of the measurement conditions by their place, counted in numbers.
const X_LENGTH: Field = Field("x length per pixel", 42);
const Y_LENGTH: Field = Field("y length per pixel", 43);
const Z_LENGTH: Field = Field("z length per digit", 44);
/// Bytes before the heights of an image: 7 numbers and a palette.
const IMAGE_HEADER_BYTES: usize = 7 * 4 + 768;
/// Picometre per metre.
const PM_PER_METRE: f64 = 1e12;

/// A field of the measurement conditions and its place, counted in numbers.
#[derive(Clone, Copy)]
pub(super) struct Field(pub(super) &'static str, pub(super) usize);

/// The measurement conditions: the file up to their end, and where they start.
#[derive(Clone, Copy)]
pub(super) struct Conditions<'a> {
    input: Input<'a>,
    start: usize,
}

impl Conditions<'_> {
    pub(super) fn at(&self, field: Field) -> usize {
        self.start + 4 * field.1
    }

    pub(super) fn u32(&self, field: Field) -> Result<u32, FormatError> {
        self.input.u32(field.0, self.at(field))
    }

    fn metre(&self, field: Field) -> Result<f64, FormatError> {
        Ok(f64::from(self.u32(field)?) / PM_PER_METRE)
    }
}

pub(super) fn detect(bytes: &[u8]) -> bool {
    SIGNATURES.iter().any(|signature| bytes.starts_with(signature))
}

/// The offset in an entry of the table, `None` where the part is not there.
pub(super) fn offset(input: Input, part: &str, entry: usize) -> Result<Option<usize>, FormatError> {
    let at = OFFSETS + 4 * entry;
    let found = input.u32(&format!("the offset of {part}"), at)?;
    Ok(usize::try_from(found).ok().filter(|&offset| offset > 0))
}

/// Reads a layer of heights.
///
/// # Errors
/// Files without heights, and headers that the bytes cannot bear out.
pub(super) fn read(input: Input, options: &ReadOptions) -> Result<Scan, FormatError> {
    let mut warnings = Vec::new();
    let file_type = input.u32("file type", FILE_TYPE)?;
    if file_type != 0 {
        warnings.push(format!("the file type is {file_type}, not 0; the file was read all the same"));
    }
    let conditions = conditions(input)?;
    let (mut names, mut offsets) = (Vec::new(), Vec::new());
    for (number, entry) in HEIGHT_ENTRIES.into_iter().enumerate() {
        let name = format!("Height {}", number + 1);
        if let Some(offset) = offset(input, &name, entry)? {
            names.push(name);
            offsets.push(offset);
        }
    }
    if names.is_empty() {
        return Err(input.unsupported("the file holds no heights, only images", "a layer of heights"));
    }
    let channel = options.choose(Format::Vk, &names)?;
    let heights_m = heights(input, offsets[channel], &conditions, &mut warnings)?;
    let pitch_m = Some((conditions.metre(X_LENGTH)?, conditions.metre(Y_LENGTH)?));
    let scan = Scan { metadata: metadata(input, &conditions), warnings, ..Scan::new(heights_m, pitch_m) };
    Ok(scan.with_channels(names, channel))
}

/// The measurement conditions.
fn conditions<'a>(input: Input<'a>) -> Result<Conditions<'a>, FormatError> {
    let start = offset(input, "the measurement conditions", CONDITIONS_ENTRY)?
        .ok_or_else(|| input.missing("the offset of the measurement conditions", OFFSETS, "a value above 0"))?;
    let size = usize::try_from(input.u32("the size of the measurement conditions", start)?).unwrap_or(usize::MAX);
    let end = start + input.take("the measurement conditions", start, size)?.len();
    Ok(Conditions { input: input.up_to(end), start })
}

/// The heights of the image at `start` in metre.
fn heights(
    input: Input,
    start: usize,
    conditions: &Conditions,
    warnings: &mut Vec<String>,
) -> Result<Array2<f64>, FormatError> {
    let [width, height, bits, size] = [("width", 0), ("height", 4), ("bit depth", 8), ("byte size", 16)]
        .map(|(field, offset)| (field, start + offset));
    let number = |(field, at): (&str, usize)| input.u32(field, at);
    let shape = |at: (&'static str, usize)| number(at).map(|found| (at.0, at.1, i64::from(found)));
    let (ny, nx) = input.shape(shape(height)?, shape(width)?)?;
    let sample = match number(bits)? {
        8 => Sample::U8,
        16 => Sample::U16,
        32 => Sample::U32,
        found => return Err(input.wrong(bits.0, bits.1, found, "8, 16 or 32")),
    };
    let (found, wanted) = (number(size)?, nx * ny * sample.size());
    if usize::try_from(found) != Ok(wanted) {
        return Err(input.wrong(size.0, size.1, found, &format!("{wanted}, as heights that are not compressed take")));
    }
    let scale_m = conditions.metre(Z_LENGTH)?;
    if scale_m == 0.0 {
        return Err(input.wrong(Z_LENGTH.0, conditions.at(Z_LENGTH), 0, "a length above 0"));
    }
    let mut heights = input.samples("the heights", start + IMAGE_HEADER_BYTES, nx * ny, sample)?;
    let zeros = large::count(&mut heights, |z| {
        *z *= scale_m;
        *z == 0.0
    });
    if zeros > 0 {
        warnings.push(format!("{zeros} heights are 0, which may stand for missing points; they were kept"));
    }
    Array2::from_shape_vec((ny, nx), heights).map_err(|_| input.wrong(width.0, width.1, nx, FITTING_SHAPE))
}
