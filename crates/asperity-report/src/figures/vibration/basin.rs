//! What starts end in, over the phase plane.

use std::collections::BTreeMap;

use plotters::prelude::RGBColor;

use super::{ATTRACTORS, Words, columns, outlined};
use crate::axis::{Axis, range};
use crate::canvas::{Dash, Pen};
use crate::chart::{Backdrop, Chart, Layout, Mark};
use crate::format::Unit;
use crate::image;
use crate::palette::{BLACK, VERMILION, pale};
use crate::{Figure, ReportError, Table};

/// Most pixels of the image along an axis.
const MOST: usize = 4096;

const WORDS: Words = Words {
    name: "basin",
    title: "What starts end in",
    description: "Every point of the phase plane in the colour of the attractor that a mass started there ends in, with the border \
                  between them and the limit cycle.",
};

/// The colour of an area; slip cycles are darker, so that neighbours differ in lightness as well.
fn tint(kind: f64, colour: RGBColor) -> RGBColor {
    pale(colour, if kind == 1.0 { 0.7 } else { 0.35 })
}

pub(super) fn figure(tables: &BTreeMap<String, Table>) -> Result<Option<Figure>, ReportError> {
    let names = ["displacement", "velocity", "attractor"];
    let Some([x, y, attractor]) = tables.get("basin").and_then(|t| columns(t, names)) else { return Ok(None) };
    let Some(grid) = Grid::of(x, y) else { return Ok(None) };
    let axis = |name: &str, ends| Axis::linear(name, Unit::none(), ends);
    let mut chart = Chart::new(axis("Start: displacement X", grid.x), axis("Start: velocity dX/dτ", grid.y));
    chart.backdrop = Some(Backdrop { data_uri: grid.image(attractor)?, x: grid.x, y: grid.y });
    for (kind, name, colour) in ATTRACTORS {
        if attractor.contains(&kind) {
            chart.add(name, Mark::Patch { colour: tint(kind, colour) });
        }
    }
    let curve = |name: &str| {
        let [x, y] = columns(tables.get(name)?, ["displacement", "velocity"])?;
        Some((x.to_vec(), y.to_vec()))
    };
    if let Some(border) = curve("separatrix") {
        outlined(&mut chart, "separatrix", border, Pen::new(BLACK, 2.0, Dash::Dashed));
    }
    if let Some(cycle) = curve("limit_cycle") {
        outlined(&mut chart, "limit cycle", cycle, Pen::new(VERMILION, 2.4, Dash::Solid));
    }
    WORDS.figure(Layout::Column, &[(420.0, chart)])
}

/// A regular grid of cells, row by row with rising velocity, from the centres of its cells.
struct Grid {
    columns: usize,
    rows: usize,
    /// Outer edges.
    x: (f64, f64),
    y: (f64, f64),
}

impl Grid {
    fn of(x: &[f64], y: &[f64]) -> Option<Self> {
        let columns = y.iter().take_while(|value| **value == y[0]).count();
        let rows = x.len().checked_div(columns)?;
        if columns * rows != x.len() || columns > MOST || rows > MOST {
            return None;
        }
        let edges = |values: &[f64], cells: usize| {
            let (low, high) = range(values)?;
            let half = if cells > 1 { 0.5 * (high - low) / (cells - 1) as f64 } else { 0.5 };
            Some((low - half, high + half))
        };
        Some(Self { columns, rows, x: edges(x, columns)?, y: edges(y, rows)? })
    }

    /// The image, from the top.
    fn image(&self, attractor: &[f64]) -> Result<String, ReportError> {
        let palette = std::iter::once(RGBColor(255, 255, 255))
            .chain(ATTRACTORS.iter().map(|(kind, _, colour)| tint(*kind, *colour)))
            .collect();
        let index = |found: &f64| ATTRACTORS.iter().position(|(kind, _, _)| kind == found).map_or(0, |k| k as u8 + 1);
        let rows = (0..self.rows).rev().map(|row| &attractor[row * self.columns..(row + 1) * self.columns]);
        let indices: Vec<u8> = rows.flatten().map(index).collect();
        image::indexed(self.columns, self.rows, &indices, palette)
    }
}
