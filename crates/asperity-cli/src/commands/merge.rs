//! One run from parts.

use std::path::{Path, PathBuf};

use asperity::study::{RunStatus, Share, program_difference};
use clap::Args;

use super::computation::{Computation, as_json, missing, open, removed_at_exit};
use super::found::found;
use crate::failure::{Failure, Kind};
use crate::monitor::Terminal;
use crate::output::Answer;
use crate::run_folder::{begin_folder, store_failure};

/// Makes one folder of the parts that several machines computed.
///
/// They come from `asperity run --shard` or `asperity campaign --shard`, are of the same file, and of this program on machines like
/// this one. Names the blocks that are missing (exit code 3).
#[derive(Debug, Args)]
pub(crate) struct Merge {
    /// Folders of the parts.
    #[arg(required = true, value_name = "DIR")]
    parts: Vec<PathBuf>,
    /// Folder of the run.
    #[arg(long, value_name = "RUN")]
    out: PathBuf,
    /// Compute the blocks that are missing.
    #[arg(long)]
    finish: bool,
    /// Replace a folder that asperity wrote.
    #[arg(long)]
    force: bool,
    /// Print results.json to stdout as well.
    #[arg(long)]
    json: bool,
}

impl Merge {
    pub(crate) fn run(&self, monitor: &Terminal) -> Result<(), Failure> {
        let read = |part: &PathBuf| {
            let status = RunStatus::read(part);
            let status = status
                .ok_or_else(|| Failure::new(Kind::Data, format!("{}: no blocks of a part of a run", part.display())))?;
            if status.record.shard.is_some() {
                return Ok(status);
            }
            Err(Failure::usage(format_args!("{} is a run, no part of one (`asperity run --shard`)", part.display())))
        };
        let parts = self.parts.iter().map(read).collect::<Result<Vec<_>, _>>()?;
        let first = &parts[0].record;
        for (folder, part) in self.parts.iter().zip(&parts) {
            if let Some(difference) = first.difference(&part.record) {
                let (folder, first) = (folder.display(), self.parts[0].display());
                return Err(Failure::usage(format_args!("{folder} is of {difference} than {first}")));
            }
        }
        let computation = Computation::of(first)?;
        let record = computation.record(None)?;
        if record.inputs != first.inputs {
            let part = self.parts[0].display();
            return Err(Failure::usage(format_args!("{part} is of another version of the scans than the present one")));
        }
        if let Some(difference) = program_difference(&record.program, &first.program) {
            return Err(Failure::usage(format_args!(
                "{} is of {difference} than this program on this machine",
                self.parts[0].display()
            )));
        }
        computation.require_memory(None)?;
        let provenance = computation.provenance()?;
        let inputs = computation.inputs();
        let inputs: Vec<&Path> = inputs.iter().chain(&self.parts).map(PathBuf::as_path).collect();
        let staging = begin_folder("--out", &self.out, self.force, &inputs)?;
        removed_at_exit(&staging, monitor);
        computation.require_disk(&self.out)?;
        let blocks = open(&self.out, record, if self.finish { Share::All } else { Share::None })?;
        for part in &self.parts {
            blocks.import(part).map_err(|e| store_failure(&e))?;
        }
        let Some(computed) = computation.compute(&blocks, self.json, monitor)? else {
            let rounds = blocks.rounds();
            if self.json {
                Answer::default().with("complete", false).with("rounds", as_json(&rounds)).print(true)?;
            }
            let words = missing(&rounds);
            let advice = "compute the parts again beside --out, or add --finish";
            return Err(Failure::new(Kind::Data, format!("blocks are missing: {words}; {advice}")));
        };
        let written = computation.write(staging, &computed, provenance, &blocks, monitor)?;
        found(&computed).print(self.json, &written)
    }
}
