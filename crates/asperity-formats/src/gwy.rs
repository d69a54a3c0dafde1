//! Gwyddion's native format: one tree of serialised objects, little-endian.
//!
//! An object is the name of its type, the size of its content, and its components; a component is a name, a letter for
//! its type, and a value. The root is a `GwyContainer`. Image N of the file is `/N/data`, a `GwyDataField` with its
//! rows from the top down; `/N/data/title`, `/N/mask` and `/N/meta` belong to it.
//! Layout: <https://gwyddion.net/documentation/user-guide-en/gwyfile-format.html>.
//!
//! `xreal` and `yreal` are the sizes of whole images, pixels · pitch. All numbers are in base units: Gwyddion writes no
//! prefixes and ignores those that other programs write. They are taken at their word here, with a warning. `A` is the
//! ampere. A file of other programs that states no unit at all, neither across nor upwards, is taken in metre; a field
//! without unit beside lateral ones in metre has none because it is no height.
//!
//! Gwyddion has no missing points. It keeps them as masked points, with an ordinary number under the mask, and leaves it
//! to the user what a mask means. Masked points are missing points here, which a warning tells. Mask values are 0 and 1
//! and Gwyddion's functions differ in what they make of others; the nearer of the two counts.

mod object;
mod read;
mod write;

use crate::Format;
use crate::codec::{Codec, Description, Tested};

pub use write::write_gwy;

pub(crate) const CODEC: Codec = Codec {
    description: Description {
        format: Format::Gwy,
        extensions: &["gwy"],
        vendor: "Gwyddion",
        known_by: "`GWYP`, `GWYO`",
        reads: "images whose values are lengths, with mask and metadata; no files of Gwyddion 1 (GWYO), no volumes, \
                no point clouds",
        writes: "one image, with a mask for missing points",
        stores_pitch: true,
        missing_points: "the mask of the image, NaN",
        orientation: "the first stored line is row 0",
        tested: Tested::OtherPrograms,
    },
    detect,
    read: read::read,
    write: Some(write_gwy),
};

/// First bytes of a file.
const MAGIC: &[u8] = b"GWYP";
/// First bytes of a file of Gwyddion 1.
const MAGIC_1: &[u8] = b"GWYO";
/// The type of the root and of metadata.
const CONTAINER: &str = "GwyContainer";
/// The type of an image or mask.
const DATA_FIELD: &str = "GwyDataField";
/// The type of a unit.
const UNIT: &str = "GwySIUnit";

fn detect(bytes: &[u8]) -> bool {
    bytes.starts_with(MAGIC) || bytes.starts_with(MAGIC_1)
}
