//! Rough cost of the pressure stage.

use crate::contact::memory_bytes;
use crate::map::BoundaryKind;
use crate::pressure::{pooled_pressures, stratified_designs};
use crate::study::estimate::{STIFFNESS_WORK, contact_seconds, countable_surface, fourier_modes};
use crate::study::{Stage, StageEstimate, Study};
use crate::surface::model::PatchSize;

/// Upper bound of the work of the pressure stage on coarser models, relative to the fine solves of one method: the same
/// maps at a loose tolerance, with half and a quarter of the points along either side, and further samples if they pay.
const COARSE_WORK: f64 = 4.0 + 0.5 + 0.25 + 0.0625;
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

/// Returns the rough cost of the pressure stage; `None` for a study without it.
pub(in crate::study) fn cost(whole: &Study, threads: usize) -> Option<StageEstimate> {
    let study = whole.pressure.as_ref()?;
    // The reference, and the samplers that the methods share.
    let samplers = 1 + stratified_designs(&study.methods).into_iter().filter(|needed| *needed).count();
    let solutions = study.reference_samples + samplers * study.fine_solves;
    let coarse = COARSE_WORK * study.fine_solves as f64;
    // The stiffness of the Monte Carlo samples and of those on coarser grids.
    let stiffness = if study.stiffness { STIFFNESS_WORK * (study.fine_solves as f64 + coarse) } else { 0.0 };
    let (nx, ny) = (study.grid.nx(), study.grid.ny());
    let cells = nx as f64 * ny as f64;
    let periodic = study.boundary == BoundaryKind::Periodic;
    // A surface that is measured on scans has at most all Fourier modes.
    let all_modes = PatchSize { variables: fourier_modes(study.grid, periodic), expansion_bytes: 0.0 };
    let size = countable_surface(whole, study.grid).map_or(all_modes, |model| model.patch_size(study.grid, periodic));
    let bodies = if whole.counterface.is_some() { 2.0 } else { 1.0 };
    // With the coarse ones of the default.
    let samples = solutions as f64 + coarse;
    let pooled = if periodic { pooled_pressures([nx, ny], study.reference_samples) as f64 } else { samples };
    let fields = (4.0 * cells * study.fine_solves as f64).min(MOST_FIELD_BYTES);
    let memory_bytes = DISTRIBUTION_BYTES
        + threads as f64 * memory_bytes(nx.saturating_mul(ny), study.boundary)
        + (EXPANSION_BYTES * study.fine_solves as f64).min(MOST_EXPANSION_BYTES)
        + CELL_BYTES * cells
        + bodies * (VARIABLE_BYTES * size.variables as f64 + size.expansion_bytes)
        + POOLED_BYTES * pooled
        + OBSERVATION_BYTES * samples
        + fields;
    Some(StageEstimate {
        contact_solutions: solutions,
        coarse_solutions: coarse,
        core_seconds: contact_seconds((solutions as f64 + coarse + stiffness) * cells),
        ..StageEstimate::new(Stage::Pressure, memory_bytes)
    })
}
