//! Chunked data: index of the chunks, filters, and assembly.

use crate::error::Result;
use std::borrow::Cow;
use std::io::Read;

use flate2::read::ZlibDecoder;

use super::piece::Piece;
use super::tree::Keys;
use super::{Dataset, File};
use crate::archive::{damage, damaged};

/// Size in bytes that the chunks of every file may unpack to: a map of 2048 × 1024 as `f64`.
const FREE_BYTES: usize = 1 << 24;
/// Above [`FREE_BYTES`], maximum ratio of unpacked size to file size. Maps of instruments reach 2 to 20.
const MAX_RATIO: usize = 64;
/// Minimum size of an element in bytes for the limit: numbers become `f64`.
const LEAST_ELEMENT_BYTES: usize = 8;

/// Maximum number of filters of a dataset: each of the three once.
const MAX_FILTERS: u8 = 3;

/// Division of a dataset into chunks.
pub(super) struct Chunks {
    /// Number of elements of a chunk along each dimension.
    shape: Vec<usize>,
    element_bytes: usize,
    index: Index,
}

/// Index of the chunks; `None` if no chunk was written.
enum Index {
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

/// Stored bytes of a chunk.
struct Stored<'a> {
    at: usize,
    bytes: &'a [u8],
    /// Bit mask of the filters that were not applied.
    skipped: u32,
}

/// Reads the part of a layout message after its class.
pub(super) fn layout(mut message: Piece, version: u8) -> Result<Chunks> {
    let flags = if version == 4 { message.u8("flags")? } else { 0 };
    let rank_at = message.at();
    // The last dimension is the size of an element.
    let rank = usize::from(message.u8("dimensions")?);
    if !(2..=33).contains(&rank) {
        return Err(message.wrong("dimensions", rank_at, rank, "2 to 33"));
    }
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

impl<'a> File<'a> {
    /// Assembles the chunks of a dataset.
    ///
    /// # Errors
    /// More elements than the size of the file allows; chunks that are damaged, off their grid or present twice.
    pub(super) fn unpack(&self, dataset: &Dataset<'a>, chunks: &Chunks) -> Result<Vec<u8>> {
        let element_bytes = dataset.datatype.bytes;
        let grid = Grid::new(chunks, &dataset.shape).ok_or_else(|| {
            let found = format!("chunks of {} dimensions", chunks.shape.len());
            self.input.unsupported(found, "chunks of two dimensions")
        })?;
        if chunks.element_bytes != element_bytes {
            let wanted = "the size of the datatype";
            return Err(self.input.wrong("chunk, size of an element", 0, chunks.element_bytes, wanted));
        }
        let limit = FREE_BYTES.max(self.input.len().saturating_mul(MAX_RATIO));
        let unpacked = grid.padded_elements().saturating_mul(element_bytes.max(LEAST_ELEMENT_BYTES));
        if unpacked > limit {
            return Err(self.input.too_large("the number of bytes in chunks", 0, unpacked, limit));
        }
        let count = grid.rows * grid.columns;
        let mut data = dataset.fill.map_or_else(|| vec![0; count * element_bytes], |fill| fill.repeat(count));
        let mut is_done = vec![false; grid.down * grid.across];
        let chunk_bytes = grid.chunk_rows.saturating_mul(grid.chunk_columns).saturating_mul(element_bytes);
        let mut place = |number: usize, stored: Stored| {
            let at = stored.at;
            self.charge("chunk", at, stored.bytes.len())?;
            match is_done.get_mut(number) {
                Some(done) if !*done => *done = true,
                _ => return Err(self.input.wrong("chunk, place", at, number, "a place of its own")),
            }
            let unpacked = self.unfiltered(&stored, &dataset.filters, chunk_bytes, element_bytes)?;
            grid.copy(number, &unpacked, element_bytes, &mut data);
            Ok(())
        };
        match chunks.index {
            Index::Single { address: Some(at), bytes, skipped } => {
                let bytes = self.input.take("chunk", at, bytes.unwrap_or(chunk_bytes))?;
                place(0, Stored { at, bytes, skipped })?;
            }
            Index::Tree(Some(root)) => {
                let keys = Keys { kind: 1, bytes: 8 + 8 * (chunks.shape.len() + 1) };
                self.visit_tree(root, keys, &mut |mut key, at| {
                    let length = key.size("chunk size", 4)?;
                    let skipped = key.u32("filter mask")?;
                    let offset_at = key.at();
                    let offsets: Result<Vec<_>, _> = chunks.shape.iter().map(|_| key.size("chunk offset", 8)).collect();
                    let number = grid.number(&offsets?).ok_or_else(|| {
                        key.wrong("chunk offset", offset_at, "off the grid", "a multiple of the chunk size in the data")
                    })?;
                    place(number, Stored { at, bytes: self.input.take("chunk", at, length)?, skipped })
                })?;
            }
            _ => (),
        }
        Ok(data)
    }

    /// Undoes the filters of a chunk.
    fn unfiltered(
        &self,
        stored: &Stored<'a>,
        filters: &[Filter],
        chunk_bytes: usize,
        element_bytes: usize,
    ) -> Result<Cow<'a, [u8]>> {
        let broken = |reason: String| damaged(self.input.format(), &format!("the chunk at byte {}", stored.at), reason);
        let mut bytes = Cow::Borrowed(stored.bytes);
        for (place, filter) in filters.iter().enumerate().rev() {
            if stored.skipped >> place.min(31) & 1 == 1 {
                continue;
            }
            bytes = match filter {
                Filter::Deflate => {
                    // A checksum may follow the data.
                    let mut unpacked = Vec::with_capacity(chunk_bytes.min(bytes.len().saturating_mul(1032)));
                    let limit = chunk_bytes as u64 + 4;
                    ZlibDecoder::new(bytes.as_ref())
                        .take(limit)
                        .read_to_end(&mut unpacked)
                        .map_err(|error| broken(damage(&error)))?;
                    Cow::Owned(unpacked)
                }
                Filter::Shuffle => Cow::Owned(unshuffled(&bytes, element_bytes)),
                Filter::Fletcher32 => {
                    let Some((data, stated)) = bytes.split_last_chunk() else {
                        return Err(broken("there is no room for a checksum".into()));
                    };
                    if fletcher32(data) != u32::from_le_bytes(*stated) {
                        return Err(broken("the Fletcher-32 checksum does not fit".into()));
                    }
                    Cow::Owned(data.to_vec())
                }
            };
        }
        if bytes.len() != chunk_bytes {
            return Err(broken(format!("it unpacks to {} bytes; wanted {chunk_bytes}", bytes.len())));
        }
        Ok(bytes)
    }
}

/// Map and the grid of chunks that covers it.
struct Grid {
    rows: usize,
    columns: usize,
    chunk_rows: usize,
    chunk_columns: usize,
    /// Number of chunks per column and per row of the map.
    down: usize,
    across: usize,
}

impl Grid {
    /// Creates the grid. Missing dimensions count as 1. Returns `None` if dimensions before the last two exceed 1.
    fn new(chunks: &Chunks, shape: &[usize]) -> Option<Self> {
        if shape.len() != chunks.shape.len() {
            return None;
        }
        let (rows, columns) = last_two(shape, 1)?;
        let (chunk_rows, chunk_columns) = last_two(&chunks.shape, 1)?;
        let (down, across) = (rows.div_ceil(chunk_rows), columns.div_ceil(chunk_columns));
        Some(Self { rows, columns, chunk_rows, chunk_columns, down, across })
    }

    /// Returns the number of elements of all chunks, including those beyond the edges of the map.
    fn padded_elements(&self) -> usize {
        let (height, width) =
            (self.down.saturating_mul(self.chunk_rows), self.across.saturating_mul(self.chunk_columns));
        height.saturating_mul(width)
    }

    /// Returns the number of the chunk whose first element has these coordinates.
    fn number(&self, offsets: &[usize]) -> Option<usize> {
        let (row, column) = match offsets {
            [column] => (0, *column),
            _ => last_two(offsets, 0)?,
        };
        let is_on_grid = row.is_multiple_of(self.chunk_rows) && column.is_multiple_of(self.chunk_columns);
        (is_on_grid && row < self.rows && column < self.columns)
            .then(|| row / self.chunk_rows * self.across + column / self.chunk_columns)
    }

    /// Copies the elements of a chunk that are within the map.
    fn copy(&self, number: usize, chunk: &[u8], element_bytes: usize, data: &mut [u8]) {
        let (top, left) = (number / self.across * self.chunk_rows, number % self.across * self.chunk_columns);
        let height = self.chunk_rows.min(self.rows - top);
        let width = self.chunk_columns.min(self.columns - left) * element_bytes;
        for (row, line) in chunk.chunks_exact(self.chunk_columns * element_bytes).take(height).enumerate() {
            let start = ((top + row) * self.columns + left) * element_bytes;
            data[start..start + width].copy_from_slice(&line[..width]);
        }
    }
}

/// Returns the last two numbers, with 1 for a missing one; `None` unless all other numbers equal `others`.
fn last_two(numbers: &[usize], others: usize) -> Option<(usize, usize)> {
    match *numbers {
        [last] => Some((1, last)),
        [ref before @ .., first, last] => before.iter().all(|&number| number == others).then_some((first, last)),
        [] => None,
    }
}

/// Undoes the shuffle filter. Surplus bytes that fill no element remain in place.
fn unshuffled(bytes: &[u8], element_bytes: usize) -> Vec<u8> {
    let count = bytes.len() / element_bytes;
    let mut together = bytes.to_vec();
    for (place, plane) in bytes.chunks_exact(count.max(1)).take(element_bytes).enumerate() {
        for (element, &byte) in plane.iter().enumerate() {
            together[element * element_bytes + place] = byte;
        }
    }
    together
}

/// Returns the checksum of J. G. Fletcher over big-endian words of 16 bits, modulo 2¹⁶ − 1.
fn fletcher32(bytes: &[u8]) -> u32 {
    let fold = |sum: u32| (sum & 0xffff) + (sum >> 16);
    let (mut first, mut second) = (0_u32, 0_u32);
    for word in bytes.chunks(2) {
        first = fold(first + (u32::from(word[0]) << 8 | u32::from(word.get(1).copied().unwrap_or(0))));
        second = fold(second + first);
    }
    fold(second) << 16 | fold(first)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn bytes_are_put_together_by_element() {
        // Elements 0x0102, 0x0304, 0x0506 and an odd byte.
        assert_eq!(unshuffled(&[1, 3, 5, 2, 4, 6, 9], 2), [1, 2, 3, 4, 5, 6, 9]);
        assert_eq!(unshuffled(&[1], 2), [1]);
        assert_eq!(unshuffled(&[], 2), []);
    }

    #[test]
    fn fletcher_sums_fit_the_published_examples() {
        // Published sums of `abcde`, `abcdef` and `abcdefgh` are for words with the low byte first.
        assert_eq!(fletcher32(b"badc\0e"), 0xf04f_c729);
        assert_eq!(fletcher32(b"badcfe"), 0x5650_2d2a);
        assert_eq!(fletcher32(b"badcfehg"), 0xebe1_9591);
        assert_eq!(fletcher32(b"ab\xff"), fletcher32(b"ab\xff\0"));
    }
}
