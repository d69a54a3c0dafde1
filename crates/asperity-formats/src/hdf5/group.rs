//! Groups: names and addresses of their objects.

use super::header::{LINK, LINK_INFO, SYMBOL_TABLE};
use super::{File, Keys, Object, Piece};
use crate::Result;

/// Keys of the tree of a symbol table: offsets of names.
const NAMES: Keys = Keys { kind: 0, bytes: 8 };
/// Kind of a soft link in a symbol table entry.
const SOFT_ENTRY: u32 = 2;
/// Size in bytes of the hash of a name before a heap identifier.
const HASH_BYTES: usize = 4;

/// Hard link. Soft and external links are skipped: their targets have hard links of their own or are not in the file.
pub(crate) struct Link<'a> {
    pub(crate) name: &'a [u8],
    pub(crate) address: usize,
}

impl<'a> File<'a> {
    /// Returns the links of a group; none for a dataset.
    pub(crate) fn links(&self, object: &Object) -> Result<Vec<Link<'a>>> {
        let mut links = Vec::new();
        let mut push = |link: Option<Link<'a>>| {
            links.extend(link);
            self.check_count("the number of links", object.at, links.len())
        };
        for message in object.all(LINK) {
            push(link(self.message(message, "link message")?)?)?;
        }
        if let Some(message) = object.first(LINK_INFO) {
            let info = self.message(message, "link info message")?;
            self.visit_dense(info, 8, HASH_BYTES, &mut |found| push(link(found)?))?;
        }
        if let Some(message) = object.first(SYMBOL_TABLE) {
            let mut table = self.message(message, "symbol table message")?;
            let (tree, heap) = (table.address("address of the tree")?, table.address("address of the heap")?);
            let heap = self.local_heap(heap)?;
            self.visit_tree(tree, NAMES, &mut |_, node| {
                let mut head = self.piece("symbol table node", node, 8)?;
                head.expect("signature", b"SNOD")?;
                head.version(&[1])?;
                head.skip("reserved", 1)?;
                let count = usize::from(head.u16("number of symbols")?);
                let mut entries = self.piece("symbol table node", node + 8, count * 40)?;
                for _ in 0..count {
                    let name = entries.size("offset of the name", 8)?;
                    let address = entries.optional_address("address")?;
                    let kind = entries.u32("kind")?;
                    entries.skip("cache", 20)?;
                    if let Some(address) = address.filter(|_| kind != SOFT_ENTRY) {
                        push(Some(Link { name: self.name(&heap, name)?, address }))?;
                    }
                }
                Ok(())
            })?;
        }
        Ok(links)
    }
}

/// Returns the link in a link message; `None` for soft and external links.
fn link(mut message: Piece) -> Result<Option<Link>> {
    message.version(&[1])?;
    let flags = message.u8("flags")?;
    let kind = if flags & 1 << 3 != 0 { message.u8("kind")? } else { 0 };
    if flags & 1 << 2 != 0 {
        message.skip("creation order", 8)?;
    }
    if flags & 1 << 4 != 0 {
        message.skip("character set", 1)?;
    }
    let length = message.size("length of the name", 1 << (flags & 3))?;
    let name = message.take("name", length)?;
    if kind != 0 {
        return Ok(None);
    }
    Ok(Some(Link { name, address: message.address("address")? }))
}
