//! Parts of a study on several machines: blocks that a worker computes, and the run of all parts.

use std::path::{Path, PathBuf};

use asperity::study::result::Program;
use asperity::study::{
    RunBlocks, RunRecord, Share, Stage, Study, StudyError, elementary_functions, file_hash, instruction_sets,
};
use pyo3::prelude::*;
use pyo3::types::PyDict;

use crate::errors::Raise;
use crate::long;
use crate::study::{answer, chosen};

/// Returns what stored blocks depend on beside the study. `library` is the file of this module.
fn program(library: &Path) -> PyResult<Program> {
    Ok(Program {
        sha256: file_hash(library).raise()?,
        dependencies_sha256: String::new(),
        instruction_sets: instruction_sets(),
        functions: elementary_functions(),
    })
}

fn record(study: &Study, only: Option<Stage>, library: &Path, shard: Option<[usize; 2]>) -> PyResult<RunRecord> {
    Ok(RunRecord { seed: study.seed(), only, shard, program: program(library)?, ..RunRecord::default() })
}

/// Computes a part, number and count, of the blocks that can be computed now, into a folder. Blocks in the folder above
/// it are used. Returns whether the study is complete.
#[pyfunction]
#[pyo3(signature = (study, only, seed, part, folder, library))]
pub(crate) fn study_part(
    py: Python<'_>,
    study: &Bound<'_, PyAny>,
    only: Option<&str>,
    seed: Option<u64>,
    part: (usize, usize),
    folder: PathBuf,
    library: PathBuf,
) -> PyResult<bool> {
    let (source, study, only) = chosen(study, only, seed)?;
    long::run(py, None, move |monitor| {
        let (number, of) = part;
        let record = record(&study, only, &library, Some([number, of]))?;
        let blocks = RunBlocks::open(&folder, record, Share::Part { number, of }).raise()?;
        let found = study.run_with(Some(&blocks), &source.folder(), only, monitor);
        blocks.flush().raise()?;
        match found {
            Err(StudyError::Incomplete) => Ok(false),
            found => found.map(|_| true).map_err(|error| source.exception(&error)),
        }
    })
}

/// Joins parts beside the folder `run` and, with `finish`, computes what is missing. Returns the results, or none if
/// blocks are missing, and the number of finished blocks.
#[pyfunction]
#[pyo3(signature = (study, only, seed, parts, run, finish, library))]
#[expect(clippy::too_many_arguments, reason = "the arguments of a Python function")]
pub(crate) fn merge_parts<'py>(
    py: Python<'py>,
    study: &Bound<'py, PyAny>,
    only: Option<&str>,
    seed: Option<u64>,
    parts: Vec<PathBuf>,
    run: PathBuf,
    finish: bool,
    library: PathBuf,
) -> PyResult<(Option<Bound<'py, PyDict>>, usize)> {
    let (source, study, only) = chosen(study, only, seed)?;
    let (outcome, done) = long::run(py, None, move |monitor| {
        let share = if finish { Share::All } else { Share::None };
        let blocks = RunBlocks::open(&run, record(&study, only, &library, None)?, share).raise()?;
        for part in &parts {
            blocks.import(part).raise()?;
        }
        let found = study.run_with(Some(&blocks), &source.folder(), only, monitor);
        blocks.flush().raise()?;
        let done = blocks.rounds().iter().map(|round| round.done).sum();
        match found {
            Err(StudyError::Incomplete) => Ok((None, done)),
            found => found.map(|outcome| (Some(outcome), done)).map_err(|error| source.exception(&error)),
        }
    })?;
    Ok((outcome.map(|outcome| answer(py, outcome)).transpose()?, done))
}
