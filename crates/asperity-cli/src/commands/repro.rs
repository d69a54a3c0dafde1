//! Reproduction of a finished run.

use std::fs;
use std::path::PathBuf;

use asperity::study::{StoreError, StoredRun, result_files};
use clap::Args;
use serde_json::Value;

use super::study_file;
use crate::failure::{Failure, Kind};
use crate::monitor::Terminal;
use crate::output::print;
use crate::run_folder::{load_failure, store_failure};

/// Computes a finished run again, without its stored blocks, and compares all results, tables and fields: prints IDENTICAL, or the first
/// difference (exit code 1).
#[derive(Debug, Args)]
pub(crate) struct Repro {
    /// Folder of a finished run.
    dir: PathBuf,
}

impl Repro {
    pub(crate) fn run(&self, monitor: &Terminal) -> Result<(), Failure> {
        let stored = StoredRun::load(&self.dir).map_err(|e| load_failure(&e))?;
        let only = stored.provenance.only.as_deref().map(str::parse).transpose();
        let only = only.map_err(|error| Failure::data(self.dir.display(), &error))?;
        let file = self.dir.join("study.toml");
        let (study, text) = study_file::study(&file, None)?;
        let outcome = study
            .run(study_file::folder_of(&file), only, monitor)
            .map_err(|error| study_file::failure(&file, Some(&text), &error))?;
        let mut difference = None;
        result_files(&outcome, |name, bytes| {
            if difference.is_none() {
                let path = self.dir.join(name);
                let before = fs::read(&path).map_err(|source| StoreError::Io { path, source })?;
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
