//! TIFF with one number per point: grey images. Every page is a map.
//!
//! Floating-point numbers are heights in metre. Integers are counts without a unit; they count as metre, with a
//! warning. If ImageJ's description states a unit of the values (`vunit`), that unit applies, with the straight line
//! of the calibration (`cf=0`, `c0`, `c1`). PhotometricInterpretation has no effect on the numbers: it only defines
//! whether zero is shown black or white.
//!
//! The distance between points comes from the first of: OME-XML (`PhysicalSizeX`, `PhysicalSizeXUnit`), ImageJ's
//! description (`unit`) with XResolution as points per unit, XResolution with ResolutionUnit inch or centimetre.
//!
//! Layout: TIFF 6.0, <https://www.itu.int/itudoc/itu-t/com16/tiff-fx/docs/tiff6.pdf>, and the BigTIFF of libtiff.

mod decode;
mod description;
mod directory;
mod jpk;
mod lext;
mod park;
mod read;
mod tag;

use description::Units;
use directory::{Directory, File, Tag};

use crate::{Description, Format, Tested};

pub(crate) const CODEC: Description = Description {
    extensions: &["tif", "tiff", "jpk", "lext"],
    vendor: "Adobe; JPK, Park Systems, Olympus",
    known_by: "`II*`, `MM*`, BigTIFF",
    reads: "grey pages of float32, float64 and integers of 8, 16 and 32 bits; strips and tiles; uncompressed, LZW, \
            Deflate, PackBits; no colours; heights of JPK, Park Systems and LEXT",
    missing_points: "NaN, ±inf, the value of GDAL_NODATA",
    orientation: "the first stored line is row 0, or as the Orientation tag says; of JPK and Park Systems the last one",
    tested: Tested::OtherPrograms,
    ..Description::new(Format::Tiff, directory::detect, read::read)
};
