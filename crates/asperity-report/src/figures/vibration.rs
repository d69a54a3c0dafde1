//! Stick-slip: phase portraits, distributions of points, cycles over damping, and the answers of the vibration commands.

mod basin;
mod bifurcation;
mod critical_curve;
pub(super) mod curves;
mod cycles;
mod modes;
mod points;
mod portrait;
mod sound;
pub(super) mod stability_map;
mod survival;

use serde_json::Value;

use self::curves::Tables;
use self::modes::Marks;
use super::CaptionedFigure;
use crate::{ReportError, Run};

/// Draws the figures for which the run holds data.
///
/// # Errors
/// The PNG encoder failed.
pub(crate) fn figures(run: &Run) -> Result<Vec<CaptionedFigure>, ReportError> {
    let charts = [portrait::of_run(run), points::of_run(run)].into_iter().flatten();
    let figures = charts.chain(cycles::figures(run)).chain(survival::of_run(run));
    Ok(figures.chain(stability_map::of_run(run)?).collect())
}

/// Draws the modes of a run over the friction coefficient.
pub(crate) fn coupled_figures(run: &Run) -> Vec<CaptionedFigure> {
    let marks = run.results.mode_coupling.as_ref().map(Marks::from);
    marks.and_then(|marks| modes::over_friction(&marks, &run.tables)).into_iter().collect()
}

/// Draws the answer of a vibration command. The names of the tables determine the figures:
///
/// - `map_cells`, `map_contours`, `map_limit`: a stability map over the parameters in the keys `x` and `y`;
/// - `bifurcation_up`, `bifurcation_down`, `bifurcation_marks`, `bifurcation_turnovers`: a bifurcation diagram, and
///   `critical_curve`, a curve of critical damping, over the key `parameter`;
/// - `sound_spectrum`: a spectrum, with the keys `level_db` and `cycle_period`;
/// - `phase_cloud`, `trajectory`, `limit_cycle`: a phase portrait; with `basin` and `separatrix` a map of attractors;
/// - `reattachment`, `release`: distributions of points, and `survival`, the fraction of trajectories that never left vibration;
/// - `modes_over_friction` and `mode_cycle`: modes over the friction coefficient, with the keys `coalescence`,
///   `critical_friction` and `friction`, and the cycle in the plane.
///
/// # Errors
/// The PNG encoder failed.
pub(crate) fn of_answer(answer: &Value, tables: &Tables) -> Result<Vec<CaptionedFigure>, ReportError> {
    let drawn = [
        stability_map::figure(answer, tables)?,
        bifurcation::figure(answer, tables),
        critical_curve::figure(answer, tables),
        sound::figure(answer, tables),
        basin::figure(tables)?,
        portrait::figure(tables),
        points::figure(tables),
        survival::figure(tables),
        modes::over_friction(&Marks::of_answer(answer), tables),
        modes::cycle(answer, tables),
    ];
    Ok(drawn.into_iter().flatten().collect())
}
