//! Files of a run folder, and finished runs that are read back.

use std::collections::BTreeMap;
use std::fs;
use std::io;
use std::path::Path;

use asperity_runs::{StoreError, require_finished};
use serde::de::DeserializeOwned;
use serde::{Deserialize, Serialize};

use crate::study::result::{Field, Provenance, Results, SCHEMA_VERSION, Table};
use crate::study::run_machine::RunMachine;

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

#[derive(Serialize, Deserialize)]
pub(super) struct FieldEntry {
    pub(super) dx_m: f64,
    pub(super) dy_m: f64,
    pub(super) unit: String,
}

/// Returns the name of the array of a field in its archive.
pub(super) fn array_name(name: &str, unit: &str) -> String {
    if unit.is_empty() { name.to_owned() } else { format!("{name}_{}", unit.to_lowercase()) }
}

fn at(path: &Path) -> impl FnOnce(io::Error) -> StoreError + '_ {
    move |source| StoreError::Io { path: path.into(), source }
}

/// Schema version of `results.json`.
#[derive(Deserialize)]
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
        let (what, command, file) =
            if is_campaign { ("campaign", "campaign", CAMPAIGN) } else { ("study", "run", STUDY) };
        let again = format!("the {what} again with `asperity {command} {}`", path.with_file_name(file).display());
        return Err(StoreError::SchemaVersion { path, found, again });
    }
    serde_json::from_slice(&bytes).map_err(corrupt)
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
}
