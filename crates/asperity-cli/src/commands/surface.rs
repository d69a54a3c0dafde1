//! Rough surfaces: what a map is, and maps like it.

mod convert;
mod modes;
mod stats;

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
    /// Karhunen–Loève eigenvalues of a covariance.
    Modes(modes::Modes),
}

impl Surface {
    pub(crate) fn run(&self, monitor: &Terminal) -> Result<(), Failure> {
        match self {
            Self::Stats(stats) => stats.run(monitor),
            Self::Convert(convert) => convert.run(monitor),
            Self::Modes(modes) => modes.run(monitor),
        }
    }
}
