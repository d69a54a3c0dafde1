use asperity_formats::{Format, FormatError};

use crate::assert_heights;
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
        let order = |mut number: Vec<u8>| {
            if self.big {
                number.reverse();
            }
            number
        };
        let mut put = |at: usize, number: Vec<u8>| bytes[at..at + number.len()].copy_from_slice(&order(number));
        let note = "ScanRate: 1.1\rImagingMode: 0\r";
        put(0, 5_i16.to_le_bytes().to_vec());
        put(4, (320 + self.numbers.len() as i32).to_le_bytes().to_vec());
        put(12, (note.len() as i32).to_le_bytes().to_vec());
        if !self.labels.is_empty() {
            put(44, (32 * (self.labels.len() as i32 + 1)).to_le_bytes().to_vec());
        }
        put(80, self.kind.to_le_bytes().to_vec());
        for (at, size) in [(132, 3), (136, 2), (140, self.labels.len() as i32)] {
            put(at, size.to_le_bytes().to_vec());
        }
        put(148, 1e-6_f64.to_le_bytes().to_vec());
        put(156, 2e-6_f64.to_le_bytes().to_vec());
        for (at, unit) in [(212, self.data_unit), (216, self.dimension_unit), (220, self.dimension_unit)] {
            bytes[at..at + unit.len()].copy_from_slice(unit.as_bytes());
        }
        bytes[92..96].copy_from_slice(b"wave");
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
                let start = bytes.len();
                bytes.extend(label.as_bytes());
                bytes.resize(start + 32, 0);
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
    let scan = read_bytes(&Wave::asylum().bytes()).unwrap();
    assert_eq!((scan.format, scan.heights_m.dim(), scan.pitch_m), (Some(Format::Ibw), (2, 3), Some((1e-6, 2e-6))));
    let z = |n: f64| f64::from(n as f32 * 1e-9);
    assert_heights(&scan, &[z(4.0), z(5.0), z(6.0), z(1.0), z(2.0), z(3.0)]);
    assert_eq!(scan.channels, ["HeightTrace"]);
    assert!(scan.warnings[0].contains("`PhaseTrace`"), "{:?}", scan.warnings);
    assert_eq!(scan.metadata["ScanRate"], "1.1");
}

#[test]
fn a_matrix_without_labels_has_the_unit_of_the_wave_in_either_byte_order() {
    let scan = read_bytes(&Wave::plain().bytes()).unwrap();
    assert_heights(&scan, &[4e-9, 5e-9, 6e-9, 1e-9, 2e-9, 3e-9]);
    let pitch = scan.pitch_m.unwrap();
    assert!((pitch.0 / 1e-12 - 1.0).abs() < 1e-12 && (pitch.1 / 2e-12 - 1.0).abs() < 1e-12, "{pitch:?}");
    let scan = read_bytes(&Wave { dimension_unit: "s", ..Wave::plain() }.bytes()).unwrap();
    assert!(scan.pitch_m.is_none() && scan.warnings[0].contains("no pixel size"), "{:?}", scan.warnings);
}

#[test]
fn other_quantities_curves_and_damage_are_refused() {
    let refusal = |wave: Wave| read_bytes(&wave.bytes()).unwrap_err();
    let error = refusal(Wave { labels: vec!["PhaseTrace", "UserIn0Trace"], ..Wave::asylum() }).to_string();
    assert!(error.contains("no image of the file holds lengths"), "{error}");
    assert!(refusal(Wave { data_unit: "V", ..Wave::plain() }).to_string().contains("`wave` (V)"));
    // Complex numbers.
    let error = refusal(Wave { kind: 3, ..Wave::plain() });
    assert!(matches!(&error, FormatError::Field { field, .. } if field == "type"), "{error}");
    // A wrong check sum is another format.
    let mut bytes = Wave::plain().bytes();
    bytes[2] ^= 1;
    assert_ne!(Format::detect(&bytes), Some(Format::Ibw));
}
