use asperity_formats::{Format, FormatError};

use crate::fixture::{Fixture, read_bytes, unsupported, wrong_field};
use crate::{NAN, assert_heights, assert_metadata};

/// Variable parts of an NMS file. The rest is as written by µsoft.
struct Nms {
    data_type: i32,
    dimension_type: i32,
    n_range: (i32, i32),
    f_range_um: (f64, f64),
    version: &'static [u8],
    header_size: i32,
    /// Columns and rows.
    size: (i32, i32),
    steps_nm: (f64, f64),
    heights: Vec<u16>,
    intensities: Vec<u8>,
}

impl Default for Nms {
    fn default() -> Self {
        Self {
            data_type: 2,
            dimension_type: 1,
            n_range: (0, 65535),
            f_range_um: (2.5, 6.0),
            version: b"OM_MS_2.0",
            header_size: 3468,
            size: (3, 2),
            steps_nm: (3125.0, 6250.0),
            heights: vec![0, 65535, 13107, 26214, 1, 65534],
            intensities: vec![],
        }
    }
}

impl Nms {
    /// A file whose last point but one was not seen.
    fn with_intensities() -> Self {
        Self { intensities: vec![169, 12, 255, 1, 0, 187], ..Self::default() }
    }

    fn bytes(&self) -> Vec<u8> {
        let mut bytes = Vec::new();
        for number in [self.data_type, self.dimension_type, self.n_range.0, self.n_range.1] {
            bytes.extend(number.to_le_bytes());
        }
        for height_um in [self.f_range_um.0, self.f_range_um.1] {
            bytes.extend(height_um.to_le_bytes());
        }
        // Texts: version (20 bytes), title (1024), date (20), note (256).
        bytes.extend(self.version);
        bytes.resize(52, 0);
        bytes.extend(b"Confocal Height Image");
        bytes.resize(1076, 0);
        bytes.extend(b"2022-02-09T13:25");
        bytes.resize(1096, 0);
        bytes.extend(b"R\xf6ntgen");
        bytes.resize(1352, 0);
        // Size of the header, three numbers of unknown meaning, columns, rows.
        for number in [self.header_size, 2, 0, 0, self.size.0, self.size.1] {
            bytes.extend(number.to_le_bytes());
        }
        // Steps along x and y, and three numbers that may be a position.
        for number in [self.steps_nm.0, self.steps_nm.1, 24965.75, 4394.5, 29679.75] {
            bytes.extend(number.to_le_bytes());
        }
        // Whether there are intensities.
        bytes.extend(i32::from(!self.intensities.is_empty()).to_le_bytes());
        bytes.resize(3468, 0);
        bytes.extend(self.heights.iter().flat_map(|n| n.to_le_bytes()));
        bytes.extend(&self.intensities);
        bytes
    }
}

pub(crate) fn fixtures() -> Vec<Fixture> {
    vec![
        Fixture::whole("NMS", Nms::default().bytes()),
        Fixture::whole("NMS with intensities", Nms::with_intensities().bytes()),
    ]
}

/// 65535 is 5 · 13107: the numbers are 0, 5, 1 and 2 fifths of the range, and a step from its ends.
fn wanted_m() -> [f64; 6] {
    let step = 3.5e-6 / 65535.0;
    [2.5e-6, 6e-6, 3.2e-6, 3.9e-6, 2.5e-6 + step, 6e-6 - step]
}

#[test]
fn the_stated_numbers_are_the_stated_heights_in_micrometres() {
    let scan = read_bytes(&Nms::default().bytes()).unwrap();
    assert_eq!(Format::detect(&Nms::default().bytes()), Some(Format::Nms));
    assert_eq!(scan.heights_m.dim(), (2, 3));
    assert_heights(&scan, &wanted_m());
    assert_eq!(scan.warnings, [] as [String; 0]);
}

#[test]
fn another_range_of_numbers_has_other_steps_and_no_heights_outside() {
    let file = Nms { n_range: (1, 65534), f_range_um: (-1.0, 2.0), ..Nms::default() };
    let scan = read_bytes(&file.bytes()).unwrap();
    let height_m = |n: f64| (-1.0 + (n - 1.0) * 3.0 / 65533.0) * 1e-6;
    assert_heights(&scan, &[NAN, NAN, height_m(13107.0), height_m(26214.0), -1e-6, 2e-6]);
    assert!(scan.warnings.iter().any(|warning| warning.starts_with("2 numbers are outside")), "{:?}", scan.warnings);
}

#[test]
fn steps_are_nanometres_along_x_and_y() {
    assert_eq!(read_bytes(&Nms::default().bytes()).unwrap().pitch_m, Some((3.125e-6, 6.25e-6)));
}

#[test]
fn a_point_without_intensity_is_missing() {
    let scan = read_bytes(&Nms::with_intensities().bytes()).unwrap();
    let mut wanted = wanted_m();
    wanted[4] = NAN;
    assert_heights(&scan, &wanted);
}

#[test]
fn the_texts_of_the_header_are_kept() {
    let scan = read_bytes(&Nms::default().bytes()).unwrap();
    let wanted = [
        ("version", "OM_MS_2.0"),
        ("title", "Confocal Height Image"),
        ("date", "2022-02-09T13:25"),
        ("note", "Röntgen"),
    ];
    assert_metadata(&scan, &wanted);
}

#[test]
fn unknown_versions_and_sizes_of_the_header_give_a_warning() {
    let scan = read_bytes(&Nms { version: b"OM_MS_3.0", ..Nms::default() }.bytes()).unwrap();
    assert!(scan.warnings.iter().any(|warning| warning.contains("OM_MS_3.0")), "{:?}", scan.warnings);
    let scan = read_bytes(&Nms { header_size: 4096, ..Nms::default() }.bytes()).unwrap();
    assert!(scan.warnings.iter().any(|warning| warning.contains("4096 bytes")), "{:?}", scan.warnings);
    assert_eq!(Format::detect(&Nms { version: b"OMMS_2.0", ..Nms::default() }.bytes()), None);
}

#[test]
fn profiles_and_other_numbers_are_refused_with_a_reason() {
    for (file, reason) in [
        (Nms { dimension_type: 0, ..Nms::default() }, "a profile"),
        (Nms { data_type: 5, ..Nms::default() }, "data type 5"),
    ] {
        let found = unsupported(&file.bytes());
        assert!(found.contains(reason), "{found}");
    }
}

#[test]
fn headers_that_exceed_the_file_are_errors() {
    for (file, field) in [
        (Nms { dimension_type: 2, ..Nms::default() }, "dimension type"),
        (Nms { n_range: (5, 5), ..Nms::default() }, "n_high"),
        (Nms { f_range_um: (f64::NAN, 1.0), ..Nms::default() }, "f_low"),
        (Nms { f_range_um: (1.0, f64::INFINITY), ..Nms::default() }, "f_high"),
        (Nms { size: (0, 2), ..Nms::default() }, "nx"),
        (Nms { size: (2, -1), ..Nms::default() }, "ny"),
    ] {
        assert_eq!(wrong_field(&file.bytes()), field);
    }
    let error = read_bytes(&Nms { size: (i32::MAX, i32::MAX), ..Nms::default() }.bytes()).unwrap_err();
    assert!(matches!(error, FormatError::TooLarge { .. }), "{error}");
    let error = read_bytes(&Nms { size: (100, 100), ..Nms::default() }.bytes()).unwrap_err().to_string();
    assert_eq!(error, "NMS: the heights (byte 3468) stop after 12 bytes; wanted 20000");
    let bytes = Nms::with_intensities().bytes();
    let error = read_bytes(&bytes[..bytes.len() - 1]).unwrap_err().to_string();
    assert_eq!(error, "NMS: the intensities (byte 3480) stop after 5 bytes; wanted 6");
    let error = read_bytes(&bytes[..3000]).unwrap_err().to_string();
    assert_eq!(error, "NMS: the bytes of the header (byte 0) stop after 3000 bytes; wanted 3468");
}
