//! The commands, one per file.

mod campaign;
mod check;
mod cite;
mod completions;
mod computation;
mod contact;
mod formats;
mod found;
mod friction;
mod init;
mod manual;
mod merge;
mod report;
mod repro;
mod run;
mod schema;
mod slurm;
mod status;
mod study_file;
mod surface;
mod verdict;
mod vibration;

#[cfg(test)]
pub(crate) use vibration::FLAGS_WITH_UNITS;
pub(crate) use vibration::dimensionless;

use clap::Subcommand;

use crate::failure::Failure;
use crate::monitor::Terminal;

/// Commands under the headings of the program's help.
pub(crate) const GROUPS: [(&str, &[&str]); 4] = [
    ("Start", &["init", "check", "run", "verdict"]),
    ("Links of the chain", &["surface", "contact", "friction", "vibration"]),
    ("Long runs", &["campaign", "status", "slurm", "merge", "repro"]),
    ("Files", &["report", "cite", "formats", "schema", "completions"]),
];

/// Command of the program. Help shows the documentation of each command's type.
#[derive(Debug, Subcommand)]
pub(crate) enum Command {
    Init(init::Init),
    Check(check::Check),
    Run(run::Run),
    Campaign(campaign::Campaign),
    Verdict(verdict::Verdict),
    Merge(merge::Merge),
    Status(status::Status),
    Repro(repro::Repro),
    Slurm(slurm::Slurm),
    Report(report::Report),
    Cite(cite::Cite),
    /// Statistics, conversion and random generation of rough surfaces.
    #[command(subcommand)]
    Surface(surface::Surface),
    Formats(formats::Formats),
    Schema(schema::Schema),
    Completions(completions::Completions),
    #[command(hide = true)]
    Manual(manual::Manual),
    Contact(contact::Contact),
    /// Friction coefficient as a random process: fit measured records, draw new ones.
    #[command(subcommand)]
    Friction(friction::Friction),
    /// A mass on a moving belt, in dimensionless form or with units.
    Vibration(vibration::Vibration),
}

impl Command {
    /// Runs the command; `program` returns the whole command line, which some commands print.
    pub(crate) fn run(&self, program: fn() -> clap::Command, monitor: &Terminal) -> Result<(), Failure> {
        match self {
            Self::Init(init) => init.run(monitor),
            Self::Check(check) => check.run(monitor),
            Self::Run(run) => run.run(monitor),
            Self::Campaign(campaign) => campaign.run(monitor),
            Self::Verdict(verdict) => verdict.run(monitor),
            Self::Merge(merge) => merge.run(monitor),
            Self::Status(status) => status.run(monitor),
            Self::Repro(repro) => repro.run(monitor),
            Self::Slurm(slurm) => slurm.run(monitor),
            Self::Report(report) => report.run(monitor),
            Self::Cite(cite) => cite.run(monitor),
            Self::Surface(surface) => surface.run(monitor),
            Self::Formats(formats) => formats.run(monitor),
            Self::Schema(schema) => schema.run(monitor),
            Self::Completions(completions) => completions.run(program()),
            Self::Manual(manual) => manual.run(program()),
            Self::Contact(contact) => contact.run(monitor),
            Self::Friction(friction) => friction.run(monitor),
            Self::Vibration(vibration) => vibration.run(monitor),
        }
    }
}
