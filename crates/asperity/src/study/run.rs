//! Run of a study, stage by stage.

use std::mem;
use std::path::{Path, PathBuf};

use asperity_runs::key_of;
use serde::{Deserialize, Serialize};

use crate::friction::{OperatingLevel, RoughBody, SolvedLevel, WindowFriction};
use crate::map::BoundaryKind;
use crate::monitor::{Cancelled, Monitor};
use crate::study::check::{FrictionSource, SurfaceStudy, VibrationStudy};
use crate::study::output::Gathered;
use crate::study::result::KarhunenLoeveResult;
use crate::study::result::{Outcome, Results};
use crate::study::surface_stage::SurfaceStage;
use crate::study::write_run::with_paths;
use crate::study::{
    FailureKind, RunBlocks, Stage, StoreError, Study, StudyError, StudyFile, counterface, coupled_stage, file_hash,
    friction_process, friction_stage, implausible_friction, pressure_stage, sentence, surface_stage, verdict,
    vibration_stage,
};

impl Study {
    /// Returns the scan files, `folder` being the folder of the study file.
    pub fn scan_paths(&self, folder: &Path) -> Vec<PathBuf> {
        let bodies = self.surface.iter().chain(&self.counterface);
        bodies.flat_map(|body| &body.files).map(|file| folder.join(file)).collect()
    }

    /// Returns the file of the friction process that the study reads, `folder` being the folder of the study file.
    pub fn friction_process_path(&self, folder: &Path) -> Option<PathBuf> {
        match &self.vibration.as_ref()?.machine.friction {
            FrictionSource::File(file) => Some(folder.join(file)),
            FrictionSource::Computed(_) | FrictionSource::Stated(_) => None,
        }
    }

    /// Returns whether the study has a section for the stage.
    pub fn has(&self, stage: Stage) -> bool {
        match stage {
            Stage::Surface => self.surface.is_some(),
            Stage::Pressure => self.pressure.is_some(),
            Stage::Friction => self.friction.is_some(),
            Stage::Vibration | Stage::Verdict => self.vibration.is_some(),
        }
    }

    /// Returns the level at which friction drives the vibration.
    pub(super) fn operating_level(&self) -> OperatingLevel {
        let Some(VibrationStudy { machine, .. }) = &self.vibration else { return OperatingLevel::Deepest };
        match machine.friction {
            FrictionSource::Computed(Some(percentile)) => OperatingLevel::Percentile(percentile),
            _ => OperatingLevel::NominalPressure(machine.nominal_contact().pressure_pa),
        }
    }

    /// Returns whether a run computes the verdict: that of every machine without a harmonic force, or one that the study states.
    pub(super) fn judges(&self) -> bool {
        let is_forced = self.vibration.as_ref().is_some_and(|vibration| vibration.machine.forcing.is_some());
        self.verdict.is_some() && (!is_forced || self.states_verdict())
    }

    /// Returns whether the study states a verdict: it has its section, or uncertain values.
    pub(super) fn states_verdict(&self) -> bool {
        let file = self.file();
        self.verdict.is_some() && (file.verdict.is_some() || !file.uncertain.is_empty())
    }

    /// Returns whether a value is uncertain or the input of a remedy.
    pub(super) fn varies(&self, name: &str) -> bool {
        self.verdict.as_ref().is_some_and(|verdict| {
            let of_remedies = verdict.remedies.iter().map(|remedy| &remedy.place);
            verdict.places.iter().chain(of_remedies).any(|place| place.name() == name)
        })
    }

    /// Returns the friction that the study states or reads; `None` if its friction stage computes it.
    fn known_friction(&self, folder: &Path) -> Result<Option<WindowFriction>, StudyError> {
        let Some(vibration) = &self.vibration else { return Ok(None) };
        let (nominal, stribeck) = (vibration.machine.nominal_contact(), vibration.machine.dimensionless_stribeck());
        Ok(match &vibration.machine.friction {
            FrictionSource::Computed(_) => None,
            FrictionSource::File(file) => {
                let process = friction_process::read(&folder.join(file), file)?;
                // The folder of a run states the absolute path, so results contain the name alone.
                let name = file.file_name().unwrap_or_default().to_string_lossy().into_owned();
                let unit_m_per_s = vibration.machine.scales.velocity_m_per_s();
                let mut found = WindowFriction::from_process(&process, &name, nominal, stribeck, unit_m_per_s);
                if found.stribeck != stribeck && self.varies("vibration.stribeck") {
                    let stated = sentence::digits(found.stribeck.unwrap_or_default() / unit_m_per_s);
                    let reason = format!(
                        "the file states the Stribeck coefficient, {stated} s/m; a `stribeck` that is uncertain or the input of a remedy \
                         must have this central value"
                    );
                    return Err(StudyError::FrictionProcess { file: name, reason });
                }
                found.warnings.extend(implausible_friction(process.mean).map(|warning| format!("{name}: {warning}")));
                Some(found)
            }
            FrictionSource::Stated(friction) => {
                Some(WindowFriction::from_statement(friction.clone(), nominal.area_m2, stribeck))
            }
        })
    }

    /// Returns the warnings that are known before anything is computed, including those of the known friction.
    fn known_warnings(&self, known: Option<&mut WindowFriction>) -> Result<Vec<String>, StudyError> {
        let mut warnings = self.warnings();
        if let (Some(section), Some(known)) = (&self.vibration, known) {
            if section.machine.coupled.is_none() {
                vibration_stage::refuse_clipping(section, known)?;
            }
            warnings.append(&mut known.warnings);
        }
        Ok(warnings)
    }

    /// Checks the scans and returns warnings about them; `folder` is the folder of the study file. Computes the
    /// statistics of the scans only if the random surfaces need their fractal dimension.
    ///
    /// # Errors
    /// A scan cannot be read or filtered, or has no fractal dimension although the random surfaces need one.
    pub fn check_scans(&self, folder: &Path) -> Result<Vec<String>, StudyError> {
        let Some(surface) = &self.surface else { return Ok(Vec::new()) };
        let mut warnings = surface_stage::check_scans(surface, folder)?;
        if let Some(body) = &self.counterface {
            warnings.extend(counterface::check_scans(body, folder)?);
        }
        Ok(warnings)
    }

    /// Reads the scans and returns the number of their heights; `folder` is the folder of the study file.
    ///
    /// # Errors
    /// A scan cannot be read.
    pub fn scan_points(&self, folder: &Path) -> Result<usize, StudyError> {
        let points = |body: &SurfaceStudy| -> Result<usize, StudyError> {
            Ok(body.read_scans(folder)?.iter().map(|(_, scan)| scan.heights_m.len()).sum())
        };
        let own = self.surface.as_ref().map_or(Ok(0), points)?;
        let counterface = self.counterface.as_ref().map_or(Ok(0), points);
        Ok(own + counterface.map_err(StudyError::of_counterface)?)
    }

    /// Returns the warnings of a run that are known before anything is computed; `folder` is the folder of the study
    /// file.
    ///
    /// # Errors
    /// The study cannot run: its friction process cannot be read, or more of the friction is clipped than the study
    /// allows.
    pub fn check_before_run(&self, folder: &Path) -> Result<Vec<String>, StudyError> {
        self.known_warnings(self.known_friction(folder)?.as_mut())
    }

    /// Runs the stages of the study, or, with `only`, one stage and the stages it needs. `folder` is the folder of the
    /// study file. Writes no files.
    ///
    /// # Errors
    /// A stage failed, or the study has no section for the stage `only`.
    pub fn run(&self, folder: &Path, only: Option<Stage>, monitor: &dyn Monitor) -> Result<Outcome, StudyError> {
        self.run_with(None, folder, only, monitor)
    }

    /// Runs as [`Study::run`], with the blocks that are stored, and stores those that it computes.
    ///
    /// # Errors
    /// As [`Study::run`]; blocks cannot be stored, or blocks of other parts are missing ([`StudyError::Incomplete`]). Stages that do not
    /// need the missing blocks are computed all the same.
    pub fn run_with(
        &self,
        blocks: Option<&RunBlocks>,
        folder: &Path,
        only: Option<Stage>,
        monitor: &dyn Monitor,
    ) -> Result<Outcome, StudyError> {
        self.run_chain(&Stages { blocks, monitor }, Purpose::Study, folder, only).map(|(outcome, _)| outcome)
    }

    /// Runs what the verdict needs or, without uncertain values, the last stage, and returns its results with the friction of the
    /// machine. `friction` is the friction stage of a study that differs in nothing the stage depends on.
    pub(super) fn run_answers(
        &self,
        friction: Option<&SharedFriction>,
        folder: &Path,
        monitor: &dyn Monitor,
    ) -> Result<(Results, Option<WindowFriction>), StudyError> {
        let stages = [Stage::Vibration, Stage::Friction, Stage::Pressure, Stage::Surface];
        let last = stages.into_iter().find(|stage| self.has(*stage));
        let only = if self.states_verdict() { Some(Stage::Verdict) } else { last };
        let stages = Stages { blocks: None, monitor };
        let (outcome, window) = self.run_chain(&stages, Purpose::Answers { friction }, folder, only)?;
        let mut results = outcome.results;
        results.warnings.extend(friction.iter().flat_map(|friction| friction.warnings.iter().cloned()));
        Ok((results, window))
    }

    /// Returns a key of all inputs of the friction stage and the stages before it, if the friction of the machine is computed.
    pub(super) fn friction_key(&self, folder: &Path) -> Option<String> {
        let vibration = self.vibration.as_ref()?;
        let FrictionSource::Computed(_) = vibration.machine.friction else { return None };
        let (_, friction) = (self.surface.as_ref()?, self.friction.as_ref()?);
        let of_machine =
            (self.operating_level(), self.stated_nominal_area(), vibration.machine.nominal_contact(), self.seed());
        key_of(&(bodies_text(self.file()).ok()?, self.scan_paths(folder), friction, of_machine)).ok()
    }

    /// Computes the friction of the machine for all studies with this [`Study::friction_key`].
    pub(super) fn share_friction(&self, folder: &Path, monitor: &dyn Monitor) -> Result<SharedFriction, StudyError> {
        let mut gathered = Gathered::default();
        let (Some(surface), Some(vibration)) = (self.run_surface(false, folder, &mut gathered)?, &self.vibration)
        else {
            return Err(StudyError::NoStage(Stage::Vibration.name()));
        };
        gathered.results.warnings.extend(surface.output.warnings.iter().cloned());
        let stages = Stages { blocks: None, monitor };
        let stage = self.run_friction(&stages, "", &surface, &mut gathered)?;
        let (level, body) = stage.ok_or(StudyError::NoStage(Stage::Friction.name()))?;
        // The Stribeck coefficient is that of each machine.
        let window = WindowFriction::from_level(&level, body, vibration.machine.nominal_contact(), None);
        Ok(SharedFriction { window, warnings: gathered.results.warnings })
    }

    /// Runs the surface stage, with the tables of the scan or without; `None` if the study has no surface.
    fn run_surface(
        &self,
        tables: bool,
        folder: &Path,
        gathered: &mut Gathered,
    ) -> Result<Option<SurfaceStage>, StudyError> {
        let Some(surface) = &self.surface else { return Ok(None) };
        let run = if tables { surface_stage::run } else { surface_stage::without_tables };
        let mut stage = run(surface, folder)?;
        if let Some(body) = &self.counterface {
            gathered.results.counterface = Some(counterface::add_to(&mut stage, body, folder)?);
        }
        Ok(Some(stage))
    }

    /// Runs the friction stage; `None` if the study has none. `of_surface` is what the surface depends on.
    fn run_friction(
        &self,
        stages: &Stages<'_>,
        of_surface: &str,
        surface: &SurfaceStage,
        gathered: &mut Gathered,
    ) -> Result<Option<(SolvedLevel, RoughBody)>, StudyError> {
        let Some(study) = &self.friction else { return Ok(None) };
        let (level, stated_area) = (self.operating_level(), self.stated_nominal_area());
        let input = (of_surface, study, level, stated_area, self.seed());
        let stage = stages.run(Stage::Friction.name(), &input, |monitor| {
            friction_stage::run(study, surface, level, stated_area, self.seed(), monitor)
        })?;
        // Nothing that follows is possible without friction.
        let stage = stage.ok_or(StudyError::Incomplete)?;
        gathered.add(stage.output);
        gathered.results.friction = Some(stage.result);
        let stribeck_s_per_m = self.vibration.as_ref().and_then(|vibration| {
            Some(vibration.machine.stribeck?.s_per_m(vibration.machine.scales.velocity_m_per_s()))
        });
        // The file of a process cannot state differences between parts.
        let process = (study.body == RoughBody::Track).then(|| stage.level.fitted_process(stribeck_s_per_m));
        match process.transpose() {
            Ok(process) => gathered.friction_process = process,
            Err(reason) => gathered.results.warnings.push(format!("no friction_process.json is written: {reason}")),
        }
        Ok(Some((stage.level, study.body)))
    }

    /// Runs the pressure stage, if the study has one, and returns the expansion of the surface of its patch.
    fn run_pressure(
        &self,
        stages: &Stages<'_>,
        of_surface: &str,
        surface: &SurfaceStage,
        gathered: &mut Gathered,
    ) -> Result<Option<KarhunenLoeveResult>, StudyError> {
        let Some(study) = &self.pressure else { return Ok(None) };
        let generated = surface.model.patch(study.grid, study.boundary == BoundaryKind::Periodic)?;
        let stage = stages.run(Stage::Pressure.name(), &(of_surface, study, self.seed()), |monitor| {
            pressure_stage::run(study, &surface.model, &generated, self.seed(), monitor)
        })?;
        if let Some(stage) = stage {
            gathered.add(stage.output);
            gathered.results.pressure = Some(stage.result);
        }
        Ok(generated.karhunen_loeve)
    }

    /// Runs the vibration of the machine.
    fn run_vibration(
        &self,
        stages: &Stages<'_>,
        study: &VibrationStudy,
        window: &WindowFriction,
        gathered: &mut Gathered,
    ) -> Result<(), StudyError> {
        if let Some(model) = study.machine.coupled_model(window.mean, window.stiffness_pa_per_m) {
            let stage = coupled_stage::run(study, &model?, window)?;
            gathered.add(stage.output);
            gathered.results.mode_coupling = Some(stage.result);
            return Ok(());
        }
        let mut own = study.clone();
        if let FrictionSource::File(file) = &mut own.machine.friction {
            // The friction of the file is that of the window.
            *file = PathBuf::new();
        }
        // The friction of a part of a rough slider on a smooth track has no course along the path.
        let has_path = self.friction.as_ref().is_none_or(|friction| friction.body != RoughBody::Slider);
        let stage = stages.run(Stage::Vibration.name(), &(&own, window, has_path, self.seed()), |monitor| {
            vibration_stage::run(study, window, has_path, self.seed(), monitor)
        })?;
        let stage = stage.ok_or(StudyError::Incomplete)?;
        gathered.machine = stage.machine;
        gathered.add(stage.output);
        gathered.results.vibration = Some(stage.result);
        Ok(())
    }

    /// Runs the stages.
    fn run_chain(
        &self,
        stages: &Stages<'_>,
        purpose: Purpose<'_>,
        folder: &Path,
        only: Option<Stage>,
    ) -> Result<(Outcome, Option<WindowFriction>), StudyError> {
        let &Stages { blocks, monitor } = stages;
        let (with_tables, given) = match purpose {
            Purpose::Study => (true, None),
            Purpose::Answers { friction } => (false, friction),
        };
        let wants = |stage: Stage| only.is_none_or(|only| only == stage);
        let wants_verdict = only == Some(Stage::Verdict) || only.is_none() && self.judges();
        let wants_friction = wants(Stage::Friction) || wants(Stage::Vibration) || wants_verdict;
        if let Some(stage) = only.filter(|stage| !self.has(*stage)) {
            return Err(StudyError::NoStage(stage.name()));
        }
        let mut gathered = Gathered::default();
        gathered.results.seed = self.seed();
        let drives = wants(Stage::Vibration) || wants_verdict;
        let mut known = if drives { self.known_friction(folder)? } else { None };
        gathered.results.warnings = self.known_warnings(known.as_mut())?;
        let (mut surface, mut karhunen_loeve) = (None, None);
        let without_paths = with_paths(self.file(), |_| PathBuf::new());
        let hashes = if blocks.is_some() { self.scan_hashes(folder)? } else { Vec::new() };
        let of_surface = key_of(&(bodies_text(&without_paths)?, &hashes))?;
        if self.surface.is_some() && (given.is_none() || wants_verdict) {
            monitor.begin(Stage::Surface.name());
            surface = self.run_surface(with_tables, folder, &mut gathered)?;
            self.refuse_changed(folder, &hashes.into_iter().zip(self.scan_paths(folder)).collect::<Vec<_>>())?;
        }
        if let Some(stage) = surface.as_mut().filter(|_| given.is_none()) {
            stage.output.assumptions.extend(counterface::contact_sentence(self.file()));
            gathered.add(mem::take(&mut stage.output));
        }
        if let Some(surface) = surface.as_ref().filter(|_| wants(Stage::Pressure)) {
            karhunen_loeve = self.run_pressure(stages, &of_surface, surface, &mut gathered)?;
        }
        let friction = match &surface {
            Some(surface) if wants_friction && given.is_none() => {
                self.run_friction(stages, &of_surface, surface, &mut gathered)?
            }
            _ => None,
        };
        let mut window = None;
        if let Some(study) = self.vibration.as_ref().filter(|_| drives) {
            let (nominal, stribeck) = (study.machine.nominal_contact(), study.machine.dimensionless_stribeck());
            let given = given.map(|given| WindowFriction { stribeck, ..given.window.clone() });
            let computed = friction.map(|(level, body)| WindowFriction::from_level(&level, body, nominal, stribeck));
            window = known.or(given).or(computed);
            if let Some(window) = window.as_ref().filter(|_| wants(Stage::Vibration)) {
                self.run_vibration(stages, study, window, &mut gathered)?;
            }
        }
        if let Some(window) = window.as_ref().filter(|_| wants_verdict) {
            let text = without_paths.to_text()?;
            let verdict =
                stages.run(Stage::Verdict.name(), &(&of_surface, text, &self.verdict, window), |monitor| {
                    verdict::run(self, surface.as_ref(), window, monitor)
                })?;
            let verdict = verdict.ok_or(StudyError::Incomplete)?;
            gathered.add(verdict.output);
            gathered.results.verdict = Some(verdict.result);
        }
        if blocks.is_some_and(RunBlocks::is_incomplete) {
            return Err(StudyError::Incomplete);
        }
        gathered.results.surface = surface.map(|stage| stage.result(karhunen_loeve));
        Ok((gathered.outcome(), window))
    }

    /// Fails if a file that the study reads is among `inputs` and has another SHA-256.
    pub(super) fn refuse_changed(&self, folder: &Path, inputs: &[(String, PathBuf)]) -> Result<(), StudyError> {
        let files = self.scan_paths(folder).into_iter().chain(self.friction_process_path(folder));
        for file in files {
            let changed = |(hash, _): &(String, PathBuf)| *hash != file_hash(&file).unwrap_or_default();
            if inputs.iter().find(|(_, input)| *input == file).is_some_and(changed) {
                return Err(StudyError::Changed(file.display().to_string()));
            }
        }
        Ok(())
    }

    /// Returns the SHA-256 of the scans.
    fn scan_hashes(&self, folder: &Path) -> Result<Vec<String>, StudyError> {
        Ok(self.scan_paths(folder).iter().map(|scan| file_hash(scan)).collect::<Result<_, _>>()?)
    }
}

/// Returns the sections of both bodies as text, without fields that they leave out.
fn bodies_text(file: &StudyFile) -> Result<String, StoreError> {
    Ok(serde_json::to_string(&(&file.surface, &file.counterface))?)
}

/// What the stages are run for.
enum Purpose<'a> {
    /// All results of a study.
    Study,
    /// The answers of a member of a campaign, without the tables of the scan; its friction, if other members have the same.
    Answers { friction: Option<&'a SharedFriction> },
}

/// Friction of the machine that several studies have in common.
#[derive(Debug, Clone, Serialize, Deserialize)]
pub(super) struct SharedFriction {
    window: WindowFriction,
    /// Warnings of the surface and of the friction stage.
    warnings: Vec<String>,
}

/// Stages of a run, with the blocks that are stored.
pub(super) struct Stages<'a> {
    pub(super) blocks: Option<&'a RunBlocks>,
    pub(super) monitor: &'a dyn Monitor,
}

impl Stages<'_> {
    /// Runs a stage, a function of `input` alone; `None` if blocks of other parts are missing.
    pub(super) fn run<T>(
        &self,
        stage: &str,
        input: &impl Serialize,
        run: impl FnOnce(&dyn Monitor) -> Result<T, StudyError>,
    ) -> Result<Option<T>, StudyError> {
        self.monitor.begin(stage);
        let Some(blocks) = self.blocks else { return run(self.monitor).map(Some) };
        match run(&blocks.stage(stage, input, self.monitor)?) {
            Err(_) if blocks.failed() => Err(blocks.flush().err().map_or(StudyError::Cancelled(Cancelled), Into::into)),
            Err(error)
                if error.kind() == FailureKind::Cancelled && blocks.is_incomplete() && !self.monitor.cancelled() =>
            {
                Ok(None)
            }
            found => found.map(Some),
        }
    }
}
