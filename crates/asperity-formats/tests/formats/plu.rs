use asperity_formats::{Channel, Format, FormatError, ReadOptions};

use crate::fixture::{Fixture, read_bytes, read_bytes_with, read_channel, unsupported};
use crate::{NAN, assert_heights, assert_metadata};

/// The height of a lost point.
const LOST: f32 = 1_000_001.0;

/// Rows, columns, heights in µm, and the bytes of the colour images after them.
struct Layer {
    shape: (u32, u32),
    heights_um: Vec<f32>,
    colours: Vec<u8>,
}

/// Variable parts of a PLU file. The rest is as written by a DCM 3D.
struct Plu {
    date: &'static [u8],
    shape: (u32, u32),
    kind: u32,
    area: u32,
    layers: u8,
    version: u8,
    images: u8,
    data: Vec<Layer>,
}

impl Default for Plu {
    fn default() -> Self {
        Self {
            date: b"Fri Mar 10 16:35:59 2023",
            shape: (2, 3),
            kind: 3,
            area: 3,
            layers: 1,
            version: 251,
            images: 1,
            data: vec![Layer {
                shape: (2, 3),
                heights_um: vec![-1.5, 2.25, LOST, 0.0, 1_000_000.0, 1_000_002.0],
                colours: vec![7; 18],
            }],
        }
    }
}

impl Plu {
    /// The structures one after the other: date, comment, calibration of the axes, configuration of the measurement,
    /// layers.
    fn bytes(&self) -> Vec<u8> {
        let mut bytes = self.date.to_vec();
        bytes.resize(128, 0);
        // Seconds since 1970.
        bytes.extend(1_678_462_559_u32.to_le_bytes());
        bytes.extend(b"ground, \xb5 = 0.1");
        bytes.resize(388, 0);
        // yres, xres, N_tall.
        for count in [self.shape.0, self.shape.1, self.shape.1] {
            bytes.extend(count.to_le_bytes());
        }
        // dy_multip, mppx, mppy, x_0, y_0, mpp_tall, z_0.
        for length_um in [28.25_f32, 1.5, 0.25, -52.5, 6042.75, 1.5, 142.5] {
            bytes.extend(length_um.to_le_bytes());
        }
        assert_eq!(bytes.len(), 428);
        // Type, algorithm (gradient), method (one field), objective (DI 10x), area.
        for code in [self.kind, 1, 0, 14, self.area] {
            bytes.extend(code.to_le_bytes());
        }
        // xres_area, yres_area, xres, yres, na.
        for count in [3_u32, 2, 3, 2, 1] {
            bytes.extend(count.to_le_bytes());
        }
        // incr_z, range, n_planes, tpc_umbral_F.
        bytes.extend(0.0625_f64.to_le_bytes());
        bytes.extend(55.5_f32.to_le_bytes());
        bytes.extend(23_u32.to_le_bytes());
        bytes.extend(4_u32.to_le_bytes());
        // restore, num_layers, version, config_hardware, num_images, reserved, padding, factor_delmacio.
        bytes.extend([0, self.layers, self.version, 6, self.images, 0, 0, 0]);
        bytes.extend(1_u32.to_le_bytes());
        assert_eq!(bytes.len(), 500);
        for layer in &self.data {
            bytes.extend(layer.shape.0.to_le_bytes());
            bytes.extend(layer.shape.1.to_le_bytes());
            bytes.extend(layer.heights_um.iter().flat_map(|z| z.to_le_bytes()));
            // Lowest and highest, not computed.
            bytes.extend((-LOST).to_le_bytes());
            bytes.extend(LOST.to_le_bytes());
            bytes.extend(&layer.colours);
        }
        bytes
    }

    /// Two layers, the second of one row.
    fn of_two_layers() -> Self {
        let mut file = Self { layers: 2, ..Self::default() };
        file.data.push(Layer { shape: (1, 2), heights_um: vec![4.0, 5.0], colours: vec![9; 6] });
        file
    }
}

pub(crate) fn fixtures() -> Vec<Fixture> {
    // The heights end before the range and the image.
    let one = Plu::default().bytes();
    let two = Fixture { needed: 500 + 8 + 24, ..Fixture::whole("PLU of two layers", Plu::of_two_layers().bytes()) };
    vec![Fixture { needed: 500 + 8 + 24, ..Fixture::whole("PLU of a topography", one) }, two]
}

fn wanted_m() -> [f64; 6] {
    [-1.5e-6, 2.25e-6, NAN, 0.0, 1.0, 1.000002]
}

#[test]
fn heights_are_micrometres_behind_the_shape_and_lost_points_are_missing() {
    let scan = read_bytes(&Plu::default().bytes()).unwrap();
    assert_eq!(scan.heights_m.dim(), (2, 3));
    assert_heights(&scan, &wanted_m());
    assert_eq!(scan.heights_m[[1, 0]], 0.0);
    assert_eq!(scan.missing_points(), 1);
}

#[test]
fn sides_of_a_pixel_are_micrometres_along_x_and_y() {
    let scan = read_bytes(&Plu::default().bytes()).unwrap();
    assert_eq!(scan.pitch_m, Some((1.5e-6, 0.25e-6)));
}

#[test]
fn layers_follow_each_other_behind_range_and_images() {
    let bytes = Plu::of_two_layers().bytes();
    let scan = read_bytes(&bytes).unwrap();
    assert_heights(&scan, &wanted_m());
    assert_eq!((scan.channels, scan.channel), (vec!["layer 1".to_owned(), "layer 2".to_owned()], 0));
    for channel in [Channel::Number(2), Channel::Name("Layer 2".into())] {
        let scan = read_bytes_with(&bytes, &ReadOptions { channel: Some(channel), ..ReadOptions::default() }).unwrap();
        assert_eq!(scan.heights_m.dim(), (1, 2));
        assert_heights(&scan, &[4e-6, 5e-6]);
        assert!(scan.warnings.iter().any(|warning| warning.contains("the header states 3 × 2 points")));
    }
    let error = read_channel(&bytes, "3").unwrap_err();
    assert!(error.to_string().contains("`layer 1`, `layer 2`"), "{error}");
}

#[test]
fn a_layer_that_is_stated_and_not_there_gives_a_warning() {
    let scan = read_bytes(&Plu { layers: 2, ..Plu::default() }.bytes()).unwrap();
    assert_eq!(scan.channels.len(), 1);
    let gives_warning = |layers| {
        let scan = read_bytes(&Plu { layers, ..Plu::default() }.bytes()).unwrap();
        scan.warnings.iter().any(|warning| warning.starts_with("the header states"))
    };
    assert!(gives_warning(2) && gives_warning(255));
    assert!(!gives_warning(1) && !gives_warning(0));
}

#[test]
fn measurements_that_are_no_topography_are_refused_by_name() {
    let kinds = [
        (0, "an image"),
        (1, "a profile"),
        (2, "multiple profiles"),
        (4, "multiple profiles at coordinates"),
        (5, "the thickness at one point"),
        (6, "a custom application"),
        (7, "topographies at coordinates"),
        (8, "thicknesses at coordinates"),
    ];
    for (kind, name) in kinds {
        let found = unsupported(&Plu { kind, ..Plu::default() }.bytes());
        assert!(found.contains(name), "{kind}: {found}");
    }
}

#[test]
fn the_header_is_kept() {
    let scan = read_bytes(&Plu::default().bytes()).unwrap();
    let wanted = [
        ("date", "Fri Mar 10 16:35:59 2023"),
        ("user comment", "ground, µ = 0.1"),
        ("type", "a topography"),
        ("algorithm", "confocal gradient"),
        ("objective", "Nikon interferometric DI 10×"),
        ("config_hardware", "PLu neox"),
        ("version", "2012"),
        ("z_0", "142.5 µm"),
        ("incr_z", "0.0625 µm"),
        ("n_planes", "23"),
    ];
    assert_metadata(&scan, &wanted);
    // Measurements at coordinates have other fields where the planes are.
    let scan = read_bytes(&Plu { area: 6, ..Plu::default() }.bytes()).unwrap();
    assert_eq!(scan.metadata.get("n_planes"), None);
    assert_eq!(scan.metadata["area"], "coordinates");
}

#[test]
fn only_a_date_and_small_codes_make_the_format() {
    let is_plu = |file: Plu| Format::detect(&file.bytes()) == Some(Format::Plu);
    for version in [0, 250, 255] {
        assert!(is_plu(Plu { version, ..Plu::default() }), "{version}");
    }
    assert!(!is_plu(Plu { version: 7, ..Plu::default() }));
    assert!(!is_plu(Plu { kind: 9, ..Plu::default() }));
    assert!(!is_plu(Plu { date: b"10.03.2023 16:35:59", ..Plu::default() }));
    assert!(!is_plu(Plu { date: b"Fri Mar 10 16:35:59 2023x", ..Plu::default() }));
    let log = "Fri Mar 10 16:35:59 2023 1.0 2.0\n".repeat(30);
    assert_ne!(Format::detect(log.as_bytes()), Some(Format::Plu));
}

#[test]
fn shapes_that_exceed_the_file_are_errors() {
    let of_shape = |shape| {
        let mut file = Plu::default();
        file.data[0].shape = shape;
        read_bytes(&file.bytes()).unwrap_err()
    };
    assert!(matches!(of_shape((0, 3)), FormatError::Field { field, .. } if field == "the number of rows"));
    assert!(matches!(of_shape((u32::MAX, u32::MAX)), FormatError::TooLarge { .. }));
    let error = of_shape((1000, 1000)).to_string();
    // Six heights, two ends of the range, eighteen bytes of colours.
    assert_eq!(error, "PLU: the heights (byte 508) stop after 50 bytes; wanted 4000000");
}
