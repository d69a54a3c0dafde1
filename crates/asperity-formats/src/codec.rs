//! What is known of a format, and the functions that read and write it.

use crate::error::Result;
use crate::{Format, ReadOptions, Scan};

/// What the reader of a format was tried on.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Tested {
    /// Files that instruments or the vendors' programs wrote.
    InstrumentFiles,
    /// Files that another program wrote.
    OtherPrograms,
    /// Files assembled from the description of the format.
    Specification,
}

impl Tested {
    /// In words for the user.
    pub fn describe(self) -> &'static str {
        match self {
            Self::InstrumentFiles => "instrument files",
            Self::OtherPrograms => "files of other programs",
            Self::Specification => "files made from the specification",
        }
    }
}

/// What is known of a format: a row of the table of formats.
#[derive(Debug, Clone, Copy)]
pub struct Description {
    /// The format.
    pub format: Format,
    /// Usual extensions, without the dot.
    pub extensions: &'static [&'static str],
    /// Whose format it is.
    pub vendor: &'static str,
    /// How its content is known.
    pub known_by: &'static str,
    /// What is read; empty where the format is only written.
    pub reads: &'static str,
    /// What is written; empty where the format is only read.
    pub writes: &'static str,
    /// Whether files state the distance between points.
    pub stores_pitch: bool,
    /// How missing points are marked; empty where the format has no mark.
    pub missing_points: &'static str,
    /// Which way the rows of a file run, and why row 0 of a scan is at the top.
    pub orientation: &'static str,
    /// What the reader was tried on.
    pub tested: Tested,
}

/// Bytes of a file from a scan.
type Write = fn(&Scan) -> Result<Vec<u8>>;

/// A format with the functions behind it.
pub(crate) struct Codec {
    pub(crate) description: Description,
    /// Whether bytes look like this format.
    pub(crate) detect: fn(&[u8]) -> bool,
    /// Reads a map.
    pub(crate) read: fn(&[u8], &ReadOptions) -> Result<Scan>,
    /// Writes the form that [`write`](crate::write) uses, where the format is written.
    pub(crate) write: Option<Write>,
}
