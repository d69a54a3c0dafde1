use asperity_formats::{Format, FormatError};

use crate::assert_heights;
use crate::check::assert_error;
use crate::fixture::{Fixture, read_bytes};

/// A file of three data sets of 3 × 2 points; `second` replaces fields of the second, the heights.
fn nid(second: &[(&str, &str)], numbers: &[u8]) -> Vec<u8> {
    let set = |name: &str, unit: &str, bits: &str| {
        vec![
            ("Points", "3"),
            ("Lines", "2"),
            ("Frame", "Scan forward"),
            ("Dim0Unit", "m"),
            ("Dim0Range", "3e-06"),
            ("Dim1Unit", "m"),
            ("Dim1Range", "4e-06"),
            ("Dim2Name", name),
            ("Dim2Unit", unit),
            ("Dim2Range", "6.5536e-06"),
            ("Dim2Min", "-3.2768e-06"),
            ("SaveMode", "Binary"),
            ("SaveBits", bits),
            ("SaveSign", "Signed"),
            ("SaveOrder", "Intel"),
        ]
        .into_iter()
        .map(|(key, value)| (key.to_owned(), value.to_owned()))
        .collect::<Vec<_>>()
    };
    let mut heights = set("Z-Axis", "m", "16");
    for (key, value) in second {
        heights.iter_mut().filter(|(known, _)| known == key).for_each(|(_, old)| *old = (*value).to_owned());
    }
    let mut text =
        "[DataSet]\r\nVersion=2\r\nGroupCount=1\r\nGr0-Name=Scan forward\r\nGr0-Count=4\r\nGr0-Ch0=DataSet-0:0\r\n\
                    Gr0-Ch2=DataSet-0:2\r\nGr0-Ch3=DataSet-0:3\r\n\r\n[DataSet-Info]\r\nDate=24-11-2026\r\n\r\n"
            .to_owned();
    for (name, fields) in [(0, set("Deflection", "m", "8")), (2, heights), (3, set("Phase", "\u{b0}", "8"))] {
        text += &format!("[DataSet-0:{name}]\r\n");
        fields.iter().for_each(|(key, value)| text += &format!("{key}={value}\r\n"));
        text += "\r\n";
    }
    let mut bytes: Vec<u8> = text.chars().map(|c| c as u8).collect();
    bytes.extend(b"#!");
    bytes.extend([9; 6]);
    bytes.extend(numbers);
    bytes.extend([9; 6]);
    bytes
}

fn numbers() -> Vec<u8> {
    [0_i16, 1000, -2000, 3000, 32767, -32768].iter().flat_map(|n| n.to_le_bytes()).collect()
}

pub(crate) fn fixtures() -> Vec<Fixture> {
    vec![Fixture::open_ended("NID", nid(&[], &numbers()))]
}

#[test]
fn integers_span_the_range_from_its_minimum_on_from_the_bottom_up() {
    let scan = read_bytes(&nid(&[], &numbers())).unwrap();
    assert_eq!((scan.format, scan.heights_m.dim()), (Some(Format::Nid), (2, 3)));
    assert_heights(&scan, &[0.3e-6, 3.2767e-6, -3.2768e-6, 0.0, 0.1e-6, -0.2e-6]);
    assert_eq!(scan.pitch_m, Some((1e-6, 2e-6)));
    // The deflection is a length, but no height.
    assert_eq!(
        (scan.channels.as_slice(), scan.channel),
        (["Scan forward: Deflection", "Scan forward: Z-Axis"].map(str::to_owned).as_slice(), 1)
    );
    assert!(scan.warnings[0].contains("`Scan forward: Phase` (°)"), "{:?}", scan.warnings);
    assert_eq!(scan.metadata["Date"], "24-11-2026");
}

#[test]
fn signs_widths_orders_and_units_are_those_of_the_data_set() {
    let big: Vec<u8> = [0_u32, 1 << 30, 1 << 31, 3 << 30, 0, 0].iter().flat_map(|n| n.to_be_bytes()).collect();
    let fields = [
        ("SaveSign", "Unsigned"),
        ("SaveBits", "32"),
        ("SaveOrder", "Motorola"),
        ("Dim2Range", "4"),
        ("Dim2Min", "1"),
        ("Dim2Unit", "nm"),
    ];
    let scan = read_bytes(&nid(&fields, &big)).unwrap();
    assert_heights(&scan, &[4e-9, 1e-9, 1e-9, 1e-9, 2e-9, 3e-9]);
}

#[test]
fn other_data_and_damaged_headers_are_refused_with_their_field() {
    for (field, value) in [("SaveMode", "Text"), ("SaveBits", "64"), ("Dim2Range", "x"), ("Lines", "0")] {
        let error = read_bytes(&nid(&[(field, value)], &numbers())).unwrap_err();
        assert!(matches!(&error, FormatError::Field { field: found, .. } if found == field), "{field}: {error}");
    }
    let volts = read_bytes(&nid(&[("Dim2Unit", "V")], &numbers())).unwrap();
    assert_eq!(volts.channels, ["Scan forward: Deflection"]);
    assert_error(read_bytes(b"[DataSet]\r\nGroupCount=1\r\n"), "the end of the header");
}
