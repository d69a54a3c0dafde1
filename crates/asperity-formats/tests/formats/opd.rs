//! Wyko OPD.

use asperity_formats::{FormatError, ReadOptions};

use crate::fixture::{Fixture, read_bytes, read_bytes_with, read_channel, unsupported, wrong_field};
use crate::{NAN, assert_heights};

/// A block: name, type, content.
type Block = (&'static str, i16, Vec<u8>);

/// The file: two bytes, the directory with its own entry, empty entries, the blocks one after the other.
fn file(blocks: &[Block]) -> Vec<u8> {
    fn entry(bytes: &mut Vec<u8>, name: &[u8], kind: i16, length: usize, attributes: u16) {
        bytes.extend(name);
        bytes.extend(vec![0; 16 - name.len()]);
        bytes.extend(kind.to_le_bytes());
        bytes.extend((length as i32).to_le_bytes());
        bytes.extend(attributes.to_le_bytes());
    }
    let mut bytes = vec![1, 0];
    entry(&mut bytes, b"Directory", 1, 24 * (blocks.len() + 2), 0xffff);
    for (name, kind, content) in blocks {
        entry(&mut bytes, name.as_bytes(), *kind, content.len(), 8);
    }
    entry(&mut bytes, b"", 0, 0, 0);
    for (_, _, content) in blocks {
        bytes.extend(content);
    }
    bytes
}

/// An array of columns, each from the bottom up.
fn array(columns: u16, rows: u16, element: u16, data: impl IntoIterator<Item = u8>) -> Vec<u8> {
    let mut bytes: Vec<u8> = [columns, rows, element].iter().flat_map(|number| number.to_le_bytes()).collect();
    bytes.extend(data);
    bytes
}

/// 3 columns and 2 rows: top row 2 4 6, bottom row 1 3 5, of which 4 is missing.
fn floats(mark: f32) -> Vec<u8> {
    array(3, 2, 4, [1.0, 2.0, 3.0, mark, 5.0, 6.0].iter().flat_map(|v: &f32| v.to_le_bytes()))
}

fn integers() -> Vec<u8> {
    array(3, 2, 2, [100, -200, 32765, 32766, -32768, 32767].iter().flat_map(|v: &i16| v.to_le_bytes()))
}

fn float(name: &'static str, value: f32) -> Block {
    (name, 7, value.to_le_bytes().to_vec())
}

fn short(name: &'static str, value: i16) -> Block {
    (name, 6, value.to_le_bytes().to_vec())
}

fn text(name: &'static str, text: &[u8]) -> Block {
    (name, 5, text.to_vec())
}

/// Objects of newer files: the type, how many bytes the length takes, the length, the content.
fn text_object(name: &'static str, text: &str) -> Block {
    (name, 15, [&[0x12, 1, text.len() as u8], text.as_bytes()].concat())
}

fn quantity_object(name: &'static str, number: f64, unit: &str, symbol: &str) -> Block {
    let mut content = number.to_le_bytes().to_vec();
    for text in [unit, symbol] {
        content.extend((text.len() as u32).to_le_bytes());
        content.extend(text.as_bytes());
    }
    // Factor to the SI unit, and the dimension.
    content.extend(1e6_f64.to_le_bytes());
    content.extend([1, 0, 0, 0]);
    (name, 15, [&[0x13, 1, content.len() as u8], content.as_slice()].concat())
}

/// As Vision64 writes it.
fn new_file() -> Vec<Block> {
    vec![
        text_object("PrimaryData2D", "Raw"),
        float("Wavelength", 500.0),
        float("Aspect", 1.5),
        float("Pixel_size", 0.002),
        ("Raw", 3, floats(2_f32.powi(127))),
        ("SecArr_0", 3, floats(7.0)),
        ("Image", 3, array(3, 2, 1, [9; 6])),
        // An object of an unknown type.
        ("1D_Channels", 15, vec![0x7d, 1, 7, 0, 0, 0, 0, 0x7f, 0xff, 0xff]),
        ("Mystery", 99, vec![1, 2, 3]),
        text("Date", b"7/7/2015"),
        text_object("MeasMode", "PSI"),
        quantity_object("PixelSize", 2.0, "Micrometer", "µm"),
        ("ImageWidth", 15, vec![6, 3, 0, 0, 0]),
    ]
}

/// As older programs write it.
fn old_file() -> Vec<Block> {
    vec![
        ("RAW_DATA", 3, integers()),
        float("Wavelength", 640.0),
        short("Mult", 64),
        float("Pixel_size", 0.002),
        float("Aspect", 1.5),
        text("Title", b"flank \xb5\0 and what was there before"),
        text("Note", b""),
        ("StageX", 8, 12.25_f64.to_le_bytes().to_vec()),
        ("Samples", 12, 70_000_i32.to_le_bytes().to_vec()),
    ]
}

pub(crate) fn fixtures() -> Vec<Fixture> {
    // The bytes after the last block that is needed may be absent.
    let needed = |blocks: &[Block], last: &str| {
        let end = blocks.iter().rposition(|(name, ..)| *name == last).unwrap() + 1;
        let lost: usize = blocks[end..].iter().map(|(.., content)| content.len()).sum();
        file(blocks).len() - lost
    };
    vec![
        Fixture { needed: needed(&new_file(), "Raw"), ..Fixture::whole("OPD of float32", file(&new_file())) },
        Fixture { needed: needed(&old_file(), "Aspect"), ..Fixture::whole("OPD of int16", file(&old_file())) },
    ]
}

fn without(blocks: Vec<Block>, name: &str) -> Vec<Block> {
    blocks.into_iter().filter(|(found, ..)| *found != name).collect()
}

fn with(blocks: Vec<Block>, block: Block) -> Vec<Block> {
    blocks.into_iter().map(|old| if old.0 == block.0 { block.clone() } else { old }).collect()
}

#[test]
fn columns_from_the_bottom_up_become_rows_from_the_top_and_waves_become_metres() {
    let scan = read_bytes(&file(&new_file())).unwrap();
    assert_eq!(scan.heights_m.dim(), (2, 3));
    assert_heights(&scan, &[2.0, NAN, 6.0, 1.0, 3.0, 5.0].map(|waves| waves * 500e-9));
}

#[test]
fn many_columns_keep_their_places() {
    let (nx, ny) = (37_u16, 3_u16);
    let waves = |x: u16, from_bottom: u16| f32::from(100 * from_bottom + x);
    let stored = (0..nx).flat_map(|x| (0..ny).flat_map(move |y| waves(x, y).to_le_bytes()));
    let scan = read_bytes(&file(&with(new_file(), ("Raw", 3, array(nx, ny, 4, stored))))).unwrap();
    let wanted: Vec<f64> = (0..ny).rev().flat_map(|y| (0..nx).map(move |x| f64::from(waves(x, y)) * 500e-9)).collect();
    assert_eq!(scan.heights_m.dim(), (3, 37));
    assert_heights(&scan, &wanted);
}

#[test]
fn integers_are_signed_and_divided_by_mult() {
    let scan = read_bytes(&file(&old_file())).unwrap();
    assert_heights(&scan, &[-200.0, NAN, NAN, 100.0, 32765.0, -32768.0].map(|v| v / 64.0 * 640e-9));
    // Without `Mult` a 1 is a wave.
    let scan = read_bytes(&file(&without(old_file(), "Mult"))).unwrap();
    assert!((scan.heights_m[[1, 0]] / (100.0 * 640e-9) - 1.0).abs() < 1e-15);
}

#[test]
fn a_number_whose_length_is_overstated_moves_no_block() {
    let mut blocks = old_file();
    blocks.insert(0, float("ImageModificat~0", 1.5));
    let mut bytes = file(&blocks);
    // The entry after the two bytes and the entry of the directory: 16 bytes of name, 2 of type, the length.
    let length = 2 + 24 + 18;
    assert_eq!(bytes[length..length + 4], 4_i32.to_le_bytes());
    bytes[length..length + 4].copy_from_slice(&40_i32.to_le_bytes());
    let scan = read_bytes(&bytes).unwrap();
    assert_eq!(crate::bits(&scan), crate::bits(&read_bytes(&file(&old_file())).unwrap()));
    assert_eq!(scan.metadata["ImageModificat~0"], "1.5");
}

#[test]
fn bytes_have_no_mark() {
    let bytes = ("RAW_DATA", 3, array(1, 3, 1, [0, 128, 255]));
    let scan = read_bytes(&file(&with(without(old_file(), "Mult"), bytes))).unwrap();
    assert_heights(&scan, &[255.0, 128.0, 0.0].map(|v| v * 640e-9));
}

#[test]
fn every_mark_of_a_missing_float_is_known() {
    // 1e38 as float32 is below 1e38.
    for mark in [1e38, 2_f32.powi(127), f32::MAX, f32::INFINITY, f32::NAN] {
        let scan = read_bytes(&file(&with(new_file(), ("Raw", 3, floats(mark))))).unwrap();
        assert_eq!(scan.missing_points(), 1, "{mark:e}");
        assert!(scan.heights_m[[0, 1]].is_nan());
    }
}

#[test]
fn pixels_are_in_millimetre_and_as_high_as_their_aspect() {
    let scan = read_bytes(&file(&new_file())).unwrap();
    let (dx_m, dy_m) = scan.pitch_m.unwrap();
    // 0.002 as float32.
    let wanted_m = f64::from(0.002_f32) * 1e-3;
    assert!((dx_m / wanted_m - 1.0).abs() < 1e-15 && (dy_m / (1.5 * wanted_m) - 1.0).abs() < 1e-15);
    let (dx_m, dy_m) = read_bytes(&file(&without(new_file(), "Aspect"))).unwrap().pitch_m.unwrap();
    assert_eq!(dx_m, dy_m);
}

#[test]
fn without_a_pixel_size_there_is_a_warning() {
    let scan = read_bytes(&file(&without(new_file(), "Pixel_size"))).unwrap();
    assert_eq!(scan.pitch_m, None);
    assert!(scan.warnings.iter().any(|warning| warning.contains("no block `Pixel_size`")), "{:?}", scan.warnings);
}

#[test]
fn intensities_are_no_channels() {
    let scan = read_bytes(&file(&new_file())).unwrap();
    assert_eq!((scan.channels.as_slice(), scan.channel), (&["Raw".to_owned()][..], 0));
    assert!(matches!(read_channel(&file(&new_file()), "Image"), Err(FormatError::NoSuchChannel { .. })));
}

#[test]
fn of_several_maps_the_primary_or_the_first_or_the_chosen_is_read() {
    let second = ("SAMPLE_DATA", 3, array(1, 1, 4, 8_f32.to_le_bytes()));
    let mut blocks = old_file();
    blocks.push(second);
    let read = |blocks: &[Block], channel: Option<&str>| {
        let options = ReadOptions { channel: channel.map(Into::into), ..ReadOptions::default() };
        read_bytes_with(&file(blocks), &options).unwrap()
    };
    let scan = read(&blocks, None);
    assert_eq!(scan.channels, ["RAW_DATA", "SAMPLE_DATA"]);
    assert_eq!((scan.channel, scan.heights_m.dim()), (0, (2, 3)));
    assert!(scan.warnings.iter().any(|warning| warning.contains("2 height maps")), "{:?}", scan.warnings);
    for chosen in ["sample_data", "2"] {
        let scan = read(&blocks, Some(chosen));
        assert_eq!((scan.channel, scan.heights_m.dim()), (1, (1, 1)));
        assert_heights(&scan, &[8.0 / 64.0 * 640e-9]);
    }
    blocks.push(text_object("PrimaryData2D", "SAMPLE_DATA"));
    assert_eq!(read(&blocks, None).channel, 1);
    assert_eq!(read(&blocks, Some("1")).channel, 0);
}

#[test]
fn texts_numbers_and_simple_objects_are_kept() {
    let new = read_bytes(&file(&new_file())).unwrap().metadata;
    let old = read_bytes(&file(&old_file())).unwrap().metadata;
    for (metadata, field, text) in [
        (&new, "Date", "7/7/2015"),
        (&new, "MeasMode", "PSI"),
        (&new, "PixelSize", "2 µm"),
        (&new, "ImageWidth", "3"),
        (&new, "Wavelength", "500"),
        (&new, "Pixel_size", "0.002"),
        (&old, "Title", "flank µ"),
        (&old, "Mult", "64"),
        (&old, "StageX", "12.25"),
        (&old, "Samples", "70000"),
    ] {
        assert_eq!(metadata.get(field).map(String::as_str), Some(text), "{field}");
    }
    assert!(!old.contains_key("Note") && !new.contains_key("Mystery") && !new.contains_key("1D_Channels"));
}

#[test]
fn blocks_that_are_lost_at_the_end_are_reported() {
    let bytes = file(&new_file());
    let scan = read_bytes(&bytes[..bytes.len() - 1]).unwrap();
    assert!(scan.warnings.iter().any(|warning| warning.contains("`ImageWidth`")), "{:?}", scan.warnings);
    assert!(read_bytes(&bytes).unwrap().warnings.iter().all(|warning| !warning.contains("blocks")));
}

#[test]
fn a_file_without_heights_is_refused_with_its_content() {
    for (blocks, reason) in
        [(without(new_file(), "Raw"), "the arrays SecArr_0, Image"), (vec![float("Wavelength", 1.0)], "no array")]
    {
        let found = unsupported(&file(&blocks));
        assert!(found.contains(reason), "{found}");
    }
    let message = read_bytes(&file(&without(new_file(), "Wavelength"))).unwrap_err().to_string();
    assert!(message.starts_with("OPD: Wavelength is missing"), "{message}");
}

#[test]
fn blocks_that_give_no_heights_are_errors() {
    let directory = |length: i32| {
        let mut bytes = file(&new_file());
        // Two bytes, 16 of the name, 2 of the type.
        bytes[20..24].copy_from_slice(&length.to_le_bytes());
        bytes
    };
    let changed = |block| file(&with(old_file(), block));
    for (bytes, field) in [
        (directory(-24), "the length of the directory"),
        (directory(25), "the length of the directory"),
        (directory(0x6000_0000), "the length of the directory"),
        (changed(float("Wavelength", 0.0)), "Wavelength"),
        (changed(float("Wavelength", f32::NAN)), "Wavelength"),
        (changed(short("Mult", 0)), "Mult"),
        (changed(text("Mult", b"64")), "the type of Mult"),
        (changed(("Mult", 7, vec![0, 0])), "the length of Mult"),
        (changed(("RAW_DATA", 3, array(3, 2, 8, [0; 48]))), "bytes of an element of RAW_DATA"),
        (changed(("RAW_DATA", 3, array(3, 2, 4, [0; 23]))), "the length of RAW_DATA"),
        (changed(("RAW_DATA", 3, array(0, 2, 4, []))), "columns of RAW_DATA"),
    ] {
        assert_eq!(wrong_field(&bytes), field);
    }
    let huge = changed(("RAW_DATA", 3, array(u16::MAX, u16::MAX, 4, [])));
    assert!(matches!(read_bytes(&huge), Err(FormatError::TooLarge { .. })));
    let short = &file(&new_file())[..40];
    assert!(matches!(read_bytes(short), Err(FormatError::Truncated { .. })));
}
