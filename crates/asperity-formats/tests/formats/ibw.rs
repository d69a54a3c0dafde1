use asperity_formats::Format;

use crate::check::{assert_refused, assert_scan, bytes, padded};
use crate::fixture::{Fixture, read_bytes};

/// A wave of 3 × 2 points per layer, with the labels of its layers.
struct Wave {
    big: bool,
    kind: i16,
    labels: Vec<&'static str>,
    data_unit: &'static str,
    dimension_unit: &'static str,
    numbers: Vec<u8>,
}

impl Wave {
    fn asylum() -> Self {
        let numbers = (0..6).chain([1, 2, 3, 4, 5, 6]).flat_map(|z| (z as f32 * 1e-9).to_le_bytes()).collect();
        Self {
            big: false,
            kind: 2,
            labels: vec!["PhaseTrace", "HeightTrace"],
            data_unit: "",
            dimension_unit: "m",
            numbers,
        }
    }

    fn plain() -> Self {
        let numbers = [1.0_f64, 2.0, 3.0, 4.0, 5.0, 6.0].map(f64::to_be_bytes).concat();
        Self { big: true, kind: 4, labels: vec![], data_unit: "nm", dimension_unit: "um", numbers }
    }

    fn bytes(&self) -> Vec<u8> {
        let mut bytes = vec![0; 384];
        let mut put = |at: usize, mut number: Vec<u8>| {
            if self.big {
                number.reverse();
            }
            bytes[at..at + number.len()].copy_from_slice(&number);
        };
        let note = "ScanRate: 1.1\rImagingMode: 0\r";
        let layers = self.labels.len() as i32;
        for (at, size) in [
            (4, 320 + self.numbers.len() as i32),
            (12, note.len() as i32),
            (44, if layers > 0 { 32 * (layers + 1) } else { 0 }),
            (132, 3),
            (136, 2),
            (140, layers),
        ] {
            put(at, bytes![size]);
        }
        for (at, number) in [(0, bytes![5_i16]), (80, bytes![self.kind]), (148, bytes![1e-6]), (156, bytes![2e-6])] {
            put(at, number);
        }
        for (at, text) in [(92, "wave"), (212, self.data_unit), (216, self.dimension_unit), (220, self.dimension_unit)]
        {
            bytes[at..at + text.len()].copy_from_slice(text.as_bytes());
        }
        let sum = bytes.chunks(2).fold(0_i16, |sum, pair| {
            let pair = [pair[0], pair[1]];
            sum.wrapping_add(if self.big { i16::from_be_bytes(pair) } else { i16::from_le_bytes(pair) })
        });
        let check = sum.wrapping_neg();
        bytes[2..4].copy_from_slice(&if self.big { check.to_be_bytes() } else { check.to_le_bytes() });
        bytes.extend(&self.numbers);
        bytes.extend(note.as_bytes());
        if !self.labels.is_empty() {
            for label in std::iter::once(&"").chain(&self.labels) {
                bytes.extend(padded(*label, 32));
            }
        }
        bytes
    }
}

pub(crate) fn fixtures() -> Vec<Fixture> {
    vec![Fixture::whole("IBW", Wave::asylum().bytes()), Fixture::whole("IBW of float64", Wave::plain().bytes())]
}

#[test]
fn layers_of_asylum_research_are_in_metre_by_their_labels_from_the_bottom_up() {
    let heights = [4.0_f32, 5.0, 6.0, 1.0, 2.0, 3.0].map(|n| f64::from(n * 1e-9));
    let scan = assert_scan(&Wave::asylum().bytes(), Format::Ibw, (2, 3), (1e-6, 2e-6), &heights);
    assert_eq!(scan.channels, ["HeightTrace"]);
    assert!(scan.warnings[0].contains("`PhaseTrace`"), "{:?}", scan.warnings);
    assert_eq!(scan.metadata["ScanRate"], "1.1");
}

#[test]
fn a_matrix_without_labels_has_the_unit_of_the_wave_in_either_byte_order() {
    let heights = [4e-9, 5e-9, 6e-9, 1e-9, 2e-9, 3e-9];
    assert_scan(&Wave::plain().bytes(), Format::Ibw, (2, 3), (1e-12, 2e-12), &heights);
    let scan = read_bytes(&Wave { dimension_unit: "s", ..Wave::plain() }.bytes()).unwrap();
    assert!(scan.pitch_m.is_none() && scan.warnings[0].contains("no pixel size"), "{:?}", scan.warnings);
}

#[test]
fn other_quantities_curves_and_damage_are_refused() {
    let labels = vec!["PhaseTrace", "UserIn0Trace"];
    assert_refused([
        (Wave { labels, ..Wave::asylum() }.bytes(), "no image of the file holds lengths"),
        (Wave { data_unit: "V", ..Wave::plain() }.bytes(), "`wave` (V)"),
        // Complex numbers.
        (Wave { kind: 3, ..Wave::plain() }.bytes(), "IBW: type ("),
    ]);
    // A wrong check sum is another format.
    let mut bytes = Wave::plain().bytes();
    bytes[2] ^= 1;
    assert_ne!(Format::detect(&bytes), Some(Format::Ibw));
}
