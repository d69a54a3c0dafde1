//! The folder of a finished run.
//!
//! A run is written into a hidden folder beside its destination and moved there as a whole, so that a destination is
//! either complete or untouched. `COMPLETE` is written last.

use std::collections::BTreeMap;
use std::fs;
use std::io;
use std::path::{Path, PathBuf};

use asperity_formats::Scan;
use thiserror::Error;

use crate::friction::process::ProcessError;
use crate::study::{Outcome, Table, TableError};

/// Last file of a run folder.
const COMPLETE: &str = "COMPLETE";
/// The process that the friction stage hands on.
const FRICTION_PROCESS: &str = "friction_process.json";
/// Grids and units of the fields.
const FIELD_INDEX: &str = "fields/index.json";

/// Why a run folder could not be written or read.
#[derive(Debug, Error)]
pub enum StoreError {
    /// The file system refused.
    #[error("{}: {source}", path.display())]
    Io {
        /// File or folder.
        path: PathBuf,
        /// Its answer.
        source: io::Error,
    },
    /// The destination holds something.
    #[error("{} exists and is not empty; choose another folder with --out, or replace it with --force", path.display())]
    NotEmpty {
        /// The destination.
        path: PathBuf,
    },
    /// The destination has no name of its own, as `.` and `..`.
    #[error("{} names no folder that could be put in place as a whole; write its name", path.display())]
    Unnamed {
        /// The destination.
        path: PathBuf,
    },
    /// The destination holds a file that is read.
    #[error("{} holds {}, which is read: replacing the folder would delete it; choose another folder", path.display(), input.display())]
    HoldsInput {
        /// The destination.
        path: PathBuf,
        /// The file in it.
        input: PathBuf,
    },
    /// The folder holds no finished run.
    #[error("{} is not a finished run: it holds no {missing}", path.display())]
    NotARun {
        /// The folder.
        path: PathBuf,
        /// What is missing.
        missing: &'static str,
    },
    /// A file of the run cannot be read.
    #[error("{}: {reason}", path.display())]
    Corrupt {
        /// The file.
        path: PathBuf,
        /// What is wrong.
        reason: String,
    },
    /// A table could not be written.
    #[error(transparent)]
    Table(#[from] TableError),
    /// The process of the friction stage is none.
    #[error("friction process: {0}")]
    Process(#[from] ProcessError),
    /// A value could not be written as JSON.
    #[error("cannot be written as JSON: {0}")]
    Json(#[from] serde_json::Error),
}

fn at(path: &Path) -> impl FnOnce(io::Error) -> StoreError + '_ {
    move |source| StoreError::Io { path: path.into(), source }
}

/// A run folder in the making. Dropped without [`Staging::commit`], it leaves nothing behind.
#[derive(Debug)]
pub struct Staging {
    destination: PathBuf,
    partial: PathBuf,
}

impl Staging {
    /// Begins a run folder at `destination`. With `force` a folder that is there is replaced at the commit, unless it holds
    /// one of the `inputs`.
    ///
    /// # Errors
    /// The destination is a file, or not empty without `force`, or holds an input, or has no name of its own, or its parent
    /// cannot be written.
    pub fn open(destination: &Path, force: bool, inputs: &[&Path]) -> Result<Self, StoreError> {
        if destination.is_file() {
            return Err(StoreError::NotEmpty { path: destination.into() });
        }
        if destination.is_dir() && fs::read_dir(destination).map_err(at(destination))?.next().is_some() {
            let path = destination.to_path_buf();
            if !force {
                return Err(StoreError::NotEmpty { path });
            }
            let folder = destination.canonicalize().map_err(at(destination))?;
            let within = |input: &&&Path| input.canonicalize().is_ok_and(|input| input.starts_with(&folder));
            if let Some(input) = inputs.iter().find(within) {
                return Err(StoreError::HoldsInput { path, input: input.to_path_buf() });
            }
        }
        let Some(name) = destination.file_name().map(|name| name.to_string_lossy().into_owned()) else {
            return Err(StoreError::Unnamed { path: destination.into() });
        };
        let parent = destination.parent().filter(|parent| !parent.as_os_str().is_empty()).unwrap_or(Path::new("."));
        fs::create_dir_all(parent).map_err(at(parent))?;
        let partial = parent.join(format!(".{name}.partial-{}", std::process::id()));
        if partial.exists() {
            fs::remove_dir_all(&partial).map_err(at(&partial))?;
        }
        fs::create_dir_all(&partial).map_err(at(&partial))?;
        Ok(Self { destination: destination.into(), partial })
    }

    /// Writes one file of the run; `relative` may name a subfolder.
    ///
    /// # Errors
    /// The file system refused.
    pub fn write(&self, relative: &str, bytes: &[u8]) -> Result<(), StoreError> {
        let path = self.path(relative)?;
        fs::write(&path, bytes).map_err(at(&path))
    }

    /// Where a file of the run is to be written by someone else; its folder is there.
    ///
    /// # Errors
    /// The file system refused the folder.
    pub fn path(&self, relative: &str) -> Result<PathBuf, StoreError> {
        let path = self.partial.join(relative);
        if let Some(parent) = path.parent() {
            fs::create_dir_all(parent).map_err(at(parent))?;
        }
        Ok(path)
    }

    /// Writes results, tables, fields, and the process of the friction stage.
    ///
    /// # Errors
    /// The file system refused.
    pub fn write_outcome(&self, outcome: &Outcome) -> Result<(), StoreError> {
        self.write("results.json", &json_bytes(&outcome.results)?)?;
        for (name, table) in &outcome.tables {
            self.write(&format!("tables/{name}.csv"), &table.to_csv()?)?;
        }
        if let Some(process) = &outcome.friction_process {
            self.write(FRICTION_PROCESS, process.to_json()?.as_bytes())?;
        }
        let mut index = BTreeMap::new();
        for (name, field) in &outcome.fields {
            let entry = FieldEntry { dx_m: field.grid.dx_m(), dy_m: field.grid.dy_m(), unit: field.unit.into() };
            index.insert(name.clone(), entry);
            self.write(
                &format!("fields/{name}.npy"),
                &asperity_formats::write_npy(&Scan::new(field.values.clone(), None)),
            )?;
        }
        self.write(FIELD_INDEX, &json_bytes(&index)?)
    }

    /// Marks the run complete and moves it to its destination.
    ///
    /// # Errors
    /// The file system refused; the destination is then as before.
    pub fn commit(self) -> Result<PathBuf, StoreError> {
        self.write(COMPLETE, b"")?;
        self.commit_unmarked()
    }

    /// Moves a folder that is no run to its destination, with nothing in it but what was written.
    ///
    /// # Errors
    /// The file system refused; the destination is then as before.
    pub fn commit_unmarked(self) -> Result<PathBuf, StoreError> {
        let old = self.partial.with_extension("old");
        let replaced = self.destination.exists();
        if replaced {
            fs::rename(&self.destination, &old).map_err(at(&self.destination))?;
        }
        if let Err(error) = fs::rename(&self.partial, &self.destination) {
            if replaced {
                fs::rename(&old, &self.destination).map_err(at(&self.destination))?;
            }
            return Err(StoreError::Io { path: self.destination.clone(), source: error });
        }
        if replaced {
            fs::remove_dir_all(&old).map_err(at(&old))?;
        }
        Ok(self.destination.clone())
    }
}

impl Drop for Staging {
    fn drop(&mut self) {
        // After a commit there is nothing left to remove; before one, failing to clean up must not hide the first error.
        let _ = fs::remove_dir_all(&self.partial);
    }
}

#[derive(serde::Serialize, serde::Deserialize)]
struct FieldEntry {
    dx_m: f64,
    dy_m: f64,
    unit: String,
}

/// A map read back from a run folder.
#[derive(Debug, Clone, PartialEq)]
pub struct StoredField {
    /// Pitch along x in metre.
    pub dx_m: f64,
    /// Pitch along y in metre.
    pub dy_m: f64,
    /// SI unit of the values.
    pub unit: String,
    /// Values, shape `[ny, nx]`, NaN where undefined.
    pub values: ndarray::Array2<f64>,
}

/// A finished run, read back.
#[derive(Debug, Clone)]
pub struct StoredRun {
    /// Text of the resolved study.
    pub study: String,
    /// `results.json`.
    pub results: serde_json::Value,
    /// `provenance.json`.
    pub provenance: serde_json::Value,
    /// Tables by name.
    pub tables: BTreeMap<String, Table>,
    /// Fields by name.
    pub fields: BTreeMap<String, StoredField>,
}

impl StoredRun {
    /// Reads the run folder `dir`.
    ///
    /// # Errors
    /// It is not a finished run, or one of its files cannot be read.
    pub fn load(dir: &Path) -> Result<Self, StoreError> {
        if !dir.join(COMPLETE).is_file() {
            return Err(StoreError::NotARun { path: dir.into(), missing: COMPLETE });
        }
        let read = |relative: &str| {
            let path = dir.join(relative);
            fs::read(&path).map_err(at(&path))
        };
        let corrupt = |relative: &str, reason: String| StoreError::Corrupt { path: dir.join(relative), reason };
        let json = |relative: &str| -> Result<serde_json::Value, StoreError> {
            serde_json::from_slice(&read(relative)?).map_err(|error| corrupt(relative, error.to_string()))
        };
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
            let relative = format!("fields/{name}.npy");
            let scan = asperity_formats::read_bytes(&read(&relative)?)
                .map_err(|error| corrupt(&relative, error.to_string()))?;
            let FieldEntry { dx_m, dy_m, unit } = entry;
            fields.insert(name, StoredField { dx_m, dy_m, unit, values: scan.heights_m });
        }
        let study = String::from_utf8_lossy(&read("study.toml")?).into_owned();
        Ok(Self { study, results: json("results.json")?, provenance: json("provenance.json")?, tables, fields })
    }

    /// Replaces one file of a finished run as a whole.
    ///
    /// # Errors
    /// The file system refused; the file is then as before.
    pub fn replace(dir: &Path, relative: &str, bytes: &[u8]) -> Result<(), StoreError> {
        let path = dir.join(relative);
        if let Some(parent) = path.parent() {
            fs::create_dir_all(parent).map_err(at(parent))?;
        }
        let mut name = path.file_name().map(|name| name.to_os_string()).unwrap_or_default();
        name.push(".partial");
        let partial = path.with_file_name(name);
        fs::write(&partial, bytes).map_err(at(&partial))?;
        fs::rename(&partial, &path).map_err(at(&path))
    }
}

/// Indented JSON with a final newline.
pub fn json_bytes(value: &impl serde::Serialize) -> Result<Vec<u8>, StoreError> {
    let mut bytes = serde_json::to_vec_pretty(value)?;
    bytes.push(b'\n');
    Ok(bytes)
}
