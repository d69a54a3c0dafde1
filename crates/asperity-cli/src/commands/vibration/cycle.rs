//! The stick-slip limit cycle.

use asperity::vibration::{LimitCycle, Oscillator, Regime, limit_cycle};
use clap::Args;

use super::{Damping, Machine, refused};
use crate::failure::Failure;
use crate::monitor::Terminal;
use crate::output::Answer;

/// Finds the limit cycle; that there is none is an answer too.
#[derive(Debug, Args)]
pub(crate) struct Cycle {
    #[command(flatten)]
    machine: Machine,
    #[command(flatten)]
    damping: Damping,
    /// Print one JSON object instead of a table.
    #[arg(long)]
    json: bool,
}

impl Cycle {
    pub(crate) fn run(&self, monitor: &Terminal) -> Result<(), Failure> {
        let oscillator = self.machine.oscillator(self.damping.damping_ratio)?;
        let regime = monitor
            .at_once(|| limit_cycle(&oscillator))?
            .or_else(|e| Err(refused(&e).told(answer(None, None), self.json)?))?;
        match regime {
            Regime::Cycle(_) => {}
            Regime::Sliding if slides_unsteadily(&oscillator) => monitor.warn(
                "no limit cycle that sticks; but steady sliding is unstable at this damping ratio, so the mass vibrates without \
                 reaching the velocity of the belt",
            ),
            Regime::Sliding => monitor.note("no limit cycle: the mass slides for ever"),
            Regime::Irregular => monitor.note("no limit cycle: the forced motion does not repeat itself"),
        }
        answer(Some(regime.cycle().is_some()), regime.cycle()).print(self.json)
    }
}

/// Whether steady sliding is unstable, below ζ_H, although there is no cycle that sticks.
fn slides_unsteadily(oscillator: &Oscillator) -> bool {
    let weakening = oscillator.law().weakening(oscillator.belt_velocity());
    oscillator.forcing().is_none() && oscillator.damping_ratio() < 0.5 * weakening
}

fn answer(found: Option<bool>, cycle: Option<&LimitCycle>) -> Answer {
    Answer::default()
        .with("limit_cycle", found)
        .with("period", cycle.map(|c| c.period))
        .with("slip_duration", cycle.map(|c| c.slip_duration))
        .with("reattachment_displacement", cycle.map(|c| c.reattachment_displacement))
        .with("displacement_min", cycle.map(|c| c.displacement_min))
        .with("displacement_max", cycle.map(|c| c.displacement_max))
        .with("velocity_min", cycle.map(|c| c.velocity_min))
}
