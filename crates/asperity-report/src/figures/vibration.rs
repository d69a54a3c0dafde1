//! Stick-slip: phase portraits, laws of points, cycles against damping, and what the commands of the vibration compute.

mod basin;
mod bifurcation;
mod critical_curve;
mod cycles;
mod modes;
mod points;
mod portrait;
mod sound;
mod stability_map;
mod survival;

use std::collections::BTreeMap;

use plotters::prelude::RGBColor;
use serde_json::Value;

use super::{Plate, columns};
use crate::canvas::{Dash, Pen};
use crate::chart::{Chart, Layout, Mark, figure};
use crate::palette::{BLUE, GREEN, ORANGE, VERMILION};
use crate::{Figure, ReportError, Run, Table};

/// White of the halo around lines on an image.
const HALO: RGBColor = RGBColor(255, 255, 255);

pub(super) fn plates(run: &Run, plates: &mut Vec<Plate>) -> Result<(), ReportError> {
    portrait::plate(run, plates)?;
    points::plate(run, plates)?;
    cycles::plates(run, plates)?;
    survival::plate(run, plates)?;
    stability_map::plate(run, plates)
}

/// What a figure is called, and what it says of itself.
#[derive(Debug, Clone, Copy)]
struct Words {
    name: &'static str,
    title: &'static str,
    description: &'static str,
}

impl Words {
    /// The figure of charts; none without charts.
    fn figure(self, layout: Layout, charts: &[(f64, Chart)]) -> Result<Option<Figure>, ReportError> {
        if charts.is_empty() {
            return Ok(None);
        }
        let svg = figure(self.title, self.description, layout, charts)?;
        Ok(Some(Figure { name: self.name.into(), svg }))
    }
}

/// Draws what a command of the vibration computed, from its answer, as `--json` prints it, and its tables; a pure function,
/// as [`crate::render`]. Names of tables decide what is drawn:
///
/// - `map_cells`, `map_contours`, `map_limit`: a stability map over the parameters that the keys `x` and `y` name;
/// - `bifurcation_up`, `bifurcation_down`, `bifurcation_marks`, `bifurcation_turnovers`: a bifurcation diagram, and
///   `critical_curve`, a curve of critical damping, over the key `parameter`;
/// - `sound_spectrum`: a spectrum, with the keys `level_db` and `cycle_period`;
/// - `phase_cloud`, `trajectory`, `limit_cycle`: a phase portrait; with `basin` and `separatrix` a map of attractors;
/// - `reattachment`, `release`: laws of points, and `survival`, the share that has never left vibration;
/// - `modes_over_friction` and `mode_cycle`: modes over the friction coefficient, with the keys `coalescence`,
///   `critical_friction` and `friction`, and the cycle in the plane.
///
/// # Errors
/// A table with columns of different lengths; never because something is absent.
pub fn vibration_figures(answer: &Value, tables: &BTreeMap<String, Table>) -> Result<Vec<Figure>, ReportError> {
    crate::validate(tables.iter().map(|(name, table)| (name.as_str(), table)), [])?;
    let drawn = [
        stability_map::figure(answer, tables)?,
        bifurcation::figure(answer, tables)?,
        critical_curve::figure(answer, tables)?,
        sound::figure(answer, tables)?,
        basin::figure(tables)?,
        portrait::figure(tables)?,
        points::figure(tables)?,
        survival::figure(tables)?,
        modes::over_friction(answer, tables)?,
        modes::cycle(answer, tables)?,
    ];
    Ok(drawn.into_iter().flatten().collect())
}

/// A parameter of the machine as an axis calls it.
fn in_words(parameter: &str) -> String {
    let words = match parameter {
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
    words.to_owned()
}

/// Where a motion ends: its number in tables, its name and its colour.
const ATTRACTORS: [(f64, &str, RGBColor); 4] = [
    (0.0, "steady sliding", BLUE),
    (1.0, "slip cycle", GREEN),
    (2.0, "stick-slip", VERMILION),
    (3.0, "overtaking", ORANGE),
];

/// Points of several curves, one after the other, parted by undefined ones wherever the curve's number changes.
fn parted(curve: &[f64], x: &[f64], y: &[f64]) -> (Vec<f64>, Vec<f64>) {
    let (mut xs, mut ys) = (Vec::with_capacity(x.len()), Vec::with_capacity(y.len()));
    for i in 0..x.len() {
        if i > 0 && curve[i].to_bits() != curve[i - 1].to_bits() {
            xs.push(f64::NAN);
            ys.push(f64::NAN);
        }
        xs.push(x[i]);
        ys.push(y[i]);
    }
    (xs, ys)
}

/// A line that stands out on every colour.
fn outlined(chart: &mut Chart, name: &'static str, (x, y): (Vec<f64>, Vec<f64>), pen: Pen) {
    let halo = Pen { opacity: 0.85, ..Pen::new(HALO, pen.width + 2.6, Dash::Solid) };
    chart.add(None, Mark::Line { x: x.clone(), y: y.clone(), pen: halo });
    chart.add(name, Mark::Line { x, y, pen });
}
