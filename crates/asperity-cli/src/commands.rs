//! The commands, one per file.

mod check;
mod contact;
mod formats;
mod init;
mod report;
mod run;
mod study_file;
mod surface;
mod vibration;

use clap::Subcommand;

use crate::failure::Failure;
use crate::monitor::Terminal;

/// What to do.
#[derive(Debug, Subcommand)]
pub(crate) enum Command {
    /// Write an annotated study to begin with.
    Init(init::Init),
    /// Look at a study without computing anything.
    Check(check::Check),
    /// Run a study.
    Run(run::Run),
    /// Render the report of a finished run again.
    Report(report::Report),
    /// Statistics, conversion and random generation of rough surfaces.
    #[command(subcommand)]
    Surface(surface::Surface),
    /// The file formats of surfaces.
    Formats(formats::Formats),
    /// Contact of a rough surface with a rigid flat.
    Contact(contact::Contact),
    /// A mass on a moving belt, in dimensionless form.
    #[command(subcommand)]
    Vibration(vibration::Vibration),
}

impl Command {
    pub(crate) fn run(&self, monitor: &Terminal) -> Result<(), Failure> {
        match self {
            Self::Init(init) => init.run(monitor),
            Self::Check(check) => check.run(monitor),
            Self::Run(run) => run.run(monitor),
            Self::Report(report) => report.run(monitor),
            Self::Surface(surface) => surface.run(monitor),
            Self::Formats(formats) => formats.run(monitor),
            Self::Contact(contact) => contact.run(monitor),
            Self::Vibration(vibration) => vibration.run(monitor),
        }
    }
}
