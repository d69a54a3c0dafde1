//! Writer of SDF.

use crate::sample::stored;
use crate::{Format, FormatError, Scan};

/// Sizes in bytes of the manufacturer's name and of a date.
const MANUFACTURER_BYTES: usize = 10;
const DATE_BYTES: usize = 12;
/// Code of `float64`.
const DOUBLE: u8 = 7;
/// Value for an unknown resolution.
const UNKNOWN_RESOLUTION: f64 = -1.0;

/// Writes a scan as a surface data file of ISO 25178-71: binary, `float64`.
///
/// Heights are stored exactly, in metre. Missing points are NaN, which free programs read as missing; some of them
/// read the least `float64`, the mark of the standard, as a height. Version 1.0 counts to 65535; larger maps become
/// version 2.0. The bytes do not depend on the clock: without the `CreateDate` of an input file, the dates are zeros,
/// which mean unknown.
///
/// # Errors
/// [`FormatError::NoPitch`] without a pixel size, [`FormatError::NotStorable`] for a scan without points or with an
/// invalid pixel size.
pub fn write_sdf(scan: &Scan) -> Result<Vec<u8>, FormatError> {
    let ((profiles, points), (dx_m, dy_m)) = scan.to_store(Format::Sdf)?;
    let is_date = |date: &&String| date.len() == DATE_BYTES && date.bytes().all(|byte| byte.is_ascii_digit());
    let date = |name| scan.metadata.get(name).filter(is_date).map_or("0".repeat(DATE_BYTES), String::clone);
    let counts = u16::try_from(points).ok().zip(u16::try_from(profiles).ok());
    let mut bytes = Vec::with_capacity(100 + 8 * points * profiles);
    bytes.extend(if counts.is_some() { b"bISO-1.0" } else { b"bISO-2.0" });
    bytes.extend(format!("{:MANUFACTURER_BYTES$}{}{}", "asperity", date("CreateDate"), date("ModDate")).as_bytes());
    match counts {
        Some((points, profiles)) => bytes.extend([points.to_le_bytes(), profiles.to_le_bytes()].concat()),
        // A scan has far fewer than 2³² points.
        None => bytes.extend([(points as u32).to_le_bytes(), (profiles as u32).to_le_bytes()].concat()),
    }
    for number in [dx_m, dy_m, 1.0, UNKNOWN_RESOLUTION] {
        bytes.extend(number.to_le_bytes());
    }
    // No compression and no checksum.
    bytes.extend([0, DOUBLE, 0]);
    for z in &scan.heights_m {
        bytes.extend(stored(z));
    }
    Ok(bytes)
}
