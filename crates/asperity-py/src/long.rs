//! Long computations: progress and Ctrl-C.
//!
//! Python runs its signal handlers on the main thread, and only while that thread executes Python. The library computes
//! on the threads of rayon, and a thread that waits for them executes nothing. So `run` computes on a thread of its
//! own, while the calling thread wakes twenty times a second, runs the signal handlers and reports progress.
//!
//! If a handler or the progress callback raises, the computation is cancelled. The caller gets the exception at the
//! latest 0.3 s later. A block that is not finished by then ends in the background, and its result is dropped.

use std::mem;
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::mpsc::{RecvTimeoutError, sync_channel};
use std::sync::{Arc, Mutex, PoisonError};
use std::thread;
use std::time::{Duration, Instant};

use asperity::map::HeightMap;
use asperity::monitor::{Monitor, Silent};
use pyo3::exceptions::PyRuntimeError;
use pyo3::prelude::*;

use crate::errors::refused;
use crate::pool;

/// Time between two looks at the signals.
const TICK: Duration = Duration::from_millis(50);
/// Time that a cancelled computation gets to end.
const GRACE: Duration = Duration::from_millis(300);
/// Time after which a computation may have freed much memory.
const LONG: Duration = Duration::from_millis(100);
/// Stack of the computation in bytes, as on the main thread.
const STACK: usize = 8 << 20;

/// Largest grid that takes milliseconds: it needs no thread, which would take longer to start.
const SMALL_POINTS: usize = 1 << 12;

/// State that the computation and the calling thread share.
#[derive(Default)]
struct Shared {
    cancelled: AtomicBool,
    tasks: Mutex<Vec<Task>>,
}

/// Progress of one task.
struct Task {
    what: String,
    done: usize,
    total: usize,
    changed: bool,
}

impl Monitor for Shared {
    fn progress(&self, what: &str, done: usize, total: usize) {
        let mut tasks = self.tasks.lock().unwrap_or_else(PoisonError::into_inner);
        match tasks.iter_mut().find(|task| task.what == what) {
            // Reports come in any order; a small one after the end begins the task anew.
            Some(task) if task.total == total && done < task.done && !(task.done == total && done <= total / 2) => {}
            Some(task) => (task.done, task.total, task.changed) = (done, total, true),
            None => tasks.push(Task { what: what.to_owned(), done, total, changed: true }),
        }
    }

    fn cancelled(&self) -> bool {
        self.cancelled.load(Ordering::Relaxed)
    }
}

impl Shared {
    /// Passes what changed to the callback.
    fn report(&self, callback: Option<&Bound<'_, PyAny>>) -> PyResult<()> {
        let Some(callback) = callback else { return Ok(()) };
        let changed: Vec<_> = {
            let mut tasks = self.tasks.lock().unwrap_or_else(PoisonError::into_inner);
            let changed =
                |task: &mut Task| mem::take(&mut task.changed).then(|| (task.what.clone(), task.done, task.total));
            tasks.iter_mut().filter_map(changed).collect()
        };
        changed.into_iter().try_for_each(|report| callback.call1(report).map(drop))
    }
}

/// Runs a computation on a map as [`run_sized`] does.
pub(crate) fn run_on_map<T: Send + 'static>(
    py: Python<'_>,
    map: HeightMap,
    compute: impl FnOnce(HeightMap) -> PyResult<T> + Send + 'static,
) -> PyResult<T> {
    run_sized(py, map.grid().points(), |_| compute(map))
}

/// Runs a computation on a grid of `points` without the interpreter lock, a small one on this thread.
pub(crate) fn run_sized<T: Send + 'static>(
    py: Python<'_>,
    points: usize,
    compute: impl FnOnce(&dyn Monitor) -> PyResult<T> + Send + 'static,
) -> PyResult<T> {
    if points <= SMALL_POINTS { pool::detached(py, || compute(&Silent)) } else { run(py, None, compute) }
}

/// Runs a computation without the interpreter lock. `progress` is a callable of the task, the blocks done and all blocks.
pub(crate) fn run<T: Send + 'static>(
    py: Python<'_>,
    progress: Option<&Bound<'_, PyAny>>,
    compute: impl FnOnce(&dyn Monitor) -> PyResult<T> + Send + 'static,
) -> PyResult<T> {
    let shared = Arc::new(Shared::default());
    let (sender, mut receiver) = sync_channel(1);
    let monitor = Arc::clone(&shared);
    let computation = move || {
        let found = catch_unwind(AssertUnwindSafe(|| pool::compute(|| compute(&*monitor))));
        // Nobody waits for a cancelled computation.
        let _ = sender.send(found);
    };
    let started = thread::Builder::new().name("asperity".into()).stack_size(STACK).spawn(computation);
    started.map_err(|error| refused("cannot start a thread", &error))?;
    let receiver = &mut receiver;
    let start = Instant::now();
    loop {
        let channel = &mut *receiver;
        match py.detach(move || channel.recv_timeout(TICK)) {
            Ok(Ok(found)) => {
                if found.is_ok() {
                    shared.report(progress)?;
                }
                if start.elapsed() > LONG {
                    py.detach(return_free_memory);
                }
                return found;
            }
            Ok(Err(_)) | Err(RecvTimeoutError::Disconnected) => {
                return Err(PyRuntimeError::new_err("internal error; the message above says where"));
            }
            Err(RecvTimeoutError::Timeout) => {
                if let Err(raised) = py.check_signals().and_then(|()| shared.report(progress)) {
                    shared.cancelled.store(true, Ordering::Relaxed);
                    let channel = &mut *receiver;
                    let _ = py.detach(move || channel.recv_timeout(GRACE));
                    return Err(raised);
                }
            }
        }
    }
}

/// Returns memory to the system that glibc keeps for the threads of a computation.
fn return_free_memory() {
    #[cfg(all(target_os = "linux", target_env = "gnu"))]
    #[expect(unsafe_code, reason = "a function of libc that takes no pointer")]
    // SAFETY: malloc_trim may be called at any time, from any thread.
    unsafe {
        libc::malloc_trim(0);
    }
}
