use asperity_formats::Format;

use crate::check::{assert_no_warning, assert_refused, assert_scan, bytes, patched};
use crate::fixture::{Fixture, read_bytes};
use crate::{NAN, assert_metadata};

/// A file of 3 × 2 heights, of version 1.0 or 1.01, with a picture after them.
fn os3d(minor: i32) -> Vec<u8> {
    let time = if minor == 0 { vec![] } else { bytes![15_i32, "20240102T030405"] };
    let start = bytes!["OmniSurf3D", [1_i32, minor], 9_i32, "Ra sample", time];
    // Points along x and y; spacing and origin in µm.
    let grid = bytes![[3_i32, 2], [15.0_f64, 20.0, 10.0, -20.0]];
    bytes![start, grid, [1.0_f32, f32::MIN, -3.0, 0.5, f32::NAN, 2.0], 1_u8, "\u{1}PNG"]
}

const HEIGHTS_M: [f64; 6] = [1e-6, NAN, -3e-6, 0.5e-6, NAN, 2e-6];

pub(crate) fn fixtures() -> Vec<Fixture> {
    let fixture = |name, minor| Fixture { needed: os3d(minor).len() - 5, ..Fixture::whole(name, os3d(minor)) };
    vec![fixture("OS3D of version 1.0", 0), fixture("OS3D of version 1.01", 1)]
}

#[test]
fn heights_and_spacings_are_micrometres_in_both_versions() {
    for minor in [0, 1] {
        let scan = assert_scan(&os3d(minor), Format::Os3d, (2, 3), (1.5e-5, 2e-5), &HEIGHTS_M);
        assert_no_warning(&scan);
        assert_metadata(&scan, &[("identification", "Ra sample"), ("x origin in um", "10"), ("y origin in um", "-20")]);
        assert_eq!(scan.metadata.get("measured at").map(String::as_str), (minor == 1).then_some("20240102T030405"));
    }
}

#[test]
fn other_versions_and_sizes_beyond_the_file_are_refused() {
    let plain = os3d(0);
    assert_refused([
        (patched(&plain, 10, 2_i32), "OS3D: major version (byte 10) is `2`; wanted 1"),
        (patched(&plain, 18, -1_i32), "OS3D: identification (byte 18) is `-1`; wanted a length of 0 or more"),
        (patched(&plain, 18, i32::MAX), "OS3D: identification (byte 22) stop after"),
        (patched(&plain, 31, 0_i32), "OS3D: points along x (byte 31) is `0`"),
        (patched(&plain, 31, [i32::MAX; 2]), "the limit is"),
        (patched(&plain, 31, 4_i32), "OS3D: the heights (byte 71) stop after 29 bytes; wanted 32"),
    ]);
    assert!(read_bytes(&plain[..plain.len() - 5]).is_ok());
}
