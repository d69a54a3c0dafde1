//! Run of a study, from its file to a run folder.

use std::path::{Path, PathBuf};
use std::time::Duration;

use asperity::quantity::Time;
use asperity::study::result::{MeasuredSurface, Results};
use asperity::study::{Share, Stage, StoredRun, file_hash, resolved_study};
use asperity_report::{verdict_sentence, vibration_answer};
use clap::Args;
use serde_json::Value;

use super::computation::{Computation, as_json, missing, open, removed_at_exit};
use super::study_file::folder_of;
use crate::args;
use crate::failure::Failure;
use crate::monitor::Terminal;
use crate::output::Answer;
use crate::run_folder::{begin_folder, load_failure, store_failure};

/// Runs a study and writes its folder: numbers, tables, fields, figures, an offline report, provenance. An interrupted run goes on from its
/// finished blocks when the same command is given again.
#[derive(Debug, Args)]
pub(crate) struct Run {
    /// Study file.
    study: PathBuf,
    /// Folder to write; runs/NAME of the study when left out. The folder appears complete or not at all.
    #[arg(long, value_name = "DIR")]
    out: Option<PathBuf>,
    /// Seed to use instead of the study's.
    #[arg(long, value_name = "N", value_parser = args::seed, allow_hyphen_values = true)]
    seed: Option<u64>,
    /// Compute only this stage and the stages that it needs.
    #[arg(long, value_parser = args::named::<Stage>(), value_name = "STAGE")]
    only: Option<Stage>,
    /// Replace a folder that asperity wrote. A folder that contains an input, or a file that asperity did not write or
    /// that has changed, is never replaced.
    #[arg(long)]
    force: bool,
    /// Accept the finished run of the same study as the result.
    #[arg(long, conflicts_with = "shard")]
    resume: bool,
    /// Compute part I of N, I from 1, of the blocks that can be computed now. --out is then the folder of these blocks;
    /// `asperity merge` makes the run of all parts.
    #[arg(long, value_name = "I/N", value_parser = args::shard)]
    shard: Option<[usize; 2]>,
    /// Stop after this time, such as "2 h", and keep the finished blocks (exit code 5).
    #[arg(long, value_name = "TIME", value_parser = args::positive_quantity::<Time>)]
    max_time: Option<Time>,
    /// Refuse a run that needs more memory, such as "4 GB" (exit code 5).
    #[arg(long, value_name = "SIZE", value_parser = args::bytes)]
    max_memory: Option<f64>,
    /// Print results.json to stdout as well.
    #[arg(long)]
    json: bool,
}

impl Run {
    pub(crate) fn run(&self, monitor: &Terminal) -> Result<(), Failure> {
        let computation = Computation::read(&self.study, self.seed, self.only)?;
        let destination = self.out.clone().unwrap_or_else(|| default_destination(&self.study));
        if let Some(time) = self.max_time {
            monitor.limit_time(Duration::try_from_secs_f64(time.0).unwrap_or(Duration::MAX));
        }
        computation.require_memory(self.max_memory)?;
        if let Some(shard) = self.shard {
            return self.part(&computation, shard, monitor);
        }
        if self.resume
            && let Some(results) = finished(&computation, &destination)?
        {
            monitor.note(&format!("{} is finished", destination.display()));
            return self.print(&results, &destination);
        }
        let provenance = computation.provenance()?;
        // Check the folder before a long computation.
        let inputs = computation.inputs();
        let inputs: Vec<&Path> = inputs.iter().map(PathBuf::as_path).collect();
        let staging = begin_folder("--out", &destination, self.force, &inputs)?;
        removed_at_exit(&staging, monitor);
        computation.require_disk(&destination)?;
        let blocks = open(&destination, computation.record(None)?, Share::All)?;
        let outcome = computation.compute(&blocks, self.json, monitor)?;
        let written = computation.write(staging, &outcome, provenance, &blocks, monitor)?;
        self.print(&outcome.results, &written)
    }

    /// Computes one part of the blocks.
    fn part(&self, computation: &Computation, shard: [usize; 2], monitor: &Terminal) -> Result<(), Failure> {
        let [number, of] = shard;
        let folder = self.out.clone().unwrap_or_else(|| {
            let name = format!("{}-part-{number}-of-{of}", computation.name);
            default_destination(&self.study).with_file_name(name)
        });
        if StoredRun::is_run(&folder) {
            return Err(Failure::usage(format_args!(
                "--out {} is a run; give another folder for the blocks",
                folder.display()
            )));
        }
        let blocks = open(&folder, computation.record(Some(shard))?, Share::Part { number, of })?;
        let complete = match computation.compute(&blocks, self.json, monitor) {
            Ok(_) => true,
            Err(_) if blocks.is_incomplete() && monitor.check().is_ok() => false,
            Err(failure) => return Err(failure),
        };
        // A merge reads it.
        blocks.write_record().map_err(|e| store_failure(&e))?;
        let rounds = blocks.rounds();
        if !complete {
            monitor.note(&format!("blocks of other parts are missing: {}", missing(&rounds)));
        }
        Answer::default()
            .with("part", number)
            .with("parts", of)
            .with("complete", complete)
            .with("rounds", as_json(&rounds))
            .with("folder", folder.display().to_string())
            .print(self.json)
    }

    fn print(&self, results: &Results, folder: &Path) -> Result<(), Failure> {
        let answer = if self.json { Answer::new(results)? } else { headline(results, folder) };
        answer.print(self.json)
    }
}

/// Returns the results of a finished run of the same study; `None` if there is no folder, or an empty one.
fn finished(computation: &Computation, folder: &Path) -> Result<Option<Results>, Failure> {
    let is_empty = std::fs::read_dir(folder).map_or(!folder.exists(), |mut entries| entries.next().is_none());
    if is_empty {
        return Ok(None);
    }
    let run = StoredRun::load(folder).map_err(|e| load_failure(&e))?;
    let resolved = resolved_study(&computation.study, folder_of(&computation.file)).map_err(|e| store_failure(&e))?;
    let only = computation.only.map(|stage| stage.name());
    let mut same = run.study == resolved && run.provenance.only.as_deref() == only;
    for file in computation.data() {
        let hash = file_hash(&file).map_err(|e| load_failure(&e))?;
        same &= run.provenance.inputs.values().any(|own| *own == hash);
    }
    if same {
        return Ok(Some(run.results));
    }
    Err(Failure::usage(format_args!("--resume: {} is the run of another study", folder.display())))
}

/// Returns the default folder of a run.
pub(super) fn default_destination(study: &Path) -> PathBuf {
    Path::new("runs").join(study.file_stem().unwrap_or_default())
}

/// Returns the main results, and the folder of the others.
pub(super) fn headline(results: &Results, folder: &Path) -> Answer {
    let mut answer = Answer::default();
    let mut show = |key: &str, value: Value| answer = std::mem::take(&mut answer).with(key, value);
    if let Some(verdict) = &results.verdict {
        show("verdict", verdict_sentence(verdict).into());
    }
    if let Some(scan) = results.surface.as_ref().map(|surface| &surface.measured) {
        let number = |name: &str| match scan {
            MeasuredSurface::Scan(scan) => Some(scan.number(name)),
            MeasuredSurface::Part(part) => Some(part.pooled.get(name).map(|pooled| pooled.value)),
            MeasuredSurface::Stated {} => None,
        };
        for name in ["Sq_m", "correlation_length_x_m", "correlation_length_y_m"] {
            if let Some(value) = number(name) {
                show(name, value.into());
            }
        }
    }
    // The lengths of the scan come first, then those of the covariance. A fitted model need not reproduce the scan's
    // length, and its length parameter may differ from its 1/e length.
    if let Some(covariance) = results.surface.as_ref().and_then(|surface| surface.covariance.as_ref()) {
        show("covariance", covariance.model.as_str().into());
        show("covariance_length_x_m", covariance.length_x_m.into());
        show("covariance_length_y_m", covariance.length_y_m.into());
        show("covariance_decay_length_x_m", covariance.decay_length_x_m.into());
        show("covariance_decay_length_y_m", covariance.decay_length_y_m.into());
    }
    let point = results.friction.as_ref().map(|friction| &friction.operating_point);
    let vibration = results.vibration.as_ref();
    // Contact and friction at the operating point, if there is one: the coefficient that drives the vibration.
    if let Some(point) = point {
        show("operating_point", point.level.as_str().into());
        show("mean_pressure_pa", point.mean_pressure_pa.into());
        show("contact_probability", point.contact_fraction.into());
        show("friction_mean", point.mean.into());
        // The mean of short strips has no interval.
        if let Some([low, high]) = point.mean_interval {
            show("friction_mean_interval", vec![low, high].into());
        }
    } else {
        if let Some(pressure) = &results.pressure {
            show("contact_probability", pressure.contact_probability.into());
        }
        if let Some(vibration) = vibration {
            show("friction_mean", vibration.static_friction.into());
        }
    }
    if let Some(vibration) = vibration {
        // The standard deviation of the study's main upscaling.
        let main = if vibration.upscaling == "paper" { &vibration.paper } else { &vibration.area };
        show("friction_std", main.friction_std.into());
        // A part of a rough slider has constant friction.
        match point.filter(|_| vibration.friction_correlation_length_m.is_none()) {
            Some(point) if vibration.upscaling == "paper" => show("friction_std_between_parts", point.std.into()),
            Some(point) => show("friction_std_between_parts", point.std_nominal_area.into()),
            None => show("friction_correlation_length_m", vibration.friction_correlation_length_m.into()),
        }
        show("critical_damping_ratio", vibration.critical_damping_ratio.into());
        show("limit_damping_ratio", vibration.limit_damping_ratio.into());
        show("kind", vibration.kind.name().into());
        show("period", vibration.cycle.period.into());
        show("vibrates", vibration_answer(vibration).into());
    } else if let Some(point) = point {
        show("friction_std", point.std.into());
    }
    if let Some(coupled) = &results.mode_coupling {
        show("friction", coupled.friction.into());
        show("critical_friction", coupled.critical_friction.into());
        show("limit_damping_ratio", coupled.limit_damping_ratio.into());
        show("kind", coupled.kind.name().into());
        show("frequency_hz", coupled.cycle.map(|cycle| cycle.frequency_hz).into());
    }
    answer.with("folder", folder.display().to_string())
}
