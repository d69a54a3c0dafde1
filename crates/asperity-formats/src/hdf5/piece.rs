//! Sequential reading of the fields of a structure.

use crate::{FormatError, Input, Result, refuse_if};

/// Address that marks an absent object.
const UNDEFINED: u64 = u64::MAX;

/// Unread part of a structure. Numbers are little-endian.
#[derive(Clone, Copy)]
pub(super) struct Piece<'a> {
    input: Input<'a>,
    name: &'static str,
    at: usize,
    end: usize,
}

impl<'a> Piece<'a> {
    /// Creates a piece of `length` bytes.
    ///
    /// # Errors
    /// [`FormatError::Truncated`] if the file ends early.
    pub(super) fn new(input: Input<'a>, name: &'static str, at: usize, length: usize) -> Result<Self> {
        input.take(name, at, length)?;
        Ok(Self { input, name, at, end: at + length })
    }

    /// Returns the offset of the next field in the file.
    pub(super) fn at(&self) -> usize {
        self.at
    }

    /// Returns the number of unread bytes.
    pub(super) fn left(&self) -> usize {
        self.end - self.at
    }

    pub(super) fn take(&mut self, field: &str, length: usize) -> Result<&'a [u8]> {
        if length > self.left() {
            let part = format!("{}, {field}:", self.name);
            return Err(self.input.up_to(self.end).truncated(&part, self.at, length));
        }
        let bytes = self.input.take(field, self.at, length)?;
        self.at += length;
        Ok(bytes)
    }

    pub(super) fn skip(&mut self, field: &str, length: usize) -> Result<()> {
        self.take(field, length).map(|_| ())
    }

    /// Reads a number of at most 8 bytes.
    pub(super) fn number(&mut self, field: &str, width: usize) -> Result<u64> {
        let bytes = self.take(field, width)?;
        Ok(bytes.iter().rev().fold(0, |number, &byte| number << 8 | u64::from(byte)))
    }

    pub(super) fn u8(&mut self, field: &str) -> Result<u8> {
        Ok(self.number(field, 1)? as u8)
    }

    pub(super) fn u16(&mut self, field: &str) -> Result<u16> {
        Ok(self.number(field, 2)? as u16)
    }

    pub(super) fn u32(&mut self, field: &str) -> Result<u32> {
        Ok(self.number(field, 4)? as u32)
    }

    pub(super) fn u64(&mut self, field: &str) -> Result<u64> {
        self.number(field, 8)
    }

    /// Reads a size of at most 8 bytes.
    pub(super) fn size(&mut self, field: &str, width: usize) -> Result<usize> {
        let at = self.at;
        let found = self.number(field, width)?;
        usize::try_from(found).map_err(|_| self.wrong(field, at, found, "a size within the file"))
    }

    /// Reads an address; `None` if it is undefined.
    pub(super) fn optional_address(&mut self, field: &str) -> Result<Option<usize>> {
        let at = self.at;
        match self.u64(field)? {
            UNDEFINED => Ok(None),
            found => usize::try_from(found)
                .ok()
                .filter(|&address| address < self.input.len())
                .map(Some)
                .ok_or_else(|| self.wrong(field, at, found, "a byte within the file")),
        }
    }

    /// Reads a required address.
    pub(super) fn address(&mut self, field: &str) -> Result<usize> {
        let at = self.at;
        self.optional_address(field)?.ok_or_else(|| self.wrong(field, at, "undefined", "a byte within the file"))
    }

    /// Checks a signature.
    pub(super) fn expect(&mut self, field: &str, wanted: &[u8]) -> Result<()> {
        let at = self.at;
        let found = self.take(field, wanted.len())?;
        refuse_if!(found != wanted, self.wrong(field, at, found.escape_ascii(), &wanted.escape_ascii().to_string()));
        Ok(())
    }

    /// Reads a version and checks that it is supported.
    pub(super) fn version(&mut self, read: &[u8]) -> Result<u8> {
        let at = self.at;
        let version = self.u8("version")?;
        if !read.contains(&version) {
            let versions = read.iter().map(u8::to_string).collect::<Vec<_>>().join(", ");
            return Err(self.wrong("version", at, version, &versions));
        }
        Ok(version)
    }

    /// Splits off the next `length` bytes as a structure of their own.
    pub(super) fn split(&mut self, name: &'static str, length: usize) -> Result<Self> {
        let at = self.at;
        self.skip(name, length)?;
        Ok(Self { name, at, end: at + length, ..*self })
    }

    /// Reads text up to a zero, which is skipped, or up to the end.
    pub(super) fn text(&mut self, field: &str) -> Result<&'a [u8]> {
        let rest = Self { ..*self }.take("bytes", self.left())?;
        let length = rest.iter().position(|&byte| byte == 0).unwrap_or(rest.len());
        self.skip(field, (length + 1).min(rest.len()))?;
        Ok(&rest[..length])
    }

    /// Skips the bytes up to a multiple of 8 after `start`.
    pub(super) fn align(&mut self, start: usize) -> Result<()> {
        let padding = (self.at - start).next_multiple_of(8) - (self.at - start);
        self.skip("padding", padding.min(self.left()))
    }

    /// Returns the error for a field whose value is invalid.
    pub(super) fn wrong(&self, field: &str, at: usize, found: impl ToString, wanted: &str) -> FormatError {
        self.input.wrong(&format!("{}, {field}", self.name), at, found, wanted)
    }

    /// Returns the error for a valid feature that is not supported.
    pub(super) fn unsupported(&self, found: impl std::fmt::Display, wanted: &'static str) -> FormatError {
        self.input.unsupported(format!("{found} ({}, byte {})", self.name, self.at), wanted)
    }
}
