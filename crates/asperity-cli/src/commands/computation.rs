//! Computation of a study or a campaign into its folder, with its stored blocks.

use std::collections::BTreeMap;
use std::ffi::OsStr;
use std::fs;
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::time::Duration;

use asperity::quantity::Time;
use asperity::study::{
    Campaign, Computed, FailureKind, Provenance, RoundState, RunBlocks, RunRecord, Share, Stage, Staging,
    StoredCampaign, StoredRun, Study, StudyError, Work, folder_of, is_finished, require_unchanged, resolved_study,
};
use clap::Args;
use serde_json::{Value, json};

use super::found::{Found, found};
use super::study_file;
use crate::args;
use crate::failure::{Failure, Kind};
use crate::monitor::{Terminal, duration};
use crate::output::{Answer, columns, print};
use crate::provenance;
use crate::resources::{limit_memory, require_disk, require_memory};
use crate::run_folder::{begin_default_folder, begin_folder, load_failure, store_failure};

/// Study or campaign to compute.
pub(super) struct Computation {
    own: asperity::study::Computation,
    file: PathBuf,
}

impl Computation {
    /// Reads a study file.
    pub(super) fn study(file: &Path, seed: Option<u64>, only: Option<Stage>) -> Result<Self, Failure> {
        let (study, text) = study_file::study(file, seed)?;
        Ok(Self::new(asperity::study::Computation::study(Some(file.into()), text, study, only), file))
    }

    /// Reads a campaign file and the study that its members vary.
    pub(super) fn campaign(file: &Path, seed: Option<u64>) -> Result<Self, Failure> {
        let study_path = study_file::read(file, |text, _| Campaign::study_path(text, file));
        let (path, text) =
            study_path.map_err(|failure| match study_file::has_any(file, &["surface", "vibration"]) {
                true => Failure::usage(format_args!("{0} is a study: `asperity run {0}` computes it", file.display())),
                false => failure,
            })?;
        let parse = |study: &str, _: &str| Campaign::parse(&text, file, study, seed);
        let (campaign, _) = study_file::read(&folder_of(file).join(path), parse)?;
        Ok(Self::new(asperity::study::Computation::campaign(file.into(), text, campaign), file))
    }

    fn new(own: asperity::study::Computation, file: &Path) -> Self {
        Self { own, file: file.into() }
    }

    /// Returns the study or the campaign of stored blocks.
    pub(super) fn of(record: &RunRecord) -> Result<Self, Failure> {
        let own = asperity::study::Computation::of_record(record)
            .map_err(|error| Failure::new(if error.in_data { Kind::Data } else { Kind::Usage }, error.to_string()))?;
        Ok(Self::new(own, &record.file))
    }

    pub(super) fn name(&self) -> String {
        self.own.name()
    }

    /// Returns the default folder.
    pub(super) fn destination(&self) -> PathBuf {
        match self.own.work() {
            Work::Study { study, .. } => default_destination(&self.file, study),
            Work::Campaign(_) => Path::new("campaigns").join(self.name()),
        }
    }

    /// Returns a description of the computation, for a campaign.
    pub(super) fn extent(&self) -> Option<String> {
        let Work::Campaign(campaign) = self.own.work() else { return None };
        let shared = match campaign.shared_stages() {
            0 => String::new(),
            1 => "; one friction stage is common to several".to_owned(),
            shared => format!("; {shared} friction stages are common to several"),
        };
        let members = campaign.members();
        Some(format!("{members} {}{shared}", if members == 1 { "member" } else { "members" }))
    }

    /// Returns the record of the run, or of one part of it.
    pub(super) fn record(&self, shard: Option<[usize; 2]>) -> Result<RunRecord, Failure> {
        self.own.record(provenance::program()?, shard).map_err(|e| store_failure(&e))
    }

    /// Returns the SHA-256 of the files that the study or the campaign reads, by name.
    pub(super) fn data_hashes(&self) -> Result<BTreeMap<String, String>, Failure> {
        self.own.data_hashes().map_err(|e| store_failure(&e))
    }

    /// Returns the files that the computation reads.
    pub(super) fn inputs(&self) -> Vec<PathBuf> {
        self.own.inputs()
    }

    /// Begins the provenance of the run.
    pub(super) fn provenance(&self) -> Result<Provenance, Failure> {
        provenance::begin(self.own.provenance().map_err(|e| load_failure(&e))?)
    }

    /// Fails if the memory of the machine, or a limit in bytes, is too small.
    pub(super) fn require_memory(&self, most_bytes: Option<f64>) -> Result<(), Failure> {
        let largest = self.own.largest_stage(rayon::current_num_threads()).map_err(|error| self.failure(&error))?;
        let Some(largest) = largest else { return Ok(()) };
        let what = format!("the {} stage", largest.stage.name());
        require_memory(largest.memory_bytes, &what)?;
        most_bytes.map_or(Ok(()), |most| limit_memory(largest.memory_bytes, &what, most))
    }

    /// Fails if the disk of the destination is too small.
    pub(super) fn require_disk(&self, destination: &Path) -> Result<(), Failure> {
        let what = match self.own.work() {
            Work::Study { .. } => "the run",
            Work::Campaign(_) => "the campaign",
        };
        require_disk(self.own.disk_bytes(), destination, what)
    }

    fn failure(&self, error: &StudyError) -> Failure {
        study_file::with_message(error, self.own.message(error))
    }

    /// Computes with the stored blocks; `None` if blocks of other parts are missing. Keeps the finished ones if it ends early.
    pub(super) fn compute(
        &self,
        blocks: &Arc<RunBlocks>,
        json: bool,
        monitor: &Terminal,
    ) -> Result<Option<Computed>, Failure> {
        let kept = Arc::clone(blocks);
        monitor.before_exit(move || {
            // The program ends; an error would have no reader.
            kept.flush().is_ok() && has_blocks(&kept)
        });
        let outcome = match self.own.compute(Some(blocks), monitor) {
            Err(StudyError::Incomplete) => Ok(None),
            Err(StudyError::Blocks(error)) => Err(store_failure(&error)),
            Err(error) => match monitor.exceeded_time().filter(|_| error.kind() == FailureKind::Cancelled) {
                Some(limit) => {
                    let limit = duration(limit.as_secs_f64());
                    let message = format!("stopped after {limit}; the same command goes on from the finished blocks");
                    Err(Failure::new(Kind::Resources, message))
                }
                None if error.kind() == FailureKind::Cancelled => Err(Failure::cancelled(has_blocks(blocks))),
                None => {
                    let reason = Answer::default().with("reason", error.to_string());
                    Err(self.failure(&error).print(reason, json)?)
                }
            },
            Ok(outcome) => Ok(Some(outcome)),
        };
        blocks.flush().map_err(|e| store_failure(&e))?;
        outcome
    }

    /// Computes without stored blocks.
    pub(super) fn again(&self, monitor: &Terminal) -> Result<Computed, Failure> {
        self.own.compute(None, monitor).map_err(|error| self.failure(&error))
    }

    /// Writes the folder, and ends the use of its blocks.
    pub(super) fn write(
        &self,
        staging: Staging,
        computed: &Computed,
        mut provenance: Provenance,
        blocks: &RunBlocks,
        monitor: &Terminal,
    ) -> Result<PathBuf, Failure> {
        let warnings = match found(computed) {
            Found::Run(results) => &results.warnings,
            Found::Campaign(results) => &results.warnings,
        };
        warnings.iter().for_each(|warning| monitor.warn(warning));
        let failed: usize = blocks.rounds().iter().map(|round| round.failed).sum();
        if failed > 0 {
            let (noun, run) = (if failed == 1 { "sample" } else { "samples" }, staging.destination().display());
            monitor.note(&format!("{failed} {noun} failed; `asperity status {run}` lists them"));
        }
        (provenance.seconds, provenance.stages) = (monitor.seconds(), monitor.stages());
        self.own.write(&staging, computed, &provenance).map_err(|e| store_failure(&e))?;
        let committed = monitor.commit(|| staging.commit().map_err(|e| store_failure(&e)));
        let written = committed.map_err(|failure| match failure.kind() {
            Kind::Cancelled => Failure::cancelled(has_blocks(blocks)),
            _ => failure,
        })?;
        blocks.finish().map_err(|e| store_failure(&e))?;
        monitor.note(&format!("wrote {}", written.join("report.html").display()));
        Ok(written)
    }

    /// Prints the results of a finished folder of the same study or campaign, and returns whether there is one. An empty folder counts
    /// as none.
    pub(super) fn print_finished(&self, folder: &Path, json: bool) -> Result<bool, Failure> {
        let is_empty = fs::read_dir(folder).map_or(!folder.exists(), |mut entries| entries.next().is_none());
        if is_empty {
            return Ok(false);
        }
        let data = self.data_hashes()?;
        // The file of the study is an input as well.
        let same_inputs = |provenance: &Provenance| {
            let inputs = &provenance.inputs;
            inputs.len() == data.len() + 1 && data.iter().all(|(name, hash)| inputs.get(name) == Some(hash))
        };
        let print = |found: &Found<'_>| {
            require_unchanged(folder).map_err(|e| load_failure(&e))?;
            found.print(json, folder)
        };
        let printed = match self.own.work() {
            Work::Study { .. } if StoredCampaign::is_campaign(folder) => None,
            Work::Campaign(_) if is_finished(folder) && !StoredCampaign::is_campaign(folder) => None,
            Work::Study { study, only } => {
                let run = StoredRun::load(folder).map_err(|e| load_failure(&e))?;
                let resolved = resolved_study(study, self.own.folder()).map_err(|e| store_failure(&e))?;
                let same = run.study == resolved && run.provenance.only.as_deref() == only.map(|stage| stage.name());
                (same && same_inputs(&run.provenance)).then(|| print(&Found::Run(&run.results)))
            }
            Work::Campaign(campaign) => {
                let stored = StoredCampaign::load(folder).map_err(|e| load_failure(&e))?;
                let same = stored.text == campaign.resolved() && same_inputs(&stored.provenance);
                same.then(|| print(&Found::Campaign(&stored.results)))
            }
        };
        match printed {
            Some(printed) => printed.map(|()| true),
            None => {
                let other = match self.own.work() {
                    Work::Study { .. } => "the run of another study",
                    Work::Campaign(_) => "another campaign",
                };
                Err(Failure::usage(format_args!("--resume: {} is {other}", folder.display())))
            }
        }
    }
}

/// Returns the default folder of the run of a study in `file`.
pub(super) fn default_destination(file: &Path, study: &Study) -> PathBuf {
    let stated = study.file().name.as_ref().map(OsStr::new);
    Path::new("runs").join(stated.or(file.file_stem()).unwrap_or_default())
}

/// Opens the blocks of a run.
pub(super) fn open(run: &Path, record: RunRecord, share: Share) -> Result<Arc<RunBlocks>, Failure> {
    RunBlocks::open(run, record, share).map(Arc::new).map_err(|e| store_failure(&e))
}

/// Returns whether a run has finished blocks, from which it goes on.
fn has_blocks(blocks: &RunBlocks) -> bool {
    blocks.rounds().iter().any(|round| round.done > 0)
}

/// Removes an unfinished folder if a signal ends the program.
pub(super) fn removed_at_exit(staging: &Staging, monitor: &Terminal) {
    let partial = staging.partial().to_path_buf();
    monitor.before_exit(move || {
        // The next command beside it removes what stays.
        let _ = std::fs::remove_dir_all(partial);
        false
    });
}

/// Returns the state of loops for display.
pub(super) fn as_json(rounds: &[RoundState]) -> Vec<Value> {
    let row = |round: &RoundState| {
        json!({
            "stage": round.stage,
            "task": round.name,
            "expected": round.expected,
            "done": round.done,
            "failed": round.failed,
            "missing": round.expected - round.done,
        })
    };
    rounds.iter().map(row).collect()
}

/// Returns the state of loops as an aligned table; loops of the same stage and name are one row.
pub(super) fn as_table(rounds: &[RoundState]) -> String {
    let mut sums: Vec<RoundState> = Vec::new();
    for round in rounds {
        match sums.iter_mut().find(|sum| (&sum.stage, &sum.name) == (&round.stage, &round.name)) {
            Some(sum) => {
                sum.expected += round.expected;
                sum.done += round.done;
                sum.failed += round.failed;
            }
            None => sums.push(round.clone()),
        }
    }
    let head = ["stage", "task", "expected", "done", "failed", "missing"].map(str::to_owned);
    let row = |round: &RoundState| {
        let [expected, done, failed] = [round.expected, round.done, round.failed].map(|count| count.to_string());
        let missing = (round.expected - round.done).to_string();
        [round.stage.clone(), round.name.clone(), expected, done, failed, missing]
    };
    let rows: Vec<[String; 6]> = std::iter::once(head).chain(sums.iter().map(row)).collect();
    columns(&rows)
}

/// Returns which loops lack blocks, in words.
pub(super) fn missing(rounds: &[RoundState]) -> String {
    let lacks = rounds.iter().filter(|round| round.done < round.expected);
    let words =
        lacks.map(|round| format!("{} ({} of {} blocks)", round.name, round.expected - round.done, round.expected));
    words.collect::<Vec<_>>().join(", ")
}

/// Flags of a computation.
#[derive(Debug, Args)]
pub(super) struct Options {
    /// Folder to write. When left out, a study is written to runs/NAME and a campaign to campaigns/NAME, where NAME is the `name` that the
    /// study states, or the name of the file. The folder appears complete or not at all.
    #[arg(long, value_name = "DIR")]
    out: Option<PathBuf>,
    /// Seed to use instead of the file's.
    #[arg(long, value_name = "N", value_parser = args::seed, allow_hyphen_values = true)]
    pub(super) seed: Option<u64>,
    /// Replace a folder that asperity wrote. A folder that contains an input, or a file that asperity did not write or
    /// that has changed, is never replaced.
    #[arg(long)]
    force: bool,
    /// Accept the finished folder of the same file as the result.
    #[arg(long, conflicts_with = "shard")]
    resume: bool,
    /// Compute part I of N, I from 1, of the blocks that can be computed now. --out is then the folder of these blocks;
    /// `asperity merge` makes the whole of all parts.
    #[arg(long, value_name = "I/N", value_parser = args::shard)]
    shard: Option<[usize; 2]>,
    /// Stop after this time, such as "2 h", and keep the finished blocks (exit code 5).
    #[arg(long, value_name = "TIME", value_parser = args::positive_quantity::<Time>, allow_hyphen_values = true)]
    max_time: Option<Time>,
    /// Refuse a computation that needs more memory, such as "4 GB" (exit code 5).
    #[arg(long, value_name = "SIZE", value_parser = args::bytes)]
    max_memory: Option<f64>,
    /// Print results.json to stdout as well.
    #[arg(long)]
    json: bool,
}

impl Options {
    /// Computes into a folder, or one part.
    pub(super) fn run(&self, computation: &Computation, monitor: &Terminal) -> Result<(), Failure> {
        let destination = self.out.clone().unwrap_or_else(|| computation.destination());
        if let Some(time) = self.max_time {
            monitor.limit_time(Duration::try_from_secs_f64(time.0).unwrap_or(Duration::MAX));
        }
        computation.require_memory(self.max_memory)?;
        if let Some(shard) = self.shard {
            return self.part(computation, shard, monitor);
        }
        Staging::clean_beside(&destination);
        if self.resume && computation.print_finished(&destination, self.json)? {
            monitor.note(&format!("{} is finished", destination.display()));
            return Ok(());
        }
        let provenance = computation.provenance()?;
        // Check the folder before a long computation.
        let inputs = computation.inputs();
        let inputs: Vec<&Path> = inputs.iter().map(PathBuf::as_path).collect();
        let begin = if self.out.is_some() { begin_folder } else { begin_default_folder };
        let staging = begin("--out", &destination, self.force, &inputs)?;
        removed_at_exit(&staging, monitor);
        computation.require_disk(&destination)?;
        let blocks = open(&destination, computation.record(None)?, Share::All)?;
        let computed = computation.compute(&blocks, self.json, monitor)?;
        let computed = computed.ok_or_else(|| Failure::new(Kind::Runtime, StudyError::Incomplete.to_string()))?;
        let written = computation.write(staging, &computed, provenance, &blocks, monitor)?;
        found(&computed).print(self.json, &written)
    }

    /// Computes one part of the blocks.
    fn part(&self, computation: &Computation, shard: [usize; 2], monitor: &Terminal) -> Result<(), Failure> {
        let [number, of] = shard;
        let record = computation.record(Some(shard))?;
        let folder = self.out.clone().unwrap_or_else(|| {
            let name = format!("{}-part-{number}-of-{of}", computation.name());
            computation.destination().with_file_name(name)
        });
        if is_finished(&folder) {
            return Err(Failure::usage(format_args!(
                "--out {} is a run; give another folder for the blocks",
                folder.display()
            )));
        }
        let blocks = open(&folder, record, Share::Part { number, of })?;
        let complete = computation.compute(&blocks, self.json, monitor)?.is_some();
        // A merge reads it.
        blocks.write_record().map_err(|e| store_failure(&e))?;
        let rounds = blocks.rounds();
        if !complete {
            monitor.note(&format!("blocks of other parts are missing: {}", missing(&rounds)));
        }
        if !self.json {
            let rest = if complete { "" } else { ", as far as it can be computed without the other parts" };
            return print(&format!("part {number} of {of}{rest}: {}\n\n{}", folder.display(), as_table(&rounds)));
        }
        Answer::default()
            .with("part", number)
            .with("parts", of)
            .with("complete", complete)
            .with("rounds", as_json(&rounds))
            .with("folder", folder.display().to_string())
            .print(true)
    }
}
