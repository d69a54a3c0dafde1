//! Messages on chunked data: division into chunks, and filters.

use super::Piece;
use crate::{Result, refuse_if};

/// Maximum number of filters of a dataset: each of the three once.
const MAX_FILTERS: u8 = 3;

/// Division of a dataset into chunks.
pub(super) struct Chunks {
    /// Number of elements of a chunk along each dimension.
    pub(super) shape: Vec<usize>,
    pub(super) element_bytes: usize,
    pub(super) index: Index,
}

/// Index of the chunks; `None` if no chunk was written.
pub(super) enum Index {
    Tree(Option<usize>),
    /// A single chunk, its size after filters (`None`: the unpacked size) and the filters that it skips.
    Single {
        address: Option<usize>,
        bytes: Option<usize>,
        skipped: u32,
    },
}

/// Filter that was applied when chunks were written.
#[derive(Clone, Copy)]
pub(super) enum Filter {
    Deflate,
    /// Grouping of bytes by their place in the elements.
    Shuffle,
    Fletcher32,
}

/// Reads the part of a layout message after its class.
pub(super) fn layout(mut message: Piece, version: u8) -> Result<Chunks> {
    let flags = if version == 4 { message.u8("flags")? } else { 0 };
    let rank_at = message.at();
    // The last dimension is the size of an element.
    let rank = usize::from(message.u8("dimensions")?);
    refuse_if!(!(2..=33).contains(&rank), message.wrong("dimensions", rank_at, rank, "2 to 33"));
    let tree = if version == 3 { Some(Index::Tree(message.optional_address("address")?)) } else { None };
    let width = if version == 3 { 4 } else { usize::from(message.u8("width of sizes")?.min(8)) };
    let mut shape = (0..rank).map(|_| message.size("chunk size", width)).collect::<Result<Vec<_>, _>>()?;
    let element_bytes = shape.pop().unwrap_or_default();
    if element_bytes == 0 || shape.contains(&0) {
        return Err(message.wrong("chunk size", rank_at, 0, "1 or more along each dimension"));
    }
    let index = match tree {
        Some(tree) => tree,
        None => newer_index(&mut message, flags)?,
    };
    Ok(Chunks { shape, element_bytes, index })
}

/// Reads the index of a version 4 layout.
fn newer_index(message: &mut Piece, flags: u8) -> Result<Index> {
    let name = match message.u8("kind of index")? {
        1 => {
            let is_filtered = flags & 2 != 0;
            let bytes = if is_filtered { Some(message.size("filtered size", 8)?) } else { None };
            let skipped = if is_filtered { message.u32("filter mask")? } else { 0 };
            return Ok(Index::Single { address: message.optional_address("address")?, bytes, skipped });
        }
        2 => "no index",
        3 => "a fixed array",
        4 => "an extensible array",
        5 => "a version 2 B-tree",
        _ => "an unknown index",
    };
    Err(message.unsupported(
        format!("chunks under {name}"),
        "chunks under a version 1 B-tree; or contiguous data, which `h5repack -l CONTI OLD NEW` of the HDF5 tools writes",
    ))
}

/// Reads the filters of a pipeline message.
pub(super) fn filters(mut message: Piece) -> Result<Vec<Filter>> {
    let version = message.version(&[1, 2])?;
    let count_at = message.at();
    let count = message.u8("number of filters")?;
    if count > MAX_FILTERS {
        return Err(message.wrong("number of filters", count_at, count, &format!("at most {MAX_FILTERS}")));
    }
    if version == 1 {
        message.skip("reserved", 6)?;
    }
    let mut filters = Vec::new();
    for _ in 0..count {
        let filter = match message.u16("filter")? {
            1 => Filter::Deflate,
            2 => Filter::Shuffle,
            3 => Filter::Fletcher32,
            other => {
                let name = match other {
                    4 => "szip",
                    5 => "n-bit",
                    6 => "scale-offset",
                    _ => "not known",
                };
                return Err(message.unsupported(
                    format!("filter {other} ({name})"),
                    "data without compression, or with deflate, shuffle, Fletcher-32",
                ));
            }
        };
        // Version 2 stores no names of known filters.
        let name_bytes = if version == 1 { usize::from(message.u16("length of the name")?) } else { 0 };
        message.skip("flags", 2)?;
        let values = usize::from(message.u16("number of values")?);
        message.skip("name", if version == 1 { name_bytes.next_multiple_of(8) } else { 0 })?;
        let padding = if version == 1 { values % 2 } else { 0 };
        message.skip("values", 4 * (values + padding))?;
        filters.push(filter);
    }
    Ok(filters)
}
