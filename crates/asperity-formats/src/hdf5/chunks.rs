//! Assembly of chunked data, and their filters.

use std::borrow::Cow;
use std::io::Read;

use flate2::read::ZlibDecoder;

use super::layout::{Chunks, Filter, Index};
use super::{Dataset, File, Keys};
use crate::archive::{damage, damaged};
use crate::{Result, refuse_if};

/// Size in bytes that the chunks of every file may unpack to: a map of 2048 × 1024 as `f64`.
const FREE_BYTES: usize = 1 << 24;
/// Above [`FREE_BYTES`], maximum ratio of unpacked size to file size. Maps of instruments reach 2 to 20.
const MAX_RATIO: usize = 64;
/// Minimum size of an element in bytes for the limit: numbers become `f64`.
const LEAST_ELEMENT_BYTES: usize = 8;

/// Stored bytes of a chunk.
struct Stored<'a> {
    at: usize,
    bytes: &'a [u8],
    /// Bit mask of the filters that were not applied.
    skipped: u32,
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
        refuse_if!(unpacked > limit, self.input.too_large("the number of bytes in chunks", 0, unpacked, limit));
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
        let broken = |reason: String| damaged(self.input.format, &format!("the chunk at byte {}", stored.at), reason);
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
