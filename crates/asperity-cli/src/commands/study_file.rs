//! Study files, and errors of studies.

use std::path::Path;

use asperity::monitor::Cancelled;
use asperity::study::{FailureKind, Study, StudyError, StudyFileError};
use asperity_formats::read_settings;

use crate::failure::{Failure, Kind};

/// Reads a study or specification file; returns also its text.
pub(super) fn read<T>(
    path: &Path,
    parse: impl FnOnce(&str, &str) -> Result<T, StudyFileError>,
) -> Result<(T, String), Failure> {
    let bytes = read_settings(path).map_err(|e| Failure::io(Kind::Data, path.display(), &e))?;
    let text = String::from_utf8(bytes)
        .map_err(|_| Failure::usage(format_args!("{}: not a text file; a study is a TOML file", path.display())))?;
    let parsed = parse(&text, &path.display().to_string())
        .map_err(|error| Failure::new(if error.in_data { Kind::Data } else { Kind::Usage }, error.to_string()))?;
    Ok((parsed, text))
}

/// Reads a study, with another seed if one is given; returns also its text.
pub(super) fn study(path: &Path, seed: Option<u64>) -> Result<(Study, String), Failure> {
    let (study, text) = read(path, Study::parse).map_err(|failure| match has_any(path, &["study"]) {
        true => Failure::usage(format_args!("{0} is a campaign: `asperity campaign {0}` computes it", path.display())),
        false => failure,
    })?;
    Ok((if let Some(seed) = seed { study.with_seed(seed) } else { study }, text))
}

/// Returns whether a TOML file has one of the keys, of which campaigns have `study` and studies have sections.
pub(super) fn has_any(path: &Path, keys: &[&str]) -> bool {
    let text = read_settings(path).ok().and_then(|bytes| String::from_utf8(bytes).ok());
    let table = text.and_then(|text| text.parse::<toml::Table>().ok());
    table.is_some_and(|table| keys.iter().any(|key| table.contains_key(*key)))
}

/// Converts an error of a study; `path` is its file. With `text`, the text of the file, the message names the line of the
/// value that caused the error.
pub(super) fn failure(path: &Path, text: Option<&str>, error: &StudyError) -> Failure {
    with_message(error, error.message_in(&path.display().to_string(), text))
}

/// Converts an error of a study with this message.
pub(super) fn with_message(error: &StudyError, message: String) -> Failure {
    match error.kind() {
        FailureKind::Cancelled => Cancelled.into(),
        kind => Failure::new(kind.into(), message),
    }
}
