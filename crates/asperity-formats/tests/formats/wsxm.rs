use asperity_formats::Format;

use crate::assert_heights;
use crate::check::{assert_refused, assert_scan, bytes};
use crate::fixture::{Fixture, read_bytes};

/// A file with the type of its numbers, the unit of its heights and the numbers of 3 × 2 points.
fn wsxm(kind: &str, amplitude: &str, numbers: &[u8]) -> Vec<u8> {
    let text = |size: usize| {
        format!(
            "WSxM file copyright UAM\r\nSxM Image file\r\nImage header size: {size}\r\n\r\n[Control]\r\n\r\n    X Amplitude: 3 nm\r\n    \
             Y Amplitude: 4 nm\r\n\r\n[General Info]\r\n\r\n    Acquisition channel: Topography\r\n    \
             Acquisition time: 18/06/2021, 14:12:26\r\n    Image Data Type: {kind}\r\n    Number of columns: 3\r\n    \
             Number of rows: 2\r\n    Z Amplitude: {amplitude}\r\n\r\n[Header end]\r\n"
        )
    };
    let size = text(100).len();
    bytes![text(size).as_str(), numbers]
}

fn short() -> Vec<u8> {
    wsxm("short", "6 nm", &bytes![[-300_i16, 0, 300, 100, 200, -100]])
}

fn double() -> Vec<u8> {
    wsxm("double", "6 nm", &bytes![[-3.0, 0.0, 3.0, 1.0, 2.0, -1.0]])
}

const WANTED: [f64; 6] = [-1e-9, 2e-9, 1e-9, 3e-9, 0.0, -3e-9];

pub(crate) fn fixtures() -> Vec<Fixture> {
    vec![Fixture::whole("WSxM", short()), Fixture::whole("WSxM of float64", double())]
}

#[test]
fn integers_span_the_amplitude_and_reals_are_in_its_unit_from_the_lower_right_on() {
    let float = wsxm("float", "6 nm", &bytes![[-3.0_f32, 0.0, 3.0, 1.0, 2.0, -1.0]]);
    for bytes in [short(), double(), float] {
        let scan = assert_scan(&bytes, Format::Wsxm, (2, 3), (1e-9, 2e-9), &WANTED);
        assert_eq!(scan.metadata["Acquisition time"], "18/06/2021, 14:12:26");
    }
    let flat = read_bytes(&wsxm("short", "0 nm", &[7; 12])).unwrap();
    assert_heights(&flat, &[0.0; 6]);
}

#[test]
fn other_quantities_types_and_kinds_are_refused() {
    assert_refused([
        (wsxm("double", "6 nA", &[0; 48]), "`Topography` (nA)"),
        (wsxm("long", "6 nm", &[0; 48]), "Image Data Type ("),
        (b"WSxM file copyright UAM\r\nIV File\r\n".to_vec(), "no image"),
    ]);
}
