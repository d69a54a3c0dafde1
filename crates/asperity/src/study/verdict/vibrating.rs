//! Frequency and amplitude of the machines that vibrate.

use std::collections::BTreeMap;

use asperity_base::blocks::Task;

use super::dynamics::Vibration;
use super::machines::Machines;
use super::sampled::Sampled;
use crate::monitor::{Cancelled, Monitor};
use crate::stats::quantile_sorted;
use crate::study::Table;
use crate::study::result::{MachineModel, Quantiles, VibratingMachines};

/// Largest number of rows of the table of machines.
pub(super) const MOST_ROWS: usize = 4096;
/// Largest number of machines whose cycles are computed; cycles of two coupled modes take longer.
pub(super) const MOST: usize = 1024;
const MOST_COUPLED: usize = 64;

/// Returns the kinds, frequencies and amplitudes of the machines that vibrate; `None` if there are none. Cycles are those without
/// fluctuation of friction.
pub(super) fn vibrating_machines(
    machines: &Machines<'_>,
    sampled: &Sampled,
    monitor: &dyn Monitor,
) -> Result<Option<VibratingMachines>, Cancelled> {
    let most = match machines.model() {
        MachineModel::StickSlip => MOST,
        MachineModel::ModeCoupling => MOST_COUPLED,
    };
    let vibrates = |index: &usize| sampled.machines[*index].as_ref().is_ok_and(|m| m.margins.from_stick < 0.0);
    let indices: Vec<usize> = (0..sampled.machines.len()).filter(vibrates).take(most).collect();
    let task = Task::new(monitor, "verdict: cycles", indices.len());
    let vibration = |index: usize| {
        let machine = machines.at(&machines.variables_of(index)).ok()?;
        machine.dynamics.vibration(&machine.inputs.scales).ok()?
    };
    let found = task.map(indices.len(), |place| Ok::<_, Cancelled>(vibration(indices[place])))?;
    let found: Vec<Vibration> = found.into_iter().flatten().collect();
    if found.is_empty() {
        return Ok(None);
    }
    let mut kinds = BTreeMap::new();
    for vibration in &found {
        *kinds.entry(vibration.kind).or_insert(0.0) += 1.0 / found.len() as f64;
    }
    let quantiles = |of: fn(&Vibration) -> Option<f64>| {
        let mut sorted: Vec<f64> = found.iter().filter_map(of).filter(|number| number.is_finite()).collect();
        sorted.sort_by(f64::total_cmp);
        let [q05, q50, q95] = [0.05, 0.5, 0.95].map(|probability| quantile_sorted(&sorted, probability));
        (!sorted.is_empty()).then_some(Quantiles { q05, q50, q95 })
    };
    Ok(Some(VibratingMachines {
        kinds,
        frequency_hz: quantiles(|vibration| Some(vibration.frequency_hz)),
        velocity_amplitude_m_per_s: quantiles(|vibration| vibration.velocity_amplitude_m_per_s),
        displacement_amplitude_m: quantiles(|vibration| vibration.displacement_amplitude_m),
    }))
}

/// Returns the first sampled machines: their kinds of motion without fluctuation of friction, uncertain values in SI, friction
/// coefficients, stiffnesses of the computed contact over the nominal area, and margins.
pub(super) fn samples_table(
    machines: &Machines<'_>,
    sampled: &Sampled,
    monitor: &dyn Monitor,
) -> Result<Table, Cancelled> {
    let count = sampled.machines.len().min(MOST_ROWS);
    let task = Task::new(monitor, "verdict: samples", count);
    let row = |index: usize| {
        let variables = machines.variables_of(index);
        let margin = sampled.machines[index].as_ref().ok()?.margins.from_stick;
        let machine = machines.at(&variables).ok()?;
        Some((
            machine.dynamics.kind().ok()?.name().to_owned(),
            machines.inputs().values(&variables),
            machine.window.mean,
            machine.window.stiffness_pa_per_m.map(|stiffness| stiffness * machine.inputs.nominal_area.0),
            margin,
        ))
    };
    let rows = task.map(count, |index| Ok::<_, Cancelled>(row(index)))?;
    let rows: Vec<_> = rows.into_iter().flatten().collect();
    let inputs = machines.inputs().inputs().iter().enumerate();
    let mut columns: Vec<(String, Vec<f64>)> = inputs
        .map(|(place, input)| (input.name().to_owned(), rows.iter().map(|(_, values, ..)| values[place]).collect()))
        .collect();
    columns.push(("friction_coefficient".into(), rows.iter().map(|(_, _, friction, ..)| *friction).collect()));
    let stiffnesses: Option<Vec<f64>> = rows.iter().map(|(.., stiffness, _)| *stiffness).collect();
    columns.extend(stiffnesses.map(|stiffnesses| ("contact_stiffness_n_per_m".into(), stiffnesses)));
    columns.push(("damping_margin".into(), rows.iter().map(|(.., margin)| *margin).collect()));
    Ok(Table::with_names(rows.into_iter().map(|(kind, ..)| kind).collect(), columns))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::friction::WindowFriction;
    use crate::monitor::Silent;
    use crate::study::Study;
    use crate::study::verdict::rests_on::tests::{STUDY, computed_window};
    use crate::study::verdict::sampled::Evaluated;

    #[test]
    fn the_table_of_samples_states_values_friction_stiffness_and_margins() {
        let text = STUDY
            .replace("0.17", "\"0.05 ± 0.01\"")
            .replace("belt_velocity = \"0.1 m/s\"", "dimensionless_belt_velocity = 0.1")
            + "velocity_law = \"linear\"\nlinear_weakening = 0.1\n";
        let study = Study::parse(&text, "study.toml").unwrap();
        let verdict = study.verdict.as_ref().unwrap();
        let window = WindowFriction { stiffness_pa_per_m: Some(2e12), ..computed_window(None) };
        let machines = Machines::new(verdict, &window, None, 1);
        let evaluate = |machine: &_, _: usize| Evaluated::constant_friction(machine);
        let sampled = Sampled::until(&machines, &evaluate, 0.5, 64, &Silent).unwrap();
        let table = samples_table(&machines, &sampled, &Silent).unwrap();
        let column = |name: &str| table.column(name).unwrap_or_else(|| panic!("{name}")).to_vec();
        let damping = column("vibration.damping_ratio");
        assert_eq!(damping.len(), 64);
        assert!(column("friction_coefficient").iter().all(|friction| *friction == 0.3));
        // 2·10¹² Pa/m on 833 mm².
        assert!(column("contact_stiffness_n_per_m").iter().all(|stiffness| (stiffness / 1.666e9 - 1.0).abs() < 1e-12));
        for (margin, damping) in column("damping_margin").iter().zip(damping) {
            assert!((margin - (damping - 0.05)).abs() < 1e-6, "{margin} of {damping}");
        }
    }
}
