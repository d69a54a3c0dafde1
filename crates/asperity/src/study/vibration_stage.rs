//! Stick-slip of a mass on a belt under the friction process.

mod clipping;
pub(super) mod cost;
mod ensembles;
mod entries;
mod map;
mod tables;

pub use self::clipping::clipping_warning;
pub(super) use self::cost::{cost, trajectory_seconds};
use self::ensembles::Ensembles;
pub(super) use self::ensembles::refuse_clipping;
use self::entries::cycle_result;
pub use self::map::{map_result, stability_map_tables};
use self::tables::damping_table;
pub use self::tables::{cloud_table, points_table, portrait_table, survival_table};

use crate::friction::{Upscaling, WindowFriction};
use crate::monitor::Monitor;
use crate::study::StudyError;
use crate::study::check::{FrictionSource, VibrationStudy};
use crate::study::output::StageOutput;
use crate::study::result::{VibrationResult, distribution_result};
use crate::study::run_machine::RunMachine;
use crate::vibration::{CONSTANT_STD, VibrationError, critical_damping, limit_cycle, limit_damping, smallest_kick};

/// Output of the vibration stage.
pub(super) struct VibrationStage {
    pub(super) result: VibrationResult,
    /// Machine of the run; `None` if friction has no course along the path.
    pub(super) machine: Option<RunMachine>,
    pub(super) output: StageOutput,
}

/// Simulates the ensembles of a study. `has_path` states whether friction has a course along the path.
pub(super) fn run(
    study: &VibrationStudy,
    window: &WindowFriction,
    has_path: bool,
    seed: u64,
    monitor: &dyn Monitor,
) -> Result<VibrationStage, StudyError> {
    let ensembles = Ensembles::new(study, window, seed)?;
    let oscillator = ensembles.oscillator.clone();
    let mut warnings = window.warnings.clone();
    let (paper, paper_ensemble) = ensembles.run(Upscaling::Paper, monitor, &mut warnings)?;
    let (area, area_ensemble) = ensembles.run(Upscaling::Area, monitor, &mut warnings)?;
    // For a study without a measured process, the study file alone decides.
    let is_stated = || window.stribeck == study.machine.dimensionless_stribeck();
    warnings.extend(
        study.load_warning().filter(|_| matches!(study.machine.friction, FrictionSource::File(_)) && is_stated()),
    );
    let critical = found_or_none(critical_damping(&oscillator))?;
    let free = oscillator.forcing().is_none();
    let regime = limit_cycle(&oscillator)?;
    let velocity_scale = study.machine.scales.velocity_m_per_s();
    let kick = if free { found_or_none(smallest_kick(&oscillator))?.flatten() } else { None };
    let mut tables = vec![("cycles_over_damping", damping_table(&paper, &area))];
    tables.extend(ensembles.portraits(monitor)?);
    for (name, ensemble) in [("reattachment_paper", &paper_ensemble), ("reattachment_area", &area_ensemble)] {
        if let Some(table) = ensemble.as_ref().and_then(|ensemble| points_table(&ensemble.reattachments)) {
            tables.push((name, table));
        }
    }
    for (name, ensemble) in [("survival_paper", &paper_ensemble), ("survival_area", &area_ensemble)] {
        tables.extend(ensemble.as_ref().map(|ensemble| (name, survival_table(&ensemble.passages, study.duration))));
    }
    let mut map = None;
    if let Some(plan) = &study.map {
        warnings.extend(ensembles.map_clipping(plan)?);
        let found = ensembles.map(plan, monitor)?;
        let [x, y] = plan.over.axes();
        tables.extend(stability_map_tables(&found, [x, y]));
        map = Some(map_result(&found, [x, y]));
    }
    let (assumptions, machine) = (ensembles.sentences(), has_path.then(|| ensembles.machine()));
    let result = VibrationResult {
        damping_ratio: study.machine.damping_ratio,
        belt_velocity: oscillator.belt_velocity(),
        static_friction: window.mean,
        level_percentile: window.level_percentile,
        level_mean_pressure_pa: window.level_mean_pressure_pa,
        friction_correlation_length_m: has_path.then_some(window.length_m),
        correlation_length: has_path.then(|| ensembles.correlation_length()),
        marginal: (window.std >= CONSTANT_STD).then(|| distribution_result(&window.marginal)),
        variance_reduction: window.variance_reduction,
        critical_damping_ratio: critical.map(|c| c.critical_damping_ratio),
        hopf_damping_ratio: critical.map(|c| c.hopf_damping_ratio),
        limit_damping_ratio: found_or_none(limit_damping(&oscillator))?,
        kind: regime.kind(),
        steady_sliding_unstable: free.then(|| oscillator.sliding_is_unstable()),
        kick_m_per_s: kick.map(|kick| kick * velocity_scale),
        cycle: cycle_result(oscillator.damping_ratio(), &regime),
        upscaling: study.machine.upscaling.name().into(),
        map,
        paper,
        area,
    };
    Ok(VibrationStage { result, machine, output: StageOutput { tables, fields: Vec::new(), assumptions, warnings } })
}

/// Converts a failed search to `None`.
fn found_or_none<T>(answer: Result<T, VibrationError>) -> Result<Option<T>, VibrationError> {
    match answer {
        Ok(found) => Ok(Some(found)),
        Err(VibrationError::NotFound { .. }) => Ok(None),
        Err(error) => Err(error),
    }
}
