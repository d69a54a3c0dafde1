//! Threads of computations in forked processes.
//!
//! A process that Python forks has none of the threads of its parent, and rayon's own pool would wait for them for ever. So a
//! forked process computes in a pool of its own.

use std::process;
use std::sync::{Arc, Mutex, OnceLock, PoisonError};

use pyo3::prelude::*;
use rayon::{ThreadPool, ThreadPoolBuilder};

use crate::errors::ResourceError;

/// Process that loaded the module.
static LOADED_BY: OnceLock<u32> = OnceLock::new();
/// Pool of a forked process, with the number of that process.
static FORKED: Mutex<Option<(u32, Arc<ThreadPool>)>> = Mutex::new(None);

/// Records the process that loads the module.
pub(crate) fn loaded() {
    LOADED_BY.get_or_init(process::id);
}

/// Computes on threads that exist.
pub(crate) fn compute<T: Send>(compute: impl FnOnce() -> PyResult<T> + Send) -> PyResult<T> {
    let own = process::id();
    if LOADED_BY.get() == Some(&own) {
        return compute();
    }
    let mut forked = FORKED.lock().unwrap_or_else(PoisonError::into_inner);
    let pool = match forked.as_ref() {
        Some((process, pool)) if *process == own => Arc::clone(pool),
        _ => {
            let pool = ThreadPoolBuilder::new().build().map_err(|error| ResourceError::new_err(error.to_string()))?;
            let pool = Arc::new(pool);
            // The pool of the parent has no threads here; to end it would wait for them.
            std::mem::forget(forked.replace((own, Arc::clone(&pool))));
            pool
        }
    };
    drop(forked);
    pool.install(compute)
}

/// Computes without the interpreter lock, in a time too short for Ctrl-C.
pub(crate) fn detached<T: Send>(py: Python<'_>, work: impl FnOnce() -> PyResult<T> + Send) -> PyResult<T> {
    py.detach(|| compute(work))
}
