use std::path::Path;

use asperity_formats::{Format, FormatError, Scan, to_bytes, write_sur, write_x3p};
use ndarray::{Array2, array};

use crate::check::{assert_error, assert_no_warning, assert_pitch};
use crate::fixture::read_bytes;
use crate::{NAN, assert_metadata, bits};

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

fn of_metadata(fields: &[(&str, &str)]) -> Scan {
    let mut scan = Scan::new(array![[0.0, 1e-6]], Some((1e-6, 1e-6)));
    scan.metadata = fields.iter().map(|&(field, text)| (field.into(), text.into())).collect();
    scan
}

/// Returns the bytes of a file of this name.
fn written(scan: &Scan, name: &str) -> Result<Vec<u8>, FormatError> {
    to_bytes(scan, Path::new(name)).map_err(|error| match error {
        FormatError::File { error, .. } => *error,
        other => other,
    })
}

fn again(scan: &Scan, name: &str) -> Scan {
    read_bytes(&written(scan, name).unwrap()).unwrap()
}

/// Formats that store `f64`, and whether they state the pitch.
const EXACT: [(&str, bool); 7] = [
    ("a.x3p", true),
    ("a.sdf", true),
    ("a.gwy", true),
    ("a.npy", false),
    ("a.txt", true),
    ("a.csv", true),
    ("a.DAT", true),
];

#[test]
fn exact_formats_keep_every_bit_and_the_pitch_in_bytes_that_depend_only_on_the_scan() {
    let extremes = array![[f64::MIN_POSITIVE / 8.0, 1e308], [-0.0, 0.1 + 0.2]];
    let flat = [array![[0.5, 0.5]], array![[NAN, NAN]], array![[1e-6]], array![[NAN, 0.25]], array![[-1e308, 1e308]]];
    let maps = flat.into_iter().chain([extremes, scan().heights_m.reversed_axes()]);
    let scans: Vec<Scan> = maps.map(|map| Scan::new(map, Some((1e-6, 2e-6)))).chain([scan()]).collect();
    for (name, keeps_pitch) in EXACT {
        for scan in &scans {
            let read = again(scan, name);
            // X3P has an offset to add, which leaves no negative zero.
            let sign = if name == "a.x3p" { 0.0 } else { -0.0 };
            let wanted = bits(&Scan { heights_m: &scan.heights_m + sign, ..scan.clone() });
            assert_eq!((read.heights_m.dim(), bits(&read)), (scan.heights_m.dim(), wanted.clone()), "{name}");
            assert_pitch(&read, scan.pitch_m.filter(|_| keeps_pitch));
            assert_eq!(written(scan, name).unwrap(), written(scan, name).unwrap());
            // Infinities are missing.
            let infinite = Scan {
                heights_m: scan.heights_m.mapv(|z| if z.is_nan() { -f64::INFINITY } else { z }),
                ..scan.clone()
            };
            assert_eq!(bits(&again(&infinite, name)), wanted, "{name}");
        }
    }
}

#[test]
fn every_format_needs_a_point_and_a_pitch_if_it_states_one() {
    for name in ["a.x3p", "a.sur", "a.sdf", "a.gwy", "a.vti"] {
        let without = written(&Scan { pitch_m: None, ..scan() }, name);
        assert!(matches!(without, Err(FormatError::NoPitch { .. })), "{name}");
        let sides = [(0.0, 1e-6), (-1e-6, 1e-6), (1e-6, NAN), (1e308, 1e308)];
        let pitches = sides.map(|pitch_m| Scan { pitch_m: Some(pitch_m), ..scan() });
        for wrong in pitches.into_iter().chain([Scan::new(Array2::zeros((0, 3)), Some((1e-6, 1e-6)))]) {
            assert_error(written(&wrong, name), "cannot be stored");
        }
    }
}

#[test]
fn x3p_keeps_the_description_and_operator_date_and_comment_of_other_formats() {
    let (scan, read) = (scan(), again(&scan(), "a.x3p"));
    assert_no_warning(&read);
    for (field, text) in &scan.metadata {
        assert_eq!(read.metadata[field], text.replace('\u{1}', ""));
    }
    assert_eq!(read.metadata["Record2/Instrument/Serial"], "not available");
    let other = of_metadata(&[("operator name", "A. Operator"), ("date", "2016-12-01T14:30:59"), ("comment", "a < b")]);
    let read = again(&other, "a.x3p");
    assert_metadata(&read, &[("Record2/Creator", "A. Operator"), ("Record2/Date", "2016-12-01T14:30:59")]);
    assert_metadata(&read, &[("Record2/Comment", "a < b")]);
    // The schema has no place for dates of other forms.
    let read = again(&of_metadata(&[("date", "1 Dec 2016")]), "a.x3p");
    assert_metadata(&read, &[("Record2/Date", "1970-01-01T00:00:00Z")]);
    // Some readers detect the format by these five bytes (version 2.0). No flags, deflated, 1980-01-01 00:00 follow.
    assert_eq!(write_x3p(&scan).unwrap()[..14], *b"PK\x03\x04\x14\x00\x00\x00\x08\x00\x00\x00\x21\x00");
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
fn assert_within_half_a_step(scan: &Scan) -> Scan {
    let read = again(scan, "a.sur");
    assert_eq!(read.heights_m.dim(), scan.heights_m.dim());
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
    read
}

#[test]
fn sur_rounds_heights_to_half_a_step_and_the_pitch_to_single_precision() {
    let (scan, read) = (scan(), assert_within_half_a_step(&scan()));
    assert_no_warning(&read);
    let ((dx, dy), (wanted_dx, wanted_dy)) = (read.pitch_m.unwrap(), scan.pitch_m.unwrap());
    for (pitch, wanted) in [(dx, wanted_dx), (dy, wanted_dy)] {
        assert!((pitch / wanted - 1.0).abs() <= f64::from(f32::EPSILON) / 2.0, "{pitch:e}, wanted {wanted:e}");
    }
    // A second round trip moves nothing by more than a step.
    let twice = again(&read, "a.sur");
    assert_eq!(read.pitch_m, twice.pitch_m);
    for (z, wanted) in twice.heights_m.iter().zip(&read.heights_m) {
        assert!(z.is_nan() && wanted.is_nan() || (z - wanted).abs() <= 2.5e-6 / SUR_STEPS, "{z:e} {wanted:e}");
    }
    // Whole nanometres of a pitch are exact.
    for pitch_m in [(2.58e-6, 0.645e-6), (1e-6, 0.5e-6), (3e-9, 1e-3), (16.016e-3, 1.0)] {
        assert_pitch(&again(&Scan::new(array![[0.0, 1e-6]], Some(pitch_m)), "a.sur"), pitch_m);
    }
}

#[test]
fn sur_stores_distant_flat_empty_and_extreme_maps() {
    // A stage at 25 mm: the offset alone, as f32, is off by up to 2 nm.
    let maps = [
        scan().heights_m + 0.0251234567,
        scan().heights_m - 1.1,
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
    let pitch_m = Some((1e-6, 1e-6));
    for heights_m in maps {
        assert_within_half_a_step(&Scan::new(heights_m, pitch_m));
    }
    assert_eq!(again(&Scan::new(array![[NAN, NAN]], pitch_m), "a.sur").missing_points(), 2);
    let heights = [array![[-1e308, 1e308]], array![[0.0, 1e308]], array![[1e40, 1e40]]];
    let beyond = heights.map(|heights_m| Scan::new(heights_m, pitch_m)).into_iter();
    let pitches = [(1e-60, 1e-6), (1e60, 1e-6)].map(|pitch_m| Scan::new(array![[0.0]], Some(pitch_m)));
    for scan in beyond.chain(pitches) {
        assert!(matches!(write_sur(&scan), Err(FormatError::NotStorable { format: Format::Sur, .. })));
    }
}

#[test]
fn sur_keeps_name_operator_date_and_comment_of_either_format() {
    let name = ("object name", "gear 7, a name that is longer than its field");
    let [operator, comment] = [("operator name", "A. Opérateur"), ("comment", "two\nlines, 3 μm")];
    let read = again(&of_metadata(&[name, operator, ("date", "2016-12-01T14:30:59"), comment]), "a.sur");
    assert_eq!(read.channels, ["gear 7, a name that is longer"]);
    assert_metadata(&read, &[("object name", "gear 7, a name that is longer"), operator]);
    assert_metadata(&read, &[("date", "2016-12-01T14:30:59"), ("comment", "two\nlines, 3 µm")]);
    let read = again(&scan(), "a.sur");
    assert_metadata(&read, &[("operator name", "A <operator> & \"co\""), ("date", "2016-12-01T14:30:59")]);
    assert_metadata(&read, &[("comment", "two\nlines")]);
    for wrong in ["yesterday", "2016-13-01T14:30:59", "2016-12-01", "1970-01-01T00:00:00Z", "２０１６-12-01T14:30:59"]
    {
        assert_eq!(again(&of_metadata(&[("date", wrong)]), "a.sur").metadata.get("date"), None, "{wrong}");
    }
    let long = again(&of_metadata(&[("comment", &"x".repeat(100_000))]), "a.sur");
    assert_eq!(long.metadata["comment"].len(), 32767);
    let bytes = write_sur(&scan()).unwrap();
    assert_eq!((bytes.len(), &bytes), (512 + 9 + 4 * 5 * 7, &write_sur(&scan()).unwrap()));
    let number = |place: usize| i32::from_le_bytes(bytes[place..place + 4].try_into().unwrap());
    // Numbers from 0 up to the highest but one, so that readers that count from the z minimum agree; voids below.
    assert_eq!((number(100), number(512 + 9)), (0, -2));
    assert!((2147483000..=2147483646).contains(&number(104)), "{}", number(104));
}

#[test]
fn npy_and_text_are_written_so_that_their_readers_take_them_for_maps() {
    let (npy, csv) = (written(&scan(), "a.npy").unwrap(), written(&scan(), "a.csv").unwrap());
    assert_eq!(npy.len() % 64, 5 * 7 * 8 % 64, "the array starts at a multiple of 64 bytes");
    for (bytes, separator) in [(written(&scan(), "a.txt").unwrap(), b' '), (csv, b',')] {
        let row = bytes.split(|&byte| byte == b'\n').nth(2).unwrap();
        assert_eq!(row.split(|&byte| byte == separator).count(), 7);
        assert_no_warning(&read_bytes(&bytes).unwrap());
    }
    let most = Scan::new(array![[f64::MAX, f64::MIN]], None);
    assert_eq!(bits(&again(&most, "a.csv")), bits(&most));
    // A map that looks like points.
    let points = Array2::from_shape_fn((30, 3), |(row, column)| [row % 5, row / 5, row][column] as f64);
    let map = Scan::new(points, Some((1.0, 1.0)));
    assert_eq!(bits(&again(&map, "a.txt")), bits(&map));
}
