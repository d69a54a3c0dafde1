//! Parts of a study or a campaign on several machines: blocks that a worker computes, and the results of all parts.

use std::path::{Path, PathBuf};

use asperity::study::{Computation, RunBlocks, RunRecord, Share, StudyError, program};
use pyo3::prelude::*;
use pyo3::types::PyDict;

use crate::convert::to_python;
use crate::errors::Raise;
use crate::long;
use crate::study::{Request, answer, failed};

fn record(computation: &Computation, library: &Path, shard: Option<[usize; 2]>) -> PyResult<RunRecord> {
    computation.record(program(library, String::new()).raise()?, shard).raise()
}

/// Returns the file of this module and its libraries on this machine, which determine the last bits of results.
#[pyfunction]
pub(crate) fn module_program(py: Python<'_>, library: PathBuf) -> PyResult<Bound<'_, PyAny>> {
    to_python(py, &program(&library, String::new()).raise()?)
}

/// Computes a part, number and count, of the blocks that can be computed now, into a folder. Blocks in the folder above
/// it are used. Returns whether all are known.
#[pyfunction]
pub(crate) fn study_part(
    py: Python<'_>,
    request: Request<'_>,
    part: (usize, usize),
    folder: PathBuf,
) -> PyResult<bool> {
    let (computation, library) = (request.computation()?, request.library);
    long::run(py, None, move |monitor| {
        let (number, of) = part;
        let record = record(&computation, &library, Some([number, of]))?;
        let blocks = RunBlocks::open(&folder, record, Share::Part { number, of }).raise()?;
        let found = computation.compute(Some(&blocks), monitor);
        blocks.flush().raise()?;
        match found {
            Err(StudyError::Incomplete) => Ok(false),
            found => found.map(|_| true).map_err(|error| failed(&computation, &error)),
        }
    })
}

/// Joins parts beside the folder `run` and, with `finish`, computes what is missing. Returns the results, or none if
/// blocks are missing, and the number of finished blocks.
#[pyfunction]
pub(crate) fn merge_parts<'py>(
    py: Python<'py>,
    request: Request<'py>,
    parts: Vec<PathBuf>,
    run: PathBuf,
    finish: bool,
) -> PyResult<(Option<Bound<'py, PyDict>>, usize)> {
    let (computation, library) = (request.computation()?, request.library);
    let (computed, done) = long::run(py, None, move |monitor| {
        let share = if finish { Share::All } else { Share::None };
        let blocks = RunBlocks::open(&run, record(&computation, &library, None)?, share).raise()?;
        for part in &parts {
            blocks.import(part).raise()?;
        }
        let found = computation.compute(Some(&blocks), monitor);
        blocks.flush().raise()?;
        let done = blocks.rounds().iter().map(|round| round.done).sum();
        match found {
            Err(StudyError::Incomplete) => Ok((None, done)),
            found => found.map(|found| (Some(found), done)).map_err(|error| failed(&computation, &error)),
        }
    })?;
    Ok((computed.map(|found| answer(py, found)).transpose()?, done))
}
