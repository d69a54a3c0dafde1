//! Runs of studies.

use std::path::{Path, PathBuf};
use std::time::{SystemTime, UNIX_EPOCH};

use asperity::choice::Choice;
use asperity::monitor::{Cancelled, Monitor};
use asperity::study::{
    Campaign, Computation, Computed, Provenance, RunBlocks, Share, Stage, StageEstimate, Staging, StoredRun, Study,
    StudyError, Work, folder_of, machine, program, works,
};
use asperity_formats::read_settings;
use asperity_report::verdict_summary;
use asperity_results::split_unit;
use numpy::{PyArray1, PyArray2};
use pyo3::prelude::*;
use pyo3::types::PyDict;

use crate::convert::{to_python, to_value, whole};
use crate::errors::{Raise, exception, refused, value_error, with_message};
use crate::long;
use crate::process::dictionary;
use crate::resources::require_memory;

/// Returns the content of a file or, of a dictionary, TOML.
fn text_of(study: &Bound<'_, PyAny>) -> PyResult<(String, Option<PathBuf>)> {
    if study.is_instance_of::<PyDict>() {
        return Ok((table_text(study.cast()?)?, None));
    }
    let file: PathBuf = study.extract()?;
    Ok((read(&file)?, Some(file)))
}

fn read(file: &Path) -> PyResult<String> {
    let bytes = read_settings(file).map_err(|error| refused(file.display(), &error))?;
    String::from_utf8(bytes)
        .map_err(|_| value_error(format_args!("{}: not a text file; a study is a TOML file", file.display())))
}

/// Returns the study of a text, of a file or of a dictionary.
fn parsed(text: &str, file: Option<&Path>) -> PyResult<Study> {
    let name = file.map_or_else(|| "study".into(), |file| file.display().to_string());
    Study::parse(text, &name).map_err(|error| match file {
        Some(_) => with_message(&error, error.to_string()),
        // The lines of a dictionary are not those of the user.
        None => {
            let line = text.lines().nth(error.line - 1).unwrap_or_default();
            with_message(&error, format!("study, at `{line}`: {}", error.message))
        }
    })
}

fn optional_seed(seed: &Bound<'_, PyAny>) -> PyResult<Option<u64>> {
    if seed.is_none() {
        return Ok(None);
    }
    // A run stores it as TOML.
    let number: u64 = whole(seed)?;
    i64::try_from(number).map_err(|_| value_error(format_args!("seed: {number} is above {}", i64::MAX)))?;
    Ok(Some(number))
}

/// Study or campaign that a Python program asks for.
#[derive(FromPyObject)]
#[pyo3(from_item_all)]
pub(crate) struct Request<'py> {
    /// Path of a study or a campaign, or a study as a dictionary.
    source: Bound<'py, PyAny>,
    only: Option<String>,
    seed: Bound<'py, PyAny>,
    /// File of this module.
    pub(crate) library: PathBuf,
}

impl Request<'_> {
    /// Reads the study or the campaign and checks it.
    pub(crate) fn computation(&self) -> PyResult<Computation> {
        let only = self.only.as_deref().map(|only| Stage::from_name(only).raise()).transpose()?;
        let seed = optional_seed(&self.seed)?;
        let (text, file) = text_of(&self.source)?;
        let is_campaign = text.parse::<toml::Table>().is_ok_and(|table| table.contains_key("study"));
        if let (true, Some(file)) = (is_campaign, &file) {
            if only.is_some() {
                return Err(value_error(format_args!(
                    "{} is a campaign, of which no stage can be chosen",
                    file.display()
                )));
            }
            let study = Campaign::study_path(&text, file).raise()?;
            let campaign = Campaign::parse(&text, file, &read(&folder_of(file).join(study))?, seed).raise()?;
            return Ok(Computation::campaign(file.clone(), text, campaign));
        }
        let study = parsed(&text, file.as_deref())?;
        let study = if let Some(seed) = seed { study.with_seed(seed) } else { study };
        Ok(Computation::study(file, text, study, only))
    }
}

/// Returns the exception of a failed computation.
pub(crate) fn failed(computation: &Computation, error: &StudyError) -> PyErr {
    with_message(error, computation.message(error))
}

/// Computes a study or, with `campaign`, a campaign. Returns results, tables and fields; with `out` also writes the folder, and goes on from the blocks that
/// an interrupted computation left beside it.
#[pyfunction]
#[pyo3(signature = (request, campaign, progress, out))]
pub(crate) fn compute<'py>(
    py: Python<'py>,
    request: Request<'py>,
    campaign: bool,
    progress: Option<Bound<'py, PyAny>>,
    out: Option<PathBuf>,
) -> PyResult<Bound<'py, PyDict>> {
    let computation = request.computation()?;
    if campaign != matches!(computation.work(), Work::Campaign(_)) {
        let (found, name) = if campaign { ("study", "run_study") } else { ("campaign", "run_campaign") };
        return Err(value_error(format_args!("found a {found}; asperity.{name} computes it")));
    }
    let library = request.library;
    let computed = long::run(py, progress.as_ref(), move |monitor| {
        let Some(out) = out else {
            require_free(&computation)?;
            return computation.compute(None, monitor).map_err(|error| failed(&computation, &error));
        };
        let found = compute_stored(&computation, &library, &out, Some(&out), Share::All, &[], monitor)?;
        found.map_err(|_| failed(&computation, &StudyError::Incomplete))
    })?;
    answer(py, computed)
}

fn require_free(computation: &Computation) -> PyResult<()> {
    let largest = computation.largest_stage(rayon::current_num_threads());
    match largest.map_err(|error| failed(computation, &error))? {
        Some(largest) => require_memory(largest.memory_bytes, &format!("the {} stage", largest.stage.name())),
        None => Ok(()),
    }
}

/// Computes with the blocks of the run `run` and of `parts`, and writes the folder `out`, if there is one. Returns the blocks if some are
/// missing.
pub(crate) fn compute_stored(
    computation: &Computation,
    library: &Path,
    run: &Path,
    out: Option<&Path>,
    share: Share,
    parts: &[PathBuf],
    monitor: &dyn Monitor,
) -> PyResult<Result<Computed, RunBlocks>> {
    let program = program(library, String::new()).raise()?;
    let started_unix_s = SystemTime::now().duration_since(UNIX_EPOCH).map_or(0, |since| since.as_secs());
    let provenance = computation.provenance().raise()?;
    let provenance = Provenance { started_unix_s, machine: machine(), program: program.clone(), ..provenance };
    let inputs = computation.inputs();
    let inputs: Vec<&Path> = inputs.iter().map(PathBuf::as_path).collect();
    let staging = out.map(|out| Staging::open(out, false, &inputs)).transpose().raise()?;
    let blocks = RunBlocks::open(run, computation.record(program, None).raise()?, share).raise()?;
    require_free(computation)?;
    parts.iter().try_for_each(|part| blocks.import(part)).raise()?;
    let found = computation.compute(Some(&blocks), monitor);
    blocks.flush().raise()?;
    let computed = match found {
        Err(StudyError::Incomplete) => return Ok(Err(blocks)),
        found => found.map_err(|error| failed(computation, &error))?,
    };
    if let Some(staging) = staging {
        computation.write(&staging, &computed, &provenance).raise()?;
        if monitor.cancelled() {
            return Err(exception(&Cancelled));
        }
        staging.commit().raise()?;
        // Blocks elsewhere may be those of several runs.
        if out == Some(run) {
            blocks.finish().raise()?;
        }
    }
    Ok(Ok(computed))
}

/// Returns the parts of results: of a study with its tables, fields and friction process.
pub(crate) fn answer(py: Python<'_>, computed: Computed) -> PyResult<Bound<'_, PyDict>> {
    let answer = PyDict::new(py);
    let outcome = match computed {
        Computed::Run(outcome) => *outcome,
        Computed::Campaign(results) => {
            answer.set_item("campaign", to_python(py, &results)?)?;
            return Ok(answer);
        }
    };
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
        let (dx_m, dy_m, unit) = (field.dx_m(), field.dy_m(), field.unit().to_owned());
        fields.set_item(name, (PyArray2::from_owned_array(py, field.into_values()), dx_m, dy_m, unit))?;
    }
    let process = outcome.friction_process.as_ref().map(|process| dictionary(py, process)).transpose()?;
    answer.set_item("friction_process", process)?;
    answer.set_item("summary", outcome.results.verdict.as_ref().map(verdict_summary).unwrap_or_default())?;
    answer.set_item("results", to_python(py, &outcome.results)?)?;
    answer.set_item("tables", tables)?;
    answer.set_item("fields", fields)?;
    Ok(answer)
}

fn table_text(table: &Bound<'_, PyDict>) -> PyResult<String> {
    toml::to_string(&toml::Table::try_from(to_value(table)?).raise()?).raise()
}

/// Checks the values of a study; its scans are not read.
#[pyfunction]
pub(crate) fn check_inputs(study: &Bound<'_, PyDict>) -> PyResult<()> {
    parsed(&table_text(study)?, None).map(|_| ())
}

/// Returns the text of a study file.
#[pyfunction]
pub(crate) fn toml_of(study: &Bound<'_, PyDict>) -> PyResult<String> {
    table_text(study)
}

/// Returns the content of a study file, which is checked.
#[pyfunction]
pub(crate) fn read_study(py: Python<'_>, path: PathBuf) -> PyResult<Bound<'_, PyAny>> {
    let text = read(&path)?;
    parsed(&text, Some(&path))?;
    to_python(py, &text.parse::<toml::Table>().raise()?)
}

/// Returns the stages of a study with their cost, warnings, and reasons why it cannot run.
#[pyfunction]
pub(crate) fn check_study<'py>(py: Python<'py>, request: Request<'py>) -> PyResult<Bound<'py, PyDict>> {
    let computation = request.computation()?;
    let Work::Study { study, .. } = computation.work() else {
        return Err(value_error("found a campaign, expected a study"));
    };
    let (folder, raised) = (computation.folder(), |error: StudyError| failed(&computation, &error));
    let mut warnings = study.check_scans(folder).map_err(raised)?;
    let mut problems = Vec::new();
    match study.check_before_run(folder) {
        Ok(found) => warnings.extend(found),
        Err(error) => problems.push(computation.message(&error)),
    }
    let threads = rayon::current_num_threads();
    let stages = study.estimate(study.scan_points(folder).map_err(raised)?, threads);
    let entry = |stage: &StageEstimate| -> PyResult<Bound<'py, PyDict>> {
        let entry = PyDict::new(py);
        entry.set_item("stage", stage.stage.name())?;
        entry.set_item("contact_solutions", stage.contact_solutions)?;
        entry.set_item("core_s", stage.core_seconds)?;
        entry.set_item("memory_bytes", stage.memory_bytes)?;
        Ok(entry)
    };
    let found = PyDict::new(py);
    found.set_item("stages", stages.iter().map(entry).collect::<PyResult<Vec<_>>>()?)?;
    found.set_item("warnings", warnings)?;
    found.set_item("problems", problems)?;
    Ok(found)
}

/// Returns the works behind the methods of the run in a folder, as sentences or as entries of BibTeX.
#[pyfunction]
pub(crate) fn cite(py: Python<'_>, folder: PathBuf, bibtex: bool) -> PyResult<Vec<String>> {
    let run = long::run(py, None, move |_| StoredRun::load(&folder).raise())?;
    let cited = works(&run.results, &run.study);
    Ok(cited.iter().map(|work| if bibtex { work.bibtex() } else { work.text() }).collect())
}

/// Returns the SI unit that the name of a number ends with; empty if it states none.
#[pyfunction]
pub(crate) fn unit_of(name: &str) -> &'static str {
    split_unit(name).1
}

/// Returns the JSON Schema of studies, from which the classes of their sections are generated.
#[pyfunction]
pub(crate) fn study_schema() -> String {
    asperity::study::study_schema().to_value().to_string()
}

/// Returns the JSON Schema of results, from which the dataclasses are generated.
#[pyfunction]
pub(crate) fn results_schema() -> String {
    asperity_results::results_schema().to_value().to_string()
}
