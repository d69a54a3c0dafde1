//! A structure of the file, read field by field from its start to its end.

use crate::FormatError;
use crate::error::Result;
use crate::input::Input;

/// What stands for an address where there is nothing.
const UNDEFINED: u64 = u64::MAX;

/// The part of a structure that is not read yet. Numbers are little-endian.
#[derive(Clone, Copy)]
pub(super) struct Piece<'a> {
    input: Input<'a>,
    name: &'static str,
    at: usize,
    end: usize,
}

impl<'a> Piece<'a> {
    /// # Errors
    /// [`FormatError::Truncated`] where the file ends before.
    pub(super) fn new(input: Input<'a>, name: &'static str, at: usize, length: usize) -> Result<Self> {
        input.take(name, at, length)?;
        Ok(Self { input, name, at, end: at + length })
    }

    /// Where the next field stands in the file.
    pub(super) fn at(&self) -> usize {
        self.at
    }

    /// Bytes that are left.
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

    /// All bytes that are left.
    pub(super) fn rest(mut self) -> Result<&'a [u8]> {
        self.take("bytes", self.left())
    }

    pub(super) fn skip(&mut self, field: &str, length: usize) -> Result<()> {
        self.take(field, length).map(|_| ())
    }

    /// A number of at most 8 bytes.
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

    /// A number of at most 8 bytes that counts things in the file.
    pub(super) fn size(&mut self, field: &str, width: usize) -> Result<usize> {
        let at = self.at;
        let found = self.number(field, width)?;
        usize::try_from(found).map_err(|_| self.wrong(field, at, found, "a size within the file"))
    }

    /// An address, `None` where there is nothing.
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

    /// An address where something must be.
    pub(super) fn address(&mut self, field: &str) -> Result<usize> {
        let at = self.at;
        self.optional_address(field)?.ok_or_else(|| self.wrong(field, at, "undefined", "a byte within the file"))
    }

    /// Bytes that every structure of a kind starts with.
    pub(super) fn expect(&mut self, field: &str, wanted: &[u8]) -> Result<()> {
        let at = self.at;
        let found = self.take(field, wanted.len())?;
        if found != wanted {
            return Err(self.wrong(field, at, found.escape_ascii(), &wanted.escape_ascii().to_string()));
        }
        Ok(())
    }

    /// The number of a version that is read.
    pub(super) fn version(&mut self, read: &[u8]) -> Result<u8> {
        let at = self.at;
        let version = self.u8("version")?;
        if !read.contains(&version) {
            let versions = read.iter().map(u8::to_string).collect::<Vec<_>>().join(", ");
            return Err(self.wrong("version", at, version, &versions));
        }
        Ok(version)
    }

    /// The next `length` bytes as a structure of their own.
    pub(super) fn split(&mut self, name: &'static str, length: usize) -> Result<Self> {
        let at = self.at;
        self.skip(name, length)?;
        Ok(Self { name, at, end: at + length, ..*self })
    }

    /// Text up to a zero, which is passed over; up to the end where there is none.
    pub(super) fn text(&mut self, field: &str) -> Result<&'a [u8]> {
        let rest = self.rest()?;
        let length = rest.iter().position(|&byte| byte == 0).unwrap_or(rest.len());
        self.skip(field, (length + 1).min(rest.len()))?;
        Ok(&rest[..length])
    }

    /// Passes over the bytes up to a multiple of 8 after `start`.
    pub(super) fn align(&mut self, start: usize) -> Result<()> {
        let padding = (self.at - start).next_multiple_of(8) - (self.at - start);
        self.skip("padding", padding.min(self.left()))
    }

    /// The error for a field whose value cannot be right.
    pub(super) fn wrong(&self, field: &str, at: usize, found: impl ToString, wanted: &str) -> FormatError {
        self.input.wrong(&format!("{}, {field}", self.name), at, found, wanted)
    }

    /// The error for something that the format allows and this reader does not read.
    pub(super) fn unsupported(&self, found: impl std::fmt::Display, wanted: &'static str) -> FormatError {
        self.input.unsupported(format!("{found} ({}, byte {})", self.name, self.at), wanted)
    }
}
