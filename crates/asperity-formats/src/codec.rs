//! Description of a format, and the functions that read and write it.

use crate::error::Result;
use crate::{Format, ReadOptions, Scan};

/// Source of the files that the reader of a format was tested on.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Tested {
    /// Files written by instruments or by the vendors' programs.
    InstrumentFiles,
    /// Files written by other programs.
    OtherPrograms,
    /// Files assembled from the specification.
    Specification,
}

impl Tested {
    /// Returns a description for the user.
    pub fn describe(self) -> &'static str {
        match self {
            Self::InstrumentFiles => "instrument files",
            Self::OtherPrograms => "files of other programs",
            Self::Specification => "files made from the specification",
        }
    }
}

/// Row of the table of formats.
#[derive(Debug, Clone, Copy)]
pub struct Description {
    /// Format.
    pub format: Format,
    /// Usual extensions, without the dot.
    pub extensions: &'static [&'static str],
    /// Owner of the format.
    pub vendor: &'static str,
    /// Signature by which the content is recognised.
    pub known_by: &'static str,
    /// Supported content; empty for formats that are only written.
    pub reads: &'static str,
    /// Form of written files; empty for formats that are only read.
    pub writes: &'static str,
    /// Whether files state the distance between points.
    pub stores_pitch: bool,
    /// Marks of missing points; empty for formats without marks.
    pub missing_points: &'static str,
    /// Direction of the rows in a file, and the reason why row 0 of a scan is the top row.
    pub orientation: &'static str,
    /// Source of the files that the reader was tested on.
    pub tested: Tested,
}

/// Function that returns the bytes of a file.
type Write = fn(&Scan) -> Result<Vec<u8>>;

/// Format and its functions.
pub(crate) struct Codec {
    pub(crate) description: Description,
    /// Returns whether bytes start like this format.
    pub(crate) detect: fn(&[u8]) -> bool,
    /// Reads one map.
    pub(crate) read: fn(&[u8], &ReadOptions) -> Result<Scan>,
    /// Writes the form that [`write`](crate::write) uses; `None` for formats that are only read.
    pub(crate) write: Option<Write>,
}
