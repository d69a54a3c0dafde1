//! Metadata of an FRT file.

use std::collections::BTreeMap;

use super::blocks::{Blocks, Z_UNIT};
use crate::date::utc;
use crate::{Input, input, latin1};

/// Type of a field.
#[derive(Clone, Copy)]
enum Kind {
    U32,
    F64,
    /// Seconds since 1970-01-01; 0 and all bits set mean unknown.
    Time,
    /// Text of at most this many bytes.
    Text(usize),
    /// Text after its length as u32, after this many other such texts.
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

/// Returns the fields that are present. Fields beyond the end of a block are left out.
pub(super) fn metadata(blocks: &Blocks) -> BTreeMap<String, String> {
    let mut metadata = BTreeMap::new();
    for (tag, offset, name, kind) in FIELDS {
        let Some(block) = blocks.get(&tag) else { continue };
        metadata.extend(value(block, name, offset, kind).map(|value| (name.to_owned(), value)));
    }
    metadata.extend(blocks.get(&Z_UNIT).and_then(z_unit).map(|unit| ("z unit".to_owned(), unit)));
    metadata
}

fn value(block: &Input, name: &str, offset: usize, kind: Kind) -> Option<String> {
    match kind {
        Kind::U32 => block.value(name, offset, input::Kind::U32).ok(),
        Kind::F64 => block.value(name, offset, input::Kind::F64).ok(),
        Kind::Time => block.u32(name, offset).ok().filter(|&seconds| seconds != 0 && seconds != u32::MAX).map(utc),
        Kind::Text(length) => {
            let length = length.min(block.len().checked_sub(offset)?);
            block.latin1(name, offset, length).ok()
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

/// Returns a text after its length.
fn counted<'a>(block: &Input<'a>, name: &str, offset: usize) -> Option<&'a [u8]> {
    let length = usize::try_from(block.u32(name, offset).ok()?).ok()?;
    block.take(name, offset + 4, length).ok()
}

/// Returns the unit of z in block 0x009f, a text after its length as u16.
pub(super) fn z_unit(block: &Input) -> Option<String> {
    let length = block.u16("z unit", 0).ok()?;
    block.latin1("z unit", 2, length.into()).ok().filter(|text| !text.is_empty())
}
