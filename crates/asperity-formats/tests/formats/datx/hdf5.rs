//! HDF5 files assembled structure by structure from the HDF5 File Format Specification, version 3.0. Comments give
//! the numbers of its sections.
//!
//! A structure is appended after all structures that it refers to, so their addresses are known. The superblock comes
//! last.

use crate::check::bytes;

/// Address that marks an absent object.
pub(crate) const UNDEFINED: u64 = u64::MAX;

/// Types of object header messages (IV.A.2).
pub(crate) const DATASPACE: u16 = 0x01;
pub(crate) const LINK_INFO: u16 = 0x02;
pub(crate) const DATATYPE: u16 = 0x03;
pub(crate) const FILL_VALUE: u16 = 0x05;
pub(crate) const LINK: u16 = 0x06;
pub(crate) const LAYOUT: u16 = 0x08;
pub(crate) const FILTERS: u16 = 0x0b;
pub(crate) const ATTRIBUTE: u16 = 0x0c;
pub(crate) const SYMBOL_TABLE: u16 = 0x11;
pub(crate) const ATTRIBUTE_INFO: u16 = 0x15;

/// A message: its type and content.
pub(crate) type Message = (u16, Vec<u8>);

/// The bytes of a file: room for its superblock, a global heap collection, other structures.
pub(crate) struct Hdf5 {
    bytes: Vec<u8>,
    /// Objects in the collection and where the next one goes.
    objects: u16,
    free: usize,
    heap_bytes: usize,
}

/// Offset of the first structure, the global heap: after the superblock of version 1, which is the longest.
const START: usize = 104;
/// The least size of a collection (III.E).
const HEAP_BYTES: usize = 4096;
/// Ranks of the leaves and inner nodes of groups, and of inner nodes over chunks: half of the entries that fit.
const LEAF_RANK: u16 = 2;
const GROUP_RANK: u16 = 2;
const CHUNK_RANK: u16 = 2;

fn padded(bytes: &[u8]) -> Vec<u8> {
    let mut padded = bytes.to_vec();
    padded.resize(bytes.len().next_multiple_of(8), 0);
    padded
}

impl Hdf5 {
    pub(crate) fn new() -> Self {
        Self::with_heap(HEAP_BYTES)
    }

    /// With a larger collection.
    pub(crate) fn with_heap(heap_bytes: usize) -> Self {
        let mut bytes = vec![0; START];
        // Signature, version, reserved, size of the collection.
        bytes.extend(bytes![b"GCOL", [1_u8], [0_u8; 3], heap_bytes as u64]);
        let free = bytes.len();
        bytes.resize(START + heap_bytes, 0);
        Self { bytes, objects: 0, free, heap_bytes }
    }

    /// Puts an object into the global heap (III.E).
    pub(crate) fn keep(&mut self, object: &[u8]) -> Reference {
        self.objects += 1;
        // Index, reference count, reserved, size; the object itself is padded.
        let entry = bytes![self.objects, 1_u16, [0_u8; 4], object.len() as u64, padded(object),];
        self.bytes[self.free..self.free + entry.len()].copy_from_slice(&entry);
        self.free += entry.len();
        // The free space at the end is object 0; its size counts this header.
        let left = (START + self.heap_bytes - self.free) as u64;
        let end = bytes![[0_u8; 8], left];
        self.bytes[self.free..self.free + 16].copy_from_slice(&end);
        Reference { address: START as u64, index: self.objects.into() }
    }

    /// Appends a structure at a multiple of 8 bytes; its address.
    pub(crate) fn append(&mut self, structure: &[u8]) -> u64 {
        self.bytes.resize(self.bytes.len().next_multiple_of(8), 0);
        let address = self.bytes.len() as u64;
        self.bytes.extend(structure);
        address
    }

    /// A version 1 object header (IV.A.1.a).
    pub(crate) fn object(&mut self, messages: &[Message]) -> u64 {
        let content = old_messages(messages);
        self.append(&bytes![
            // Version, reserved, number of messages.
            [1_u8, 0],
            messages.len() as u16,
            // Reference count, size of the messages, padding to 8 bytes.
            1_u32,
            content.len() as u32,
            [0_u8; 4],
            content,
        ])
    }

    /// A version 2 object header (IV.A.1.b) whose first piece has a size of 2 bytes.
    pub(crate) fn new_object(&mut self, messages: &[Message]) -> u64 {
        let mut content = Vec::new();
        for (kind, message) in messages {
            // Type, size, flags.
            content.extend(bytes![[*kind as u8], message.len() as u16, [0_u8], message]);
        }
        let header = bytes![b"OHDR", [2_u8], [1_u8], content.len() as u16, content];
        let sum = lookup3(&header);
        self.append(&bytes![header, sum])
    }

    /// The message of a group that is a symbol table (III.A.1, III.B, III.D), with links in the order of their names.
    pub(crate) fn symbol_table(&mut self, links: &[(&str, u64)]) -> Message {
        let mut links = links.to_vec();
        links.sort_unstable();
        // Offset 0 holds the empty name.
        let (mut names, mut symbols) = (vec![0; 8], Vec::new());
        let mut last = 0_u64;
        for (name, address) in &links {
            last = names.len() as u64;
            // Offset of the name, address, kind of cache, reserved, scratch.
            symbols.extend(bytes![last, address, [0_u8; 4], [0_u8; 4], [0_u8; 16]]);
            names.extend(padded(format!("{name}\0").as_bytes()));
        }
        let segment = self.append(&names);
        // Signature, version, reserved, size of the segment, no free list, address of the segment.
        let size = names.len() as u64;
        let heap = self.append(&bytes![b"HEAP", [0_u8], [0_u8; 3], size, 1_u64, segment]);
        symbols.resize(2 * usize::from(LEAF_RANK) * 40, 0);
        let count = (links.len() as u16).to_le_bytes();
        let node = self.append(&bytes![b"SNOD", [1_u8], [0_u8], count, symbols]);
        // Keys are offsets of names: below the first, and the last.
        let tree = self.tree(0, 0, &[(0_u64.to_le_bytes().to_vec(), node)], &last.to_le_bytes());
        (SYMBOL_TABLE, bytes![tree, heap])
    }

    /// A group of old style.
    pub(crate) fn group(&mut self, links: &[(&str, u64)], attributes: &[Message]) -> u64 {
        let table = self.symbol_table(links);
        self.object(&[&[table], attributes].concat())
    }

    /// Appends a node of a version 1 B-tree (III.A.1): its keys, their addresses, and the key after the last.
    pub(crate) fn tree(&mut self, kind: u8, level: u8, children: &[(Vec<u8>, u64)], last: &[u8]) -> u64 {
        let mut entries = Vec::new();
        for (key, child) in children {
            entries.extend(bytes![key, child]);
        }
        // Nodes have room for all entries that fit, and one more key.
        let room = 2 * usize::from(if kind == 0 { GROUP_RANK } else { CHUNK_RANK });
        entries.extend(last);
        entries.resize(entries.len().max(room * (last.len() + 8) + last.len()), 0);
        // Signature, type, level, entries, no siblings.
        self.append(&bytes![b"TREE", [kind, level], children.len() as u16, UNDEFINED, UNDEFINED, entries,])
    }

    /// The file with a superblock (II.A) of version 0 before it, or of version 1, which states the rank over chunks.
    pub(crate) fn finish(mut self, version: u8, root: u64) -> Vec<u8> {
        let chunk_rank = if version == 1 { bytes![CHUNK_RANK, [0_u8; 2]] } else { vec![] };
        let superblock = bytes![
            b"\x89HDF\r\n\x1a\n",
            // Versions of the superblock, of free space, of the root entry; reserved; version of shared messages.
            [version, 0, 0, 0, 0],
            // Sizes of offsets and lengths, reserved.
            [8_u8, 8, 0],
            LEAF_RANK,
            GROUP_RANK,
            // Flags.
            [0_u8; 4],
            chunk_rank,
            // Base address, free space, end of file, driver.
            0_u64,
            UNDEFINED,
            self.bytes.len() as u64,
            UNDEFINED,
            // The root: offset of its name, address of its header, no cache, reserved, scratch.
            0_u64,
            root,
            [0_u8; 8],
            [0_u8; 16],
        ];
        self.bytes[..superblock.len()].copy_from_slice(&superblock);
        self.bytes
    }

    /// The file with a version 2 superblock (II.B) before it.
    pub(crate) fn finish_new(mut self, root: u64) -> Vec<u8> {
        let superblock = bytes![
            b"\x89HDF\r\n\x1a\n",
            // Version, sizes of offsets and lengths, flags.
            [2_u8, 8, 8, 0],
            // Base address, no extension, end of file, root.
            0_u64,
            UNDEFINED,
            self.bytes.len() as u64,
            root,
        ];
        let sum = lookup3(&superblock);
        let superblock = bytes![superblock, sum];
        self.bytes[..superblock.len()].copy_from_slice(&superblock);
        self.bytes
    }

    /// The message of links in a fractal heap under a tree by the hashes of their names.
    pub(crate) fn dense_links(&mut self, links: &[(&str, u64)]) -> Message {
        let mut objects: Vec<Dense> = links
            .iter()
            .map(|(name, address)| Dense { hash: lookup3(name.as_bytes()), content: link(name, *address) })
            .collect();
        objects.sort_by_key(|object| object.hash);
        // A record of type 5: hash, identifier.
        let record = |object: &Dense, id: Vec<u8>| bytes![object.hash, id];
        let (heap, tree) = self.dense(5, 7, &objects, record);
        // Version, flags, heap, tree.
        (LINK_INFO, bytes![[0_u8, 0], heap, tree])
    }

    /// The message of attributes in a fractal heap.
    pub(crate) fn dense_attributes(&mut self, attributes: &[(&str, Vec<u8>)]) -> Message {
        let hashed =
            |(name, content): &(&str, Vec<u8>)| Dense { hash: lookup3(name.as_bytes()), content: content.clone() };
        let mut objects: Vec<Dense> = attributes.iter().map(hashed).collect();
        objects.sort_by_key(|object| object.hash);
        // A record of type 8: identifier, flags, creation order, hash.
        let record = |object: &Dense, id: Vec<u8>| bytes![id, [0_u8], [0_u8; 4], object.hash];
        let (heap, tree) = self.dense(8, 8, &objects, record);
        (ATTRIBUTE_INFO, bytes![[0_u8, 0], heap, tree])
    }

    /// Objects in a fractal heap (III.G) under a version 2 B-tree (III.A.2): the addresses of both.
    fn dense(
        &mut self,
        kind: u8,
        id_bytes: usize,
        objects: &[Dense],
        record: impl Fn(&Dense, Vec<u8>) -> Vec<u8>,
    ) -> (u64, u64) {
        // The header of the heap refers to the block and the block to the header, which has a known size.
        let heap_address = self.append(&[]);
        let block_address = heap_address + 146_u64.next_multiple_of(8);
        let block_bytes = 512_u64;
        let mut block = bytes![b"FHDB", [0_u8], heap_address, 0_u32];
        let mut records = Vec::new();
        for object in objects {
            // Kind 0, an offset of 4 bytes, a length of 2 bytes.
            let mut id = bytes![[0_u8], block.len() as u32, object.content.len() as u16];
            id.resize(id_bytes, 0);
            records.extend(record(object, id));
            block.extend(&object.content);
        }
        let free = block_bytes - block.len() as u64;
        block.resize(block_bytes as usize, 0);
        let heap = bytes![
            b"FRHP",
            [0_u8],
            // Bytes of an identifier, of filters; flags.
            id_bytes as u16,
            [0_u8; 2],
            [0_u8],
            // Largest managed object; next huge object and their tree; free space and its manager.
            512_u32,
            0_u64,
            UNDEFINED,
            free,
            UNDEFINED,
            // Managed space, allocated, iterator, objects; huge objects: bytes, number; tiny ones: bytes, number.
            block_bytes,
            block_bytes,
            block_bytes,
            objects.len() as u64,
            [0_u8; 32],
            // Width of the table, first and largest block, bits of the heap, rows at the start.
            4_u16,
            block_bytes,
            65536_u64,
            32_u16,
            1_u16,
            // The root is a direct block, so that it has no rows.
            block_address,
            0_u16,
        ];
        let sum = lookup3(&heap);
        assert_eq!(self.append(&bytes![heap, sum]), heap_address);
        assert_eq!(self.append(&block), block_address);
        let node_bytes = 256_usize;
        let record_bytes = records.len() / objects.len();
        // A leaf: signature, version, type, records, checksum; a node has its full size.
        let mut leaf = bytes![b"BTLF", [0_u8, kind], records];
        let sum = lookup3(&leaf);
        leaf.extend(sum.to_le_bytes());
        leaf.resize(node_bytes, 0);
        let leaf = self.append(&leaf);
        let header = bytes![
            b"BTHD",
            [0_u8, kind],
            // Bytes of a node and a record, depth, percentages of splitting and merging.
            node_bytes as u32,
            record_bytes as u16,
            0_u16,
            [100_u8, 40],
            leaf,
            objects.len() as u16,
            objects.len() as u64,
        ];
        let sum = lookup3(&header);
        (heap_address, self.append(&bytes![header, sum]))
    }
}

/// An object in a fractal heap and the hash of its name.
struct Dense {
    hash: u32,
    content: Vec<u8>,
}

/// A value of variable length in a global heap.
#[derive(Clone, Copy)]
pub(crate) struct Reference {
    pub(crate) address: u64,
    pub(crate) index: u32,
}

impl Reference {
    /// Its number of elements before it (III.E, variable-length data).
    pub(crate) fn of(self, elements: usize) -> Vec<u8> {
        bytes![elements as u32, self.address, self.index]
    }
}

/// Messages of version 1: type, size, flags, reserved, content in multiples of 8 bytes.
pub(crate) fn old_messages(messages: &[Message]) -> Vec<u8> {
    let mut content = Vec::new();
    for (kind, message) in messages {
        let message = padded(message);
        content.extend(bytes![kind, message.len() as u16, [0_u8; 4], message]);
    }
    content
}

/// Datatypes of version 1 (IV.A.2.d): class and version, bits of the class, size, properties.
pub(crate) mod datatype {
    use crate::check::bytes;

    /// Two's complement; bit 0 is the byte order, bit 3 the sign. Bit offset and precision.
    pub(crate) fn integer(bytes: u8, is_big_endian: bool) -> Vec<u8> {
        let bits = 8 | u8::from(is_big_endian);
        bytes![[0x10_u8, bits, 0, 0], u32::from(bytes), 0_u16, 8 * u16::from(bytes)]
    }

    /// IEEE 754. The bits are the byte order, the implied one before the point (2 in bits 4 and 5), and the place of
    /// the sign.
    pub(crate) fn float(bytes: u8, is_big_endian: bool) -> Vec<u8> {
        let (exponent, mantissa, bias) = if bytes == 4 { (8, 23, 127_u32) } else { (11, 52, 1023) };
        let precision = 8 * u16::from(bytes);
        bytes![
            [0x11_u8, 0x20 | u8::from(is_big_endian), precision as u8 - 1, 0],
            u32::from(bytes),
            // Bit offset and precision; place and size of the exponent, of the mantissa; bias.
            0_u16,
            precision,
            [mantissa, exponent, 0_u8, mantissa],
            bias,
        ]
    }

    /// Text of a fixed size, filled with zeros.
    pub(crate) fn text(bytes: u32) -> Vec<u8> {
        bytes![[0x13_u8, 1, 0, 0], bytes]
    }

    /// Text of variable length: type 1, in UTF-8, over bytes.
    pub(crate) fn long_text() -> Vec<u8> {
        let byte = bytes![[0x10_u8, 0, 0, 0], 1_u32, 0_u16, 8_u16];
        bytes![[0x19_u8, 1, 1, 0], 16_u32, byte]
    }

    /// A sequence of variable length.
    pub(crate) fn sequence(base: &[u8]) -> Vec<u8> {
        bytes![[0x19_u8, 0, 0, 0], 16_u32, base]
    }

    /// The address of an object.
    pub(crate) fn reference() -> Vec<u8> {
        bytes![[0x17_u8, 0, 0, 0], 8_u32]
    }

    /// Parts side by side: name, bytes, type.
    pub(crate) fn compound(members: &[(&str, u32, Vec<u8>)]) -> Vec<u8> {
        let size: u32 = members.iter().map(|(_, bytes, _)| bytes).sum();
        let mut datatype = bytes![[0x16_u8], &(members.len() as u32).to_le_bytes()[..3], size];
        let mut offset = 0_u32;
        for (name, bytes, base) in members {
            let mut name = format!("{name}\0").into_bytes();
            name.resize(name.len().next_multiple_of(8), 0);
            // Offset; no dimensions, reserved, permutation, reserved, four sizes.
            datatype.extend(bytes![name, offset, [0_u8; 28], base]);
            offset += bytes;
        }
        datatype
    }
}

/// A version 1 dataspace (IV.A.2.b): version, rank, no flags, reserved, sizes.
pub(crate) fn dataspace(shape: &[u64]) -> Vec<u8> {
    let sizes: Vec<u8> = shape.iter().flat_map(|size| size.to_le_bytes()).collect();
    bytes![[1_u8, shape.len() as u8, 0, 0], [0_u8; 4], sizes]
}

/// A version 1 attribute of one element (IV.A.2.m): its parts are padded.
pub(crate) fn attribute(name: &str, datatype: &[u8], value: &[u8]) -> Message {
    let (name, space) = (format!("{name}\0"), dataspace(&[1]));
    let message = bytes![
        [1_u8, 0],
        name.len() as u16,
        datatype.len() as u16,
        space.len() as u16,
        padded(name.as_bytes()),
        padded(datatype),
        padded(&space),
        value,
    ];
    (ATTRIBUTE, message)
}

/// A version 3 attribute of elements in a row: its parts follow each other.
pub(crate) fn new_attribute(name: &str, datatype: &[u8], count: u64, value: &[u8]) -> Vec<u8> {
    let (name, space) = (format!("{name}\0"), dataspace(&[count]));
    bytes![
        // Version, flags, sizes, character set.
        [3_u8, 0],
        name.len() as u16,
        datatype.len() as u16,
        space.len() as u16,
        [0_u8],
        name.as_bytes(),
        datatype,
        space,
        value,
    ]
}

/// A link to an object (IV.A.2.g): version, flags (the length of the name has 1 byte), length, name, address.
pub(crate) fn link(name: &str, address: u64) -> Vec<u8> {
    bytes![[1_u8, 0, name.len() as u8], name.as_bytes(), address]
}

/// A contiguous layout of version 3 (IV.A.2.i).
pub(crate) fn contiguous(address: u64, bytes: u64) -> Message {
    (LAYOUT, bytes![[3_u8, 1], address, bytes])
}

/// A fill value of version 2 (IV.A.2.f): allocated late, written when set.
pub(crate) fn fill_value(value: &[u8]) -> Message {
    (FILL_VALUE, bytes![[2_u8, 2, 2, u8::from(!value.is_empty())], value.len() as u32, value])
}

/// Bob Jenkins' lookup3 with the start value 0, the checksum of metadata (II.B).
fn lookup3(bytes: &[u8]) -> u32 {
    /// Steps of a turn for the three words: the word, and the rotation of its predecessor.
    const FINAL: [(usize, u32); 7] = [(2, 14), (0, 11), (1, 25), (2, 16), (0, 4), (1, 14), (2, 24)];
    const MIX: [(usize, u32); 6] = [(0, 4), (1, 6), (2, 8), (0, 16), (1, 19), (2, 4)];
    let mut words = [0xdead_beef_u32.wrapping_add(bytes.len() as u32); 3];
    let blocks = bytes.chunks(12);
    let last = blocks.len();
    for (number, block) in blocks.enumerate() {
        let mut filled = [0; 12];
        filled[..block.len()].copy_from_slice(block);
        for (word, raw) in words.iter_mut().zip(filled.as_chunks().0) {
            *word = word.wrapping_add(u32::from_le_bytes(*raw));
        }
        if number + 1 == last {
            for (place, turn) in FINAL {
                let before = words[(place + 2) % 3];
                words[place] = (words[place] ^ before).wrapping_sub(before.rotate_left(turn));
            }
        } else {
            for (place, turn) in MIX {
                let before = words[(place + 2) % 3];
                words[place] = words[place].wrapping_sub(before) ^ before.rotate_left(turn);
                words[(place + 2) % 3] = before.wrapping_add(words[(place + 1) % 3]);
            }
        }
    }
    words[2]
}

#[test]
fn the_checksum_equals_the_published_examples() {
    // From the comments of lookup3.c, for the start value 0.
    assert_eq!(lookup3(b""), 0xdead_beef);
    assert_eq!(lookup3(b"Four score and seven years ago"), 0x1777_0551);
}
