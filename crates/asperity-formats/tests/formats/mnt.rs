//! MNT files after the entries that SurfaceTopography describes.

use std::io::{Cursor, Write};

use asperity_formats::{Format, FormatError, Scan};

use crate::assert_heights;
use crate::check::{Raw, assert_error, assert_refused, assert_scan, bytes};
use crate::fixture::{Fixture, read_bytes, read_channel};
use crate::fixtures::zlib;

fn entry(tag: u16, value: impl Raw) -> Vec<u8> {
    let value = bytes![value];
    bytes![tag, value.len() as u64, value]
}

/// An entry of entries.
fn tree(tag: u16, entries: &[Vec<u8>]) -> Vec<u8> {
    entry(tag, entries)
}

fn text(tag: u16, text: &str) -> Vec<u8> {
    entry(tag, bytes![4_u8, text.encode_utf16().collect::<Vec<_>>()])
}

fn class(number: u32) -> Vec<u8> {
    tree(1, &[entry(1, number)])
}

/// An object after its size.
fn object(entries: &[Vec<u8>]) -> Vec<u8> {
    let object = tree(1, entries);
    bytes![object.len() as u64, object]
}

fn scale(step: f64, unit: &str, origin: f64, origin_unit: &str) -> Vec<u8> {
    let label = tree(0xffff, &[entry(1, 0_u32), text(2, "Axis")]);
    tree(0xffff, &[label, entry(1, step), text(2, unit), text(3, origin_unit), entry(5, origin)])
}

fn lateral(tag: u16, step: f64, points: u32) -> Vec<u8> {
    tree(tag, &[tree(0xffff, &[scale(step, "\u{b5}m", 7.0, "mm"), entry(1, points)])])
}

/// An array in blocks, each with its first number and its bytes.
fn array(tag: u16, class_number: u32, count: u32, size: usize, blocks: &[(u64, &[u8])]) -> Vec<u8> {
    let mut data = bytes![u64::from(count) * size as u64];
    for (first, bytes) in blocks {
        let packed = zlib(bytes);
        data.extend(bytes![first, (bytes.len() / size) as u32, packed.len() as u32, packed]);
    }
    tree(tag, &[class(class_number), tree(2, &[entry(1, count), entry(2, data)])])
}

/// A surface of 3 × 2 points.
struct Surface {
    name: &'static str,
    unit: &'static str,
    origin_unit: &'static str,
    /// Bytes of a height.
    size: usize,
    /// Places of the blocks, three numbers each.
    blocks: Vec<u64>,
    marks: Option<[u8; 6]>,
    columns: u32,
}

impl Default for Surface {
    fn default() -> Self {
        let (name, unit, origin_unit) = ("Raw", "nm", "\u{b5}m");
        Self { name, unit, origin_unit, size: 4, blocks: vec![3, 0], marks: Some([9, 9, 9, 22, 9, 9]), columns: 3 }
    }
}

impl Surface {
    /// The size of an object and its entry.
    fn object(&self) -> Vec<u8> {
        let bytes = |first: u64| {
            let numbers = NUMBERS.iter().skip(first as usize).take(3);
            numbers.flat_map(|n| n.to_le_bytes()[..self.size].to_vec()).collect::<Vec<u8>>()
        };
        let blocks: Vec<(u64, Vec<u8>)> = self.blocks.iter().map(|&first| (first, bytes(first % 6))).collect();
        let blocks: Vec<(u64, &[u8])> = blocks.iter().map(|(first, bytes)| (*first, bytes.as_slice())).collect();
        let heights = array(1, 9049, 6, self.size, &blocks);
        let mut grid = vec![
            tree(0xffff, &[tree(0xffff, &[text(1, self.name)])]),
            lateral(1, 0.5, self.columns),
            lateral(2, 0.25, 2),
        ];
        if let Some(marks) = self.marks {
            let framed = bytes![[9_u8; 6], marks[..3], [9_u8; 2], marks[3..], [9_u8; 6]];
            let marks = array(5, 9048, 20, 1, &[(0, &framed)]);
            grid.push(tree(3, &[class(9056), tree(2, &[entry(1, 3_u32), entry(2, 2_u32), marks])]));
        }
        let z = tree(2, &[scale(2.0, self.unit, 1.0, self.origin_unit)]);
        let measurement = tree(2, &[tree(0xffff, &[tree(0xffff, &grid), heights, z])]);
        let surface = tree(2, &[tree(0xffff, &[text(4, "Title")]), tree(1, &[class(9062), measurement])]);
        object(&[class(9012), surface])
    }
}

const NUMBERS: [i32; 6] = [1, -2, 3, 4, 5, 6];
const HEIGHTS_M: [f64; 6] = [1.002e-6, 0.996e-6, 1.006e-6, f64::NAN, 1.01e-6, 1.012e-6];

fn mnt(objects: &[Vec<u8>]) -> Vec<u8> {
    let list = tree(2, &[tree(1, objects)]);
    let contents = object(&[tree(0xc8, &[entry(1, 9_u32)]), tree(0x2bd, &[entry(1, objects.len() as u8), list])]);
    let mut file = cfb::CompoundFile::create(Cursor::new(Vec::new())).unwrap();
    file.create_stream("XmlHeader").unwrap().write_all(b"<Document/>").unwrap();
    file.create_stream("ScopedContents").unwrap().write_all(&contents).unwrap();
    file.into_inner().into_inner()
}

fn read(surface: Surface) -> Result<Scan, FormatError> {
    read_bytes(&mnt(&[surface.object()]))
}

pub(crate) fn fixtures() -> Vec<Fixture> {
    vec![Fixture::open_ended("MNT", mnt(&[Surface::default().object()]))]
}

#[test]
fn heights_follow_the_line_of_their_axis_and_marked_points_are_missing() {
    for blocks in [vec![3, 0], vec![0, 3]] {
        let bytes = mnt(&[Surface { blocks, ..Surface::default() }.object()]);
        assert_scan(&bytes, Format::Mnt, (2, 3), (0.5e-6, 0.25e-6), &HEIGHTS_M);
    }
    let scan = read(Surface { size: 2, marks: None, origin_unit: "", ..Surface::default() }).unwrap();
    assert_heights(&scan, &NUMBERS.map(|n| 1e-9 + f64::from(n) * 2e-9));
}

#[test]
fn surfaces_in_other_units_are_left_out_and_named() {
    let surface = |name, unit| Surface { name, unit, ..Surface::default() }.object();
    let study = object(&[class(9013), tree(2, &[])]);
    let bytes = mnt(&[study, surface("Intensity", "LSB"), surface("Left", "nm"), surface("Right", "nm")]);
    let scan = read_bytes(&bytes).unwrap();
    assert_eq!((scan.channels, scan.channel), (vec!["Left".to_owned(), "Right".into()], 0));
    assert!(scan.warnings.concat().contains("`Intensity` (LSB)"), "{:?}", scan.warnings);
    assert_eq!(read_channel(&bytes, "right").unwrap().channel, 1);
}

#[test]
fn documents_without_surfaces_and_blocks_that_do_not_fit_are_refused() {
    assert_refused([(mnt(&[]), "no image")]);
    for (surface, words) in [
        (Surface { unit: "LSB", ..Surface::default() }, "`Raw` (LSB)"),
        (Surface { origin_unit: "V", ..Surface::default() }, "finite lengths"),
        (Surface { columns: 4, ..Surface::default() }, "wanted 8"),
        (Surface { size: 3, ..Surface::default() }, "heights of 3 bytes"),
    ] {
        assert_error(read(surface), words);
    }
    for blocks in [vec![0], vec![0, 0], vec![3], vec![0, 4], vec![0, 3, 6], vec![0, u64::MAX / 6 * 6]] {
        let error = read(Surface { blocks: blocks.clone(), ..Surface::default() }).unwrap_err();
        assert!(matches!(error, FormatError::Field { .. } | FormatError::Truncated { .. }), "{blocks:?}: {error}");
    }
}
