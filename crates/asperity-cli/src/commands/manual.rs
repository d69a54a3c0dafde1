//! Manual pages, for those who package the program.

use std::fs;
use std::path::PathBuf;

use clap::Args;

use crate::failure::{Failure, Kind};

/// Writes the manual pages of the program and of each command.
#[derive(Debug, Args)]
pub(crate) struct Manual {
    /// Folder of the pages; it is made where it is missing.
    folder: PathBuf,
}

impl Manual {
    /// `program` is the whole command line.
    pub(crate) fn run(&self, program: clap::Command) -> Result<(), Failure> {
        fs::create_dir_all(&self.folder).and_then(|()| clap_mangen::generate_to(program, &self.folder)).map_err(
            |error| {
                Failure::new(Kind::Runtime, format!("cannot write manual pages to {}: {error}", self.folder.display()))
            },
        )
    }
}
