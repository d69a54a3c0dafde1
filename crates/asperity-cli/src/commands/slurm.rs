//! Script that computes a study in parts with Slurm.

use std::fmt::Write as _;
use std::io::Write as _;
use std::path::{Path, PathBuf};

use asperity::quantity::Time;
use clap::Args;

use super::computation::Computation;
use crate::args;
use crate::failure::{Failure, Kind};
use crate::monitor::Terminal;
use crate::output::{replace_file, write_verb};

/// The script after its options and variables.
const JOBS: &str = include_str!("slurm.sh");

/// Writes a script that submits a study to Slurm.
///
/// NAME.slurm.sh submits a job array and a dependent job that merges the parts. The program and all folders must be on a disk that the nodes
/// share.
#[derive(Debug, Args)]
pub(crate) struct Slurm {
    /// Study file.
    study: PathBuf,
    /// Number of parts: tasks of the array.
    #[arg(long, value_name = "N", value_parser = args::count)]
    tasks: usize,
    /// Folder of the run; runs/NAME of the study when left out. The parts are in RUN-part-I-of-N.
    #[arg(long, value_name = "RUN")]
    out: Option<PathBuf>,
    /// Number of arrays, each followed by a merge. An array computes the loops whose inputs are known; the last merge computes what is left.
    #[arg(long, value_name = "K", value_parser = args::count, default_value = "1")]
    rounds: usize,
    /// Time limit of each job, such as "2 h"; the limit of the partition when left out.
    #[arg(long, value_name = "TIME", value_parser = args::positive_quantity::<Time>)]
    time: Option<Time>,
    /// Memory of each job, such as "4 GB"; the default of the partition when left out.
    #[arg(long, value_name = "SIZE", value_parser = args::bytes)]
    memory: Option<f64>,
    /// Number of processors of each job.
    #[arg(long, value_name = "N", value_parser = args::threads, default_value = "1")]
    cpus: usize,
    /// Replace the script.
    #[arg(long)]
    force: bool,
}

impl Slurm {
    pub(crate) fn run(&self, monitor: &Terminal) -> Result<(), Failure> {
        let computation = Computation::study(&self.study, None, None)?;
        let name = computation.name();
        let script = PathBuf::from(format!("{name}.slurm.sh"));
        if script.exists() && !self.force {
            let script = script.display();
            return Err(Failure::usage(format_args!("{script} exists already; --force replaces it")));
        }
        let text = self.script(&computation)?;
        let verb = write_verb(&script);
        replace_file(&script, |file| file.write_all(text.as_bytes()))?;
        monitor.note(&format!("{verb} {}; next: sh {}", script.display(), shell_word(&script)?));
        Ok(())
    }

    /// Returns the text of the script.
    fn script(&self, computation: &Computation) -> Result<String, Failure> {
        const SECONDS_PER_MINUTE: f64 = 60.0;
        const BYTES_PER_MEBIBYTE: f64 = 1_048_576.0;
        let run = self.out.clone().unwrap_or_else(|| computation.destination());
        let asperity = std::env::current_exe().map_err(|e| Failure::io(Kind::Runtime, "the program file", &e))?;
        let mut text = format!("#!/bin/sh\n#SBATCH --cpus-per-task={}\n", self.cpus);
        // Slurm counts limits in whole minutes and, with M, in mebibytes.
        if let Some(time) = self.time {
            let _ = writeln!(text, "#SBATCH --time={:.0}", (time.0 / SECONDS_PER_MINUTE).ceil());
        }
        if let Some(bytes) = self.memory {
            let _ = writeln!(text, "#SBATCH --mem={:.0}M", (bytes / BYTES_PER_MEBIBYTE).ceil());
        }
        for (name, path) in [("asperity", asperity), ("study", self.study.clone()), ("run", run)] {
            let path = std::path::absolute(&path).map_err(|e| Failure::io(Kind::Data, path.display(), &e))?;
            let _ = writeln!(text, "{name}={}", shell_word(&path)?);
        }
        let _ = writeln!(text, "parts={}\nrounds={}\n", self.tasks, self.rounds);
        Ok(text + JOBS)
    }
}

/// Quotes a path for a shell, if necessary.
fn shell_word(path: &Path) -> Result<String, Failure> {
    let text =
        path.to_str().ok_or_else(|| Failure::usage(format_args!("{}: the name is not UTF-8", path.display())))?;
    if text.chars().all(|c| c.is_ascii_alphanumeric() || "/._-".contains(c)) {
        return Ok(text.to_owned());
    }
    Ok(format!("'{}'", text.replace('\'', r"'\''")))
}
