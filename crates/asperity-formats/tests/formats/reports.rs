//! Cases that users of other programs reported; docs/validation/reports.md lists them.

use asperity_formats::Format;

use crate::check::assert_pitch;
use crate::fixture::read_bytes;
use crate::{NAN, assert_heights};

#[test]
fn points_have_the_spacing_of_their_coordinates_in_any_order() {
    // SurfaceTopography #235 and #158: spacing 0.5, never a map of as many rows as points and three columns.
    let point = |place: usize| {
        let (row, column) = (place / 4, place % 4);
        format!("{} {} {}\n", 0.5 * (column + 1) as f64, 0.5 * (row + 1) as f64, place as f64 / 8.0)
    };
    // 5 and 16 are coprime, so multiples of 5 visit each point once.
    let heights: Vec<f64> = (0..16).map(|place| place as f64 / 8.0).collect();
    for order in [1, 5] {
        let text: String = (0..16).map(|n| point(n * order % 16)).collect();
        let scan = read_bytes(text.as_bytes()).unwrap();
        assert_eq!((scan.format, scan.heights_m.dim()), (Some(Format::Xyz), (4, 4)), "{text}");
        assert_pitch(&scan, (0.5, 0.5));
        assert_heights(&scan, &heights);
    }
}

#[test]
fn missing_points_of_a_list_are_voids_in_their_place() {
    // SurfaceTopography #126; asperity-cli tests that they stay there when levelled and converted.
    let points = (0..16).filter(|place| ![6, 12].contains(place));
    let text: String = points.map(|place| format!("{} {} {}\n", place % 4, place / 4, place as f64 / 8.0)).collect();
    let scan = read_bytes(text.as_bytes()).unwrap();
    let wanted: Vec<f64> =
        (0..16).map(|place| if [6, 12].contains(&place) { NAN } else { place as f64 / 8.0 }).collect();
    assert_heights(&scan, &wanted);
}

#[test]
fn every_spelling_of_a_unit_of_heights_is_understood() {
    // TopoStats #240, AFMReader #83.
    let numbers = [1.5, -2.0, 3.0, 4.25, 5.0, 6.0];
    for (unit, metre) in [
        ("\u{b5}m".as_bytes(), 1e-6),
        ("\u{3bc}m".as_bytes(), 1e-6),
        (b"\xb5m", 1e-6),
        (b"um", 1e-6),
        (b"pm", 1e-12),
        ("Å".as_bytes(), 1e-10),
    ] {
        for matrix in ["1.5 -2 3\n4.25 5 6\n", "1,5;-2;3\n4,25;5;6\n"] {
            let bytes = [b"# unit: ", unit, b"\n", matrix.as_bytes()].concat();
            let scan = read_bytes(&bytes).unwrap();
            assert_heights(&scan, &numbers.map(|number| number * metre));
        }
    }
}

#[test]
fn columns_of_a_file_are_x() {
    // surfalize 0.17: three points along x, two along y.
    let text = "# unit: um\n# dx: 1 um\n# dy: 2.5 um\n1 2 3\n4 5 6\n";
    let scan = read_bytes(text.as_bytes()).unwrap();
    assert_eq!(scan.heights_m.dim(), (2, 3));
    assert_pitch(&scan, (1e-6, 2.5e-6));
}
