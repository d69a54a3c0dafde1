//! Rough surfaces: statistics, conversion, filling and random generation.

mod convert;
mod fill;
mod generate;
mod maps;
mod modes;
pub(super) mod preparation;
mod stats;
mod twin;

use clap::Subcommand;

use crate::failure::Failure;
use crate::monitor::Terminal;

/// Commands of the surface stage. Help shows the documentation of each command's type.
#[derive(Debug, Subcommand)]
pub(crate) enum Surface {
    Stats(stats::Stats),
    Convert(convert::Convert),
    Fill(fill::Fill),
    Generate(generate::Generate),
    Twin(Box<twin::Twin>),
    Modes(modes::Modes),
}

impl Surface {
    pub(crate) fn run(&self, monitor: &Terminal) -> Result<(), Failure> {
        match self {
            Self::Stats(stats) => stats.run(monitor),
            Self::Convert(convert) => convert.run(monitor),
            Self::Fill(fill) => fill.run(monitor),
            Self::Generate(generate) => generate.run(monitor),
            Self::Twin(twin) => twin.run(monitor),
            Self::Modes(modes) => modes.run(monitor),
        }
    }
}
