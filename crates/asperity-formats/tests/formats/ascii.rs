//! Texts of Zygo, Wyko and Keyence.

use asperity_formats::{Format, FormatError};

use crate::NAN;
use crate::check::{assert_refused, assert_scan};
use crate::fixture::{Fixture, read_bytes};

/// A file of two intensities and 3 × 2 phases: λ = 632.8 nm, S = 0.5, O = 1, R by its code.
fn zygo(code: u8, lateral: &str, phases: &str) -> Vec<u8> {
    format!(
        "Zygo ASCII Data File - Format 2\n0 0 0 0 \"Tue Nov 24 00:00:00 2026\"\n0 0 2 1 1 255\n0 0 3 2\n\"a # comment\"\n\"serial\"\n\
         \"part\"\n0 0.5 6.328e-07 0 1 0 {lateral} 1795479270\n3 2 0 0 0 0 \"5x\"\n0 0 0 0 0 0 0 0 0 0\n{code} 1 20 2 0 0 0 0 0\n\
         0 \"\"\n1 0\n\"\"\n#\n17 18\n#\n{phases}#\n"
    )
    .into_bytes()
}

fn wyko(flag: u8, fields: &str, lines: &str) -> Vec<u8> {
    format!(
        "Wyko ASCII Data File Format 0\t{flag}\t1\r\nX Size\t4\r\nY Size\t3\r\nBlock Name\tType\tLength\tValue\r\n\
         Aspect\t7\t4\t1.5\r\nPixel_size\t7\t4\t0.002\r\nWavelength\t7\t4\t600\r\nTitle\t5\t20\ta disc\r\n{fields}\
         RAW_DATA\t3\t48\t\r\n{lines}"
    )
    .into_bytes()
}

const COLUMNS: &str = "1\t2\t3\r\n4\tBad\t6\r\n7\t8\t9\r\n10\t11\t12\r\n";

fn keyence() -> Vec<u8> {
    b"\"Model\",\"VK-X1000 Series\"\r\n\"Data type\n\",\"ImageDataCsv\"\r\n\"XY Calibration\",\"1394\",\"nm\"\r\n\
      \"Output image data\",\"Height\"\r\n\"Horizontal\",\"3\"\r\n\"Vertical\",\"2\"\r\n\"Unit\",\"um\"\r\n\r\n\"Height\"\r\n\
      \"1.5\",\"2.5\",\"3\"\r\n\"4\",\"\",\"1\"\r\n"
        .to_vec()
}

pub(crate) fn fixtures() -> Vec<Fixture> {
    vec![
        Fixture::open_ended("Zygo ASCII", zygo(1, "1e-6", "1 2 3\n4 2147483640 6\n")),
        Fixture::open_ended("Wyko ASCII", wyko(0, "", COLUMNS)),
        Fixture::open_ended("Keyence CSV", keyence()),
    ]
}

#[test]
fn phases_of_zygo_are_heights_by_the_formula_of_its_guide() {
    for (code, counts) in [(0, 4096.0), (1, 32768.0), (2, 131_072.0)] {
        let bytes = zygo(code, "1e-6", "1 2 3\n4 2147483640 -6\n");
        let heights = [1.0, 2.0, 3.0, 4.0, NAN, -6.0].map(|phase: f64| phase * 632.8e-9 * 0.5 / counts);
        let scan = assert_scan(&bytes, Format::ZygoAscii, (2, 3), (1e-6, 1e-6), &heights);
        assert_eq!(scan.metadata["comment"], "a # comment");
    }
    let scan = read_bytes(&zygo(1, "0", "1 2 3 4 5 6\n")).unwrap();
    assert!(scan.pitch_m.is_none() && scan.warnings[0].contains("unknown"), "{:?}", scan.warnings);
    for (code, lateral, phases, reason) in [
        (3, "1e-6", "1 2 3 4 5 6", "phase_res"),
        (1, "x", "1 2 3 4 5 6", "camera_res"),
        (1, "1e-6", "1 2 3 4 5", "number of phases"),
    ] {
        assert_refused([(zygo(code, lateral, phases), reason)]);
    }
}

#[test]
fn lines_of_wyko_are_columns_from_the_bottom_up_in_wavelengths_or_nanometre() {
    let wanted = [3.0, 6.0, 9.0, 12.0, 2.0, NAN, 8.0, 11.0, 1.0, 4.0, 7.0, 10.0];
    for (flag, unit) in [(0, 600e-9), (1, 1e-9)] {
        let (bytes, heights) = (wyko(flag, "", COLUMNS), wanted.map(|z| z * unit));
        let scan = assert_scan(&bytes, Format::WykoAscii, (3, 4), (2e-6, 3e-6), &heights);
        assert_eq!(scan.metadata["Title"], "a disc");
    }
    let scan = read_bytes(&wyko(0, "", &format!("{COLUMNS}Image\t3\t24\t\r\n1\t2\r\n"))).unwrap();
    assert_eq!(scan.heights_m.dim(), (3, 4));
    let error = read_bytes(&wyko(0, "Mult\t6\t2\t2\r\n", COLUMNS)).unwrap_err().to_string();
    assert!(error.contains("Mult"), "{error}");
    let error = read_bytes(&wyko(0, "", &COLUMNS[..20])).unwrap_err();
    assert!(matches!(error, FormatError::Ragged { .. } | FormatError::Field { .. }), "{error}");
}

#[test]
fn tables_of_keyence_have_keys_in_english_or_german() {
    let german = "Modell;VK\r\nDateityp;ImageDataCsv\r\nXY-Justierung;1,394;um\r\nBilddatenausg.;H\u{f6}he\r\nHorizont.;3\r\nVertikal;2\r\n\
                  Einheit;um\r\n\r\nH\u{f6}he\r\n1,5;2,5;3\r\n4;;1\r\n";
    let german: Vec<u8> = german.chars().map(|c| c as u8).collect();
    for bytes in [keyence(), german] {
        let heights = [1.5e-6, 2.5e-6, 3e-6, 4e-6, NAN, 1e-6];
        assert_scan(&bytes, Format::KeyenceCsv, (2, 3), (1.394e-6, 1.394e-6), &heights);
    }
    let changed = |from: &str, to: &str| String::from_utf8(keyence()).unwrap().replace(from, to).into_bytes();
    for (from, to, reason) in [
        ("\"Vertical\",\"2\"", "\"Vertical\",\"3\"", "number of lines"),
        ("\"Unit\",\"um\"", "\"Unit\",\"V\"", "Unit"),
        ("data\",\"Height\"", "data\",\"Laser\"", "Output image data"),
        ("Horizontal", "Width", "Horizontal"),
    ] {
        assert_refused([(changed(from, to), reason)]);
    }
}
