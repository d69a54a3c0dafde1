//! Report folder of a command: answer, tables and figures.

use std::path::{Path, PathBuf};

use asperity::study::{StoreError, Table, json_bytes};
use asperity_report::{Figure, Report, VibrationFigures, render_vibration};
use clap::Args;

use crate::failure::{Failure, Kind, chain};
use crate::monitor::Terminal;
use crate::output::{Answer, warnings};
use crate::resources::require_disk;
use crate::run_folder::{begin_folder, store_failure};

/// Approximate disk space of the tables and figures of a report, in bytes.
const REPORT_BYTES: f64 = 4e6;

/// Destination of tables and figures.
#[derive(Debug, Args)]
pub(super) struct Folder {
    /// Write answer, tables, figures and report.html to this folder. The folder appears complete or not at all.
    #[arg(long, value_name = "DIR")]
    report: Option<PathBuf>,
    /// Replace a folder that asperity wrote. A folder that contains an input, or a file that asperity did not write or
    /// that has changed, is never replaced.
    #[arg(long, requires = "report")]
    force: bool,
}

impl Folder {
    /// Returns whether a folder is requested. Fails if it cannot be written.
    pub(super) fn is_requested(&self, inputs: &[&Path]) -> Result<bool, Failure> {
        let Some(folder) = &self.report else { return Ok(false) };
        begin_folder("--report", folder, self.force, inputs)?;
        require_disk(REPORT_BYTES, folder, "the report")?;
        Ok(true)
    }

    /// Writes `answer.json`, the tables as CSV, their figures, and the page of all of them.
    pub(super) fn write(
        &self,
        command: &str,
        figures: &VibrationFigures,
        inputs: &[&Path],
        answer: &Answer,
        tables: Vec<(&str, Table)>,
        monitor: &Terminal,
    ) -> Result<(), Failure> {
        let Some(folder) = &self.report else { return Ok(()) };
        let staging = begin_folder("--report", folder, self.force, inputs)?;
        let write = |relative: &str, bytes: &[u8]| staging.write(relative, bytes).map_err(|e| store_failure(&e));
        write("answer.json", &json_bytes(&answer.as_object()).map_err(|e| store_failure(&e))?)?;
        for (name, table) in &tables {
            write(&format!("tables/{name}.csv"), &table.to_csv().map_err(|e| store_failure(&StoreError::content(e)))?)?;
        }
        let report = rendered(command, figures, answer, tables)?;
        for (path, svg) in report.figures.iter().flat_map(Figure::files) {
            write(&path, svg.as_bytes())?;
        }
        write("report.html", report.html.as_bytes())?;
        monitor.check()?;
        let written = staging.commit_unmarked().map_err(|e| store_failure(&e))?;
        monitor.note(&format!("wrote {}", written.display()));
        Ok(())
    }
}

fn rendered(
    command: &str,
    figures: &VibrationFigures,
    answer: &Answer,
    tables: Vec<(&str, Table)>,
) -> Result<Report, Failure> {
    let tables = tables.into_iter().map(|(name, table)| (name.to_owned(), table)).collect();
    render_vibration(command, figures, answer.entries(), &warnings(), &tables)
        .map_err(|e| Failure::new(Kind::Runtime, format!("the report could not be drawn: {}", chain(&e))))
}
