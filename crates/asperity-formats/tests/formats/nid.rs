use asperity_formats::Format;

use crate::assert_heights;
use crate::check::{assert_refused, assert_scan, bytes};
use crate::fixture::{Fixture, read_bytes};

/// A file of three data sets of 3 × 2 points; `second` replaces fields of the second, the heights.
fn nid(second: &[(&str, &str)], numbers: &[u8]) -> Vec<u8> {
    let set = |name: &str, unit: &str, bits: &str| {
        format!(
            "Points=3\r\nLines=2\r\nFrame=Scan forward\r\nDim0Unit=m\r\nDim0Range=3e-06\r\nDim1Unit=m\r\nDim1Range=4e-06\r\n\
             Dim2Name={name}\r\nDim2Unit={unit}\r\nDim2Range=6.5536e-06\r\nDim2Min=-3.2768e-06\r\nSaveMode=Binary\r\n\
             SaveBits={bits}\r\nSaveSign=Signed\r\nSaveOrder=Intel\r\n"
        )
    };
    let mut heights = set("Z-Axis", "m", "16");
    for (key, value) in second {
        let old = heights.lines().find(|line| line.starts_with(&format!("{key}="))).unwrap().to_owned();
        heights = heights.replace(&old, &format!("{key}={value}"));
    }
    let text = format!(
        "[DataSet]\r\nVersion=2\r\nGroupCount=1\r\nGr0-Name=Scan forward\r\nGr0-Count=4\r\nGr0-Ch0=DataSet-0:0\r\n\
         Gr0-Ch2=DataSet-0:2\r\nGr0-Ch3=DataSet-0:3\r\n\r\n[DataSet-Info]\r\nDate=24-11-2026\r\n\r\n\
         [DataSet-0:0]\r\n{}\r\n[DataSet-0:2]\r\n{heights}\r\n[DataSet-0:3]\r\n{}\r\n",
        set("Deflection", "m", "8"),
        set("Phase", "\u{b0}", "8"),
    );
    let latin1: Vec<u8> = text.chars().map(|c| c as u8).collect();
    bytes![latin1, "#!", [9_u8; 6], numbers, [9_u8; 6]]
}

fn numbers() -> Vec<u8> {
    bytes![[0_i16, 1000, -2000, 3000, 32767, -32768]]
}

pub(crate) fn fixtures() -> Vec<Fixture> {
    vec![Fixture::open_ended("NID", nid(&[], &numbers()))]
}

#[test]
fn integers_span_the_range_from_its_minimum_on_from_the_bottom_up() {
    let heights = [0.3e-6, 3.2767e-6, -3.2768e-6, 0.0, 0.1e-6, -0.2e-6];
    let scan = assert_scan(&nid(&[], &numbers()), Format::Nid, (2, 3), (1e-6, 2e-6), &heights);
    // The deflection is a length, but no height.
    assert_eq!(scan.channels, ["Scan forward: Deflection", "Scan forward: Z-Axis"]);
    assert_eq!(scan.channel, 1);
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
        assert_refused([(nid(&[(field, value)], &numbers()), format!("NID: {field} ("))]);
    }
    let volts = read_bytes(&nid(&[("Dim2Unit", "V")], &numbers())).unwrap();
    assert_eq!(volts.channels, ["Scan forward: Deflection"]);
    assert_refused([("[DataSet]\r\nGroupCount=1\r\n", "the end of the header")]);
}
