//! Thread that writes finished blocks.
//!
//! The computation does not wait for the disk: blocks are queued, and the thread writes all that wait as one file per
//! stage. Files are some time apart, so a lost process loses little and the disk synchronises seldom.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, Condvar, Mutex, MutexGuard, PoisonError};
use std::thread::JoinHandle;
use std::time::{Duration, Instant};

use super::file::{self, Block, Round};
use super::record::RunRecord;
use crate::StoreError;

/// Bytes of waiting blocks at which they are written, and at which the computation waits.
const WRITTEN_BYTES: usize = 1 << 24;
const MOST_BYTES: usize = 1 << 27;
/// Times between two files: a hundredth of the time that has passed, within these limits. A lost process loses a hundredth
/// of its work, and a long one leaves some hundred files.
const SHORTEST: Duration = Duration::from_millis(100);
const LONGEST: Duration = Duration::from_secs(60);
const SHARE: u32 = 100;

#[derive(Debug, Default)]
struct Queue {
    /// Waiting blocks by folder, with the rounds that they belong to.
    waiting: BTreeMap<PathBuf, (Vec<Round>, Vec<Block>)>,
    bytes: usize,
    /// Record of the run to write before the next blocks.
    record: Option<RunRecord>,
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
    fn run(&self, path: &Path) {
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
                let (waiting, record) = (std::mem::take(&mut queue.waiting), queue.record.take());
                (queue.bytes, queue.writing) = (0, true);
                drop(queue);
                let mut written = record.map_or(Ok(()), |record| record.write(path));
                for (folder, (rounds, blocks)) in waiting {
                    let write = |()| file::write(&folder, rounds, &blocks);
                    written = written
                        .and_then(|()| write(()).map_err(|source| StoreError::Io { path: folder.clone(), source }));
                }
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
    /// Starts the thread of a run whose record has this path.
    pub(super) fn start(path: PathBuf) -> std::io::Result<Self> {
        let shared = Arc::new(Shared::default());
        let own = Arc::clone(&shared);
        let thread = std::thread::Builder::new().name("blocks".into()).spawn(move || own.run(&path))?;
        Ok(Self { shared, thread: Some(thread) })
    }

    /// Writes the record of the run before the next blocks.
    pub(super) fn set_record(&self, record: RunRecord) {
        self.shared.lock().record = Some(record);
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
        // The thread waits for the first block, then for the time of the next file or many bytes.
        let is_first = queue.waiting.is_empty();
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
        if is_first || queue.bytes >= WRITTEN_BYTES {
            self.shared.changed.notify_all();
        }
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
