//! Metadata of an FRT file.

use std::collections::BTreeMap;

use super::blocks::{Blocks, Z_UNIT};
use crate::date::utc;
use crate::input::Kind;
use crate::{Input, latin1};

/// Fields by block and offset.
const FIELDS: [(u16, usize, &str, Kind); 31] = [
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
    (0x0072, 8, "measurement time in s", Kind::U32),
    (0x0074, 0, "DLL version 1", Kind::U32),
    (0x0074, 4, "DLL version 2", Kind::U32),
    (0x0075, 4, "drift correction applied", Kind::U32),
    (0x0077, 0, "parameter set", Kind::Text(usize::MAX)),
    (0x007a, 0, "measuring rate", Kind::U32),
    (0x007a, 4, "minimum intensity", Kind::U32),
    (0x007b, 0, "sensor subtype", Kind::U32),
    (0x007f, 0, "calibration", Kind::Text(255)),
    (0x0090, 0, "despiked", Kind::U32),
    (0x0090, 12, "filtered", Kind::U32),
    (0x0095, 0, "thickness mode", Kind::U32),
    (0x0095, 8, "refractive index", Kind::F64),
    (0x009b, 0, "roundness", Kind::U32),
    (0x00a9, 0, "x axis subtracted", Kind::U32),
    (0x00a9, 4, "y axis subtracted", Kind::U32),
];

/// Seconds since 1970-01-01 by block and offset; 0 and all bits set mean unknown.
const TIMES: [(u16, usize, &str); 2] = [(0x0072, 0, "measurement started"), (0x0072, 4, "measurement ended")];
/// Texts after their lengths as u32, by block and the number of other such texts before.
const TEXTS: [(u16, usize, &str); 4] =
    [(0x008e, 0, "serial number"), (0x00a6, 0, "objective"), (0x00ac, 0, "user name"), (0x00ac, 1, "user description")];

/// Returns the fields that are present. Fields beyond the end of a block are left out.
pub(super) fn metadata(blocks: &Blocks) -> BTreeMap<String, String> {
    let field = |&(tag, offset, name, kind): &(u16, usize, &str, Kind)| {
        let block = blocks.get(&tag)?;
        let left = block.len().checked_sub(offset)?;
        let kind = if let Kind::Text(length) = kind { Kind::Text(length.min(left)) } else { kind };
        Some((name.to_owned(), block.value(name, offset, kind).ok()?))
    };
    let time = |&(tag, offset, name): &(u16, usize, &str)| {
        let seconds = blocks.get(&tag)?.u32(name, offset).ok().filter(|&seconds| seconds != 0 && seconds != u32::MAX);
        Some((name.to_owned(), utc(seconds?)))
    };
    let text = |&(tag, before, name): &(u16, usize, &str)| {
        let block = blocks.get(&tag)?;
        let start = (0..before).try_fold(0, |at, _| Some(at + 4 + counted(block, name, at)?.len()))?;
        Some((name.to_owned(), latin1(counted(block, name, start)?)))
    };
    let unit = blocks.get(&Z_UNIT).and_then(z_unit).map(|unit| ("z unit".to_owned(), unit));
    let fields = FIELDS.iter().filter_map(field).chain(TIMES.iter().filter_map(time));
    fields.chain(TEXTS.iter().filter_map(text)).chain(unit).collect()
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
