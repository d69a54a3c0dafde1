//! Finished folders, and errors of writing and reading them.

use std::error;
use std::fs;
use std::io;
use std::path::{Path, PathBuf};

use asperity_formats::{refusal, remove_abandoned_files, replace_file};
use asperity_results::SCHEMA_VERSION;
use thiserror::Error;

use crate::manifest::{self, MANIFEST, Manifest};

/// Name of the file that is written last.
pub(crate) const COMPLETE: &str = "COMPLETE";

/// Error of writing or reading a folder.
#[derive(Debug, Error)]
#[non_exhaustive]
pub enum StoreError {
    /// The operating system refused to read or write a file.
    #[error("{}: {}", path.display(), refusal(source))]
    Io {
        /// File or folder.
        path: PathBuf,
        /// Error of the operating system.
        source: io::Error,
    },
    /// The destination is not empty, and replacement was not requested.
    #[error(
        "{} is not empty; choose another folder, or add --force to replace a folder that asperity wrote",
        path.display()
    )]
    NotEmpty {
        /// The destination.
        path: PathBuf,
    },
    /// The destination is no folder.
    #[error("{} is {found}; give a folder", path.display())]
    NoFolder {
        /// The destination.
        path: PathBuf,
        /// Description of the destination.
        found: &'static str,
    },
    /// The destination has no name of its own, for example `.` or `..`.
    #[error("{} does not name a folder; write its name, for example out/run1", path.display())]
    Unnamed {
        /// The destination.
        path: PathBuf,
    },
    /// The destination contains an input file.
    #[error("{} contains the input {}; replacing the folder would delete it; choose another folder", path.display(), input.display())]
    HoldsInput {
        /// The destination.
        path: PathBuf,
        /// The input file.
        input: PathBuf,
    },
    /// The destination has no manifest.
    #[error(
        "{} has no {MANIFEST}, so asperity did not write it, or an earlier version did; it is not replaced; \
         choose another folder, or delete it yourself",
        path.display()
    )]
    NoManifest {
        /// The destination.
        path: PathBuf,
    },
    /// The destination contains files that asperity did not write, or that have changed since.
    #[error("{} is not replaced: asperity did not write {}; move it away, or choose another folder", path.display(), first_names(foreign))]
    Foreign {
        /// The destination.
        path: PathBuf,
        /// The files, relative to the destination.
        foreign: Vec<String>,
    },
    /// Files of the finished folder are missing or have changed.
    #[error(
        "{} is not as asperity wrote it: {}; choose another folder, or delete it yourself",
        path.display(),
        first_names(changed)
    )]
    Changed {
        /// The folder.
        path: PathBuf,
        /// The files, relative to the folder.
        changed: Vec<String>,
    },
    /// The finished folder could not be moved to its destination.
    #[error("{}; this result is in {}", not_moved(path, source), kept.display())]
    NotMoved {
        /// The destination.
        path: PathBuf,
        /// Reason. If the destination is not empty, it was written in the meantime.
        source: io::Error,
        /// Folder that contains the result instead.
        kept: PathBuf,
    },
    /// The folder contains no finished run.
    #[error("{} is not a finished run: {missing} is missing", path.display())]
    NotARun {
        /// The folder.
        path: PathBuf,
        /// Name of the missing file.
        missing: &'static str,
    },
    /// An input cannot be read.
    #[error("{}: {source}", path.display())]
    Input {
        /// The file.
        path: PathBuf,
        /// Reason.
        source: io::Error,
    },
    /// A file of the run cannot be read.
    #[error("{}: {reason}", path.display())]
    Corrupt {
        /// The file.
        path: PathBuf,
        /// Reason.
        reason: String,
    },
    /// The content of a file could not be made from the results.
    #[error(transparent)]
    Content(Box<dyn error::Error + Send + Sync>),
    /// The results have another schema version.
    #[error(
        "{}: {}, but this program reads version {SCHEMA_VERSION}; run {again}",
        path.display(),
        found.as_ref().map_or_else(|| "the results state no schema_version".to_owned(), |found| format!("the results have schema_version {found}")),
    )]
    SchemaVersion {
        /// The file.
        path: PathBuf,
        /// Version found, if there is one, as in the file.
        found: Option<String>,
        /// What to run again, with its command.
        again: String,
    },
    /// A value could not be written as JSON.
    #[error("cannot be written as JSON: {0}")]
    Json(#[from] serde_json::Error),
}

impl StoreError {
    /// Returns the error of making the content of a file.
    pub fn content(error: impl error::Error + Send + Sync + 'static) -> Self {
        Self::Content(Box::new(error))
    }
}

pub(crate) fn at(path: &Path) -> impl FnOnce(io::Error) -> StoreError + '_ {
    move |source| StoreError::Io { path: path.into(), source }
}

/// Describes why a finished folder could not be moved to its destination.
fn not_moved(path: &Path, source: &io::Error) -> String {
    match source.kind() {
        io::ErrorKind::DirectoryNotEmpty | io::ErrorKind::AlreadyExists | io::ErrorKind::NotADirectory => {
            format!("{} is not replaced: it was written in the meantime", path.display())
        }
        _ => format!("cannot write {}: {}", path.display(), refusal(source)),
    }
}

/// Returns the first three names of a list, and the number of the others.
fn first_names(names: &[String]) -> String {
    const SHOWN: usize = 3;
    let first = names.iter().take(SHOWN).map(String::as_str).collect::<Vec<_>>().join(", ");
    match names.len().saturating_sub(SHOWN) {
        0 => first,
        more => format!("{first} and {more} more"),
    }
}

/// Returns whether asperity finished a folder.
pub fn is_finished(dir: &Path) -> bool {
    dir.join(COMPLETE).is_file()
}

/// Fails if `dir` is no folder that asperity finished, with this file.
///
/// # Errors
/// [`StoreError::NotARun`], or the folder may not be read.
pub fn require_finished(dir: &Path, file: &'static str) -> Result<(), StoreError> {
    for missing in [COMPLETE, file] {
        match fs::metadata(dir.join(missing)) {
            Ok(metadata) if metadata.is_file() => (),
            Err(source) if source.kind() == io::ErrorKind::PermissionDenied => {
                return Err(StoreError::Io { path: dir.into(), source });
            }
            _ => return Err(StoreError::NotARun { path: dir.into(), missing }),
        }
    }
    Ok(())
}

/// Fails if files of a finished folder are missing or have changed since asperity wrote them.
///
/// # Errors
/// [`StoreError::Changed`], or a file cannot be read.
pub fn require_unchanged(dir: &Path) -> Result<(), StoreError> {
    let changed = match Manifest::read(dir).map_err(at(dir))? {
        Some(manifest) => manifest.changed(dir).map_err(at(dir))?,
        None => vec![format!("{MANIFEST} (missing)")],
    };
    if changed.is_empty() { Ok(()) } else { Err(StoreError::Changed { path: dir.into(), changed }) }
}

/// Returns the SHA-256 of a file as lower-case hexadecimal digits.
///
/// # Errors
/// The file cannot be read.
pub fn file_hash(file: &Path) -> Result<String, StoreError> {
    manifest::hash(file).map_err(|source| StoreError::Input { path: file.into(), source })
}

/// Replaces files of a finished folder, each atomically, and updates the manifest.
///
/// # Errors
/// The operating system refused; each file is then either replaced or unchanged.
pub fn replace_files(dir: &Path, files: &[(String, Vec<u8>)]) -> Result<(), StoreError> {
    let write = |path: &Path, bytes: &[u8]| {
        let folder = path.parent().unwrap_or(dir);
        fs::create_dir_all(folder).map_err(at(folder))?;
        remove_abandoned_files(folder);
        replace_file(path, |file| io::Write::write_all(file, bytes)).map_err(at(path))
    };
    for (relative, bytes) in files {
        write(&dir.join(relative), bytes)?;
    }
    // A folder of an earlier version has no manifest. A new one would have to list all files as written by
    // asperity.
    if let Some(mut manifest) = Manifest::read(dir).map_err(at(dir))? {
        manifest.update(dir, files.iter().map(|(relative, _)| relative.as_str())).map_err(at(dir))?;
        write(&dir.join(MANIFEST), manifest.text().as_bytes())?;
    }
    Ok(())
}

/// Returns indented JSON with a final newline.
///
/// # Errors
/// The value cannot be written as JSON.
pub fn json_bytes(value: &impl serde::Serialize) -> Result<Vec<u8>, StoreError> {
    let mut bytes = serde_json::to_vec_pretty(value)?;
    bytes.push(b'\n');
    Ok(bytes)
}
