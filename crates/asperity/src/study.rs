//! Studies: configuration, run and results. Only this module uses the whole chain and writes files.
//!
//! [`Study::parse`] reads a study file, [`Study::run`] computes its [`Outcome`] without writing anything, and [`write_run`]
//! writes the run folder through a [`Staging`], so that it appears complete or not at all.

mod campaign;
mod check;
mod complete;
mod computation;
mod counterface;
mod coupled_stage;
mod error;
mod estimate;
pub mod file;
mod friction_process;
mod friction_stage;
mod friction_strips;
mod half_space;
mod motion_entries;
mod output;
mod parse;
mod plausibility;
mod pressure_stage;
mod profile;
#[cfg(feature = "report")]
mod report;
pub mod result;
mod run;
mod run_machine;
mod scan_sizes;
mod scan_tables;
mod schema;
mod series;
mod specimen;
mod spectra;
pub mod standard_deviation;
mod stored_run;
mod surface_model;
mod surface_result;
mod surface_scans;
mod surface_stage;
mod twin;
mod uncertain;
mod verdict;
mod vibration_stage;
mod write_run;

use asperity_base::sentence;
pub use asperity_results::Stage;
pub use asperity_runs::{
    BlockPlace, FailedBlock, Others, Replay, RoundState, RunBlocks, RunRecord, RunStatus, Share, Staging, StoreError,
    file_hash, forget_peak_memory, free_memory_bytes, is_finished, json_bytes, machine, peak_memory_bytes, program,
    program_difference, replace_files, require_unchanged, sha256,
};

/// Calls for fuzz targets.
#[cfg(fuzzing)]
pub mod fuzzing {
    pub use super::uncertain::read_samples;
    pub use asperity_runs::read_blocks;
}

/// Template of a study: a brake, of which a scan of the disc belongs to it.
pub const QUICKSTART: &str = include_str!("study/quickstart.toml");

pub use campaign::{Campaign, StoredCampaign, campaign_files, write_campaign};
pub use check::{InvalidValue, Study, is_folder_name};
pub use computation::{Computation, Computed, Work, folder_of};
pub use coupled_stage::modes_table;
pub use error::{FailureKind, StudyError};
pub use estimate::StageEstimate;
pub use file::StudyFile;
pub use friction_process::simulated_record;
pub use parse::StudyFileError;
pub use plausibility::{filling_warnings, implausible_damping, implausible_friction, implausible_material};
pub use profile::profile_of;
#[cfg(feature = "report")]
pub use report::{ReportFiles, works};
pub use result::{
    BandMethod, CampaignResults, Comparison, CurveComparison, Field, Outcome, Provenance, Results, StatisticComparison,
    Table, TableError, TwinModel,
};
pub use run_machine::RunMachine;
pub use scan_sizes::ScanSizes;
pub use schema::study_schema;
pub use specimen::{Sampler, Specimen, draw_map};
pub use stored_run::StoredRun;
pub use surface_result::{covariance_result, part_statistics, profile_statistics, surface_statistics};
pub use twin::{TwinError, TwinOptions, TwinTables, Twins};
pub use uncertain::UncertainValue;
pub use verdict::VERDICT_SAMPLES;
pub use vibration_stage::{
    clipping_warning, cloud_table, map_result, points_table, portrait_table, stability_map_tables, survival_table,
};
pub use write_run::{provenance, resolved_study, result_files, write_run};
