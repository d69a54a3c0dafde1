//! VK4: the header, the table of offsets, the measurement conditions and images, in the order and with the widths of
//! the published layout; VK6 around it.

use asperity_formats::{Format, Scan};

use crate::check::{assert_pitch, assert_refused, assert_scan, assert_warns, bytes, patched, warns};
use crate::fixture::{Fixture, read_bytes, read_channel};
use crate::fixtures::zip;
use crate::{NAN, assert_heights, assert_metadata, bits};

/// Offsets of the conditions and of the first layer of the usual file.
const CONDITIONS: usize = 12 + 4 * 18;
const LAYER: usize = CONDITIONS + 76 * 4 + 4 + 20 + 4 + 16;

/// A layer of heights: columns, rows and bits; no compression; range of the palette and 256 colours.
fn layer(size: [u32; 3], data: &[u8]) -> Vec<u8> {
    bytes![size, [0, data.len() as u32], [0_u32, 255], [7_u8; 768], data]
}

/// 2 lines of 3 heights.
fn of_32_bits(numbers: [u32; 6]) -> Vec<u8> {
    layer([3, 2, 32], &bytes![numbers])
}

/// The measurement conditions: 76 numbers, named by their place.
fn conditions() -> Vec<u8> {
    // Year, month, day, hour, minute, second; minutes ahead of UTC.
    let date = bytes![76_u32 * 4, [2022_u32, 10, 23, 12, 13, 10], -240_i32];
    // Image attributes, user interface mode, colour composition, layers, run mode, peak mode, sharpening level.
    let modes = [8_u32, 9, 10, 1, 12, 13, 14];
    // Speed, distance, pitch in nm, zoom · 10, number of lines, first line, 3 reserved.
    let speed = [15_u32, 16_000, 750, 10, 768, 20, 0, 0, 0];
    // Magnification · 10, PMT gain mode, gain, offset, ND filter, reserved, average, shutter mode, shutter speed.
    let lens = [500_u32, 25, 26, 27, 28, 0, 30, 31, 32];
    // White balance mode, red, blue; camera gain, plane compensation; units of lengths and heights, their decimal places.
    let camera = [33_u32, 34, 35, 36, 37, 38, 39, 40, 41];
    let lengths_pm = [1_250_000_u32, 2_500_000, 100];
    // 5 reserved, light filter, reserved, gamma reverse, gamma, its offset, CCD offset.
    let gamma = [0_u32, 0, 0, 0, 0, 50, 0, 52, 53, 54, 55];
    // Numerical aperture · 1000, head type, second PMT gain, colour omitted, lens ID, LUT mode, 5 pairs of the LUT.
    let head = bytes![[950_u32, 57, 58, 59, 60, 61], [0_u32; 10]];
    // Upper and lower position in nm, effective bits of light and height.
    bytes![date, modes, speed, lens, camera, lengths_pm, gamma, head, [72_u32, 73, 16, 21]]
}

/// A file of a signature, whose table of offsets has `entries`, and of up to three layers.
fn vk4(signature: &str, entries: usize, layers: [Option<Vec<u8>>; 3]) -> Vec<u8> {
    let start = 12 + 4 * entries;
    let mut parts = conditions();
    let strings_at = (start + parts.len()) as u32;
    // Each string after its length in units of UTF-16.
    for text in ["Zahnrad µ7", "Plan 50x"] {
        let units: Vec<u16> = text.encode_utf16().collect();
        parts.extend(bytes![units.len() as u32, units]);
    }
    let heights = layers.map(|layer| {
        let at = (start + parts.len()) as u32;
        parts.extend(layer.iter().flatten());
        if layer.is_some() { at } else { 0 }
    });
    // Conditions; colour of peak and light; 3 of light; 3 of heights; 4 thumbnails, assembly, line measurement, line
    // thickness, strings, and in VK4 one that is reserved.
    let table = bytes![[start as u32, 0, 0, 0, 0, 0], heights, [0, 0, 0, 0, 0, 0, 0, strings_at, 0]];
    // Version of the library, the main number last; type of the file.
    bytes![signature, [4_u8, 3, 2, 1], 0_u32, table[..4 * entries], parts]
}

fn layered(layer: Vec<u8>) -> Vec<u8> {
    vk4("VK4_", 18, [Some(layer), None, None])
}

fn usual() -> Vec<u8> {
    layered(of_32_bits([10, 20, 30, 40, 0, 60]))
}

/// A VK6 or VK7 file: signature, size of the preview, preview (a BMP header: `BM`, its size, no more), archive.
fn vk6(signature: &str, files: &[(&str, &[u8])]) -> Vec<u8> {
    bytes![signature, 14_u32, "BM", 14_u32, [0_u8; 8], zip(files)]
}

/// A VK6 file with an image of errors: its columns, rows, bytes per point and per row, and rows.
fn with_errors(head: [u32; 4], rows: &[u8]) -> Vec<u8> {
    let images = zip(&[("HdrImageData", b"left out"), ("ErrorImageData", &bytes![head, rows])]);
    vk6("VK6", &[("Vk4File", &usual()), ("Vk6ImageData", &images)])
}

pub(crate) fn fixtures() -> Vec<Fixture> {
    let small = layer([2, 2, 16], &[1, 0, 2, 0, 3, 0, 255, 255]);
    vec![
        Fixture::whole("VK4 of one layer", usual()),
        // The second layer comes last, so the first alone is read of a beginning.
        Fixture::open_ended("VK3 of two layers", vk4("VK3_", 17, [Some(small.clone()), None, Some(small)])),
        Fixture::whole("VK6 with errors", with_errors([3, 2, 1, 4], &[0, 1, 0, 0, 0, 0, 0, 0])),
    ]
}

const WANTED_M: [f64; 6] = [1e-9, 2e-9, 3e-9, 4e-9, 0.0, 6e-9];

fn read(bytes: &[u8]) -> Scan {
    read_bytes(bytes).unwrap()
}

#[test]
fn heights_and_pitches_are_picometre_and_the_first_line_is_at_the_top() {
    let scan = assert_scan(&usual(), Format::Vk, (2, 3), (1.25e-6, 2.5e-6), &WANTED_M);
    assert_eq!(scan.channels, ["Height 1"]);
    // Heights of 0 are kept with a warning.
    assert_warns(&scan, "1 heights are 0");
    assert!(!warns(&read(&layered(of_32_bits([1, 2, 3, 4, 5, 6]))), "heights are 0"));
    // VK3 has a shorter table.
    let older = read(&vk4("VK3_", 17, [Some(of_32_bits([10, 20, 30, 40, 0, 60])), None, None]));
    assert_eq!((bits(&older), older.metadata), (bits(&scan), scan.metadata));
    assert_pitch(&read(&patched(&usual(), CONDITIONS + 4 * 42, 0_u32)), None);
}

#[test]
fn numbers_of_every_width_are_unsigned() {
    for (bits, data, wanted) in [
        (8, vec![1, 128, 255, 2], [1e-10, 128e-10, 255e-10, 2e-10]),
        (16, vec![1, 0, 0, 128, 255, 255, 2, 0], [1e-10, 32768e-10, 65535e-10, 2e-10]),
        (32, bytes![[1_u32, 1 << 31, u32::MAX, 2]], [1e-10, 2147483648e-10, 4294967295e-10, 2e-10]),
    ] {
        assert_heights(&read(&layered(layer([2, 2, bits], &data))), &wanted);
    }
}

#[test]
fn layers_of_heights_are_channels_by_their_numbers() {
    let layers = [Some(of_32_bits([10; 6])), None, Some(of_32_bits([1, 2, 3, 4, 5, 6]))];
    let file = vk4("VK4_", 18, layers);
    let scan = read(&file);
    assert_eq!((scan.channels, scan.channel), (vec!["Height 1".to_owned(), "Height 3".to_owned()], 0));
    let scan = read_channel(&file, "height 3").unwrap();
    assert_heights(&scan, &[1e-10, 2e-10, 3e-10, 4e-10, 5e-10, 6e-10]);
    assert_eq!(scan.channel, 1);
}

#[test]
fn the_measurement_conditions_and_strings_are_kept() {
    let scan = read(&usual());
    assert_metadata(&scan, &[("date", "2022-10-23T12:13:10-04:00"), ("library version", "1.2.3.4")]);
    assert_metadata(&scan, &[("title", "Zahnrad µ7"), ("lens name", "Plan 50x"), ("image layers", "1")]);
    assert_metadata(&scan, &[("run mode", "12"), ("peak mode", "13"), ("sharpening level", "14"), ("speed", "15")]);
    assert_metadata(&scan, &[("distance", "16000 nm"), ("pitch", "750 nm"), ("optical zoom", "1")]);
    assert_metadata(&scan, &[("number of lines", "768"), ("first line position", "20"), ("lens magnification", "50")]);
    assert_metadata(&scan, &[("PMT gain mode", "25"), ("PMT gain", "26"), ("PMT offset", "27"), ("ND filter", "28")]);
    assert_metadata(&scan, &[("image average frequency", "30"), ("shutter speed", "32"), ("plane compensation", "37")]);
    assert_metadata(&scan, &[("x length per pixel", "1250000 pm"), ("y length per pixel", "2500000 pm")]);
    assert_metadata(&scan, &[("z length per digit", "100 pm"), ("numerical aperture", "0.95"), ("head type", "57")]);
    assert_metadata(&scan, &[("lens ID", "60"), ("upper position", "72 nm"), ("lower position", "73 nm")]);
    assert_metadata(&scan, &[("height effective bit depth", "21")]);
    // The length of the title, right after the conditions.
    let scan = read(&patched(&usual(), CONDITIONS + 304, u32::MAX));
    assert!(!scan.metadata.contains_key("title") && !scan.metadata.contains_key("lens name"));
}

#[test]
fn vk6_and_vk7_hold_a_vk4_file_in_an_archive_after_a_preview() {
    for signature in ["VK6", "VK7"] {
        let file = vk6(signature, &[("Vk6ImageData", &zip(&[])), ("Vk4File", &usual())]);
        let scan = assert_scan(&file, Format::Vk, (2, 3), (1.25e-6, 2.5e-6), &WANTED_M);
        assert_eq!(scan.metadata["lens name"], "Plan 50x");
    }
    assert_eq!(Format::detect(b"VK6 sample\n1 2\n3 4\n"), Some(Format::Text));
}

#[test]
fn points_of_the_image_of_errors_are_missing() {
    // Rows of 3 points in 4 bytes; the fourth is no point.
    let rows = [0, 1, 0, 9, 255, 0, 0, 9];
    let scan = read(&with_errors([3, 2, 1, 4], &rows));
    assert_heights(&scan, &[1e-9, NAN, 3e-9, NAN, 0.0, 6e-9]);
    assert_warns(&scan, "2 points are marked in ErrorImageData");
    let scan = read(&with_errors([3, 2, 1, 3], &[0; 6]));
    assert_heights(&scan, &WANTED_M);
    assert!(!warns(&scan, "ErrorImageData"));
    // One that does not fit is left out with a warning.
    for (head, rows, reason) in [
        ([2, 2, 1, 2], vec![1; 4], "width (ErrorImageData, byte 0) is `2`; wanted 3"),
        ([3, 3, 1, 3], vec![1; 9], "height (ErrorImageData, byte 4) is `3`; wanted 2"),
        ([3, 2, 4, 12], vec![1; 12], "bytes per point (ErrorImageData, byte 8) is `4`; wanted 1"),
        ([3, 2, 1, 2], vec![1; 6], "bytes per row (ErrorImageData, byte 12) is `2`"),
        ([3, 2, 1, 3], vec![1; 5], "the rows (ErrorImageData, byte 16) stop after 5 bytes; wanted 6"),
        ([3, 2, 1, 3], vec![1; 13], "the file's size in bytes (ErrorImageData, byte 0) is 29; the limit is 28"),
    ] {
        let scan = read(&with_errors(head, &rows));
        assert_eq!(scan.missing_points(), 0);
        assert_warns(&scan, &format!("ErrorImageData was left out: VK4/VK6: {reason}"));
    }
    // Damage to it leaves the heights.
    for bit in 0..8 * rows.len() as u32 + 128 {
        let mut image = bytes![[3_u32, 2, 1, 4], rows];
        image[bit as usize / 8] ^= 1 << (bit % 8);
        let (head, rows) = image.split_at(16);
        let head = [0, 4, 8, 12].map(|at| u32::from_le_bytes(head[at..at + 4].try_into().unwrap()));
        assert_eq!(read(&with_errors(head, rows)).heights_m.dim(), (2, 3));
    }
}

#[test]
fn archives_layers_and_conditions_that_do_not_fit_are_refused() {
    let with = |at: usize, number: u32| patched(&usual(), at, number);
    let sized = |size: [u32; 3]| patched(&usual(), LAYER, size);
    assert_refused([
        (vk6("VK6", &[("Other", b"")]), "VK4/VK6: Vk4File: no such file in the archive"),
        (patched(&vk6("VK7", &[]), 3, u32::MAX), "VK4/VK6: the bytes of the preview (byte 7) stop after"),
        (vk6("VK6", &[("Vk4File", b"VK4_")]), "VK4/VK6: file type (Vk4File, byte 8) stop after 0 bytes; wanted 4"),
        (layered(layer([3, 2, 32], &[1; 20])), "is `20`; wanted 24, the size of uncompressed heights"),
        (
            vk4("VK4_", 18, [None, None, None]),
            "VK4/VK6: the file holds no heights, only images; wanted a layer of heights",
        ),
        (sized([u32::MAX, u32::MAX, 32]), "the limit is"),
        (sized([0, 2, 32]), "width ("),
        (sized([3, 0, 32]), "height ("),
        (sized([3, 2, 24]), "bit depth ("),
        (with(CONDITIONS + 4 * 44, 0), "z length per digit ("),
        (with(12, 0), "VK4/VK6: the offset of the measurement conditions is missing (byte 12); wanted a value above 0"),
        // Conditions that end before the lengths.
        (with(CONDITIONS, 168), "length per"),
    ]);
    // The field for compression alone means nothing.
    assert_eq!(bits(&read(&patched(&usual(), LAYER + 12, *b"MC32"))), bits(&read(&usual())));
    assert_warns(&read(&with(8, 2)), "the file type is 2, not 0");
}
