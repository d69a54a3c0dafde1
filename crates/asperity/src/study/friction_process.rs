//! Fitted friction process as the input of a study, and records drawn from it.

use std::path::Path;

use asperity_formats::{read_text, refusal};

use crate::friction::process::{FittedProcess, ProcessError};
use crate::study::{StudyError, Table};

/// Simulates a record of a process: `position_m`, `mu` and `fluctuation`, the deviation of μ from its mean.
///
/// # Errors
/// See [`FittedProcess::simulate`].
pub fn simulated_record(process: &FittedProcess, length_m: f64, step_m: f64, seed: u64) -> Result<Table, ProcessError> {
    let mu = process.simulate(length_m, step_m, seed, 0)?;
    Ok(Table::new([
        ("position_m", (0..mu.len()).map(|index| index as f64 * step_m).collect()),
        ("fluctuation", mu.iter().map(|mu| mu - process.mean).collect()),
        ("mu", mu),
    ]))
}

/// Reads the process that a study names; `path` is its location, `name` its name in the study.
///
/// # Errors
/// The file cannot be read, or contains no process.
pub(super) fn read(path: &Path, name: &Path) -> Result<FittedProcess, StudyError> {
    let failed = |reason: String| StudyError::FrictionProcess { file: name.display().to_string(), reason };
    let text = read_text(path).map_err(|error| failed(refusal(&error)))?;
    FittedProcess::from_json(&text).map_err(|error| failed(error.to_string()))
}
