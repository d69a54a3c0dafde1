use asperity_formats::{Format, Scan, write_sdf};
use ndarray::array;

use crate::check::{Raw, assert_no_warning, assert_refused, assert_scan, assert_warns, bytes, patched};
use crate::fixture::{Fixture, read_bytes};
use crate::{NAN, assert_heights, assert_metadata, bits};

/// The fields of a binary file one after the other, in the order and with the widths of ISO 25178-71, table 2.
fn binary(version: &str, size: [u32; 2], scale: [f64; 3], codes: [u8; 3], data: impl Raw) -> Vec<u8> {
    // Manufacturer, in 10 bytes; created and modified, DDMMYYYYHHMM.
    let start = bytes![version, "Micro 7   ", "301120161430", "011220161430"];
    let counts = if version == "bISO-2.0" { bytes![size] } else { bytes![size.map(|count| count as u16)] };
    // Scales, and the unknown resolution of heights; compression, data type, check type.
    bytes![start, counts, scale, -1_f64, codes, data]
}

const SCALE: [f64; 3] = [5e-5, 2.5e-5, 1e-9];
const HEIGHTS: [i16; 6] = [0, 100, -200, 300, i16::MIN, i16::MAX];
/// The greatest number is a height in ISO files, the least is none.
const WANTED_M: [f64; 6] = [0.0, 1e-7, -2e-7, 3e-7, NAN, 32767e-9];

/// A file of 3 × 2 signed numbers of 16 bits.
fn usual() -> Vec<u8> {
    binary("bISO-1.0", [3, 2], SCALE, [0, 5, 0], HEIGHTS)
}

const TRAILER: &str = "PartName = gear 7\r\n";

fn version_2() -> Vec<u8> {
    binary("bISO-2.0", [3, 2], SCALE, [0, 5, 0], bytes![HEIGHTS, TRAILER])
}

/// Example of the standard, with other heights and a missing point.
const TEXT: &str = "aISO-1.0\r\nManufacID = ISOTC213\r\nCreateDate = 040120100853\r\nModDate = 050320101353\r\n\
    NumPoints = 3\r\nNumProfiles = 2\r\nXscale = 1.0E-6\r\nYscale = 2.0E-6\r\nZscale = 1.0E-6\r\n\
    Zresolution = 1.0E-9\r\nCompression = 0\r\nDataType = 7\r\nCheckType = 0\r\n*\r\n\
    1.00000 0.99874 0.99495\r\n0.98865 BAD -0.5\r\n*\r\n< OperatorName > Tom Jones < / OperatorName >\r\n\
    PartName = gear 7\r\nhob ground\r\n*\r\n";

pub(crate) fn fixtures() -> Vec<Fixture> {
    let doubles = binary("bBCR-1.0", [3, 2], SCALE, [0, 7, 0], [0_f64, 1.0, 2.0, 3.0, 4.0, 5.0]);
    vec![
        Fixture { needed: TEXT.find("-0.5").unwrap() + 2, ..Fixture::whole("SDF text", TEXT.into()) },
        Fixture::whole("SDF binary", usual()),
        Fixture { needed: version_2().len() - TRAILER.len(), ..Fixture::whole("SDF version 2", version_2()) },
        Fixture::whole("SDF doubles", doubles),
    ]
}

#[test]
fn heights_pitch_and_voids_of_a_binary_file() {
    let scan = assert_scan(&usual(), Format::Sdf, (2, 3), (5e-5, 2.5e-5), &WANTED_M);
    assert_no_warning(&scan);
    assert_metadata(&scan, &[("version", "bISO-1.0"), ("ManufacID", "Micro 7"), ("CreateDate", "301120161430")]);
    assert_metadata(&scan, &[("ModDate", "011220161430")]);
    // Version 2 has wider counts.
    let scan = assert_scan(&version_2(), Format::Sdf, (2, 3), (5e-5, 2.5e-5), &WANTED_M);
    assert_eq!(scan.metadata["PartName"], "gear 7");
    // Two more fields of a header are skipped, a trailer of their length is not.
    let extra = binary("bISO-1.0", [3, 2], SCALE, [0, 5, 0], bytes![[5_u32, 1], HEIGHTS]);
    assert_heights(&read_bytes(&extra).unwrap(), &WANTED_M);
    let scan = read_bytes(&bytes![usual(), "a = 1234"]).unwrap();
    assert_heights(&scan, &WANTED_M);
    assert_eq!(scan.metadata["a"], "1234");
}

#[test]
fn heights_pitch_and_voids_of_a_text() {
    let wanted = [1e-6, 0.99874e-6, 0.99495e-6, 0.98865e-6, NAN, -0.5e-6];
    let scan = assert_scan(TEXT.as_bytes(), Format::Sdf, (2, 3), (1e-6, 2e-6), &wanted);
    assert_metadata(&scan, &[("ManufacID", "ISOTC213"), ("Zresolution", "1.0E-9"), ("OperatorName", "Tom Jones")]);
    assert_metadata(&scan, &[("PartName", "gear 7"), ("trailer", "hob ground")]);
    assert!(!scan.metadata.contains_key("Xscale"));
    // Texts of other programs: another version, keys in any case, line ends, no equals signs, comments, a height per line,
    // fields of no use, NaN for BAD, no trailer, no end.
    for text in [
        TEXT.into(),
        TEXT.replace("aISO-1.0", "aNPL-V1.0"),
        TEXT.replace("ManufacID", "ManuFacID").replace("NumPoints", "NUMPOINTS"),
        TEXT.replace("\r\n", "\n"),
        TEXT.replace("\r\n", "\r"),
        TEXT.replace(" = ", "   "),
        TEXT.replace("Xscale", "; a comment = 3\r\nXscale").replace("0.99495\r\n", "0.99495 ; first\r\n"),
        TEXT.replace(' ', "\r\n").replace("\r\n=\r\n", " = "),
        TEXT.replace("CheckType", "NumDataSet = 1\r\nNanPresent = 0\r\nCheckType"),
        TEXT.replace("BAD", "NaN"),
        TEXT[..TEXT.find("< Op").unwrap()].into(),
        TEXT[..TEXT.find("*\r\n< Op").unwrap()].into(),
    ] {
        let other = read_bytes(text.as_bytes()).unwrap_or_else(|error| panic!("{text}: {error}"));
        assert_eq!(bits(&other), bits(&scan), "{text}");
        assert_no_warning(&other);
    }
    // Integers in text bear the mark of their type too.
    let integers = TEXT.replace("DataType = 7", "DataType = 5").replace("BAD", "-32768");
    assert_eq!(read_bytes(integers.as_bytes()).unwrap().missing_points(), 1);
    let scan = read_bytes(TEXT.replace("NumProfiles = 2", "NumProfiles = 1").as_bytes()).unwrap();
    assert_eq!(scan.heights_m.dim(), (1, 3));
    assert_warns(&scan, "3 numbers after");
}

#[test]
fn every_type_of_number_is_read_with_the_mark_of_its_dialect() {
    // The number 7 and the marks for missing points: least and greatest of the type.
    let numbers = [
        bytes![[7, u8::MIN, u8::MAX]],
        bytes![[7, u16::MIN, u16::MAX]],
        bytes![[7, u32::MIN, u32::MAX]],
        bytes![[7.0, f32::MIN, f32::MAX]],
        bytes![[7, i8::MIN, i8::MAX]],
        bytes![[7, i16::MIN, i16::MAX]],
        bytes![[7, i32::MIN, i32::MAX]],
        bytes![[7.0, f64::MIN, NAN]],
    ];
    for (version, number, least, greatest) in [
        ("bISO-1.0", 4, NAN, 127.0),
        ("bISO-1.0", 5, NAN, 32767.0),
        ("bISO-1.0", 6, NAN, 2147483647.0),
        ("bISO-1.0", 3, NAN, NAN),
        ("bISO-1.0", 7, NAN, NAN),
        // Of unsigned types zero is a height.
        ("bBCR-1.0", 0, 0.0, NAN),
        ("bBCR-1.0", 1, 0.0, NAN),
        ("bBCR-1.0", 2, 0.0, NAN),
        ("bISO-1.0", 1, 0.0, NAN),
        ("bBCR-1.0", 4, NAN, NAN),
        ("bBCR-1.0", 5, NAN, NAN),
        ("bBCR-1.0", 6, NAN, NAN),
        ("bBCR-1.0", 7, NAN, NAN),
    ] {
        let file = binary(version, [3, 1], [1.0; 3], [0, number, 0], &numbers[usize::from(number)]);
        assert_heights(&read_bytes(&file).unwrap(), &[7.0, least, greatest]);
    }
}

#[test]
fn a_single_profile_needs_no_distance_across_it() {
    let scan = read_bytes(&binary("bISO-1.0", [6, 1], [1e-6, 0.0, 1e-12], [0, 5, 0], HEIGHTS)).unwrap();
    assert_eq!((scan.heights_m.dim(), scan.pitch_m), ((1, 6), Some((1e-6, 1e-6))));
    assert_no_warning(&scan);
}

#[test]
fn files_without_a_map_are_refused_with_the_reason_and_the_line() {
    // The counts are after 8 + 10 + 12 + 12 bytes, the scales after 4 more, the codes after 4 · 8 more.
    let with = |at, field: &dyn Fn(&[u8], usize) -> Vec<u8>| field(&usual(), at);
    let code = |at, code: u8| with(at, &|file, at| patched(file, at, code));
    let scale = |scale: f64| patched(&usual(), 62, scale);
    let counts = |counts: [u16; 2]| patched(&usual(), 42, counts);
    assert_refused([
        (code(78, 1), "SDF: Compression (byte 78) is `1`"),
        (code(80, 1), "SDF: CheckType (byte 80) is `1`"),
        (code(79, 8), "SDF: DataType (byte 79) is `8`"),
        (counts([0, 2]), "SDF: NumPoints (byte 42) is `0`; wanted 1 or more"),
        (scale(0.0), "SDF: Zscale (byte 62)"),
        (scale(-1e-9), "SDF: Zscale (byte 62)"),
        (scale(NAN), "SDF: Zscale (byte 62)"),
        (scale(f64::INFINITY), "SDF: Zscale (byte 62)"),
        (counts([3, 3]), "SDF: the heights (byte 81) stop after 12 bytes; wanted 18"),
        (binary("bISO-2.0", [1 << 16; 2], SCALE, [0, 5, 0], HEIGHTS), "the limit is"),
    ]);
    assert_refused(
        [
            ("NumPoints = 3", "NumPoints = three", "SDF: NumPoints (line 5) is `three`; wanted a whole number"),
            ("Zscale = 1.0E-6", "Zscale = 0", "SDF: Zscale (line 9) is `0`; wanted a positive number"),
            (
                "DataType = 7\r\n",
                "",
                "SDF: DataType is missing (line 13); wanted a line `key = value` before the first `*`",
            ),
            ("BAD", "x7", "SDF: value 2 (line 16) is `x7`; wanted a number or BAD"),
            (" -0.5", "", "SDF: height 6 of 6 is missing (line 17)"),
        ]
        .map(|(from, to, words)| (TEXT.replace(from, to), words)),
    );
}

#[test]
fn the_written_form_follows_the_standard() {
    let scan = Scan::new(array![[1e-6, NAN, -0.0], [0.1 + 0.2, -3e-300, NAN]], Some((1.276_565_098e-7, 3.1e-6)));
    let bytes = write_sdf(&scan).unwrap();
    let start = bytes!["bISO-1.0asperity  000000000000000000000000", [3_u16, 2], [1.276_565_098e-7, 3.1e-6, 1.0, -1.0]];
    assert_eq!(bytes, bytes![start, [0_u8, 7, 0], [1e-6, NAN, -0.0, 0.1 + 0.2, -3e-300, NAN]]);
    // Dates of a file that was read are kept.
    let again = read_bytes(&write_sdf(&read_bytes(&usual()).unwrap()).unwrap()).unwrap();
    assert_metadata(&again, &[("CreateDate", "301120161430"), ("ModDate", "011220161430"), ("ManufacID", "asperity")]);
    // Maps beyond the counts of version 1 become version 2.
    let long = Scan::new(ndarray::Array2::from_shape_fn((2, 70_000), |(y, x)| (x + y) as f64), Some((1e-6, 1e-6)));
    let bytes = write_sdf(&long).unwrap();
    assert!(bytes.starts_with(b"bISO-2.0"));
    assert_eq!(bits(&read_bytes(&bytes).unwrap()), bits(&long));
}
