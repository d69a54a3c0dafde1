//! Digital Surf SUR and PRO, the format of the Mountains programs and of many instruments: a sequence of objects,
//! each with a header of 512 bytes, a comment, a private zone, and its heights as integers.
//!
//! A stored integer n is the height n·s + o with the z spacing s and the z offset o, both in the unit of the z steps.
//! If the header declares missing points, n = z_min − 2 marks them. The first line is at the top. The spacing of an
//! axis is the distance between its points. Texts are Latin-1, padded with spaces or zeros.
//!
//! Heights are stored plain (signature `DIGITAL SURF`) or in zlib streams (`DSCOMPRESSED`): the number of streams,
//! for each its unpacked and packed size, all of 32 bits, and the streams. Numbers are little-endian. A format field
//! of 257 declares big-endian numbers (Macintosh II), which are read as such if the header is then valid.
//!
//! The header names two units per axis, one for the step and one for lengths, and the ratio between them. Only the
//! unit of the step defines the scale here; a ratio that contradicts the units gives a warning.
//!
//! Some readers measure heights from z_min instead of from zero, which only moves the datum.

mod header;
mod object;
mod read;
mod write;

use crate::{Description, Format, Tested};
use header::is_object;
pub use write::write_sur;

pub(crate) const CODEC: Description = Description {
    extensions: &["sur", "pro"],
    vendor: "Digital Surf",
    known_by: "`DIGITAL SURF`, `DSCOMPRESSED`",
    reads: "int16, int32, plain or compressed, in either byte order; series and multilayer surfaces; single profiles",
    writes: "int32",
    missing_points: "z minimum − 2",
    orientation: "the first stored line is the top one, row 0",
    write: Some(write_sur),
    tested: Tested::InstrumentFiles,
    ..Description::new(Format::Sur, is_object, read::read)
};
