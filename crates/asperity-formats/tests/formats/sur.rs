use asperity_formats::{Format, FormatError, read_bytes};

use crate::assert_heights;
use crate::fixture::Fixture;
use crate::fixtures::Sur;

const NAN: f64 = f64::NAN;

pub(crate) fn fixtures() -> Vec<Fixture> {
    vec![Fixture::whole("SUR of int16", Sur::default().bytes())]
}

#[test]
fn int16_heights_are_scaled_shifted_and_voids_are_two_below_the_minimum() {
    let scan = read_bytes(&Sur::default().bytes()).unwrap();
    assert_eq!(scan.heights_m.dim(), (2, 3));
    // n · 2 nm + 1000 nm.
    assert_heights(&scan, &[1200e-9, 1400e-9, NAN, 400e-9, 1800e-9, 2000e-9]);
    let (dx_m, dy_m) = scan.pitch_m.unwrap();
    assert!((dx_m / 0.5e-6 - 1.0).abs() < 1e-15 && (dy_m / 0.25e-3 - 1.0).abs() < 1e-15);
}

#[test]
fn a_height_outside_of_the_stated_range_is_doubted() {
    let scan = read_bytes(&Sur::default().bytes()).unwrap();
    assert!(scan.warnings.iter().any(|warning| warning.starts_with("1 heights are outside")), "{:?}", scan.warnings);
}

#[test]
fn int32_heights_read_up_to_the_ends_of_their_range() {
    let heights = [i32::MIN, i32::MIN + 2, 0, i32::MAX];
    let file = Sur {
        bits: 32,
        size: (2, 2),
        z_range: (i32::MIN + 2, i32::MAX),
        spacing: [1.0, 1.0, 0.5],
        units: [b"m", b"um", b"cm"],
        z_offset: 0.0,
        data: heights.iter().flat_map(|z| z.to_le_bytes()).collect(),
        ..Sur::default()
    };
    let scan = read_bytes(&file.bytes()).unwrap();
    assert_heights(&scan, &[NAN, -2147483646.0 * 0.005, 0.0, 2147483647.0 * 0.005]);
    assert_eq!(scan.pitch_m, Some((1.0, 1e-6)));
}

#[test]
fn without_special_points_the_code_is_a_height() {
    let scan = read_bytes(&Sur { special_points: 0, ..Sur::default() }.bytes()).unwrap();
    assert_heights(&scan, &[1200e-9, 1400e-9, 1196e-9, 400e-9, 1800e-9, 2000e-9]);
    assert!(scan.warnings.iter().any(|warning| warning.starts_with("1 heights equal the code")), "{:?}", scan.warnings);
}

#[test]
fn the_minimum_of_all_integers_leaves_no_code() {
    let file = Sur { z_range: (i32::MIN, i32::MAX), ..Sur::default() };
    assert_eq!(read_bytes(&file.bytes()).unwrap().missing_points(), 0);
}

#[test]
fn units_are_lengths_in_several_spellings() {
    let spellings: [(&[u8], f64); 8] = [
        (b"m", 1.0),
        (b"cm", 1e-2),
        (b"mm", 1e-3),
        (b"um", 1e-6),
        (b"\xb5m", 1e-6),
        (b"\xc2\xb5m", 1e-6),
        (b"nm\x00junk", 1e-9),
        (b" nm", 1e-9),
    ];
    for (unit, metres) in spellings {
        let file = Sur { units: [unit, unit, unit], spacing: [1.0, 1.0, 1.0], z_offset: 0.0, ..Sur::default() };
        let scan = read_bytes(&file.bytes()).unwrap();
        assert_eq!(scan.pitch_m, Some((metres, metres)));
        assert_eq!(scan.heights_m[[0, 0]], 100.0 * metres);
    }
}

#[test]
fn a_height_that_is_no_length_is_an_error_and_a_position_that_is_none_a_warning() {
    let error = read_bytes(&Sur { units: [b"mm", b"mm", b"V"], ..Sur::default() }.bytes()).unwrap_err();
    assert!(error.to_string().starts_with("SUR: z step unit (byte 212) is `V`; wanted a unit of length"), "{error}");
    let scan = read_bytes(&Sur { units: [b"s", b"mm", b"mm"], ..Sur::default() }.bytes()).unwrap();
    assert_eq!(scan.pitch_m, None);
    assert!(scan.warnings.iter().any(|warning| warning.contains("the x step unit is `s`")), "{:?}", scan.warnings);
}

#[test]
fn a_unit_ratio_that_contradicts_the_units_is_doubted() {
    let mut bytes = Sur::default().bytes();
    let doubted = |bytes: &[u8]| read_bytes(bytes).unwrap().warnings.iter().any(|w| w.contains("x unit ratio"));
    assert!(!doubted(&bytes));
    // Steps in µm, lengths in mm: the ratio is 1000 or its inverse.
    bytes[228..244].copy_from_slice(b"mm              ");
    assert!(doubted(&bytes));
    for ratio in [1000_f32, 0.001] {
        bytes[276..280].copy_from_slice(&ratio.to_le_bytes());
        assert!(!doubted(&bytes));
    }
}

#[test]
fn the_comment_and_the_header_are_kept() {
    let scan = read_bytes(&Sur::default().bytes()).unwrap();
    let wanted = [
        ("comment", "hob ground, µ = 0.1"),
        ("object name", "gear 7"),
        ("operator name", "A. Operator"),
        ("acquisition type", "1"),
        ("date", "2016-12-01T14:30:59"),
        ("measurement duration", "12.5"),
        ("z step unit", "nm"),
        ("z offset", "1000"),
    ];
    for (field, text) in wanted {
        assert_eq!(scan.metadata.get(field).map(String::as_str), Some(text), "{field}");
    }
}

#[test]
fn comment_and_private_zone_are_skipped_by_their_sizes() {
    let plain = read_bytes(&Sur { comment: b"", private: b"", ..Sur::default() }.bytes()).unwrap();
    let long: &'static [u8] = &[b'x'; 30_000];
    let skipped = read_bytes(&Sur { comment: long, private: long, ..Sur::default() }.bytes()).unwrap();
    assert_eq!(crate::bits(&plain), crate::bits(&skipped));
}

#[test]
fn compressed_big_endian_and_other_objects_are_refused_with_a_reason() {
    let mut big_endian = Sur::default().bytes();
    big_endian[12..14].copy_from_slice(&[1, 1]);
    let cases = [
        (Sur { signature: b"DSCOMPRESSED", ..Sur::default() }.bytes(), "compressed"),
        (big_endian, "big-endian"),
        (Sur { object_type: 1, size: (6, 1), ..Sur::default() }.bytes(), "profile"),
        (Sur { object_type: 12, ..Sur::default() }.bytes(), "colour image"),
        (Sur { object_type: 99, ..Sur::default() }.bytes(), "not published"),
    ];
    for (bytes, reason) in cases {
        match read_bytes(&bytes) {
            Err(FormatError::Unsupported { format: Format::Sur, found, .. }) => {
                assert!(found.contains(reason), "{found}")
            }
            other => panic!("{other:?}"),
        }
    }
}

#[test]
fn many_lines_called_a_profile_are_a_surface_with_a_warning() {
    let scan = read_bytes(&Sur { object_type: 1, ..Sur::default() }.bytes()).unwrap();
    assert!(scan.warnings.iter().any(|warning| warning.contains("calls itself a profile")));
}

#[test]
fn headers_that_the_bytes_cannot_bear_out_are_errors() {
    let huge = Sur { size: (i32::MAX, i32::MAX), ..Sur::default() }.bytes();
    assert!(matches!(read_bytes(&huge), Err(FormatError::TooLarge { .. })));
    let long = Sur { size: (16384, 16384), ..Sur::default() }.bytes();
    assert!(matches!(read_bytes(&long), Err(FormatError::Truncated { found: 12, wanted: 536_870_912, .. })));
    for (file, field) in [
        (Sur { size: (0, 2), ..Sur::default() }, "points per line"),
        (Sur { size: (3, -2), ..Sur::default() }, "number of lines"),
        (Sur { bits: 8, ..Sur::default() }, "bits per point"),
        (Sur { spacing: [1.0, 1.0, f32::NAN], ..Sur::default() }, "z spacing"),
        (Sur { spacing: [1.0, 1.0, 0.0], ..Sur::default() }, "z spacing"),
        (Sur { z_offset: f32::INFINITY, ..Sur::default() }, "z offset"),
    ] {
        match read_bytes(&file.bytes()) {
            Err(FormatError::Field { field: found, .. }) => assert_eq!(found, field),
            other => panic!("{other:?}"),
        }
    }
    let mut miscounted = Sur::default().bytes();
    miscounted[116] = 7;
    assert!(matches!(read_bytes(&miscounted), Err(FormatError::Field { wanted, .. }) if wanted == "3 × 2 = 6"));
    let short = &Sur::default().bytes()[..400];
    assert!(matches!(read_bytes(short), Err(FormatError::Truncated { found: 400, wanted: 512, .. })));
}
