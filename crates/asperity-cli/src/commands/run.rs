//! Run of a study, from its file to a run folder.

use std::path::PathBuf;

use asperity::study::Stage;
use clap::Args;

use super::computation::{Computation, Options};
use crate::args;
use crate::failure::Failure;
use crate::monitor::Terminal;

/// Runs a study and writes its folder: numbers, figures, an offline report.
///
/// The folder also contains tables, fields and provenance. An interrupted run goes on from its finished blocks when the same command is given
/// again.
#[derive(Debug, Args)]
pub(crate) struct Run {
    /// Study file.
    study: PathBuf,
    /// Compute only this stage and the stages that it needs.
    #[arg(long, value_parser = args::named::<Stage>(), value_name = "STAGE")]
    only: Option<Stage>,
    #[command(flatten)]
    options: Options,
}

impl Run {
    pub(crate) fn run(&self, monitor: &Terminal) -> Result<(), Failure> {
        self.options.run(&Computation::study(&self.study, self.options.seed, self.only)?, monitor)
    }
}
