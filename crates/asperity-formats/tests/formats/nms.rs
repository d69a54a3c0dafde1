use asperity_formats::{Format, Scan};

use crate::check::{assert_no_warning, assert_refused, assert_scan, assert_warns, bytes, padded, patched};
use crate::fixture::{Fixture, read_bytes};
use crate::{NAN, assert_heights, assert_metadata};

/// A file of µsoft with 3 × 2 numbers, and intensities if there are any.
fn nms(intensities: &[u8]) -> Vec<u8> {
    // Data type, dimension type, range of numbers; range of heights in µm.
    let ranges = bytes![[2_i32, 1, 0, 65535], [2.5_f64, 6.0]];
    let texts = bytes![padded("OM_MS_2.0", 20), padded("Confocal Height Image", 1024), padded("2022-02-09T13:25", 20)];
    let start = padded(bytes![ranges, texts, padded(b"R\xf6ntgen", 256)], 1352);
    // Size of the header, three numbers of unknown meaning, columns, rows; steps in nm, and perhaps a position.
    let numbers = bytes![[3468_i32, 2, 0, 0, 3, 2], [3125.0_f64, 6250.0, 24965.75, 4394.5, 29679.75]];
    let header = padded(bytes![start, numbers, i32::from(!intensities.is_empty())], 3468);
    bytes![header, [0_u16, 65535, 13107, 26214, 1, 65534], intensities]
}

/// A file whose last point but one was not seen.
fn with_intensities() -> Vec<u8> {
    nms(&[169, 12, 255, 1, 0, 187])
}

pub(crate) fn fixtures() -> Vec<Fixture> {
    vec![Fixture::whole("NMS", nms(&[])), Fixture::whole("NMS with intensities", with_intensities())]
}

/// 65535 is 5 · 13107: the numbers are 0, 5, 1 and 2 fifths of the range, and a step from its ends.
fn wanted_m() -> [f64; 6] {
    let step = 3.5e-6 / 65535.0;
    [2.5e-6, 6e-6, 3.2e-6, 3.9e-6, 2.5e-6 + step, 6e-6 - step]
}

#[test]
fn the_stated_numbers_are_the_stated_heights_in_micrometres_and_steps_are_nanometres() {
    let scan = assert_scan(&nms(&[]), Format::Nms, (2, 3), (3.125e-6, 6.25e-6), &wanted_m());
    assert_no_warning(&scan);
    assert_metadata(&scan, &[("version", "OM_MS_2.0"), ("title", "Confocal Height Image")]);
    assert_metadata(&scan, &[("date", "2022-02-09T13:25"), ("note", "Röntgen")]);
}

#[test]
fn numbers_outside_of_the_range_and_points_without_intensity_are_missing() {
    let other_range = patched(&patched(&nms(&[]), 8, [1_i32, 65534]), 16, [-1.0_f64, 2.0]);
    let scan = read_bytes(&other_range).unwrap();
    let height_m = |n: f64| (-1.0 + (n - 1.0) * 3.0 / 65533.0) * 1e-6;
    assert_heights(&scan, &[NAN, NAN, height_m(13107.0), height_m(26214.0), -1e-6, 2e-6]);
    assert_warns(&scan, "2 numbers are outside");
    let mut wanted = wanted_m();
    wanted[4] = NAN;
    assert_heights(&read_bytes(&with_intensities()).unwrap(), &wanted);
}

#[test]
fn unknown_versions_and_sizes_of_the_header_give_a_warning() {
    let read = |at, number: i32| -> Scan { read_bytes(&patched(&nms(&[]), at, number)).unwrap() };
    assert_warns(&read_bytes(&patched(&nms(&[]), 32, "OM_MS_3.0")).unwrap(), "OM_MS_3.0");
    assert_warns(&read(1352, 4096), "4096 bytes");
    assert_eq!(Format::detect(&patched(&nms(&[]), 32, "OMMS_2.0")), None);
}

#[test]
fn other_data_and_headers_that_exceed_the_file_are_refused() {
    let with = |at, number: i32| patched(&nms(&[]), at, number);
    let with_height = |at, height_um: f64| patched(&nms(&[]), at, height_um);
    let whole = with_intensities();
    assert_refused([
        (with(4, 0), "a profile"),
        (with(0, 5), "data type 5"),
        (with(4, 2), "dimension type ("),
        (with(12, 0), "n_high ("),
        (with_height(16, NAN), "f_low ("),
        (with_height(24, f64::INFINITY), "f_high ("),
        (with(1368, 0), "nx ("),
        (with(1372, -1), "ny ("),
        (patched(&nms(&[]), 1368, [i32::MAX; 2]), "the limit is"),
        (patched(&nms(&[]), 1368, [100_i32; 2]), "NMS: the heights (byte 3468) stop after 12 bytes; wanted 20000"),
        (whole[..whole.len() - 1].to_vec(), "NMS: the intensities (byte 3480) stop after 5 bytes; wanted 6"),
        (whole[..3000].to_vec(), "NMS: the bytes of the header (byte 0) stop after 3000 bytes; wanted 3468"),
    ]);
}
