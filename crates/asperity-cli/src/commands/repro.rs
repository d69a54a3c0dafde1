//! Reproduction of a finished run.

use std::fs;
use std::path::PathBuf;

use asperity::study::{
    BlockPlace, Computed, Provenance, RunStatus, Share, StoreError, StoredCampaign, StoredRun, campaign_files,
    program_difference, result_files,
};
use clap::Args;
use serde_json::Value;

use super::computation::{Computation, open};
use crate::failure::{Failure, Kind};
use crate::monitor::Terminal;
use crate::output::print;
use crate::run_folder::{load_failure, store_failure};

/// Computes a finished run again and compares all its numbers.
///
/// Uses no stored blocks. Prints IDENTICAL, or the first difference of results, tables and fields (exit code 1). With --sample, computes one
/// sample again, of a run that need not be finished.
#[derive(Debug, Args)]
pub(crate) struct Repro {
    /// Folder of the run.
    dir: PathBuf,
    /// Compute this sample alone, named as `asperity status` lists failed ones; prints the reason of its failure, and whether the stored
    /// sample is identical.
    #[arg(long, value_name = "TASK:INDEX")]
    sample: Option<BlockPlace>,
}

impl Repro {
    pub(crate) fn run(&self, monitor: &Terminal) -> Result<(), Failure> {
        if let Some(place) = &self.sample {
            return self.sample(place, monitor);
        }
        let mut members = Vec::new();
        let (computation, provenance) = if StoredCampaign::is_campaign(&self.dir) {
            let stored = StoredCampaign::load(&self.dir).map_err(|e| load_failure(&e))?;
            members = stored.results.members;
            (Computation::campaign(&self.dir.join("campaign.toml"), None)?, stored.provenance)
        } else {
            let stored = StoredRun::load(&self.dir).map_err(|e| load_failure(&e))?;
            let only = stored.provenance.only.as_deref().map(str::parse).transpose();
            let only = only.map_err(|error| Failure::data(self.dir.display(), &error))?;
            (Computation::study(&self.dir.join("study.toml"), None, only)?, stored.provenance)
        };
        self.require_inputs(&computation, &provenance)?;
        match computation.again(monitor)? {
            Computed::Run(outcome) => self.compare(|write| result_files(&outcome, write)),
            Computed::Campaign(mut results) => {
                // Scans have absolute paths in the folder's campaign.
                for (own, before) in results.members.iter_mut().zip(members) {
                    own.scan = before.scan;
                }
                self.compare(|write| campaign_files(&results, write))
            }
        }
    }

    /// Fails if a scan has changed since.
    fn require_inputs(&self, computation: &Computation, stored: &Provenance) -> Result<(), Failure> {
        let data = computation.data_hashes()?;
        let changed = data.iter().find(|(name, hash)| stored.inputs.get(*name).is_some_and(|own| own != *hash));
        changed.map_or(Ok(()), |(name, _)| {
            Err(Failure::new(Kind::Data, format!("{name} has changed since {} was computed", self.dir.display())))
        })
    }

    /// Compares the files of the folder with those of a repetition.
    fn compare(
        &self,
        files: impl FnOnce(&mut dyn FnMut(&str, &[u8]) -> Result<(), StoreError>) -> Result<(), StoreError>,
    ) -> Result<(), Failure> {
        let mut difference = None;
        files(&mut |name, bytes| {
            if difference.is_none() {
                let path = self.dir.join(name);
                let before = fs::read(&path).map_err(|source| StoreError::Input { path, source })?;
                difference = first_difference(name, &before, bytes);
            }
            Ok(())
        })
        .map_err(|e| store_failure(&e))?;
        match difference {
            None => print("IDENTICAL\n"),
            Some(difference) => {
                print(&format!("{difference}\n"))?;
                Err(Failure::new(Kind::Runtime, "the run is not reproduced"))
            }
        }
    }

    /// Computes one sample again.
    fn sample(&self, place: &BlockPlace, monitor: &Terminal) -> Result<(), Failure> {
        let unknown = || Failure::new(Kind::Data, format!("{}: no blocks of a run", self.dir.display()));
        let record = RunStatus::read(&self.dir).ok_or_else(unknown)?.record;
        let computation = Computation::of(&record)?;
        let own = computation.record(record.shard)?;
        if let Some(difference) = program_difference(&own.program, &record.program) {
            let dir = self.dir.display();
            return Err(Failure::usage(format_args!("{dir} is of {difference} than this program on this machine")));
        }
        let blocks = open(&self.dir, own, Share::Again(place.clone()))?;
        let found = computation.compute(&blocks, false, monitor);
        let Some(replay) = blocks.replay() else {
            found?;
            let of_task: Vec<_> = blocks.rounds().into_iter().filter(|round| round.name == place.task).collect();
            let has = match of_task.as_slice() {
                [] => "the run has no such task; `asperity status` lists the tasks".to_owned(),
                loops => loops.get(usize::try_from(place.ordinal).unwrap_or(usize::MAX)).map_or_else(
                    || format!("the run has {} loops of this task", loops.len()),
                    |own| format!("this loop has the indices 0 to {}", own.expected.saturating_sub(1)),
                ),
            };
            return Err(Failure::usage(format_args!("--sample {place}: {has}")));
        };
        if let Some(reason) = &replay.failure {
            print(&format!("{reason}\n"))?;
        }
        match replay.identical {
            Some(true) => print("IDENTICAL\n"),
            Some(false) => Err(Failure::new(Kind::Runtime, format!("{place} differs from the stored sample"))),
            None => print(if replay.failure.is_some() { "" } else { "the sample does not fail; none is stored\n" }),
        }
    }
}

/// Returns the first difference between two versions of a file in words.
fn first_difference(name: &str, before: &[u8], now: &[u8]) -> Option<String> {
    if before == now {
        return None;
    }
    if let (Ok(before), Ok(now)) = (serde_json::from_slice(before), serde_json::from_slice(now))
        && let Some(found) = first_value(&before, &now)
    {
        return Some(format!("{name}: {found}"));
    }
    let texts = (std::str::from_utf8(before), std::str::from_utf8(now));
    if let (Ok(before), Ok(now)) = texts {
        let mut lines = before.lines().zip(now.lines()).enumerate();
        if let Some((line, (before, now))) = lines.find(|(_, (before, now))| before != now) {
            return Some(format!("{name}:{}: {before} before, {now} now", line + 1));
        }
    }
    Some(format!("{name}: {} bytes before, {} bytes now", before.len(), now.len()))
}

/// Returns the first difference between two values: its path, and both.
fn first_value(before: &Value, now: &Value) -> Option<String> {
    match (before, now) {
        (Value::Object(old), Value::Object(new)) => {
            let keys = old.keys().chain(new.keys().filter(|key| !old.contains_key(*key)));
            keys.into_iter().find_map(|key| {
                let value = |of: &serde_json::Map<String, Value>| of.get(key).cloned().unwrap_or(Value::Null);
                first_value(&value(old), &value(new)).map(|found| format!("{key}.{found}").replace(". ", " "))
            })
        }
        (Value::Array(old), Value::Array(new)) if old.len() == new.len() => {
            let mut pairs = old.iter().zip(new).enumerate();
            pairs.find_map(|(place, (old, new))| {
                first_value(old, new).map(|found| format!("{place}.{found}").replace(". ", " "))
            })
        }
        _ => (before != now).then(|| format!(" {before} before, {now} now")),
    }
}
