//! TrueMap TMD.

use asperity_formats::FormatError;

use crate::fixture::{Fixture, read_bytes, unsupported};
use crate::{NAN, assert_heights, assert_metadata};

/// Variable parts of a file.
struct Tmd {
    title: &'static [u8],
    comment: &'static [u8],
    size: (u32, u32),
    lengths_mm: (f32, f32),
    offsets_mm: Option<(f32, f32)>,
    heights_mm: Vec<f32>,
}

impl Default for Tmd {
    /// Three columns and two rows as GelSight's routines write them.
    fn default() -> Self {
        Self {
            title: b"Binary TrueMap Data File v2.0\r\n\0",
            comment: b"\0",
            size: (3, 2),
            lengths_mm: (0.75, 1.0),
            offsets_mm: Some((2.5, 0.0)),
            heights_mm: vec![0.5, -0.25, f32::NAN, 1.0, f32::INFINITY, 0.125],
        }
    }
}

impl Tmd {
    fn bytes(&self) -> Vec<u8> {
        let mut bytes = [self.title, self.comment].concat();
        bytes.extend(self.size.0.to_le_bytes());
        bytes.extend(self.size.1.to_le_bytes());
        let (x, y) = self.lengths_mm;
        let (x_offset, y_offset) = self.offsets_mm.unzip();
        for length in [Some(x), Some(y), x_offset, y_offset].into_iter().flatten() {
            bytes.extend(length.to_le_bytes());
        }
        bytes.extend(self.heights_mm.iter().flat_map(|z| z.to_le_bytes()));
        bytes
    }
}

/// As TrueMap v6 writes them: a comment of 24 bytes with the zero.
fn truemap() -> Tmd {
    Tmd { comment: b"Created by TrueMap v6\r\n\0", ..Tmd::default() }
}

fn version_1() -> Tmd {
    Tmd { title: b"Binary TrueMap Data File\r\n\0", offsets_mm: None, ..Tmd::default() }
}

pub(crate) fn fixtures() -> Vec<Fixture> {
    vec![
        Fixture::whole("TMD of GelSight", Tmd::default().bytes()),
        Fixture::whole("TMD of TrueMap", truemap().bytes()),
        Fixture::whole("TMD version 1", version_1().bytes()),
    ]
}

#[test]
fn heights_and_lengths_are_millimetres_and_the_first_row_is_on_top() {
    for file in [Tmd::default(), truemap(), version_1()] {
        let scan = read_bytes(&file.bytes()).unwrap();
        assert_eq!(scan.heights_m.dim(), (2, 3));
        assert_heights(&scan, &[0.5e-3, -0.25e-3, NAN, 1e-3, NAN, 0.125e-3]);
        // 0.75 mm hold 3 columns, 1 mm holds 2 rows.
        let (dx_m, dy_m) = scan.pitch_m.unwrap();
        assert!((dx_m / 0.25e-3 - 1.0).abs() < 1e-15 && (dy_m / 0.5e-3 - 1.0).abs() < 1e-15, "{dx_m:e} {dy_m:e}");
    }
}

#[test]
fn the_comment_and_the_offsets_are_kept() {
    let scan = read_bytes(&truemap().bytes()).unwrap();
    assert_metadata(&scan, &[("comment", "Created by TrueMap v6"), ("offset x", "2.5 mm"), ("offset y", "0 mm")]);
    assert!(!read_bytes(&version_1().bytes()).unwrap().metadata.contains_key("offset x"));
}

#[test]
fn comments_of_any_length_end_with_a_zero_or_are_filled_with_zeros() {
    let plain = read_bytes(&Tmd::default().bytes()).unwrap();
    let comments: [&[u8]; 4] = [
        b"a\0",
        b"a comment that is rather longer than what TrueMap writes\0",
        b"filled\0\0\0\0\0\0\0\0\0\0\0\0\0\0\0\0\0\0",
        b"\0\0\0\0\0\0\0\0\0\0\0\0\0\0\0\0\0\0\0\0\0\0\0\0",
    ];
    for comment in comments {
        let scan = read_bytes(&Tmd { comment, ..Tmd::default() }.bytes()).unwrap();
        assert_eq!(crate::bits(&scan), crate::bits(&plain), "{}", comment.escape_ascii());
    }
}

#[test]
fn bytes_after_the_heights_give_a_warning() {
    let mut bytes = Tmd::default().bytes();
    assert!(read_bytes(&bytes).unwrap().warnings.iter().all(|warning| !warning.contains("follow")));
    bytes.extend([0; 5]);
    let scan = read_bytes(&bytes).unwrap();
    assert!(scan.warnings.iter().any(|warning| warning.starts_with("5 bytes follow")), "{:?}", scan.warnings);
}

#[test]
fn lengths_that_are_none_leave_no_pixel_size() {
    let scan = read_bytes(&Tmd { lengths_mm: (0.0, 1.0), ..Tmd::default() }.bytes()).unwrap();
    assert_eq!(scan.pitch_m, None);
    assert!(scan.warnings.iter().any(|warning| warning.contains("not positive")), "{:?}", scan.warnings);
}

#[test]
fn other_versions_are_refused() {
    for (title, version) in [
        (&b"Binary TrueMap Data File v3.0\r\n\0"[..], "v3.0"),
        (b"Binary TrueMap Data File \\ Ambios File Format\r\n\0", "\\ Ambios File Format"),
    ] {
        let found = unsupported(&Tmd { title, ..Tmd::default() }.bytes());
        assert!(found.contains(version), "{found}");
    }
}

#[test]
fn sizes_that_exceed_the_file_are_errors() {
    let huge = Tmd { size: (u32::MAX, u32::MAX), ..Tmd::default() }.bytes();
    assert!(matches!(read_bytes(&huge), Err(FormatError::TooLarge { .. })));
    let long = Tmd { size: (1 << 14, 1 << 14), ..Tmd::default() }.bytes();
    assert!(matches!(read_bytes(&long), Err(FormatError::Truncated { found: 24, wanted: 1_073_741_824, .. })));
    let none = Tmd { size: (3, 0), ..Tmd::default() }.bytes();
    assert!(matches!(read_bytes(&none), Err(FormatError::Field { field, .. }) if field == "rows"));
    let endless = [&b"Binary TrueMap Data File v2.0\r\n\0"[..], &[b'x'; 5000]].concat();
    assert!(matches!(read_bytes(&endless), Err(FormatError::MissingField { field, .. }) if field == "the comment"));
    let endless = [&b"Binary TrueMap Data File"[..], &[b' '; 5000]].concat();
    assert!(matches!(read_bytes(&endless), Err(FormatError::MissingField { field, .. }) if field == "the title"));
}
