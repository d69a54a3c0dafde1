//! Run folders: creation, and errors of reading and writing them.

use std::io;
use std::path::Path;

use asperity::study::{Staging, StoreError};

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
    Staging::open(folder, force, inputs).map_err(|error| {
        let is_misnamed = matches!(&error, StoreError::Io { source, .. }
            if matches!(source.kind(), io::ErrorKind::NotADirectory | io::ErrorKind::InvalidFilename));
        match store_failure(&error) {
            failure if is_misnamed || failure.kind() == Kind::Usage => {
                Failure::usage(format_args!("{argument} {}", failure.message()))
            }
            failure => failure,
        }
    })
}
