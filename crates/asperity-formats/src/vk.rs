//! Keyence VK3, VK4, VK6, VK7 of laser scanning microscopes.
//!
//! VK3 and VK4 share one layout ([`vk4`]). VK6 and VK7 consist of `VK6` or `VK7`, the size of a preview as u32, the
//! preview as BMP, and a zip archive with a whole VK4 file under the name `Vk4File`.
//!
//! `Vk6ImageData` in that archive is another archive. Its `ErrorImageData` marks points at which the instrument found
//! no height. VK3 and VK4 have no such marks: programs disagree on whether 0 or the highest number is one, so heights
//! of 0 are kept, with a warning.

mod conditions;
mod metadata;
mod vk4;

use ndarray::Array2;

use crate::{Archive, Description, Format, Input, ReadOptions, Result, Sample, Scan, large, refuse_if};

pub(crate) const CODEC: Description = Description {
    extensions: &["vk3", "vk4", "vk6", "vk7"],
    vendor: "Keyence",
    known_by: "`VK3_`, `VK4_`; `VK6` or `VK7` before a BMP preview",
    reads: "up to three layers of heights, 8, 16 and 32 bits",
    missing_points: "points marked in `ErrorImageData` of VK6 and VK7",
    orientation: "the first stored line is row 0",
    ..Description::new(Format::Vk, detect, read)
};

/// Offset of the size of the preview, after `VK6`.
const PREVIEW_SIZE: usize = 3;
/// Offset of the preview.
const PREVIEW: usize = 7;
/// First bytes of the preview.
const BITMAP: &[u8] = b"BM";
/// File of the archive with the heights.
const HEIGHTS: &str = "Vk4File";
/// File of the archive that is an archive of images.
const IMAGES: &str = "Vk6ImageData";
/// Image of points without a height.
const ERRORS: &str = "ErrorImageData";
/// Size in bytes of the header of such an image.
const ERRORS_HEADER_BYTES: usize = 16;

fn detect(bytes: &[u8]) -> bool {
    let is_archive = || [b"VK6", b"VK7"].iter().any(|signature| bytes.starts_with(*signature));
    vk4::detect(bytes) || is_archive() && bytes.get(PREVIEW..).is_some_and(|preview| preview.starts_with(BITMAP))
}

/// Reads a layer of heights.
///
/// # Errors
/// Archives without a VK4 file, files without heights, and sizes beyond the end of the file.
fn read(bytes: &[u8], options: &ReadOptions) -> Result<Scan> {
    let input = Input::new(Format::Vk, bytes);
    if vk4::detect(bytes) {
        return vk4::read(input, options);
    }
    let preview_bytes = usize::try_from(input.u32("the size of the preview", PREVIEW_SIZE)?).unwrap_or(usize::MAX);
    let end = PREVIEW + input.take("the bytes of the preview", PREVIEW, preview_bytes)?.len();
    let mut archive = Archive::open(Format::Vk, &bytes[end..])?;
    let content = archive.read_whole(HEIGHTS, u64::MAX)?;
    let mut scan = vk4::read(Input::entry(Format::Vk, HEIGHTS, &content), options)?;
    drop(content);
    if archive.contains(IMAGES) {
        let warning = match mark_missing(&mut archive, &mut scan.heights_m) {
            Ok(0) => None,
            Ok(marked) => Some(format!("{marked} points are marked in {ERRORS}; they count as missing")),
            Err(error) => Some(format!("{ERRORS} was left out: {error}")),
        };
        scan.warnings.extend(warning);
    }
    Ok(scan)
}

/// Sets heights to NaN where the image of errors is not 0. Returns their number.
fn mark_missing(archive: &mut Archive, heights_m: &mut Array2<f64>) -> Result<usize> {
    let images = archive.read_whole(IMAGES, u64::MAX)?;
    let mut images = Archive::open(Format::Vk, &images)?;
    if !images.contains(ERRORS) {
        return Ok(0);
    }
    let (ny, nx) = heights_m.dim();
    // Rows may be up to twice as long as necessary.
    let limit = ERRORS_HEADER_BYTES as u64 + 2 * heights_m.len() as u64;
    let content = images.read_whole(ERRORS, limit)?;
    let input = Input::entry(Format::Vk, ERRORS, &content);
    for (field, offset, wanted) in [("width", 0, nx), ("height", 4, ny), ("bytes per point", 8, 1)] {
        let found = input.u32(field, offset)?;
        refuse_if!(usize::try_from(found) != Ok(wanted), input.wrong(field, offset, found, &wanted.to_string()));
    }
    let stride = input.u32("bytes per row", 12)?;
    let stride = usize::try_from(stride)
        .ok()
        .filter(|&stride| stride >= nx)
        .ok_or_else(|| input.wrong("bytes per row", 12, stride, "the width or more"))?;
    let errors = input.padded("the rows", ERRORS_HEADER_BYTES, (ny, nx), stride, Sample::U8)?;
    Ok(large::hide(heights_m, errors.into_iter().map(|error| error != 0.0)))
}
