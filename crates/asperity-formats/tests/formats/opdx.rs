use asperity_formats::Format;

use crate::assert_heights;
use crate::check::assert_error;
use crate::fixture::{Fixture, read_bytes, read_channel};

fn name(text: &str) -> Vec<u8> {
    [&(text.len() as u32).to_le_bytes(), text.as_bytes()].concat()
}

fn item(label: &str, kind: u8, value: &[u8]) -> Vec<u8> {
    [name(label).as_slice(), &[kind], value].concat()
}

/// A value of variable length, with the size of its length as small as possible.
fn sized(value: &[u8]) -> Vec<u8> {
    match u8::try_from(value.len()) {
        Ok(length) => [&[1, length], value].concat(),
        Err(_) => [&[2][..], &(value.len() as u16).to_le_bytes(), value].concat(),
    }
}

fn text(label: &str, value: &str) -> Vec<u8> {
    item(label, 0x12, &sized(value.as_bytes()))
}

fn quantity(label: &str, value: f64, symbol: &str) -> Vec<u8> {
    item(label, 0x13, &sized(&[&value.to_le_bytes(), name("unit").as_slice(), &name(symbol), &[0; 12]].concat()))
}

fn container(label: &str, items: &[Vec<u8>]) -> Vec<u8> {
    // Two bytes of unknown meaning follow the last item.
    item(label, 0x7d, &sized(&[items.concat().as_slice(), &name(""), &[0x7f, 0xff, 0xff]].concat()))
}

fn matrix(rows: u32, columns: u32, numbers: &[f32]) -> Vec<u8> {
    let numbers: Vec<u8> = numbers.iter().flat_map(|z| z.to_le_bytes()).collect();
    let shape = [rows.to_le_bytes(), columns.to_le_bytes()].concat();
    item(
        "Matrix",
        0x00,
        &[name("Matrix<float>").as_slice(), &[0; 4], &name("float"), &sized(&[shape, numbers].concat())].concat(),
    )
}

fn data(label: &str, unit: &str, shape: (u32, u32)) -> Vec<u8> {
    let numbers = [1.0, 2.0, 3.0, 4.0, f32::NAN, 6.0];
    container(
        label,
        &[
            item("Dimension1Points", 0x07, &shape.0.to_le_bytes()),
            quantity("Dimension1Extent", 2.0, "\u{b5}m"),
            quantity("Dimension2Extent", 8.0, "\u{b5}m"),
            quantity("DataScale", 10.0, unit),
            matrix(shape.0, shape.1, &numbers),
        ],
    )
}

fn opdx(maps: &[Vec<u8>]) -> Vec<u8> {
    let list = item("Height", 0x42, &[name("StringList"), sized(&name("Raw"))].concat());
    let meta = [
        text("PrimaryData2D", "Raw"),
        container("2D_Channels", &[list]),
        item("Time", 0x15, &[0; 9]),
        item("Averages", 0x06, &4_i32.to_le_bytes()),
        quantity("Magnification", 20.0, "x"),
    ];
    [
        b"VCA DATA\x01\x00\x00\x55".as_slice(),
        &container("MetaData", &meta),
        &container("2D_Data", maps),
        &name(""),
        &[0x7f],
    ]
    .concat()
}

/// A file with an item of every type, several maps, and a matrix without the name of its type.
fn every_type() -> Vec<u8> {
    let numbers = [
        item("u8", 0x01, &[200]),
        item("i16", 0x04, &(-2_i16).to_le_bytes()),
        item("u16", 0x05, &65_000_u16.to_le_bytes()),
        item("i32", 0x06, &(-4_i32).to_le_bytes()),
        item("u32", 0x07, &4_000_000_000_u32.to_le_bytes()),
        item("i64", 0x0a, &(-8_i64).to_le_bytes()),
        item("u64", 0x0b, &8_u64.to_le_bytes()),
        item("f32", 0x0c, &0.5_f32.to_le_bytes()),
        item("f64", 0x0d, &(-0.25_f64).to_le_bytes()),
    ];
    let long = [&[4][..], &4_u32.to_le_bytes(), b"unit"].concat();
    let named = [0x40, 0x42, 0x7c].map(|kind| item("named", kind, &[name("Type"), sized(&[1, 2])].concat()));
    let shape = [2_u32, 3].map(u32::to_le_bytes).concat();
    let heights: Vec<u8> = [1_f32, 2.0, 3.0, 4.0, 5.0, 6.0].iter().flat_map(|z| z.to_le_bytes()).collect();
    let plain = item("Matrix", 0x45, &[name("Matrix<float>"), sized(&[shape, heights].concat())].concat());
    let maps = [
        data("Image", "counts", (2, 3)),
        data("Raw", "\u{b5}m", (3, 2)),
        container("Plain", &[quantity("DataScale", 1.0, "mm"), plain]),
    ];
    [
        b"VCA DATA\x01\x00\x00\x55".as_slice(),
        &container("MetaData", &[numbers.concat(), text("PrimaryData2D", "Raw")]),
        &item("Group", 0x46, &sized(&named.concat())),
        &item("Group", 0x47, &sized(&item("Unit", 0x0e, &[name("m"), long.clone()].concat()))),
        &item("Position", 0x18, &long),
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
    let scan = read_bytes(&opdx(&[data("Raw", "nm", (2, 3))])).unwrap();
    assert_eq!((scan.format, scan.heights_m.dim()), (Some(Format::Opdx), (2, 3)));
    assert_heights(&scan, &[10e-9, 20e-9, 30e-9, 40e-9, f64::NAN, 60e-9]);
    assert_eq!(scan.pitch_m, Some((4e-6, 2e-6)));
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
    let error = read_bytes(&opdx(&[])).unwrap_err().to_string();
    assert!(error.contains("no image"), "{error}");
    assert_error(read_bytes(&opdx(&[data("Raw", "nm", (2, 4))])), "stop after");
    let unknown = [b"VCA DATA\x01\x00\x00\x55".as_slice(), &item("a", 0x33, &[])].concat();
    assert_error(read_bytes(&unknown), "type of an item");
    // Containers in containers without end.
    let mut deep = Vec::new();
    for _ in 0..100 {
        deep = container("a", &[deep]);
    }
    assert!(read_bytes(&[b"VCA DATA\x01\x00\x00\x55".as_slice(), &deep].concat()).is_err());
}
