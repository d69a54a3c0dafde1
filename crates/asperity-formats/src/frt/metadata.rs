//! What an FRT file says besides its heights.

use std::collections::BTreeMap;

use super::blocks::{Block, Blocks, Z_UNIT};
use crate::input::latin1;

/// How a field is stored and shown.
#[derive(Clone, Copy)]
enum Kind {
    U32,
    F64,
    /// Seconds since 1970-01-01, unset as 0 or with all bits.
    Time,
    /// Text of at most that many bytes.
    Text(usize),
    /// Text after its length as u32, after so many other such texts.
    Counted(usize),
}

/// Fields by block and offset.
const FIELDS: [(u16, usize, &str, Kind); 37] = [
    (0x0065, 0, "description", Kind::Text(usize::MAX)),
    (0x0067, 16, "x offset", Kind::F64),
    (0x0067, 24, "y offset", Kind::F64),
    (0x0067, 40, "scan direction", Kind::U32),
    (0x0068, 0, "x speed", Kind::F64),
    (0x0068, 8, "y speed", Kind::F64),
    (0x006c, 0, "measuring range", Kind::U32),
    (0x006c, 4, "z scale", Kind::F64),
    (0x006e, 0, "sensor type", Kind::U32),
    (0x006e, 4, "xy table type", Kind::U32),
    (0x006e, 8, "z table type", Kind::U32),
    (0x006f, 4, "integrate over", Kind::U32),
    (0x0070, 0, "first valid value", Kind::U32),
    (0x0070, 4, "last valid value", Kind::U32),
    (0x0071, 0, "z offset", Kind::F64),
    (0x0072, 0, "measurement started", Kind::Time),
    (0x0072, 4, "measurement ended", Kind::Time),
    (0x0072, 8, "measurement time in s", Kind::U32),
    (0x0074, 0, "DLL version 1", Kind::U32),
    (0x0074, 4, "DLL version 2", Kind::U32),
    (0x0075, 4, "drift correction applied", Kind::U32),
    (0x0077, 0, "parameter set", Kind::Text(usize::MAX)),
    (0x007a, 0, "measuring rate", Kind::U32),
    (0x007a, 4, "minimum intensity", Kind::U32),
    (0x007b, 0, "sensor subtype", Kind::U32),
    (0x007f, 0, "calibration", Kind::Text(255)),
    (0x008e, 0, "serial number", Kind::Counted(0)),
    (0x0090, 0, "despiked", Kind::U32),
    (0x0090, 12, "filtered", Kind::U32),
    (0x0095, 0, "thickness mode", Kind::U32),
    (0x0095, 8, "refractive index", Kind::F64),
    (0x009b, 0, "roundness", Kind::U32),
    (0x00a6, 0, "objective", Kind::Counted(0)),
    (0x00a9, 0, "x axis subtracted", Kind::U32),
    (0x00a9, 4, "y axis subtracted", Kind::U32),
    (0x00ac, 0, "user name", Kind::Counted(0)),
    (0x00ac, 0, "user description", Kind::Counted(1)),
];

/// The fields that are there; whatever a block is too short for is left out.
pub(super) fn metadata(blocks: &Blocks) -> BTreeMap<String, String> {
    let mut metadata = BTreeMap::new();
    for (tag, offset, name, kind) in FIELDS {
        let Some(block) = blocks.get(&tag) else { continue };
        if let Some(value) = value(block, name, offset, kind).filter(|value| !value.is_empty()) {
            metadata.insert(name.into(), value);
        }
    }
    if let Some(unit) = blocks.get(&Z_UNIT).and_then(z_unit) {
        metadata.insert("z unit".into(), unit);
    }
    metadata
}

fn value(block: &Block, name: &str, offset: usize, kind: Kind) -> Option<String> {
    match kind {
        Kind::U32 => block.u32(name, offset).ok().map(|number| number.to_string()),
        Kind::F64 => block.f64(name, offset).ok().map(|number| number.to_string()),
        Kind::Time => {
            let seconds = block.u32(name, offset).ok().filter(|&seconds| seconds != 0 && seconds != u32::MAX)?;
            Some(utc(seconds))
        }
        Kind::Text(length) => {
            let length = length.min(block.len().checked_sub(offset)?);
            block.input.latin1(name, block.start + offset, length).ok()
        }
        Kind::Counted(before) => {
            let mut offset = offset;
            for _ in 0..before {
                offset += 4 + counted(block, name, offset)?.len();
            }
            counted(block, name, offset).map(latin1)
        }
    }
}

/// A text after its length.
fn counted<'a>(block: &Block<'a>, name: &str, offset: usize) -> Option<&'a [u8]> {
    let length = usize::try_from(block.u32(name, offset).ok()?).ok()?;
    block.input.take(name, block.start + offset + 4, length).ok()
}

/// The unit of z in block 0x009f, a text after its length as u16.
pub(super) fn z_unit(block: &Block) -> Option<String> {
    let length = block.input.u16("z unit", block.start).ok()?;
    let text = block.input.latin1("z unit", block.start + 2, length.into()).ok()?;
    Some(text).filter(|text| !text.is_empty())
}

/// Seconds since 1970-01-01 as a date and time.
fn utc(seconds: u32) -> String {
    let (days, rest) = (i64::from(seconds) / 86400, seconds % 86400);
    // Days of years that start on 1 March, in eras of 400 years (146097 days) from 0000-03-01.
    let day = days + 719468;
    let (era, day) = (day / 146097, day % 146097);
    let year = (day - day / 1460 + day / 36524 - day / 146096) / 365;
    let day = day - (365 * year + year / 4 - year / 100);
    let month = (5 * day + 2) / 153;
    let (day, month) = (day - (153 * month + 2) / 5 + 1, if month < 10 { month + 3 } else { month - 9 });
    let year = year + 400 * era + i64::from(month <= 2);
    let (hour, minute, second) = (rest / 3600, rest / 60 % 60, rest % 60);
    format!("{year:04}-{month:02}-{day:02}T{hour:02}:{minute:02}:{second:02}Z")
}

#[cfg(test)]
mod tests {
    use super::utc;

    #[test]
    fn seconds_are_told_as_dates() {
        // By `date -u -d @…`.
        for (seconds, date) in [
            (1, "1970-01-01T00:00:01Z"),
            (951_782_400, "2000-02-29T00:00:00Z"),
            (1_678_463_840, "2023-03-10T15:57:20Z"),
            (4_107_542_399, "2100-02-28T23:59:59Z"),
            (4_107_542_400, "2100-03-01T00:00:00Z"),
        ] {
            assert_eq!(utc(seconds), date);
        }
    }
}
