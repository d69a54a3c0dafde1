//! The stick-slip limit cycle.

use asperity::vibration::{
    LimitCycle, Oscillator, Regime, SlipCycle, VibrationError, hopf_point, limit_cycle, slip_cycles,
};
use clap::Args;
use serde_json::json;

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
        let found = monitor.at_once(|| -> Result<_, VibrationError> {
            let regime = limit_cycle(&oscillator)?;
            let slip_cycle = if regime == Regime::Sliding { slip_cycle(&oscillator)? } else { None };
            Ok((regime, slip_cycle))
        })?;
        let (regime, slip_cycle) = found.or_else(|e| Err(refused(&e).told(answer(None, None), self.json)?))?;
        match regime {
            Regime::Cycle(_) => {}
            Regime::Sliding if slip_cycle.is_some() => monitor.warn(
                "no limit cycle that sticks; but steady sliding is left for a cycle that stays slower than the belt, the slip_cycle",
            ),
            Regime::Sliding => monitor.note("no limit cycle: the mass slides for ever"),
            Regime::Irregular => monitor.note("no limit cycle: the forced motion does not repeat itself"),
        }
        let answer = answer(Some(regime.cycle().is_some()), regime.cycle());
        let told = answer.clone().with("slip_cycle", json!(slip_cycle));
        if self.json || slip_cycle.is_some() { told.print(self.json) } else { answer.print(false) }
    }
}

/// The cycle without stick that a motion ends in which leaves steady sliding, if that is unstable; forcing has none that is known.
fn slip_cycle(oscillator: &Oscillator) -> Result<Option<SlipCycle>, VibrationError> {
    if oscillator.forcing().is_some() || oscillator.damping_ratio() >= hopf_point(oscillator)?.damping_ratio {
        return Ok(None);
    }
    Ok(slip_cycles(oscillator)?.into_iter().find(SlipCycle::is_stable))
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
