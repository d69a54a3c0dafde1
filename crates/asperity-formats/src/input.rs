//! Checked reading of fields from bytes. Nothing is read beyond their end, and errors name the field and its place.

use std::collections::BTreeMap;

use ndarray::Array2;

use crate::scan::{matrix, shape};
use crate::{ByteOrder, Format, FormatError, Location, Result, Sample, Shape, large, refuse_if, shown};

/// Bytes of a file, or of one file in an archive.
#[derive(Clone, Copy)]
pub(crate) struct Input<'a> {
    pub(crate) format: Format,
    entry: Option<&'a str>,
    order: ByteOrder,
    pub(crate) bytes: &'a [u8],
    /// Offset of `bytes` in the file.
    start: usize,
}

/// Field of a header: its name and its offset.
#[derive(Clone, Copy)]
pub(crate) struct Field(pub(crate) &'static str, pub(crate) usize);

/// Type of a field that becomes metadata.
#[derive(Clone, Copy)]
pub(crate) enum Kind {
    U8,
    I16,
    U16,
    I32,
    U32,
    F32,
    F64,
    /// Latin-1 text of at most this many bytes.
    Text(usize),
}

/// Defines a function that reads one number.
macro_rules! number {
    ($name:ident) => {
        #[doc = concat!("Reads one `", stringify!($name), "` in the byte order of the input.")]
        pub(crate) fn $name(&self, field: &str, offset: usize) -> Result<$name> {
            let raw = self.array(field, offset)?;
            Ok(match self.order {
                ByteOrder::Little => <$name>::from_le_bytes(raw),
                ByteOrder::Big => <$name>::from_be_bytes(raw),
            })
        }
    };
}

impl<'a> Input<'a> {
    /// Creates an input with little-endian numbers.
    pub(crate) fn new(format: Format, bytes: &'a [u8]) -> Self {
        Self { format, entry: None, order: ByteOrder::Little, bytes, start: 0 }
    }

    /// Creates an input for a file inside an archive.
    pub(crate) fn entry(format: Format, entry: &'a str, bytes: &'a [u8]) -> Self {
        Self { entry: Some(entry), ..Self::new(format, bytes) }
    }

    /// Returns the same bytes with numbers in another byte order.
    pub(crate) fn with_order(self, order: ByteOrder) -> Self {
        Self { order, ..self }
    }

    /// Returns the same bytes up to `end`.
    pub(crate) fn up_to(self, end: usize) -> Self {
        Self { bytes: &self.bytes[..end.min(self.bytes.len())], ..self }
    }

    /// Returns the bytes from `offset` on. Offsets then count from there; errors still name the place in the file.
    pub(crate) fn from(self, offset: usize) -> Self {
        Self { bytes: self.bytes.get(offset..).unwrap_or_default(), start: self.start.saturating_add(offset), ..self }
    }

    /// Returns the number of bytes.
    pub(crate) fn len(&self) -> usize {
        self.bytes.len()
    }

    number!(u8);
    number!(i16);
    number!(u16);
    number!(i32);
    number!(u32);
    number!(i64);
    number!(u64);
    number!(f32);
    number!(f64);

    fn array<const N: usize>(&self, field: &str, offset: usize) -> Result<[u8; N]> {
        let bytes = self.take(field, offset, N)?;
        bytes.try_into().map_err(|_| self.truncated(field, offset, N))
    }

    /// Returns `length` bytes from `offset` on.
    ///
    /// # Errors
    /// [`FormatError::Truncated`] if the file ends early.
    pub(crate) fn take(&self, part: &str, offset: usize, length: usize) -> Result<&'a [u8]> {
        let end = offset.checked_add(length);
        end.and_then(|end| self.bytes.get(offset..end)).ok_or_else(|| self.truncated(part, offset, length))
    }

    /// Reads Latin-1 text of at most `length` bytes, up to the first zero, and trims white space.
    pub(crate) fn latin1(&self, field: &str, offset: usize, length: usize) -> Result<String> {
        Ok(latin1(self.take(field, offset, length)?))
    }

    /// Returns the value of a field as text.
    pub(crate) fn value(&self, field: &str, offset: usize, kind: Kind) -> Result<String> {
        match kind {
            Kind::U8 => self.u8(field, offset).map(|number| number.to_string()),
            Kind::I16 => self.i16(field, offset).map(|number| number.to_string()),
            Kind::U16 => self.u16(field, offset).map(|number| number.to_string()),
            Kind::I32 => self.i32(field, offset).map(|number| number.to_string()),
            Kind::U32 => self.u32(field, offset).map(|number| number.to_string()),
            Kind::F32 => self.f32(field, offset).map(|number| number.to_string()),
            Kind::F64 => self.f64(field, offset).map(|number| number.to_string()),
            Kind::Text(length) => self.latin1(field, offset, length),
        }
    }

    /// Returns the values of a table of fields as metadata.
    pub(crate) fn values(&self, fields: &[(&str, usize, Kind)]) -> Result<BTreeMap<String, String>> {
        fields.iter().map(|&(name, at, kind)| Ok((name.to_owned(), self.value(name, at, kind)?))).collect()
    }

    /// Reads `count` numbers from `offset` on. Memory is allocated only if all of them are present.
    pub(crate) fn samples(&self, part: &str, offset: usize, count: usize, sample: Sample) -> Result<Vec<f64>> {
        let bytes = self.take(part, offset, count.saturating_mul(sample.size()))?;
        Ok(sample.decode_all(self.order, bytes))
    }

    /// Reads a map of numbers whose rows start `stride` bytes from each other.
    pub(crate) fn padded(
        &self,
        part: &str,
        offset: usize,
        (ny, nx): Shape,
        stride: usize,
        sample: Sample,
    ) -> Result<Vec<f64>> {
        let length = (ny - 1).saturating_mul(stride).saturating_add(nx * sample.size());
        let fill = |record: &[u8], row: &mut [f64]| sample.decode_into(self.order, record, row);
        Ok(large::rows(nx, self.take(part, offset, length)?, stride, fill))
    }

    /// Reads a map of numbers from `offset` on and converts each number to a height in metre.
    pub(crate) fn heights(
        &self,
        part: &str,
        offset: usize,
        shape: Shape,
        sample: Sample,
        in_metre: impl Fn(f64) -> f64 + Sync,
    ) -> Result<Array2<f64>> {
        let bytes = self.take(part, offset, (shape.0 * shape.1).saturating_mul(sample.size()))?;
        self.matrix(part, offset, shape, sample.decode_and_map(self.order, bytes, in_metre))
    }

    /// Reads a map as [`Input::heights`] whose rows are stored from the bottom up.
    pub(crate) fn heights_upwards(
        &self,
        part: &str,
        offset: usize,
        shape: Shape,
        sample: Sample,
        in_metre: impl Fn(f64) -> f64 + Sync,
    ) -> Result<Array2<f64>> {
        let mut heights = self.heights(part, offset, shape, sample, in_metre)?;
        heights.as_slice_mut().into_iter().for_each(|heights| large::flip(heights, shape.1));
        Ok(heights)
    }

    /// Arranges heights as a map. An error names `field`, the source of the shape.
    pub(crate) fn matrix(&self, field: &str, offset: usize, shape: Shape, heights: Vec<f64>) -> Result<Array2<f64>> {
        matrix(self.format, field, self.at(offset), shape, heights)
    }

    /// Checks the dimensions of a map, each given as `(field, offset, value)`.
    ///
    /// # Errors
    /// A dimension below 1, or a product above [`MAX_POINTS`](crate::MAX_POINTS).
    pub(crate) fn shape<T>(&self, rows: (&str, usize, T), columns: (&str, usize, T)) -> Result<Shape>
    where
        T: TryInto<u64> + ToString + Copy,
    {
        let placed = |(field, offset, found)| (field, self.at(offset), found);
        shape(self.format, placed(rows), placed(columns))
    }

    /// Returns a place in the file.
    pub(crate) fn at(&self, offset: usize) -> Location {
        let offset = self.start.saturating_add(offset) as u64;
        match self.entry {
            Some(entry) => Location::Entry { entry: shown(entry), offset },
            None => Location::Byte(offset),
        }
    }

    /// Returns the error for a part that ends early.
    pub(crate) fn truncated(&self, part: &str, offset: usize, wanted: usize) -> FormatError {
        let found = self.bytes.len().saturating_sub(offset) as u64;
        FormatError::truncated(self.format, shown(part), self.at(offset), found, wanted as u64)
    }

    /// Returns a number that other numbers are multiplied with.
    ///
    /// # Errors
    /// 0 and numbers that are not finite.
    pub(crate) fn factor<T: Into<f64> + ToString + Copy>(&self, field: &str, offset: usize, found: T) -> Result<f64> {
        let factor: f64 = found.into();
        refuse_if!(
            !factor.is_finite() || factor == 0.0,
            self.wrong(field, offset, found, "a finite number other than 0")
        );
        Ok(factor)
    }

    /// Returns the error for a field whose value is invalid.
    pub(crate) fn wrong(&self, field: &str, offset: usize, found: impl ToString, wanted: &str) -> FormatError {
        // Some formats have field names of any length.
        FormatError::field(self.format, shown(field), self.at(offset), found, wanted)
    }

    /// Returns the error for a size above its limit.
    pub(crate) fn too_large(&self, field: &str, offset: usize, found: usize, limit: usize) -> FormatError {
        FormatError::too_large(self.format, field, self.at(offset), found as u64, limit as u64)
    }

    /// Returns the error for a field that is absent.
    pub(crate) fn missing(&self, field: &str, offset: usize, wanted: &str) -> FormatError {
        FormatError::missing(self.format, field, self.at(offset), wanted)
    }

    /// Returns the error for a valid file of a kind that is not read.
    pub(crate) fn unsupported(&self, found: impl Into<String>, wanted: &'static str) -> FormatError {
        FormatError::unsupported(self.format, found, wanted)
    }
}

/// Decodes Latin-1 text up to the first zero and trims white space.
pub(crate) fn latin1(bytes: &[u8]) -> String {
    let end = bytes.iter().position(|&byte| byte == 0).unwrap_or(bytes.len());
    kept(bytes[..end].trim_ascii(), |bytes| bytes.iter().map(|&byte| char::from(byte)).collect()).trim().to_owned()
}

/// Decodes UTF-16 text after a byte-order mark. Returns `None` without a mark.
pub(crate) fn utf16(bytes: &[u8]) -> Option<String> {
    match bytes {
        [0xff, 0xfe, rest @ ..] => Some(utf16_text(rest, ByteOrder::Little)),
        [0xfe, 0xff, rest @ ..] => Some(utf16_text(rest, ByteOrder::Big)),
        _ => None,
    }
}

/// Decodes UTF-16 text.
pub(crate) fn utf16_text(bytes: &[u8], order: ByteOrder) -> String {
    // A unit takes at most three bytes. Growth by doubling would take more memory.
    let mut text = String::with_capacity(bytes.len() + bytes.len() / 2);
    let units = bytes.as_chunks().0.iter().map(|&unit| match order {
        ByteOrder::Little => u16::from_le_bytes(unit),
        ByteOrder::Big => u16::from_be_bytes(unit),
    });
    text.extend(char::decode_utf16(units).map(|unit| unit.unwrap_or(char::REPLACEMENT_CHARACTER)));
    text
}

/// Decodes text in UTF-8, or in Latin-1 if it is not valid UTF-8.
pub(crate) fn utf8_or_latin1(bytes: &[u8]) -> String {
    kept(bytes, |bytes| match std::str::from_utf8(bytes) {
        Ok(text) => text.to_owned(),
        // The cut is inside a character.
        Err(error) if bytes.len() == MAX_TEXT_BYTES && error.error_len().is_none() => {
            String::from_utf8_lossy(&bytes[..error.valid_up_to()]).into_owned()
        }
        Err(_) => bytes.iter().map(|&byte| char::from(byte)).collect(),
    })
}

/// Maximum number of bytes of one text. The longest comments of instruments have about ten thousand.
pub(crate) const MAX_TEXT_BYTES: usize = 1 << 18;

/// Decodes at most [`MAX_TEXT_BYTES`] bytes of a text and marks a cut with `…`.
fn kept(bytes: &[u8], decode: impl FnOnce(&[u8]) -> String) -> String {
    match bytes.get(..MAX_TEXT_BYTES) {
        Some(start) if start.len() < bytes.len() => decode(start) + "…",
        _ => decode(bytes),
    }
}

/// Limits the texts of a file beside its heights, so that a file of texts alone cannot take many times its size in
/// memory.
pub(crate) struct TextLimit {
    texts: usize,
    bytes: usize,
}

impl Default for TextLimit {
    fn default() -> Self {
        Self { texts: 10_000, bytes: 1 << 22 }
    }
}

impl TextLimit {
    /// Returns whether one more text is allowed.
    pub(crate) fn is_left(&self) -> bool {
        self.texts > 0 && self.bytes > 0
    }

    /// Accounts for a text of `bytes` bytes. Returns whether it is allowed.
    pub(crate) fn take(&mut self, bytes: usize) -> bool {
        let is_left = self.is_left();
        self.texts = self.texts.saturating_sub(1);
        self.bytes = self.bytes.saturating_sub(bytes);
        is_left
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_are_read_in_either_order() {
        let bytes = [0x3f, 0x80, 0, 0];
        let input = Input::new(Format::Text, &bytes);
        assert_eq!(input.u16("a", 0).unwrap(), 0x803f);
        assert_eq!(input.with_order(ByteOrder::Big).f32("a", 0).unwrap(), 1.0);
    }

    #[test]
    fn a_field_beyond_the_end_is_reported_by_name_and_place() {
        let input = Input::entry(Format::Text, "a.bin", &[1, 2, 3]);
        let message = input.u32("width", 1).unwrap_err().to_string();
        assert_eq!(message, "text: width (a.bin, byte 1) stop after 2 bytes; wanted 4");
        assert!(input.take("all", usize::MAX, 2).is_err());
        assert!(input.samples("all", 0, usize::MAX, Sample::F64).is_err());
    }

    #[test]
    fn long_texts_are_cut_between_characters() {
        assert_eq!(utf8_or_latin1("µm".as_bytes()), "µm");
        assert_eq!(utf8_or_latin1(b"\xb5m"), "µm");
        let long = "µ".repeat(MAX_TEXT_BYTES);
        assert_eq!(utf8_or_latin1(long.as_bytes()), "µ".repeat(MAX_TEXT_BYTES / 2) + "…");
        // One more byte moves the cut into a character.
        let shifted = utf8_or_latin1(format!("m{long}").as_bytes());
        assert!(shifted.ends_with("µ…") && shifted.len() == MAX_TEXT_BYTES - 1 + "…".len(), "{}", shifted.len());
        assert_eq!(latin1(&vec![0xb5; MAX_TEXT_BYTES + 1]), "µ".repeat(MAX_TEXT_BYTES) + "…");
    }

    #[test]
    fn room_ends_with_the_number_of_texts_or_with_their_bytes() {
        let mut room = TextLimit { texts: 2, bytes: 10 };
        assert!(room.take(3) && room.take(3) && !room.take(3));
        let mut room = TextLimit { texts: 9, bytes: 10 };
        assert!(room.take(100) && !room.take(0));
    }

    #[test]
    fn nothing_is_read_beyond_a_nearer_end() {
        let input = Input::new(Format::Text, &[1, 2, 3]).up_to(2);
        assert_eq!(input.u16("a", 0).unwrap(), 0x0201);
        assert!(input.u16("a", 1).is_err());
        assert_eq!(input.up_to(9).len(), 2);
    }

    #[test]
    fn dimensions_below_one_or_beyond_the_limit_are_refused() {
        let input = Input::new(Format::Text, &[]);
        assert_eq!(input.shape(("rows", 0, 2), ("columns", 4, 3)).unwrap(), (2, 3));
        assert!(matches!(input.shape(("rows", 0, 0), ("columns", 4, 3)), Err(FormatError::Field { .. })));
        assert!(matches!(input.shape(("rows", 0, 2), ("columns", 4, -1)), Err(FormatError::Field { .. })));
        assert!(matches!(
            input.shape(("rows", 0, 1 << 14), ("columns", 4, 1 << 15)),
            Err(FormatError::TooLarge { .. })
        ));
    }
}
