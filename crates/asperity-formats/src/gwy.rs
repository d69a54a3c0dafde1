//! Gwyddion's native format: one tree of serialised objects, little-endian.
//!
//! An object consists of the name of its type, the size of its content, and its components. A component consists of a
//! name, a letter for its type, and a value. The root is a `GwyContainer`. Image N of the file is `/N/data`, a
//! `GwyDataField` with its rows from the top down; `/N/data/title`, `/N/mask` and `/N/meta` belong to it. Layout:
//! <https://gwyddion.net/documentation/user-guide-en/gwyfile-format.html>.
//!
//! `xreal` and `yreal` are the sizes of whole images, pixels · pitch. All numbers are in base units: Gwyddion writes
//! no prefixes and ignores prefixes of other programs. This reader applies them, with a warning. `A` is the ampere. A
//! file of another program without any unit counts as metre. A field without a unit in a file with lateral units is
//! not a height.
//!
//! Gwyddion has no missing points. It stores them as masked points, with an ordinary number under the mask, and the
//! user decides on the meaning of a mask. This reader takes masked points as missing, with a warning. Mask values are
//! 0 and 1; Gwyddion's functions differ for other values, of which this reader takes the nearer of the two.

mod object;
mod read;
mod write;

use crate::{Description, Format, Tested};
use object::{MAGIC, MAGIC_1};
pub use write::write_gwy;

pub(crate) const CODEC: Description = Description {
    extensions: &["gwy"],
    vendor: "Gwyddion",
    known_by: "`GWYP`, `GWYO`",
    reads: "images whose values are lengths, with mask and metadata; no files of Gwyddion 1 (GWYO), no volumes, \
            no point clouds",
    writes: "one image, with a mask for missing points",
    missing_points: "the mask of the image, NaN",
    orientation: "the first stored line is row 0",
    write: Some(write_gwy),
    tested: Tested::OtherPrograms,
    ..Description::new(Format::Gwy, detect, read::read)
};

fn detect(bytes: &[u8]) -> bool {
    bytes.starts_with(MAGIC) || bytes.starts_with(MAGIC_1)
}
