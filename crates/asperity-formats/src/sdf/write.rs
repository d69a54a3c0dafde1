//! Writer of SDF.

use std::fmt::Write;

use crate::sample::stored;
use crate::{Format, FormatError, Scan};

/// Form of a written file.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum SdfData {
    /// Binary, `float64`.
    #[default]
    Double,
    /// Text. Each number has the fewest digits that read back to the same `f64`.
    Text,
}

/// Sizes in bytes of the manufacturer's name and of a date.
const MANUFACTURER_BYTES: usize = 10;
const DATE_BYTES: usize = 12;
/// Code of `float64`.
const DOUBLE: u8 = 7;
/// Value for an unknown resolution.
const UNKNOWN_RESOLUTION: f64 = -1.0;

/// Writes a scan as a surface data file of ISO 25178-71.
///
/// Heights are stored exactly, in metre. Missing points are `BAD` in text and NaN in binary, which free programs read
/// as missing; some of them read the least `float64`, the mark of the standard, as a height. Version 1.0 counts to
/// 65535; larger binary maps become version 2.0. The bytes do not depend on the clock: without the `CreateDate` of an
/// input file, the dates are zeros, which mean unknown.
///
/// # Errors
/// [`FormatError::NoPitch`] without a pixel size, [`FormatError::NotStorable`] for a scan without points or with an
/// invalid pixel size.
pub fn write_sdf(scan: &Scan, data: SdfData) -> Result<Vec<u8>, FormatError> {
    let (_, pitch_m) = scan.to_store(Format::Sdf)?;
    let is_date = |date: &&String| date.len() == DATE_BYTES && date.bytes().all(|byte| byte.is_ascii_digit());
    let date = |name| scan.metadata.get(name).filter(is_date).map_or("0".repeat(DATE_BYTES), String::clone);
    let (created, modified) = (date("CreateDate"), date("ModDate"));
    Ok(match data {
        SdfData::Text => text(scan, pitch_m, &created, &modified),
        SdfData::Double => binary(scan, pitch_m, &created, &modified),
    })
}

fn binary(scan: &Scan, (dx_m, dy_m): (f64, f64), created: &str, modified: &str) -> Vec<u8> {
    let (profiles, points) = scan.heights_m.dim();
    let counts = u16::try_from(points).ok().zip(u16::try_from(profiles).ok());
    let mut bytes = Vec::with_capacity(100 + 8 * points * profiles);
    bytes.extend(if counts.is_some() { b"bISO-1.0" } else { b"bISO-2.0" });
    bytes.extend(format!("{:MANUFACTURER_BYTES$}{created}{modified}", "asperity").as_bytes());
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
    bytes
}

fn text(scan: &Scan, (dx_m, dy_m): (f64, f64), created: &str, modified: &str) -> Vec<u8> {
    let (profiles, points) = scan.heights_m.dim();
    let mut text = format!(
        "aISO-1.0\r\nManufacID = asperity\r\nCreateDate = {created}\r\nModDate = {modified}\r\nNumPoints = {points}\r\n\
         NumProfiles = {profiles}\r\nXscale = {dx_m:e}\r\nYscale = {dy_m:e}\r\nZscale = 1.0\r\n\
         Zresolution = {UNKNOWN_RESOLUTION:?}\r\nCompression = 0\r\nDataType = {DOUBLE}\r\nCheckType = 0\r\n*\r\n"
    );
    for row in scan.heights_m.rows() {
        for (column, &z) in row.iter().enumerate() {
            let separator = if column > 0 { " " } else { "" };
            // Writing to a String cannot fail.
            let _ = if z.is_finite() { write!(text, "{separator}{z:e}") } else { write!(text, "{separator}BAD") };
        }
        text.push_str("\r\n");
    }
    // Empty trailer.
    text.push_str("*\r\n*\r\n");
    text.into_bytes()
}
