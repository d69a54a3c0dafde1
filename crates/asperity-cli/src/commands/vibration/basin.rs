//! Basins of attraction: the motion that follows from each start in the phase plane.

use std::path::Path;

use asperity::study::result::AttractorMap;
use asperity::study::{Table, portrait_table};
use asperity::vibration::{
    self, Basin as Found, BasinBox, MapAxis, MotionKind, Oscillator, Regime, Separatrix, limit_cycle, separatrix,
    slip_cycles,
};
use asperity_report::VibrationFigures;
use clap::Args;
use serde_json::{Value, json};

use super::folder::Folder;
use super::machine::{Damping, Machine, code};
use super::map::axis_range;
use super::series;
use crate::failure::Failure;
use crate::monitor::Terminal;
use crate::output::Answer;
use crate::resources::require_memory;

/// Cells along an axis of the default box of starts.
const CELLS: usize = 200;
/// Margin of the default box around the cycle, as a fraction of the cycle's size.
const MARGIN: f64 = 0.5;
/// Memory per cell, including its entry in the answer, in bytes.
const CELL_BYTES: f64 = 64.0;
/// Points of the separatrix.
const BORDER_POINTS: usize = 800;

/// Computes which starts lead to steady sliding and which to vibration, without fluctuation: the fraction of each kind
/// of motion over a box of starts, and the border between them.
#[derive(Debug, Args)]
pub(crate) struct Basin {
    #[command(flatten)]
    machine: Machine,
    #[command(flatten)]
    damping: Damping,
    /// Displacements X of the starts: least, largest, cells. When left out, the range of the cycle with half its size
    /// added on each side.
    #[arg(long, value_name = "FROM,TO,N", value_parser = axis_range, allow_hyphen_values = true)]
    displacements: Option<MapAxis>,
    /// Velocities dX/dτ of the starts: least, largest, cells; the default is like that of the displacements.
    #[arg(long, value_name = "FROM,TO,N", value_parser = axis_range, allow_hyphen_values = true)]
    velocities: Option<MapAxis>,
    #[command(flatten)]
    folder: Folder,
    /// Print one JSON object instead of a table.
    #[arg(long)]
    json: bool,
}

impl Basin {
    pub(crate) fn run(&self, monitor: &Terminal) -> Result<(), Failure> {
        if self.machine.forcing.is_some() {
            monitor.note("the forcing is ignored; the basins are those of the unforced machine");
        }
        let oscillator = self.machine.oscillator(self.damping.damping_ratio, monitor)?;
        let oscillator = oscillator.with_forcing(None).map_err(Failure::usage)?;
        let inputs: Vec<&Path> = self.machine.friction.inputs();
        let has_folder = self.folder.is_requested(&inputs)?;
        let area = self.area(&oscillator, monitor)?;
        let [columns, rows] = area.cells;
        require_memory(CELL_BYTES * columns as f64 * rows as f64, "the map of the starts")?;
        let found = vibration::basin(&oscillator, &area, monitor)?;
        let border = monitor.killable(|| separatrix(&oscillator, BORDER_POINTS))??;
        let cycles = monitor.killable(|| slip_cycles(&oscillator))??;
        let answer = answer(&found, border.as_ref()).with("slip_cycles", json!(cycles));
        let whole = answer.clone().with("attractors", json!(found.attractors));
        if has_folder {
            let mut tables = vec![("basin", table(&found))];
            tables.extend(border.map(|border| ("separatrix", portrait_table(&border.points))));
            tables.extend(series::cycle(&oscillator)?);
            self.folder.write("basin", &VibrationFigures::Basin, &inputs, &whole, tables, monitor)?;
        }
        if self.json { whole.print(true) } else { answer.without("slip_cycles").print(false) }
    }

    /// Returns the stated box, or the default box around the cycle.
    fn area(&self, oscillator: &Oscillator, monitor: &Terminal) -> Result<BasinBox, Failure> {
        if let (Some(x), Some(y)) = (self.displacements, self.velocities) {
            let cells = [x.cells, y.cells];
            return Ok(BasinBox { displacement: [x.from, x.to], velocity: [y.from, y.to], cells });
        }
        let regime = monitor.killable(|| limit_cycle(oscillator))??;
        let Regime::Cycle(cycle) = regime else {
            let message = "there is no cycle to derive the box of starts from; give --displacements and --velocities";
            return Err(Failure::usage(message));
        };
        let around = |low: f64, high: f64| [low - MARGIN * (high - low), high + MARGIN * (high - low)];
        let displacement = around(cycle.displacement_min, cycle.displacement_max);
        let velocity = around(cycle.velocity_min, cycle.velocity_max);
        let stated =
            |axis: Option<MapAxis>, own: [f64; 2]| axis.map_or((own, CELLS), |axis| ([axis.from, axis.to], axis.cells));
        let (x, y) = (stated(self.displacements, displacement), stated(self.velocities, velocity));
        Ok(BasinBox { displacement: x.0, velocity: y.0, cells: [x.1, y.1] })
    }
}

fn answer(found: &Found, border: Option<&Separatrix>) -> Answer {
    let fraction = |kind: MotionKind| {
        let count = found.attractors.iter().filter(|attractor| **attractor == kind).count();
        count as f64 / found.attractors.len() as f64
    };
    Answer::default()
        .with("sliding_share", found.sliding_share)
        .with("slip_cycle_share", fraction(MotionKind::SlipCycle))
        .with("stick_slip_share", fraction(MotionKind::StickSlip))
        .with("overtaking_share", fraction(MotionKind::Overtaking))
        .with("displacements", json!(found.area.displacement))
        .with("velocities", json!(found.area.velocity))
        .with("cells", json!(found.area.cells))
        .with("separatrix", border.map_or(Value::Null, |border| json!(border.kind)))
        .with("separatrix_area", border.map(Separatrix::area))
}

fn table(found: &Found) -> Table {
    let [columns, rows] = found.area.cells;
    let places = || (0..rows).flat_map(|row| (0..columns).map(move |column| found.area.centre(column, row)));
    Table::from(AttractorMap {
        displacement: places().map(|place| place[0]).collect(),
        velocity: places().map(|place| place[1]).collect(),
        attractor: found.attractors.iter().map(|attractor| code(*attractor)).collect(),
    })
}
