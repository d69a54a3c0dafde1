//! File with the budget of its structures.

use std::cell::Cell;

use super::Piece;
use crate::{Format, Input, Result, refuse_if};

/// First bytes of every file.
const SIGNATURE: &[u8] = b"\x89HDF\r\n\x1a\n";
/// Budget of any file: bytes of structures that its reader may read. [`WORK_RATIO`] times the size of the file is
/// added.
const WORK_BYTES: u64 = 1 << 26;
/// Number of times that the structures of a file may be read: several look-ups read the same header or heap.
const WORK_RATIO: u64 = 4;
/// Minimum cost of a structure in bytes.
const LEAST_WORK: usize = 64;
/// Maximum number of messages, links or attributes of one object. Version 1 counts its messages in 16 bits.
pub(super) const MAX_ENTRIES: usize = 1 << 16;

/// HDF5 file.
pub(crate) struct File<'a> {
    pub(super) input: Input<'a>,
    /// Offset of the header of the root group.
    pub(super) root: usize,
    /// Remaining budget in bytes of structures.
    work: Cell<u64>,
}

impl<'a> File<'a> {
    /// Opens a file whose superblock is at its start.
    ///
    /// # Errors
    /// Other versions, addresses of other than 8 bytes, and a base address other than 0.
    pub(crate) fn open(format: Format, bytes: &'a [u8]) -> Result<Self> {
        let input = Input::new(format, bytes);
        let budget = WORK_BYTES.saturating_add((bytes.len() as u64).saturating_mul(WORK_RATIO));
        let mut file = Self { input, root: 0, work: Cell::new(budget) };
        let mut block = file.piece("superblock", 0, bytes.len().min(96))?;
        block.expect("signature", SIGNATURE)?;
        let version = block.version(&[0, 1, 2, 3])?;
        if version < 2 {
            // Versions of free space, root entry and shared messages, and two reserved bytes.
            block.skip("versions", 4)?;
        }
        for field in ["size of offsets", "size of lengths"] {
            let at = block.at();
            let size = block.u8(field)?;
            refuse_if!(size != 8, file.input.unsupported(format!("the {field} (byte {at}) is {size}"), "8 bytes"));
        }
        match version {
            // A reserved byte, the ranks of the group trees, and flags.
            0 => block.skip("group ranks", 9)?,
            // The same, the rank of the chunk trees and two reserved bytes.
            1 => block.skip("group ranks", 13)?,
            _ => block.skip("flags", 1)?,
        }
        let at = block.at();
        let base = block.u64("base address")?;
        refuse_if!(base != 0, file.input.wrong("base address", at, base, "0"));
        // Free space or extension, and end of file; in old versions also the driver and the name of the root.
        block.skip("addresses", if version < 2 { 4 * 8 } else { 2 * 8 })?;
        file.root = block.address("address of the root group")?;
        Ok(file)
    }

    /// Returns whether the bytes start as HDF5.
    pub(crate) fn is_one(bytes: &[u8]) -> bool {
        bytes.starts_with(SIGNATURE)
    }

    /// Reads an optional part of the file with a quarter of the remaining budget.
    pub(crate) fn optional<T>(&self, read: impl FnOnce() -> Result<T>) -> Option<T> {
        let share = self.work.get() / 4;
        let rest = self.work.replace(share) - share;
        let found = read().ok();
        self.work.set(rest + self.work.get());
        found
    }

    /// Returns `length` bytes of a structure and charges them to the budget.
    pub(super) fn piece(&self, name: &'static str, at: usize, length: usize) -> Result<Piece<'a>> {
        self.charge(name, at, length)?;
        Piece::new(self.input, name, at, length)
    }

    /// Charges the bytes of a structure to the budget.
    pub(super) fn charge(&self, name: &str, at: usize, length: usize) -> Result<()> {
        let work = length.max(LEAST_WORK) as u64;
        let found = "a structure that refers to itself or is shared too often";
        let left = self.work.get().checked_sub(work);
        self.work.set(left.ok_or_else(|| self.input.wrong(name, at, found, "a tree of structures"))?);
        Ok(())
    }
    /// Checks the number of messages, links or attributes of an object.
    pub(super) fn check_count(&self, field: &str, at: usize, count: usize) -> Result<()> {
        let is_allowed = count <= MAX_ENTRIES;
        if is_allowed { Ok(()) } else { Err(self.input.too_large(field, at, count, MAX_ENTRIES)) }
    }
}
