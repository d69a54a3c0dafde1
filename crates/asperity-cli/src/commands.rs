//! The commands, one per file.

mod contact;
mod surface;
mod vibration;

use clap::Subcommand;

use crate::failure::Failure;
use crate::monitor::Terminal;

/// What to do.
#[derive(Debug, Subcommand)]
pub(crate) enum Command {
    /// Statistics, conversion and random generation of rough surfaces.
    #[command(subcommand)]
    Surface(surface::Surface),
    /// Contact of a rough surface with a rigid flat.
    Contact(contact::Contact),
    /// A mass on a moving belt, in dimensionless form.
    #[command(subcommand)]
    Vibration(vibration::Vibration),
}

impl Command {
    pub(crate) fn run(&self, monitor: &Terminal) -> Result<(), Failure> {
        match self {
            Self::Surface(surface) => surface.run(monitor),
            Self::Contact(contact) => contact.run(monitor),
            Self::Vibration(vibration) => vibration.run(monitor),
        }
    }
}
