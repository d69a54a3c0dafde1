//! Run folders: creation, and errors of reading and writing them.

use std::io;
use std::path::Path;

use asperity::study::{Staging, StoreError, is_finished};

use crate::failure::{Failure, Kind, chain};
use crate::output::write_failure;

/// Returns the error of a run folder that could not be read. A missing or unreadable file is unusable data.
pub(crate) fn load_failure(error: &StoreError) -> Failure {
    match error {
        StoreError::Io { path, source } => Failure::io(Kind::Data, path.display(), source),
        error => store_failure(error),
    }
}

/// Returns the error of a run folder: unusable data if it cannot be read, a runtime error if it cannot be written.
pub(crate) fn store_failure(error: &StoreError) -> Failure {
    match error {
        StoreError::NotEmpty { .. }
        | StoreError::NoFolder { .. }
        | StoreError::Unnamed { .. }
        | StoreError::HoldsInput { .. }
        | StoreError::NoManifest { .. }
        | StoreError::Foreign { .. } => Failure::usage(error),
        StoreError::NotARun { .. }
        | StoreError::Corrupt { .. }
        | StoreError::Changed { .. }
        | StoreError::SchemaVersion { .. } => Failure::new(Kind::Data, error.to_string()),
        StoreError::Input { path, source } if source.kind() == io::ErrorKind::NotFound => {
            Failure::new(Kind::Data, format!("{}: no such file or folder", path.display()))
        }
        StoreError::Input { path, source } => Failure::io(Kind::Data, path.display(), source),
        StoreError::Io { path, source } => write_failure(path, source),
        StoreError::NotMoved { source, .. } => {
            Failure::new(Failure::io(Kind::Runtime, "", source).kind(), error.to_string())
        }
        // A table, field or file that could not be made.
        _ => Failure::new(Kind::Runtime, chain(error)),
    }
}

/// Opens the output folder of a command; `argument` names the flag that chose it.
pub(crate) fn begin_folder(argument: &str, folder: &Path, force: bool, inputs: &[&Path]) -> Result<Staging, Failure> {
    begin_default_folder(argument, folder, force, inputs).map_err(|failure| match failure.kind() {
        Kind::Usage => Failure::usage(format_args!("{argument} {}", failure.message())),
        _ => failure,
    })
}

/// Opens the output folder of a command that the flag `argument` could have chosen, but did not.
pub(crate) fn begin_default_folder(
    argument: &str,
    folder: &Path,
    force: bool,
    inputs: &[&Path],
) -> Result<Staging, Failure> {
    Staging::open(folder, force, inputs).map_err(|error| {
        let is_misnamed = matches!(&error, StoreError::Io { source, .. }
            if matches!(source.kind(), io::ErrorKind::NotADirectory | io::ErrorKind::InvalidFilename));
        match store_failure(&error) {
            _ if matches!(error, StoreError::NotEmpty { .. }) => not_empty(argument, folder),
            failure if is_misnamed => Failure::usage(failure.message()),
            failure => failure,
        }
    })
}

/// Returns the error of a folder that is not empty, with both ways out.
fn not_empty(argument: &str, folder: &Path) -> Failure {
    let (content, replaced) = match is_finished(folder) {
        true => (": a run is already there", "it"),
        false => ("", "a folder that asperity wrote"),
    };
    Failure::usage(format_args!(
        "{} is not empty{content}; `--force` replaces {replaced}, `{argument} DIR` writes elsewhere",
        folder.display()
    ))
}
