//! Record of a run before it is finished.

use std::collections::{BTreeMap, BTreeSet};
use std::fs;
use std::io::Write;
use std::path::{Path, PathBuf};

use asperity_formats::replace_file;
use serde::{Deserialize, Serialize, Serializer};

use asperity_results::{Program, Stage};

use crate::{StoreError, file_hash, json_bytes};

/// Extension of records.
const EXTENSION: &str = "json";

/// Run whose blocks a folder holds.
#[derive(Debug, Clone, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct RunRecord {
    /// Name of the study.
    pub name: String,
    /// File of the study or of the campaign, an absolute path. What is no Unicode in it is replaced where the record is written.
    #[serde(serialize_with = "lossy")]
    pub file: PathBuf,
    /// Text of the study; of a campaign, that of the study which its members vary.
    pub study: String,
    /// Text of the campaign; `None` for the run of a study.
    #[serde(default)]
    pub campaign: Option<String>,
    /// Seed of the run.
    pub seed: u64,
    /// The stage that was asked for, if not all.
    pub only: Option<Stage>,
    /// SHA-256 of the scans and of other files that the study reads, by name.
    #[serde(default)]
    pub inputs: BTreeMap<String, String>,
    /// Program, instruction sets and mathematical library, which determine, with the study, the bits of a block.
    pub program: Program,
    /// Number of this part from 1, and of all parts.
    pub shard: Option<[usize; 2]>,
    /// Names of the stages begun so far, with the names of the folders of their blocks.
    pub stages: Vec<(String, String)>,
    /// Folders of blocks that earlier runs of the same name used.
    pub earlier: BTreeSet<String>,
    /// Whether all stages are finished.
    pub finished: bool,
}

fn lossy<S: Serializer>(path: &Path, serializer: S) -> Result<S::Ok, S::Error> {
    path.to_string_lossy().serialize(serializer)
}

/// Returns the program in a file, the hash of the list of its libraries, and the instruction sets and functions of this machine. They
/// determine the last bits of results.
///
/// # Errors
/// The file cannot be read.
pub fn program(file: &Path, dependencies_sha256: String) -> Result<Program, StoreError> {
    let (instruction_sets, functions) = (instruction_sets(), elementary_functions());
    Ok(Program { sha256: file_hash(file)?, dependencies_sha256, instruction_sets, functions })
}

/// Returns the differences between two programs.
pub fn program_difference(one: &Program, other: &Program) -> Option<&'static str> {
    if (&one.sha256, &one.dependencies_sha256) != (&other.sha256, &other.dependencies_sha256) {
        Some("another program or version")
    } else if one.instruction_sets != other.instruction_sets {
        Some("other instruction sets")
    } else if one.functions != other.functions {
        Some("another mathematical library")
    } else {
        None
    }
}

/// Returns the SHA-256 of values of the elementary functions, whose last bits differ between mathematical libraries, and between processors
/// with the same library.
fn elementary_functions() -> String {
    const POINTS: u32 = 512;
    let unary = [
        f64::exp,
        f64::ln,
        f64::sin,
        f64::cos,
        f64::tan,
        f64::atan,
        f64::tanh,
        f64::sinh,
        f64::cbrt,
        f64::exp_m1,
        f64::ln_1p,
    ];
    let mut bytes = Vec::new();
    for point in 1..=POINTS {
        let x = f64::from(point) * 0.017_320_508;
        let values = unary.iter().map(|function| function(x)).chain([x.powf(1.7), x.hypot(3.1), x.atan2(0.7)]);
        values.for_each(|value| bytes.extend(value.to_le_bytes()));
    }
    super::file::sha256(&bytes)
}

/// Returns the instruction sets on which the last bits of results may depend.
fn instruction_sets() -> Vec<String> {
    #[cfg(target_arch = "x86_64")]
    let candidates = [
        ("sse4.1", std::is_x86_feature_detected!("sse4.1")),
        ("avx", std::is_x86_feature_detected!("avx")),
        ("avx2", std::is_x86_feature_detected!("avx2")),
        ("fma", std::is_x86_feature_detected!("fma")),
        ("avx512f", std::is_x86_feature_detected!("avx512f")),
    ];
    #[cfg(target_arch = "aarch64")]
    let candidates = [("neon", true)];
    #[cfg(not(any(target_arch = "x86_64", target_arch = "aarch64")))]
    let candidates: [(&str, bool); 0] = [];
    candidates.into_iter().filter(|(_, present)| *present).map(|(name, _)| name.to_owned()).collect()
}

impl RunRecord {
    /// Returns the differences from another part of the same run.
    pub fn difference(&self, other: &Self) -> Option<&'static str> {
        let of_study = |record: &Self| (record.study.clone(), record.campaign.clone(), record.seed, record.only);
        if of_study(self) != of_study(other) {
            return Some("another study, seed or stage");
        }
        if self.inputs != other.inputs {
            return Some("another version of the scans");
        }
        program_difference(&self.program, &other.program)
    }

    /// Returns the file of the record of a run in a folder of blocks.
    pub(super) fn path(folder: &Path, run: &Path) -> PathBuf {
        let mut name = run.file_name().unwrap_or_default().to_os_string();
        name.push(".");
        name.push(EXTENSION);
        folder.join(name)
    }

    /// Reads a record; `None` if there is none that can be read.
    pub(super) fn read(path: &Path) -> Option<Self> {
        serde_json::from_slice(&fs::read(path).ok()?).ok()
    }

    pub(super) fn write(&self, path: &Path) -> Result<(), StoreError> {
        let bytes = json_bytes(self)?;
        let folder = path.parent().unwrap_or(path);
        let written = fs::create_dir_all(folder).and_then(|()| replace_file(path, |file| file.write_all(&bytes)));
        written.map_err(|source| StoreError::Io { path: path.into(), source })
    }

    /// Returns the records in a folder of blocks, with their files.
    pub(super) fn all(folder: &Path) -> Vec<(PathBuf, Self)> {
        let paths = fs::read_dir(folder).into_iter().flatten().flatten().map(|entry| entry.path());
        let mut found: Vec<_> = paths
            .filter(|path| path.extension().is_some_and(|extension| extension == EXTENSION))
            .filter_map(|path| Self::read(&path).map(|record| (path, record)))
            .collect();
        found.sort_by(|a, b| a.0.cmp(&b.0));
        found
    }

    /// Returns the folders of blocks that this run and earlier ones of its name use.
    pub(super) fn folders(&self) -> impl Iterator<Item = &String> {
        self.stages.iter().map(|(_, name)| name).chain(&self.earlier)
    }

    /// Removes those of the folders `names` of blocks that no run in `folder` uses.
    pub(super) fn remove_unused(folder: &Path, names: &BTreeSet<String>) {
        let records = Self::all(folder);
        let used: BTreeSet<&String> = records.iter().flat_map(|(_, record)| record.folders()).collect();
        for name in names.iter().filter(|name| !used.contains(name)) {
            let unused = folder.join(name);
            for file in super::file::files(&unused) {
                // Another process may remove it at the same time.
                let _ = fs::remove_file(file);
            }
            // A folder that holds anything else stays.
            let _ = fs::remove_dir(unused);
        }
    }
}
