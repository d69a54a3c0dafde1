//! Finished blocks of a run, in files beside it, from which an interrupted run goes on.
//!
//! The blocks of the run `runs/brake` are in `runs/.asperity-blocks`: a folder per stage, named by the hash of what the stage depends
//! on, and a record of each run. A study whose vibration changes therefore finds the blocks of its contact stages again.

mod file;
mod record;
mod writer;

use std::collections::{BTreeMap, HashMap};
use std::fmt::Debug;
use std::fs;
use std::io::Write;
use std::path::{Path, PathBuf};
use std::sync::{Mutex, MutexGuard, PoisonError};

use asperity_base::monitor::{BlockStore, Monitor, RoundId};
use asperity_formats::{remove_abandoned_files, replace_file};
use sha2::{Digest, Sha256};

use self::file::{Block, Entry, Round};
pub use self::record::{Program, RunRecord};
use self::writer::Writer;
use crate::study::StoreError;

/// Name of the folder of blocks beside a run.
const FOLDER: &str = ".asperity-blocks";

/// Returns the SHA-256 of parts as hexadecimal digits.
pub(super) fn hash<'a>(parts: impl IntoIterator<Item = &'a [u8]>) -> String {
    let mut sha256 = Sha256::new();
    for part in parts {
        // The length separates a part from the next.
        sha256.update((part.len() as u64).to_le_bytes());
        sha256.update(part);
    }
    file::hex(&sha256.finalize())
}

/// Which blocks a process computes.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Share {
    /// All that are missing.
    All,
    /// Those whose index has the remainder `number − 1` by `of`.
    Part {
        /// Number of this part, from 1.
        number: usize,
        /// Number of all parts.
        of: usize,
    },
    /// None: stored blocks only.
    None,
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
}

fn lock<T>(mutex: &Mutex<T>) -> MutexGuard<'_, T> {
    mutex.lock().unwrap_or_else(PoisonError::into_inner)
}

impl RunBlocks {
    /// Opens the blocks of the run in the folder `run`, which need not exist. The blocks of a part are in its own folder. Nothing is
    /// written before the first block.
    ///
    /// # Errors
    /// No thread can be started.
    pub fn open(run: &Path, mut record: RunRecord, share: Share) -> Result<Self, StoreError> {
        let shared = beside(run);
        let (folder, beside) = match share {
            Share::Part { .. } => (run.join(FOLDER), vec![shared]),
            Share::All | Share::None => (shared, Vec::new()),
        };
        remove_abandoned_files(&folder);
        let path = RunRecord::path(&folder, run);
        record.earlier = RunRecord::read(&path).iter().flat_map(RunRecord::folders).cloned().collect();
        let writer = Writer::start(path.clone()).map_err(|source| StoreError::Io { path: folder.clone(), source })?;
        Ok(Self { folder, beside, share, record: Mutex::new(record), path, writer, rounds: Mutex::default() })
    }

    /// Begins a stage, a function of `depends_on` alone.
    pub(super) fn stage<'a>(
        &'a self,
        stage: &str,
        depends_on: &[&dyn Debug],
        monitor: &'a dyn Monitor,
    ) -> StageBlocks<'a> {
        let mut record = lock(&self.record);
        let mut parts = vec![format!("{:?}", record.program), stage.to_owned()];
        parts.extend(depends_on.iter().map(|part| format!("{part:?}")));
        let name = hash(parts.iter().map(String::as_bytes))[..32].to_owned();
        let folder = self.folder.join(&name);
        remove_abandoned_files(&folder);
        let known = Known::read(self.beside.iter().map(|other| other.join(&name)).chain([folder.clone()]));
        record.stages.push((stage.to_owned(), name));
        self.writer.set_record(record.clone());
        StageBlocks { run: self, stage: stage.to_owned(), folder, monitor, known, ordinals: Mutex::default() }
    }

    /// Returns the rounds that were begun, in their order.
    pub fn rounds(&self) -> Vec<RoundState> {
        lock(&self.rounds).clone()
    }

    /// Returns whether blocks could not be written.
    pub(super) fn failed(&self) -> bool {
        self.writer.failed()
    }

    /// Returns whether blocks of other parts are missing.
    pub fn is_incomplete(&self) -> bool {
        lock(&self.rounds).iter().any(|round| round.done < round.expected)
    }

    /// Waits until all finished blocks are on the disk.
    ///
    /// # Errors
    /// A file of blocks could not be written.
    pub fn flush(&self) -> Result<(), StoreError> {
        self.writer.flush()
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
    /// The run.
    pub record: RunRecord,
    /// Loops with at least one finished block; loops of the same stage and name count as one.
    pub rounds: Vec<RoundState>,
}

impl RunStatus {
    /// Reads the state of the run in the folder `run`, or of the part whose blocks it holds; `None` if nothing is known of it.
    pub fn read(run: &Path) -> Option<Self> {
        let own = run.join(FOLDER);
        let (folder, record) = match RunRecord::all(&own).into_iter().next() {
            Some((_, record)) => (own, record),
            None => {
                let folder = beside(run);
                let record = RunRecord::read(&RunRecord::path(&folder, run))?;
                (folder, record)
            }
        };
        let mut rounds: Vec<RoundState> = Vec::new();
        for (stage, name) in &record.stages {
            let known = Known::read([folder.join(name)].into_iter());
            let first = rounds.len();
            let mut of_stage: BTreeMap<&str, RoundState> = BTreeMap::new();
            let empty =
                |name: &str| RoundState { stage: stage.clone(), name: name.into(), expected: 0, done: 0, failed: 0 };
            for round in known.rounds.values() {
                of_stage.entry(&round.name).or_insert_with(|| empty(&round.name)).expected += round.count;
            }
            for ((round, _), (.., entry)) in &known.blocks {
                let state = known.rounds.get(round).and_then(|round| of_stage.get_mut(round.name.as_str()));
                if let Some(state) = state {
                    state.done += 1;
                    state.failed += usize::from(entry.failed);
                }
            }
            rounds.extend(of_stage.into_values());
            // A stage without a finished block.
            if rounds.len() == first {
                rounds.push(empty(stage));
            }
        }
        Some(Self { record, rounds })
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
        Some((file::read_block(&self.files[*file], *offset, entry)?, entry.failed))
    }
}

/// Blocks of one stage, and the monitor of its computation.
pub(super) struct StageBlocks<'a> {
    run: &'a RunBlocks,
    stage: String,
    folder: PathBuf,
    monitor: &'a dyn Monitor,
    known: Known,
    /// Rounds begun by name, and the place of each in the rounds of the run.
    ordinals: Mutex<(HashMap<String, u64>, HashMap<RoundId, (Round, usize)>)>,
}

impl StageBlocks<'_> {
    fn round(&self, id: RoundId) -> Option<(Round, usize)> {
        lock(&self.ordinals).1.get(&id).cloned()
    }

    fn count(&self, id: RoundId, failed: bool) {
        if let Some((_, place)) = self.round(id) {
            let round = &mut lock(&self.run.rounds)[place];
            round.done += 1;
            round.failed += usize::from(failed);
        }
    }
}

impl Monitor for StageBlocks<'_> {
    fn progress(&self, what: &str, done: usize, total: usize) {
        self.monitor.progress(what, done, total);
    }

    fn cancelled(&self) -> bool {
        self.monitor.cancelled() || self.run.writer.failed()
    }

    fn store(&self) -> Option<&dyn BlockStore> {
        Some(self)
    }
}

impl BlockStore for StageBlocks<'_> {
    fn begin(&self, name: &str, count: usize) -> RoundId {
        let mut ordinals = lock(&self.ordinals);
        let ordinal = ordinals.0.entry(name.to_owned()).or_default();
        let key = format!("{name}/{count}/{ordinal}");
        *ordinal += 1;
        let id = RoundId(u64::from_le_bytes(Sha256::digest(key).as_chunks().0[0]));
        let mut rounds = lock(&self.run.rounds);
        let round = Round { id: id.0, name: name.to_owned(), count };
        rounds.push(RoundState {
            stage: self.stage.clone(),
            name: name.to_owned(),
            expected: count,
            done: 0,
            failed: 0,
        });
        ordinals.1.insert(id, (round, rounds.len() - 1));
        id
    }

    fn load(&self, round: RoundId, index: usize) -> Option<Vec<u8>> {
        let (bytes, failed) = self.known.load(round.0, index)?;
        self.count(round, failed);
        Some(bytes)
    }

    fn save(&self, round: RoundId, index: usize, failed: bool, bytes: Vec<u8>) {
        self.count(round, failed);
        if let Some((name, _)) = self.round(round) {
            self.run.writer.add(&self.folder, &name, Block { round, index, failed, bytes });
        }
    }

    fn computes(&self, index: usize) -> bool {
        match self.run.share {
            Share::All => true,
            Share::Part { number, of } => index % of + 1 == number,
            Share::None => false,
        }
    }
}
