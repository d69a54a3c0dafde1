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
    let drawn: Vec<(Option<CaptionedFigure>, &[&str])> = match figures {
        VibrationFigures::Map(map) => {
            vec![(stability_map::drawn(map, tables)?, &["map_cells", "map_contours", "map_limit"])]
        }
        VibrationFigures::Bifurcation { parameter } => {
            let names = &["bifurcation_up", "bifurcation_down", "bifurcation_marks", "bifurcation_turnovers"];
            vec![(bifurcation::figure(parameter, tables), names)]
        }
        VibrationFigures::CriticalCurve { parameter } => {
            vec![(critical_curve::figure(parameter, tables), &["critical_curve"])]
        }
        VibrationFigures::Sound { level_db, level_db_interval, cycle_period } => {
            let level = level_db.map(|level| (level, *level_db_interval));
            vec![(sound::figure(level, *cycle_period, tables), &["sound_spectrum"])]
        }
        VibrationFigures::Basin => vec![(basin::figure(tables)?, &["basin", "separatrix", "limit_cycle"])],
        VibrationFigures::Ensemble => vec![
            (portrait::figure(tables), &["phase_cloud", "limit_cycle"]),
            (points::figure(tables), &["reattachment", "release"]),
            (survival::figure(tables), &["survival"]),
        ],
        VibrationFigures::ModeCoupling(modes) => vec![
            (modes::over_friction(modes, tables), &["modes_over_friction"]),
            (modes::cycle(modes, tables), &["mode_cycle"]),
        ],
    };
    let with_sources = |(figure, names): (Option<CaptionedFigure>, &[&str])| {
        let names: Vec<&str> = names.iter().copied().filter(|name| tables.contains_key(*name)).collect();
        figure.map(|figure| figure.with_tables(&names))
    };
    Ok(drawn.into_iter().filter_map(with_sources).collect())
}
