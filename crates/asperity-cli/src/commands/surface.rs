//! Rough surfaces: what a map is, and maps like it.

mod convert;
mod fill;
mod generate;
mod maps;
mod modes;
mod preparation;
mod stats;
mod twin;

use clap::Subcommand;

use crate::failure::Failure;
use crate::monitor::Terminal;

/// Commands of the surface stage.
#[derive(Debug, Subcommand)]
pub(crate) enum Surface {
    /// ISO 25178-2 parameters, correlation lengths and fractal dimension of a map.
    Stats(stats::Stats),
    /// Rewrite a file in another format, chosen by the extension.
    Convert(convert::Convert),
    /// Fill missing heights, and extend a map beyond its edges, by random heights that continue it.
    Fill(fill::Fill),
    /// Draw random maps like a specified surface.
    Generate(generate::Generate),
    /// Draw random maps like a measured one, and compare them with it.
    Twin(Box<twin::Twin>),
    /// Karhunen–Loève eigenvalues of a covariance.
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
