//! Works behind the methods of a run.

use std::path::PathBuf;

use asperity::study::{StoredRun, works};
use asperity_report::program_bibtex;
use clap::Args;

use crate::failure::Failure;
use crate::monitor::Terminal;
use crate::output::print;
use crate::run_folder::load_failure;

/// Lists the papers behind the methods that a run used.
///
/// The references of its report.
#[derive(Debug, Args)]
pub(crate) struct Cite {
    /// Folder of a finished run.
    run: PathBuf,
    /// Print entries of BibTeX, with that of the program, instead of sentences.
    #[arg(long)]
    bibtex: bool,
}

impl Cite {
    pub(crate) fn run(&self, monitor: &Terminal) -> Result<(), Failure> {
        let run = StoredRun::load(&self.run).map_err(|error| load_failure(&error))?;
        monitor.check()?;
        let cited = works(&run.results, &run.study);
        if self.bibtex {
            let entries = cited.iter().map(|work| format!("\n{}", work.bibtex()));
            return print(&(program_bibtex(&run.provenance.asperity) + &entries.collect::<String>()));
        }
        print(&cited.iter().map(|work| work.text() + "\n").collect::<String>())
    }
}
