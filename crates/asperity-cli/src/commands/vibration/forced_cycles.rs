//! Cycles of the forced machine, stable and unstable.

use asperity::vibration::{ForcedCycle, forced_cycles};
use clap::Args;
use serde_json::{Value, json};

use super::machine::{Damping, Machine};
use crate::args;
use crate::failure::Failure;
use crate::monitor::Terminal;
use crate::output::{Answer, columns, print};

/// Finds all cycles with stick of the forced machine by shooting, stable and unstable, with their multipliers.
#[derive(Debug, Args)]
pub(crate) struct ForcedCycles {
    #[command(flatten)]
    machine: Machine,
    #[command(flatten)]
    damping: Damping,
    /// Largest number of detachments in a period of a cycle.
    #[arg(long, value_name = "N", default_value = "2", value_parser = args::count, allow_hyphen_values = true)]
    slips: usize,
    /// Print one JSON object instead of a table.
    #[arg(long)]
    json: bool,
}

impl ForcedCycles {
    pub(crate) fn run(&self, monitor: &Terminal) -> Result<(), Failure> {
        let oscillator = self.machine.oscillator(self.damping.damping_ratio, monitor)?;
        if oscillator.forcing().is_none() {
            return Err(Failure::usage("there is no forcing; give --forcing, above 0, and --forcing-frequency"));
        }
        let cycles = forced_cycles(&oscillator, self.slips, monitor)?;
        if self.json {
            let cycles: Vec<Value> = cycles.iter().map(in_json).collect();
            return Answer::default().with("cycles", cycles).print(true);
        }
        if cycles.is_empty() {
            monitor.note(&format!(
                "no cycle with stick has up to {} detachments in a period: try a larger --slips; the motion is found by \
                 `vibration bifurcation`",
                self.slips
            ));
        }
        let heading = [
            "slips",
            "force periods",
            "phase",
            "multiplier",
            "stable",
            "period",
            "X of re-attachment",
            "least velocity",
        ];
        let mut rows = vec![heading.map(str::to_owned)];
        for found in &cycles {
            let back = found.cycle.reattachment_displacement;
            rows.push([
                found.multiplicity.to_string(),
                found.forcing_periods.to_string(),
                format!("{:.9}", found.detachment_phase),
                format!("{:+.6e}", found.multiplier),
                if found.is_stable() { "yes" } else { "no" }.to_owned(),
                format!("{:.9}", found.cycle.period),
                back.map_or_else(|| "-".to_owned(), |x| format!("{x:.9}")),
                format!("{:.9}", found.cycle.velocity_min),
            ]);
        }
        print(&columns(&rows))
    }
}

fn in_json(found: &ForcedCycle) -> Value {
    let ForcedCycle { detachment_phase, multiplicity, forcing_periods, multiplier, cycle } = found;
    json!({
        "slips": multiplicity,
        "forcing_periods": forcing_periods,
        "detachment_phase": detachment_phase,
        "multiplier": multiplier,
        "stable": found.is_stable(),
        "period": cycle.period,
        "slip_duration": cycle.slip_duration,
        "reattachment_displacement": cycle.reattachment_displacement,
        "displacement_min": cycle.displacement_min,
        "displacement_max": cycle.displacement_max,
        "velocity_min": cycle.velocity_min,
    })
}
