//! Writer of SUR.

use super::header::{
    AXIS_TEXT_BYTES, CLIENT_ZONE_BYTES, DATE, HEADER_BYTES, NAME_BYTES, OBJECT_NAME, OPERATOR_NAME, SIGNATURE,
    VOID_BELOW_MINIMUM,
};
use crate::unit::in_words;
use crate::{Format, FormatError, Result, Scan};

/// Highest number; the lowest is 0. One more would mark a saturated point.
const HIGHEST: i32 = i32::MAX - 1;
/// Number of units per metre and spelling of micrometre and nanometre. µ is one byte of Latin-1.
const MICROMETRE: (f64, &str) = (1e6, "\u{b5}m");
const NANOMETRE: (f64, &str) = (1e9, "nm");
/// Object type of a surface, and version of the header.
const SURFACE: i16 = 2;
const VERSION: i16 = 1;
/// Maximum size of a comment in bytes.
const MAX_COMMENT_BYTES: usize = i16::MAX as usize;
/// Date that other formats use for an unknown one.
const NO_DATE: &str = "1970-01-01";
/// Content of the zone of the writing program.
const CLIENT: &str = "asperity";

/// Stored numbers from 0 up, and the spacing and offset that convert them to micrometre.
struct Stored {
    points: Vec<u8>,
    highest: i32,
    spacing: f32,
    offset: f32,
}

/// Writes a scan as a SUR file of one surface with plain `int32`. Equal scans give equal bytes.
///
/// Numbers start at 0. Offset and spacing are `f32`: the offset is the lowest height rounded down, the spacing is the
/// range above it divided by the number of steps and rounded up, and heights are rounded to multiples of the rounded
/// spacing. The error of a height is at most half a step, without an error of scale. For heights far from zero, the
/// range grows by the rounding of the offset, at most 1.2e-7 of the offset. The pixel size is also `f32`, with a
/// relative error of at most 6e-8; it is exact for whole nanometres up to 2²⁴. Readers that measure heights from the
/// z minimum agree, since it is 0.
///
/// Name, operator, date and comment are taken from the metadata, by the names of this format or of X3P. Texts are cut
/// to the widths of their fields, and characters outside Latin-1 become `?`.
///
/// # Errors
/// [`FormatError::NoPitch`] without a pixel size, [`FormatError::NotStorable`] for a scan without points, with more
/// than 2³¹ − 1 points, or with lengths beyond the range of `f32`.
pub fn write_sur(scan: &Scan) -> Result<Vec<u8>, FormatError> {
    let ((ny, nx), (dx_m, dy_m)) = scan.to_store(Format::Sur)?;
    let counts = [nx, ny, scan.heights_m.len()].map(i32::try_from);
    let [Ok(columns), Ok(lines), Ok(points)] = counts else {
        return Err(not_storable(format!("a map of {nx} × {ny} points"), "at most 2³¹ − 1 points"));
    };
    let ((dx, x_unit), (dy, y_unit)) = (pitch(dx_m)?, pitch(dy_m)?);
    let z_unit = MICROMETRE.1;
    let stored = quantised(scan)?;
    let known = |names: [&str; 2]| names.iter().find_map(|name| scan.metadata.get(*name)).map_or("", String::as_str);
    let comment = latin1(known(["comment", "Record2/Comment"]), MAX_COMMENT_BYTES);

    let mut file = Vec::with_capacity(HEADER_BYTES + comment.len() + stored.points.len());
    file.extend(SIGNATURE);
    // Little-endian, one object.
    file.extend([0, 1, VERSION, SURFACE].map(i16::to_le_bytes).as_flattened());
    file.extend(field(known([OBJECT_NAME.0, ""]), NAME_BYTES));
    file.extend(field(known([OPERATOR_NAME.0, "Record2/Creator"]), NAME_BYTES));
    // One channel of unknown acquisition and normal range; special points; absolute heights.
    file.extend([0, 0, 0, i16::from(scan.missing_points() > 0), 1].map(i16::to_le_bytes).as_flattened());
    // Resolution of the gauge, points per spectrum.
    file.extend([0; 8]);
    file.extend(32_i16.to_le_bytes());
    file.extend([0, stored.highest, columns, lines, points].map(i32::to_le_bytes).as_flattened());
    file.extend([dx, dy, stored.spacing].map(f32::to_le_bytes).as_flattened());
    // Lengths have the units of steps, so the ratios are 1.
    for text in ["X", "Y", "Z", x_unit, y_unit, z_unit, x_unit, y_unit, z_unit] {
        file.extend(field(text, AXIS_TEXT_BYTES));
    }
    file.extend([1.0; 3].map(f32::to_le_bytes).as_flattened());
    // No imprint, not inverted, not levelled; obsolete bytes.
    file.extend([0; 6 + 12]);
    file.extend(date(known([DATE.0, "Record2/Date"])).map(i16::to_le_bytes).as_flattened());
    // Duration, size of compressed heights, obsolete bytes.
    file.extend([0; 4 + 4 + 6]);
    file.extend([comment.len() as i16, 0].map(i16::to_le_bytes).as_flattened());
    file.extend(field(CLIENT, CLIENT_ZONE_BYTES));
    file.extend([0.0, 0.0, stored.offset].map(f32::to_le_bytes).as_flattened());
    // Axis of a series.
    file.extend([0; 4 + 4 + 13 + 13]);
    file.extend(comment);
    file.extend(stored.points);
    Ok(file)
}

fn not_storable(found: String, wanted: &'static str) -> FormatError {
    FormatError::not_storable(Format::Sur, found, wanted)
}

/// Returns the pitch in micrometre, or in nanometre if it is exact only there.
fn pitch(pitch_m: f64) -> Result<(f32, &'static str)> {
    let rounded = |(per_metre, unit): (f64, &'static str)| {
        let pitch = (pitch_m * per_metre) as f32;
        ((f64::from(pitch) / per_metre - pitch_m).abs(), pitch, unit)
    };
    let (micrometre, nanometre) = (rounded(MICROMETRE), rounded(NANOMETRE));
    // An exact number differs only by the rounding of the two conversions.
    let is_exact = |error: f64| error <= 2.0 * f64::EPSILON * pitch_m;
    let (_, pitch, unit) = if is_exact(nanometre.0) && !is_exact(micrometre.0) { nanometre } else { micrometre };
    if !(pitch.is_normal() && pitch > 0.0) {
        return Err(not_storable(
            format!("a pixel size of {}", in_words(pitch_m)),
            "a positive number within the range of f32",
        ));
    }
    Ok((pitch, unit))
}

/// Returns the heights in steps above the offset.
fn quantised(scan: &Scan) -> Result<Stored> {
    let (low_m, high_m) = scan.height_range_m().unwrap_or((0.0, 0.0));
    let (low, high) = (low_m * MICROMETRE.0, high_m * MICROMETRE.0);
    let nearest = low as f32;
    let offset = if nearest.is_finite() && f64::from(nearest) > low { nearest.next_down() } else { nearest };
    let span = high - f64::from(offset);
    // A spacing below the normal numbers would lose digits. A flat map may have any spacing.
    let exact = if span > 0.0 { (span / f64::from(HIGHEST)).max(f32::MIN_POSITIVE.into()) } else { 1.0 };
    let spacing = exact as f32;
    let spacing = if f64::from(spacing) < exact { spacing.next_up() } else { spacing };
    if !(offset.is_finite() && spacing.is_finite() && span.is_finite()) {
        let [low, high] = [low_m, high_m].map(in_words);
        return Err(not_storable(format!("heights from {low} to {high}"), "heights within the range of f32"));
    }
    let mut points = Vec::with_capacity(4 * scan.heights_m.len());
    let mut highest = 0;
    for &z in &scan.heights_m {
        let number = if z.is_finite() {
            // The spacing is rounded up, so no number is above the highest.
            ((z * MICROMETRE.0 - f64::from(offset)) / f64::from(spacing)).round() as i32
        } else {
            -VOID_BELOW_MINIMUM
        };
        highest = highest.max(number);
        points.extend(number.to_le_bytes());
    }
    Ok(Stored { points, highest, spacing, offset })
}

/// Encodes a text as Latin-1, cut to `width` bytes.
fn latin1(text: &str, width: usize) -> Vec<u8> {
    let shown = text.chars().filter(|c| !c.is_control() || matches!(c, '\n' | '\r' | '\t'));
    let byte = |c| match c {
        // Greek letter used for the micro sign.
        '\u{3bc}' => 0xb5,
        _ => u8::try_from(c).unwrap_or(b'?'),
    };
    shown.map(byte).take(width).collect()
}

/// Returns second, minute, hour, day, month, year and day of the week; zeros if the text is not
/// `yyyy-mm-ddThh:mm:ss`.
fn date(text: &str) -> [i16; 7] {
    let part = |range: std::ops::Range<usize>, low: i16, high: i16| {
        text.get(range)?.parse().ok().filter(|number| (low..=high).contains(number))
    };
    let parts = || {
        let (year, month, day) = (part(0..4, 1, 9999)?, part(5..7, 1, 12)?, part(8..10, 1, 31)?);
        let (hour, minute, second) = (part(11..13, 0, 23)?, part(14..16, 0, 59)?, part(17..19, 0, 60)?);
        // The day of the week is left at 0: writers disagree on the first day.
        Some([second, minute, hour, day, month, year, 0])
    };
    if text.starts_with(NO_DATE) { [0; 7] } else { parts().unwrap_or_default() }
}

/// Returns a text in a field of `width` bytes, padded with spaces.
fn field(text: &str, width: usize) -> Vec<u8> {
    let mut bytes = latin1(text, width);
    bytes.resize(width, b' ');
    bytes
}
