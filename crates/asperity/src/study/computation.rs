//! A study or a campaign with the file that states it: what front ends compute, store and write.

use std::collections::BTreeMap;
use std::path::{self, Path, PathBuf};

use crate::monitor::Monitor;
use crate::study::campaign::sample_files;
use crate::study::result::{CampaignResults, Outcome, Program};
use crate::study::{
    Campaign, Provenance, RunBlocks, RunRecord, Stage, StageEstimate, Staging, StoreError, Study, StudyError,
    StudyFileError, provenance, write_campaign, write_run,
};

/// Bytes of the folder of a campaign per member.
const MEMBER_BYTES: f64 = 2048.0;
/// Bytes of the heights of a scan in a run folder per byte of its file, which may be compressed: raw and prepared, each as archive and VTK image.
const SCAN_FIELD_BYTES: f64 = 19.0;

/// Study or campaign to compute.
#[derive(Debug)]
pub struct Computation {
    /// Its file; `None` for a study without one, whose paths are relative to the working directory.
    file: Option<PathBuf>,
    text: String,
    work: Work,
}

/// Result that a computation produces.
#[derive(Debug)]
pub enum Work {
    /// A study, or one stage of it with those that it needs.
    Study {
        /// The study.
        study: Box<Study>,
        /// The stage, if not all.
        only: Option<Stage>,
    },
    /// A campaign.
    Campaign(Box<Campaign>),
}

/// Results of a computation.
#[derive(Debug)]
pub enum Computed {
    /// Those of a study.
    Run(Box<Outcome>),
    /// Those of a campaign.
    Campaign(CampaignResults),
}

/// Returns the folder of a file, to which the paths in the file are relative.
pub fn folder_of(file: &Path) -> &Path {
    file.parent().filter(|folder| !folder.as_os_str().is_empty()).unwrap_or(Path::new("."))
}

impl Computation {
    /// Returns the computation of a study; `text` is the content of its file.
    pub fn study(file: Option<PathBuf>, text: String, study: Study, only: Option<Stage>) -> Self {
        Self { file, text, work: Work::Study { study: Box::new(study), only } }
    }

    /// Returns the computation of a campaign; `text` is the content of its file.
    pub fn campaign(file: PathBuf, text: String, campaign: Campaign) -> Self {
        Self { file: Some(file), text, work: Work::Campaign(Box::new(campaign)) }
    }

    /// Returns the computation whose blocks are stored.
    ///
    /// # Errors
    /// The file of the record is not valid in this version.
    pub fn of_record(record: &RunRecord) -> Result<Self, StudyFileError> {
        let RunRecord { file, study, campaign, seed, only, .. } = record;
        let Some(text) = campaign else {
            let parsed = Study::parse(study, &file.display().to_string())?.with_seed(*seed);
            return Ok(Self::study(Some(file.clone()), study.clone(), parsed, *only));
        };
        let parse = |seed| Campaign::parse(text, file, study, seed);
        let campaign = match parse(None)? {
            own if own.seed() == *seed => own,
            _ => parse(Some(*seed))?,
        };
        Ok(Self::campaign(file.clone(), text.clone(), campaign))
    }

    /// Returns the result to produce.
    pub fn work(&self) -> &Work {
        &self.work
    }

    /// Returns the name that the study states, or that of the file without its extension.
    pub fn name(&self) -> String {
        if let Work::Study { study, .. } = &self.work
            && let Some(name) = &study.file().name
        {
            return name.clone();
        }
        let stem = self.file.as_deref().and_then(Path::file_stem);
        stem.map_or_else(|| "study".into(), |stem| stem.to_string_lossy().into_owned())
    }

    /// Returns the folder to which the paths in the file are relative.
    pub fn folder(&self) -> &Path {
        self.file.as_deref().map_or(Path::new("."), folder_of)
    }

    /// Returns the seed.
    pub fn seed(&self) -> u64 {
        match &self.work {
            Work::Study { study, .. } => study.seed(),
            Work::Campaign(campaign) => campaign.seed(),
        }
    }

    /// Returns an error as a sentence that begins with the file and the line of the value that caused it.
    pub fn message(&self, error: &StudyError) -> String {
        let file = self.file.as_ref().map_or_else(|| "study".into(), |file| file.display().to_string());
        let has_lines = self.file.is_some() && matches!(self.work, Work::Study { .. });
        error.message_in(&file, has_lines.then_some(self.text.as_str()))
    }

    /// Returns the files that the study or the campaign names.
    fn data(&self) -> Vec<PathBuf> {
        match &self.work {
            Work::Study { study, .. } => {
                let folder = self.folder();
                let mut samples = Vec::new();
                if let Ok(table) = toml::from_str(&self.text) {
                    sample_files(&table, &mut samples);
                }
                let samples = samples.into_iter().map(|file| folder.join(file));
                study.scan_paths(folder).into_iter().chain(study.friction_process_path(folder)).chain(samples).collect()
            }
            Work::Campaign(campaign) => campaign.inputs(),
        }
    }

    /// Returns the files that the computation reads, its own first.
    pub fn inputs(&self) -> Vec<PathBuf> {
        self.file.iter().cloned().chain(self.data()).collect()
    }

    /// Returns the SHA-256 of the files that the study or the campaign names, by name.
    ///
    /// # Errors
    /// A file cannot be read.
    pub fn data_hashes(&self) -> Result<BTreeMap<String, String>, StoreError> {
        provenance(&self.name(), self.seed(), &self.data()).map(|found| found.inputs)
    }

    /// Returns the provenance of the results; the caller fills in the start, the durations, the program and the machine.
    ///
    /// # Errors
    /// An input cannot be read.
    pub fn provenance(&self) -> Result<Provenance, StoreError> {
        let only = match &self.work {
            Work::Study { only, .. } => only.map(|stage| stage.name().to_owned()),
            Work::Campaign(_) => None,
        };
        Ok(Provenance { only, ..provenance(&self.name(), self.seed(), &self.inputs())? })
    }

    /// Returns the record of stored blocks, of the whole or of a part, number and count.
    ///
    /// # Errors
    /// An input cannot be read.
    pub fn record(&self, program: Program, shard: Option<[usize; 2]>) -> Result<RunRecord, StoreError> {
        let file = self.file.clone().unwrap_or_else(|| "study".into());
        let file = path::absolute(&file).map_err(|source| StoreError::Input { path: file, source })?;
        let (study, campaign, only) = match &self.work {
            Work::Study { only, .. } => (self.text.clone(), None, *only),
            Work::Campaign(campaign) => (campaign.study_text().to_owned(), Some(self.text.clone()), None),
        };
        let (name, seed, inputs) = (self.name(), self.seed(), self.data_hashes()?);
        Ok(RunRecord { name, file, study, campaign, seed, only, inputs, program, shard, ..RunRecord::default() })
    }

    /// Returns the estimate of the computed stage that needs the most memory with `threads` threads.
    ///
    /// # Errors
    /// A scan cannot be read.
    pub fn largest_stage(&self, threads: usize) -> Result<Option<StageEstimate>, StudyError> {
        let stages = match &self.work {
            Work::Study { study, only } => {
                // No other stage needs the pressure stage.
                let needs =
                    |stage| only.is_none_or(|only| stage <= only && (stage != Stage::Pressure || only == stage));
                let mut stages = study.estimate(study.scan_points(self.folder())?, threads);
                stages.retain(|own| needs(own.stage));
                stages
            }
            Work::Campaign(campaign) => campaign.estimate(threads),
        };
        Ok(stages.into_iter().max_by(|a, b| a.memory_bytes.total_cmp(&b.memory_bytes)))
    }

    /// Returns a rough size of the written folder in byte.
    pub fn disk_bytes(&self) -> f64 {
        match &self.work {
            Work::Study { study, .. } => {
                let scans = self.data().into_iter().filter_map(|scan| scan.metadata().ok());
                study.disk_bytes() + scans.map(|scan| SCAN_FIELD_BYTES * scan.len() as f64).sum::<f64>()
            }
            Work::Campaign(campaign) => MEMBER_BYTES * campaign.members() as f64,
        }
    }

    /// Computes, with stored blocks if there are any, and stores those that it computes.
    ///
    /// # Errors
    /// A stage failed, blocks of other parts are missing ([`StudyError::Incomplete`]), or the monitor cancelled.
    pub fn compute(&self, blocks: Option<&RunBlocks>, monitor: &dyn Monitor) -> Result<Computed, StudyError> {
        match &self.work {
            Work::Study { study, only } => {
                study.run_with(blocks, self.folder(), *only, monitor).map(|outcome| Computed::Run(Box::new(outcome)))
            }
            Work::Campaign(campaign) => campaign.run_with(blocks, monitor).map(Computed::Campaign),
        }
    }

    /// Writes the folder of the results, which appears at its destination with [`Staging::commit`].
    ///
    /// # Errors
    /// The operating system refused.
    ///
    /// # Panics
    /// The results are those of a study and this is a campaign, or the reverse.
    pub fn write(&self, staging: &Staging, computed: &Computed, provenance: &Provenance) -> Result<(), StoreError> {
        match (&self.work, computed) {
            (Work::Study { study, .. }, Computed::Run(outcome)) => {
                write_run(staging, study, self.folder(), outcome, provenance)
            }
            (Work::Campaign(campaign), Computed::Campaign(results)) => {
                write_campaign(staging, campaign, results, provenance)
            }
            _ => unreachable!("a computation has results of its own kind"),
        }
    }
}
