//! Motion from a start in stick, without fluctuation.

use asperity::vibration::{LimitCycle, Regime, VibrationError, limit_cycle, smallest_kick};
use clap::Args;

use super::machine::{Damping, Machine};
use crate::failure::Failure;
use crate::monitor::Terminal;
use crate::output::Answer;

/// Finds the vibration that develops from a start in stick, and whether steady sliding is stable too.
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

/// Motion of the machine, and stability of its steady sliding.
struct Found {
    regime: Regime,
    /// `None` under forcing, where steady sliding does not exist.
    steady_sliding_unstable: Option<bool>,
    kick: Option<f64>,
}

impl Cycle {
    pub(crate) fn run(&self, monitor: &Terminal) -> Result<(), Failure> {
        let oscillator = self.machine.oscillator(self.damping.damping_ratio, monitor)?;
        let free = oscillator.forcing().is_none();
        let found = monitor.killable(|| -> Result<_, VibrationError> {
            let regime = limit_cycle(&oscillator)?;
            let kick = if free { smallest_kick(&oscillator)? } else { None };
            Ok(Found { regime, steady_sliding_unstable: free.then(|| oscillator.sliding_is_unstable()), kick })
        })?;
        let found = found.or_else(|e| Err(Failure::from(e).print(answer(None), self.json)?))?;
        match (found.regime, found.kick) {
            (Regime::Cycle(_), Some(kick)) => monitor.note(&format!(
                "the machine vibrates once started (from stick, or by a kick of {kick:.4e}); steady sliding alone is stable"
            )),
            (Regime::Cycle(_), None) => {}
            (Regime::Sliding, _) if free => monitor.note("no limit cycle: every motion ends in steady sliding"),
            (Regime::Sliding, _) => monitor.note("no limit cycle: the mass follows the force, slower than the belt"),
            (Regime::Irregular(_), _) => monitor.note("no limit cycle: the forced motion is not periodic"),
        }
        answer(Some(&found)).print(self.json)
    }
}

fn answer(found: Option<&Found>) -> Answer {
    let cycle = found.and_then(|found| found.regime.cycle());
    let number = |of: fn(&LimitCycle) -> f64| cycle.map(of);
    Answer::default()
        .with("kind", found.map(|found| found.regime.kind().name()))
        .with("steady_sliding_unstable", found.and_then(|found| found.steady_sliding_unstable))
        .with("kick", found.and_then(|found| found.kick))
        .with("limit_cycle", found.map(|_| cycle.is_some()))
        .with("period", number(|c| c.period))
        .with("slip_duration", number(|c| c.slip_duration))
        .with("reattachment_displacement", cycle.and_then(|c| c.reattachment_displacement))
        .with("displacement_min", number(|c| c.displacement_min))
        .with("displacement_max", number(|c| c.displacement_max))
        .with("velocity_min", number(|c| c.velocity_min))
}
