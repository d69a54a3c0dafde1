//! VK3 and VK4: a header, a table of offsets, measurement conditions, and images at the offsets.
//!
//! All numbers are u32, little-endian. A stored height n is n · (z length per digit), unsigned; lengths are in
//! picometre. The length per pixel is the distance between points: Keyence's programs state (n − 1) of them as the size
//! of n points.
//!
//! VK3 lacks the last, reserved entry of the table; offsets count from the start of the file, so nothing else differs.
//! The field for compression is set in some files whose heights are not compressed. Only the size in bytes tells.

use crate::error::Result;
use ndarray::Array2;

use super::conditions::{Conditions, Field, offset};
use super::metadata::metadata;
use crate::input::Input;
use crate::large;
use crate::sample::Sample;

use crate::{Format, ReadOptions, Scan};

/// First bytes of the two versions.
const SIGNATURES: [&[u8]; 2] = [b"VK3_", b"VK4_"];
/// Where the type of the file stands, after the version of Keyence's library.
const FILE_TYPE: usize = 8;
/// Entries of the table of offsets.
const HEIGHT_ENTRIES: [usize; 3] = [6, 7, 8];
/// Fields of the measurement conditions by their place, counted in numbers.
const X_LENGTH: Field = Field("x length per pixel", 42);
const Y_LENGTH: Field = Field("y length per pixel", 43);
const Z_LENGTH: Field = Field("z length per digit", 44);
/// Bytes before the heights of an image: 7 numbers and a palette.
const IMAGE_HEADER_BYTES: usize = 7 * 4 + 768;
pub(super) fn detect(bytes: &[u8]) -> bool {
    SIGNATURES.iter().any(|signature| bytes.starts_with(signature))
}

/// Reads a layer of heights.
///
/// # Errors
/// Files without heights, and headers that the bytes cannot bear out.
pub(super) fn read(input: Input, options: &ReadOptions) -> Result<Scan> {
    let mut warnings = Vec::new();
    let file_type = input.u32("file type", FILE_TYPE)?;
    if file_type != 0 {
        warnings.push(format!("the file type is {file_type}, not 0; the file was read all the same"));
    }
    let conditions = Conditions::new(input)?;
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

/// The heights of the image at `start` in metre.
fn heights(input: Input, start: usize, conditions: &Conditions, warnings: &mut Vec<String>) -> Result<Array2<f64>> {
    let [width, height, bits, size] = [("width", 0), ("height", 4), ("bit depth", 8), ("byte size", 16)]
        .map(|(field, offset)| (field, start + offset));
    let number = |(field, at): (&str, usize)| input.u32(field, at);
    let shape = |at: (&'static str, usize)| number(at).map(|found| (at.0, at.1, found));
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
    input.matrix(width.0, width.1, (ny, nx), heights)
}
