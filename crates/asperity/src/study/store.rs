//! Folders that asperity writes, and finished runs that it reads.
//!
//! [`Staging`] writes a folder beside its destination and then moves it there in one step, so that a destination is
//! either complete or unchanged. Each folder has a manifest of the files that asperity wrote ([`manifest`]). A folder
//! is replaced only if it contains nothing else.

mod manifest;
mod staging;

use std::collections::BTreeMap;
use std::fs;
use std::io;
use std::path::{Path, PathBuf};

use asperity_formats::{FormatError, refusal, remove_abandoned_files, replace_file};
use serde::de::DeserializeOwned;
use thiserror::Error;

use crate::friction::process::ProcessError;
use crate::study::result::{Field, Provenance, Results, SCHEMA_VERSION, Table, TableError};
use crate::study::run_machine::RunMachine;

use manifest::{MANIFEST, Manifest};
pub use staging::Staging;

/// Name of the file that is written last.
const COMPLETE: &str = "COMPLETE";
/// Name of the file with the friction process of the friction stage.
pub(super) const FRICTION_PROCESS: &str = "friction_process.json";
/// Name of the file with the machine of the run.
pub(super) const MACHINE: &str = "machine.json";
/// Name of the file with the study of the run.
pub(super) const STUDY: &str = "study.toml";
/// Name of the file with the campaign of a folder.
pub(super) const CAMPAIGN: &str = "campaign.toml";
/// Name of the file with the results of a run or a campaign.
pub(super) const RESULTS: &str = "results.json";
/// Name of the file with the provenance of a run or a campaign.
pub(super) const PROVENANCE: &str = "provenance.json";
/// Name of the file with the grids and units of the fields.
pub(super) const FIELD_INDEX: &str = "fields/index.json";

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
    /// A table could not be written.
    #[error(transparent)]
    Table(#[from] TableError),
    /// A field could not be written.
    #[error(transparent)]
    Field(#[from] FormatError),
    /// The friction process is invalid.
    #[error("friction process: {0}")]
    Process(#[from] ProcessError),
    /// The results have another schema version.
    #[error(
        "{}: {}, but this program reads version {SCHEMA_VERSION}; run the {} again with `asperity {} {}`",
        path.display(),
        found.as_ref().map_or_else(|| "the results state no schema_version".to_owned(), |found| format!("the results have schema_version {found}")),
        if *is_campaign { "campaign" } else { "study" },
        if *is_campaign { "campaign" } else { "run" },
        path.with_file_name(if *is_campaign { CAMPAIGN } else { STUDY }).display()
    )]
    SchemaVersion {
        /// The file.
        path: PathBuf,
        /// Version found, if there is one, as in the file.
        found: Option<String>,
        /// Whether the results are those of a campaign.
        is_campaign: bool,
    },
    /// A value could not be written as JSON.
    #[error("cannot be written as JSON: {0}")]
    Json(#[from] serde_json::Error),
    /// The study could not be written.
    #[error("the study cannot be written as TOML: {0}")]
    Toml(#[from] toml::ser::Error),
    /// The report could not be rendered.
    #[cfg(feature = "report")]
    #[error("the report could not be rendered: {0}")]
    Report(#[from] asperity_report::ReportError),
}

fn at(path: &Path) -> impl FnOnce(io::Error) -> StoreError + '_ {
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

#[derive(serde::Serialize, serde::Deserialize)]
pub(super) struct FieldEntry {
    pub(super) dx_m: f64,
    pub(super) dy_m: f64,
    pub(super) unit: String,
}

/// Returns the name of the array of a field in its archive.
pub(super) fn array_name(name: &str, unit: &str) -> String {
    if unit.is_empty() { name.to_owned() } else { format!("{name}_{}", unit.to_lowercase()) }
}

/// Schema version of `results.json`.
#[derive(serde::Deserialize)]
struct Version {
    schema_version: Option<serde_json::Value>,
}

/// Reads the results of the finished run or campaign in `dir`.
pub(super) fn read_results<T: DeserializeOwned>(dir: &Path, is_campaign: bool) -> Result<T, StoreError> {
    let path = dir.join(RESULTS);
    let bytes = fs::read(&path).map_err(at(&path))?;
    let corrupt = |error: serde_json::Error| StoreError::Corrupt { path: path.clone(), reason: error.to_string() };
    let Version { schema_version: found } = serde_json::from_slice(&bytes).map_err(corrupt)?;
    if found != Some(SCHEMA_VERSION.into()) {
        let found = found.map(|found| found.to_string());
        return Err(StoreError::SchemaVersion { path, found, is_campaign });
    }
    serde_json::from_slice(&bytes).map_err(corrupt)
}

/// Fails if `dir` is no folder that asperity finished, with this file.
pub(super) fn require_finished(dir: &Path, file: &'static str) -> Result<(), StoreError> {
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

/// Finished run, read from its folder.
#[derive(Debug, Clone)]
pub struct StoredRun {
    /// Text of the resolved study.
    pub study: String,
    /// `results.json`.
    pub results: Results,
    /// `provenance.json`.
    pub provenance: Provenance,
    /// Tables by name.
    pub tables: BTreeMap<String, Table>,
    /// Fields by name.
    pub fields: BTreeMap<String, Field>,
    /// `machine.json`, if the run has one.
    pub machine: Option<RunMachine>,
}

impl StoredRun {
    /// Returns whether `dir` is the folder of a finished run.
    pub fn is_run(dir: &Path) -> bool {
        dir.join(COMPLETE).is_file()
    }

    /// Reads the run folder `dir`.
    ///
    /// # Errors
    /// The folder is no finished run, or one of its files cannot be read.
    pub fn load(dir: &Path) -> Result<Self, StoreError> {
        // A campaign has no study of its own.
        require_finished(dir, STUDY)?;
        let read = |relative: &str| {
            let path = dir.join(relative);
            fs::read(&path).map_err(at(&path))
        };
        let corrupt = |relative: &str, reason: String| StoreError::Corrupt { path: dir.join(relative), reason };
        let results = read_results(dir, false)?;
        let provenance =
            serde_json::from_slice(&read(PROVENANCE)?).map_err(|error| corrupt(PROVENANCE, error.to_string()))?;
        let mut tables = BTreeMap::new();
        let folder = dir.join("tables");
        if folder.is_dir() {
            for entry in fs::read_dir(&folder).map_err(at(&folder))? {
                let path = entry.map_err(at(&folder))?.path();
                let name = path.file_stem().map(|stem| stem.to_string_lossy().into_owned());
                if let (Some(name), true) = (name, path.extension().is_some_and(|extension| extension == "csv")) {
                    let bytes = fs::read(&path).map_err(at(&path))?;
                    let table = Table::from_csv(&bytes).map_err(|error| corrupt(&name, error.to_string()))?;
                    tables.insert(name, table);
                }
            }
        }
        let index: BTreeMap<String, FieldEntry> =
            serde_json::from_slice(&read(FIELD_INDEX)?).map_err(|error| corrupt(FIELD_INDEX, error.to_string()))?;
        let mut fields = BTreeMap::new();
        for (name, entry) in index {
            let relative = format!("fields/{name}.npz");
            let FieldEntry { dx_m, dy_m, unit } = entry;
            let values = asperity_formats::read_npz(&read(&relative)?, &array_name(&name, &unit))
                .map_err(|error| corrupt(&relative, error.to_string()))?;
            if !Field::is_pitch([dx_m, dy_m]) {
                let reason = format!("the pitches {dx_m} and {dy_m} of {name} are not positive and finite");
                return Err(corrupt(FIELD_INDEX, reason));
            }
            fields.insert(name, Field::new([dx_m, dy_m], unit, values));
        }
        let machine = if dir.join(MACHINE).is_file() {
            let machine = serde_json::from_slice(&read(MACHINE)?);
            Some(machine.map_err(|error| corrupt(MACHINE, error.to_string()))?)
        } else {
            None
        };
        let study = String::from_utf8_lossy(&read(STUDY)?).into_owned();
        Ok(Self { study, results, provenance, tables, fields, machine })
    }

    /// Replaces files of a finished run, each atomically, and updates the manifest.
    ///
    /// # Errors
    /// The operating system refused; each file is then either replaced or unchanged.
    pub fn replace(dir: &Path, files: &[(String, Vec<u8>)]) -> Result<(), StoreError> {
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
}

/// Returns indented JSON with a final newline.
pub fn json_bytes(value: &impl serde::Serialize) -> Result<Vec<u8>, StoreError> {
    let mut bytes = serde_json::to_vec_pretty(value)?;
    bytes.push(b'\n');
    Ok(bytes)
}
