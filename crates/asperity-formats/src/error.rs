//! Errors of reading and writing files.

use std::fmt;
use std::io;
use std::path::{Path, PathBuf};

use thiserror::Error;

use crate::Format;
use crate::unit::is_micro;

/// Result of reading or writing a file.
pub(crate) type Result<T, E = FormatError> = std::result::Result<T, E>;

/// Maximum number of characters that a message quotes from a file.
const SHOWN_CHARS: usize = 60;
/// Maximum number of names that a message lists.
const LISTED_NAMES: usize = 24;

/// Place in a file.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum Location {
    /// Offset in bytes from the start of the file.
    Byte(u64),
    /// Line number in a text file, counted from 1.
    Line(usize),
    /// Offset in a file inside an archive.
    Entry {
        /// Name inside the archive.
        entry: String,
        /// Offset in bytes from its start.
        offset: u64,
    },
}

impl fmt::Display for Location {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Byte(offset) => write!(f, "byte {offset}"),
            Self::Line(line) => write!(f, "line {line}"),
            Self::Entry { entry, offset } => write!(f, "{entry}, byte {offset}"),
        }
    }
}

/// Error of reading or writing a file.
///
/// The message of an error is complete: it includes the message of an inner error, so no error has a source. Errors
/// of [`read`](crate::read) and [`write`](crate::write) name the path; errors of functions on bytes cannot.
#[derive(Debug, Error)]
#[non_exhaustive]
pub enum FormatError {
    /// The file to read, or the folder to write to, does not exist.
    #[error("{}: no such file or folder", path.display())]
    NotFound {
        /// Path of that file or folder.
        path: PathBuf,
    },
    /// The operating system refused the operation.
    #[error("{}: {}", path.display(), crate::replace::refusal(error))]
    Io {
        /// Path that was read or written.
        path: PathBuf,
        /// Error of the operating system.
        error: io::Error,
    },
    /// Error in the content of a file.
    #[error("{}: {error}", path.display())]
    File {
        /// Path that was read or written.
        path: PathBuf,
        /// Error in the content.
        error: Box<FormatError>,
    },
    /// The content matches no known format.
    #[error("{}; known formats are {}", unknown(*length, start), known)]
    Unrecognised {
        /// Size of the file in bytes.
        length: u64,
        /// First bytes of the content, escaped.
        start: String,
        /// Names of the formats that are read.
        known: String,
    },
    /// The content is in a known format that this crate does not read.
    #[error("this is {name}, which is not read; {advice}")]
    NotRead {
        /// Format with its article.
        name: &'static str,
        /// Advice to the user.
        advice: &'static str,
    },
    /// A text is not a unit of length.
    #[error("`{}` is not a unit of length; wanted m, mm, um, nm, pm, angstrom or in{}", shown(unit), meant(unit))]
    UnknownUnit {
        /// Text that was found.
        unit: String,
    },
    /// A valid file is of a kind that this crate does not read or write.
    #[error("{}: {found}; wanted {wanted}", format.name())]
    Unsupported {
        /// Format.
        format: Format,
        /// Content of the file.
        found: String,
        /// Supported content.
        wanted: &'static str,
    },
    /// The value of a field is invalid.
    #[error("{}: {field} ({at}) is `{found}`; wanted {wanted}", format.name())]
    Field {
        /// Format.
        format: Format,
        /// Name of the field in the terms of the format.
        field: String,
        /// Place of the field.
        at: Location,
        /// Value that was found.
        found: String,
        /// Valid values.
        wanted: String,
    },
    /// A required field is absent.
    #[error("{}: {field} is missing ({at}); wanted {wanted}", format.name())]
    MissingField {
        /// Format.
        format: Format,
        /// Name of the field in the terms of the format.
        field: String,
        /// Place where the field was expected.
        at: Location,
        /// Expected content.
        wanted: String,
    },
    /// Data end before the declared size.
    #[error("{}: {part} ({at}) stop after {found} bytes; wanted {wanted}", format.name())]
    Truncated {
        /// Format.
        format: Format,
        /// Part of the file that is too short.
        part: String,
        /// Start of the part.
        at: Location,
        /// Number of bytes present.
        found: u64,
        /// Number of bytes declared.
        wanted: u64,
    },
    /// A declared size exceeds the limit of this crate.
    #[error("{}: {field} ({at}) is {found}; the limit is {limit}", format.name())]
    TooLarge {
        /// Format.
        format: Format,
        /// Name of the field in the terms of the format.
        field: String,
        /// Place of the field.
        at: Location,
        /// Declared size.
        found: u64,
        /// Largest supported size.
        limit: u64,
    },
    /// The file holds no map with that number or name.
    #[error("{}: no height map {found}; the file holds {}", format.name(), listed(channels))]
    NoSuchChannel {
        /// Format.
        format: Format,
        /// Requested number or name.
        found: String,
        /// Names of all maps in the file.
        channels: Vec<String>,
    },
    /// The archive or the compressed stream around the data is damaged.
    #[error("{}: {entry}: {reason}", format.name())]
    Archive {
        /// Format.
        format: Format,
        /// File inside the archive, or `archive` for the archive as a whole.
        entry: String,
        /// Description of the damage.
        reason: String,
    },
    /// The XML description is damaged.
    #[error("{}: {at}: {reason}", format.name())]
    Xml {
        /// Format.
        format: Format,
        /// Place of the damage.
        at: Location,
        /// Description of the damage.
        reason: String,
    },
    /// The commas of all numbers may be decimal signs or separate thousands.
    #[error(
        "{}: `{}` ({at}) may be {} or {}, as all numbers of the file with a comma; state the decimal sign by `--decimal comma` or \
         `--decimal point`, in a study by `decimal`",
        format.name(), shown(found), shown(&found.replace(',', ".")), shown(&found.replace(',', ""))
    )]
    AmbiguousDecimal {
        /// Format.
        format: Format,
        /// Place of the first such number.
        at: Location,
        /// Number that was found.
        found: String,
    },
    /// The rows of a text matrix differ in length.
    #[error("text: line {line} has {found} values; the first row has {wanted}")]
    Ragged {
        /// Line number, counted from 1.
        line: usize,
        /// Number of values in this row.
        found: usize,
        /// Number of values in the first row.
        wanted: usize,
    },
    /// Neither the file nor the options state the unit of the heights, and in metre they exceed the field of view.
    #[error(
        "{}: the file states no unit of height; in metre the heights would {found}, more than the field of view, \
         {field_of_view}; state the unit by `--height-unit`, in a study by `height_unit`, such as `um` (`m` if they are in metre)",
        format.name()
    )]
    NoHeightUnit {
        /// Format.
        format: Format,
        /// Reach or span of the heights in metre.
        found: String,
        /// Longer side of the field of view.
        field_of_view: String,
    },
    /// The format needs the distance between points, and the scan has none.
    #[error("{}: the scan has no pixel size, and the format requires one", format.name())]
    NoPitch {
        /// Format.
        format: Format,
    },
    /// The format cannot store the scan.
    #[error("{}: {found} cannot be stored; wanted {wanted}", format.name())]
    NotStorable {
        /// Format.
        format: Format,
        /// Content of the scan.
        found: String,
        /// Content that can be stored.
        wanted: &'static str,
    },
    /// No format is written with this extension.
    #[error("{}; wanted {}", unwritten(extension), written)]
    UnknownExtension {
        /// Extension; empty if there is none.
        extension: String,
        /// Extensions that are written.
        written: String,
    },
}

impl FormatError {
    /// Returns the error without the path of the file.
    pub fn cause(&self) -> &Self {
        match self {
            Self::File { error, .. } => error.cause(),
            other => other,
        }
    }

    /// Returns whether the user can state the choice or the fact that the file leaves open.
    pub fn asks_for_option(&self) -> bool {
        let cause = self.cause();
        matches!(cause, Self::NoSuchChannel { .. } | Self::NoHeightUnit { .. } | Self::AmbiguousDecimal { .. })
    }

    /// Returns the error for a field whose value is invalid.
    pub(crate) fn field(
        format: Format,
        field: impl Into<String>,
        at: Location,
        found: impl ToString,
        wanted: impl Into<String>,
    ) -> Self {
        let found = shown(&found.to_string());
        Self::Field { format, field: field.into(), at, found, wanted: wanted.into() }
    }

    /// Returns the error for a field that is absent.
    pub(crate) fn missing(format: Format, field: impl Into<String>, at: Location, wanted: impl Into<String>) -> Self {
        Self::MissingField { format, field: field.into(), at, wanted: wanted.into() }
    }

    /// Returns the error for `part`, which starts at `at` and has `found` of `wanted` bytes.
    pub(crate) fn truncated(format: Format, part: impl Into<String>, at: Location, found: u64, wanted: u64) -> Self {
        Self::Truncated { format, part: part.into(), at, found, wanted }
    }

    /// Returns the error for a size above its limit.
    pub(crate) fn too_large(format: Format, field: impl Into<String>, at: Location, found: u64, limit: u64) -> Self {
        Self::TooLarge { format, field: field.into(), at, found, limit }
    }

    /// Returns the error for a valid file of a kind that is not read.
    pub(crate) fn unsupported(format: Format, found: impl Into<String>, wanted: &'static str) -> Self {
        Self::Unsupported { format, found: found.into(), wanted }
    }

    /// Returns the error for a scan that the format cannot store.
    pub(crate) fn not_storable(format: Format, found: impl Into<String>, wanted: &'static str) -> Self {
        Self::NotStorable { format, found: found.into(), wanted }
    }

    /// Adds the path of the file.
    pub(crate) fn in_file(self, path: &Path) -> Self {
        Self::File { path: path.into(), error: Box::new(self) }
    }

    /// Returns an error of the operating system with the path of the file.
    pub(crate) fn io(path: &Path, error: io::Error) -> Self {
        match error.kind() {
            io::ErrorKind::NotFound => Self::NotFound { path: path.into() },
            _ => Self::Io { path: path.into(), error },
        }
    }
}

/// Returns an error from the function if a condition holds.
macro_rules! refuse_if {
    ($condition:expr, $error:expr) => {
        if $condition {
            return Err($error);
        }
    };
}

/// Adds a warning, formatted like a message, if a condition holds.
macro_rules! warn_if {
    ($warnings:expr, $condition:expr, $($message:tt)+) => {
        if $condition {
            $warnings.push(format!($($message)+));
        }
    };
}
pub(crate) use {refuse_if, warn_if};

/// Returns the message of an error followed by the messages of its causes, without repetition.
pub fn chain(error: &dyn std::error::Error) -> String {
    let mut text = error.to_string();
    let mut cause = error.source();
    while let Some(inner) = cause {
        let more = inner.to_string();
        if !text.contains(&more) {
            text = format!("{text}: {more}");
        }
        cause = inner.source();
    }
    text
}

fn unknown(length: u64, start: &str) -> String {
    match length {
        0 => "the file is empty".into(),
        _ => format!("unknown format: {length} bytes that start with {start}"),
    }
}

/// Returns a question about a unit that is only a prefix.
fn meant(unit: &str) -> &'static str {
    if is_micro(unit) { "; did you mean `um`?" } else { "" }
}

fn unwritten(extension: &str) -> String {
    match extension {
        "" => "the name has no extension to choose the format".into(),
        _ => format!("no format is written as `.{}`", shown(extension)),
    }
}

/// Lists names for a message.
fn listed(names: &[String]) -> String {
    match names {
        [] => "none".into(),
        [one] => format!("just one, `{}`", shown(one)),
        several => first_of(several, LISTED_NAMES, |name| format!("`{name}`")),
    }
}

/// Lists the first `limit` names for a message, each as `quote` returns it, and counts the others.
pub(crate) fn first_of(names: &[String], limit: usize, quote: fn(String) -> String) -> String {
    let first = names.iter().take(limit).map(|name| quote(shown(name))).collect::<Vec<_>>().join(", ");
    let more = names.len().saturating_sub(limit);
    if more > 0 { format!("{first} and {more} more") } else { first }
}

/// Returns the start of a text from a file, short enough for a message.
pub(crate) fn shown(text: &str) -> String {
    cut(text, SHOWN_CHARS)
}

/// Cuts a text to `characters` characters. Control characters, which could control a terminal, are escaped.
pub(crate) fn cut(text: &str, characters: usize) -> String {
    let mut kept = String::new();
    for (place, c) in text.chars().enumerate() {
        if place == characters {
            kept.push('…');
            break;
        }
        if c.is_control() { kept.extend(c.escape_default()) } else { kept.push(c) }
    }
    kept
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn texts_from_files_are_short_and_do_not_control_a_terminal() {
        assert_eq!(shown("\u{1b}[2Jgap\n\u{9b}1A"), "\\u{1b}[2Jgap\\n\\u{9b}1A");
        assert_eq!(shown(&"é".repeat(61)), "é".repeat(60) + "…");
    }

    #[test]
    fn long_lists_of_names_are_cut() {
        let error = |count: usize| {
            let channels = (1..=count).map(|n| format!("layer {n}")).collect();
            FormatError::NoSuchChannel { format: Format::X3p, found: "number 0".into(), channels }.to_string()
        };
        assert_eq!(error(1), "X3P: no height map number 0; the file holds just one, `layer 1`");
        assert!(error(24).ends_with("`layer 23`, `layer 24`"));
        assert!(error(4096).ends_with("`layer 24` and 4072 more"));
    }
}
