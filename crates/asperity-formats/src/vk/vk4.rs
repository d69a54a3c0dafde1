//! VK3 and VK4: a header, a table of offsets, measurement conditions, and images at the offsets.
//!
//! All numbers are u32, little-endian. A stored height n is n · (z length per digit), unsigned; lengths are in
//! picometre. The length per pixel is the distance between points: Keyence's programs state (n − 1) of them as the
//! size of n points.
//!
//! VK3 lacks the last, reserved entry of the table. Offsets count from the start of the file, so there is no other
//! difference. Some files with uncompressed heights set the field for compression. Only the size in bytes shows
//! compression.

use ndarray::Array2;

use super::conditions::{conditions, length_m, offset};
use super::metadata::metadata;
use crate::{Field, Format, Input, ReadOptions, Result, Sample, Scan, large, refuse_if, warn_if};

/// First bytes of the two versions.
const SIGNATURES: [&[u8]; 2] = [b"VK3_", b"VK4_"];
/// Offset of the type of the file, after the version of Keyence's library.
const FILE_TYPE: usize = 8;
/// Entries of the table of offsets.
const HEIGHT_ENTRIES: [usize; 3] = [6, 7, 8];
/// Fields of the measurement conditions; offsets count numbers of 4 bytes.
const X_LENGTH: Field = Field("x length per pixel", 42);
const Y_LENGTH: Field = Field("y length per pixel", 43);
const Z_LENGTH: Field = Field("z length per digit", 44);
/// Size in bytes of the header of an image: 7 numbers and a palette.
const IMAGE_HEADER_BYTES: usize = 7 * 4 + 768;
pub(super) fn detect(bytes: &[u8]) -> bool {
    SIGNATURES.iter().any(|signature| bytes.starts_with(signature))
}

/// Reads a layer of heights.
///
/// # Errors
/// Files without heights, and sizes beyond the end of the file.
pub(super) fn read(input: Input, options: &ReadOptions) -> Result<Scan> {
    let mut warnings = Vec::new();
    let file_type = input.u32("file type", FILE_TYPE)?;
    warn_if!(warnings, file_type != 0, "the file type is {file_type}, not 0; the file was still read");
    let conditions = conditions(input)?;
    let (mut names, mut offsets) = (Vec::new(), Vec::new());
    for (number, entry) in HEIGHT_ENTRIES.into_iter().enumerate() {
        let name = format!("Height {}", number + 1);
        if let Some(offset) = offset(input, &name, entry)? {
            names.push(name);
            offsets.push(offset);
        }
    }
    refuse_if!(names.is_empty(), input.unsupported("the file holds no heights, only images", "a layer of heights"));
    let channel = options.choose(Format::Vk, &names)?;
    let heights_m = heights(input.from(offsets[channel]), &conditions, &mut warnings)?;
    let pitch_m = Some((length_m(&conditions, X_LENGTH)?, length_m(&conditions, Y_LENGTH)?));
    let scan = Scan { metadata: metadata(input, &conditions), warnings, ..Scan::new(heights_m, pitch_m) };
    Ok(scan.with_channels(names, channel))
}

/// Reads the heights of an image in metre.
fn heights(image: Input, conditions: &Input, warnings: &mut Vec<String>) -> Result<Array2<f64>> {
    let (width, height, bits) = (image.u32("width", 0)?, image.u32("height", 4)?, image.u32("bit depth", 8)?);
    let (ny, nx) = image.shape(("height", 4, height), ("width", 0, width))?;
    let sample = Sample::integer(bits.into(), false).filter(|sample| sample.size() <= 4);
    let sample = sample.ok_or_else(|| image.wrong("bit depth", 8, bits, "8, 16 or 32"))?;
    let (found, wanted) = (image.u32("byte size", 16)?, nx * ny * sample.size());
    if usize::try_from(found) != Ok(wanted) {
        let wanted = format!("{wanted}, the size of uncompressed heights");
        return Err(image.wrong("byte size", 16, found, &wanted));
    }
    let scale_m = length_m(conditions, Z_LENGTH)?;
    refuse_if!(scale_m == 0.0, conditions.wrong(Z_LENGTH.0, 4 * Z_LENGTH.1, 0, "a length above 0"));
    let mut heights = image.samples("the heights", IMAGE_HEADER_BYTES, nx * ny, sample)?;
    let zeros = large::count(&mut heights, |z| {
        *z *= scale_m;
        *z == 0.0
    });
    warn_if!(warnings, zeros > 0, "{zeros} heights are 0, which may stand for missing points; they were kept");
    image.matrix("width", 0, (ny, nx), heights)
}
