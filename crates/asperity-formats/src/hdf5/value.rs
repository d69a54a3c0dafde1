//! Attributes and their values.

use super::datatype::dimensions;
use super::header::{ATTRIBUTE, ATTRIBUTE_INFO};
use super::{Class, Datatype, File, Object, Piece};
use crate::{Result, shown};

/// Maximum number of numbers of a value that are shown as text.
const SHOWN_NUMBERS: usize = 16;
/// Cost of a byte of text: texts are copied, other structures are read in place.
const COPY_WORK: usize = 8;

/// Named value of a group or dataset. Its type is read on demand.
pub(crate) struct Attribute<'a> {
    pub(crate) name: &'a [u8],
    is_shared: bool,
    datatype: Piece<'a>,
    dataspace: Piece<'a>,
    data: Piece<'a>,
}

/// One element, or several contiguous ones.
#[derive(Clone, Copy)]
pub(crate) struct Value<'v> {
    pub(super) file: &'v File<'v>,
    pub(super) datatype: &'v Datatype,
    pub(super) bytes: &'v [u8],
}

impl<'a> File<'a> {
    /// Returns all attributes of an object.
    pub(crate) fn attributes(&self, object: &Object) -> Result<Vec<Attribute<'a>>> {
        let mut attributes = Vec::new();
        let mut push = |attribute: Attribute<'a>| {
            attributes.push(attribute);
            self.check_count("the number of attributes", object.at, attributes.len())
        };
        for message in object.all(ATTRIBUTE).filter(|message| !message.shared) {
            push(attribute(self.message(message, "attribute")?)?)?;
        }
        if let Some(message) = object.first(ATTRIBUTE_INFO) {
            let info = self.message(message, "attribute info message")?;
            self.visit_dense(info, 2, 0, &mut |found| push(attribute(found)?))?;
        }
        Ok(attributes)
    }

    /// Converts the elements of an attribute with `turn`; `None` if it has no elements.
    pub(crate) fn value<T>(
        &self,
        attribute: &Attribute<'a>,
        turn: impl FnOnce(Value) -> Result<Option<T>>,
    ) -> Result<Option<T>> {
        let datatype = self.datatype(attribute.datatype, attribute.is_shared)?;
        let count = dimensions(attribute.dataspace)?.into_iter().fold(1, usize::saturating_mul);
        if count == 0 {
            return Ok(None);
        }
        let mut data = attribute.data;
        let bytes = data.take("value", count.saturating_mul(datatype.bytes))?;
        turn(Value { file: self, datatype: &datatype, bytes })
    }
}

/// Formats a number, with an exponent if it would have many digits.
pub(crate) fn shown_number(number: f64) -> String {
    if number == 0.0 || (1e-4..1e15).contains(&number.abs()) { number.to_string() } else { format!("{number:e}") }
}

/// Maximum number of bytes of a name. Names of instruments are shorter.
const NAME_BYTES: usize = 256;

/// Returns a name as text, cut to [`NAME_BYTES`].
pub(crate) fn shown_name(name: &[u8]) -> String {
    String::from_utf8_lossy(&name[..name.len().min(NAME_BYTES)]).into_owned()
}

/// Reads an attribute message up to its value.
fn attribute(mut message: Piece) -> Result<Attribute> {
    let version = message.version(&[1, 2, 3])?;
    let flags = message.u8("flags")?;
    let lengths = [message.size("name size", 2)?, message.size("type size", 2)?, message.size("space size", 2)?];
    if version == 3 {
        message.skip("character set", 1)?;
    }
    let mut part = |name, length| {
        let start = message.at();
        let part = message.split(name, length)?;
        if version == 1 {
            message.align(start)?;
        }
        Ok(part)
    };
    let mut name = part("attribute name", lengths[0])?;
    let datatype = part("datatype", lengths[1])?;
    let dataspace = part("dataspace", lengths[2])?;
    Ok(Attribute {
        name: name.text("name")?,
        is_shared: version > 1 && flags & 1 != 0,
        datatype,
        dataspace,
        data: message,
    })
}

impl<'v> Value<'v> {
    /// Returns the first number.
    pub(crate) fn number(&self) -> Result<Option<f64>> {
        Ok(self.numbers(1)?.first().copied())
    }

    /// Returns at most `most` numbers of single values, arrays or the first sequence.
    pub(crate) fn numbers(&self, most: usize) -> Result<Vec<f64>> {
        let (base, bytes) = match &self.datatype.class {
            Class::Array(base) => (base.as_ref(), self.bytes),
            Class::Sequence(base) => (base.as_ref(), self.elsewhere(base.bytes)?),
            _ => (self.datatype, self.bytes),
        };
        let mut numbers = Vec::new();
        if let Class::Number(sample, order) = base.class {
            let length = most.saturating_mul(sample.size()).min(bytes.len());
            sample.decode(order, &bytes[..length], &mut numbers);
        }
        Ok(numbers)
    }

    /// Returns the bytes of the first text up to a zero; `None` for other types.
    pub(crate) fn raw_text(&self) -> Result<Option<&'v [u8]>> {
        let bytes = match self.datatype.class {
            Class::Text => &self.bytes[..self.datatype.bytes.min(self.bytes.len())],
            Class::TextElsewhere => self.elsewhere(1)?,
            _ => return Ok(None),
        };
        let end = bytes.iter().position(|&byte| byte == 0).unwrap_or(bytes.len());
        Ok(Some(&bytes[..end]))
    }

    /// Returns a text without surrounding white space.
    pub(crate) fn text(&self) -> Result<Option<String>> {
        let Some(raw) = self.raw_text()? else { return Ok(None) };
        self.file.charge("texts", 0, raw.len().saturating_mul(COPY_WORK))?;
        Ok(Some(String::from_utf8_lossy(raw).trim().to_owned()))
    }

    /// Returns a member of the first compound.
    pub(crate) fn member(&self, name: &str) -> Option<Self> {
        let Class::Compound(members) = &self.datatype.class else { return None };
        let member = members.iter().find(|member| member.name == name)?;
        let bytes = self.bytes.get(member.offset..member.offset + member.datatype.bytes)?;
        Some(Self { datatype: &member.datatype, bytes, ..*self })
    }

    /// Returns the bytes of a text member of the first compound.
    pub(crate) fn member_text(&self, name: &str) -> Result<Option<&'v [u8]>> {
        self.member(name).map_or(Ok(None), |member| member.raw_text())
    }

    /// Returns whether a text member of the first compound equals `wanted`.
    pub(crate) fn has_text(&self, name: &str, wanted: &[u8]) -> Result<bool> {
        let Some(member) = self.member(name) else { return Ok(false) };
        // A text of another length, apart from a zero at the end, differs without a look into the heap.
        let length = member.reference(0, 4);
        let is_long = matches!(member.datatype.class, Class::TextElsewhere);
        if is_long && ![wanted.len() as u64, wanted.len() as u64 + 1].contains(&length) {
            return Ok(false);
        }
        Ok(member.raw_text()? == Some(wanted))
    }

    /// Returns the addresses of object references: the first of each sequence.
    pub(crate) fn objects(&self) -> Result<Vec<usize>> {
        let Class::Sequence(base) = &self.datatype.class else { return Ok(Vec::new()) };
        let address = |bytes: &'v [u8]| -> Result<usize> {
            let found = Self { bytes, ..*self }.elsewhere(base.bytes)?;
            let raw = found.first_chunk().filter(|_| matches!(base.class, Class::ObjectReference));
            Ok(raw.and_then(|raw| usize::try_from(u64::from_le_bytes(*raw)).ok()).unwrap_or(usize::MAX))
        };
        self.bytes.chunks_exact(self.datatype.bytes).map(address).collect()
    }

    /// Describes the value for the user; `None` unless it consists of texts and numbers.
    pub(crate) fn describe(&self) -> Result<Option<String>> {
        if let Class::Compound(members) = &self.datatype.class {
            let mut parts = Vec::new();
            for member in members.iter().take(SHOWN_NUMBERS) {
                if let Some(value) = self.member(&member.name)
                    && !matches!(value.datatype.class, Class::Compound(_))
                    && let Some(text) = value.describe()?
                {
                    parts.push(format!("{} {text}", shown(&member.name)));
                }
            }
            return Ok((!parts.is_empty()).then(|| parts.join(", ")));
        }
        if let Some(text) = self.text()? {
            return Ok(Some(text));
        }
        let numbers: Vec<String> = self.numbers(SHOWN_NUMBERS)?.into_iter().map(shown_number).collect();
        Ok((!numbers.is_empty()).then(|| numbers.join(" ")))
    }

    /// Returns a part of a reference into a global heap.
    fn reference(&self, start: usize, width: usize) -> u64 {
        self.bytes.iter().skip(start).take(width).rev().fold(0, |number, &byte| number << 8 | u64::from(byte))
    }

    /// Returns the elements of a reference into a global heap; none for an empty sequence.
    fn elsewhere(&self, element_bytes: usize) -> Result<&'v [u8]> {
        let (length, address, index) = (self.reference(0, 4), self.reference(4, 8), self.reference(12, 4));
        let address = usize::try_from(address).unwrap_or(usize::MAX);
        if length == 0 || index == 0 {
            return Ok(&[]);
        }
        let found = self.file.global(address, index as u32)?.unwrap_or_default();
        let wanted = usize::try_from(length).unwrap_or(usize::MAX).saturating_mul(element_bytes);
        found.get(..wanted).ok_or_else(|| {
            self.file.input.wrong(
                "global heap, value of variable length",
                address,
                found.len(),
                &format!("{wanted} bytes"),
            )
        })
    }
}
