//! Description of a format, with the functions that read and write it.

use crate::{Format, ReadOptions, Result, Scan};

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

/// Function that returns the bytes of a file.
type Write = fn(&Scan) -> Result<Vec<u8>>;

/// Row of the table of formats, with the functions of the format.
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
    /// Returns whether bytes start like this format.
    pub(crate) detect: fn(&[u8]) -> bool,
    /// Reads one map.
    pub(crate) read: fn(&[u8], &ReadOptions) -> Result<Scan>,
    /// Returns the bytes of a file, for [`write`](crate::write()); `None` for formats that are only read.
    pub(crate) write: Option<Write>,
}

impl Description {
    /// Creates a row for a format that is only read, states the distance between points, has no mark of missing points, and is known
    /// from its specification.
    pub(crate) const fn new(
        format: Format,
        detect: fn(&[u8]) -> bool,
        read: fn(&[u8], &ReadOptions) -> Result<Scan>,
    ) -> Self {
        let [vendor, known_by, reads, writes, missing_points, orientation] = [""; 6];
        Self {
            format,
            extensions: &[],
            vendor,
            known_by,
            reads,
            writes,
            stores_pitch: true,
            missing_points,
            orientation,
            tested: Tested::Specification,
            detect,
            read,
            write: None,
        }
    }
}
