//! A study, from its file to a run folder.

use std::path::{self, Path, PathBuf};

use asperity::study::{Outcome, Stage, StoredField, StoredRun, Study, json_bytes};
use asperity_report::vibration_answer;
use clap::{Args, ValueEnum};

use super::study_file;
use crate::args;
use crate::failure::{Failure, Kind};
use crate::monitor::Terminal;
use crate::output::Answer;
use crate::page::{begin_folder, rendered, store_failure};
use crate::provenance::Provenance;
use crate::resources::{require_disk, require_memory};

/// Runs a study and writes its folder: numbers, tables, fields, figures, an offline report, provenance.
#[derive(Debug, Args)]
pub(crate) struct Run {
    /// Study file.
    study: PathBuf,
    /// Folder to write, which appears complete or not at all; runs/NAME of the study when left out.
    #[arg(long, value_name = "DIR")]
    out: Option<PathBuf>,
    /// Another seed than the study's.
    #[arg(long, value_name = "N", value_parser = args::seed, allow_hyphen_values = true)]
    seed: Option<u64>,
    /// Only this stage and what it needs.
    #[arg(long, value_enum, value_name = "STAGE")]
    only: Option<Only>,
    /// Replace a folder that asperity wrote; one that holds any other or changed file, or an input, is refused.
    #[arg(long)]
    force: bool,
    /// Print results.json to stdout as well.
    #[arg(long)]
    json: bool,
}

#[derive(Debug, Clone, Copy, ValueEnum)]
enum Only {
    /// Statistics and random surfaces.
    Surface,
    /// The law of the random pressure.
    Pressure,
    /// Friction as a process.
    Friction,
    /// Stick-slip.
    Vibration,
}

impl From<Only> for Stage {
    fn from(only: Only) -> Self {
        match only {
            Only::Surface => Self::Surface,
            Only::Pressure => Self::Pressure,
            Only::Friction => Self::Friction,
            Only::Vibration => Self::Vibration,
        }
    }
}

impl Run {
    pub(crate) fn run(&self, monitor: &Terminal) -> Result<(), Failure> {
        let study = study_file::study(&self.study, self.seed)?;
        let folder = study_file::folder_of(&self.study);
        let only = self.only.map(Stage::from);
        for stage in study.estimate(rayon::current_num_threads()) {
            require_memory(stage.memory_bytes, &format!("the {} stage", stage.stage.name()))?;
        }
        let name = self.study.file_stem().unwrap_or_default();
        let mut provenance = Provenance::begin(
            name.to_string_lossy().into_owned(),
            study.seed,
            only.map(|stage| stage.name().to_owned()),
        );
        provenance.input(&self.study)?;
        let read: Vec<PathBuf> =
            study.scan_paths(folder).into_iter().chain(study.friction_process_path(folder)).collect();
        for file in &read {
            provenance.input(file)?;
        }
        let resolved = toml::to_string(&runnable_anywhere(&study, folder))
            .map_err(|e| Failure::new(Kind::Runtime, e.to_string()))?;
        let destination = self.out.clone().unwrap_or_else(|| default_destination(&self.study));
        // Before hours are spent: may the folder be written?
        let inputs: Vec<&Path> =
            std::iter::once(self.study.as_path()).chain(read.iter().map(PathBuf::as_path)).collect();
        let staging = begin_folder("--out", &destination, self.force, &inputs)?;
        require_disk(study.disk_bytes() + scan_field_bytes(&read), &destination, "the run")?;
        let outcome = study.run(folder, only, monitor).or_else(|e| {
            let reason = Answer::default().with("reason", e.to_string());
            Err(study_file::ended(&self.study, &e).told(reason, self.json)?)
        })?;
        for warning in &outcome.results.warnings {
            monitor.warn(warning);
        }
        provenance.end(monitor.seconds());
        let run = stored(&outcome, resolved, &provenance)?;
        let report = rendered(&run)?;
        let write = |relative: &str, bytes: &[u8]| staging.write(relative, bytes).map_err(|e| store_failure(&e));
        staging.write_outcome(&outcome).map_err(|e| store_failure(&e))?;
        write("study.toml", run.study.as_bytes())?;
        write("provenance.json", &json_bytes(&run.provenance).map_err(|e| store_failure(&e))?)?;
        for figure in &report.figures {
            write(&format!("figures/{}.svg", figure.name), figure.svg.as_bytes())?;
        }
        write("report.html", report.html.as_bytes())?;
        monitor.check()?;
        let written = staging.commit().map_err(|e| store_failure(&e))?;
        monitor.note(&format!("wrote {}", written.join("report.html").display()));
        let answer = if self.json { Answer::of(&outcome.results)? } else { headline(&run, &written) };
        answer.print(self.json)
    }
}

/// The folder of a run that is not told another.
pub(super) fn default_destination(study: &Path) -> PathBuf {
    Path::new("runs").join(study.file_stem().unwrap_or_default())
}

/// Disk space of the heights of scans in a run folder, raw and prepared, roughly: scans may be compressed.
fn scan_field_bytes(scans: &[PathBuf]) -> f64 {
    const BYTES_PER_BYTE: f64 = 8.0;
    scans.iter().filter_map(|scan| scan.metadata().ok()).map(|scan| BYTES_PER_BYTE * scan.len() as f64).sum()
}

/// The study with the files it reads named so that they are found from every folder, that of the run included.
fn runnable_anywhere(study: &Study, folder: &Path) -> Study {
    let mut study = study.clone();
    // TOML holds no path that is not Unicode; such a one stays as it was given.
    let absolute = |scan: &Path| path::absolute(folder.join(scan)).ok().filter(|path| path.to_str().is_some());
    if let Some(files) = study.surface.as_mut().and_then(|surface| surface.file.as_mut()) {
        *files = files.map(|scan| absolute(scan).unwrap_or_else(|| scan.to_path_buf()));
    }
    if let Some(file) = study.vibration.as_mut().and_then(|vibration| vibration.friction_process.as_mut()) {
        *file = absolute(file).unwrap_or_else(|| file.clone());
    }
    study
}

/// The outcome in the form in which a finished run is read back.
fn stored(outcome: &Outcome, study: String, provenance: &Provenance) -> Result<StoredRun, Failure> {
    let failed = |e: serde_json::Error| Failure::new(Kind::Runtime, e.to_string());
    let fields = outcome.fields.iter().map(|(name, field)| {
        let (dx_m, dy_m) = (field.grid.dx_m(), field.grid.dy_m());
        (name.clone(), StoredField { dx_m, dy_m, unit: field.unit.into(), values: field.values.clone() })
    });
    Ok(StoredRun {
        study,
        results: serde_json::to_value(&outcome.results).map_err(failed)?,
        provenance: serde_json::to_value(provenance).map_err(failed)?,
        tables: outcome.tables.clone(),
        fields: fields.collect(),
    })
}

/// The numbers to look at first, and where the others are.
fn headline(run: &StoredRun, folder: &Path) -> Answer {
    let results = &run.results;
    let point = &results["friction"]["operating_point"];
    // Contact and friction at the operating point, where there is one: the coefficient that drives the vibration.
    let [contact, mean, interval] = match point.is_object() {
        true => ["contact_fraction", "mean", "mean_interval"].map(|key| format!("/friction/operating_point/{key}")),
        false => ["/pressure/contact_probability", "/vibration/static_friction", ""].map(str::to_owned),
    };
    // The scatter of the upscaling that the study leads with.
    let lead = results.pointer("/vibration/upscaling").and_then(|name| name.as_str()).unwrap_or("area");
    let std = match results["vibration"].is_object() {
        true => format!("/vibration/{lead}/friction_std"),
        false => "/friction/operating_point/std".to_owned(),
    };
    let numbers = [
        ("Sq_m", "/surface/Sq_m"),
        // Of the scan, then of the covariance: a fit need not meet the length of the scan, and what its model calls a length
        // may be another than that to 1/e.
        ("correlation_length_x_m", "/surface/correlation_length_x_m"),
        ("correlation_length_y_m", "/surface/correlation_length_y_m"),
        ("covariance", "/surface/covariance/model"),
        ("covariance_length_x_m", "/surface/covariance/length_x_m"),
        ("covariance_length_y_m", "/surface/covariance/length_y_m"),
        ("covariance_decay_length_x_m", "/surface/covariance/decay_length_x_m"),
        ("covariance_decay_length_y_m", "/surface/covariance/decay_length_y_m"),
        ("operating_point", "/friction/operating_point/level"),
        ("mean_pressure_pa", "/friction/operating_point/mean_pressure_pa"),
        ("contact_probability", contact.as_str()),
        ("friction_mean", mean.as_str()),
        ("friction_mean_interval", interval.as_str()),
        ("friction_std", std.as_str()),
        ("friction_correlation_length_m", "/vibration/friction_correlation_length_m"),
        ("critical_damping_ratio", "/vibration/critical_damping_ratio"),
        ("limit_damping_ratio", "/vibration/limit_damping_ratio"),
        ("kind", "/vibration/kind"),
        ("period", "/vibration/cycle/period"),
    ];
    let found = numbers.into_iter().filter(|(_, pointer)| !pointer.is_empty());
    let found = found.filter_map(|(key, pointer)| Some((key, results.pointer(pointer)?.clone())));
    // Short strips leave the mean without an interval.
    let found = found.filter(|(key, value)| !(key.ends_with("_interval") && value.is_null()));
    let vibrates = vibration_answer(results).map(|answer| ("vibrates", answer.into()));
    found
        .chain(vibrates)
        .fold(Answer::default(), |answer, (key, value)| answer.with(key, value))
        .with("folder", folder.display().to_string())
}
