//! Costly loops as plan, blocks and reduction.
//!
//! A plan is data that states the work and its number of blocks. A block depends on the plan and its index alone and returns
//! plain data, so it can be stored or computed elsewhere. Blocks run in parallel. The reduction takes them in index order, so
//! results do not depend on the number of threads. A loop whose length depends on its results is a sequence of rounds: each
//! round is planned from the results of the rounds before it.

use std::ops::Range;
use std::sync::atomic::{AtomicUsize, Ordering};

use rayon::prelude::*;

use crate::monitor::{Cancelled, Monitor};

/// Memory limit in bytes for blocks that wait for [`reduce`].
const WAITING_BYTES: usize = 1 << 27;
/// Smallest number of waiting blocks per thread, so that threads are seldom idle at the end of a group of blocks.
const WAITING_PER_THREAD: usize = 4;

/// Task of several steps, whose progress a [`Monitor`] observes and which it can cancel.
pub struct Task<'a> {
    monitor: &'a dyn Monitor,
    name: &'a str,
    steps: usize,
    done: AtomicUsize,
}

impl<'a> Task<'a> {
    /// Creates a task with a number of steps; the monitor reports it by its name.
    pub fn new(monitor: &'a dyn Monitor, name: &'a str, steps: usize) -> Self {
        Self { monitor, name, steps, done: AtomicUsize::new(0) }
    }

    /// Computes one step and reports it. Steps may run on any thread, in any order.
    ///
    /// # Errors
    /// The monitor cancelled before the step.
    pub fn step<T>(&self, compute: impl FnOnce() -> T) -> Result<T, Cancelled> {
        if self.monitor.cancelled() {
            return Err(Cancelled);
        }
        let result = compute();
        self.monitor.progress(self.name, self.done.fetch_add(1, Ordering::Relaxed) + 1, self.steps);
        Ok(result)
    }
}

/// Computes blocks in parallel and collects them in index order. A collection of `Result` stops at an error.
pub fn map<B: Send, C: FromParallelIterator<B>>(indices: Range<usize>, block: impl Fn(usize) -> B + Sync + Send) -> C {
    indices.into_par_iter().map(block).collect()
}

/// Computes blocks as [`map`] does, with memory that a thread reuses from block to block. A block must not depend on what
/// blocks before it left in the workspace.
pub fn map_with<W, B: Send, C: FromParallelIterator<B>>(
    indices: Range<usize>,
    workspace: impl Fn() -> W + Sync + Send,
    block: impl Fn(&mut W, usize) -> B + Sync + Send,
) -> C {
    indices.into_par_iter().map_init(workspace, block).collect()
}

/// Computes `count` blocks of `block_bytes` each as [`map_with`] does and passes them to `add` in index order. Blocks that wait
/// for `add` take at most 128 MiB, or four blocks per thread if that is more.
///
/// # Errors
/// The error of a block.
pub fn reduce<W, B: Send, E: Send>(
    count: usize,
    block_bytes: usize,
    workspace: impl Fn() -> W + Sync + Send,
    block: impl Fn(&mut W, usize) -> Result<B, E> + Sync + Send,
    mut add: impl FnMut(usize, B),
) -> Result<(), E> {
    let at_once = (WAITING_BYTES / block_bytes.max(1)).max(WAITING_PER_THREAD * rayon::current_num_threads());
    for first in (0..count).step_by(at_once) {
        let group: Vec<B> = map_with::<_, _, Result<_, E>>(first..count.min(first + at_once), &workspace, &block)?;
        group.into_iter().enumerate().for_each(|(place, block)| add(first + place, block));
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::monitor::Silent;

    /// Returns the indices in the order of the reduction, and the largest number of blocks that were computed but not yet added.
    fn reduced(count: usize, block_bytes: usize, threads: usize) -> (Vec<usize>, usize) {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        let (computed, mut added, mut waiting) = (AtomicUsize::new(0), Vec::new(), 0);
        let block = |buffer: &mut Vec<usize>, index: usize| {
            computed.fetch_add(1, Ordering::Relaxed);
            buffer.push(index);
            Ok::<usize, Cancelled>(index * index)
        };
        let add = |index: usize, square: usize| {
            assert_eq!(square, index * index);
            waiting = waiting.max(computed.load(Ordering::Relaxed) - added.len());
            added.push(index);
        };
        pool.install(|| reduce(count, block_bytes, Vec::new, block, add)).unwrap();
        (added, waiting)
    }

    #[test]
    fn blocks_are_added_in_order_and_few_large_ones_wait() {
        for threads in [1, 3] {
            let wanted: Vec<usize> = (0..100).collect();
            assert_eq!(reduced(100, 8, threads), (wanted.clone(), 100));
            assert_eq!(reduced(100, WAITING_BYTES / 20, threads), (wanted.clone(), 20));
            assert_eq!(reduced(100, WAITING_BYTES, threads), (wanted, 4 * threads));
        }
        assert_eq!(reduced(0, 8, 1).0, [0; 0]);
    }

    #[test]
    fn progress_reaches_the_number_of_steps() {
        struct Last(AtomicUsize);
        impl Monitor for Last {
            fn progress(&self, what: &str, done: usize, total: usize) {
                assert_eq!((what, total), ("squares", 50));
                self.0.fetch_max(done, Ordering::Relaxed);
            }
            fn cancelled(&self) -> bool {
                false
            }
        }
        let last = Last(AtomicUsize::new(0));
        let task = Task::new(&last, "squares", 50);
        let squares: Result<Vec<usize>, Cancelled> = map(0..50, |index| task.step(|| index * index));
        assert_eq!(squares.unwrap(), (0..50).map(|index| index * index).collect::<Vec<_>>());
        assert_eq!(last.0.load(Ordering::Relaxed), 50);
    }

    #[test]
    fn no_step_runs_after_cancellation_and_no_block_is_added_after_an_error() {
        struct CancelledAfter(usize, AtomicUsize);
        impl Monitor for CancelledAfter {
            fn progress(&self, _what: &str, _done: usize, _total: usize) {
                self.1.fetch_add(1, Ordering::Relaxed);
            }
            fn cancelled(&self) -> bool {
                self.1.load(Ordering::Relaxed) >= self.0
            }
        }
        let pool = rayon::ThreadPoolBuilder::new().num_threads(2).build().unwrap();
        let monitor = CancelledAfter(10, AtomicUsize::new(0));
        let task = Task::new(&monitor, "blocks", 1000);
        let result: Result<Vec<()>, Cancelled> = pool.install(|| map(0..1000, |_| task.step(|| ())));
        assert_eq!(result, Err(Cancelled));
        // The other thread may have begun a step.
        assert!(monitor.1.load(Ordering::Relaxed) <= 11);
        let task = Task::new(&Silent, "blocks", 30);
        let mut added = 0;
        let block = |_: &mut (), index: usize| {
            task.step(|| index).map_err(|_| 0).and_then(|i| if i < 25 { Ok(i) } else { Err(i) })
        };
        let error = pool.install(|| reduce(30, WAITING_BYTES / 10, || (), block, |_, _| added += 1)).unwrap_err();
        assert!((25..30).contains(&error) && added == 20, "{error} {added}");
    }
}
