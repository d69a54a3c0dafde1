//! Parts of a study or a campaign on several machines: blocks that a worker computes, and the results of all parts.

use std::path::{Path, PathBuf};

use asperity::choice::Choice;
use asperity::monitor::Cancelled;
use asperity::study::{Computation, Others, RunBlocks, RunRecord, Share, Stage, StudyError, program};
use pyo3::prelude::*;
use pyo3::types::PyDict;

use crate::convert::to_python;
use crate::errors::{Raise, exception};
use crate::long;
use crate::study::{Request, answer, compute_stored, failed};

type Dictionary<'py> = Option<Bound<'py, PyDict>>;

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

/// Computes as `compute` does, with blocks beside `run` and in `parts`, until a loop that `threads` threads elsewhere finish earlier: in
/// `count` parts, or as many as follow from the work, of which the first begins after `start_s` seconds. Returns the results or that loop.
#[pyfunction]
#[pyo3(signature = (request, progress, run, out, parts, threads, count, start_s))]
#[expect(clippy::too_many_arguments, reason = "what a caller in Python passes by name")]
pub(crate) fn compute_or_leave<'py>(
    py: Python<'py>,
    request: Request<'py>,
    progress: Option<Bound<'py, PyAny>>,
    run: PathBuf,
    out: Option<PathBuf>,
    parts: Vec<PathBuf>,
    threads: usize,
    count: Option<usize>,
    start_s: f64,
) -> PyResult<(Dictionary<'py>, Dictionary<'py>)> {
    let (computation, library) = (request.computation()?, request.library);
    let share = Share::UnlessFaster(Others { threads, parts: count, start_s });
    let found = long::run(py, progress.as_ref(), move |monitor| {
        let found = compute_stored(&computation, &library, &run, out.as_deref(), share, &parts, monitor)?;
        Ok(found.map_err(|blocks| (blocks.left(), blocks.stage_folders())))
    })?;
    let (left, folders) = match found {
        Ok(computed) => return Ok((Some(answer(py, computed)?), None)),
        Err((left, folders)) => (left.ok_or_else(|| exception(&Cancelled))?, folders),
    };
    let loop_ = PyDict::new(py);
    loop_.set_item("name", left.name)?;
    // The stage of a campaign is its own.
    loop_.set_item("only", Stage::from_name(&left.stage).ok().map(|stage| stage.name()))?;
    loop_.set_item("folders", folders)?;
    loop_.set_item("parts", left.parts)?;
    loop_.set_item("left_s", left.left_s)?;
    Ok((None, Some(loop_)))
}
