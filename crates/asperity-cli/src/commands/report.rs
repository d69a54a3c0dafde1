//! Rendering of the report of a finished run.

use std::path::PathBuf;

use asperity::study::{StoreError, StoredCampaign, StoredRun, replace_files};
use clap::Args;

use crate::failure::{Failure, Kind};
use crate::monitor::Terminal;
use crate::run_folder::{load_failure, store_failure};

/// Renders report.html and figures/ again from a finished run.
///
/// Computes nothing.
#[derive(Debug, Args)]
pub(crate) struct Report {
    /// Folder of a finished run.
    dir: PathBuf,
}

impl Report {
    pub(crate) fn run(&self, monitor: &Terminal) -> Result<(), Failure> {
        if StoredCampaign::is_campaign(&self.dir) {
            let message =
                format!("{} is a campaign, not a run; `asperity campaign` writes its report", self.dir.display());
            return Err(Failure::new(Kind::Data, message));
        }
        let run = StoredRun::load(&self.dir).map_err(|e| load_failure(&e))?;
        let files = run.report().map_err(|e| store_failure(&StoreError::content(e)))?;
        monitor.check()?;
        replace_files(&self.dir, &files).map_err(|e| store_failure(&e))?;
        monitor.note(&format!("wrote {}", self.dir.join("report.html").display()));
        Ok(())
    }
}
