use asperity_formats::Format;

use crate::check::{assert_error, assert_pitch, assert_refused, assert_scan, bytes, padded, patched, warns};
use crate::fixture::{Fixture, read_bytes, read_channel};
use crate::{NAN, assert_heights, assert_metadata};

/// The height of a lost point.
const LOST: f32 = 1_000_001.0;

/// Rows, columns, heights in µm, the range, not computed, and the bytes of the colour image after it.
fn layer(shape: [u32; 2], heights_um: &[f32]) -> Vec<u8> {
    bytes![shape, heights_um, [-LOST, LOST], vec![7_u8; 3 * heights_um.len()]]
}

/// The structures of a DCM 3D one after the other: date, comment, calibration of the axes, configuration, layers.
fn plu(layers: &[Vec<u8>]) -> Vec<u8> {
    let date = bytes![padded("Fri Mar 10 16:35:59 2023", 128), 1_678_462_559_u32];
    let comment = padded(bytes![date, b"ground, \xb5 = 0.1"], 388);
    // yres, xres, N_tall; dy_multip, mppx, mppy, x_0, y_0, mpp_tall, z_0.
    let axes = bytes![comment, [2_u32, 3, 3], [28.25_f32, 1.5, 0.25, -52.5, 6042.75, 1.5, 142.5]];
    // Type, algorithm (gradient), method (one field), objective (DI 10x), area; xres_area, yres_area, xres, yres, na.
    let codes = bytes![axes, [3_u32, 1, 0, 14, 3], [3_u32, 2, 3, 2, 1]];
    // incr_z, range, n_planes, tpc_umbral_F; restore, num_layers, version, config_hardware, num_images, factor_delmacio.
    let counts = [0, layers.len() as u8, 251, 6, 1, 0, 0, 0];
    bytes![codes, 0.0625_f64, 55.5_f32, [23_u32, 4], counts, 1_u32, layers.concat()]
}

fn first_layer() -> Vec<u8> {
    layer([2, 3], &[-1.5, 2.25, LOST, 0.0, 1_000_000.0, 1_000_002.0])
}

fn usual() -> Vec<u8> {
    plu(&[first_layer()])
}

/// Two layers, the second of one row.
fn two_layers() -> Vec<u8> {
    plu(&[first_layer(), layer([1, 2], &[4.0, 5.0])])
}

pub(crate) fn fixtures() -> Vec<Fixture> {
    // The heights end before the range and the image.
    let [one, two] = [("PLU of a topography", usual()), ("PLU of two layers", two_layers())]
        .map(|(name, bytes)| Fixture { needed: 500 + 8 + 24, ..Fixture::whole(name, bytes) });
    vec![one, two]
}

const WANTED_M: [f64; 6] = [-1.5e-6, 2.25e-6, NAN, 0.0, 1.0, 1.000002];

#[test]
fn heights_and_sides_of_a_pixel_are_micrometres_and_lost_points_are_missing() {
    let scan = assert_scan(&usual(), Format::Plu, (2, 3), (1.5e-6, 0.25e-6), &WANTED_M);
    assert_eq!(scan.heights_m[[1, 0]], 0.0);
    assert_metadata(&scan, &[("date", "Fri Mar 10 16:35:59 2023"), ("user comment", "ground, µ = 0.1")]);
    assert_metadata(&scan, &[("type", "a topography"), ("algorithm", "confocal gradient"), ("version", "2012")]);
    assert_metadata(&scan, &[("objective", "Nikon interferometric DI 10×"), ("config_hardware", "PLu neox")]);
    assert_metadata(&scan, &[("z_0", "142.5 µm"), ("incr_z", "0.0625 µm"), ("n_planes", "23")]);
    // Measurements at coordinates have other fields where the planes are.
    let scan = read_bytes(&patched(&usual(), 444, 6_u32)).unwrap();
    assert_eq!(scan.metadata.get("n_planes"), None);
    assert_eq!(scan.metadata["area"], "coordinates");
}

#[test]
fn layers_follow_each_other_behind_range_and_images() {
    let bytes = two_layers();
    let scan = assert_scan(&bytes, Format::Plu, (2, 3), (1.5e-6, 0.25e-6), &WANTED_M);
    assert_eq!((scan.channels, scan.channel), (vec!["layer 1".to_owned(), "layer 2".to_owned()], 0));
    for channel in ["2", "Layer 2"] {
        let scan = read_channel(&bytes, channel).unwrap();
        assert_eq!(scan.heights_m.dim(), (1, 2));
        assert_heights(&scan, &[4e-6, 5e-6]);
        assert!(warns(&scan, "the header states 3 × 2 points"));
    }
    assert_error(read_channel(&bytes, "3"), "`layer 1`, `layer 2`");
    // Layers that are stated and not there.
    for (stated, is_reported) in [(0_u8, false), (1, false), (2, true), (255, true)] {
        let scan = read_bytes(&patched(&usual(), 489, stated)).unwrap();
        assert_eq!((scan.channels.len(), warns(&scan, "the header states")), (1, is_reported));
        assert_pitch(&scan, (1.5e-6, 0.25e-6));
    }
}

#[test]
fn only_a_date_and_small_codes_make_the_format() {
    let is_plu = |bytes: &[u8]| Format::detect(bytes) == Some(Format::Plu);
    for version in [0_u8, 250, 255] {
        assert!(is_plu(&patched(&usual(), 490, version)), "{version}");
    }
    assert!(!is_plu(&patched(&usual(), 490, 7_u8)) && !is_plu(&patched(&usual(), 428, 9_u32)));
    assert!(!is_plu(&patched(&usual(), 0, padded("10.03.2023 16:35:59", 24))) && !is_plu(&patched(&usual(), 24, "x")));
    assert!(!is_plu("Fri Mar 10 16:35:59 2023 1.0 2.0\n".repeat(30).as_bytes()));
}

#[test]
fn other_measurements_and_shapes_that_exceed_the_file_are_refused() {
    let of_type = |code: u32| patched(&usual(), 428, code);
    let of_shape = |shape: [u32; 2]| patched(&usual(), 500, shape);
    assert_refused([
        (of_type(0), "an image"),
        (of_type(1), "a profile"),
        (of_type(2), "multiple profiles"),
        (of_type(4), "multiple profiles at coordinates"),
        (of_type(5), "the thickness at one point"),
        (of_type(6), "a custom application"),
        (of_type(7), "topographies at coordinates"),
        (of_type(8), "thicknesses at coordinates"),
        (of_shape([0, 3]), "the number of rows ("),
        (of_shape([u32::MAX; 2]), "the limit is"),
        // Six heights, two ends of the range, eighteen bytes of colours.
        (of_shape([1000; 2]), "PLU: the heights (byte 508) stop after 50 bytes; wanted 4000000"),
    ]);
}
