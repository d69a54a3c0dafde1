//! Friction processes: fitted to records, stored as JSON, simulated.

use std::fmt::Display;
use std::io;
use std::path::PathBuf;

use asperity::distribution::Marginal;
use asperity::friction::measured::{DistributionChoice, FittedRecord, MeasuredRecord, RecordPreparation};
use asperity::friction::process::FittedProcess;
use asperity_formats::read_text;
use numpy::{PyArray1, PyReadonlyArray1};
use pyo3::prelude::*;
use serde_json::Value;

use crate::convert::{from_json, to_value, whole};
use crate::errors::{Raise, format_error, refused, value_error, warn};
use crate::long;

/// Returns the process of a dictionary, with the keys of its file. The marginal distribution may be a text.
pub(crate) fn process_of(process: &Bound<'_, PyAny>) -> PyResult<FittedProcess> {
    let mut document = to_value(process)?;
    if let Some(text) = document.get("marginal").and_then(Value::as_str) {
        let marginal: Marginal = text.parse().map_err(value_error)?;
        document["marginal"] = serde_json::to_value(marginal).raise()?;
    }
    FittedProcess::from_json(&document.to_string()).raise()
}

/// Returns a process as a dictionary.
pub(crate) fn dictionary<'py>(py: Python<'py>, process: &FittedProcess) -> PyResult<Bound<'py, PyAny>> {
    from_json(py, &process.to_json().raise()?)
}

/// Checks a process, a dictionary with the keys of its file, and completes it.
#[pyfunction]
pub(crate) fn friction_process<'py>(process: &Bound<'py, PyAny>) -> PyResult<Bound<'py, PyAny>> {
    dictionary(process.py(), &process_of(process)?)
}

/// Reads a process from a file.
#[pyfunction]
pub(crate) fn read_friction_process(py: Python<'_>, path: PathBuf) -> PyResult<Bound<'_, PyAny>> {
    let process = long::run(py, None, move |_| {
        let damaged = |reason: &dyn Display| format_error(format_args!("{}: {reason}", path.display()));
        let text = read_text(&path).map_err(|error| match error.kind() {
            io::ErrorKind::InvalidData => damaged(&error),
            _ => refused(path.display(), &error),
        })?;
        FittedProcess::from_json(&text).map_err(|error| damaged(&error))
    })?;
    dictionary(py, &process)
}

/// Draws values of the friction coefficient along a path.
#[pyfunction]
pub(crate) fn simulate_friction<'py>(
    process: &Bound<'py, PyAny>,
    length_m: f64,
    step_m: f64,
    #[pyo3(from_py_with = whole)] seed: u64,
    #[pyo3(from_py_with = whole)] index: u64,
) -> PyResult<Bound<'py, PyArray1<f64>>> {
    let own = process_of(process)?;
    let values = long::run(process.py(), None, move |_| own.simulate(length_m, step_m, seed, index).raise())?;
    Ok(PyArray1::from_vec(process.py(), values))
}

/// Fits a process to a record of the friction coefficient at equal steps; NaN marks gaps.
#[pyfunction]
pub(crate) fn fit_friction_record<'py>(
    py: Python<'py>,
    friction: PyReadonlyArray1<'py, f64>,
    step_m: f64,
    marginal: &str,
    detrend: &str,
    low_pass_m: Option<f64>,
    #[pyo3(from_py_with = whole)] decimation: usize,
) -> PyResult<Bound<'py, PyAny>> {
    if decimation == 0 {
        return Err(value_error("decimation is 0, but must be at least 1"));
    }
    let record = MeasuredRecord {
        start_m: 0.0,
        step_m,
        friction: friction.as_array().to_vec(),
        velocity_m_per_s: None,
        strokes_m: Vec::new(),
        warnings: Vec::new(),
    };
    let choice: DistributionChoice = marginal.parse().map_err(value_error)?;
    let detrend = detrend.parse().map_err(value_error)?;
    let preparation = RecordPreparation { cut: None, detrend, low_pass_m, decimation };
    let (mut warnings, fitted) = long::run(py, None, move |_| {
        let prepared = preparation.apply(&record).raise()?;
        let fitted = FittedRecord::new(&prepared, choice, "array of a Python program").raise()?;
        Ok((prepared.record.warnings, fitted))
    })?;
    warnings.extend(fitted.warnings);
    warnings.iter().try_for_each(|warning| warn(py, warning))?;
    dictionary(py, &fitted.process)
}
