//! State of a run.

use std::path::PathBuf;

use asperity::study::{RunStatus, is_finished};
use clap::Args;
use serde_json::{Value, json};

use super::computation::{as_json, as_table};
use crate::failure::{Failure, Kind};
use crate::monitor::Terminal;
use crate::output::{Answer, print};

/// Shows how far a run is, finished or not.
///
/// Lists expected, done, failed and missing samples of each task that was begun, also of a part of a run, and the reason of each failure.
/// `asperity repro DIR --sample TASK:INDEX` computes one of them again.
#[derive(Debug, Args)]
pub(crate) struct Status {
    /// Folder of the run, which need not exist yet, or of the part.
    dir: PathBuf,
    /// Print one JSON object.
    #[arg(long)]
    json: bool,
}

impl Status {
    pub(crate) fn run(&self, monitor: &Terminal) -> Result<(), Failure> {
        let complete = is_finished(&self.dir);
        let Some(status) = RunStatus::read(&self.dir) else {
            if complete {
                monitor.note("the blocks of this run are not stored any more");
                return Answer::default().with("complete", true).with("rounds", as_json(&[])).print(self.json);
            }
            return Err(Failure::new(Kind::Data, format!("{}: no run, and no blocks of one", self.dir.display())));
        };
        let record = &status.record;
        let is_complete = complete || record.finished;
        if !self.json {
            let state = if is_complete { "finished" } else { "not finished" };
            let part = record.shard.map_or_else(String::new, |[number, of]| format!(", part {number} of {of}"));
            let (file, seed) = (record.file.display(), record.seed);
            let mut text = format!("{file}, seed {seed}{part}: {state}\n\n{}", as_table(&status.rounds));
            for failure in &status.failures {
                let again = format!("asperity repro {} --sample {}", self.dir.display(), failure.place);
                text += &format!("\n{}: {}\n  {again}\n", failure.place, failure.reason);
            }
            return print(&text);
        }
        let failures: Vec<Value> = status
            .failures
            .iter()
            .map(|failure| {
                json!({
                    "stage": failure.stage,
                    "sample": failure.place.to_string(),
                    "index": failure.place.index,
                    "seed": record.seed,
                    "reason": failure.reason,
                })
            })
            .collect();
        Answer::default()
            .with("study", record.file.display().to_string())
            .with("seed", record.seed)
            .with("part", record.shard.map(|[number, _]| number))
            .with("parts", record.shard.map(|[_, of]| of))
            .with("complete", is_complete)
            .with("rounds", as_json(&status.rounds))
            .with("failures", failures)
            .print(true)
    }
}
