//! Finished blocks of a run, in files beside it, from which an interrupted run goes on.
//!
//! The blocks of the run `runs/brake` are in `runs/.asperity-blocks`: a folder per stage, named by the hash of what the stage depends
//! on, and a record of each run. A study whose vibration changes therefore finds the blocks of its contact stages again.

mod file;
mod others;
mod record;
mod writer;

use std::collections::{BTreeMap, HashMap};
use std::fmt;
use std::fs;
use std::io::Write;
use std::path::{Path, PathBuf};
use std::str::FromStr;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Mutex, MutexGuard, PoisonError};

use asperity_base::monitor::{BlockStore, Monitor, RoundId};
use asperity_formats::{check_writable, remove_abandoned_files, replace_file};
use serde::Serialize;
use sha2::{Digest, Sha256};

#[cfg(fuzzing)]
pub use self::file::read_blocks;
pub use self::file::sha256;
use self::file::{Block, Entry, Round};
use self::others::Clock;
pub use self::others::{LeftLoop, Others};
pub use self::record::{RunRecord, program, program_difference};
use self::writer::Writer;
use crate::StoreError;

/// Name of the folder of blocks beside a run.
const FOLDER: &str = ".asperity-blocks";

/// Returns the SHA-256 of a value in its serialised form. Types of the value must serialise all their fields.
///
/// # Errors
/// The value cannot be serialised.
pub fn key_of(value: &impl Serialize) -> Result<String, StoreError> {
    postcard::to_allocvec(value).map(|bytes| sha256(&bytes)).map_err(StoreError::content)
}

/// Blocks that a process computes.
#[derive(Debug, Clone, PartialEq)]
pub enum Share {
    /// All that are missing.
    All,
    /// All that are missing, up to a loop that others finish earlier: see [`RunBlocks::left`].
    UnlessFaster(Others),
    /// Those whose index has the remainder `number − 1` by `of`.
    Part {
        /// Number of this part, from 1.
        number: usize,
        /// Number of all parts.
        of: usize,
    },
    /// None: stored blocks only.
    None,
    /// One block again; all others if they are missing.
    Again(BlockPlace),
}

/// Blocks of one loop.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct RoundState {
    /// Stage of the loop: that of a study, or `campaign`.
    pub stage: String,
    /// Name of the loop.
    pub name: String,
    /// Number of its blocks.
    pub expected: usize,
    /// Number of finished blocks.
    pub done: usize,
    /// Number of finished blocks that hold the reason of a failure.
    pub failed: usize,
}

/// Place of a block in a run. Its text is `TASK:INDEX`, or `TASK#N:INDEX` in the loop number N, from 2, of a task.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct BlockPlace {
    /// Name of the loop.
    pub task: String,
    /// Number of the earlier loops of the stage with this name.
    pub ordinal: u64,
    /// Index of the block.
    pub index: usize,
}

impl fmt::Display for BlockPlace {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self.ordinal {
            0 => write!(f, "{}:{}", self.task, self.index),
            ordinal => write!(f, "{}#{}:{}", self.task, ordinal + 1, self.index),
        }
    }
}

impl FromStr for BlockPlace {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let refused = || format!("`{text}` is no sample; write TASK:INDEX as `asperity status` does");
        let (task, index) = text.rsplit_once(':').ok_or_else(refused)?;
        let index = index.parse().map_err(|_| refused())?;
        let numbered = task.rsplit_once('#').and_then(|(task, number)| Some((task, number.parse::<u64>().ok()?)));
        let (task, number) = numbered.unwrap_or((task, 1));
        let ordinal = number.checked_sub(1).ok_or_else(refused)?;
        Ok(Self { task: task.to_owned(), ordinal, index })
    }
}

/// Finished block that holds the reason of a failure.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct FailedBlock {
    /// Stage of the loop.
    pub stage: String,
    /// Place of the block.
    pub place: BlockPlace,
    /// Reason of the failure; the first of several.
    pub reason: String,
}

/// Block that was computed again.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Replay {
    /// Reason of its failure, if it fails.
    pub failure: Option<String>,
    /// Whether the stored block, if there is one, has the same bytes.
    pub identical: Option<bool>,
}

/// Blocks of a run that is computed.
#[derive(Debug)]
pub struct RunBlocks {
    folder: PathBuf,
    /// Folders of blocks that are read as well.
    beside: Vec<PathBuf>,
    share: Share,
    record: Mutex<RunRecord>,
    path: PathBuf,
    writer: Writer,
    /// Rounds in their order.
    rounds: Mutex<Vec<RoundState>>,
    /// Whether a block of another part was missing.
    awaits: AtomicBool,
    replay: Mutex<Option<Replay>>,
    clock: Mutex<Clock>,
}

fn lock<T>(mutex: &Mutex<T>) -> MutexGuard<'_, T> {
    mutex.lock().unwrap_or_else(PoisonError::into_inner)
}

impl RunBlocks {
    /// Opens the blocks of the run in the folder `run`, which need not exist. The blocks of a part are in its own folder. Nothing is
    /// written before the first block.
    ///
    /// # Errors
    /// The folder of the blocks exists but cannot be written, or no thread can be started.
    pub fn open(run: &Path, mut record: RunRecord, share: Share) -> Result<Self, StoreError> {
        let shared = beside(run);
        let (folder, beside) = match share {
            Share::Part { .. } => (run.join(FOLDER), vec![shared]),
            _ => (shared, Vec::new()),
        };
        let computes = !matches!(share, Share::None | Share::Again(_));
        if computes && fs::symlink_metadata(&folder).is_ok() {
            // This also removes files that ended processes left.
            check_writable(&folder).map_err(|source| StoreError::Io { path: folder.clone(), source })?;
        }
        let path = RunRecord::path(&folder, run);
        record.earlier = RunRecord::read(&path).iter().flat_map(RunRecord::folders).cloned().collect();
        let writer = Writer::start(path.clone()).map_err(|source| StoreError::Io { path: folder.clone(), source })?;
        Ok(Self {
            folder,
            beside,
            share,
            record: Mutex::new(record),
            path,
            writer,
            rounds: Mutex::default(),
            awaits: AtomicBool::new(false),
            replay: Mutex::default(),
            clock: Mutex::new(Clock::start()),
        })
    }

    /// Begins a stage, a function of `input` alone: its blocks are found again by the [`key_of`] the input.
    ///
    /// # Errors
    /// The input cannot be serialised.
    pub fn stage<'a>(
        &'a self,
        stage: &str,
        input: &impl Serialize,
        monitor: &'a dyn Monitor,
    ) -> Result<StageBlocks<'a>, StoreError> {
        let mut record = lock(&self.record);
        let name = key_of(&(&record.program, stage, input))?[..32].to_owned();
        let folder = self.folder.join(&name);
        remove_abandoned_files(&folder);
        let known = Known::read(self.beside.iter().map(|other| other.join(&name)).chain([folder.clone()]));
        record.stages.push((stage.to_owned(), name));
        self.writer.set_record(record.clone());
        Ok(StageBlocks { run: self, stage: stage.to_owned(), folder, monitor, known, begun: Mutex::default() })
    }

    /// Returns the rounds that were begun, in their order.
    pub fn rounds(&self) -> Vec<RoundState> {
        lock(&self.rounds).clone()
    }

    /// Returns whether blocks could not be written.
    pub fn failed(&self) -> bool {
        self.writer.failed()
    }

    /// Returns whether blocks of other parts are missing.
    pub fn is_incomplete(&self) -> bool {
        self.awaits.load(Ordering::SeqCst)
    }

    /// Returns the block that was computed again, for [`Share::Again`].
    pub fn replay(&self) -> Option<Replay> {
        lock(&self.replay).clone()
    }

    /// Returns the loop that was left to others, for [`Share::UnlessFaster`]. No block after it is computed.
    pub fn left(&self) -> Option<LeftLoop> {
        lock(&self.clock).left.clone()
    }

    /// Returns the names of the folders of the blocks of the stages that were begun.
    pub fn stage_folders(&self) -> Vec<String> {
        lock(&self.record).stages.iter().map(|(_, folder)| folder.clone()).collect()
    }

    /// Waits until all finished blocks are on the disk.
    ///
    /// # Errors
    /// A file of blocks could not be written.
    pub fn flush(&self) -> Result<(), StoreError> {
        self.writer.flush()
    }

    /// Writes the record of the run even if it has no block.
    ///
    /// # Errors
    /// The record could not be written.
    pub fn write_record(&self) -> Result<(), StoreError> {
        lock(&self.record).write(&self.path)
    }

    /// Ends a finished run: removes the blocks that only an earlier run of this name used.
    ///
    /// # Errors
    /// A file of blocks could not be written.
    pub fn finish(&self) -> Result<(), StoreError> {
        self.flush()?;
        let mut record = lock(&self.record);
        record.finished = true;
        let earlier = std::mem::take(&mut record.earlier);
        if !self.folder.is_dir() {
            return Ok(());
        }
        record.write(&self.path)?;
        RunRecord::remove_unused(&self.folder, &earlier);
        Ok(())
    }

    /// Copies the blocks of a part of this run from its folder.
    ///
    /// # Errors
    /// A file of blocks cannot be read or written.
    pub fn import(&self, part: &Path) -> Result<(), StoreError> {
        let at = |path: &Path, source| StoreError::Io { path: path.into(), source };
        let folders = fs::read_dir(part.join(FOLDER)).into_iter().flatten().flatten().map(|entry| entry.path());
        for from in folders.flat_map(|folder| file::files(&folder)) {
            let names = from.parent().and_then(Path::file_name).zip(from.file_name());
            let Some(to) = names.map(|(folder, name)| self.folder.join(folder).join(name)) else { continue };
            // The name is the hash of the content, and a damaged file is absent.
            if to.exists() || file::read_header(&from).is_err() {
                continue;
            }
            let bytes = fs::read(&from).map_err(|source| at(&from, source))?;
            to.parent().map_or(Ok(()), fs::create_dir_all).map_err(|source| at(&to, source))?;
            replace_file(&to, |file| file.write_all(&bytes)).map_err(|source| at(&to, source))?;
        }
        Ok(())
    }
}

/// State of a run, finished or not, from its blocks.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct RunStatus {
    /// Finished blocks that hold the reason of a failure.
    pub failures: Vec<FailedBlock>,
    /// The run.
    pub record: RunRecord,
    /// Loops with at least one finished block; loops of the same stage and name count as one.
    pub rounds: Vec<RoundState>,
}

impl RunStatus {
    /// Reads the state of the run in the folder `run`, or of the part whose blocks it holds; `None` if nothing is known of it.
    pub fn read(run: &Path) -> Option<Self> {
        let own = run.join(FOLDER);
        // The folder above runs holds the blocks of several; it is itself neither a run nor a part.
        let part = RunRecord::all(&own).into_iter().find(|(_, record)| record.shard.is_some());
        let (folder, record) = match part {
            Some((_, record)) => (own, record),
            None => {
                let folder = beside(run);
                let record = RunRecord::read(&RunRecord::path(&folder, run))?;
                (folder, record)
            }
        };
        let (mut rounds, mut failures): (Vec<RoundState>, Vec<FailedBlock>) = Default::default();
        for (stage, name) in &record.stages {
            let known = Known::read([folder.join(name)].into_iter());
            let first = rounds.len();
            let mut of_stage: BTreeMap<&str, RoundState> = BTreeMap::new();
            let empty =
                |name: &str| RoundState { stage: stage.clone(), name: name.into(), expected: 0, done: 0, failed: 0 };
            for round in known.rounds.values() {
                of_stage.entry(&round.name).or_insert_with(|| empty(&round.name)).expected += round.count;
            }
            let mut failed = Vec::new();
            for ((round, index), (.., entry)) in &known.blocks {
                let Some(round) = known.rounds.get(round) else { continue };
                if let Some(state) = of_stage.get_mut(round.name.as_str()) {
                    state.done += 1;
                    state.failed += usize::from(entry.failure.is_some());
                }
                if let Some(reason) = entry.failure.clone() {
                    let place = BlockPlace { task: round.name.clone(), ordinal: round.ordinal, index: *index };
                    failed.push(FailedBlock { stage: stage.clone(), place, reason });
                }
            }
            failed.sort_by(|a, b| {
                (&a.place.task, a.place.ordinal, a.place.index).cmp(&(&b.place.task, b.place.ordinal, b.place.index))
            });
            failures.append(&mut failed);
            rounds.extend(of_stage.into_values());
            // A stage without a finished block.
            if rounds.len() == first {
                rounds.push(empty(stage));
            }
        }
        Some(Self { failures, record, rounds })
    }
}

/// Returns the folder of the blocks of a run.
fn beside(run: &Path) -> PathBuf {
    run.parent().filter(|parent| !parent.as_os_str().is_empty()).unwrap_or(Path::new(".")).join(FOLDER)
}

/// Place of a stored block: number of the file, offset, and entry.
type Place = (usize, u64, Entry);

/// Stored blocks of a stage.
#[derive(Debug, Default)]
struct Known {
    files: Vec<PathBuf>,
    blocks: HashMap<(u64, usize), Place>,
    rounds: BTreeMap<u64, Round>,
}

impl Known {
    /// Reads the headers of all files in folders. Damaged files count as absent.
    fn read(folders: impl Iterator<Item = PathBuf>) -> Self {
        let mut known = Self::default();
        for path in folders.flat_map(|folder| file::files(&folder)) {
            let Ok((header, mut offset)) = file::read_header(&path) else { continue };
            for entry in header.entries {
                let length = entry.length;
                known.blocks.insert((entry.round, entry.index), (known.files.len(), offset, entry));
                offset = offset.saturating_add(length);
            }
            known.rounds.extend(header.rounds.into_iter().map(|round| (round.id, round)));
            known.files.push(path);
        }
        known
    }

    fn load(&self, round: u64, index: usize) -> Option<(Vec<u8>, bool)> {
        let (file, offset, entry) = self.blocks.get(&(round, index))?;
        Some((file::read_block(&self.files[*file], *offset, entry)?, entry.failure.is_some()))
    }
}

/// Blocks of one stage, and the monitor of its computation.
pub struct StageBlocks<'a> {
    run: &'a RunBlocks,
    stage: String,
    folder: PathBuf,
    monitor: &'a dyn Monitor,
    known: Known,
    begun: Mutex<Begun>,
}

/// Rounds of a stage that were begun.
#[derive(Debug, Default)]
struct Begun {
    /// Number of rounds by name.
    counts: HashMap<String, u64>,
    /// Each round, with its place in the rounds of the run.
    rounds: HashMap<RoundId, (Round, usize)>,
}

impl StageBlocks<'_> {
    fn round(&self, id: RoundId) -> Option<(Round, usize)> {
        lock(&self.begun).rounds.get(&id).cloned()
    }

    /// Returns whether a block is to be computed again.
    fn is_again(&self, id: RoundId, index: usize) -> bool {
        let Share::Again(place) = &self.run.share else { return false };
        let round = self.round(id);
        place.index == index
            && round.is_some_and(|(round, _)| round.name == place.task && round.ordinal == place.ordinal)
    }

    fn count(&self, id: RoundId, failed: bool) {
        if let Some((_, place)) = self.round(id) {
            let round = &mut lock(&self.run.rounds)[place];
            round.done += 1;
            round.failed += usize::from(failed);
        }
    }

    /// Returns whether the run computes a block of a loop, instead of leaving the loop to others.
    fn keeps(&self, id: RoundId, others: &Others) -> bool {
        let mut clock = lock(&self.run.clock);
        let Some((round, place)) = self.round(id).filter(|_| clock.left.is_none()) else { return false };
        let missing = round.count - lock(&self.run.rounds)[place].done;
        let left = clock.leaves(place, missing, rayon::current_num_threads(), others);
        clock.left =
            left.map(|(parts, left_s)| LeftLoop { stage: self.stage.clone(), name: round.name, parts, left_s });
        clock.left.is_none()
    }
}

impl Monitor for StageBlocks<'_> {
    fn progress(&self, what: &str, done: usize, total: usize) {
        // An earlier computation reported a loop whose blocks are all known.
        let is_known = || lock(&self.run.clock).place.map(|place| place + 1) != Some(lock(&self.run.rounds).len());
        if !(matches!(self.run.share, Share::UnlessFaster(_)) && is_known()) {
            self.monitor.progress(what, done, total);
        }
    }

    fn cancelled(&self) -> bool {
        self.monitor.cancelled() || self.run.writer.failed() || lock(&self.run.replay).is_some()
    }

    fn store(&self) -> Option<&dyn BlockStore> {
        Some(self)
    }
}

impl BlockStore for StageBlocks<'_> {
    fn begin(&self, name: &str, count: usize) -> RoundId {
        let mut begun = lock(&self.begun);
        let ordinal = begun.counts.entry(name.to_owned()).or_default();
        let (key, own) = (format!("{name}/{count}/{ordinal}"), *ordinal);
        *ordinal += 1;
        let id = RoundId(u64::from_le_bytes(Sha256::digest(key).as_chunks().0[0]));
        let mut rounds = lock(&self.run.rounds);
        let round = Round { id: id.0, name: name.to_owned(), count, ordinal: own };
        let state =
            RoundState { stage: self.stage.clone(), name: name.to_owned(), expected: count, done: 0, failed: 0 };
        rounds.push(state);
        begun.rounds.insert(id, (round, rounds.len() - 1));
        id
    }

    fn load(&self, round: RoundId, index: usize) -> Option<Vec<u8>> {
        if self.is_again(round, index) {
            return None;
        }
        let (bytes, failed) = self.known.load(round.0, index)?;
        self.count(round, failed);
        Some(bytes)
    }

    fn save(&self, round: RoundId, index: usize, failure: Option<String>, bytes: Vec<u8>) {
        // The computation of one sample changes nothing on the disk.
        if matches!(self.run.share, Share::Again(_)) {
            if self.is_again(round, index) {
                let identical = self.known.load(round.0, index).map(|(stored, _)| stored == bytes);
                *lock(&self.run.replay) = Some(Replay { failure, identical });
            }
            return;
        }
        self.count(round, failure.is_some());
        lock(&self.run.clock).end_block();
        if let Some((name, _)) = self.round(round) {
            self.run.writer.add(&self.folder, &name, Block { round, index, failure, bytes });
        }
    }

    fn computes(&self, round: RoundId, index: usize) -> bool {
        let own = match &self.run.share {
            Share::All | Share::Again(_) => true,
            Share::UnlessFaster(others) => self.keeps(round, others),
            Share::Part { number, of } => index % of + 1 == *number,
            Share::None => false,
        };
        if !own {
            self.run.awaits.store(true, Ordering::SeqCst);
        }
        own
    }
}
