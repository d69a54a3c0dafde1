//! Object headers: the messages that describe a group or a dataset.

use super::{File, MAX_ENTRIES, Piece};
use crate::Result;

pub(super) const DATASPACE: u16 = 0x01;
pub(super) const LINK_INFO: u16 = 0x02;
pub(super) const DATATYPE: u16 = 0x03;
pub(super) const OLD_FILL_VALUE: u16 = 0x04;
pub(super) const FILL_VALUE: u16 = 0x05;
pub(super) const LINK: u16 = 0x06;
pub(super) const LAYOUT: u16 = 0x08;
pub(super) const FILTERS: u16 = 0x0b;
pub(super) const ATTRIBUTE: u16 = 0x0c;
pub(super) const SYMBOL_TABLE: u16 = 0x11;
pub(super) const ATTRIBUTE_INFO: u16 = 0x15;
const CONTINUATION: u16 = 0x10;

/// First bytes of a version 2 header; version 1 has no signature.
const SIGNATURE: &[u8] = b"OHDR";
/// Maximum number of blocks of one object header.
const MAX_BLOCKS: usize = 1024;

/// Group or dataset.
pub(crate) struct Object {
    /// Offset of its header.
    pub(crate) at: usize,
    messages: Vec<Message>,
}

/// Place of a message.
#[derive(Clone, Copy)]
pub(super) struct Message {
    kind: u16,
    /// Whether the content is stored elsewhere.
    pub(super) shared: bool,
    pub(super) at: usize,
    pub(super) length: usize,
}

impl Object {
    pub(super) fn all(&self, kind: u16) -> impl Iterator<Item = Message> {
        self.messages.iter().copied().filter(move |message| message.kind == kind)
    }

    pub(super) fn first(&self, kind: u16) -> Option<Message> {
        self.all(kind).next()
    }
}

/// Layout of the messages of a header: bytes of the type, and bytes between the flags and the content.
type Style = (usize, usize);

impl<'a> File<'a> {
    /// Reads the header of the object at an address.
    pub(crate) fn object(&self, at: usize) -> Result<Object> {
        let is_old = self.input.take("object header", at, 4)? != SIGNATURE;
        let (style, first) = if is_old { self.old_header(at)? } else { self.new_header(at)? };
        let mut blocks = vec![first];
        let mut messages = Vec::new();
        let mut next = 0;
        while let Some(&(start, length)) = blocks.get(next) {
            next += 1;
            let mut block = self.piece("object header", start, length)?;
            while let Some(message) = next_message(&mut block, style)? {
                if message.kind == CONTINUATION {
                    let mut place = self.message(message, "continuation message")?;
                    let (start, length) = (place.address("address")?, place.size("length", 8)?);
                    // New blocks have a signature before their messages and a checksum after them.
                    blocks.push(if is_old { (start, length) } else { (start + 4, length.saturating_sub(8)) });
                }
                messages.push(message);
                if messages.len() > MAX_ENTRIES || blocks.len() > MAX_BLOCKS {
                    return Err(self.input.too_large("the number of messages", at, messages.len(), MAX_ENTRIES));
                }
            }
        }
        Ok(Object { at, messages })
    }

    /// Returns the place of the messages of a version 1 header.
    fn old_header(&self, at: usize) -> Result<(Style, (usize, usize))> {
        let mut header = self.piece("object header", at, 16)?;
        header.version(&[1])?;
        // A reserved byte, number of messages, reference count.
        header.skip("counts", 7)?;
        Ok(((2, 3), (at + 16, header.size("size", 4)?)))
    }

    /// Returns the place of the messages of a version 2 header.
    fn new_header(&self, at: usize) -> Result<(Style, (usize, usize))> {
        let longest = 4 + 1 + 1 + 16 + 4 + 8;
        let mut header = self.piece("object header", at, self.input.len().saturating_sub(at).min(longest))?;
        header.expect("signature", SIGNATURE)?;
        header.version(&[2])?;
        let flags = header.u8("flags")?;
        if flags & 1 << 5 != 0 {
            header.skip("times", 16)?;
        }
        if flags & 1 << 4 != 0 {
            header.skip("limits of attributes", 4)?;
        }
        let length = header.size("size", 1 << (flags & 3))?;
        // Bit 2: every message states its creation order.
        let order_bytes = if flags & 1 << 2 != 0 { 2 } else { 0 };
        Ok(((1, order_bytes), (header.at(), length)))
    }

    /// Returns the content of a message.
    pub(super) fn message(&self, message: Message, name: &'static str) -> Result<Piece<'a>> {
        self.piece(name, message.at, message.length)
    }
}

/// Reads the next message of a block; `None` if the rest is too short.
fn next_message(block: &mut Piece, (kind_bytes, behind_flags): Style) -> Result<Option<Message>> {
    if block.left() < kind_bytes + 2 + 1 + behind_flags {
        return Ok(None);
    }
    let kind = block.number("message type", kind_bytes)? as u16;
    let length = usize::from(block.u16("message size")?);
    let flags = block.u8("message flags")?;
    block.skip("message order", behind_flags)?;
    let at = block.at();
    block.skip("message", length)?;
    Ok(Some(Message { kind, shared: flags & 2 != 0, at, length }))
}
