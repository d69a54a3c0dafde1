//! Rough cost of the friction stage.

use crate::contact::memory_bytes;
use crate::friction::DISTANCES;
use crate::friction::cutoff::{CutoffPlan, STRIPS};
use crate::map::{BoundaryKind, Grid};
use crate::study::check::{FrictionSource, FrictionStudy};
use crate::study::estimate::{STIFFNESS_WORK, contact_seconds, countable_surface, fourier_modes};
use crate::study::friction_stage::scan;
use crate::study::{Stage, StageEstimate, Study};

/// Bytes per normal variable of the generator of strips.
const GENERATOR_BYTES: f64 = 50.0;
/// Bytes per point of a strip that all threads share.
const RECORDS_BYTES: f64 = 80.0;
/// Bytes per point of a strip's normal variables, heights and window sums.
const STRIP_BYTES: f64 = 42.0;
/// Bytes per point for the interpolation of a strip to half its pitch. A free strip is mirrored along both sides.
const FINER_BYTES: f64 = 34.0;
const MIRRORED: f64 = 4.0;
/// Copies of the records of friction in its statistics.
const RECORD_COPIES: f64 = 2.5;
/// Bytes of a double.
const DOUBLE_BYTES: f64 = 8.0;

/// Returns the rough cost of the friction stage with scans of a number of heights; `None` for a study without it.
pub(in crate::study) fn cost(whole: &Study, scan_points: usize, threads: usize) -> Option<StageEstimate> {
    let study = whole.friction.as_ref()?;
    let nominal = whole.vibration.as_ref().is_some_and(|v| v.machine.friction == FrictionSource::Computed(None));
    let uncertain = study.uncertainty.as_ref().map_or(0, |u| u.points * u.realisations);
    let levels = study.levels.len() + usize::from(nominal);
    // Two rough bodies are solved again after several sliding distances, at one level.
    let slides = whole.counterface.is_some() && study.boundary == BoundaryKind::Periodic;
    let slid = if slides { DISTANCES * study.realisations } else { 0 };
    let solutions = levels * (study.realisations + uncertain) + slid;
    let plan = study.cutoff_plan(levels, 0.0);
    let others = plan.map_or(0.0, |plan| plan.work(study.points[0]));
    // The strips of the operating level have a stiffness.
    let stiffness = STIFFNESS_WORK * study.realisations as f64;
    let cells = study.points[0] as f64 * study.points[1] as f64;
    let mut cost = StageEstimate {
        contact_solutions: solutions,
        coarse_solutions: others,
        core_seconds: contact_seconds((solutions as f64 + others + stiffness) * cells),
        ..StageEstimate::new(Stage::Friction, strip_bytes(whole, study, levels, plan, threads))
    };
    // The scan itself is pressed, but not two scans on each other.
    if scan_points > 0 && study.depends_on_contact() && whole.counterface.is_none() {
        let [finest, all] = scan::cells(scan_points);
        cost.core_seconds += contact_seconds(all as f64);
        let pressed_bytes = memory_bytes(finest, BoundaryKind::Periodic) + STRIP_BYTES * finest as f64;
        cost.memory_bytes = cost.memory_bytes.max(pressed_bytes);
    }
    Some(cost)
}

/// Returns the memory of the friction stage with a number of levels.
fn strip_bytes(whole: &Study, study: &FrictionStudy, levels: usize, plan: Option<CutoffPlan>, threads: usize) -> f64 {
    let bodies = if whole.counterface.is_some() { 2.0 } else { 1.0 };
    let periodic = study.boundary == BoundaryKind::Periodic;
    let generator = |points: [usize; 2], size_m: [f64; 2]| {
        let Ok(grid) = Grid::with_size(points[0], points[1], size_m[0], size_m[1]) else { return 0.0 };
        let all_modes = || fourier_modes(grid, periodic);
        let variables =
            countable_surface(whole, grid).map_or_else(all_modes, |model| model.strip_variables(grid, periodic));
        bodies * (GENERATOR_BYTES * variables as f64 + RECORDS_BYTES * grid.points() as f64)
    };
    // Each thread has a solver and a strip.
    let solvers = |threads: usize, [nx, ny]: [usize; 2], strip_bytes: f64| {
        let cells = nx.saturating_mul(ny);
        threads as f64 * (memory_bytes(cells, study.boundary) + strip_bytes * cells as f64)
    };
    // The strips of the cut-off analysis have their own generator, and are also solved on halves of the pitch.
    let cutoff = plan.map_or(0.0, |plan| {
        let halved = plan.points.map(|points| points.saturating_mul(1 << plan.halvings));
        let finer_bytes = if periodic { FINER_BYTES } else { MIRRORED * FINER_BYTES };
        generator(plan.points, [plan.length_m, study.size_m[1]]) + solvers(threads.min(STRIPS), halved, finer_bytes)
    });
    let strips = generator(study.points, study.size_m) + solvers(threads, study.points, STRIP_BYTES);
    strips.max(cutoff) + RECORD_COPIES * levels as f64 * study.realisations as f64 * record_bytes(study)
}

/// Returns the bytes of the records of one strip at one level: six numbers at every position of the window and of
/// windows of a half, a quarter and an eighth of it, and again at the mean load.
fn record_bytes(study: &FrictionStudy) -> f64 {
    let ([nx, _], [length_m, width_m]) = (study.points, study.size_m);
    let [window_length_m, window_width_m] = study.window_m;
    let cells = (window_length_m / length_m * nx as f64).max(1.0);
    let positions: f64 = [1.0, 2.0, 4.0, 8.0]
        .iter()
        .map(|part| cells / part)
        .filter(|cells| *cells >= 4.0 || window_length_m >= length_m)
        .map(|cells| nx as f64 / (cells / 16.0).floor().max(1.0))
        .sum();
    let tracks = (width_m / window_width_m).floor().max(1.0);
    tracks * positions * 12.0 * DOUBLE_BYTES
}
