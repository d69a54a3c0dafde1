//! Completions of shells.

use clap::Args;
use clap_complete::{Shell, generate};

use crate::failure::Failure;
use crate::output::print;

/// Prints a script that completes commands and flags in a shell.
///
/// For bash, `asperity completions bash > ~/.local/share/bash-completion/completions/asperity` installs it for new shells.
#[derive(Debug, Args)]
pub(crate) struct Completions {
    /// Shell that reads the script.
    #[arg(value_enum)]
    shell: Shell,
}

impl Completions {
    /// `program` is the whole command line.
    pub(crate) fn run(&self, mut program: clap::Command) -> Result<(), Failure> {
        let mut script = Vec::new();
        generate(self.shell, &mut program, "asperity", &mut script);
        print(&String::from_utf8_lossy(&script))
    }
}
