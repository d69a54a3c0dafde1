use asperity_formats::Format;

use crate::assert_heights;
use crate::check::{Raw, assert_refused, assert_scan, bytes};
use crate::fixture::{Fixture, read_bytes, read_channel};

fn name(text: &str) -> Vec<u8> {
    bytes![text.len() as u32, text]
}

fn item(label: &str, kind: u8, value: impl Raw) -> Vec<u8> {
    bytes![name(label), kind, value]
}

/// A value of variable length, with the size of its length as small as possible.
fn sized(value: &[u8]) -> Vec<u8> {
    match u8::try_from(value.len()) {
        Ok(length) => bytes![1_u8, length, value],
        Err(_) => bytes![2_u8, value.len() as u16, value],
    }
}

fn text(label: &str, value: &str) -> Vec<u8> {
    item(label, 0x12, sized(value.as_bytes()))
}

fn quantity(label: &str, value: f64, symbol: &str) -> Vec<u8> {
    item(label, 0x13, sized(&bytes![value, name("unit"), name(symbol), [0_u8; 12]]))
}

fn container(label: &str, items: &[Vec<u8>]) -> Vec<u8> {
    // Two bytes of unknown meaning follow the last item.
    item(label, 0x7d, sized(&bytes![items, name(""), [0x7f_u8, 0xff, 0xff]]))
}

fn data(label: &str, unit: &str, shape: (u32, u32)) -> Vec<u8> {
    let numbers = bytes![shape.0, shape.1, [1.0, 2.0, 3.0, 4.0, f32::NAN, 6.0]];
    let matrix = bytes![name("Matrix<float>"), [0_u8; 4], name("float"), sized(&numbers)];
    container(
        label,
        &[
            item("Dimension1Points", 0x07, shape.0),
            quantity("Dimension1Extent", 2.0, "\u{b5}m"),
            quantity("Dimension2Extent", 8.0, "\u{b5}m"),
            quantity("DataScale", 10.0, unit),
            item("Matrix", 0x00, matrix),
        ],
    )
}

fn opdx(maps: &[Vec<u8>]) -> Vec<u8> {
    let list = item("Height", 0x42, [name("StringList"), sized(&name("Raw"))]);
    let meta = [
        text("PrimaryData2D", "Raw"),
        container("2D_Channels", &[list]),
        item("Time", 0x15, [0_u8; 9]),
        item("Averages", 0x06, 4_i32),
        quantity("Magnification", 20.0, "x"),
    ];
    bytes![b"VCA DATA\x01\x00\x00\x55", container("MetaData", &meta), container("2D_Data", maps), name(""), 0x7f_u8]
}

/// A file with an item of every type, several maps, and a matrix without the name of its type.
fn every_type() -> Vec<u8> {
    let numbers = [
        item("u8", 0x01, 200_u8),
        item("i16", 0x04, -2_i16),
        item("u16", 0x05, 65_000_u16),
        item("i32", 0x06, -4_i32),
        item("u32", 0x07, 4_000_000_000_u32),
        item("i64", 0x0a, -8_i64),
        item("u64", 0x0b, 8_u64),
        item("f32", 0x0c, 0.5_f32),
        item("f64", 0x0d, -0.25_f64),
    ];
    let long = bytes![4_u8, 4_u32, "unit"];
    let named = [0x40, 0x42, 0x7c].map(|kind| item("named", kind, [name("Type"), sized(&[1, 2])]));
    let matrix = bytes![[2_u32, 3], [1_f32, 2.0, 3.0, 4.0, 5.0, 6.0]];
    let plain = item("Matrix", 0x45, [name("Matrix<float>"), sized(&matrix)]);
    let maps = [
        data("Image", "counts", (2, 3)),
        data("Raw", "\u{b5}m", (3, 2)),
        container("Plain", &[quantity("DataScale", 1.0, "mm"), plain]),
    ];
    [
        b"VCA DATA\x01\x00\x00\x55".as_slice(),
        &container("MetaData", &[numbers.concat(), text("PrimaryData2D", "Raw")]),
        &item("Group", 0x46, sized(&named.concat())),
        &item("Group", 0x47, sized(&item("Unit", 0x0e, [name("m"), long.clone()].concat()))),
        &item("Position", 0x18, long),
        &container("2D_Data", &maps),
        &name(""),
        &[0x7f],
    ]
    .concat()
}

pub(crate) fn fixtures() -> Vec<Fixture> {
    vec![
        Fixture::open_ended("OPDx", opdx(&[data("Raw", "nm", (2, 3))])),
        Fixture::open_ended("OPDx with items of every type", every_type()),
    ]
}

#[test]
fn items_of_every_type_are_read_or_passed_over() {
    let scan = read_bytes(&every_type()).unwrap();
    assert_eq!(scan.channels, ["Raw", "Plain"]);
    assert_heights(&scan, &[10e-6, 20e-6, 30e-6, 40e-6, f64::NAN, 60e-6]);
    let numbers = ["u8", "i16", "u16", "i32", "u32", "i64", "u64", "f32", "f64"].map(|key| scan.metadata[key].as_str());
    assert_eq!(numbers, ["200", "-2", "65000", "-4", "4000000000", "-8", "8", "0.5", "-0.25"]);
    let scan = read_channel(&every_type(), "2").unwrap();
    assert_heights(&scan, &[1e-3, 2e-3, 3e-3, 4e-3, 5e-3, 6e-3]);
    assert_eq!(scan.pitch_m, None);
}

#[test]
fn heights_are_multiples_of_the_scale_and_extents_span_the_outer_points() {
    let heights = [10e-9, 20e-9, 30e-9, 40e-9, f64::NAN, 60e-9];
    let scan = assert_scan(&opdx(&[data("Raw", "nm", (2, 3))]), Format::Opdx, (2, 3), (4e-6, 2e-6), &heights);
    assert_eq!(scan.metadata["Averages"], "4");
    assert_eq!(scan.metadata["Magnification"], "20 x");
}

#[test]
fn the_main_map_comes_first_and_images_without_lengths_are_left_out() {
    let maps = [data("Image", "counts", (2, 3)), data("Other", "um", (3, 2)), data("Raw", "nm", (2, 3))];
    let scan = read_bytes(&opdx(&maps)).unwrap();
    assert_eq!(scan.channels, ["Raw", "Other"]);
    assert!(scan.warnings[0].contains("`Image` (counts)"), "{:?}", scan.warnings);
}

#[test]
fn damaged_and_empty_files_are_refused() {
    // Containers in containers without end.
    let deep = (0..100).fold(vec![], |inner, _| container("a", &[inner]));
    let start = "VCA DATA\x01\0\0\x55";
    assert_refused([
        (opdx(&[]), "no image"),
        (opdx(&[data("Raw", "nm", (2, 4))]), "stop after"),
        (bytes![start, item("a", 0x33, "")], "type of an item"),
        (bytes![start, deep], ""),
    ]);
}
