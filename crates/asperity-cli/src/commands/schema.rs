//! JSON Schemas of files.

use asperity::study::result::results_schema;
use asperity::study::{json_bytes, study_schema};
use clap::{Args, ValueEnum};

use crate::failure::Failure;
use crate::monitor::Terminal;
use crate::output::print;
use crate::run_folder::store_failure;

/// Prints the JSON Schema of results.json or of study files.
///
/// The schema has every key with its type, unit and meaning.
///
/// An editor that reads JSON Schemas completes and checks study files: write the schema beside the study, and name it in the first
/// line of the study, `#:schema ./study.schema.json`.
#[derive(Debug, Args)]
pub(crate) struct Schema {
    /// File that the schema describes.
    #[arg(value_enum, default_value = "results")]
    file: File,
}

#[derive(Debug, Clone, Copy, ValueEnum)]
enum File {
    /// Study files.
    Study,
    /// The results.json of a run or of a campaign.
    Results,
}

impl Schema {
    pub(crate) fn run(&self, monitor: &Terminal) -> Result<(), Failure> {
        monitor.check()?;
        let schema = match self.file {
            File::Study => study_schema(),
            File::Results => results_schema(),
        };
        let bytes = json_bytes(&schema).map_err(|error| store_failure(&error))?;
        print(&String::from_utf8_lossy(&bytes))
    }
}
