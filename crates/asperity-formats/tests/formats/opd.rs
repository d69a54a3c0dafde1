//! Wyko OPD.

use asperity_formats::{Format, Scan};

use crate::check::{
    assert_error, assert_pitch, assert_refused, assert_scan, assert_warns, bytes, padded, patched, warns,
};
use crate::fixture::{Fixture, read_bytes, read_channel};
use crate::{NAN, assert_heights, assert_metadata, bits};

/// A block: name, type, content.
type Block = (&'static str, i16, Vec<u8>);

/// The file: two bytes, the directory with its own entry, empty entries, the blocks one after the other.
fn file(blocks: &[Block]) -> Vec<u8> {
    let entry = |name: &str, kind: i16, length: usize, attributes: u16| {
        bytes![padded(name, 16), kind, length as i32, attributes]
    };
    let own = entry("Directory", 1, 24 * (blocks.len() + 2), 0xffff);
    let entries: Vec<u8> =
        blocks.iter().flat_map(|(name, kind, content)| entry(name, *kind, content.len(), 8)).collect();
    let contents: Vec<u8> = blocks.iter().flat_map(|(.., content)| content.clone()).collect();
    bytes![[1_u8, 0], own, entries, entry("", 0, 0, 0), contents]
}

/// An array of columns, each from the bottom up: columns, rows, size of an element.
fn array(head: [u16; 3], data: impl crate::check::Raw) -> Vec<u8> {
    bytes![head, data]
}

/// 3 columns and 2 rows: top row 2 4 6, bottom row 1 3 5, of which 4 is missing.
fn floats(mark: f32) -> Vec<u8> {
    array([3, 2, 4], [1.0, 2.0, 3.0, mark, 5.0, 6.0])
}

fn float(name: &'static str, value: f32) -> Block {
    (name, 7, bytes![value])
}

fn short(name: &'static str, value: i16) -> Block {
    (name, 6, bytes![value])
}

fn text(name: &'static str, text: &[u8]) -> Block {
    (name, 5, text.to_vec())
}

/// Objects of newer files: the type, how many bytes the length takes, the length, the content.
fn object(name: &'static str, kind: u8, content: Vec<u8>) -> Block {
    (name, 15, bytes![[kind, 1, content.len() as u8], content])
}

fn text_object(name: &'static str, text: &str) -> Block {
    object(name, 0x12, bytes![text])
}

/// As Vision64 writes it.
fn new_file() -> Vec<Block> {
    // Value, unit and symbol after their lengths; factor to the SI unit, and the dimension.
    let pixel_size = bytes![2.0_f64, 10_u32, "Micrometer", 3_u32, "µm", 1e6_f64, [1_u8, 0, 0, 0]];
    vec![
        text_object("PrimaryData2D", "Raw"),
        float("Wavelength", 500.0),
        float("Aspect", 1.5),
        float("Pixel_size", 0.002),
        ("Raw", 3, floats(2_f32.powi(127))),
        ("SecArr_0", 3, floats(7.0)),
        ("Image", 3, array([3, 2, 1], [9_u8; 6])),
        // An object of an unknown type.
        ("1D_Channels", 15, vec![0x7d, 1, 7, 0, 0, 0, 0, 0x7f, 0xff, 0xff]),
        ("Mystery", 99, vec![1, 2, 3]),
        text("Date", b"7/7/2015"),
        text_object("MeasMode", "PSI"),
        object("PixelSize", 0x13, pixel_size),
        ("ImageWidth", 15, vec![6, 3, 0, 0, 0]),
    ]
}

/// As older programs write it.
fn old_file() -> Vec<Block> {
    vec![
        ("RAW_DATA", 3, array([3, 2, 2], [100_i16, -200, 32765, 32766, -32768, 32767])),
        float("Wavelength", 640.0),
        short("Mult", 64),
        float("Pixel_size", 0.002),
        float("Aspect", 1.5),
        text("Title", b"flank \xb5\0 and what was there before"),
        text("Note", b""),
        ("StageX", 8, bytes![12.25_f64]),
        ("Samples", 12, bytes![70_000_i32]),
    ]
}

pub(crate) fn fixtures() -> Vec<Fixture> {
    // The bytes after the last block that is needed may be absent.
    let fixture = |name, blocks: &[Block], last: &str| {
        let end = blocks.iter().rposition(|(name, ..)| *name == last).unwrap() + 1;
        let lost: usize = blocks[end..].iter().map(|(.., content)| content.len()).sum();
        let whole = Fixture::whole(name, file(blocks));
        Fixture { needed: whole.needed - lost, ..whole }
    };
    vec![fixture("OPD of float32", &new_file(), "Raw"), fixture("OPD of int16", &old_file(), "Aspect")]
}

fn without(blocks: Vec<Block>, name: &str) -> Vec<u8> {
    file(&blocks.into_iter().filter(|(found, ..)| *found != name).collect::<Vec<_>>())
}

fn with(blocks: Vec<Block>, block: Block) -> Vec<u8> {
    file(&blocks.into_iter().map(|old| if old.0 == block.0 { block.clone() } else { old }).collect::<Vec<_>>())
}

fn read(bytes: &[u8]) -> Scan {
    read_bytes(bytes).unwrap()
}

/// 0.002 mm as float32, in metre.
const DX_M: f64 = 0.002_f32 as f64 * 1e-3;

#[test]
fn columns_from_the_bottom_up_become_rows_from_the_top_and_waves_become_metres() {
    let wanted = [2.0, NAN, 6.0, 1.0, 3.0, 5.0].map(|waves| waves * 500e-9);
    let scan = assert_scan(&file(&new_file()), Format::Opd, (2, 3), (DX_M, 1.5 * DX_M), &wanted);
    // Intensities are no channels.
    assert_eq!((scan.channels.as_slice(), scan.channel), (&["Raw".to_owned()][..], 0));
    assert_error(read_channel(&file(&new_file()), "Image"), "no height map");
    let (nx, ny) = (37_u16, 3_u16);
    let waves = |x: u16, from_bottom: u16| f32::from(100 * from_bottom + x);
    let stored: Vec<f32> = (0..nx).flat_map(|x| (0..ny).map(move |y| waves(x, y))).collect();
    let scan = read(&with(new_file(), ("Raw", 3, array([nx, ny, 4], stored))));
    let wanted: Vec<f64> = (0..ny).rev().flat_map(|y| (0..nx).map(move |x| f64::from(waves(x, y)) * 500e-9)).collect();
    assert_eq!(scan.heights_m.dim(), (3, 37));
    assert_heights(&scan, &wanted);
}

#[test]
fn integers_are_signed_and_divided_by_mult_and_bytes_have_no_mark() {
    let wanted = [-200.0, NAN, NAN, 100.0, 32765.0, -32768.0].map(|v| v / 64.0 * 640e-9);
    assert_heights(&read(&file(&old_file())), &wanted);
    // Without `Mult` a 1 is a wave.
    assert_heights(&read(&without(old_file(), "Mult")), &wanted.map(|z| z * 64.0));
    let bytes = with(old_file(), ("RAW_DATA", 3, array([1, 3, 1], [0_u8, 128, 255])));
    assert_heights(&read(&bytes), &[255.0, 128.0, 0.0].map(|v| v / 64.0 * 640e-9));
    // 1e38 as float32 is below 1e38.
    for mark in [1e38, 2_f32.powi(127), f32::MAX, f32::INFINITY, f32::NAN] {
        let scan = read(&with(new_file(), ("Raw", 3, floats(mark))));
        assert!(scan.missing_points() == 1 && scan.heights_m[[0, 1]].is_nan(), "{mark:e}");
    }
}

#[test]
fn a_number_whose_length_is_overstated_moves_no_block() {
    let blocks = [vec![float("ImageModificat~0", 1.5)], old_file()].concat();
    // The entry after the two bytes and the entry of the directory: 16 bytes of name, 2 of type, the length.
    let scan = read(&patched(&file(&blocks), 2 + 24 + 18, 40_i32));
    assert_eq!(bits(&scan), bits(&read(&file(&old_file()))));
    assert_eq!(scan.metadata["ImageModificat~0"], "1.5");
}

#[test]
fn absent_pixels_aspects_and_blocks_are_reported() {
    assert_pitch(&read(&without(new_file(), "Aspect")), (DX_M, DX_M));
    let scan = read(&without(new_file(), "Pixel_size"));
    assert_pitch(&scan, None);
    assert_warns(&scan, "no block `Pixel_size`");
    let bytes = file(&new_file());
    assert_warns(&read(&bytes[..bytes.len() - 1]), "`ImageWidth`");
    assert!(!warns(&read(&bytes), "blocks"));
}

#[test]
fn of_several_maps_the_primary_or_the_first_or_the_chosen_is_read() {
    let second = ("SAMPLE_DATA", 3, array([1, 1, 4], [8_f32]));
    let mut blocks = [old_file(), vec![second]].concat();
    let scan = read(&file(&blocks));
    assert_eq!(scan.channels, ["RAW_DATA", "SAMPLE_DATA"]);
    assert_eq!((scan.channel, scan.heights_m.dim()), (0, (2, 3)));
    assert_warns(&scan, "2 height maps");
    for chosen in ["sample_data", "2"] {
        let scan = read_channel(&file(&blocks), chosen).unwrap();
        assert_eq!((scan.channel, scan.heights_m.dim()), (1, (1, 1)));
        assert_heights(&scan, &[8.0 / 64.0 * 640e-9]);
    }
    blocks.push(text_object("PrimaryData2D", "SAMPLE_DATA"));
    assert_eq!(read(&file(&blocks)).channel, 1);
    assert_eq!(read_channel(&file(&blocks), "1").unwrap().channel, 0);
}

#[test]
fn texts_numbers_and_simple_objects_are_kept() {
    let (new, old) = (read(&file(&new_file())), read(&file(&old_file())));
    assert_metadata(&new, &[("Date", "7/7/2015"), ("MeasMode", "PSI"), ("PixelSize", "2 µm"), ("ImageWidth", "3")]);
    assert_metadata(&new, &[("Wavelength", "500"), ("Pixel_size", "0.002")]);
    assert_metadata(&old, &[("Title", "flank µ"), ("Mult", "64"), ("StageX", "12.25"), ("Samples", "70000")]);
    assert!(!old.metadata.contains_key("Note") && !new.metadata.contains_key("Mystery"));
    assert!(!new.metadata.contains_key("1D_Channels"));
}

#[test]
fn files_without_heights_and_blocks_that_give_none_are_refused() {
    // Two bytes, 16 of the name, 2 of the type.
    let directory = |length: i32| patched(&file(&new_file()), 20, length);
    let changed = |block| with(old_file(), block);
    let raw = |head: [u16; 3], bytes: usize| changed(("RAW_DATA", 3, array(head, vec![0_u8; bytes])));
    assert_refused([
        (without(new_file(), "Raw"), "the arrays SecArr_0, Image"),
        (file(&[float("Wavelength", 1.0)]), "no array"),
        (without(new_file(), "Wavelength"), "OPD: Wavelength is missing"),
        (directory(-24), "the length of the directory ("),
        (directory(25), "the length of the directory ("),
        (directory(0x6000_0000), "the length of the directory ("),
        (changed(float("Wavelength", 0.0)), "Wavelength ("),
        (changed(float("Wavelength", f32::NAN)), "Wavelength ("),
        (changed(short("Mult", 0)), "Mult ("),
        (changed(text("Mult", b"64")), "the type of Mult ("),
        (changed(("Mult", 7, vec![0, 0])), "the length of Mult ("),
        (raw([3, 2, 8], 48), "bytes of an element of RAW_DATA ("),
        (raw([3, 2, 4], 23), "the length of RAW_DATA ("),
        (raw([0, 2, 4], 0), "columns of RAW_DATA ("),
        (raw([u16::MAX, u16::MAX, 4], 0), "the limit is"),
        (file(&new_file())[..40].to_vec(), "stop after"),
    ]);
}
