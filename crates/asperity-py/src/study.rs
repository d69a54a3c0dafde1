//! Runs of studies.

use std::fs;
use std::path::{Path, PathBuf};

use asperity::choice::Choice;
use asperity::study::result::{Machine, Outcome};
use asperity::study::{Provenance, Stage, Staging, Study, StudyError, provenance, write_run};
use numpy::{PyArray1, PyArray2};
use pyo3::prelude::*;
use pyo3::types::PyDict;

use crate::convert::{to_python, to_value, whole};
use crate::errors::{Raise, refused, value_error, with_message};
use crate::long;
use crate::process::dictionary;
use crate::resources::require_memory;

/// A study and where it comes from.
pub(crate) struct Source {
    text: String,
    /// Its file; `None` for a dictionary.
    file: Option<PathBuf>,
}

impl Source {
    fn new(study: &Bound<'_, PyAny>) -> PyResult<Self> {
        if study.is_instance_of::<PyDict>() {
            let table = toml::Table::try_from(to_value(study)?).raise()?;
            return Ok(Self { text: toml::to_string(&table).raise()?, file: None });
        }
        let file: PathBuf = study.extract()?;
        let bytes = fs::read(&file).map_err(|error| refused(file.display(), &error))?;
        let text = String::from_utf8(bytes)
            .map_err(|_| value_error(format_args!("{}: not a text file; a study is a TOML file", file.display())))?;
        Ok(Self { text, file: Some(file) })
    }

    /// Returns the name of the study in messages.
    fn name(&self) -> String {
        self.file.as_ref().map_or_else(|| "study".into(), |file| file.display().to_string())
    }

    /// Returns the folder to which the paths in the study are relative.
    pub(crate) fn folder(&self) -> PathBuf {
        let parent = self.file.as_deref().and_then(Path::parent);
        parent.filter(|folder| !folder.as_os_str().is_empty()).unwrap_or(Path::new(".")).to_path_buf()
    }

    fn parse(&self) -> PyResult<Study> {
        Study::parse(&self.text, &self.name()).map_err(|error| match &self.file {
            Some(_) => with_message(&error, error.to_string()),
            // The lines of a dictionary are not those of the user.
            None => {
                let line = self.text.lines().nth(error.line - 1).unwrap_or_default();
                with_message(&error, format!("study, at `{line}`: {}", error.message))
            }
        })
    }

    /// Returns the exception of a failed run, with the line of the file that caused it.
    pub(crate) fn exception(&self, error: &StudyError) -> PyErr {
        let message = match (error, error.line_in(&self.text).filter(|_| self.file.is_some())) {
            // The error of a scan already names its file.
            (StudyError::Scan(_) | StudyError::Map { .. }, _) => error.to_string(),
            (_, Some(line)) => format!("{}:{line}: {error}", self.name()),
            (_, None) => format!("{}: {error}", self.name()),
        };
        with_message(error, message)
    }

    /// Begins the provenance of a run.
    fn provenance(&self, study: &Study) -> PyResult<Provenance> {
        let name = self.file.as_deref().and_then(Path::file_stem).map_or("study".into(), |stem| stem.to_string_lossy());
        let folder = self.folder();
        let data = study.scan_paths(&folder).into_iter().chain(study.friction_process_path(&folder));
        let inputs: Vec<PathBuf> = self.file.iter().cloned().chain(data).collect();
        let machine = Machine {
            system: std::env::consts::OS.into(),
            architecture: std::env::consts::ARCH.into(),
            processor: None,
            threads: rayon::current_num_threads(),
        };
        Ok(Provenance { machine, ..provenance(&name, study.seed(), &inputs).raise()? })
    }
}

fn optional_seed(seed: &Bound<'_, PyAny>) -> PyResult<Option<u64>> {
    if seed.is_none() { Ok(None) } else { whole(seed).map(Some) }
}

/// Returns a study with its source, and the stage that is asked for.
pub(crate) fn chosen(
    study: &Bound<'_, PyAny>,
    only: Option<&str>,
    seed: Option<u64>,
) -> PyResult<(Source, Study, Option<Stage>)> {
    let source = Source::new(study)?;
    let only = only.map(|only| Stage::from_name(only).raise()).transpose()?;
    let study = source.parse()?;
    Ok((source, if let Some(seed) = seed { study.with_seed(seed) } else { study }, only))
}

/// Runs a study, the path of a file or a dictionary. Returns results, tables and fields; with `out` also writes the run
/// folder.
#[pyfunction]
#[pyo3(signature = (study, only, seed, progress, out))]
pub(crate) fn run_study<'py>(
    py: Python<'py>,
    study: &Bound<'py, PyAny>,
    only: Option<&str>,
    #[pyo3(from_py_with = optional_seed)] seed: Option<u64>,
    progress: Option<Bound<'py, PyAny>>,
    out: Option<PathBuf>,
) -> PyResult<Bound<'py, PyDict>> {
    let (source, study, only) = chosen(study, only, seed)?;
    let outcome = long::run(py, progress.as_ref(), move |monitor| {
        let folder = source.folder();
        let scan_points = study.scan_points(&folder).map_err(|error| source.exception(&error))?;
        for stage in study.estimate(scan_points, rayon::current_num_threads()) {
            require_memory(stage.memory_bytes, &format!("the {} stage", stage.stage.name()))?;
        }
        let staging = out.map(|out| {
            let scans = study.scan_paths(&folder);
            let inputs: Vec<&Path> = source.file.iter().chain(&scans).map(PathBuf::as_path).collect();
            Ok::<_, PyErr>((Staging::open(&out, false, &inputs).raise()?, source.provenance(&study)?))
        });
        let staging = staging.transpose()?;
        let outcome = study.run(&folder, only, monitor).map_err(|error| source.exception(&error))?;
        if let Some((staging, provenance)) = staging {
            let provenance = Provenance { only: only.map(|stage| stage.name().to_owned()), ..provenance };
            write_run(&staging, &study, &folder, &outcome, &provenance).raise()?;
            if monitor.cancelled() {
                return Err(source.exception(&StudyError::Cancelled(asperity::monitor::Cancelled)));
            }
            staging.commit().raise()?;
        }
        Ok(outcome)
    })?;
    answer(py, outcome)
}

pub(crate) fn answer(py: Python<'_>, outcome: Outcome) -> PyResult<Bound<'_, PyDict>> {
    let (tables, fields) = (PyDict::new(py), PyDict::new(py));
    for (name, table) in outcome.tables {
        let columns = PyDict::new(py);
        if !table.names().is_empty() {
            columns.set_item("name", table.names())?;
        }
        for (column, values) in table.into_columns() {
            columns.set_item(column, PyArray1::from_vec(py, values))?;
        }
        tables.set_item(name, columns)?;
    }
    for (name, field) in outcome.fields {
        let (dx_m, dy_m) = (field.grid.dx_m(), field.grid.dy_m());
        fields.set_item(name, (PyArray2::from_owned_array(py, field.values), dx_m, dy_m, field.unit))?;
    }
    let answer = PyDict::new(py);
    let process = outcome.friction_process.as_ref().map(|process| dictionary(py, process)).transpose()?;
    answer.set_item("friction_process", process)?;
    answer.set_item("results", to_python(py, &outcome.results)?)?;
    answer.set_item("tables", tables)?;
    answer.set_item("fields", fields)?;
    Ok(answer)
}

/// Returns the JSON Schema of results, from which the dataclasses are generated.
#[pyfunction]
pub(crate) fn results_schema() -> String {
    asperity_results::results_schema().to_value().to_string()
}
