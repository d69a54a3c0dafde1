//! Metadata of a VK4 file.

use std::collections::BTreeMap;

use super::conditions::{number, offset};
use crate::{ByteOrder, Field, Input, date, utf16_text};

/// Offset of the version of Keyence's library: four bytes, the main number last.
const LIBRARY_VERSION: usize = 4;
/// Entry of the table of offsets for title and name of the lens.
const STRINGS_ENTRY: usize = 16;

/// Year, month, day, hour, minute, second.
const DATE: [Field; 6] =
    [Field("year", 1), Field("month", 2), Field("day", 3), Field("hour", 4), Field("minute", 5), Field("second", 6)];
/// Minutes by which that time is ahead of UTC, signed.
const UTC_OFFSET: Field = Field("difference from UTC", 7);

/// Numbers of the measurement conditions, their divisors and their units.
const NUMBERS: [(Field, f64, &str); 27] = [
    (Field("image layers", 11), 1.0, ""),
    (Field("run mode", 12), 1.0, ""),
    (Field("peak mode", 13), 1.0, ""),
    (Field("sharpening level", 14), 1.0, ""),
    (Field("speed", 15), 1.0, ""),
    (Field("distance", 16), 1.0, " nm"),
    (Field("pitch", 17), 1.0, " nm"),
    (Field("optical zoom", 18), 10.0, ""),
    (Field("number of lines", 19), 1.0, ""),
    (Field("first line position", 20), 1.0, ""),
    (Field("lens magnification", 24), 10.0, ""),
    (Field("PMT gain mode", 25), 1.0, ""),
    (Field("PMT gain", 26), 1.0, ""),
    (Field("PMT offset", 27), 1.0, ""),
    (Field("ND filter", 28), 1.0, ""),
    (Field("image average frequency", 30), 1.0, ""),
    (Field("shutter speed", 32), 1.0, ""),
    (Field("plane compensation", 37), 1.0, ""),
    (Field("x length per pixel", 42), 1.0, " pm"),
    (Field("y length per pixel", 43), 1.0, " pm"),
    (Field("z length per digit", 44), 1.0, " pm"),
    (Field("numerical aperture", 56), 1000.0, ""),
    (Field("head type", 57), 1.0, ""),
    (Field("lens ID", 60), 1.0, ""),
    (Field("upper position", 72), 1.0, " nm"),
    (Field("lower position", 73), 1.0, " nm"),
    (Field("height effective bit depth", 75), 1.0, ""),
];

/// Returns the fields that are present.
pub(super) fn metadata(input: Input, conditions: &Input) -> BTreeMap<String, String> {
    let in_words = |(field, divisor, unit): &(Field, f64, &str)| {
        let number = f64::from(number(conditions, *field).ok()?) / divisor;
        Some((field.0.to_owned(), format!("{number}{unit}")))
    };
    let mut metadata: BTreeMap<_, _> = NUMBERS.iter().filter_map(in_words).collect();
    let mut insert = |name: &str, value: Option<String>| metadata.extend(value.map(|value| (name.to_owned(), value)));
    insert("date", date(conditions));
    let version = input.take("library version", LIBRARY_VERSION, 4).ok();
    let version = version.map(|bytes| bytes.iter().rev().map(u8::to_string).collect::<Vec<_>>().join("."));
    insert("library version", version);
    let (title, lens) = strings(input);
    insert("title", title);
    insert("lens name", lens);
    metadata
}

/// Returns date and time of the measurement with their offset from UTC.
fn date(conditions: &Input) -> Option<String> {
    let number = |field| number(conditions, field).ok();
    let [Some(year), Some(month), Some(day @ 1..), Some(hour), Some(minute), Some(second)] = DATE.map(number) else {
        return None;
    };
    let ahead = number(UTC_OFFSET)?.cast_signed();
    let (sign, apart) = (if ahead < 0 { '-' } else { '+' }, ahead.unsigned_abs());
    let date = date::text([year, month, day, hour, minute, second]);
    Some(format!("{date}{sign}{:02}:{:02}", apart / 60, apart % 60))
}

/// Returns title and name of the lens.
fn strings(input: Input) -> (Option<String>, Option<String>) {
    let Ok(Some(start)) = offset(input, "the strings", STRINGS_ENTRY) else { return (None, None) };
    let Some((title, end)) = string(input, start) else { return (None, None) };
    (Some(title), string(input, end).map(|(lens, _)| lens))
}

/// Returns a text in UTF-16 after the number of its units, and the offset of its end.
fn string(input: Input, start: usize) -> Option<(String, usize)> {
    let units = usize::try_from(input.u32("a string's length", start).ok()?).ok()?;
    let bytes = input.take("a string", start + 4, units.saturating_mul(2)).ok()?;
    let text = utf16_text(bytes, ByteOrder::Little);
    let text = text.split('\0').next().unwrap_or_default().trim();
    Some((text.to_owned(), start + 4 + bytes.len()))
}
