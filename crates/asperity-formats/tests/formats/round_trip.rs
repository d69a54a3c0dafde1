use std::path::Path;

use asperity_formats::{Format, FormatError, Scan, to_bytes, write_npy, write_sur, write_x3p};
use ndarray::{Array2, array};

use crate::fixture::read_bytes;
use crate::{NAN, bits};

/// A tilted wave of 7 × 5 points with three voids.
fn scan() -> Scan {
    let mut heights_m = Array2::from_shape_fn((5, 7), |(row, column)| {
        let (x, y) = (column as f64, row as f64);
        1e-6 * (x / 3.0).sin() + 1e-7 * y - 2e-6
    });
    for point in [[0, 0], [1, 1], [4, 6]] {
        heights_m[point] = NAN;
    }
    let mut scan = Scan::new(heights_m, Some((1.27656509837346e-7, 3.14582113527746e-7)));
    for (field, text) in [
        ("Record2/Date", "2016-12-01T14:30:59+01:00"),
        ("Record2/Creator", "A <operator> & \"co\""),
        ("Record2/Instrument/Model", "µSurf\u{1}"),
        ("Record2/ProbingSystem/Type", "NonContacting"),
        ("Record2/Comment", "two\nlines"),
    ] {
        scan.metadata.insert(field.into(), text.into());
    }
    scan
}

fn x3p(scan: &Scan) -> Scan {
    let read = read_bytes(&write_x3p(scan).unwrap()).unwrap();
    assert_eq!(read.warnings, [] as [String; 0]);
    read
}

#[test]
fn x3p_keeps_doubles_pitch_and_description() {
    let (scan, read) = (scan(), x3p(&scan()));
    assert_eq!(bits(&read), bits(&scan));
    assert_eq!(read.pitch_m, scan.pitch_m);
    for (field, text) in &scan.metadata {
        assert_eq!(read.metadata[field], text.replace('\u{1}', ""));
    }
    assert_eq!(read.metadata["Record2/Instrument/Serial"], "not available");
}

#[test]
fn x3p_keeps_operator_date_and_comment_of_other_formats() {
    let mut scan = Scan::new(array![[0.0, 1e-6]], Some((1e-6, 1e-6)));
    for (field, text) in [("operator name", "A. Operator"), ("date", "2016-12-01T14:30:59"), ("comment", "a < b")] {
        scan.metadata.insert(field.into(), text.into());
    }
    let read = x3p(&scan);
    assert_eq!(read.metadata["Record2/Creator"], "A. Operator");
    assert_eq!(read.metadata["Record2/Date"], "2016-12-01T14:30:59");
    assert_eq!(read.metadata["Record2/Comment"], "a < b");
    // The schema has no place for dates of other forms.
    scan.metadata.insert("date".into(), "1 Dec 2016".into());
    assert_eq!(x3p(&scan).metadata["Record2/Date"], "1970-01-01T00:00:00Z");
}

#[test]
fn x3p_stores_flat_empty_and_extreme_maps() {
    for heights_m in
        [array![[0.5, 0.5]], array![[NAN, NAN]], array![[1e-6]], array![[f64::INFINITY, 0.25]], array![[-1e308, 1e308]]]
    {
        let scan = Scan::new(heights_m.mapv(|z| if z.is_finite() { z } else { NAN }), Some((1e-6, 1e-6)));
        let read = read_bytes(&write_x3p(&Scan::new(heights_m, scan.pitch_m)).unwrap()).unwrap();
        assert_eq!(bits(&read), bits(&scan));
    }
}

#[test]
fn x3p_needs_a_pitch_and_a_point() {
    assert!(matches!(write_x3p(&Scan::new(array![[0.0]], None)), Err(FormatError::NoPitch { format: Format::X3p })));
    for (heights_m, pitch_m) in
        [(Array2::zeros((0, 3)), (1e-6, 1e-6)), (array![[0.0]], (0.0, 1e-6)), (array![[0.0]], (1e-6, NAN))]
    {
        assert!(matches!(write_x3p(&Scan::new(heights_m, Some(pitch_m))), Err(FormatError::NotStorable { .. })));
    }
}

#[test]
fn x3p_bytes_depend_only_on_the_scan() {
    let bytes = write_x3p(&scan()).unwrap();
    assert_eq!(bytes, write_x3p(&scan()).unwrap());
    // Some readers detect the format by these five bytes (version 2.0). No flags, deflated, 1980-01-01 00:00 follow.
    assert_eq!(bytes[..14], *b"PK\x03\x04\x14\x00\x00\x00\x08\x00\x00\x00\x21\x00");
}

#[test]
fn x3p_stores_files_unpacked_that_would_exceed_the_limit() {
    // 2100² points are more than the 2²² that any archive may hold, and zeros deflate a thousandfold.
    let mut flat = Scan::new(Array2::zeros((2100, 2100)), Some((1e-6, 1e-6)));
    flat.heights_m[[7, 5]] = NAN;
    let bytes = write_x3p(&flat).unwrap();
    assert!(bytes.len() > 8 * flat.heights_m.len());
    assert_eq!(bits(&read_bytes(&bytes).unwrap()), bits(&flat));
}

/// Number of steps of the range.
const SUR_STEPS: f64 = 2147483646.0;

/// Asserts that heights are off by half a step of the range at most, the range counted from the lowest height as `f32`.
fn assert_within_half_a_step(read: &Scan, scan: &Scan) {
    let present = || scan.heights_m.iter().copied().filter(|z| z.is_finite());
    let (low, high) = (present().fold(f64::MAX, f64::min), present().fold(f64::MIN, f64::max));
    // The offset is at most one f32 below the lowest height, and the spacing at most one f32 above the exact one.
    let range = high - low + low.abs() * f64::from(f32::EPSILON);
    let half_step = range / SUR_STEPS / 2.0 * (1.0 + f64::from(f32::EPSILON));
    // Heights are converted between units in f64.
    let rounding = 4.0 * f64::EPSILON * low.abs().max(high.abs());
    for (z, wanted) in read.heights_m.iter().zip(&scan.heights_m) {
        assert_eq!(z.is_nan(), !wanted.is_finite());
        assert!(z.is_nan() || (z - wanted).abs() <= half_step + rounding, "{z:e}, wanted {wanted:e} ± {half_step:e}");
    }
}

fn sur(scan: &Scan) -> Scan {
    let read = read_bytes(&write_sur(scan).unwrap()).unwrap();
    assert_eq!(read.heights_m.dim(), scan.heights_m.dim());
    read
}

#[test]
fn sur_rounds_heights_to_half_a_step_and_the_pitch_to_single_precision() {
    let (scan, read) = (scan(), sur(&scan()));
    assert_within_half_a_step(&read, &scan);
    assert_eq!(read.missing_points(), 3);
    assert_eq!(read.warnings, [] as [String; 0]);
    let ((dx, dy), (wanted_dx, wanted_dy)) = (read.pitch_m.unwrap(), scan.pitch_m.unwrap());
    for (pitch, wanted) in [(dx, wanted_dx), (dy, wanted_dy)] {
        assert!((pitch / wanted - 1.0).abs() <= f64::from(f32::EPSILON) / 2.0, "{pitch:e}, wanted {wanted:e}");
    }
}

#[test]
fn sur_is_unchanged_by_a_second_round_trip() {
    let once = sur(&scan());
    let twice = sur(&once);
    assert_eq!(once.pitch_m, twice.pitch_m);
    let range = 2e-6 + 0.5e-6;
    for (z, wanted) in twice.heights_m.iter().zip(&once.heights_m) {
        assert!(z.is_nan() && wanted.is_nan() || (z - wanted).abs() <= range / 2147483646.0, "{z:e} {wanted:e}");
    }
}

#[test]
fn sur_keeps_whole_nanometres_of_a_pitch() {
    for (dx_m, dy_m) in [(2.58e-6, 0.645e-6), (1e-6, 0.5e-6), (3e-9, 1e-3), (16.016e-3, 1.0)] {
        let read = sur(&Scan::new(array![[0.0, 1e-6]], Some((dx_m, dy_m))));
        let (dx, dy) = read.pitch_m.unwrap();
        assert!((dx / dx_m - 1.0).abs() < 4.0 * f64::EPSILON && (dy / dy_m - 1.0).abs() < 4.0 * f64::EPSILON);
    }
}

#[test]
fn sur_keeps_heights_far_from_zero() {
    // A stage at 25 mm: the offset alone, as f32, is off by up to 2 nm.
    let far = Scan { heights_m: scan().heights_m + 0.0251234567, ..scan() };
    assert_within_half_a_step(&sur(&far), &far);
    let below = Scan { heights_m: scan().heights_m - 1.1, ..scan() };
    assert_within_half_a_step(&sur(&below), &below);
}

#[test]
fn sur_stores_flat_empty_and_extreme_maps() {
    let pitch_m = Some((1e-6, 1e-6));
    let maps = [
        array![[0.5, 0.5]],
        array![[0.1, 0.1], [NAN, 0.1]],
        array![[0.0, 0.0]],
        array![[-0.3]],
        array![[1e-6]],
        array![[f64::INFINITY, 0.25]],
        array![[1e-12, 1.0000001e-12]],
        array![[0.0, 1e-34]],
        array![[-1e30, 1e30]],
    ];
    for heights_m in &maps {
        let scan = Scan::new(heights_m.clone(), pitch_m);
        assert_within_half_a_step(&sur(&scan), &scan);
    }
    assert_eq!(sur(&Scan::new(array![[NAN, NAN]], pitch_m)).missing_points(), 2);
    for heights_m in [array![[-1e308, 1e308]], array![[0.0, 1e308]], array![[1e40, 1e40]]] {
        let error = write_sur(&Scan::new(heights_m, pitch_m)).unwrap_err();
        assert!(matches!(error, FormatError::NotStorable { .. }), "{error}");
    }
}

#[test]
fn sur_needs_a_pitch_and_a_point() {
    let without = write_sur(&Scan::new(array![[0.0]], None));
    assert!(matches!(without, Err(FormatError::NoPitch { format: Format::Sur })));
    for (heights_m, pitch_m) in [
        (Array2::zeros((0, 3)), (1e-6, 1e-6)),
        (array![[0.0]], (0.0, 1e-6)),
        (array![[0.0]], (-1e-6, 1e-6)),
        (array![[0.0]], (1e-6, NAN)),
        (array![[0.0]], (1e-60, 1e-6)),
        (array![[0.0]], (1e60, 1e-6)),
    ] {
        let error = write_sur(&Scan::new(heights_m, Some(pitch_m))).unwrap_err();
        assert!(matches!(error, FormatError::NotStorable { .. }), "{error}");
    }
}

#[test]
fn sur_keeps_name_operator_date_and_comment_of_either_format() {
    let mut own = Scan::new(array![[0.0, 1e-6]], Some((1e-6, 1e-6)));
    for (field, text) in [
        ("object name", "gear 7, a name that is longer than its field"),
        ("operator name", "A. Opérateur"),
        ("date", "2016-12-01T14:30:59"),
        ("comment", "two\nlines, 3 μm"),
    ] {
        own.metadata.insert(field.into(), text.into());
    }
    let read = sur(&own);
    assert_eq!(read.metadata["object name"], "gear 7, a name that is longer");
    assert_eq!(read.channels, ["gear 7, a name that is longer"]);
    assert_eq!(read.metadata["operator name"], "A. Opérateur");
    assert_eq!(read.metadata["date"], "2016-12-01T14:30:59");
    assert_eq!(read.metadata["comment"], "two\nlines, 3 µm");
    let read = sur(&scan());
    assert_eq!(read.metadata["operator name"], "A <operator> & \"co\"");
    assert_eq!(read.metadata["date"], "2016-12-01T14:30:59");
    assert_eq!(read.metadata["comment"], "two\nlines");
    for wrong in ["yesterday", "2016-13-01T14:30:59", "2016-12-01", "1970-01-01T00:00:00Z", "２０１６-12-01T14:30:59"]
    {
        own.metadata.insert("date".into(), wrong.into());
        assert_eq!(sur(&own).metadata.get("date"), None, "{wrong}");
    }
    own.metadata.insert("comment".into(), "x".repeat(100_000));
    assert_eq!(sur(&own).metadata["comment"].len(), 32767);
}

#[test]
fn sur_bytes_depend_only_on_the_scan() {
    assert_eq!(write_sur(&scan()).unwrap(), write_sur(&scan()).unwrap());
    let bytes = write_sur(&scan()).unwrap();
    assert_eq!(bytes.len(), 512 + "two\nlines".len() + 4 * 5 * 7);
    let number = |place: usize| i32::from_le_bytes(bytes[place..place + 4].try_into().unwrap());
    // Numbers from 0 up to the highest but one, so that readers that count from the z minimum agree; voids below.
    assert_eq!((number(100), number(512 + "two\nlines".len())), (0, -2));
    assert!((2147483000..=2147483646).contains(&number(104)), "{}", number(104));
}

#[test]
fn npy_keeps_every_bit() {
    let scan = scan();
    let bytes = write_npy(&scan);
    assert_eq!(bytes.len() % 64, 5 * 7 * 8 % 64, "the array starts at a multiple of 64 bytes");
    assert_eq!(bits(&read_bytes(&bytes).unwrap()), bits(&scan));
    let transposed = Scan::new(scan.heights_m.clone().reversed_axes(), None);
    let read = read_bytes(&write_npy(&transposed)).unwrap();
    assert_eq!(read.heights_m.dim(), (7, 5));
    assert_eq!(bits(&read), bits(&transposed));
}

/// Returns the bytes of a file of this name.
fn text(scan: &Scan, name: &str) -> Vec<u8> {
    to_bytes(scan, Path::new(name)).unwrap()
}

#[test]
fn text_keeps_every_bit_and_the_pitch_with_either_separator() {
    let scan = scan();
    for (name, separator) in [("a.txt", b' '), ("a.csv", b',')] {
        let bytes = text(&scan, name);
        let row = bytes.split(|&byte| byte == b'\n').nth(2).unwrap();
        assert_eq!(row.split(|&byte| byte == separator).count(), 7);
        let read = read_bytes(&bytes).unwrap();
        assert_eq!(bits(&read), bits(&scan));
        assert_eq!(read.pitch_m, scan.pitch_m);
        assert_eq!(read.warnings, [] as [String; 0]);
    }
    let extremes = Scan::new(array![[f64::MIN_POSITIVE / 8.0, f64::MAX], [-0.0, 0.1 + 0.2]], None);
    let read = read_bytes(&text(&extremes, "a.csv")).unwrap();
    assert_eq!(bits(&read), bits(&extremes));
    assert_eq!(read.pitch_m, None);
}

#[test]
fn a_map_that_looks_like_points_is_written_so_that_it_stays_a_map() {
    let map = Scan::new(
        Array2::from_shape_fn((30, 3), |(row, column)| [row % 5, row / 5, row][column] as f64),
        Some((1.0, 1.0)),
    );
    let read = read_bytes(&text(&map, "a.txt")).unwrap();
    assert_eq!(bits(&read), bits(&map));
}
