//! Structures that refer to themselves, and sizes beyond the end of the file.

use super::*;

/// Reads a malicious file within the limits of time and memory.
fn read_harmful(bytes: &[u8]) -> Result<Scan, FormatError> {
    let start = std::time::Instant::now();
    let (scan, peak) = crate::memory::peak_bytes(|| read_bytes(bytes));
    let took = start.elapsed();
    assert!(took < crate::memory::TIME_LIMIT, "{took:?}");
    assert!(peak <= (64 << 20) + 2 * bytes.len(), "{peak} bytes of memory for {} of input", bytes.len());
    scan
}

#[test]
fn a_tree_whose_nodes_are_shared_ends_as_an_error() {
    let mut file = Hdf5::new();
    let mut node = file.append(&bytes![b"SNOD", [1_u8, 0], [0_u8, 0]]);
    // Each level refers sixty times to the one below: 60⁸ symbol table nodes.
    for level in 0..8 {
        let children = vec![(vec![0; 8], node); 60];
        node = file.tree(0, level, &children, &[0; 8]);
    }
    let heap = file.append(&bytes![b"HEAP", [0_u8; 4], 8_u64, 1_u64, node]);
    let root = file.object(&[(hdf5::SYMBOL_TABLE, bytes![node, heap])]);
    assert_error(read_harmful(&file.finish(0, root)), "shared too often");
}

#[test]
fn a_tree_that_is_its_own_child_ends_as_an_error() {
    let mut file = Hdf5::new();
    let next = file.append(&[]);
    let node = file.tree(0, 1, &[(vec![0; 8], next)], &[0; 8]);
    assert_eq!(node, next);
    let root = file.object(&[(hdf5::SYMBOL_TABLE, bytes![node, node])]);
    assert!(read_harmful(&file.finish(0, root)).is_err());
}

#[test]
fn a_header_that_goes_on_in_itself_ends_as_an_error() {
    let mut file = Hdf5::new();
    // A continuation of the 24 bytes of this very message.
    let next = file.append(&[]);
    let root = file.object(&[(0x10, bytes![(next + 16), 24_u64])]);
    assert_eq!(root, next);
    assert_error(read_harmful(&file.finish(0, root)), "the number of messages");
}

#[test]
fn a_text_that_many_attributes_share_takes_no_memory() {
    let mut file = Hdf5::with_heap(1 << 21);
    let text = vec![b'x'; 1 << 20];
    let reference = file.keep(&text);
    let attributes: Vec<Message> = (0..3000)
        .map(|number| attribute(&format!("text {number}"), &datatype::long_text(), &reference.of(text.len())))
        .collect();
    let described = file.group(&[], &attributes);
    let described = file.group(&[("{A}", described)], &[]);
    let map = Map::default().append(&mut file);
    let kind = file.group(&[("{1}", map)], &[]);
    let data = file.group(&[("Surface", kind)], &[]);
    let root = file.group(&[("Attributes", described), ("Data", data)], &[]);
    let scan = read_harmful(&file.finish(0, root)).unwrap();
    assert_eq!(scan.heights_m[[0, 0]], 100e-9);
}

#[test]
fn shapes_that_the_bytes_cannot_fill_are_refused() {
    let huge = read_harmful(&one(Map { shape: [1 << 31, 1 << 31], ..Map::default() }));
    assert!(matches!(huge, Err(FormatError::TooLarge { .. })), "{huge:?}");
    let long = read_harmful(&one(Map { shape: [1 << 14, 1 << 14], ..Map::default() }));
    assert!(matches!(long, Err(FormatError::Truncated { wanted: 0x8000_0000, .. })), "{long:?}");
    // Chunks that were never written would be filled, and chunks far larger than the map unpacked.
    for (shape, chunk) in [([1 << 12, 1 << 12], [16, 16]), ([2, 3], [1 << 15, 1 << 15])] {
        let map = Map { shape, store: Store::Chunked(chunk, vec![], vec![]), ..Map::default() };
        let refused = read_harmful(&one(map));
        assert!(matches!(refused, Err(FormatError::TooLarge { .. })), "{refused:?}");
    }
}

#[test]
fn chunks_that_are_there_twice_or_off_their_grid_or_too_short_are_refused() {
    let numbers = Map::default().numbers;
    let chunk = |row, column, bytes: &[u8]| ([row, column], 0, bytes.to_vec());
    for (chunks, reason) in [
        (vec![chunk(0, 0, &numbers), chunk(0, 0, &numbers)], "a place of its own"),
        (vec![chunk(1, 0, &numbers)], "a multiple of the chunk size"),
        (vec![chunk(2, 0, &numbers)], "a multiple of the chunk size"),
        (vec![chunk(0, 0, &numbers[1..])], "it unpacks to 47 bytes; wanted 48"),
    ] {
        let map = Map { store: Store::Chunked([2, 3], vec![], chunks), ..Map::default() };
        assert_refused([(one(map), reason)]);
    }
    let bomb = zlib(&[numbers.clone(), numbers].concat());
    let map = Map { store: Store::Chunked([2, 3], pipeline(&[(1, 6)]), vec![([0, 0], 0, bomb)]), ..Map::default() };
    assert_refused([(one(map), "it unpacks to 52 bytes; wanted 48")]);
}
