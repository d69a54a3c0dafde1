//! Directories of a TIFF file and their fields, in classic and big files.

use crate::{ByteOrder, FormatError, Input, Result, Sample, utf8_or_latin1};

/// Maximum number of fields of a directory. Files of any kind have fewer than a hundred.
const MAX_ENTRIES: u64 = 1024;

/// Field: its number and its name in the specification.
#[derive(Clone, Copy)]
pub(super) struct Tag(pub(super) u16, pub(super) &'static str);

/// File and its layout.
#[derive(Clone, Copy)]
pub(super) struct File<'a> {
    pub(super) input: Input<'a>,
    big: bool,
}

/// Directory: the description of one page.
pub(super) struct Directory<'a> {
    pub(super) input: Input<'a>,
    /// Offset in the file.
    pub(super) offset: usize,
    entries: Vec<Entry>,
    /// Offset of the next directory, 0 after the last.
    pub(super) next: u64,
}

struct Entry {
    tag: u16,
    kind: u16,
    count: u64,
    /// Offset of the values.
    values: usize,
}

/// Returns the size in bytes of one value of a type; `None` for unknown types.
fn size(kind: u16) -> Option<usize> {
    match kind {
        // Bytes, texts and undefined values.
        1 | 2 | 6 | 7 => Some(1),
        3 | 8 => Some(2),
        // Longs, floats and offsets.
        4 | 9 | 11 | 13 => Some(4),
        // Rational numbers, doubles, long longs and their offsets.
        5 | 10 | 12 | 16..=18 => Some(8),
        _ => None,
    }
}

/// Returns the byte order, and whether the file is big.
fn layout(bytes: &[u8]) -> Option<(ByteOrder, bool)> {
    match bytes.get(..4)? {
        b"II\x2a\0" => Some((ByteOrder::Little, false)),
        b"MM\0\x2a" => Some((ByteOrder::Big, false)),
        // Size of offsets, 8, then zero.
        b"II\x2b\0" => (bytes.get(4..8)? == [8, 0, 0, 0]).then_some((ByteOrder::Little, true)),
        b"MM\0\x2b" => (bytes.get(4..8)? == [0, 8, 0, 0]).then_some((ByteOrder::Big, true)),
        _ => None,
    }
}

pub(super) fn detect(bytes: &[u8]) -> bool {
    layout(bytes).is_some()
}

impl<'a> File<'a> {
    pub(super) fn open(input: Input<'a>) -> Result<Self> {
        let (order, big) =
            layout(input.bytes).ok_or_else(|| input.wrong("signature", 0, "none of a TIFF file", "II* or MM*"))?;
        Ok(Self { input: input.with_order(order), big })
    }

    /// Returns the offset of the first directory.
    pub(super) fn first(&self) -> Result<u64> {
        self.offset("offset of the first directory", if self.big { 8 } else { 4 })
    }

    fn offset(&self, field: &str, at: usize) -> Result<u64> {
        if self.big { self.input.u64(field, at) } else { self.input.u32(field, at).map(u64::from) }
    }

    /// Returns the directory at an offset.
    ///
    /// # Errors
    /// An offset or a number of fields beyond the end of the file.
    pub(super) fn directory(&self, offset: u64) -> Result<Directory<'a>> {
        const FIELD: &str = "directory";
        let input = self.input;
        let offset = usize::try_from(offset).unwrap_or(usize::MAX);
        let (count, start, width, inline) = if self.big {
            (input.u64(FIELD, offset)?, offset + 8, 20, 8)
        } else {
            (input.u16(FIELD, offset)?.into(), offset + 2, 12, 4)
        };
        if count > MAX_ENTRIES {
            return Err(input.wrong("number of fields", offset, count, &format!("at most {MAX_ENTRIES}")));
        }
        let end = start + count as usize * width;
        input.take(FIELD, start, end - start)?;
        let mut entries = Vec::with_capacity(count as usize);
        for at in (start..end).step_by(width) {
            let (tag, kind) = (input.u16(FIELD, at)?, input.u16(FIELD, at + 2)?);
            let (count, values) = (self.offset(FIELD, at + 4)?, at + width - inline);
            // By the specification, readers skip unknown types.
            let Some(size) = size(kind) else { continue };
            let is_inline = count.saturating_mul(size as u64) <= inline as u64;
            let values =
                if is_inline { values } else { usize::try_from(self.offset(FIELD, values)?).unwrap_or(usize::MAX) };
            entries.push(Entry { tag, kind, count, values });
        }
        Ok(Directory { input, offset, entries, next: self.offset("offset of the next directory", end)? })
    }
}

impl Directory<'_> {
    fn entry(&self, tag: Tag) -> Option<&Entry> {
        self.entries.iter().find(|entry| entry.tag == tag.0 && entry.count > 0)
    }

    /// Returns the error for a field whose value is invalid.
    pub(super) fn wrong(&self, tag: Tag, found: impl ToString, wanted: &str) -> FormatError {
        self.input.wrong(tag.1, self.entry(tag).map_or(self.offset, |entry| entry.values), found, wanted)
    }

    /// Returns at most `limit` whole numbers of a field; `None` if it is absent.
    pub(super) fn integers(&self, tag: Tag, limit: u64) -> Result<Option<Vec<u64>>> {
        let Some(entry) = self.entry(tag) else { return Ok(None) };
        let (input, at) = (self.input, entry.values);
        let size = match entry.kind {
            1 | 7 => 1,
            // A negative number becomes too large.
            3 | 8 => 2,
            4 | 9 | 13 => 4,
            16 | 18 => 8,
            kind => return Err(self.wrong(tag, format!("type {kind}"), "a type of whole numbers (1, 3, 4 or 16)")),
        };
        let length = usize::try_from(entry.count.min(limit)).unwrap_or(usize::MAX).saturating_mul(size);
        input.take(tag.1, at, length)?;
        let number = |at| match size {
            1 => input.u8(tag.1, at).map(u64::from),
            2 => input.u16(tag.1, at).map(u64::from),
            4 => input.u32(tag.1, at).map(u64::from),
            _ => input.u64(tag.1, at),
        };
        (at..at + length).step_by(size).map(number).collect::<Result<_, _>>().map(Some)
    }

    /// Returns the first whole number of a field; `None` if it is absent.
    pub(super) fn integer(&self, tag: Tag) -> Result<Option<u64>> {
        Ok(self.integers(tag, 1)?.and_then(|numbers| numbers.first().copied()))
    }

    /// Returns a number that may be rational; `None` if the field is absent or the denominator is 0.
    pub(super) fn real(&self, tag: Tag) -> Result<Option<f64>> {
        let Some(entry) = self.entry(tag) else { return Ok(None) };
        let (input, at) = (self.input, entry.values);
        let number = match entry.kind {
            5 => {
                let (over, under) = (input.u32(tag.1, at)?, input.u32(tag.1, at.saturating_add(4))?);
                f64::from(over) / f64::from(under)
            }
            11 => input.f32(tag.1, at)?.into(),
            12 => input.f64(tag.1, at)?,
            _ => return Ok(self.integer(tag)?.map(|number| number as f64)),
        };
        Ok(Some(number).filter(|number| number.is_finite()))
    }

    /// Returns a text in UTF-8 or Latin-1; `None` if it is absent or empty.
    pub(super) fn text(&self, tag: Tag) -> Result<Option<String>> {
        let Some(entry) = self.entry(tag).filter(|entry| matches!(entry.kind, 1 | 2 | 7)) else { return Ok(None) };
        let length = usize::try_from(entry.count).unwrap_or(usize::MAX);
        let bytes = self.input.take(tag.1, entry.values, length)?;
        let bytes = bytes.split(|&byte| byte == 0).next().unwrap_or_default();
        let text = utf8_or_latin1(bytes.trim_ascii()).trim().to_owned();
        Ok(Some(text).filter(|text| !text.is_empty()))
    }

    /// Returns the offset and the size in bytes of the values of a field.
    pub(super) fn place(&self, tag: Tag) -> Option<(usize, usize)> {
        let entry = self.entry(tag)?;
        let length = entry.count.saturating_mul(size(entry.kind)? as u64);
        Some((entry.values, usize::try_from(length).unwrap_or(usize::MAX)))
    }

    /// Returns the size of a text field in bytes.
    pub(super) fn length(&self, tag: Tag) -> u64 {
        self.entry(tag).map_or(0, |entry| entry.count)
    }
}

/// Returns the number type of a page from its bits per sample and its sample format; `None` if it is not supported.
pub(super) fn sample(bits: u64, kind: u64) -> Option<Sample> {
    match kind {
        // Some programs write kind 4, undefined, for unsigned integers.
        1 | 2 | 4 if bits <= 32 => Sample::integer(bits, kind == 2),
        3 => Sample::float(bits),
        _ => None,
    }
}
