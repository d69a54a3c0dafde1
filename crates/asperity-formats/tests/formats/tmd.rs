//! TrueMap TMD.

use asperity_formats::Format;

use crate::check::{assert_pitch, assert_refused, assert_scan, assert_warns, bytes, patched, warns};
use crate::fixture::{Fixture, read_bytes};
use crate::{NAN, assert_heights, assert_metadata};

const TITLE: &str = "Binary TrueMap Data File v2.0\r\n\0";
/// Three columns and two rows of 0.75 mm and 1 mm.
const SIZE: [u32; 2] = [3, 2];
const HEIGHTS_MM: [f32; 6] = [0.5, -0.25, f32::NAN, 1.0, f32::INFINITY, 0.125];

/// A file of version 2 with a comment.
fn with_comment(comment: &[u8]) -> Vec<u8> {
    bytes![TITLE, comment, SIZE, [0.75_f32, 1.0], [2.5_f32, 0.0], HEIGHTS_MM]
}

/// As GelSight's routines write them.
fn gelsight() -> Vec<u8> {
    with_comment(b"\0")
}

/// As TrueMap v6 writes them: a comment of 24 bytes with the zero.
fn truemap() -> Vec<u8> {
    with_comment(b"Created by TrueMap v6\r\n\0")
}

fn version_1() -> Vec<u8> {
    bytes!["Binary TrueMap Data File\r\n\0\0", SIZE, [0.75_f32, 1.0], HEIGHTS_MM]
}

pub(crate) fn fixtures() -> Vec<Fixture> {
    vec![
        Fixture::whole("TMD of GelSight", gelsight()),
        Fixture::whole("TMD of TrueMap", truemap()),
        Fixture::whole("TMD version 1", version_1()),
    ]
}

#[test]
fn heights_and_lengths_are_millimetres_and_the_first_row_is_on_top() {
    let wanted = [0.5e-3, -0.25e-3, NAN, 1e-3, NAN, 0.125e-3];
    for file in [gelsight(), truemap(), version_1()] {
        // 0.75 mm hold 3 columns, 1 mm holds 2 rows.
        let scan = assert_scan(&file, Format::Tmd, (2, 3), (0.25e-3, 0.5e-3), &wanted);
        assert!(!warns(&scan, "follow"));
        assert_warns(&read_bytes(&bytes![file, [0_u8; 5]]).unwrap(), "5 bytes follow");
    }
    let offsets = [("comment", "Created by TrueMap v6"), ("offset x", "2.5 mm"), ("offset y", "0 mm")];
    assert_metadata(&read_bytes(&truemap()).unwrap(), &offsets);
    assert!(!read_bytes(&version_1()).unwrap().metadata.contains_key("offset x"));
    // Comments of any length end with a zero or are filled with zeros.
    let filled = b"filled\0\0\0\0\0\0\0\0\0\0\0\0\0\0\0\0\0\0";
    for comment in [&b"a\0"[..], b"a comment that is rather longer than what TrueMap writes\0", filled, &[0; 24]] {
        assert_heights(&read_bytes(&with_comment(comment)).unwrap(), &wanted);
    }
    let scan = read_bytes(&patched(&gelsight(), 41, 0_f32)).unwrap();
    assert_pitch(&scan, None);
    assert_warns(&scan, "not positive");
}

#[test]
fn other_versions_and_sizes_that_exceed_the_file_are_refused() {
    let sized = |size: [u32; 2]| patched(&gelsight(), 33, size);
    let titled = |title: &str| bytes![title, "\r\n\0\0", [0_u8; 64]];
    assert_refused([
        (titled("Binary TrueMap Data File v3.0"), "v3.0"),
        (titled("Binary TrueMap Data File \\ Ambios File Format"), "\\ Ambios File Format"),
        (sized([u32::MAX; 2]), "the limit is"),
        (sized([1 << 14; 2]), "stop after 24 bytes; wanted 1073741824"),
        (sized([3, 0]), "rows ("),
        (bytes![TITLE, [b'x'; 5000]], "the comment is missing"),
        (bytes!["Binary TrueMap Data File", [b' '; 5000]], "the title is missing"),
    ]);
}
