//! Computation of a study into a run folder, with its stored blocks.

use std::path::{Path, PathBuf};
use std::sync::Arc;

use asperity::study::{
    FailureKind, Outcome, Provenance, RoundState, RunBlocks, RunRecord, Share, Stage, Staging, Study, StudyError,
    write_run,
};
use serde_json::{Value, json};

use super::study_file;
use crate::failure::{Failure, Kind};
use crate::monitor::{Terminal, duration};
use crate::output::Answer;
use crate::provenance;
use crate::resources::{limit_memory, require_disk, require_memory};
use crate::run_folder::store_failure;

/// Study to compute.
pub(super) struct Computation {
    /// Study file and its text.
    pub(super) file: PathBuf,
    pub(super) text: String,
    pub(super) study: Study,
    pub(super) name: String,
    pub(super) only: Option<Stage>,
}

impl Computation {
    /// Reads a study file.
    pub(super) fn read(file: &Path, seed: Option<u64>, only: Option<Stage>) -> Result<Self, Failure> {
        let (study, text) = study_file::study(file, seed)?;
        let name = file.file_stem().unwrap_or_default().to_string_lossy().into_owned();
        Ok(Self { file: file.into(), text, study, name, only })
    }

    /// Returns the study of stored blocks.
    pub(super) fn of(record: &RunRecord) -> Result<Self, Failure> {
        let study = Study::parse(&record.study, &record.file.display().to_string())
            .map_err(|error| Failure::new(if error.in_data { Kind::Data } else { Kind::Usage }, error.to_string()))?
            .with_seed(record.seed);
        let RunRecord { file, study: text, name, only, .. } = record.clone();
        Ok(Self { file, text, study, name, only })
    }

    /// Returns the record of the run, or of one part of it.
    pub(super) fn record(&self, shard: Option<[usize; 2]>) -> Result<RunRecord, Failure> {
        let file = std::path::absolute(&self.file).map_err(|e| Failure::io(Kind::Data, self.file.display(), &e))?;
        let (name, study, seed) = (self.name.clone(), self.text.clone(), self.study.seed());
        let program = provenance::program()?;
        Ok(RunRecord { name, file, study, seed, only: self.only, program, shard, ..RunRecord::default() })
    }

    /// Returns the files that the study reads.
    pub(super) fn data(&self) -> Vec<PathBuf> {
        let folder = study_file::folder_of(&self.file);
        self.study.scan_paths(folder).into_iter().chain(self.study.friction_process_path(folder)).collect()
    }

    /// Returns the files that the computation reads.
    pub(super) fn inputs(&self) -> Vec<PathBuf> {
        std::iter::once(self.file.clone()).chain(self.data()).collect()
    }

    /// Begins the provenance of the run.
    pub(super) fn provenance(&self) -> Result<Provenance, Failure> {
        let provenance = provenance::begin(&self.name, self.study.seed(), &self.inputs())?;
        Ok(Provenance { only: self.only.map(|stage| stage.name().to_owned()), ..provenance })
    }

    /// Fails if the memory of the machine, or a limit in bytes, is too small.
    pub(super) fn require_memory(&self, most_bytes: Option<f64>) -> Result<(), Failure> {
        for stage in self.study.estimate(rayon::current_num_threads()) {
            let what = format!("the {} stage", stage.stage.name());
            require_memory(stage.memory_bytes, &what)?;
            most_bytes.map_or(Ok(()), |most| limit_memory(stage.memory_bytes, &what, most))?;
        }
        Ok(())
    }

    /// Fails if the disk of the destination is too small.
    pub(super) fn require_disk(&self, destination: &Path) -> Result<(), Failure> {
        require_disk(self.study.disk_bytes() + scan_field_bytes(&self.data()), destination, "the run")
    }

    /// Computes the study with its stored blocks. Keeps the finished ones if it ends early.
    pub(super) fn compute(&self, blocks: &Arc<RunBlocks>, json: bool, monitor: &Terminal) -> Result<Outcome, Failure> {
        let kept = Arc::clone(blocks);
        monitor.before_exit(move || {
            // The program ends; an error would have no reader.
            let _ = kept.flush();
        });
        let found = self.study.run_with(Some(blocks), study_file::folder_of(&self.file), self.only, monitor);
        let outcome = match found {
            Err(StudyError::Blocks(error)) => Err(store_failure(&error)),
            Err(error) => match monitor.exceeded_time().filter(|_| error.kind() == FailureKind::Cancelled) {
                Some(limit) => {
                    let limit = duration(limit.as_secs_f64());
                    let message = format!("stopped after {limit}; the same command goes on from the finished blocks");
                    Err(Failure::new(Kind::Resources, message))
                }
                None => {
                    let reason = Answer::default().with("reason", error.to_string());
                    Err(study_file::failure(&self.file, Some(&self.text), &error).print(reason, json)?)
                }
            },
            Ok(outcome) => Ok(outcome),
        };
        blocks.flush().map_err(|e| store_failure(&e))?;
        outcome
    }

    /// Writes the run folder, and ends the use of its blocks.
    pub(super) fn write(
        &self,
        staging: Staging,
        outcome: &Outcome,
        mut provenance: Provenance,
        blocks: &RunBlocks,
        monitor: &Terminal,
    ) -> Result<PathBuf, Failure> {
        outcome.results.warnings.iter().for_each(|warning| monitor.warn(warning));
        let failed: usize = blocks.rounds().iter().map(|round| round.failed).sum();
        if failed > 0 {
            let (noun, run) = (if failed == 1 { "sample" } else { "samples" }, staging.destination().display());
            monitor.note(&format!("{failed} {noun} failed; `asperity status {run}` lists them"));
        }
        (provenance.seconds, provenance.stages) = (monitor.seconds(), monitor.stages());
        let folder = study_file::folder_of(&self.file);
        write_run(&staging, &self.study, folder, outcome, &provenance).map_err(|e| store_failure(&e))?;
        let written = monitor.commit(|| staging.commit().map_err(|e| store_failure(&e)))?;
        blocks.finish().map_err(|e| store_failure(&e))?;
        monitor.note(&format!("wrote {}", written.join("report.html").display()));
        Ok(written)
    }
}

/// Opens the blocks of a run.
pub(super) fn open(run: &Path, record: RunRecord, share: Share) -> Result<Arc<RunBlocks>, Failure> {
    RunBlocks::open(run, record, share).map(Arc::new).map_err(|e| store_failure(&e))
}

/// Removes an unfinished folder if a signal ends the program.
pub(super) fn removed_at_exit(staging: &Staging, monitor: &Terminal) {
    let partial = staging.partial().to_path_buf();
    monitor.before_exit(move || {
        // The next command beside it removes what stays.
        let _ = std::fs::remove_dir_all(partial);
    });
}

/// Returns the state of loops for display.
pub(super) fn as_json(rounds: &[RoundState]) -> Vec<Value> {
    let row = |round: &RoundState| {
        json!({
            "stage": round.stage.name(),
            "task": round.name,
            "expected": round.expected,
            "done": round.done,
            "failed": round.failed,
            "missing": round.expected - round.done,
        })
    };
    rounds.iter().map(row).collect()
}

/// Returns which loops lack blocks, in words.
pub(super) fn missing(rounds: &[RoundState]) -> String {
    let lacks = rounds.iter().filter(|round| round.done < round.expected);
    let words =
        lacks.map(|round| format!("{} ({} of {} blocks)", round.name, round.expected - round.done, round.expected));
    words.collect::<Vec<_>>().join(", ")
}

/// Estimates the disk space of the heights of scans in a run folder: raw and prepared, each as NPY file and VTK image. Scans may be
/// compressed.
fn scan_field_bytes(scans: &[PathBuf]) -> f64 {
    const BYTES_PER_BYTE: f64 = 19.0;
    scans.iter().filter_map(|scan| scan.metadata().ok()).map(|scan| BYTES_PER_BYTE * scan.len() as f64).sum()
}
