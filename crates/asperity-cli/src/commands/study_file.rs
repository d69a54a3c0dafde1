//! Study files, and errors of studies.

use std::fs;
use std::path::Path;

use asperity::study::{FailureKind, Study, StudyError, StudyFileError};

use crate::failure::{Failure, Kind};

/// Reads a study or specification file.
pub(super) fn read<T>(path: &Path, parse: impl FnOnce(&str, &str) -> Result<T, StudyFileError>) -> Result<T, Failure> {
    let bytes = fs::read(path).map_err(|e| match e.kind() {
        std::io::ErrorKind::NotFound => Failure::new(Kind::Data, format!("{}: no such file", path.display())),
        _ => Failure::io(Kind::Data, path.display(), &e),
    })?;
    let text = String::from_utf8(bytes)
        .map_err(|_| Failure::usage(format_args!("{}: not a text file; a study is a TOML file", path.display())))?;
    parse(&text, &path.display().to_string()).map_err(Failure::usage)
}

/// Reads a study, with another seed if one is given.
pub(super) fn study(path: &Path, seed: Option<u64>) -> Result<Study, Failure> {
    let study = read(path, Study::parse)?;
    Ok(match seed {
        Some(seed) => study.with_seed(seed),
        None => study,
    })
}

/// Returns the folder of a file; the paths in the file are relative to it.
pub(super) fn folder_of(path: &Path) -> &Path {
    match path.parent() {
        Some(folder) if !folder.as_os_str().is_empty() => folder,
        _ => Path::new("."),
    }
}

/// Converts an error of a study; `path` is its file.
pub(super) fn failure(path: &Path, error: &StudyError) -> Failure {
    let kind = match error.kind() {
        FailureKind::Configuration => Kind::Usage,
        FailureKind::Input => Kind::Data,
        FailureKind::NotConverged => Kind::NotConverged,
        FailureKind::Cancelled => return Failure::from(asperity::monitor::Cancelled),
        FailureKind::Runtime => Kind::Runtime,
    };
    // The error of a scan already names its file.
    match error {
        StudyError::Scan(_) | StudyError::Map { .. } => Failure::new(kind, error.to_string()),
        _ => Failure::new(kind, format!("{}: {error}", path.display())),
    }
}
