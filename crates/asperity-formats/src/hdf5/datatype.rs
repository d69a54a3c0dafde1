//! Datatypes and dataspaces.

use super::header::DATATYPE;
use super::{File, Object, Piece};
use crate::{ByteOrder, Result, Sample, refuse_if};

/// Maximum depth of nested types.
const MAX_DEPTH: usize = 8;
/// Maximum number of members of a compound. Compounds of instruments have fewer than ten.
const MAX_MEMBERS: u64 = 256;
/// Maximum number of dimensions in the format.
const MAX_DIMENSIONS: u8 = 32;
/// Size in bytes of a reference into a global heap: length, address of the heap, index.
pub(super) const REFERENCE_BYTES: usize = 4 + 8 + 4;

/// Type of an element.
pub(crate) struct Datatype {
    /// Size of an element in bytes.
    pub(crate) bytes: usize,
    pub(crate) class: Class,
}

/// Class of a type.
pub(crate) enum Class {
    Number(Sample, ByteOrder),
    /// Text with the size of the type.
    Text,
    /// Text in a global heap.
    TextElsewhere,
    /// Variable-length sequence in a global heap.
    Sequence(Box<Datatype>),
    Compound(Vec<Member>),
    /// Contiguous elements.
    Array(Box<Datatype>),
    /// Address of an object.
    ObjectReference,
    /// Class that is not supported.
    Other,
}

/// Member of a compound.
pub(crate) struct Member {
    pub(crate) name: String,
    pub(crate) offset: usize,
    pub(crate) datatype: Datatype,
}

impl File<'_> {
    /// Returns the type in a datatype message, or in the committed datatype that it refers to.
    pub(super) fn datatype(&self, mut message: Piece, is_shared: bool) -> Result<Datatype> {
        if !is_shared {
            return read(&mut message, 0);
        }
        let version = message.version(&[1, 2, 3])?;
        let kind_at = message.at();
        let kind = message.u8("kind")?;
        // Versions 1 and 2 refer to committed datatypes only. In version 3 they have the number 2.
        refuse_if!(version == 3 && kind != 2, message.wrong("kind", kind_at, kind, "2, a committed datatype"));
        if version == 1 {
            message.skip("reserved", 6)?;
        }
        let object: Object = self.object(message.address("address")?)?;
        match object.first(DATATYPE) {
            Some(datatype) if !datatype.shared => read(&mut self.message(datatype, "datatype")?, 0),
            _ => Err(self.input.missing("committed datatype", object.at, "a datatype message")),
        }
    }
}

/// Reads one type. The bytes after it remain in `message`.
fn read(message: &mut Piece, depth: usize) -> Result<Datatype> {
    let start = message.at();
    refuse_if!(depth > MAX_DEPTH, message.wrong("depth", start, depth, &format!("at most {MAX_DEPTH}")));
    let kind = message.u8("class and version")?;
    let (class, version) = (kind & 15, kind >> 4);
    let bits = message.number("bits of the class", 3)?;
    let bytes = message.size("size", 4)?;
    refuse_if!(bytes == 0, message.wrong("size", start + 4, bytes, "1 or more"));
    let class = match class {
        0 => integer(message, bits, bytes)?,
        1 => float(message, bits, bytes)?,
        3 => Class::Text,
        6 => compound(message, version, bits, bytes, depth)?,
        7 if bits & 15 == 0 => Class::ObjectReference,
        7 => Class::Other,
        // An enumeration is its integer type, followed by names.
        8 => enumeration(message, version, bits, depth)?,
        9 => {
            let base = read(message, depth + 1)?;
            if bits & 15 == 1 { Class::TextElsewhere } else { Class::Sequence(Box::new(base)) }
        }
        10 => {
            let rank = usize::from(message.u8("dimensions")?);
            // Old arrays have reserved bytes, and a permutation after the sizes.
            message.skip("sizes", if version < 3 { 3 + 8 * rank } else { 4 * rank })?;
            Class::Array(Box::new(read(message, depth + 1)?))
        }
        // Times, bits and opaque bytes are skipped inside compounds. Later classes are unknown.
        2 | 4 | 5 => {
            message.skip("properties", if class == 5 { (bits & 0xff) as usize } else { class.into() })?;
            Class::Other
        }
        _ => return Err(message.unsupported(format!("data of class {class}"), "numbers, texts and compounds of them")),
    };
    let fits = match &class {
        Class::Number(sample, _) => sample.size() == bytes,
        Class::TextElsewhere | Class::Sequence(_) => bytes == REFERENCE_BYTES,
        Class::Array(base) => bytes.is_multiple_of(base.bytes),
        Class::ObjectReference => bytes == 8,
        _ => true,
    };
    refuse_if!(!fits, message.wrong("size", start + 4, bytes, "the size of what the type holds"));
    Ok(Datatype { bytes, class })
}

fn integer(message: &mut Piece, bits: u64, bytes: usize) -> Result<Class> {
    let (offset, precision) = (message.u16("bit offset")?, message.u16("bit precision")?);
    let is_whole = offset == 0 && usize::from(precision) == bytes.saturating_mul(8);
    let sample = Sample::integer(precision.into(), bits >> 3 & 1 == 1).filter(|_| is_whole);
    Ok(sample.map_or(Class::Other, |sample| Class::Number(sample, order(bits))))
}

fn float(message: &mut Piece, bits: u64, bytes: usize) -> Result<Class> {
    let properties = message.take("properties", 12)?;
    // Bit offset and precision; position and size of exponent and mantissa; bias of the exponent, by IEEE 754.
    let sample = match (bytes, properties) {
        (4, [0, 0, 32, 0, 23, 8, 0, 23, 127, 0, 0, 0]) => Sample::F32,
        (8, [0, 0, 64, 0, 52, 11, 0, 52, 0xff, 3, 0, 0]) => Sample::F64,
        _ => return Ok(Class::Other),
    };
    // Bit 6 marks the mixed byte order of the VAX.
    Ok(if bits & 1 << 6 == 0 { Class::Number(sample, order(bits)) } else { Class::Other })
}

fn order(bits: u64) -> ByteOrder {
    if bits & 1 == 0 { ByteOrder::Little } else { ByteOrder::Big }
}

fn enumeration(message: &mut Piece, version: u8, bits: u64, depth: usize) -> Result<Class> {
    let base = read(message, depth + 1)?;
    let count = (bits & 0xffff) as usize;
    for _ in 0..count {
        name(message, version)?;
    }
    message.skip("values", count * base.bytes)?;
    Ok(base.class)
}

fn compound(message: &mut Piece, version: u8, bits: u64, bytes: usize, depth: usize) -> Result<Class> {
    let (count, mut members) = (bits & 0xffff, Vec::new());
    refuse_if!(count > MAX_MEMBERS, message.wrong("members", message.at(), count, &format!("at most {MAX_MEMBERS}")));
    for _ in 0..count {
        let name = String::from_utf8_lossy(name(message, version)?).into_owned();
        let at = message.at();
        // New offsets have the width of the size of the compound.
        let offset =
            message.size("offset of a member", if version < 3 { 4 } else { super::tree::width(bytes as u64) })?;
        if version < 2 {
            // Dimensions, permutation and sizes, which array types have replaced.
            message.skip("dimensions of a member", 28)?;
        }
        let datatype = read(message, depth + 1)?;
        if offset.checked_add(datatype.bytes).is_none_or(|end| end > bytes) {
            return Err(message.wrong("offset of a member", at, offset, "a place inside of the compound"));
        }
        members.push(Member { name, offset, datatype });
    }
    Ok(Class::Compound(members))
}

/// Reads a name that ends with a zero. Old names fill a multiple of 8 bytes.
fn name<'a>(message: &mut Piece<'a>, version: u8) -> Result<&'a [u8]> {
    let start = message.at();
    let name = message.text("name")?;
    if version < 3 {
        message.align(start)?;
    }
    Ok(name)
}

/// Returns the dimensions in a dataspace message; none for a single element.
pub(super) fn dimensions(mut message: Piece) -> Result<Vec<usize>> {
    let version = message.version(&[1, 2])?;
    let rank_at = message.at();
    let rank = message.u8("dimensions")?;
    message.skip("flags", 1)?;
    let kind = if version == 2 { message.u8("kind")? } else { 1 };
    if version == 1 {
        message.skip("reserved", 5)?;
    }
    refuse_if!(rank > MAX_DIMENSIONS, message.wrong("dimensions", rank_at, rank, &format!("at most {MAX_DIMENSIONS}")));
    // A dataspace of kind 2 is empty.
    if kind == 2 {
        return Ok(vec![0]);
    }
    (0..rank).map(|_| message.size("size of a dimension", 8)).collect()
}
