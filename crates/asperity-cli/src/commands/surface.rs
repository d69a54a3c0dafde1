//! Rough surfaces: what a map is, and maps like it.

mod convert;
mod modes;

use clap::Subcommand;

use crate::failure::Failure;
use crate::monitor::Terminal;

/// Commands of the surface stage.
#[derive(Debug, Subcommand)]
pub(crate) enum Surface {
    /// Rewrite a file in another format, chosen by the extension.
    Convert(convert::Convert),
    /// Karhunen–Loève eigenvalues of a covariance.
    Modes(modes::Modes),
}

impl Surface {
    pub(crate) fn run(&self, monitor: &Terminal) -> Result<(), Failure> {
        match self {
            Self::Convert(convert) => convert.run(monitor),
            Self::Modes(modes) => modes.run(monitor),
        }
    }
}
