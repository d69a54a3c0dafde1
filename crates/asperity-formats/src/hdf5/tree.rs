//! B-trees: version 1 for symbol tables and chunks, version 2 for dense links and attributes.

use super::{File, Piece};
use crate::{Result, refuse_if};

/// Maximum number of levels of a version 2 tree. Each level multiplies the records at least by ten.
const MAX_DEPTH: u16 = 16;
/// Size in bytes of an inner node of version 2 without records: signature, version, type, checksum.
const NODE_BYTES: usize = 10;

/// Keys of a version 1 tree: the number of their kind in the file, and their size in bytes.
#[derive(Clone, Copy)]
pub(super) struct Keys {
    pub(super) kind: u8,
    pub(super) bytes: usize,
}

/// Layout of the nodes of a version 2 tree.
struct Nodes {
    node_bytes: usize,
    record_bytes: usize,
    /// Size in bytes of the number of records in a child.
    count_bytes: usize,
    /// For each level, size in bytes of the number of all records below a node of that level.
    total_bytes: Vec<usize>,
}

/// Callback for a key and its address.
pub(super) type VisitKey<'v, 'a> = dyn FnMut(Piece<'a>, usize) -> Result<()> + 'v;
/// Callback for a record or an object.
pub(super) type Visit<'v, 'a> = dyn FnMut(Piece<'a>) -> Result<()> + 'v;

impl<'a> File<'a> {
    /// Passes every leaf of a version 1 tree to `visit`: its key and its address.
    pub(super) fn visit_tree(&self, root: usize, keys: Keys, visit: &mut VisitKey<'_, 'a>) -> Result<()> {
        self.visit_node(root, keys, None, visit)
    }

    fn visit_node(&self, at: usize, keys: Keys, wanted_level: Option<u8>, visit: &mut VisitKey<'_, 'a>) -> Result<()> {
        let mut node = self.piece("B-tree node", at, 24)?;
        node.expect("signature", b"TREE")?;
        node.expect("type", &[keys.kind])?;
        let level_at = node.at();
        let level = node.u8("level")?;
        // Levels decrease towards the leaves, which limits the depth.
        if wanted_level.is_some_and(|wanted| wanted != level) {
            return Err(node.wrong("level", level_at, level, "one less than that of the node above"));
        }
        let entries = usize::from(node.u16("entries")?);
        let mut entry = self.piece("B-tree node", at + 24, entries * (keys.bytes + 8))?;
        for _ in 0..entries {
            let key = entry.split("B-tree key", keys.bytes)?;
            let child = entry.address("child")?;
            match level.checked_sub(1) {
                None => visit(key, child)?,
                below => self.visit_node(child, keys, below, visit)?,
            }
        }
        Ok(())
    }

    /// Passes every object of a dense index to `visit`.
    ///
    /// `info` is the message that leads to the index, `order_bytes` the size of its optional creation order. The records of
    /// the tree hold `hash_bytes` bytes before the identifier of the object in the heap.
    pub(super) fn visit_dense(
        &self,
        mut info: Piece<'a>,
        order_bytes: usize,
        hash_bytes: usize,
        visit: &mut Visit<'_, 'a>,
    ) -> Result<()> {
        info.version(&[0])?;
        if info.u8("flags")? & 1 != 0 {
            info.skip("creation order", order_bytes)?;
        }
        let Some(heap) = info.optional_address("address of the heap")? else { return Ok(()) };
        let heap = self.fractal_heap(heap)?;
        self.visit_records(info.address("address of the tree")?, &mut |mut record| {
            record.skip("hash", hash_bytes)?;
            self.managed(&heap, record)?.map_or(Ok(()), &mut *visit)
        })
    }

    /// Passes every record of a version 2 tree to `visit`.
    fn visit_records(&self, header: usize, visit: &mut Visit<'_, 'a>) -> Result<()> {
        let mut head = self.piece("B-tree header", header, 4 + 1 + 1 + 4 + 2 + 2 + 2 + 8 + 2)?;
        head.expect("signature", b"BTHD")?;
        head.version(&[0])?;
        head.skip("type", 1)?;
        let node_bytes = head.size("node size", 4)?;
        let record_at = head.at();
        let record_bytes = usize::from(head.u16("record size")?);
        let depth_at = head.at();
        let depth = head.u16("depth")?;
        head.skip("percentages", 2)?;
        let Some(root) = head.optional_address("root")? else { return Ok(()) };
        let count = usize::from(head.u16("records in the root")?);
        if record_bytes == 0 || node_bytes < NODE_BYTES + record_bytes {
            return Err(head.wrong("record size", record_at, record_bytes, "1 to the size of a node"));
        }
        refuse_if!(depth > MAX_DEPTH, head.wrong("depth", depth_at, depth, &format!("at most {MAX_DEPTH}")));
        let nodes = Nodes::new(node_bytes, record_bytes, depth);
        self.visit_record_node(root, usize::from(depth), count, &nodes, visit)
    }

    fn visit_record_node(
        &self,
        at: usize,
        level: usize,
        count: usize,
        nodes: &Nodes,
        visit: &mut Visit<'_, 'a>,
    ) -> Result<()> {
        let total_bytes = if level > 1 { nodes.total_bytes[level - 1] } else { 0 };
        let child_bytes = if level > 0 { 8 + nodes.count_bytes + total_bytes } else { 0 };
        if count > (nodes.node_bytes - NODE_BYTES) / nodes.record_bytes {
            return Err(self.input.wrong("B-tree node, number of records", at, count, "as many as a node holds"));
        }
        let length = 6 + count * nodes.record_bytes + (count + 1) * child_bytes;
        let mut node = self.piece("B-tree node", at, length)?;
        node.expect("signature", if level > 0 { b"BTIN" } else { b"BTLF" })?;
        node.version(&[0])?;
        node.skip("type", 1)?;
        for _ in 0..count {
            visit(node.split("B-tree record", nodes.record_bytes)?)?;
        }
        if level > 0 {
            for _ in 0..=count {
                let child = node.address("child")?;
                let records = node.size("records in the child", nodes.count_bytes)?;
                node.skip("records below the child", total_bytes)?;
                self.visit_record_node(child, level - 1, records, nodes, visit)?;
            }
        }
        Ok(())
    }
}

impl Nodes {
    /// Computes the widths of numbers from the maximum number of records in the nodes of each level.
    fn new(node_bytes: usize, record_bytes: usize, depth: u16) -> Self {
        let in_leaf = ((node_bytes - NODE_BYTES) / record_bytes) as u64;
        let count_bytes = width(in_leaf);
        let (mut below, mut total_bytes) = (in_leaf, vec![0]);
        for level in 1..=usize::from(depth) {
            let pointer = 8 + count_bytes + total_bytes[level - 1];
            let here = (node_bytes.saturating_sub(NODE_BYTES + pointer) / (record_bytes + pointer)) as u64;
            below = (here + 1).saturating_mul(below).saturating_add(here);
            total_bytes.push(width(below));
        }
        Self { node_bytes, record_bytes, count_bytes, total_bytes }
    }
}

/// Returns the number of bytes of numbers up to `limit`.
pub(super) fn width(limit: u64) -> usize {
    limit.max(1).ilog2() as usize / 8 + 1
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_take_as_many_bytes_as_their_limit() {
        for (limit, bytes) in [(0, 1), (1, 1), (255, 1), (256, 2), (65535, 2), (65536, 3), (u64::MAX, 8)] {
            assert_eq!(width(limit), bytes, "{limit}");
        }
    }

    #[test]
    fn widths_in_inner_nodes_follow_from_the_capacity_of_the_levels_below() {
        // Nodes of 512 bytes with records of 17: 29 in a leaf; (512 − 10 − 9) / (17 + 9) = 18 above, with 19 · 29 + 18
        // = 569 records below; (512 − 10 − 11) / (17 + 11) = 17 above that.
        let nodes = Nodes::new(512, 17, 2);
        assert_eq!((nodes.count_bytes, nodes.total_bytes), (1, vec![0, 2, 2]));
    }
}
