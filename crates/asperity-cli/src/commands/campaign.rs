//! Campaign: one study over many values and scans.

use std::path::PathBuf;

use clap::Args;

use super::computation::{Computation, Options};
use crate::failure::Failure;
use crate::monitor::Terminal;

/// Computes one study over many values and scans: one table, one report.
///
/// Values come from lists, grids and samples. An interrupted campaign goes on from its finished members when the same command is given again.
#[derive(Debug, Args)]
pub(crate) struct Campaign {
    /// Campaign file.
    file: PathBuf,
    #[command(flatten)]
    options: Options,
}

impl Campaign {
    pub(crate) fn run(&self, monitor: &Terminal) -> Result<(), Failure> {
        let computation = Computation::campaign(&self.file, self.options.seed)?;
        computation.extent().into_iter().for_each(|extent| monitor.note(&extent));
        self.options.run(&computation, monitor)
    }
}
