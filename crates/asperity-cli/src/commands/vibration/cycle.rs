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
        let oscillator = self.machine.oscillator(self.damping.damping_ratio, monitor)?;
        let found = monitor.at_once(|| -> Result<_, VibrationError> {
            let regime = limit_cycle(&oscillator)?;
            let unsteady = if regime == Regime::Sliding { unsteady(&oscillator)? } else { None };
            Ok((regime, unsteady))
        })?;
        let (regime, unsteady) = found.or_else(|e| Err(refused(&e).told(answer(None, None), self.json)?))?;
        match (regime, &unsteady) {
            (Regime::Cycle(_), _) => {}
            (Regime::Sliding, Some(_)) => monitor.warn(
                "no limit cycle that sticks; but steady sliding is unstable at this damping ratio, so the mass vibrates without \
                 reaching the velocity of the belt",
            ),
            (Regime::Sliding, None) => monitor.note("no limit cycle: the mass slides for ever"),
            (Regime::Irregular, _) => monitor.note("no limit cycle: the forced motion does not repeat itself"),
        }
        let answer = answer(Some(regime.cycle().is_some()), regime.cycle());
        match unsteady.as_deref().and_then(<[SlipCycle]>::first) {
            Some(cycle) => answer.with("slip_cycle", json!(cycle)).print(self.json),
            None => answer.print(self.json),
        }
    }
}

/// Where steady sliding is unstable: the stable cycles without stick that are found, the first being what it is left for.
fn unsteady(oscillator: &Oscillator) -> Result<Option<Vec<SlipCycle>>, VibrationError> {
    if oscillator.forcing().is_some() || oscillator.damping_ratio() >= hopf_point(oscillator)?.damping_ratio {
        return Ok(None);
    }
    Ok(Some(slip_cycles(oscillator)?.into_iter().filter(SlipCycle::is_stable).collect()))
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
