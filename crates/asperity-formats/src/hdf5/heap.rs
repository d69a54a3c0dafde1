//! Heaps: local (names of a symbol table), global (variable-length values) and fractal (dense links and attributes).

use super::tree::width;
use super::{File, Piece};
use crate::{Result, refuse_if};

/// Maximum size of a name in bytes.
const MAX_NAME_BYTES: usize = 4096;
/// Maximum number of nested indirect blocks. A heap of 2⁴⁰ bytes has four.
const MAX_BLOCK_DEPTH: usize = 8;

/// Names of a symbol table.
pub(super) struct LocalHeap {
    start: usize,
    length: usize,
}

/// Heap of small objects in blocks whose sizes double from row to row.
pub(super) struct FractalHeap {
    /// Size in bytes of an offset into the heap.
    offset_bytes: usize,
    /// Size in bytes of the length of an object.
    length_bytes: usize,
    /// Number of blocks in a row.
    width: u64,
    first_block_bytes: u64,
    /// Number of rows of direct blocks at the start of an indirect block.
    direct_rows: u64,
    root: Option<usize>,
    /// Number of rows of the root if it is an indirect block, 0 if it is a direct block.
    root_rows: u64,
}

impl<'a> File<'a> {
    pub(super) fn local_heap(&self, at: usize) -> Result<LocalHeap> {
        let mut heap = self.piece("local heap", at, 32)?;
        heap.expect("signature", b"HEAP")?;
        heap.version(&[0])?;
        heap.skip("reserved", 3)?;
        let length = heap.size("size", 8)?;
        heap.skip("free list", 8)?;
        Ok(LocalHeap { start: heap.address("address")?, length })
    }

    /// Returns the name at an offset into the heap.
    pub(super) fn name(&self, heap: &LocalHeap, offset: usize) -> Result<&'a [u8]> {
        let end = heap.length.min(self.input.len().saturating_sub(heap.start));
        let length = end.saturating_sub(offset).min(MAX_NAME_BYTES);
        let at = heap.start.saturating_add(offset);
        let rest = self.input.take("name in a local heap", at, length)?;
        let name = rest.iter().position(|&byte| byte == 0).map_or(rest, |length| &rest[..length]);
        self.charge("local heap", at, name.len())?;
        Ok(name)
    }

    /// Returns an object of a global heap; `None` if it does not exist.
    pub(super) fn global(&self, at: usize, wanted: u32) -> Result<Option<&'a [u8]>> {
        let mut head = self.piece("global heap", at, 16)?;
        head.expect("signature", b"GCOL")?;
        head.version(&[1])?;
        head.skip("reserved", 3)?;
        let end = at.saturating_add(head.size("size", 8)?).min(self.input.len());
        let (mut next, mut found) = (at + 16, None);
        let mut passed = 0_usize;
        while found.is_none() && next.saturating_add(16) <= end {
            let mut object = Piece::new(self.input, "global heap", next, 16)?;
            passed += 16;
            let index = object.u16("index")?;
            object.skip("counts", 6)?;
            let length = object.size("object size", 8)?;
            // Index 0 is the free space at the end.
            if index == 0 {
                break;
            }
            if u32::from(index) == wanted {
                found = Some(self.input.take("object of the global heap", next + 16, length)?);
                passed = passed.saturating_add(length);
            }
            next = next.saturating_add(16).saturating_add(length.checked_next_multiple_of(8).unwrap_or(usize::MAX));
        }
        self.charge("global heap", at, passed)?;
        Ok(found)
    }

    pub(super) fn fractal_heap(&self, at: usize) -> Result<FractalHeap> {
        let mut heap = self.piece("fractal heap", at, 142)?;
        heap.expect("signature", b"FRHP")?;
        heap.version(&[0])?;
        heap.skip("size of identifiers", 2)?;
        if heap.u16("size of filters")? != 0 {
            return Err(heap.unsupported("a filtered heap of links or attributes", "one without filters"));
        }
        heap.skip("flags", 1)?;
        let largest_object = u64::from(heap.u32("size of managed objects")?);
        // Huge objects: next number and tree; free space: amount and address; managed space: bytes, allocated bytes,
        // iterator, number of objects; huge objects: bytes and number; tiny objects: bytes and number.
        heap.skip("counts", 12 * 8)?;
        let place = heap.at();
        let width_of_table = u64::from(heap.u16("width of the table")?);
        let first_block_bytes = heap.u64("size of the first block")?;
        let largest_block_bytes = heap.u64("size of the largest block")?;
        let bits = usize::from(heap.u16("size of the heap in bits")?);
        heap.skip("rows", 2)?;
        let root = heap.optional_address("root block")?;
        let root_rows = u64::from(heap.u16("rows of the root")?);
        let is_size = |bytes: u64| bytes.is_power_of_two() && bytes < 1 << 32;
        if !(is_size(first_block_bytes)
            && is_size(largest_block_bytes)
            && first_block_bytes <= largest_block_bytes
            && width_of_table.is_power_of_two()
            && (1..=64).contains(&bits))
        {
            return Err(heap.wrong("table of blocks", place, "an inconsistent table", "powers of two below 2^32"));
        }
        let longest = usize::try_from(largest_block_bytes.ilog2().div_ceil(8)).unwrap_or(4);
        Ok(FractalHeap {
            offset_bytes: bits.div_ceil(8),
            length_bytes: longest.min(width(largest_object)),
            width: width_of_table,
            first_block_bytes,
            direct_rows: u64::from(largest_block_bytes.ilog2() - first_block_bytes.ilog2()) + 2,
            root,
            root_rows,
        })
    }

    /// Returns the object of an identifier; `None` for huge and tiny objects, which links never are and attributes
    /// rarely are.
    pub(super) fn managed(&self, heap: &FractalHeap, mut id: Piece<'a>) -> Result<Option<Piece<'a>>> {
        let id_at = id.at();
        // Bits 4 and 5 distinguish managed, huge and tiny objects.
        if id.u8("kind")? & 0x30 != 0 {
            return Ok(None);
        }
        let mut offset = id.number("offset", heap.offset_bytes)?;
        let length = id.size("length", heap.length_bytes)?;
        let Some(mut block) = heap.root else { return Ok(None) };
        let mut rows = heap.root_rows;
        let mut block_bytes = heap.first_block_bytes;
        for _ in 0..MAX_BLOCK_DEPTH {
            if rows == 0 {
                // Offsets count from the start of a direct block, including its head.
                let inside = offset.checked_add(length as u64).is_some_and(|end| end <= block_bytes);
                let start = usize::try_from(offset).ok().and_then(|offset| block.checked_add(offset));
                return match start.filter(|_| inside) {
                    Some(start) => self.piece("fractal heap object", start, length).map(Some),
                    None => Err(id.wrong("place", id_at, offset, "a place in the heap")),
                };
            }
            let (row, bytes) = heap.row(offset);
            let column = offset.saturating_sub(heap.row_start(row)) / bytes;
            refuse_if!(row >= rows, id.wrong("place", id_at, offset, "a place in the heap"));
            offset -= heap.row_start(row) + column * bytes;
            // Signature, version, address of the heap, offset of the block; then one address per block.
            let head = 4 + 1 + 8 + heap.offset_bytes;
            let mut indirect = self.piece("indirect block", block, head)?;
            indirect.expect("signature", b"FHIB")?;
            let entry = usize::try_from((row * heap.width + column) * 8).unwrap_or(usize::MAX);
            let place = block.saturating_add(head).saturating_add(entry);
            block = self.piece("indirect block", place, 8)?.address("address of a block")?;
            // A child of an indirect row covers the size of its row, with a table of its own.
            let is_direct = row < heap.direct_rows;
            rows = if is_direct { 0 } else { heap.rows_of_child(bytes) };
            block_bytes = bytes;
        }
        Err(id.wrong("place", id_at, offset, "a place in the heap"))
    }
}

impl FractalHeap {
    /// Returns the row of an offset, and the size of each of its blocks in bytes.
    ///
    /// The first two rows have blocks of the first size. From the third row on sizes double.
    fn row(&self, offset: u64) -> (u64, u64) {
        let in_first_rows = offset / (self.first_block_bytes * self.width);
        match in_first_rows.checked_ilog2() {
            None => (0, self.first_block_bytes),
            Some(doublings) => {
                (u64::from(doublings) + 1, self.first_block_bytes.saturating_mul(1 << doublings.min(62)))
            }
        }
    }

    /// Returns the offset of the start of a row.
    fn row_start(&self, row: u64) -> u64 {
        let first = self.first_block_bytes * self.width;
        match row.checked_sub(1) {
            None => 0,
            Some(doublings) => first.saturating_mul(1 << doublings.min(62)),
        }
    }

    /// Returns the number of rows of the indirect block of a place of `bytes` bytes.
    fn rows_of_child(&self, bytes: u64) -> u64 {
        u64::from(bytes.ilog2().saturating_sub((self.first_block_bytes * self.width).ilog2())) + 1
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn rows_of_blocks_double_from_the_third_on() {
        let heap = FractalHeap {
            offset_bytes: 5,
            length_bytes: 2,
            width: 4,
            first_block_bytes: 512,
            direct_rows: 9,
            root: None,
            root_rows: 0,
        };
        // Rows of four blocks of 512, 512, 1024, 2048, … bytes.
        let mut start = 0;
        for (row, bytes) in (0..12).zip([512].into_iter().chain((0..).map(|doublings| 512 << doublings))) {
            assert_eq!((heap.row_start(row), heap.row(start)), (start, (row, bytes)));
            start += 4 * bytes;
            assert_eq!(heap.row(start - 1), (row, bytes));
        }
        // The rows of a child cover the size of its place.
        let (row, bytes) = heap.row(start);
        assert_eq!(heap.row_start(heap.rows_of_child(bytes)), bytes, "row {row}");
    }
}
