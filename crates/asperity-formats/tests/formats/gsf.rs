use asperity_formats::Format;

use crate::assert_heights;
use crate::check::{assert_refused, assert_scan};
use crate::fixture::{Fixture, read_bytes};

/// A field of 3 × 2 points with these fields after its dimensions.
fn gsf(fields: &str, numbers: &[f32]) -> Vec<u8> {
    let mut bytes = format!("Gwyddion Simple Field 1.0\nXRes = 3\nYRes = 2\n{fields}").into_bytes();
    bytes.resize((bytes.len() / 4 + 1) * 4, 0);
    bytes.extend(numbers.iter().flat_map(|z| z.to_le_bytes()));
    bytes
}

const NUMBERS: [f32; 6] = [1.0, 2.0, f32::NAN, -4.0, 5.0, 6.0];
const FIELDS: &str = "XReal = 3\nYReal = 4\nXYUnits = um\nZUnits = nm\nTitle = a groove\n";

pub(crate) fn fixtures() -> Vec<Fixture> {
    vec![Fixture::whole("GSF", gsf(FIELDS, &NUMBERS))]
}

#[test]
fn heights_follow_the_header_at_a_multiple_of_four_bytes() {
    for title in ["", "a", "ab", "abc"] {
        let bytes = gsf(&format!("{FIELDS}Note = {title}\n"), &NUMBERS);
        let heights = [1e-9, 2e-9, f64::NAN, -4e-9, 5e-9, 6e-9];
        let scan = assert_scan(&bytes, Format::Gsf, (2, 3), (1e-6, 2e-6), &heights);
        assert_eq!(scan.metadata["Title"], "a groove");
    }
    let scan = read_bytes(&gsf("", &NUMBERS)).unwrap();
    assert_heights(&scan, &[1.0, 2.0, f64::NAN, -4.0, 5.0, 6.0]);
    assert_eq!((scan.pitch_m, scan.height_unit), (None, None));
    assert!(scan.warnings[0].contains("no pixel size"), "{:?}", scan.warnings);
}

#[test]
fn other_units_and_sizes_are_refused_or_left_out_with_a_warning() {
    let scan = read_bytes(&gsf("XReal = 3\nYReal = 4\nXYUnits = 1/m\n", &NUMBERS)).unwrap();
    assert!(scan.pitch_m.is_none() && scan.warnings[0].contains("`1/m`"), "{:?}", scan.warnings);
    assert_refused([
        (gsf("ZUnits = V\n", &NUMBERS), "`field` (V)"),
        (gsf(FIELDS, &NUMBERS[..5]), "stop after"),
        (b"Gwyddion Simple Field 1.0\nXRes = 3\n".to_vec(), "the end of the header"),
    ]);
}
