use asperity_formats::{Format, FormatError, Scan, Separator, X3pData, read_bytes, write_npy, write_text, write_x3p};
use ndarray::{Array2, array};

use crate::bits;

const NAN: f64 = f64::NAN;

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

fn x3p(scan: &Scan, data: X3pData) -> Scan {
    let read = read_bytes(&write_x3p(scan, data).unwrap()).unwrap();
    assert_eq!(read.warnings, [] as [String; 0]);
    read
}

#[test]
fn x3p_keeps_doubles_pitch_and_description() {
    let (scan, read) = (scan(), x3p(&scan(), X3pData::Float64));
    assert_eq!(bits(&read), bits(&scan));
    assert_eq!(read.pitch_m, scan.pitch_m);
    for (field, text) in &scan.metadata {
        assert_eq!(read.metadata[field], text.replace('\u{1}', ""));
    }
    assert_eq!(read.metadata["Record2/Instrument/Serial"], "not available");
}

#[test]
fn x3p_rounds_floats_to_single_precision() {
    let (scan, read) = (scan(), x3p(&scan(), X3pData::Float32));
    for (z, wanted) in read.heights_m.iter().zip(&scan.heights_m) {
        assert!(z.is_nan() && wanted.is_nan() || *z == f64::from(*wanted as f32));
    }
}

#[test]
fn x3p_rounds_integers_to_half_a_step() {
    let (scan, read) = (scan(), x3p(&scan(), X3pData::Int16));
    let present = || scan.heights_m.iter().copied().filter(|z| !z.is_nan());
    let range = present().fold(f64::MIN, f64::max) - present().fold(f64::MAX, f64::min);
    let half_step = range / 32767.0 / 2.0;
    for (z, wanted) in read.heights_m.iter().zip(&scan.heights_m) {
        assert!(z.is_nan() && wanted.is_nan() || (z - wanted).abs() <= half_step * (1.0 + 1e-9), "{z} {wanted}");
    }
    assert_eq!(read.missing_points(), 3);
}

#[test]
fn x3p_stores_flat_empty_and_extreme_maps() {
    let pitch_m = Some((1e-6, 1e-6));
    for data in [X3pData::Int16, X3pData::Float32, X3pData::Float64] {
        for heights_m in [array![[0.5, 0.5]], array![[NAN, NAN]], array![[1e-6]], array![[f64::INFINITY, 0.25]]] {
            let read = read_bytes(&write_x3p(&Scan::new(heights_m.clone(), pitch_m), data).unwrap()).unwrap();
            let wanted = heights_m.mapv(|z| if z.is_finite() { z } else { NAN });
            let close = |z: f64, w: f64| z.is_nan() && w.is_nan() || (z - w).abs() <= 1e-7 * w.abs();
            assert!(read.heights_m.iter().zip(&wanted).all(|(&z, &w)| close(z, w)), "{data:?} {heights_m}");
        }
    }
    let extreme = Scan::new(array![[-1e308, 1e308]], pitch_m);
    for data in [X3pData::Int16, X3pData::Float32] {
        assert!(matches!(write_x3p(&extreme, data), Err(FormatError::NotStorable { .. })));
    }
    assert_eq!(bits(&read_bytes(&write_x3p(&extreme, X3pData::Float64).unwrap()).unwrap()), bits(&extreme));
}

#[test]
fn x3p_needs_a_pitch_and_a_point() {
    assert!(matches!(
        write_x3p(&Scan::new(array![[0.0]], None), X3pData::Float64),
        Err(FormatError::NoPitch { format: Format::X3p })
    ));
    for (heights_m, pitch_m) in
        [(Array2::zeros((0, 3)), (1e-6, 1e-6)), (array![[0.0]], (0.0, 1e-6)), (array![[0.0]], (1e-6, NAN))]
    {
        assert!(matches!(
            write_x3p(&Scan::new(heights_m, Some(pitch_m)), X3pData::Float64),
            Err(FormatError::NotStorable { .. })
        ));
    }
}

#[test]
fn x3p_bytes_depend_on_nothing_but_the_scan() {
    let bytes = write_x3p(&scan(), X3pData::Int16).unwrap();
    assert_eq!(bytes, write_x3p(&scan(), X3pData::Int16).unwrap());
    // Some readers know the format by these five bytes (version 2.0); then no flags, deflated, 1980-01-01 00:00.
    assert_eq!(bytes[..14], *b"PK\x03\x04\x14\x00\x00\x00\x08\x00\x00\x00\x21\x00");
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

#[test]
fn text_keeps_every_bit_and_the_pitch_with_every_separator() {
    let scan = scan();
    for separator in [Separator::Space, Separator::Comma, Separator::Semicolon, Separator::Tab] {
        let read = read_bytes(&write_text(&scan, separator)).unwrap();
        assert_eq!(bits(&read), bits(&scan));
        assert_eq!(read.pitch_m, scan.pitch_m);
        assert_eq!(read.warnings, [] as [String; 0]);
    }
    let extremes = Scan::new(array![[f64::MIN_POSITIVE / 8.0, f64::MAX], [-0.0, 0.1 + 0.2]], None);
    let read = read_bytes(&write_text(&extremes, Separator::Comma)).unwrap();
    assert_eq!(bits(&read), bits(&extremes));
    assert_eq!(read.pitch_m, None);
}

#[test]
fn a_map_that_looks_like_points_is_written_so_that_it_stays_a_map() {
    let map = Scan::new(
        Array2::from_shape_fn((30, 3), |(row, column)| [row % 5, row / 5, row][column] as f64),
        Some((1.0, 1.0)),
    );
    let read = read_bytes(&write_text(&map, Separator::Space)).unwrap();
    assert_eq!(bits(&read), bits(&map));
}
