//! Rough cost of the verdict.

use super::fluctuating::NEGLIGIBLE_STD;
use super::judge::LATER;
use super::replicates::REPLICATES;
use super::scan::{POINTS as SCAN_POINTS, is_in_mean};
use super::{area, assumed, axis, decided, expansion, map, margins, points, remedies, rests_on, sampled, vibrating};
use crate::contact::memory_bytes;
use crate::friction::{RoughBody, Upscaling};
use crate::map::BoundaryKind;
use crate::study::check::{FrictionSource, FrictionStudy, MachineInputs, RemedyStudy, VerdictStudy};
use crate::study::estimate::contact_seconds;
use crate::study::result::MachineModel;
use crate::study::vibration_stage::trajectory_seconds;
use crate::study::{Stage, StageEstimate, Study};

/// Seconds per machine without fluctuation: its values, and the search for the limit of its damping.
const MACHINE_SECONDS: f64 = 0.04e-3;
/// Trajectories that decide a typical machine whose friction fluctuates, and one of those that remedies choose near the limit.
const TRAJECTORIES: usize = 12;
const TRAJECTORIES_NEAR_LIMIT: usize = 100;
/// Evaluations of all machines of a remedy per target, in the search for its value.
const EVALUATIONS_PER_TARGET: usize = 15;
const FLUCTUATING_EVALUATIONS_PER_TARGET: usize = 6;
/// Typical standard deviations of the friction of one window relative to its mean, of plastic contact and of elastic contact.
const PLASTIC_STD: f64 = 0.005;
const ELASTIC_STD: f64 = 0.1;
/// Limit cycles of sampled machines, in machines: those of the samples' table and of the machines that vibrate.
const CYCLES: usize = vibrating::MOST_ROWS + vibrating::MOST;

/// Returns the rough cost of the verdict beyond that of the stages that it needs; `None` for a study without vibration.
pub(in crate::study) fn cost(whole: &Study, threads: usize) -> Option<StageEstimate> {
    let (study, vibration) = (whole.verdict.as_ref()?, whole.vibration.as_ref()?);
    let friction =
        whole.friction.as_ref().filter(|_| matches!(vibration.machine.friction, FrictionSource::Computed(_)));
    let model = vibration.machine.model();
    // Coupled modes have the mean friction coefficient.
    let fluctuates = model == MachineModel::StickSlip
        && match &vibration.machine.friction {
            FrictionSource::Stated(stated) => stated.std > 0.0,
            FrictionSource::File(_) => true,
            FrictionSource::Computed(_) => friction.is_some_and(|friction| {
                friction.body != RoughBody::Slider && typical_fluctuation(friction, &vibration.machine) > NEGLIGIBLE_STD
            }),
        };
    // The uncertainty due to the scans of a body is one more value, whose effect takes solved points of its own.
    let file = whole.file();
    let scanned = [
        file.surface.as_ref().is_some_and(|surface| surface.file.is_some()),
        file.counterface.as_ref().is_some_and(|counterface| counterface.file.is_some()),
    ];
    let counts = friction.is_some() && study.scan_errors && !is_in_mean(whole, study);
    let scans = if counts { scanned.into_iter().filter(|is_scanned| *is_scanned).count() } else { 0 };
    // The parts of a rough slider differ.
    let parts = usize::from(friction.is_some_and(|friction| friction.body != RoughBody::Track));
    let samples = match study.places.len() + scans + parts {
        0 => 1,
        _ => sampled::largest_number(study.half_width, study.evaluations),
    };
    let of_remedies = study
        .computed_remedies(samples == 1, fluctuates)
        .iter()
        .enumerate()
        .map(|(place, remedy)| remedy_cost((remedy, place == 0), study, model, fluctuates));
    let [of_remedies, decided] = of_remedies.fold([0, 0], |[a, b], [machines, decided]| [a + machines, b + decided]);
    let (mut machines, mut paths) = (samples + samples.min(CYCLES) + map_machines(study, model) + of_remedies, 0);
    // Coupled modes do not depend on these values.
    let ends = if vibration.machine.coupled.is_some() { 0 } else { rests_on::assumed_ends(&file.unstated) };
    let of_ends = ends * samples.min(assumed::MACHINES);
    if fluctuates {
        // The samples follow the fluctuation, and so do their longer paths, the windows that share the load, the ends of the ranges of
        // values that are not stated, and remedies.
        let followed =
            samples + LATER * samples.min(sampled::LATER) + area::ROWS * samples.min(area::FLUCTUATING) + of_ends;
        paths = TRAJECTORIES * followed + TRAJECTORIES_NEAR_LIMIT * decided;
    } else {
        machines += parts * area::ROWS * samples.min(area::CONSTANT) + of_ends;
    }
    // The errors of the scans of plastic contact are usually factors of friction.
    let is_plastic = friction.is_some_and(|friction| friction.material.hardness_pa.is_some());
    let values = axis::contact_places(study).len() + if is_plastic { 0 } else { scans };
    let expanded = if values > 0 { expansion::solved_points(values) } else { 0 };
    let contact = friction.filter(|_| values + scans > 0);
    let solutions = contact
        .map_or(0, |friction| (expanded + scans * SCAN_POINTS) * points::strips_per_point(friction.realisations));
    let cells = contact.map_or(0, |friction| friction.points[0].saturating_mul(friction.points[1]));
    let longer = study.duration_s / vibration.duration_s();
    Some(StageEstimate {
        stage: Stage::Verdict,
        contact_solutions: solutions,
        coarse_solutions: 0.0,
        trajectories: paths,
        machines,
        core_seconds: contact_seconds(solutions as f64 * cells as f64)
            + machines as f64 * MACHINE_SECONDS
            + paths as f64 * trajectory_seconds(whole, vibration) * longer,
        memory_bytes: if cells > 0 { threads as f64 * memory_bytes(cells, BoundaryKind::Periodic) } else { 0.0 },
    })
}

/// Returns the standard deviation of the computed friction of a machine relative to its mean, as it typically is.
fn typical_fluctuation(friction: &FrictionStudy, machine: &MachineInputs) -> f64 {
    let of_window = if friction.material.hardness_pa.is_some() { PLASTIC_STD } else { ELASTIC_STD };
    let [length_m, width_m] = friction.window_m;
    of_window
        * match machine.upscaling {
            Upscaling::Area => (length_m * width_m / machine.nominal_area.0).min(1.0).sqrt(),
            Upscaling::Paper => 1.0,
        }
}

/// Returns the numbers of machines that are evaluated with constant friction for a remedy, and that ensembles decide.
/// `risk` is whether the probability along it is drawn.
fn remedy_cost(
    (remedy, risk): (&RemedyStudy, bool),
    study: &VerdictStudy,
    model: MachineModel,
    fluctuates: bool,
) -> [usize; 2] {
    let (points, per_target) = match (study.places.len(), fluctuates) {
        (0, _) => (1, EVALUATIONS_PER_TARGET),
        (_, true) => (remedies::FLUCTUATING_POINTS, FLUCTUATING_EVALUATIONS_PER_TARGET),
        (_, false) => (remedies::POINTS, EVALUATIONS_PER_TARGET),
    };
    let all = REPLICATES * points;
    let cost = |one: usize, all: usize| (remedies::STEPS + 1) * one + per_target * study.targets.len() * all;
    let risks = if risk { remedies::RISKS } else { 0 };
    let risk_points = if fluctuates { points } else { all };
    let machines = if margins::is_damping(remedy.place, model) { all } else { cost(points, all) + risks * risk_points };
    let decided = cost(decided::decisions(points), decided::decisions(all)) + risks * decided::decisions(risk_points);
    [machines, if fluctuates { decided } else { 0 }]
}

/// Returns the number of machines of the map.
fn map_machines(study: &VerdictStudy, model: MachineModel) -> usize {
    let Some([x, y]) = study.mapped() else { return 0 };
    let points = if study.places.is_empty() { 1 } else { REPLICATES * map::POINTS };
    let is_damping = [x, y].iter().any(|remedy| margins::is_damping(remedy.place, model));
    map::VALUES * points * if is_damping { 1 } else { map::VALUES }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Returns the machines and trajectories of a verdict with a remedy.
    fn cost(model: &str, remedy: &str) -> [usize; 2] {
        let text = format!(
            "seed = 1\n[vibration]\n{model}mass = \"1 kg\"\nnatural_frequency = \"316 rad/s\"\nnormal_force = \"2.5 kN\"\n\
             nominal_area = \"833 mm^2\"\nbelt_velocity = \"0.1 m/s\"\ndamping_ratio = \"0.1 ± 0.01\"\nstatic_friction = 0.3\n\
             friction_std = 0.01\nfriction_correlation_length = \"250 um\"\nfriction_marginal = \"normal\"\n\
             [verdict]\nremedies = [{{ input = \"vibration.{remedy}\", range = [0.01, 0.5] }}]\n"
        );
        let found = super::cost(&Study::parse(&text, "study.toml").unwrap(), 1).unwrap();
        [found.machines, found.trajectories]
    }

    #[test]
    fn only_one_mode_has_a_limit_of_the_damping_that_replaces_evaluations() {
        let coupled = "model = \"mode_coupling\"\n";
        assert_eq!(cost(coupled, "damping_ratio"), cost(coupled, "static_friction"));
        let [damping, friction] = ["damping_ratio", "static_friction"].map(|remedy| cost("", remedy));
        assert!(friction[0] - damping[0] > 90_000, "{friction:?} and {damping:?}");
        // Coupled modes have the mean friction coefficient.
        assert!(cost(coupled, "damping_ratio")[1] == 0 && damping[1] == friction[1] && damping[1] > 0);
    }
}
