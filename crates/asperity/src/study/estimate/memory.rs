//! Rough memory of the stages of a study: factors on the sizes of its arrays, from runs of the program.

use crate::contact::memory_bytes;
use crate::friction::cutoff::{CutoffPlan, STRIPS};
use crate::map::{BoundaryKind, Grid};
use crate::pressure::pooled_pressures;
use crate::study::Study;
use crate::study::check::{FrictionStudy, PressureStudy};
use crate::surface::model::{PatchSize, SurfaceModel};

/// Bytes of the program itself, its libraries and its threads: from 29 to 31 MB of unoptimised code, 20 MB of optimised code.
pub(super) const PROGRAM_BYTES: f64 = 36e6;
/// Fraction of the memory of a member of a campaign that stays between members.
pub(super) const KEPT_OF_A_MEMBER: f64 = 0.1;
/// Bytes of a double.
const DOUBLE_BYTES: f64 = 8.0;
/// Bytes per point of all scans in the surface stage, and those of their statistics per point of at most [`TRIAL_POINTS`].
const SCAN_BYTES: f64 = 110.0;
const TRIAL_BYTES: f64 = 400.0;
const TRIAL_POINTS: usize = 512 * 512;
/// Bytes per point of the scans in later stages.
const KEPT_SCAN_BYTES: f64 = 70.0;
/// Bytes of the distributions of a pressure stage of any size.
const DISTRIBUTION_BYTES: f64 = 11e6;
/// Bytes of the chaos expansions per contact solution, and at most.
const EXPANSION_BYTES: f64 = 20e3;
const MOST_EXPANSION_BYTES: f64 = 8e6;
/// Bytes per pooled pressure: the values in single precision, in double precision, sorted, and with their weights.
const POOLED_BYTES: f64 = 48.0;
/// Bytes of the results of one contact solution.
const OBSERVATION_BYTES: f64 = 160.0;
/// Bytes per normal variable of a patch, and per cell: the responses of rings of cells, and directions of sensitivities.
const VARIABLE_BYTES: f64 = 340.0;
const CELL_BYTES: f64 = 330.0;
/// Most bytes of the pressures that the Monte Carlo samples keep, in single precision.
const MOST_FIELD_BYTES: f64 = 536_870_912.0;
/// Bytes per normal variable of the generator of strips.
const GENERATOR_BYTES: f64 = 74.0;
/// Bytes per point of a strip that all threads share.
const RECORDS_BYTES: f64 = 80.0;
/// Bytes per point of a strip's normal variables, heights and window sums.
const STRIP_BYTES: f64 = 42.0;
/// Most points of a grid of which the modes are counted, in seconds. A larger one counts with all its modes.
const COUNTED_POINTS: usize = 1 << 23;
/// Bytes per point for the interpolation of a strip to half its pitch. A free strip is mirrored along both sides.
const FINER_BYTES: f64 = 40.0;
const MIRRORED: f64 = 4.0;
/// Copies of the records of friction in its statistics.
const RECORD_COPIES: f64 = 2.5;

/// Returns the number of the Fourier modes of a patch or strip of a surface that scans measure.
fn fourier_modes(grid: Grid, periodic: bool) -> usize {
    if periodic { grid.points() } else { 8 * grid.points() }
}

/// Returns the memory of the surface stage.
pub(super) fn surface_bytes(scan_points: usize) -> f64 {
    SCAN_BYTES * scan_points as f64 + TRIAL_BYTES * scan_points.min(TRIAL_POINTS) as f64
}

/// Returns the memory for pressing a scan on a number of cells.
pub(super) fn pressed_bytes(cells: usize) -> f64 {
    memory_bytes(cells, BoundaryKind::Periodic) + STRIP_BYTES * cells as f64
}

/// Returns the memory that later stages need for the scans.
pub(super) fn kept_bytes(scan_points: usize) -> f64 {
    KEPT_SCAN_BYTES * scan_points as f64
}

impl Study {
    /// Returns the model of a surface that no scan measures, whose modes on a grid are counted.
    fn countable_surface(&self, grid: Grid) -> Option<SurfaceModel> {
        if grid.points() > COUNTED_POINTS {
            return None;
        }
        Some(SurfaceModel::new(self.surface.as_ref()?.request.clone(), None).ok()?.0)
    }

    /// Returns the memory of the pressure stage.
    pub(super) fn pressure_bytes(&self, study: &PressureStudy, threads: usize) -> f64 {
        let (nx, ny) = (study.grid.nx(), study.grid.ny());
        let cells = nx as f64 * ny as f64;
        let periodic = study.boundary == BoundaryKind::Periodic;
        // A surface that is measured on scans has at most all Fourier modes.
        let all_modes = PatchSize { variables: fourier_modes(study.grid, periodic), expansion_bytes: 0.0 };
        let size = self.countable_surface(study.grid).map_or(all_modes, |model| model.patch_size(study.grid, periodic));
        let bodies = if self.counterface.is_some() { 2.0 } else { 1.0 };
        let samples = study.reference_samples as f64;
        let pooled = if periodic { pooled_pressures([nx, ny], study.reference_samples) as f64 } else { samples };
        let fields = (4.0 * cells * study.fine_solves as f64).min(MOST_FIELD_BYTES);
        DISTRIBUTION_BYTES
            + threads as f64 * memory_bytes(nx.saturating_mul(ny), study.boundary)
            + (EXPANSION_BYTES * study.fine_solves as f64).min(MOST_EXPANSION_BYTES)
            + CELL_BYTES * cells
            + bodies * (VARIABLE_BYTES * size.variables as f64 + size.expansion_bytes)
            + POOLED_BYTES * pooled
            + OBSERVATION_BYTES * samples
            + fields
    }

    /// Returns the memory of the friction stage with a number of levels.
    pub(super) fn friction_bytes(
        &self,
        study: &FrictionStudy,
        levels: usize,
        plan: Option<CutoffPlan>,
        threads: usize,
    ) -> f64 {
        let bodies = if self.counterface.is_some() { 2.0 } else { 1.0 };
        let periodic = study.boundary == BoundaryKind::Periodic;
        let generator = |points: [usize; 2], size_m: [f64; 2]| {
            let Ok(grid) = Grid::with_size(points[0], points[1], size_m[0], size_m[1]) else { return 0.0 };
            let all_modes = || fourier_modes(grid, periodic);
            let variables =
                self.countable_surface(grid).map_or_else(all_modes, |model| model.strip_variables(grid, periodic));
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
