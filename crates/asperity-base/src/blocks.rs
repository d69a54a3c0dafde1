//! Costly loops as plan, blocks and reduction.
//!
//! A plan is data that states the work and its number of blocks. A block depends on the plan and its index alone and returns
//! plain data, so it can be stored or computed elsewhere. Blocks run in parallel. The reduction takes them in index order, so
//! results do not depend on the number of threads. A loop whose length depends on its results is a sequence of rounds: each
//! round is planned from the results of the rounds before it.
//!
//! The loops of a [`Task`] read and store their blocks in the [`BlockStore`](crate::monitor::BlockStore) of its monitor, if it has one.

use std::cell::Cell;
use std::fmt::Display;
use std::ops::Range;
use std::sync::atomic::{AtomicBool, AtomicUsize, Ordering};
use std::sync::{Mutex, PoisonError};

use rayon::prelude::*;
use serde::Serialize;
use serde::de::DeserializeOwned;

use crate::monitor::{BlockStore, Cancelled, Monitor};

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
        self.advance(1);
        Ok(result)
    }

    /// Reports finished steps.
    pub fn advance(&self, steps: usize) {
        let done = self.done.fetch_add(steps, Ordering::Relaxed) + steps;
        self.monitor.progress(self.name, done.min(self.steps), self.steps);
    }

    /// Returns the store of a loop. The blocks of a loop inside of a parallel loop are part of the outer block.
    fn store(&self) -> Option<&'a dyn BlockStore> {
        self.monitor.store().filter(|_| rayon::current_thread_index().is_none())
    }

    /// Computes `count` blocks of one step each and returns them in index order.
    ///
    /// # Errors
    /// The error of a block, which is not stored, or the monitor cancelled.
    pub fn map<B, E>(&self, count: usize, block: impl Fn(usize) -> Result<B, E> + Sync) -> Result<Vec<B>, E>
    where
        B: Serialize + DeserializeOwned + Send,
        E: From<Cancelled> + Send,
    {
        let mut found = Vec::with_capacity(count);
        let loop_ = Loop { count, block_bytes: size_of::<B>(), steps: 1, failure: |_| None };
        self.reduce(&loop_, || (), |(), index| self.step(|| block(index))?, |_, block| found.push(block))?;
        Ok(found)
    }

    /// Computes `count` blocks that may fail, each with its reason, as [`Task::map`].
    ///
    /// # Errors
    /// The error of a block, which is not stored, or the monitor cancelled.
    pub fn try_map<T, R, E>(
        &self,
        count: usize,
        block: impl Fn(usize) -> Result<Result<T, R>, E> + Sync,
    ) -> Result<Vec<Result<T, R>>, E>
    where
        T: Serialize + DeserializeOwned + Send,
        R: Display + Serialize + DeserializeOwned + Send,
        E: From<Cancelled> + Send,
    {
        let mut found = Vec::with_capacity(count);
        let failure = |block: &Result<T, R>| block.as_ref().err().map(R::to_string);
        let loop_ = Loop { count, block_bytes: size_of::<Result<T, R>>(), steps: 1, failure };
        self.reduce(&loop_, || (), |(), index| self.step(|| block(index))?, |_, block| found.push(block))?;
        Ok(found)
    }

    /// Computes the blocks of a loop, or reads them from the store, and passes them to `add` as [`reduce`] does.
    ///
    /// # Errors
    /// The error of a block, which is not stored, or the monitor cancelled.
    pub fn reduce<W, B, E>(
        &self,
        blocks: &Loop<B>,
        workspace: impl Fn() -> W + Sync,
        block: impl Fn(&mut W, usize) -> Result<B, E> + Sync,
        mut add: impl FnMut(usize, B),
    ) -> Result<(), E>
    where
        B: Serialize + DeserializeOwned + Send,
        E: From<Cancelled> + Send,
    {
        let Loop { count, block_bytes, steps, failure } = *blocks;
        // Cancellation may end a computation in any failure, also in one that a block takes for an answer.
        let computed = |own: &mut W, index: usize| -> Result<B, E> {
            let found = block(own, index)?;
            if self.monitor.cancelled() { Err(Cancelled.into()) } else { Ok(found) }
        };
        let Some(store) = self.store() else { return reduce(count, block_bytes, workspace, computed, add) };
        let round = store.begin(self.name, count);
        // A workspace may be large and is not needed for stored blocks.
        let stored_or_computed = |own: &mut Option<W>, index: usize| -> Result<Option<B>, E> {
            if let Some(found) = store.load(round, index).and_then(|bytes| postcard::from_bytes(&bytes).ok()) {
                if self.monitor.cancelled() {
                    return Err(Cancelled.into());
                }
                self.advance(steps);
                return Ok(Some(found));
            }
            if !store.computes(round, index) {
                return Ok(None);
            }
            let found = computed(own.get_or_insert_with(&workspace), index)?;
            if let Ok(bytes) = postcard::to_allocvec(&found) {
                debug_assert!(
                    postcard::from_bytes::<B>(&bytes).is_ok(),
                    "a block of {} cannot be read again",
                    self.name
                );
                store.save(round, index, failure(&found), bytes);
            }
            Ok(Some(found))
        };
        let mut complete = true;
        reduce(
            count,
            block_bytes,
            || None,
            stored_or_computed,
            |index, block| match block {
                Some(block) if complete => add(index, block),
                _ => complete = false,
            },
        )?;
        // Blocks of other processes are missing.
        if complete { Ok(()) } else { Err(Cancelled.into()) }
    }
}

/// Loop over blocks of type `B`.
pub struct Loop<B> {
    /// Number of blocks.
    pub count: usize,
    /// Memory of a block in bytes.
    pub block_bytes: usize,
    /// Steps of the task in each block.
    pub steps: usize,
    /// Reason of the failure that a block holds.
    pub failure: fn(&B) -> Option<String>,
}

/// Collection of blocks.
pub trait Collect<B> {
    /// Returns whether `block` decides the collection, so that further blocks are not computed.
    fn stops_at(block: &B) -> bool;
    /// Collects blocks in index order.
    fn collect(blocks: Vec<B>) -> Self;
}

impl<T> Collect<T> for Vec<T> {
    fn stops_at(_: &T) -> bool {
        false
    }

    fn collect(blocks: Vec<T>) -> Self {
        blocks
    }
}

impl<T> Collect<Option<T>> for Option<Vec<T>> {
    fn stops_at(block: &Option<T>) -> bool {
        block.is_none()
    }

    fn collect(blocks: Vec<Option<T>>) -> Self {
        blocks.into_iter().collect()
    }
}

impl<T, E> Collect<Result<T, E>> for Result<Vec<T>, E> {
    fn stops_at(block: &Result<T, E>) -> bool {
        block.is_err()
    }

    fn collect(blocks: Vec<Result<T, E>>) -> Self {
        blocks.into_iter().collect()
    }
}

/// Computes blocks in parallel and collects them in index order. A collection of `Result` stops at an error, one of `Option`
/// at `None`.
pub fn map<B: Send, C: Collect<B>>(indices: Range<usize>, block: impl Fn(usize) -> B + Sync) -> C {
    map_with(indices, || (), |(), index| block(index))
}

/// Computes blocks as [`map`] does, with memory that a thread reuses from block to block. A block must not depend on what
/// blocks before it left in the workspace.
pub fn map_with<W, B: Send, C: Collect<B>>(
    indices: Range<usize>,
    workspace: impl Fn() -> W + Sync,
    block: impl Fn(&mut W, usize) -> B + Sync,
) -> C {
    let count = indices.len();
    let stopped = AtomicBool::new(false);
    // First indices of the parts that are finished, in order, and the blocks of each.
    let finished: Mutex<(Vec<usize>, Vec<Vec<B>>)> = Mutex::default();
    over_parts(indices, &|part| {
        let first = part.start;
        let mut workspace = workspace();
        let mut blocks = Vec::with_capacity(part.len());
        for index in part {
            if stopped.load(Ordering::Relaxed) {
                break;
            }
            let block = block(&mut workspace, index);
            if C::stops_at(&block) {
                stopped.store(true, Ordering::Relaxed);
            }
            blocks.push(block);
        }
        let mut finished = finished.lock().unwrap_or_else(PoisonError::into_inner);
        let place = finished.0.partition_point(|other| *other < first);
        finished.0.insert(place, first);
        finished.1.insert(place, blocks);
    });
    let (_, parts) = finished.into_inner().unwrap_or_else(PoisonError::into_inner);
    let mut blocks = Vec::with_capacity(count);
    for mut part in parts {
        blocks.append(&mut part);
    }
    C::collect(blocks)
}

/// Passes every item to `work` in parallel.
pub fn for_each<T: Send>(items: impl IntoIterator<Item = T>, work: impl Fn(T) + Sync) {
    for_each_with(items, || (), |(), item| work(item));
}

/// Passes every item to `work` as [`for_each`] does, with memory that a thread reuses from item to item.
pub fn for_each_with<W, T: Send>(
    items: impl IntoIterator<Item = T>,
    workspace: impl Fn() -> W + Sync,
    work: impl Fn(&mut W, T) + Sync,
) {
    let items: Vec<Mutex<Option<T>>> = items.into_iter().map(|item| Mutex::new(Some(item))).collect();
    over_parts(0..items.len(), &|part| {
        let mut workspace = workspace();
        for item in &items[part] {
            let item = item.lock().unwrap_or_else(PoisonError::into_inner).take();
            if let Some(item) = item {
                work(&mut workspace, item);
            }
        }
    });
}

thread_local! {
    /// Whether loops run on their own thread.
    static ALONE: Cell<bool> = const { Cell::new(false) };
}

/// Runs `work` with all its loops on this thread. Blocks that are costly and many keep every thread busy without the loops inside
/// of them, and a thread then holds the memory of one block.
pub fn on_one_thread<T>(work: impl FnOnce() -> T) -> T {
    /// Restores the state of the thread, also after a panic.
    struct Before(bool);
    impl Drop for Before {
        fn drop(&mut self) {
            ALONE.set(self.0);
        }
    }
    let _before = Before(ALONE.replace(true));
    work()
}

/// Distributes the indices over threads as contiguous parts, whose sizes depend on the work that other threads take over.
///
/// All parallel loops call this function: the code that distributes work is compiled once, not once per loop.
fn over_parts(indices: Range<usize>, work: &(dyn Fn(Range<usize>) + Sync)) {
    if ALONE.get() {
        if !indices.is_empty() {
            work(indices);
        }
        return;
    }
    let extended =
        |part: Range<usize>, index: usize| if part.is_empty() { index..index + 1 } else { part.start..index + 1 };
    indices.into_par_iter().fold(|| 0..0, extended).for_each(|part| {
        if !part.is_empty() {
            work(part);
        }
    });
}

/// Returns how many blocks of `block_bytes` each wait for [`reduce`] at most.
pub fn at_once(block_bytes: usize, threads: usize) -> usize {
    (WAITING_BYTES / block_bytes.max(1)).max(WAITING_PER_THREAD * threads)
}

/// Computes `count` blocks of `block_bytes` each as [`map_with`] does and passes them to `add` in index order. Blocks that wait
/// for `add` take at most 128 MiB, or four blocks per thread if that is more.
///
/// # Errors
/// The error of a block.
pub fn reduce<W, B: Send, E: Send>(
    count: usize,
    block_bytes: usize,
    workspace: impl Fn() -> W + Sync,
    block: impl Fn(&mut W, usize) -> Result<B, E> + Sync,
    mut add: impl FnMut(usize, B),
) -> Result<(), E> {
    let at_once = at_once(block_bytes, rayon::current_num_threads());
    for first in (0..count).step_by(at_once) {
        let group: Vec<B> = map_with::<_, _, Result<_, E>>(first..count.min(first + at_once), &workspace, &block)?;
        group.into_iter().enumerate().for_each(|(place, block)| add(first + place, block));
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::monitor::{BlockStore, RoundId, Silent};

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
    fn blocks_keep_their_order_and_every_item_is_passed_once() {
        for threads in [1, 3] {
            let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
            pool.install(|| {
                // Loops inside of loops distribute parts at irregular places.
                let inner = |index: usize| map::<_, Vec<usize>>(0..index % 7, |i| i * index).into_iter().sum::<usize>();
                let found: Vec<usize> = map(5..1000, inner);
                assert_eq!(found, (5..1000).map(|index| (0..index % 7).sum::<usize>() * index).collect::<Vec<_>>());
                let mut counts = vec![0; 1000];
                for_each(counts.chunks_mut(3).enumerate(), |(chunk, counts)| {
                    counts.iter_mut().for_each(|c| *c += chunk)
                });
                assert_eq!(counts, (0..1000).map(|index| index / 3).collect::<Vec<_>>());
                let even = |index: usize| (index != 700).then_some(2 * index);
                assert_eq!(map::<_, Option<Vec<usize>>>(0..700, even), Some((0..700).map(|i| 2 * i).collect()));
                assert_eq!(map::<_, Option<Vec<usize>>>(0..1000, even), None);
                assert_eq!(map::<_, Vec<usize>>(3..3, |i| i), [0; 0]);
            });
        }
    }

    #[test]
    fn loops_on_one_thread_stay_on_it_and_give_the_same() {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(3).build().unwrap();
        let inner = |index: usize| -> Vec<usize> { map(0..50, |i| i * index) };
        let thread = || rayon::current_thread_index();
        pool.install(|| {
            let wanted: Vec<Vec<usize>> = map(0..20, inner);
            let alone: Vec<(Vec<usize>, bool)> = map(0..20, |index| {
                let own = thread();
                on_one_thread(|| {
                    let threads: Vec<Option<usize>> = map(0..50, |_| thread());
                    (inner(index), threads.iter().all(|thread| *thread == own))
                })
            });
            assert!(alone.iter().all(|(_, own)| *own));
            assert_eq!(alone.into_iter().map(|(found, _)| found).collect::<Vec<_>>(), wanted);
            assert!(!ALONE.get());
        });
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
    #[test]
    fn a_block_that_ends_after_cancellation_is_not_stored() {
        /// Cancels in the fourth block that is computed, and counts the stored blocks.
        #[derive(Default)]
        struct Store(AtomicUsize, AtomicUsize);
        impl Monitor for Store {
            fn progress(&self, _what: &str, _done: usize, _total: usize) {}
            fn cancelled(&self) -> bool {
                self.0.load(Ordering::Relaxed) > 3
            }
            fn store(&self) -> Option<&dyn BlockStore> {
                Some(self)
            }
        }
        impl BlockStore for Store {
            fn begin(&self, _name: &str, _count: usize) -> RoundId {
                RoundId(0)
            }
            fn load(&self, _round: RoundId, _index: usize) -> Option<Vec<u8>> {
                None
            }
            fn save(&self, _round: RoundId, _index: usize, _failure: Option<String>, bytes: Vec<u8>) {
                assert_eq!(postcard::from_bytes::<Option<()>>(&bytes), Ok(Some(())));
                self.1.fetch_add(1, Ordering::Relaxed);
            }
            fn computes(&self, _round: RoundId, _index: usize) -> bool {
                true
            }
        }
        let store = Store::default();
        let block = |_| {
            store.0.fetch_add(1, Ordering::Relaxed);
            // A cancelled computation inside of the block finds nothing.
            Ok::<Option<()>, Cancelled>((!store.cancelled()).then_some(()))
        };
        assert_eq!(Task::new(&store, "blocks", 50).map(50, block), Err(Cancelled));
        assert!(store.1.into_inner() <= 3);
    }
}
