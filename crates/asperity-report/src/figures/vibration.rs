//! Stick-slip: phase portraits, distributions of points, cycles over damping, and the answers of the vibration commands.

mod basin;
mod bifurcation;
mod critical_curve;
mod cycles;
mod modes;
mod points;
mod portrait;
mod sound;
pub(super) mod stability_map;
mod survival;

use std::collections::BTreeMap;

use serde_json::Value;

use super::{CaptionedFigure, columns, present};
use crate::plot::{BLUE, Chart, Colour, Dash, GREEN, ORANGE, Pen, VERMILION, WHITE};
use crate::{ReportError, Run, Table};

/// The tables of a command or of a run, by name.
type Tables = BTreeMap<String, Table>;

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
    let answer = run.results.mode_coupling.as_ref().and_then(|result| serde_json::to_value(result).ok());
    answer.and_then(|answer| modes::over_friction(&answer, &run.tables)).into_iter().collect()
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
        modes::over_friction(answer, tables),
        modes::cycle(answer, tables),
    ];
    Ok(drawn.into_iter().flatten().collect())
}

/// Returns the label of an axis over a parameter of the machine.
fn axis_label(parameter: &str) -> String {
    let label = match parameter {
        "damping_ratio" => "Damping ratio ζ",
        "belt_velocity" => "Belt velocity V",
        "friction_std" => "Standard deviation of μ",
        "load_ratio" => "Load ratio N/N₀",
        "static_friction" => "Static friction coefficient",
        "weakening" => "Weakening rate of the friction law",
        "forcing_amplitude" => "Amplitude q of the force",
        "forcing_frequency" => "Frequency η of the force",
        other => return other.replace('_', " "),
    };
    label.to_owned()
}

/// Attractors of the motion: number in tables, name, colour and dash.
const ATTRACTORS: [(f64, &str, Colour, Dash); 4] = [
    (0.0, "steady sliding", BLUE, Dash::Long),
    (1.0, "slip cycle", GREEN, Dash::Alternating),
    (2.0, "stick–slip", VERMILION, Dash::Solid),
    (3.0, "overtaking", ORANGE, Dash::Short),
];

/// Returns the points of several curves, with an undefined point between them wherever the number of the curve changes.
fn separated(curve: &[f64], x: &[f64], y: &[f64]) -> (Vec<f64>, Vec<f64>) {
    let points = (0..x.len()).flat_map(|i| {
        let starts = i > 0 && curve[i].to_bits() != curve[i - 1].to_bits();
        starts.then_some((f64::NAN, f64::NAN)).into_iter().chain([(x[i], y[i])])
    });
    points.unzip()
}

/// Draws a line with a white halo, which is visible on every colour.
pub(super) fn outlined(chart: &mut Chart, name: &str, x: &[f64], y: &[f64], pen: Pen) {
    chart.line("", x, y, Pen { opacity: 0.85, ..Pen::new(WHITE, pen.width + 2.6, Dash::Solid) });
    chart.line(name, x, y, pen);
}
