//! Names in an archive: files, elements of `main.xml` and number types.

use crate::Sample;

/// File of the archive that describes all others.
pub(super) const MAIN: &str = "main.xml";
/// File with the checksum of `main.xml`, unless `main.xml` names another.
pub(super) const CHECKSUM: &str = "md5checksum.hex";
/// File of the heights in written archives.
pub(super) const POINT_DATA: &str = "bindata/data.bin";

/// Paths of elements below the root of `main.xml`, by local names.
pub(super) mod path {
    pub(in crate::x3p) const FEATURE_TYPE: &str = "Record1/FeatureType";
    pub(in crate::x3p) const AXES: &str = "Record1/Axes";
    /// Element outside the standard that some programs write.
    pub(in crate::x3p) const ORIGIN: &str = "Record1/Axes/Origin";
    pub(in crate::x3p) const MANUFACTURER: &str = "Record2/Instrument/Manufacturer";
    pub(in crate::x3p) const SIZE_X: &str = "Record3/MatrixDimension/SizeX";
    pub(in crate::x3p) const LIST_DIMENSION: &str = "Record3/ListDimension";
    pub(in crate::x3p) const SIZE_Y: &str = "Record3/MatrixDimension/SizeY";
    pub(in crate::x3p) const SIZE_Z: &str = "Record3/MatrixDimension/SizeZ";
    pub(in crate::x3p) const POINT_DATA: &str = "Record3/DataLink/PointDataLink";
    pub(in crate::x3p) const POINT_DATA_MD5: &str = "Record3/DataLink/MD5ChecksumPointData";
    pub(in crate::x3p) const VALID_POINTS: &str = "Record3/DataLink/ValidPointsLink";
    pub(in crate::x3p) const VALID_POINTS_MD5: &str = "Record3/DataLink/MD5ChecksumValidPoints";
    pub(in crate::x3p) const DATUM: &str = "Record3/DataList/Datum";
    pub(in crate::x3p) const CHECKSUM_FILE: &str = "Record4/ChecksumFile";
}

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
