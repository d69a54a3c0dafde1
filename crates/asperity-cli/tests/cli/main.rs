//! Tests of the program as a whole: output, exit codes and files.

#![expect(clippy::unwrap_used, reason = "a test that cannot run the program has failed")]

mod blocks;
mod bodies;
mod campaigns;
#[cfg(unix)]
mod completions;
mod contact;
mod contact_analysis;
mod folders;
mod formats;
mod friction;
mod headlines;
mod mode_coupling;
mod outputs;
mod reports;
#[cfg(unix)]
mod resumed;
mod slurm;
mod study;
mod support;
mod surface;
mod twin;
mod usage;
mod verdict;
mod verdict_inputs;
mod verdict_scan;
mod vibration;
mod vibration_curves;
mod vibration_ensemble;
mod vibration_report;
