//! Blocks of an FRT file.

use std::collections::BTreeMap;

use crate::{Input, Result, warn_if};

/// First bytes of every file, before the version.
pub(super) const SIGNATURE: &[u8] = b"FRTM_GLIDERV";
/// Size in bytes of the version, such as `1.00`.
pub(super) const VERSION_BYTES: usize = 4;
/// Offset of the number of blocks, before the first block.
pub(super) const BLOCK_COUNT: usize = SIGNATURE.len() + VERSION_BYTES;
pub(super) const CURRENT_IMAGE: u16 = 0x000b;
pub(super) const IMAGE_SIZE: u16 = 0x0066;
pub(super) const SCAN_SIZE: u16 = 0x0067;
pub(super) const SENSOR: u16 = 0x006c;
pub(super) const VALID_VALUES: u16 = 0x0070;
pub(super) const IMAGES: u16 = 0x007d;
pub(super) const ROUNDNESS: u16 = 0x009b;
pub(super) const Z_UNIT: u16 = 0x009f;
pub(super) const BUFFERS: u16 = 0x00ab;

/// Tags whose blocks must be unique, because they define the heights.
const ONCE: [u16; 5] = [CURRENT_IMAGE, IMAGE_SIZE, SCAN_SIZE, SENSOR, IMAGES];

/// Blocks of a file by tag.
pub(super) type Blocks<'a> = BTreeMap<u16, Input<'a>>;

/// Returns all blocks up to the end of the file.
pub(super) fn blocks<'a>(input: Input<'a>, size_bytes: usize, warnings: &mut Vec<String>) -> Result<Blocks<'a>> {
    let mut blocks = Blocks::new();
    let mut place = BLOCK_COUNT + 2;
    let mut found = 0;
    while place + 2 + size_bytes <= input.len() {
        let tag = input.u16("a block's tag", place)?;
        let field = format!("the size of block {tag:#06x}");
        let size = match size_bytes {
            4 => input.u32(&field, place + 2)?.into(),
            _ => input.u64(&field, place + 2)?,
        };
        let start = place + 2 + size_bytes;
        let size = usize::try_from(size).unwrap_or(usize::MAX);
        let end = start + input.take(&format!("the bytes of block {tag:#06x}"), start, size)?.len();
        if blocks.contains_key(&tag) && ONCE.contains(&tag) {
            return Err(input.wrong("a block's tag", place, format!("{tag:#06x}"), "a tag that did not occur yet"));
        }
        blocks.entry(tag).or_insert(input.up_to(end).from(start));
        found += 1;
        place = end;
    }
    warn_if!(warnings, place < input.len(), "{} bytes after the last block were left out", input.len() - place);
    let stated = input.u16("the number of blocks", BLOCK_COUNT)?;
    warn_if!(warnings, found != usize::from(stated), "the file states {stated} blocks and holds {found}");
    Ok(blocks)
}
