//! Check of a study without computing anything.

use std::path::PathBuf;

use asperity::study::{Stage, StageEstimate, Study, folder_of};
use clap::Args;
use serde_json::{Value, json};

use super::computation::default_destination;
use super::study_file;
use crate::failure::{Failure, Kind};
use crate::monitor::Terminal;
use crate::output::{Answer, print};
use crate::resources::{require_disk, require_memory};

/// Shows what a study computes, its values, its cost and its problems.
///
/// Fills in all values, reads the scans and computes no results. Exits with 2 if the study cannot run as it is, with 5 if the
/// machine has too little memory for it.
#[derive(Debug, Args)]
pub(crate) struct Check {
    /// Study file.
    study: PathBuf,
    /// Print one JSON object: study, estimate, warnings, problems.
    #[arg(long)]
    json: bool,
}

impl Check {
    pub(crate) fn run(&self, monitor: &Terminal) -> Result<(), Failure> {
        let (study, text) = study_file::study(&self.study, None)?;
        let folder = folder_of(&self.study);
        let failure = |e| study_file::failure(&self.study, Some(&text), &e);
        let mut warnings = study.check_scans(folder).map_err(failure)?;
        let mut problems = Vec::new();
        match study.check_before_run(folder) {
            Ok(found) => warnings.extend(found),
            Err(e) => {
                let failure = failure(e);
                // A friction process that cannot be read or used is an error.
                if failure.kind() == Kind::Data {
                    return Err(failure);
                }
                warnings.extend(study.warnings());
                problems.push(failure);
            }
        }
        let threads = rayon::current_num_threads();
        let stages = study.estimate(study.scan_points(folder).map_err(failure)?, threads);
        for stage in &stages {
            problems.extend(require_memory(stage.memory_bytes, &format!("the {} stage", stage.stage.name())).err());
        }
        let destination = default_destination(&self.study);
        problems.extend(require_disk(study.disk_bytes(), &destination, "the run").err());
        monitor.check()?;
        warnings.iter().for_each(|warning| monitor.warn(warning));
        self.print(&study, &stages, threads, &warnings, &problems)?;
        problems.into_iter().next().map_or(Ok(()), Err)
    }

    fn print(
        &self,
        study: &Study,
        stages: &[StageEstimate],
        threads: usize,
        warnings: &[String],
        problems: &[Failure],
    ) -> Result<(), Failure> {
        if self.json {
            let resolved = study.file().to_table().map_err(|e| Failure::new(Kind::Runtime, e.to_string()))?;
            let resolved = serde_json::to_value(resolved).map_err(|e| Failure::new(Kind::Runtime, e.to_string()))?;
            let estimate: Vec<Value> = stages.iter().map(|stage| as_json(stage, threads)).collect();
            let problems: Vec<&str> = problems.iter().map(Failure::message).collect();
            return Answer::default()
                .with("study", resolved)
                .with("estimate", estimate)
                .with("warnings", warnings)
                .with("problems", problems)
                .print(true);
        }
        let resolved = study
            .file()
            .to_table()
            .and_then(|table| toml::to_string(&table))
            .map_err(|e| Failure::new(Kind::Runtime, e.to_string()))?;
        let mut text = format!("# {} with all its values; this output is a valid study file.\n", self.study.display());
        for stage in stages {
            text += &format!("# {}\n", describe(stage, threads));
        }
        for warning in warnings {
            text += &format!("# warning: {warning}\n");
        }
        for problem in problems {
            text += &format!("# problem: {}\n", problem.message());
        }
        print(&(text + "\n" + &resolved))
    }
}

fn as_json(stage: &StageEstimate, threads: usize) -> Value {
    json!({
        "stage": stage.stage.name(),
        "contact_solutions": stage.contact_solutions,
        "coarse_solutions": stage.coarse_solutions,
        "trajectories": stage.trajectories,
        "machines": stage.machines,
        "core_s": stage.core_seconds,
        "memory_bytes": stage.memory_bytes,
        "threads": threads,
    })
}

/// Describes the work of the verdict.
fn verdict_work(solutions: usize, trajectories: usize, machines: usize) -> String {
    let parts = [(machines, "machines"), (trajectories, "trajectories"), (solutions, "contact solutions")];
    let parts: Vec<String> =
        parts.iter().filter(|(count, _)| *count > 0).map(|(count, name)| format!("about {count} {name}")).collect();
    parts.join(", ")
}

fn describe(stage: &StageEstimate, threads: usize) -> String {
    let work = match (stage.contact_solutions, stage.trajectories) {
        (solutions, trajectories) if stage.stage == Stage::Verdict => {
            verdict_work(solutions, trajectories, stage.machines)
        }
        (solutions, 0) if stage.coarse_solutions > 0.0 => format!(
            "{solutions} contact solutions, and solutions on other grids that cost up to {:.0} more",
            stage.coarse_solutions.ceil()
        ),
        _ if stage.stage == Stage::Surface => return format!("surface: {:.0} MB", stage.memory_bytes * 1e-6),
        (solutions, 0) => format!("{solutions} contact solutions"),
        (_, trajectories) => format!("{trajectories} trajectories"),
    };
    format!(
        "{}: {work}, roughly {:.1} s of one core ({threads} threads), {:.0} MB",
        stage.stage.name(),
        stage.core_seconds,
        stage.memory_bytes * 1e-6
    )
}
