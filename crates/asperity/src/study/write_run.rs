//! Run folders: all results of a run, and their provenance.

use std::collections::BTreeMap;
use std::path::{self, Path, PathBuf};

use asperity_results::Provenance;

use crate::study::stored_run::{
    FIELD_INDEX, FRICTION_PROCESS, FieldEntry, MACHINE, PROVENANCE, RESULTS, STUDY, array_name,
};
use crate::study::{Field, Outcome, Staging, StoreError, Study, StudyFile, file_hash, json_bytes};

/// Returns the provenance of a computation from the files `inputs`: version, name, seed and the hash of every file.
///
/// The library reads neither clock nor host; the caller fills in the start, the durations and the machine.
///
/// # Errors
/// A file cannot be read.
pub fn provenance(name: &str, seed: u64, inputs: &[PathBuf]) -> Result<Provenance, StoreError> {
    let mut provenance =
        Provenance { asperity: env!("CARGO_PKG_VERSION").into(), study: name.into(), seed, ..Provenance::default() };
    // What a pipe contained can be read only once; the folder of a run has the text of its study.
    for file in inputs.iter().filter(|file| file.is_file() || !file.exists()) {
        let name = file.file_name().unwrap_or_default().to_string_lossy().into_owned();
        // Two inputs in different folders may have the same name.
        let whole = || std::path::absolute(file).unwrap_or_else(|_| file.clone()).display().to_string();
        let name = if provenance.inputs.contains_key(&name) { whole() } else { name };
        provenance.inputs.insert(name, file_hash(file)?);
    }
    Ok(provenance)
}

/// Writes the complete run folder: the study, results, tables, fields, friction process and provenance; with the feature `report`
/// also the report and its figures.
///
/// `folder` is the folder of the study file. The run folder appears at its destination with [`Staging::commit`].
///
/// ```
/// use std::path::Path;
/// use asperity::monitor::Silent;
/// use asperity::study::{Staging, StoredRun, Study, provenance, write_run};
///
/// let text = "seed = 7\n[surface]\ncovariance = \"exponential\"\nmarginal = \"normal\"\n\
///             rms_height = \"1 um\"\ncorrelation_length = [\"20 um\", \"20 um\"]\n";
/// let study = Study::parse(text, "study.toml")?;
/// # let temporary = tempfile::tempdir()?;
/// # let runs = temporary.path();
/// let staging = Staging::open(&runs.join("first"), false, &[])?;
/// let outcome = study.run(Path::new("."), None, &Silent)?;
/// let mut origin = provenance("first", study.seed(), &[])?;
/// origin.machine.threads = 1;
/// write_run(&staging, &study, Path::new("."), &outcome, &origin)?;
/// let folder = staging.commit()?;
/// assert_eq!(StoredRun::load(&folder)?.results, outcome.results);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
///
/// # Errors
/// The operating system refused, or the report could not be rendered.
pub fn write_run(
    staging: &Staging,
    study: &Study,
    folder: &Path,
    outcome: &Outcome,
    provenance: &Provenance,
) -> Result<(), StoreError> {
    let study = resolved_study(study, folder)?;
    staging.write(STUDY, study.as_bytes())?;
    staging.write(PROVENANCE, &json_bytes(provenance)?)?;
    result_files(outcome, |relative, bytes| staging.write(relative, bytes))?;
    #[cfg(feature = "report")]
    for (relative, bytes) in super::report::new_report(&study, outcome, provenance).map_err(StoreError::content)? {
        staging.write(&relative, &bytes)?;
    }
    Ok(())
}

/// Returns the text of a study with all its values and absolute paths, which are valid from every folder.
///
/// # Errors
/// The study cannot be written as TOML.
pub fn resolved_study(study: &Study, folder: &Path) -> Result<String, StoreError> {
    // TOML stores only Unicode; any other path is kept unchanged.
    let absolute = |name: &Path| path::absolute(folder.join(name)).ok().filter(|path| path.to_str().is_some());
    let file = with_paths(study.file(), |name| absolute(name).unwrap_or_else(|| name.to_path_buf()));
    file.to_text()
}

/// Passes the files of a run folder that equal studies give equal bytes to `write`, each with its relative name: results, tables,
/// friction process, machine and fields.
///
/// # Errors
/// A result cannot be written in its format, or `write` fails.
pub fn result_files(
    outcome: &Outcome,
    mut write: impl FnMut(&str, &[u8]) -> Result<(), StoreError>,
) -> Result<(), StoreError> {
    write(RESULTS, &json_bytes(&outcome.results)?)?;
    for (name, table) in &outcome.tables {
        write(&format!("tables/{name}.csv"), &table.to_csv().map_err(StoreError::content)?)?;
    }
    if let Some(process) = &outcome.friction_process {
        write(FRICTION_PROCESS, process.to_json().map_err(StoreError::content)?.as_bytes())?;
    }
    if let Some(machine) = &outcome.machine {
        write(MACHINE, &json_bytes(machine)?)?;
    }
    let mut index = BTreeMap::new();
    for (name, field) in &outcome.fields {
        let (dx_m, dy_m) = (field.dx_m(), field.dy_m());
        index.insert(name.clone(), FieldEntry { dx_m, dy_m, unit: field.unit().into() });
        let vtk =
            asperity_formats::write_vtk_fields((dx_m, dy_m), &[(name, field.values())]).map_err(StoreError::content)?;
        write(&format!("fields/{name}.vti"), &vtk)?;
        let archive =
            npz(name, field).map_err(|source| StoreError::Io { path: format!("fields/{name}.npz").into(), source })?;
        write(&format!("fields/{name}.npz"), &archive)?;
    }
    write(FIELD_INDEX, &json_bytes(&index)?)
}

/// Returns a NumPy archive of a field and its pitch. The name of the array ends with the unit.
fn npz(name: &str, field: &Field) -> std::io::Result<Vec<u8>> {
    let values = asperity_formats::write_npy(&asperity_formats::Scan::new(field.values().clone(), None));
    let [dx, dy] = [field.dx_m(), field.dy_m()].map(|pitch_m| asperity_formats::write_series(&[pitch_m]));
    asperity_formats::write_npz(&[(&array_name(name, field.unit()), values), ("dx_m", dx), ("dy_m", dy)])
}

/// Returns the study file with each path replaced by `name`.
pub(super) fn with_paths(file: &StudyFile, name: impl Fn(&Path) -> PathBuf) -> StudyFile {
    let mut file = file.clone();
    let own = file.surface.as_mut().and_then(|surface| surface.file.as_mut());
    let other = file.counterface.as_mut().and_then(|counterface| counterface.file.as_mut());
    for scans in own.into_iter().chain(other) {
        *scans = scans.map(&name);
    }
    if let Some(process) = file.vibration.as_mut().and_then(|vibration| vibration.friction_process.as_mut()) {
        *process = name(process);
    }
    file.uncertain.iter_mut().for_each(|value| value.rename(&name));
    file
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_hash_of_an_input_is_its_sha_256() {
        let folder = tempfile::tempdir().unwrap();
        let file = folder.path().join("abc.txt");
        std::fs::write(&file, "abc").unwrap();
        let found = provenance("abc", 1, &[file.clone(), file.clone()]).unwrap();
        // FIPS 180-2, appendix B.1.
        let wanted = "ba7816bf8f01cfea414140de5dae2223b00361a396177a9cb410ff61f20015ad";
        assert_eq!(found.inputs["abc.txt"], wanted);
        assert_eq!(found.inputs[&file.display().to_string()], wanted);
        assert!(matches!(provenance("abc", 1, &[folder.path().join("gone")]), Err(StoreError::Input { .. })));
    }
}
