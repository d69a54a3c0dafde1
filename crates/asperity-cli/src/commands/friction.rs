//! Friction processes: fits to measured records, and records drawn from fits.

mod fit;
mod simulate;

use clap::Subcommand;

pub(crate) use self::simulate::read_process;

use crate::failure::Failure;
use crate::monitor::Terminal;

/// Commands of friction processes. Help shows the documentation of each command's type.
#[derive(Debug, Subcommand)]
pub(crate) enum Friction {
    Fit(Box<fit::FitRecord>),
    Simulate(simulate::Simulate),
}

impl Friction {
    pub(crate) fn run(&self, monitor: &Terminal) -> Result<(), Failure> {
        match self {
            Self::Fit(fit) => fit.run(monitor),
            Self::Simulate(simulate) => simulate.run(monitor),
        }
    }
}
