//! Where a run comes from: versions, hashes, timings, machine. The only place where a clock is read for a result.

use std::collections::BTreeMap;
use std::fs;
use std::path::Path;
use std::time::{SystemTime, UNIX_EPOCH};

use serde::Serialize;
use sha2::{Digest, Sha256};

use crate::failure::{Failure, Kind};

/// The content of `provenance.json`.
#[derive(Debug, Serialize)]
pub(crate) struct Provenance {
    asperity: &'static str,
    /// Name of the study.
    study: String,
    seed: u64,
    /// SHA-256 of every input, by file name.
    inputs: BTreeMap<String, String>,
    /// The stage that was asked for, if not all.
    only: Option<String>,
    started_unix_s: u64,
    /// Seconds that each task took.
    seconds: BTreeMap<String, f64>,
    machine: Machine,
}

#[derive(Debug, Serialize)]
struct Machine {
    system: &'static str,
    architecture: &'static str,
    processor: Option<String>,
    instruction_sets: Vec<&'static str>,
    threads: usize,
}

impl Provenance {
    /// Begins the record of a run.
    pub(crate) fn begin(study: String, seed: u64, only: Option<String>) -> Self {
        Self {
            asperity: env!("CARGO_PKG_VERSION"),
            study,
            seed,
            inputs: BTreeMap::new(),
            only,
            started_unix_s: SystemTime::now().duration_since(UNIX_EPOCH).map_or(0, |since| since.as_secs()),
            seconds: BTreeMap::new(),
            machine: Machine {
                system: std::env::consts::OS,
                architecture: std::env::consts::ARCH,
                processor: processor(),
                instruction_sets: instruction_sets(),
                threads: rayon::current_num_threads(),
            },
        }
    }

    /// Notes the hash of an input file.
    pub(crate) fn input(&mut self, path: &Path) -> Result<(), Failure> {
        let bytes = fs::read(path).map_err(|e| Failure::io(Kind::Data, path.display(), &e))?;
        let mut name = path.file_name().unwrap_or_default().to_string_lossy().into_owned();
        if self.inputs.contains_key(&name) {
            // A file of the same name in another folder.
            name = path.display().to_string();
        }
        self.inputs.insert(name, hex(&Sha256::digest(&bytes)));
        Ok(())
    }

    /// Notes how long the tasks took.
    pub(crate) fn end(&mut self, seconds: BTreeMap<String, f64>) {
        self.seconds = seconds;
    }
}

fn hex(bytes: &[u8]) -> String {
    bytes.iter().map(|byte| format!("{byte:02x}")).collect()
}

/// The name of the processor, where the system tells it.
fn processor() -> Option<String> {
    let text = fs::read_to_string("/proc/cpuinfo").ok()?;
    let line = text.lines().find(|line| line.starts_with("model name"))?;
    Some(line.split_once(':')?.1.trim().to_owned())
}

/// Instruction sets on which the last bits of results may depend.
fn instruction_sets() -> Vec<&'static str> {
    let mut found = Vec::new();
    #[cfg(target_arch = "x86_64")]
    for (name, present) in [
        ("sse4.1", std::is_x86_feature_detected!("sse4.1")),
        ("avx", std::is_x86_feature_detected!("avx")),
        ("avx2", std::is_x86_feature_detected!("avx2")),
        ("fma", std::is_x86_feature_detected!("fma")),
        ("avx512f", std::is_x86_feature_detected!("avx512f")),
    ] {
        if present {
            found.push(name);
        }
    }
    #[cfg(target_arch = "aarch64")]
    found.push("neon");
    found
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_hash_of_an_input_is_its_sha_256() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("abc.txt");
        fs::write(&path, "abc").unwrap();
        let mut provenance = Provenance::begin("abc".into(), 1, None);
        provenance.input(&path).unwrap();
        // FIPS 180-2, appendix B.1.
        let wanted = "ba7816bf8f01cfea414140de5dae2223b00361a396177a9cb410ff61f20015ad";
        assert_eq!(provenance.inputs["abc.txt"], wanted);
        assert_eq!(provenance.input(&folder.path().join("gone")).unwrap_err().kind(), Kind::Data);
    }
}
