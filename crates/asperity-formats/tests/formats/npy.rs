use asperity_formats::{Format, FormatError};

use crate::assert_heights;
use crate::check::{assert_refused, patched};
use crate::fixture::{Fixture, read_bytes};
use crate::fixtures::npy;

fn header(descr: &str, column_major: &str, shape: &str) -> String {
    format!("{{'descr': '{descr}', 'fortran_order': {column_major}, 'shape': {shape}, }}   \n")
}

fn read(descr: &str, data: &[u8]) -> Vec<f64> {
    let bytes = npy(1, &header(descr, "False", "(1, 2)"), data);
    read_bytes(&bytes).unwrap_or_else(|error| panic!("{error}")).heights_m.into_iter().collect()
}

pub(crate) fn fixtures() -> Vec<Fixture> {
    let header = "{'descr': '<f8', 'fortran_order': True, 'shape': (2, 1), }  \n";
    vec![
        Fixture::whole("NPY version 1", npy(1, header, &[7; 16])),
        Fixture::whole("NPY version 2", npy(2, header, &[7; 16])),
    ]
}

#[test]
fn every_element_type_reads_in_both_byte_orders() {
    macro_rules! check {
        ($number:ty, $letter:literal, $values:expr) => {
            let values: [$number; 2] = $values;
            let wanted = values.map(|value| value as f64);
            let little: Vec<u8> = values.iter().flat_map(|value| value.to_le_bytes()).collect();
            let big: Vec<u8> = values.iter().flat_map(|value| value.to_be_bytes()).collect();
            assert_eq!(read(concat!("<", $letter), &little), wanted);
            assert_eq!(read(concat!(">", $letter), &big), wanted);
        };
    }
    check!(i8, "i1", [-128, 127]);
    check!(u8, "u1", [0, 255]);
    check!(i16, "i2", [-32768, 513]);
    check!(u16, "u2", [65535, 513]);
    check!(i32, "i4", [i32::MIN, 16909060]);
    check!(u32, "u4", [u32::MAX, 16909060]);
    check!(i64, "i8", [-(1 << 53), 72623859790382856]);
    check!(u64, "u8", [1 << 60, 5]);
    check!(f32, "f4", [-0.1, 1e30]);
    check!(f64, "f8", [-0.1, 1e300]);
    assert_eq!(read("|i1", &[0xff, 1]), [-1.0, 1.0]);
}

#[test]
fn rows_and_columns_follow_the_stated_order() {
    let data: Vec<u8> = (1..=6_i16).flat_map(i16::to_le_bytes).collect();
    let rows = read_bytes(&npy(1, &header("<i2", "False", "(2, 3)"), &data)).unwrap();
    assert_eq!(rows.heights_m, ndarray::array![[1., 2., 3.], [4., 5., 6.]]);
    let columns = read_bytes(&npy(1, &header("<i2", "True", "(2, 3)"), &data)).unwrap();
    assert_eq!(columns.heights_m, ndarray::array![[1., 3., 5.], [2., 4., 6.]]);
    assert!(columns.heights_m.is_standard_layout());
    assert_eq!(columns.pitch_m, None);
}

#[test]
fn all_header_versions_and_spellings_read() {
    let data = [1_f64, f64::NAN].map(f64::to_le_bytes).concat();
    let spellings = [
        header("<f8", "False", "(1, 2)"),
        "{\"shape\":(1,2),\"fortran_order\":False,\"descr\":\"<f8\"}".into(),
        "{'shape': (1, 2,), 'extra': [('a', '<f4'), {'b:,': 1}], 'fortran_order': False, 'descr': '<f8'}".into(),
    ];
    for version in 1..=3 {
        for spelling in &spellings {
            assert_heights(&read_bytes(&npy(version, spelling, &data)).unwrap(), &[1.0, f64::NAN]);
        }
    }
}

#[test]
fn arrays_other_than_matrices_of_numbers_are_refused() {
    for descr in ["<c16", "|b1", "<f2", "<U8", "|O", "|i2", "=f8", "", "<", "µ8"] {
        let error = read_bytes(&npy(1, &header(descr, "False", "(1, 2)"), &[0; 64])).unwrap_err();
        assert!(matches!(error, FormatError::Unsupported { format: Format::Npy, .. }), "{descr}: {error}");
    }
    for shape in ["(2,)", "()", "(1, 2, 3)", "(0, 2)", "(-1, 2)", "(1, 2", "1, 2", "(1.0, 2)"] {
        let error = read_bytes(&npy(1, &header("<f8", "False", shape), &[0; 64])).unwrap_err();
        assert!(matches!(error, FormatError::Field { format: Format::Npy, .. }), "{shape}: {error}");
    }
    assert!(matches!(read_bytes(&npy(1, &header("<f8", "1", "(1, 2)"), &[0; 16])), Err(FormatError::Field { .. })));
    assert!(matches!(
        read_bytes(&npy(4, &header("<f8", "False", "(1, 2)"), &[0; 16])),
        Err(FormatError::Unsupported { .. })
    ));
    assert!(matches!(
        read_bytes(&npy(1, "{'descr': '<f8', 'shape': (1, 2)}", &[0; 16])),
        Err(FormatError::MissingField { field, .. }) if field == "fortran_order"
    ));
}

#[test]
fn declared_sizes_are_not_believed() {
    let of = |shape| npy(1, &header("<f8", "False", shape), &[0; 16]);
    let small = npy(2, &header("<f8", "False", "(1, 2)"), &[0; 16]);
    assert_refused([
        (of("(9999999999, 9999999999)"), "the limit is"),
        (of("(16384, 16384)"), "stop after 16 bytes; wanted 2147483648"),
        (patched(&small, 8, u32::MAX), "is 4294967295; the limit is"),
        (patched(&small, 8, 0xffff_u32), "wanted 65535"),
    ]);
}

#[test]
fn bytes_after_the_array_are_a_warning() {
    let scan = read_bytes(&npy(1, &header("<f8", "False", "(1, 1)"), &[0; 11])).unwrap();
    assert!(matches!(scan.warnings.as_slice(), [one] if one.starts_with("3 bytes after")), "{:?}", scan.warnings);
}
