//! Thread that writes finished blocks.
//!
//! The computation does not wait for the disk: blocks are queued, and the thread writes all that wait as one file per
//! stage. Files are some seconds apart, so a lost process loses little and the disk synchronises seldom.

use std::collections::BTreeMap;
use std::path::PathBuf;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, Condvar, Mutex, MutexGuard, PoisonError};
use std::thread::JoinHandle;
use std::time::{Duration, Instant};

use super::file::{self, Block, Round};
use crate::study::StoreError;

/// Bytes of waiting blocks at which they are written, and at which the computation waits.
const WRITTEN_BYTES: usize = 1 << 24;
const MOST_BYTES: usize = 1 << 27;
/// Times between two files: a hundredth of the time that has passed, within these limits. A lost process loses a hundredth
/// of its work, and a long one leaves some hundred files.
const SHORTEST: Duration = Duration::from_secs(1);
const LONGEST: Duration = Duration::from_secs(60);
const SHARE: u32 = 100;

#[derive(Debug, Default)]
struct Queue {
    /// Waiting blocks by folder, with the rounds that they belong to.
    waiting: BTreeMap<PathBuf, (Vec<Round>, Vec<Block>)>,
    bytes: usize,
    /// Whether a file is being written.
    writing: bool,
    /// Whether to write without delay.
    flush: bool,
    ended: bool,
    error: Option<StoreError>,
}

#[derive(Debug, Default)]
struct Shared {
    queue: Mutex<Queue>,
    changed: Condvar,
    failed: AtomicBool,
}

impl Shared {
    fn lock(&self) -> MutexGuard<'_, Queue> {
        self.queue.lock().unwrap_or_else(PoisonError::into_inner)
    }

    fn wait<'a>(&self, queue: MutexGuard<'a, Queue>) -> MutexGuard<'a, Queue> {
        self.changed.wait(queue).unwrap_or_else(PoisonError::into_inner)
    }

    /// Writes blocks until the writer ends.
    fn run(&self) {
        let started = Instant::now();
        let mut last = started;
        let mut queue = self.lock();
        loop {
            let interval = (started.elapsed() / SHARE).clamp(SHORTEST, LONGEST);
            let left = interval.saturating_sub(last.elapsed());
            let urgent = queue.ended || queue.flush || queue.bytes >= WRITTEN_BYTES;
            if queue.waiting.is_empty() {
                if queue.ended {
                    return;
                }
                queue.flush = false;
                queue = self.wait(queue);
            } else if urgent || left.is_zero() {
                let waiting = std::mem::take(&mut queue.waiting);
                (queue.bytes, queue.writing) = (0, true);
                drop(queue);
                let written = waiting.into_iter().try_for_each(|(folder, (rounds, blocks))| {
                    file::write(&folder, rounds, &blocks)
                        .map(|_| ())
                        .map_err(|source| StoreError::Io { path: folder, source })
                });
                last = Instant::now();
                queue = self.lock();
                queue.writing = false;
                if let Err(error) = written {
                    queue.error.get_or_insert(error);
                    self.failed.store(true, Ordering::SeqCst);
                }
                self.changed.notify_all();
            } else {
                queue = self.changed.wait_timeout(queue, left).unwrap_or_else(PoisonError::into_inner).0;
            }
        }
    }
}

/// Writer of the blocks of a run.
#[derive(Debug)]
pub(super) struct Writer {
    shared: Arc<Shared>,
    thread: Option<JoinHandle<()>>,
}

impl Writer {
    pub(super) fn start() -> std::io::Result<Self> {
        let shared = Arc::new(Shared::default());
        let own = Arc::clone(&shared);
        let thread = std::thread::Builder::new().name("blocks".into()).spawn(move || own.run())?;
        Ok(Self { shared, thread: Some(thread) })
    }

    /// Queues a block. Waits while too many bytes are queued.
    pub(super) fn add(&self, folder: &PathBuf, round: &Round, block: Block) {
        let mut queue = self.shared.lock();
        while queue.bytes > MOST_BYTES && queue.error.is_none() {
            queue = self.shared.wait(queue);
        }
        if queue.error.is_some() {
            return;
        }
        queue.bytes += block.bytes.len() + size_of::<Block>();
        if !queue.waiting.contains_key(folder) {
            queue.waiting.insert(folder.clone(), (Vec::new(), Vec::new()));
        }
        if let Some((rounds, blocks)) = queue.waiting.get_mut(folder) {
            if rounds.last() != Some(round) && !rounds.contains(round) {
                rounds.push(round.clone());
            }
            blocks.push(block);
        }
        self.shared.changed.notify_all();
    }

    /// Returns whether a file could not be written.
    pub(super) fn failed(&self) -> bool {
        self.shared.failed.load(Ordering::SeqCst)
    }

    /// Waits until all queued blocks are on the disk.
    pub(super) fn flush(&self) -> Result<(), StoreError> {
        let mut queue = self.shared.lock();
        queue.flush = true;
        self.shared.changed.notify_all();
        while (!queue.waiting.is_empty() || queue.writing) && queue.error.is_none() {
            queue = self.shared.wait(queue);
        }
        queue.error.take().map_or(Ok(()), Err)
    }
}

impl Drop for Writer {
    fn drop(&mut self) {
        self.shared.lock().ended = true;
        self.shared.changed.notify_all();
        if let Some(thread) = self.thread.take() {
            let _ = thread.join();
        }
    }
}
