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

use asperity_results::ModeCouplingResult;

use self::curves::Tables;
use super::CaptionedFigure;
use crate::motion::{CoupledModes, VibrationFigures};
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
    let modes = run.results.mode_coupling.as_ref().map(|result| {
        let &ModeCouplingResult { coalescence, critical_friction, friction, .. } = result;
        CoupledModes { coalescence, critical_friction, friction, belt_velocity: None, mean_growth: None }
    });
    modes.and_then(|modes| modes::over_friction(&modes, &run.tables)).into_iter().collect()
}

/// Draws the figures of a vibration command.
///
/// # Errors
/// The PNG encoder failed.
pub(crate) fn of_command(figures: &VibrationFigures, tables: &Tables) -> Result<Vec<CaptionedFigure>, ReportError> {
    let drawn = match figures {
        VibrationFigures::Map(map) => vec![stability_map::drawn(map, tables)?],
        VibrationFigures::Bifurcation { parameter } => vec![bifurcation::figure(parameter, tables)],
        VibrationFigures::CriticalCurve { parameter } => vec![critical_curve::figure(parameter, tables)],
        VibrationFigures::Sound { level_db, level_db_interval, cycle_period } => {
            vec![sound::figure(level_db.map(|level| (level, *level_db_interval)), *cycle_period, tables)]
        }
        VibrationFigures::Basin => vec![basin::figure(tables)?],
        VibrationFigures::Ensemble => {
            vec![portrait::figure(tables), points::figure(tables), survival::figure(tables)]
        }
        VibrationFigures::ModeCoupling(modes) => {
            vec![modes::over_friction(modes, tables), modes::cycle(modes, tables)]
        }
    };
    Ok(drawn.into_iter().flatten().collect())
}
