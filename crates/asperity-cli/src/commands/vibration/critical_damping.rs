//! Damping at which vibration ends.

use asperity::vibration::{self, VibrationError, critical_damping, limit_damping};
use clap::Args;

use super::machine::{DAMPING, Machine};
use crate::args;
use crate::failure::Failure;
use crate::monitor::Terminal;
use crate::output::Answer;

/// Finds the damping ratios at which the stick-slip cycle ends, above which steady sliding is stable, and above which no
/// vibration persists.
#[derive(Debug, Args)]
pub(crate) struct CriticalDamping {
    #[command(flatten)]
    machine: Machine,
    /// Ignored; the command finds the damping ratio.
    #[arg(long, hide = true, value_name = "X", value_parser = args::of_input(DAMPING), allow_hyphen_values = true)]
    damping_ratio: Option<f64>,
    /// Print one JSON object instead of a table.
    #[arg(long)]
    json: bool,
}

impl CriticalDamping {
    pub(crate) fn run(&self, monitor: &Terminal) -> Result<(), Failure> {
        if self.damping_ratio.is_some() {
            monitor.note("--damping-ratio is ignored; the command finds the damping ratio");
        }
        if self.machine.forcing.is_some() {
            monitor.note("the forcing is ignored; the damping ratios are those of the unforced machine");
        }
        let oscillator = self.machine.oscillator(0.0, monitor)?;
        let found = monitor.killable(|| {
            let critical = critical_damping(&oscillator)?;
            let limit = match limit_damping(&oscillator) {
                Err(VibrationError::NotFound { .. }) => None,
                limit => Some(limit?),
            };
            Ok::<_, VibrationError>((critical, limit))
        })?;
        let found = found.or_else(|e| Err(Failure::from(e).print(answer(None), self.json)?))?;
        if found.1.is_none() {
            monitor.warn("the search for slip cycles above the other two damping ratios failed; the limit is unknown");
        }
        answer(Some(found)).print(self.json)
    }
}

fn answer(found: Option<(vibration::CriticalDamping, Option<f64>)>) -> Answer {
    Answer::default()
        .with("critical_damping_ratio", found.map(|(c, _)| c.critical_damping_ratio))
        .with("hopf_damping_ratio", found.map(|(c, _)| c.hopf_damping_ratio))
        .with("limit_damping_ratio", found.and_then(|(_, limit)| limit))
}
