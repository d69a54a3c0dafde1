//! Names in an archive: files, elements of `main.xml` and number types.

use crate::Sample;

/// File of the archive that describes all others.
pub(super) const MAIN: &str = "main.xml";
/// File with the checksum of `main.xml`, unless `main.xml` names another.
pub(super) const CHECKSUM: &str = "md5checksum.hex";
/// File of the heights in written archives.
pub(super) const POINT_DATA: &str = "bindata/data.bin";

/// Returns the number type of a letter in `main.xml`. Both integers are signed.
pub(super) fn sample(letter: &str) -> Option<Sample> {
    match letter {
        "I" => Some(Sample::I16),
        "L" => Some(Sample::I32),
        "F" => Some(Sample::F32),
        "D" => Some(Sample::F64),
        _ => None,
    }
}
