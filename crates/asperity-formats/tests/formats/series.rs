//! One-dimensional records in NPY files.

use std::fs;
use std::path::PathBuf;

use asperity_formats::{FormatError, read_series};
use tempfile::TempDir;

/// Version 1.0 of the format, spelled out: magic, version, length of the header, dictionary, numbers.
fn file(folder: &TempDir, shape: &str, numbers: &[f64]) -> PathBuf {
    let dictionary = format!("{{'descr': '<f8', 'fortran_order': False, 'shape': {shape}, }}");
    let mut bytes = b"\x93NUMPY\x01\x00".to_vec();
    bytes.extend(118_u16.to_le_bytes());
    bytes.extend(format!("{dictionary:<117}\n").as_bytes());
    bytes.extend(numbers.iter().flat_map(|x| x.to_le_bytes()));
    let path = folder.path().join("record.npy");
    fs::write(&path, bytes).unwrap();
    path
}

#[test]
fn a_record_is_read_bit_for_bit() {
    let folder = TempDir::new().unwrap();
    let numbers = [0.1, -0.0, 1e-300, 1.0 / 3.0];
    let read = read_series(&file(&folder, "(4,)", &numbers)).unwrap();
    assert_eq!(read.iter().map(|x| x.to_bits()).collect::<Vec<_>>(), numbers.map(f64::to_bits));
}

#[test]
fn maps_wrong_lengths_and_other_files_are_refused() {
    let folder = TempDir::new().unwrap();
    let numbers = [1.0, 2.0, 3.0, 4.0];
    for shape in ["(2, 2)", "(4, 1)", "()", "(3,)", "(5,)", "(-4,)", "(0,)", "(4.0,)", "(9223372036854775807,)"] {
        let error = read_series(&file(&folder, shape, &numbers)).unwrap_err();
        assert!(error.to_string().contains("record.npy"), "{shape}: {error}");
    }
    let text = folder.path().join("record.txt");
    fs::write(&text, "1 2 3\n").unwrap();
    assert!(read_series(&text).unwrap_err().to_string().contains("one-dimensional"));
    assert!(matches!(read_series(&folder.path().join("gone.npy")), Err(FormatError::NotFound { .. })));
    fs::write(&text, [0, 1, 2]).unwrap();
    assert!(matches!(read_series(&text), Err(FormatError::File { .. })));
}
