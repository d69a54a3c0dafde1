use asperity_formats::{FormatError, Scan, write_sdf};
use ndarray::array;

use crate::fixture::{Fixture, read_bytes};
use crate::{NAN, assert_heights, bits};

/// Variable parts of a binary file.
struct Binary {
    version: &'static [u8; 8],
    size: (u32, u32),
    scale: [f64; 3],
    codes: [u8; 3],
    data: Vec<u8>,
    trailer: &'static [u8],
}

impl Default for Binary {
    fn default() -> Self {
        let heights: [i16; 6] = [0, 100, -200, 300, i16::MIN, i16::MAX];
        Self {
            version: b"bISO-1.0",
            size: (3, 2),
            scale: [5e-5, 2.5e-5, 1e-9],
            // Compression, data type (signed 16 bit), check type.
            codes: [0, 5, 0],
            data: heights.iter().flat_map(|z| z.to_le_bytes()).collect(),
            trailer: b"",
        }
    }
}

impl Binary {
    /// The fields one after the other, in the order and with the widths of ISO 25178-71, table 2.
    fn bytes(&self) -> Vec<u8> {
        let mut bytes = self.version.to_vec();
        // Manufacturer, in 10 bytes; created and modified, DDMMYYYYHHMM.
        bytes.extend(b"Micro 7   ");
        bytes.extend(b"301120161430");
        bytes.extend(b"011220161430");
        for count in [self.size.0, self.size.1] {
            match self.version {
                b"bISO-2.0" => bytes.extend(count.to_le_bytes()),
                _ => bytes.extend((count as u16).to_le_bytes()),
            }
        }
        // Scales, and the unknown resolution of heights.
        for number in [self.scale[0], self.scale[1], self.scale[2], -1.0] {
            bytes.extend(number.to_le_bytes());
        }
        bytes.extend(self.codes);
        bytes.extend(&self.data);
        bytes.extend(self.trailer);
        bytes
    }

    fn read(&self) -> Scan {
        read_bytes(&self.bytes()).unwrap()
    }
}

/// Example of the standard, with other heights and a missing point.
const TEXT: &str = "aISO-1.0\r\nManufacID = ISOTC213\r\nCreateDate = 040120100853\r\nModDate = 050320101353\r\n\
    NumPoints = 3\r\nNumProfiles = 2\r\nXscale = 1.0E-6\r\nYscale = 2.0E-6\r\nZscale = 1.0E-6\r\n\
    Zresolution = 1.0E-9\r\nCompression = 0\r\nDataType = 7\r\nCheckType = 0\r\n*\r\n\
    1.00000 0.99874 0.99495\r\n0.98865 BAD -0.5\r\n*\r\n< OperatorName > Tom Jones < / OperatorName >\r\n\
    PartName = gear 7\r\nhob ground\r\n*\r\n";

pub(crate) fn fixtures() -> Vec<Fixture> {
    let binary = Binary::default();
    let floats = |number: u8, data| Binary { version: b"bBCR-1.0", codes: [0, number, 0], data, ..Binary::default() };
    let wide = Binary { version: b"bISO-2.0", trailer: b"PartName = gear 7\r\n", ..Binary::default() };
    vec![
        Fixture { needed: TEXT.find("-0.5").unwrap() + 2, ..Fixture::whole("SDF text", TEXT.into()) },
        Fixture::whole("SDF binary", binary.bytes()),
        Fixture { needed: wide.bytes().len() - wide.trailer.len(), ..Fixture::whole("SDF version 2", wide.bytes()) },
        Fixture::whole("SDF doubles", floats(7, (0..6).flat_map(|z| f64::from(z).to_le_bytes()).collect()).bytes()),
    ]
}

#[test]
fn heights_pitch_and_voids_of_a_binary_file() {
    let scan = Binary::default().read();
    assert_eq!(scan.heights_m.dim(), (2, 3));
    // The greatest number is a height in ISO files, the least is none.
    assert_heights(&scan, &[0.0, 1e-7, -2e-7, 3e-7, NAN, 32767e-9]);
    assert_eq!(scan.pitch_m, Some((5e-5, 2.5e-5)));
    assert_eq!(scan.warnings, [] as [String; 0]);
    for (field, text) in
        [("version", "bISO-1.0"), ("ManufacID", "Micro 7"), ("CreateDate", "301120161430"), ("ModDate", "011220161430")]
    {
        assert_eq!(scan.metadata[field], text);
    }
}

#[test]
fn heights_pitch_and_voids_of_a_text() {
    let scan = read_bytes(TEXT.as_bytes()).unwrap();
    assert_eq!(scan.heights_m.dim(), (2, 3));
    assert_heights(&scan, &[1e-6, 0.99874e-6, 0.99495e-6, 0.98865e-6, NAN, -0.5e-6]);
    assert_eq!(scan.pitch_m, Some((1e-6, 2e-6)));
    assert_eq!(scan.warnings, [] as [String; 0]);
    for (field, text) in [
        ("ManufacID", "ISOTC213"),
        ("Zresolution", "1.0E-9"),
        ("OperatorName", "Tom Jones"),
        ("PartName", "gear 7"),
        ("trailer", "hob ground"),
    ] {
        assert_eq!(scan.metadata[field], text);
    }
    assert!(!scan.metadata.contains_key("Xscale"));
}

#[test]
fn every_type_of_number_is_read_with_the_mark_of_its_dialect() {
    // The number 7 and the marks for missing points: least and greatest of the type.
    let integers = |number: u8| match number {
        0 => vec![7, u8::MIN, u8::MAX],
        1 => [7, u16::MIN, u16::MAX].iter().flat_map(|z| z.to_le_bytes()).collect(),
        2 => [7, u32::MIN, u32::MAX].iter().flat_map(|z| z.to_le_bytes()).collect(),
        3 => [7.0, f32::MIN, f32::MAX].iter().flat_map(|z| z.to_le_bytes()).collect(),
        4 => [7, i8::MIN, i8::MAX].iter().flat_map(|z| z.to_le_bytes()).collect(),
        5 => [7, i16::MIN, i16::MAX].iter().flat_map(|z| z.to_le_bytes()).collect(),
        6 => [7, i32::MIN, i32::MAX].iter().flat_map(|z| z.to_le_bytes()).collect(),
        _ => [7.0, f64::MIN, NAN].iter().flat_map(|z| z.to_le_bytes()).collect::<Vec<u8>>(),
    };
    for (version, number, least, greatest) in [
        (b"bISO-1.0", 4, NAN, 127.0),
        (b"bISO-1.0", 5, NAN, 32767.0),
        (b"bISO-1.0", 6, NAN, 2147483647.0),
        (b"bISO-1.0", 3, NAN, NAN),
        (b"bISO-1.0", 7, NAN, NAN),
        // Of unsigned types zero is a height.
        (b"bBCR-1.0", 0, 0.0, NAN),
        (b"bBCR-1.0", 1, 0.0, NAN),
        (b"bBCR-1.0", 2, 0.0, NAN),
        (b"bISO-1.0", 1, 0.0, NAN),
        (b"bBCR-1.0", 4, NAN, NAN),
        (b"bBCR-1.0", 5, NAN, NAN),
        (b"bBCR-1.0", 6, NAN, NAN),
        (b"bBCR-1.0", 7, NAN, NAN),
    ] {
        let file = Binary {
            version,
            size: (3, 1),
            scale: [1.0, 1.0, 1.0],
            codes: [0, number, 0],
            data: integers(number),
            trailer: b"",
        };
        assert_heights(&file.read(), &[7.0, least, greatest]);
    }
}

#[test]
fn version_2_has_wider_counts() {
    let file = Binary { version: b"bISO-2.0", trailer: b"PartName = gear 7\r\n", ..Binary::default() };
    let scan = file.read();
    assert_eq!(bits(&scan), bits(&Binary::default().read()));
    assert_eq!(scan.pitch_m, Some((5e-5, 2.5e-5)));
    assert_eq!(scan.metadata["PartName"], "gear 7");
}

#[test]
fn two_more_fields_of_a_header_are_skipped_and_a_trailer_of_their_length_is_not() {
    let plain = Binary::default();
    let extra = [&[5, 0, 0, 0, 1, 0, 0, 0][..], &plain.data].concat();
    let scan = Binary { data: extra, ..Binary::default() }.read();
    assert_eq!(bits(&scan), bits(&plain.read()));
    let scan = Binary { trailer: b"a = 1234", ..Binary::default() }.read();
    assert_eq!(bits(&scan), bits(&plain.read()));
    assert_eq!(scan.metadata["a"], "1234");
}

#[test]
fn texts_of_other_programs_are_read() {
    let wanted = bits(&read_bytes(TEXT.as_bytes()).unwrap());
    for (what, text) in [
        ("another version", TEXT.replace("aISO-1.0", "aNPL-V1.0")),
        ("keys in any case", TEXT.replace("ManufacID", "ManuFacID").replace("NumPoints", "NUMPOINTS")),
        ("line feeds", TEXT.replace("\r\n", "\n")),
        ("carriage returns", TEXT.replace("\r\n", "\r")),
        ("no equals signs", TEXT.replace(" = ", "   ")),
        ("comments", TEXT.replace("Xscale", "; a comment = 3\r\nXscale").replace("0.99495\r\n", "0.99495 ; first\r\n")),
        ("a height per line", TEXT.replace(' ', "\r\n").replace("\r\n=\r\n", " = ")),
        ("fields of no use", TEXT.replace("CheckType", "NumDataSet = 1\r\nNanPresent = 0\r\nCheckType")),
        ("NaN for BAD", TEXT.replace("BAD", "NaN")),
        ("no trailer", TEXT[..TEXT.find("< Op").unwrap()].into()),
        ("no end", TEXT[..TEXT.find("*\r\n< Op").unwrap()].into()),
    ] {
        let scan = read_bytes(text.as_bytes()).unwrap_or_else(|error| panic!("{what}: {error}"));
        assert_eq!(bits(&scan), wanted, "{what}");
        assert_eq!(scan.warnings, [] as [String; 0], "{what}");
    }
    // Integers in text bear the mark of their type too.
    let integers = TEXT.replace("DataType = 7", "DataType = 5").replace("BAD", "-32768");
    assert_eq!(read_bytes(integers.as_bytes()).unwrap().missing_points(), 1);
}

#[test]
fn more_numbers_than_points_give_a_warning() {
    let scan = read_bytes(TEXT.replace("NumProfiles = 2", "NumProfiles = 1").as_bytes()).unwrap();
    assert_eq!(scan.heights_m.dim(), (1, 3));
    assert!(matches!(scan.warnings.as_slice(), [one] if one.starts_with("3 numbers after")), "{:?}", scan.warnings);
}

#[test]
fn files_without_a_map_are_refused_with_the_reason() {
    let refused = |file: Binary| read_bytes(&file.bytes()).unwrap_err().to_string();
    let message = refused(Binary { size: (6, 1), scale: [1e-6, 0.0, 1e-6], ..Binary::default() });
    assert_eq!(message, "SDF: the file holds a single profile; wanted the profiles of a surface");
    // The codes are after 8 + 10 + 12 + 12 + 2 + 2 + 4 · 8 bytes.
    let message = refused(Binary { codes: [1, 5, 0], ..Binary::default() });
    assert!(message.starts_with("SDF: Compression (byte 78) is `1`"), "{message}");
    let message = refused(Binary { codes: [0, 5, 1], ..Binary::default() });
    assert!(message.starts_with("SDF: CheckType (byte 80) is `1`"), "{message}");
    let message = refused(Binary { codes: [0, 8, 0], ..Binary::default() });
    assert!(message.starts_with("SDF: DataType (byte 79) is `8`"), "{message}");
    let message = refused(Binary { size: (0, 2), ..Binary::default() });
    assert_eq!(message, "SDF: NumPoints (byte 42) is `0`; wanted 1 or more");
    for scale in [0.0, -1e-9, NAN, f64::INFINITY] {
        let message = refused(Binary { scale: [1e-6, 1e-6, scale], ..Binary::default() });
        assert!(message.starts_with("SDF: Zscale (byte 62)"), "{message}");
    }
    let message = refused(Binary { size: (3, 3), ..Binary::default() });
    assert_eq!(message, "SDF: the heights (byte 81) stop after 12 bytes; wanted 18");
    let message = refused(Binary { version: b"bISO-2.0", size: (1 << 16, 1 << 16), ..Binary::default() });
    assert!(message.contains("the limit is"), "{message}");
}

#[test]
fn errors_in_a_text_name_the_line() {
    let refused = |from: &str, to: &str| read_bytes(TEXT.replace(from, to).as_bytes()).unwrap_err().to_string();
    assert_eq!(
        refused("NumPoints = 3", "NumPoints = three"),
        "SDF: NumPoints (line 5) is `three`; wanted a whole number"
    );
    assert_eq!(refused("Zscale = 1.0E-6", "Zscale = 0"), "SDF: Zscale (line 9) is `0`; wanted a positive number");
    assert_eq!(
        refused("DataType = 7\r\n", ""),
        "SDF: DataType is missing (line 13); wanted a line `key = value` before the first `*`"
    );
    assert_eq!(refused("BAD", "x7"), "SDF: value 2 (line 16) is `x7`; wanted a number or BAD");
    let message = refused(" -0.5", "");
    assert!(message.starts_with("SDF: height 6 of 6 is missing (line 17)"), "{message}");
}

/// A map that fills every place for a mistake: pixels that are not square, voids, numbers of many sizes.
fn scan() -> Scan {
    Scan::new(array![[1e-6, NAN, -0.0], [0.1 + 0.2, -3e-300, f64::INFINITY]], Some((1.276_565_098e-7, 3.1e-6)))
}

#[test]
fn a_written_file_keeps_every_bit_of_heights_and_pitch() {
    let read = read_bytes(&write_sdf(&scan()).unwrap()).unwrap();
    let wanted = scan().heights_m.mapv(|z| if z.is_finite() { z } else { NAN });
    assert_eq!(bits(&read), bits(&Scan::new(wanted, None)));
    assert_eq!(read.pitch_m, scan().pitch_m);
    assert!(!read.warnings.iter().any(|warning| warning.contains("numbers")), "{:?}", read.warnings);
    assert_eq!(read.metadata["ManufacID"], "asperity");
}

#[test]
fn the_binary_form_follows_the_standard() {
    let bytes = write_sdf(&scan()).unwrap();
    assert_eq!(bytes.len(), 8 + 10 + 2 * 12 + 2 * 2 + 4 * 8 + 3 + 6 * 8);
    assert_eq!(bytes[..42], *b"bISO-1.0asperity  000000000000000000000000");
    assert_eq!(bytes[42..46], [3, 0, 2, 0]);
    assert_eq!(bytes[62..70], 1_f64.to_le_bytes());
    assert_eq!(bytes[78..81], [0, 7, 0]);
    assert_eq!(bytes[81..89], 1e-6_f64.to_le_bytes());
}

#[test]
fn dates_of_a_file_that_was_read_are_kept() {
    let read = Binary::default().read();
    let again = read_bytes(&write_sdf(&read).unwrap()).unwrap();
    assert_eq!(again.metadata["CreateDate"], "301120161430");
    assert_eq!(again.metadata["ModDate"], "011220161430");
}

#[test]
fn maps_beyond_the_counts_of_version_1_become_version_2() {
    let long = Scan::new(ndarray::Array2::from_shape_fn((2, 70_000), |(y, x)| (x + y) as f64), Some((1e-6, 1e-6)));
    let bytes = write_sdf(&long).unwrap();
    assert!(bytes.starts_with(b"bISO-2.0"));
    assert_eq!(bits(&read_bytes(&bytes).unwrap()), bits(&long));
}

#[test]
fn scans_that_the_format_cannot_store_are_refused() {
    let without = Scan { pitch_m: None, ..scan() };
    assert!(matches!(write_sdf(&without), Err(FormatError::NoPitch { .. })));
    for pitch_m in [(0.0, 1e-6), (1e-6, NAN)] {
        let wrong = Scan { pitch_m: Some(pitch_m), ..scan() };
        assert!(matches!(write_sdf(&wrong), Err(FormatError::NotStorable { .. })));
    }
    let empty = Scan::new(ndarray::Array2::zeros((0, 3)), Some((1e-6, 1e-6)));
    assert!(matches!(write_sdf(&empty), Err(FormatError::NotStorable { .. })));
}
