//! Frequency and amplitude of the machines that vibrate.

use std::collections::BTreeMap;

use asperity_base::blocks::{self, Task};

use super::machines::Machines;
use super::sampled::Sampled;
use crate::monitor::{Cancelled, Monitor};
use crate::stats::quantile_sorted;
use crate::study::result::{Quantiles, VibratingMachines};
use crate::study::vibration_stage::kind_result;
use crate::vibration::limit_cycle;

/// Largest number of machines whose cycles are computed.
const MOST: usize = 1024;

/// Returns the kinds, frequencies and amplitudes of the machines that vibrate; `None` if there are none. Cycles are those without
/// fluctuation of friction.
pub(super) fn vibrating_machines(
    machines: &Machines<'_>,
    sampled: &Sampled,
    monitor: &dyn Monitor,
) -> Result<Option<VibratingMachines>, Cancelled> {
    let vibrates = |index: &usize| sampled.machines[*index].as_ref().is_ok_and(|m| m.margins.from_stick < 0.0);
    let indices: Vec<usize> = (0..sampled.machines.len()).filter(vibrates).take(MOST).collect();
    let task = Task::new(monitor, "verdict: cycles", indices.len());
    let cycles: Vec<_> = blocks::map::<_, Result<Vec<_>, Cancelled>>(0..indices.len(), |place| {
        task.step(|| {
            let machine = machines.at(&machines.variables_of(indices[place])).ok()?;
            let cycle = *limit_cycle(&machine.oscillator).ok()?.cycle()?;
            let scales = machine.study.scales;
            let hertz = 1.0 / (cycle.period * scales.time_s());
            let velocity = 0.5 * (cycle.velocity_max - cycle.velocity_min) * scales.velocity_m_per_s();
            let displacement = 0.5 * (cycle.displacement_max - cycle.displacement_min) * scales.length_m();
            Some((kind_result(cycle.kind), [hertz, velocity, displacement]))
        })
    })?
    .into_iter()
    .flatten()
    .collect();
    if cycles.is_empty() {
        return Ok(None);
    }
    let mut kinds = BTreeMap::new();
    for (kind, _) in &cycles {
        *kinds.entry(kind.name().to_owned()).or_insert(0.0) += 1.0 / cycles.len() as f64;
    }
    let quantiles = |which: usize| {
        let mut sorted: Vec<f64> = cycles.iter().map(|(_, numbers)| numbers[which]).collect();
        sorted.sort_by(f64::total_cmp);
        let [q05, q50, q95] = [0.05, 0.5, 0.95].map(|probability| quantile_sorted(&sorted, probability));
        Quantiles { q05, q50, q95 }
    };
    Ok(Some(VibratingMachines {
        kinds,
        frequency_hz: quantiles(0),
        velocity_amplitude_m_per_s: quantiles(1),
        displacement_amplitude_m: quantiles(2),
    }))
}
