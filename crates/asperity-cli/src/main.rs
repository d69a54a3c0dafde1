//! The command line of asperity: parses arguments, calls the library, prints results.
//!
//! Data goes to stdout, messages go to stderr, and the exit code gives the kind of error ([`failure::Kind`]).

mod args;
mod commands;
mod failure;
mod input;
mod monitor;
mod output;
mod provenance;
mod resources;
mod run_folder;

use std::env;
use std::panic;
use std::process::ExitCode;
use std::sync::OnceLock;

use clap::{CommandFactory, FromArgMatches, Parser};

use commands::{Command, GROUPS};
use failure::{Failure, Kind};
use monitor::Terminal;

/// From a measured rough surface to contact pressure, friction and stick-slip, with uncertainty.
#[derive(Debug, Parser)]
#[command(name = "asperity", version, arg_required_else_help = true)]
#[command(after_help = "\
Quantities carry their unit: \"210 GPa\", 0.5um, \"2.5 kN\". JSON is SI, with the unit in the key.

Exit codes:
  0    done
  1    runtime error
  2    wrong flag, key, unit or value
  3    input data missing, corrupt or unusable
  4    not converged or too few valid samples (the answer is printed all the same)
  5    out of memory, disk, threads or time (--max-time)
  130  cancelled")]
struct Cli {
    /// Number of worker threads; all cores when left out. Results do not depend on it.
    #[arg(long, global = true, value_name = "N", value_parser = args::threads, help_heading = "Everywhere")]
    threads: Option<usize>,

    /// Print only errors on stderr: no progress, no warnings.
    #[arg(long, short, global = true, help_heading = "Everywhere")]
    quiet: bool,

    #[command(subcommand)]
    command: Command,
}

/// Returns the command line, with the commands of the help under their headings.
fn program() -> clap::Command {
    let program = Cli::command();
    let line = |name: &&str| {
        let about = program.find_subcommand(name).and_then(clap::Command::get_about);
        format!("  {name:<13}{}\n", about.map_or_else(String::new, ToString::to_string))
    };
    let group =
        |(title, names): &(&str, &[&str])| format!("{title}:\n{}\n", names.iter().map(line).collect::<String>());
    let groups: String = GROUPS.iter().map(group).collect();
    let template = format!("{{about-with-newline}}\n{{usage-heading}} {{usage}}\n\n{groups}{{options}}{{after-help}}");
    program.help_template(template)
}

/// Source location of the first panic.
static PANIC_LOCATION: OnceLock<String> = OnceLock::new();

fn main() -> ExitCode {
    let arguments = match commands::dimensionless(env::args_os().collect()) {
        Ok(arguments) => arguments,
        Err(failure) => {
            output::print_message(&failure.to_string());
            return ExitCode::from(failure.kind().exit_code());
        }
    };
    let cli = match Cli::from_arg_matches(&program().get_matches_from(arguments)) {
        Ok(cli) => cli,
        Err(error) => error.exit(),
    };
    // A write beyond the limit of the file size fails like one on a full disk, instead of ending the program by a signal.
    #[cfg(unix)]
    let _ = signal_hook::flag::register(signal_hook::consts::SIGXFSZ, std::sync::Arc::default());
    // A panic prints one message, below, instead of a stack trace.
    panic::set_hook(Box::new(|info| {
        PANIC_LOCATION
            .get_or_init(|| info.location().map_or_else(String::new, |at| format!(" ({}:{})", at.file(), at.line())));
    }));
    let kind = match panic::catch_unwind(|| run(&cli)) {
        Ok(Ok(())) => return ExitCode::SUCCESS,
        Ok(Err(failure)) => {
            output::print_message(&failure.to_string());
            failure.kind()
        }
        Err(payload) => {
            let what = payload
                .downcast_ref::<String>()
                .map(String::as_str)
                .or_else(|| payload.downcast_ref::<&str>().copied())
                .unwrap_or("no message");
            let place = PANIC_LOCATION.get().map_or("", String::as_str);
            output::print_message(&format!("internal error: {what}{place}; please report it"));
            Kind::Runtime
        }
    };
    ExitCode::from(kind.exit_code())
}

/// Starts the worker threads: as many as the flag or the variable of rayon states, otherwise one for each core.
fn start_threads(stated: Option<usize>) -> Result<(), Failure> {
    const VARIABLE: &str = "RAYON_NUM_THREADS";
    let of_variable = || env::var(VARIABLE).ok().filter(|text| text.parse::<usize>().is_ok_and(|threads| threads > 0));
    let threads = match (stated, of_variable()) {
        (Some(threads), _) => threads,
        (None, Some(text)) => {
            args::threads(&text).map_err(|error| Failure::usage(format_args!("{VARIABLE}: {error}")))?
        }
        (None, None) => 0,
    };
    rayon::ThreadPoolBuilder::new()
        .num_threads(threads)
        .build_global()
        .map_err(|e| Failure::new(Kind::Resources, format!("cannot start the threads: {e}; state fewer by --threads")))
}

fn run(cli: &Cli) -> Result<(), Failure> {
    start_threads(cli.threads)?;
    let monitor = Terminal::new(cli.quiet)?;
    let result = cli.command.run(program, &monitor);
    monitor.finish();
    result
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_command_stands_under_one_heading_of_the_help() {
        let program = program();
        let mut shown: Vec<&str> =
            program.get_subcommands().filter(|command| !command.is_hide_set()).map(clap::Command::get_name).collect();
        let mut grouped = GROUPS.iter().flat_map(|(_, names)| names.iter().copied()).collect::<Vec<_>>();
        shown.sort_unstable();
        grouped.sort_unstable();
        assert_eq!(shown, grouped);
        let help = program.clone().render_help().to_string();
        assert!(help.lines().count() <= 50 && help.lines().all(|line| line.chars().count() <= 100), "{help}");
    }

    #[test]
    fn values_with_units_belong_to_flags_of_the_vibration_commands() {
        let program = program();
        let vibration = program.find_subcommand("vibration").unwrap();
        let flags: Vec<String> = vibration
            .get_subcommands()
            .flat_map(clap::Command::get_arguments)
            .filter_map(|argument| argument.get_long().map(|flag| flag.replace('-', "_")))
            .collect();
        for (flag, _) in commands::FLAGS_WITH_UNITS {
            assert!(flags.iter().any(|other| other == flag), "{flag}");
        }
    }
}
