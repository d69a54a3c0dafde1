use asperity_formats::{Format, Scan};

use crate::check::{assert_refused, assert_scan, assert_warns, bytes};
use crate::fixture::{Fixture, read_bytes};
use crate::{NAN, assert_heights};

#[derive(Clone, Copy)]
enum Text {
    Ascii,
    Utf16,
    Utf16Marked,
    Utf16Big,
}

/// Returns a header of `characters` characters in the encoding of the variant, filled up with spaces, and the data.
fn file(lines: &[&str], text: Text, characters: usize, data: &[u8]) -> Vec<u8> {
    let mut header: String = lines.iter().flat_map(|line| [line, "\n"]).collect();
    if matches!(text, Text::Utf16Marked) {
        header.insert(0, '\u{feff}');
    }
    let filled = characters - header.chars().count();
    header.push_str(&" ".repeat(filled));
    let mut bytes: Vec<u8> = match text {
        Text::Ascii => header.into_bytes(),
        Text::Utf16 | Text::Utf16Marked => header.encode_utf16().flat_map(u16::to_le_bytes).collect(),
        Text::Utf16Big => header.encode_utf16().flat_map(u16::to_be_bytes).collect(),
    };
    bytes.extend(data);
    bytes
}

/// Integers with everything that is spelt out.
const INTEGERS: [&str; 14] = [
    "fileformat = bcrstm",
    "% a comment = 3",
    "xpixels = 3",
    "ypixels = 2",
    "xlength = 30",
    "ylength = 10",
    "xunit = nm",
    "yunit = nm",
    "zunit = nm",
    "bit2nm = 0.5",
    "voidpixels = 1",
    "intelmode = 1",
    "starttime = 12 01 16 14:30:59:00",
    "forcecurve = 0",
];

fn numbers() -> Vec<u8> {
    bytes![[1_i16, -2, 3, i16::MIN, 32767, 6]]
}

fn floats() -> Vec<u8> {
    bytes![[1.5_f32, -2.0, f32::MAX, NAN as f32, 5.0, 1.8e38]]
}

fn with(line: &'static str) -> Vec<&'static str> {
    let key = |line: &str| line.split('=').next().unwrap().trim().to_owned();
    let mut lines: Vec<&str> = INTEGERS.iter().copied().filter(|old| key(old) != key(line)).collect();
    lines.push(line);
    lines.rotate_right(usize::from(line.starts_with("fileformat")));
    lines
}

fn without(key: &str) -> Vec<&'static str> {
    INTEGERS.iter().copied().filter(|line| !line.starts_with(key)).collect()
}

fn read(lines: &[&str]) -> Scan {
    read_bytes(&file(lines, Text::Ascii, 2048, &numbers())).unwrap()
}

const HEIGHTS: [f64; 6] = [0.5e-9, -1e-9, 1.5e-9, -16384e-9, NAN, 3e-9];

pub(crate) fn fixtures() -> Vec<Fixture> {
    let unicode = with("fileformat = bcrf_unicode");
    vec![
        Fixture::whole("BCR integers", file(&INTEGERS, Text::Ascii, 2048, &numbers())),
        Fixture::whole("BCR floats, Unicode", file(&unicode, Text::Utf16, 2048, &floats())),
    ]
}

#[test]
fn integers_are_steps_and_the_greatest_is_missing() {
    // 30 nm are three points of 10 nm, 10 nm are two of 5 nm. Units that are not named are nanometre.
    let without_units: Vec<&str> = INTEGERS.iter().copied().filter(|line| !line.contains("unit")).collect();
    for lines in [&INTEGERS[..], &without_units] {
        let bytes = file(lines, Text::Ascii, 2048, &numbers());
        let scan = assert_scan(&bytes, Format::Bcr, (2, 3), (1e-8, 5e-9), &HEIGHTS);
        assert_eq!(scan.metadata["starttime"], "12 01 16 14:30:59:00");
        assert!(!scan.metadata.keys().any(|key| key.contains("comment")));
    }
    assert_heights(&read(&with("zunit = [um]")), &HEIGHTS.map(|z| z * 1e3));
    let big = [1_i16, 256, 3, 4, 32767, 6].map(i16::to_be_bytes).concat();
    let scan = read_bytes(&file(&with("intelmode = 0"), Text::Ascii, 2048, &big)).unwrap();
    assert_heights(&scan, &[0.5e-9, 128e-9, 1.5e-9, 2e-9, NAN, 3e-9]);
}

#[test]
fn floats_are_heights_in_their_unit_and_great_ones_are_missing() {
    let lines = [
        "fileformat = bcrf",
        "xpixels = 3",
        "ypixels = 2",
        "xlength = 3",
        "ylength = 4",
        " xunit = um",
        " yunit = um",
        " zunit = um",
    ];
    // A factor for integers does not change floats.
    let scaled = [&lines[..], &["bit2nm = 2"]].concat();
    for lines in [&lines[..], &scaled] {
        let bytes = file(lines, Text::Ascii, 2048, &floats());
        let heights = [1.5e-6, -2e-6, NAN, NAN, 5e-6, NAN];
        let scan = assert_scan(&bytes, Format::Bcr, (2, 3), (1e-6, 2e-6), &heights);
        assert_eq!(crate::check::warns(&scan, "bit2nm is 2"), lines.len() > 8, "{:?}", scan.warnings);
    }
}

#[test]
fn headers_may_be_unicode_in_either_order_and_longer() {
    for (text, format, size) in [
        (Text::Utf16, "fileformat = bcrstm_unicode", 2048),
        (Text::Utf16Marked, "fileformat = bcrstm_unicode", 2048),
        (Text::Utf16Big, "fileformat = bcrstm_unicode", 2048),
        (Text::Ascii, "fileformat = bcrstm", 3000),
        (Text::Utf16, "fileformat = bcrstm_unicode", 3000),
    ] {
        let mut lines = if size == 3000 { with("headersize = 3000") } else { INTEGERS.to_vec() };
        lines[0] = format;
        assert_heights(&read_bytes(&file(&lines, text, size, &numbers())).unwrap(), &HEIGHTS);
    }
}

#[test]
fn the_mark_is_a_height_if_the_header_declares_no_missing_points() {
    let scan = read(&with("voidpixels = 0"));
    assert_heights(&scan, &[0.5e-9, -1e-9, 1.5e-9, -16384e-9, 16383.5e-9, 3e-9]);
    assert_warns(&scan, "1 heights equal the code");
    // Some files state the mark itself, some nothing.
    assert_eq!(read(&with("voidpixels = 3.402823E+38")).missing_points(), 1);
    assert_eq!(read(&without("voidpixels")).missing_points(), 1);
}

#[test]
fn a_pixel_size_needs_lengths() {
    assert_eq!(read(&without("ylength")).pitch_m, None);
    let scan = read(&with("xunit = V"));
    assert_eq!(scan.pitch_m, None);
    assert_warns(&scan, "xunit is `V`");
}

#[test]
fn records_other_than_height_maps_are_refused_with_the_reason() {
    for (lines, words) in [
        (with("forcecurve = 1"), "BCR: the file holds force curves; wanted a height map"),
        (with("zunit = V"), "BCR: the values are in V, which is not a length; wanted heights"),
        (with("fileformat = bcrz"), "BCR: fileformat (byte 0) is `bcrz`"),
        (without("xpixels"), "BCR: xpixels is missing"),
        (with("ypixels = two"), "BCR: ypixels (byte 0) is `two`; wanted a whole number"),
        (with("ypixels = 0"), "BCR: ypixels (byte 0) is `0`; wanted 1 or more"),
        (without("bit2nm"), "BCR: bit2nm is missing"),
        (with("bit2nm = 0"), "BCR: bit2nm (byte 0) is `0`"),
        (with("headersize = many"), "BCR: headersize (byte 0) is `many`"),
        (with("ypixels = 3"), "BCR: the heights (byte 2048) stop after 12 bytes; wanted 18"),
    ] {
        assert_refused([(file(&lines, Text::Ascii, 2048, &numbers()), words)]);
    }
}
