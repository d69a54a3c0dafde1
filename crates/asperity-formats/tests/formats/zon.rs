use asperity_formats::{Format, FormatError};

use crate::check::{assert_refused, assert_scan, bytes, patched};
use crate::fixture::{Fixture, read_bytes};
use crate::fixtures::zip;

const SCALES: &str = "<Calibration><XYCalibration><MeterPerPixel>2e-6</MeterPerPixel></XYCalibration><ZCalibration>\
    <MeterPerUnit>1e-9</MeterPerUnit></ZCalibration></Calibration>";

/// An array of 3 × 2 numbers of `size` bytes, with `padding` bytes after each row.
fn array(size: i32, padding: usize, numbers: &[i32]) -> Vec<u8> {
    let row = 3 * size as usize + padding;
    let mut bytes = bytes![[3, 2, size, row as i32]];
    for numbers in numbers.chunks(3) {
        numbers.iter().for_each(|n| bytes.extend(&n.to_le_bytes()[..size as usize]));
        bytes.extend(vec![0xee; padding]);
    }
    bytes
}

/// A file of a description, heights and marks after a picture.
fn zon(heights: &[u8], marks: &[u8], scales: &str) -> Vec<u8> {
    files(b"KPK0", scales.as_bytes(), heights, marks)
}

fn files(magic: &[u8], scales: &[u8], heights: &[u8], marks: &[u8]) -> Vec<u8> {
    let archive = zip(&[
        ("686613b8-27b5-4a29-8ffc-438c2780873e", scales),
        ("4cdb0c75-5706-48cc-a9a1-adf395d609ae", heights),
        ("9e7ca6dd-0e6a-4d7b-8986-f0a7b773c916", marks),
    ]);
    bytes![magic, "\x05\0\0\0BM...", archive]
}

const NUMBERS: [i32; 6] = [1, -2, 3, 4, 5, 6];

/// A file whose arrays and description are packed with Zstandard.
fn packed() -> Vec<u8> {
    packed_files(&array(4, 4, &NUMBERS), SCALES.as_bytes())
}

fn packed_files(heights: &[u8], scales: &[u8]) -> Vec<u8> {
    let pack = |bytes: &[u8]| ruzstd::encoding::compress_to_vec(bytes, ruzstd::encoding::CompressionLevel::Fastest);
    files(b"KPK1", &pack(scales), &pack(heights), &pack(&array(1, 1, &[0, 4, 0, 1, 0, 2])))
}

pub(crate) fn fixtures() -> Vec<Fixture> {
    let plain = zon(&array(4, 4, &NUMBERS), &array(1, 1, &[0, 4, 0, 1, 0, 2]), SCALES);
    vec![Fixture::open_ended("ZON", plain), Fixture::open_ended("packed ZON", packed())]
}

#[test]
fn heights_are_units_and_marked_points_are_missing() {
    let plain = |padding: usize| zon(&array(4, padding, &NUMBERS), &array(1, 1, &[0, 4, 0, 1, 0, 2]), SCALES);
    for bytes in [plain(0), plain(4), packed()] {
        assert_scan(&bytes, Format::Zon, (2, 3), (2e-6, 2e-6), &[1e-9, -2e-9, 3e-9, f64::NAN, 5e-9, f64::NAN]);
    }
}

#[test]
fn a_zstandard_bomb_is_refused_with_little_memory() {
    let zeros = vec![0; 256 << 20];
    let bytes = packed_files(&zeros, SCALES.as_bytes());
    drop(zeros);
    let (result, peak) = crate::memory::peak_bytes(|| read_bytes(&bytes));
    assert!(matches!(result.unwrap_err(), FormatError::TooLarge { .. }));
    assert!(bytes.len() < 1 << 20 && peak <= 64 << 20, "{peak} bytes of memory for {}", bytes.len());
}

#[test]
fn arrays_that_do_not_fit_and_missing_scales_are_refused() {
    let (good, marks) = (array(4, 0, &NUMBERS), array(1, 0, &[0; 6]));
    assert_refused([
        (zon(&array(2, 0, &NUMBERS), &marks, SCALES), "bytes of a number ("),
        (zon(&good[..good.len() - 1], &marks, SCALES), "stop after"),
        (zon(&good, &patched(&marks, 0, 2_u8), SCALES), "the marks of 2 × 2 points"),
        (zon(&good, &marks, "<Calibration/>"), "MeterPerPixel"),
    ]);
}
