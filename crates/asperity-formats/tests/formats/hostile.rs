//! No input makes the reader panic. Each test fails at the first panic; what the reader answers is free.

use asperity_formats::{Scan, X3pData, read_bytes, write_x3p};
use ndarray::array;

use crate::fixtures::{Sur, TEXT, X3p, npy};

/// Bytes of which every bit is flipped.
const FLIPPED_BYTES: usize = 1024;

fn fixtures() -> Vec<Vec<u8>> {
    let header = "{'descr': '<f8', 'fortran_order': True, 'shape': (2, 1), }  \n";
    let masked = X3p {
        z_axis: "<AxisType>A</AxisType><DataType>I</DataType><Increment>1e-9</Increment>",
        data: vec![1; 8],
        valid: Some(vec![0b1101]),
        folder: "a/",
        ..X3p::default()
    };
    vec![
        X3p::default().bytes(),
        masked.bytes(),
        write_x3p(&Scan::new(array![[1e-6, f64::NAN]], Some((1e-6, 1e-6))), X3pData::Int16).unwrap(),
        Sur::default().bytes(),
        npy(1, header, &[7; 16]),
        npy(2, header, &[7; 16]),
        TEXT.to_vec(),
    ]
}

/// Reads, and checks that what is read keeps the promises of a scan.
fn read(bytes: &[u8]) -> bool {
    let Ok(scan) = read_bytes(bytes) else { return false };
    assert!(scan.heights_m.iter().all(|z| !z.is_infinite()));
    assert!(!scan.heights_m.is_empty());
    assert!(scan.pitch_m.is_none_or(|(dx, dy)| dx > 0.0 && dy > 0.0 && dx.is_finite() && dy.is_finite()));
    true
}

#[test]
fn every_prefix_is_read_or_refused() {
    for bytes in fixtures() {
        assert!(read(&bytes));
        let is_text = bytes == TEXT;
        for end in 0..bytes.len() {
            // Rows of a text may be fewer; every other format says how long it is.
            assert!(!read(&bytes[..end]) || is_text, "prefix of {end} bytes");
        }
    }
}

#[test]
fn every_flipped_bit_is_read_or_refused() {
    for mut bytes in fixtures() {
        for position in 0..bytes.len().min(FLIPPED_BYTES) {
            for bit in 0..8 {
                bytes[position] ^= 1 << bit;
                read(&bytes);
                bytes[position] ^= 1 << bit;
            }
        }
    }
}

#[test]
fn flipped_bits_in_an_archive_directory_are_read_or_refused() {
    for mut bytes in fixtures().into_iter().take(3) {
        for position in bytes.len().saturating_sub(FLIPPED_BYTES)..bytes.len() {
            for bit in 0..8 {
                bytes[position] ^= 1 << bit;
                read(&bytes);
                bytes[position] ^= 1 << bit;
            }
        }
    }
}

#[test]
fn noise_in_any_place_is_read_or_refused() {
    // A multiplicative congruential generator (MMIX) is noise enough here.
    let mut state = 2016_u64;
    let mut next = move || {
        state = state.wrapping_mul(6364136223846793005).wrapping_add(1442695040888963407);
        (state >> 33) as usize
    };
    for fixture in fixtures() {
        for _ in 0..2000 {
            let mut bytes = fixture.clone();
            for _ in 0..1 + next() % 8 {
                let position = next() % bytes.len();
                bytes[position] = next() as u8;
            }
            read(&bytes);
        }
    }
}
