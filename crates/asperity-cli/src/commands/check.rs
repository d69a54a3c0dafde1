//! Check of a study without computing anything.

use std::path::{Path, PathBuf};

use asperity::study::{Stage, StageEstimate, Study, UncertainValue, folder_of};
use clap::Args;
use serde_json::{Value, json};

use super::computation::default_destination;
use super::study_file;
use crate::failure::{Failure, Kind};
use crate::monitor::{Terminal, duration};
use crate::output::{Answer, print, print_sentences};
use crate::resources::{require_disk, require_memory};

/// Shows what a study computes, its cost and its problems.
///
/// Fills in all values, reads the scans and computes no results. Exits with 2 if the study cannot run as it is, with 5 if the
/// machine has too little memory for it.
#[derive(Debug, Args)]
pub(crate) struct Check {
    /// Study file.
    study: PathBuf,
    /// Print the study with all its values, in the order of the file, and the cost of each stage.
    #[arg(long, conflicts_with = "json")]
    show: bool,
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
        let destination = default_destination(&self.study, &study);
        problems.extend(require_disk(study.disk_bytes(), &destination, "the run").err());
        monitor.check()?;
        if self.json {
            warnings.iter().for_each(|warning| monitor.warn(warning));
        }
        let (study, stages) = (&study, &stages[..]);
        self.print(&Checked { study, text: &text, stages, threads, warnings: &warnings, problems: &problems })?;
        problems.into_iter().next().map_or(Ok(()), Err)
    }

    fn print(&self, checked: &Checked<'_>) -> Result<(), Failure> {
        let Checked { study, text, stages, threads, warnings, problems } = checked;
        if self.json {
            let resolved = study.file().to_table().map_err(|e| Failure::new(Kind::Runtime, e.to_string()))?;
            let resolved = serde_json::to_value(resolved).map_err(|e| Failure::new(Kind::Runtime, e.to_string()))?;
            let estimate: Vec<Value> = stages.iter().map(|stage| as_json(stage, *threads)).collect();
            let problems: Vec<&str> = problems.iter().map(Failure::message).collect();
            return Answer::default()
                .with("study", resolved)
                .with("estimate", estimate)
                .with("warnings", *warnings)
                .with("problems", problems)
                .print(true);
        }
        if !self.show {
            return print_sentences(&checked.sentences(&self.study));
        }
        let mut lines =
            vec![format!("{} with all its values; this output is a valid study file.", self.study.display())];
        lines.extend(stages.iter().map(|stage| describe(stage, *threads)));
        lines.extend(warnings.iter().map(|warning| format!("warning: {warning}")));
        lines.extend(problems.iter().map(|problem| format!("problem: {}", problem.message())));
        let comments: String = lines.iter().map(|line| format!("# {line}\n")).collect();
        let all = study.file().complete(text).map_err(|e| Failure::new(Kind::Runtime, e.to_string()))?;
        print(&format!("{comments}\n{all}"))
    }
}

/// A study, what it costs and what is wrong with it.
struct Checked<'a> {
    study: &'a Study,
    text: &'a str,
    stages: &'a [StageEstimate],
    threads: usize,
    warnings: &'a [String],
    problems: &'a [Failure],
}

impl Checked<'_> {
    /// Describes the study in about six sentences.
    fn sentences(&self, path: &Path) -> Vec<String> {
        let (file, path) = (self.study.file(), path.display());
        let names: Vec<&str> = self.stages.iter().map(|stage| stage.stage.name()).collect();
        let mut sentences = vec![format!("{path} computes: {}.", names.join(" → "))];
        let of_kind = |unknown| {
            let values = file.uncertain.iter().map(UncertainValue::input).filter(|input| input.is_unknown() == unknown);
            values.map(|input| format!("`{}`", input.name())).collect::<Vec<_>>()
        };
        for (unknown, words) in [(false, "Varies from part to part"), (true, "One value, not known")] {
            let values = of_kind(unknown);
            sentences.extend((!values.is_empty()).then(|| format!("{words}: {}.", values.join(", "))));
        }
        let unstated: Vec<String> = file.unstated.iter().map(|name| format!("`{name}`")).collect();
        sentences
            .extend((!unstated.is_empty()).then(|| format!("Not stated, so by default: {}.", unstated.join(", "))));
        let seconds = |stage: &StageEstimate| stage.core_seconds / self.threads as f64;
        let longest = self.stages.iter().max_by(|a, b| a.core_seconds.total_cmp(&b.core_seconds));
        let most = longest.map_or(String::new(), |stage| {
            format!(", {} of them for the {} stage", duration(seconds(stage)), stage.stage.name())
        });
        let bytes = self.stages.iter().map(|stage| stage.memory_bytes).fold(0.0, f64::max);
        sentences.push(format!(
            "Cost: roughly {} on {} threads{most}; {:.0} MB of memory, {:.0} MB on the disk.",
            duration(self.stages.iter().map(seconds).sum()),
            self.threads,
            bytes * 1e-6,
            self.study.disk_bytes() * 1e-6
        ));
        sentences.extend(self.warnings.iter().map(|warning| format!("warning: {warning}")));
        sentences.extend(self.problems.iter().map(|problem| format!("problem: {}", problem.message())));
        sentences.push(match self.problems {
            [] => {
                format!("No problems: `asperity run {path}` computes it. All values: `asperity check {path} --show`.")
            }
            _ => format!("It cannot run as it is. All values: `asperity check {path} --show`."),
        });
        sentences
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
