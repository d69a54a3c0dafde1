//! Assertions about scans and errors, and the bytes of fields.

use asperity_formats::{Format, FormatError, Scan};

use crate::assert_heights;
use crate::fixture::read_bytes;

/// Bytes of numbers, little-endian, of texts, and of lists of these.
pub(crate) trait Raw {
    fn put(&self, bytes: &mut Vec<u8>);
}

macro_rules! numbers {
    ($($number:ty)*) => {
        $(impl Raw for $number {
            fn put(&self, bytes: &mut Vec<u8>) {
                bytes.extend(self.to_le_bytes());
            }
        })*
    };
}
numbers!(u8 i8 u16 i16 u32 i32 u64 i64 f32 f64);

impl Raw for str {
    fn put(&self, bytes: &mut Vec<u8>) {
        bytes.extend(self.as_bytes());
    }
}

impl<T: Raw> Raw for [T] {
    fn put(&self, bytes: &mut Vec<u8>) {
        self.iter().for_each(|one| one.put(bytes));
    }
}

impl<T: Raw, const N: usize> Raw for [T; N] {
    fn put(&self, bytes: &mut Vec<u8>) {
        self.as_slice().put(bytes);
    }
}

impl<T: Raw> Raw for Vec<T> {
    fn put(&self, bytes: &mut Vec<u8>) {
        self.as_slice().put(bytes);
    }
}

impl<T: Raw + ?Sized> Raw for &T {
    fn put(&self, bytes: &mut Vec<u8>) {
        (**self).put(bytes);
    }
}

/// The bytes of fields that follow each other.
macro_rules! bytes {
    ($($field:expr),* $(,)?) => {{
        let mut bytes: Vec<u8> = Vec::new();
        $(crate::check::Raw::put(&$field, &mut bytes);)*
        bytes
    }};
}
pub(crate) use bytes;

/// A field with zeros up to a width.
pub(crate) fn padded(field: impl Raw, width: usize) -> Vec<u8> {
    let mut bytes = bytes![field];
    bytes.resize(width, 0);
    bytes
}

/// A file with other bytes at an offset.
pub(crate) fn patched(file: &[u8], offset: usize, field: impl Raw) -> Vec<u8> {
    let (mut file, field) = (file.to_vec(), bytes![field]);
    file[offset..offset + field.len()].copy_from_slice(&field);
    file
}

/// Asserts that an error has a message with these words.
#[track_caller]
pub(crate) fn assert_error<T: std::fmt::Debug>(result: Result<T, FormatError>, words: &str) {
    let message = result.unwrap_err().to_string();
    assert!(message.contains(words), "{message}, wanted {words}");
}

/// Asserts that files are refused, each with a message of these words.
#[track_caller]
pub(crate) fn assert_refused<B: AsRef<[u8]>, W: AsRef<str>>(cases: impl IntoIterator<Item = (B, W)>) {
    for (file, words) in cases {
        assert_error(read_bytes(file.as_ref()), words.as_ref());
    }
}

/// Asserts format, shape (rows, columns), pitch and heights of a file, and returns its scan.
#[track_caller]
pub(crate) fn assert_scan(
    file: &[u8],
    format: Format,
    shape: (usize, usize),
    pitch_m: impl Into<Option<(f64, f64)>>,
    heights_m: &[f64],
) -> Scan {
    let scan = read_bytes(file).unwrap_or_else(|error| panic!("{error}"));
    assert_eq!((scan.format, scan.heights_m.dim()), (Some(format), shape));
    assert_heights(&scan, heights_m);
    assert_pitch(&scan, pitch_m);
    scan
}

/// Asserts the pitch along x and y to the last place or two.
#[track_caller]
pub(crate) fn assert_pitch(scan: &Scan, pitch_m: impl Into<Option<(f64, f64)>>) {
    let wanted = pitch_m.into();
    let is_near = |found: f64, wanted: f64| (found / wanted - 1.0).abs() <= 2.0 * f64::EPSILON;
    let fits = match (scan.pitch_m, wanted) {
        (Some(found), Some(wanted)) => is_near(found.0, wanted.0) && is_near(found.1, wanted.1),
        (found, wanted) => found == wanted,
    };
    assert!(fits, "{:?}, wanted {wanted:?}", scan.pitch_m);
}

/// Returns whether a scan has a warning of these words.
pub(crate) fn warns(scan: &Scan, words: &str) -> bool {
    scan.warnings.iter().any(|warning| warning.contains(words))
}

/// Asserts that a scan has a warning of these words.
#[track_caller]
pub(crate) fn assert_warns(scan: &Scan, words: &str) {
    assert!(warns(scan, words), "{:?}, wanted {words}", scan.warnings);
}

/// Asserts that a scan has no warning.
#[track_caller]
pub(crate) fn assert_no_warning(scan: &Scan) {
    assert_eq!(scan.warnings, [] as [String; 0]);
}

/// Asserts that a scan has one warning, of these words.
#[track_caller]
pub(crate) fn assert_one_warning(scan: &Scan, words: &str) {
    assert!(matches!(scan.warnings.as_slice(), [one] if one.contains(words)), "{:?}, wanted {words}", scan.warnings);
}
