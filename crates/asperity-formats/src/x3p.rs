//! X3P, the open format of ISO 25178-72 (first published as ISO 5436-2): a zip archive of `main.xml`, which describes
//! the measurement, and binary files with the heights. Number types without NaN have a further file with one validity
//! bit per point.
//!
//! A stored number n on the z axis is the height n·increment + offset in metre. x varies fastest, then y, then the
//! layer. By the standard, lengths are in metre. The increment of an axis is the distance between its points. Schema
//! and sample files: <https://www.opengps.eu>.
//!
//! The schema defines the number types int16 (I), int32 (L), float32 (F) and float64 (D). The integers are signed:
//! the sample of openGPS that exists in binary and in text form holds −308 as an int16 of 0xFECC. Readers that take
//! them as unsigned agree only for numbers from 0 on.
//!
//! Row 0 of a scan is the first stored line. In the right-handed coordinates of ISO 25178-72 y grows from line to
//! line, so that the first line is at the bottom in a view from above; in ISO 5436-2 counting started at the top
//! left. Both revisions of the format call themselves `ISO5436 - 2000`, so a file does not reveal its revision.
//! Gwyddion and x3ptools show the first line at the top.

mod names;
mod read;
mod write;

use self::names::MAIN;
use crate::{Description, Format, Tested};
pub use write::write_x3p;

pub(crate) const CODEC: Description = Description {
    extensions: &["x3p"],
    vendor: "ISO 25178-72, ISO 5436-2 (openGPS)",
    known_by: "zip archive with `main.xml`",
    reads: "int16, int32, float32, float64, text lists in main.xml; layers; profiles (PRF) as a matrix; no point clouds (PCL)",
    writes: "float64",
    missing_points: "NaN, ±inf, cleared bits of valid.bin",
    orientation: "the first stored line is the top one, row 0: the format does not say; programs show it so",
    write: Some(write_x3p),
    tested: Tested::InstrumentFiles,
    ..Description::new(Format::X3p, detect, read::read)
};

/// First bytes of a zip archive.
pub(crate) const ZIP_MAGIC: &[u8] = b"PK\x03\x04";

/// Number of bytes at either end of an archive that are searched for the name of `main.xml`. The directory is at the
/// end, and an incomplete archive has headers at its start.
const SEARCHED_BYTES: usize = 1 << 18;
/// Signature of a header in the directory and of a header before a file, each with the offset of the name.
const NAME_OFFSETS: [(&[u8], usize); 2] = [(b"PK\x01\x02", 46), (b"PK\x03\x04", 30)];

/// Returns whether bytes are a zip archive with a file `main.xml`, in a folder or not.
fn detect(bytes: &[u8]) -> bool {
    let is_named_main = |part: &[u8], at: usize| {
        let is_in_folder = at > 0 && matches!(part[at - 1], b'/' | b'\\');
        let starts = |&(signature, offset): &(&[u8], usize)| {
            at.checked_sub(offset).is_some_and(|header| part[header..].starts_with(signature))
        };
        is_in_folder || NAME_OFFSETS.iter().any(starts)
    };
    let holds_main = |part: &[u8]| {
        let mut places = part.windows(MAIN.len()).enumerate().filter(|(_, window)| *window == MAIN.as_bytes());
        places.any(|(at, _)| is_named_main(part, at))
    };
    let (head, tail) = (bytes.len().min(SEARCHED_BYTES), bytes.len().saturating_sub(SEARCHED_BYTES));
    bytes.starts_with(ZIP_MAGIC) && (holds_main(&bytes[..head]) || holds_main(&bytes[tail..]))
}
