//! HDF5 containers as far as instrument files use them, read from untrusted bytes without copying them.
//!
//! Read are: superblocks of version 0 to 3 with 8-byte addresses; object headers of version 1 and 2; groups as symbol
//! tables, link messages and dense links; attributes in the header and in a fractal heap; numbers, texts, compounds,
//! arrays and variable-length values in the global heap; data that are compact, contiguous, one chunk, or chunks under a
//! version 1 B-tree, with deflate, shuffle and Fletcher-32. Soft and external links are passed over. The rest is refused
//! by name: chunk indices of HDF5 1.10 and later, other filters, shared messages beyond committed datatypes.
//!
//! Structures refer to each other by address, so a small file can describe a large or an endless one. Every byte of a
//! structure that is looked at counts against a budget of the file ([`WORK_BYTES`]): a loop, or a piece that is shared
//! too often, ends as an error. Names, texts and data are slices of the file until they are copied for good. Checksums
//! of structures are not verified; wrong fields are found by their values.
//!
//! Layout: HDF5 File Format Specification, version 3.0.

mod chunks;
mod dataset;
mod datatype;
mod group;
mod header;
mod heap;
mod piece;
mod tree;
mod value;

use crate::error::Result;
use std::cell::Cell;

pub(crate) use dataset::Dataset;
pub(crate) use header::Object;
pub(crate) use value::{Attribute, Value, shown_name, shown_number};

use crate::Format;
use crate::input::Input;
use piece::Piece;

/// First bytes of every file.
const SIGNATURE: &[u8] = b"\x89HDF\r\n\x1a\n";

/// Bytes of structures that any file may make its reader look at; its own size comes on top, [`WORK_RATIO`] times.
const WORK_BYTES: u64 = 1 << 26;
/// How often the structures of a file may be looked at: a few look-ups pass over the same header or heap.
const WORK_RATIO: u64 = 4;
/// The least that looking at a structure costs, however small it is.
const LEAST_WORK: usize = 64;
/// Messages, links or attributes that one object may have; version 1 counts its messages in 16 bits.
const MAX_ENTRIES: usize = 1 << 16;

/// An HDF5 file.
pub(crate) struct File<'a> {
    input: Input<'a>,
    /// Where the header of the root group starts.
    root: usize,
    /// Bytes of structures that may still be looked at.
    work: Cell<u64>,
}

impl<'a> File<'a> {
    /// Opens a file whose superblock is at its start.
    ///
    /// # Errors
    /// Other versions, addresses of other than 8 bytes, and a start of the address space elsewhere.
    pub(crate) fn open(format: Format, bytes: &'a [u8]) -> Result<Self> {
        let input = Input::new(format, bytes);
        let budget = WORK_BYTES.saturating_add((bytes.len() as u64).saturating_mul(WORK_RATIO));
        let mut file = Self { input, root: 0, work: Cell::new(budget) };
        let mut block = file.piece("superblock", 0, bytes.len().min(96))?;
        block.expect("signature", SIGNATURE)?;
        let version = block.version(&[0, 1, 2, 3])?;
        if version < 2 {
            // Versions of free space, root entry, and shared messages; two bytes are reserved.
            block.skip("versions", 4)?;
        }
        for field in ["size of offsets", "size of lengths"] {
            let at = block.at();
            let size = block.u8(field)?;
            if size != 8 {
                return Err(file.input.unsupported(format!("the {field} (byte {at}) is {size}"), "8 bytes"));
            }
        }
        match version {
            // A reserved byte, the ranks of the group trees, and flags.
            0 => block.skip("group ranks", 9)?,
            // The rank of the chunk trees and two reserved bytes as well.
            1 => block.skip("group ranks", 13)?,
            _ => block.skip("flags", 1)?,
        }
        let at = block.at();
        let base = block.u64("base address")?;
        if base != 0 {
            return Err(file.input.wrong("base address", at, base, "0"));
        }
        // Free space or extension, and end of file; in old versions also the driver and the name of the root.
        block.skip("addresses", if version < 2 { 4 * 8 } else { 2 * 8 })?;
        file.root = block.address("address of the root group")?;
        Ok(file)
    }

    /// Whether the file starts as HDF5.
    pub(crate) fn is_one(bytes: &[u8]) -> bool {
        bytes.starts_with(SIGNATURE)
    }

    /// The names in the root.
    pub(crate) fn names(&self) -> Result<Vec<&'a [u8]>> {
        let root = self.object(self.root)?;
        Ok(self.links(&root)?.iter().map(|link| link.name).collect())
    }

    /// The object under a path from the root, `None` where there is none.
    pub(crate) fn find(&self, path: &str) -> Result<Option<Object>> {
        let mut object = self.object(self.root)?;
        for name in path.split('/').filter(|name| !name.is_empty()) {
            match self.links(&object)?.iter().find(|link| link.name == name.as_bytes()) {
                Some(link) => object = self.object(link.address)?,
                None => return Ok(None),
            }
        }
        Ok(Some(object))
    }

    /// Reads something that may be left out: it gets a quarter of the work that is left.
    pub(crate) fn aside<T>(&self, read: impl FnOnce() -> Result<T>) -> Option<T> {
        let share = self.work.get() / 4;
        let rest = self.work.replace(share) - share;
        let found = read().ok();
        self.work.set(rest + self.work.get());
        found
    }

    /// `length` bytes of a structure; they count as work.
    fn piece(&self, name: &'static str, at: usize, length: usize) -> Result<Piece<'a>> {
        self.charge(name, at, length)?;
        Piece::new(self.input, name, at, length)
    }

    /// Counts the bytes of a structure that is looked at.
    fn charge(&self, name: &str, at: usize, length: usize) -> Result<()> {
        let work = length.max(LEAST_WORK) as u64;
        let found = "a structure that refers to itself or is shared too often";
        let left = self.work.get().checked_sub(work);
        self.work.set(left.ok_or_else(|| self.input.wrong(name, at, found, "a tree of structures"))?);
        Ok(())
    }
}
