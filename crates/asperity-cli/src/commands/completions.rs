//! Completions of shells.

use clap::{Args, CommandFactory};
use clap_complete::{Shell, generate};

use crate::Cli;
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
    pub(crate) fn run(&self) -> Result<(), Failure> {
        let mut script = Vec::new();
        generate(self.shell, &mut Cli::command(), "asperity", &mut script);
        print(&String::from_utf8_lossy(&script))
    }
}
