//! Attractors over the starting points in the phase plane.

use asperity_results::{AttractorMap, Portrait};

use crate::ReportError;
use crate::figures::vibration::curves::{ATTRACTORS, Tables, outlined};
use crate::figures::{CaptionedFigure, defined};
use crate::format::Unit;
use crate::plot::{Axis, BLACK, Backdrop, Chart, Colour, Dash, Mark, Pen, VERMILION, WHITE, indexed, pale, range};

/// Largest number of pixels of the image along an axis.
const MAX_ALONG: usize = 4096;

/// Returns the colour of an area. Slip cycles are darker, so that neighbours differ in lightness as well.
fn tint(kind: f64, colour: Colour) -> Colour {
    pale(colour, if kind == 1.0 { 0.7 } else { 0.35 })
}

pub(super) fn figure(tables: &Tables) -> Result<Option<CaptionedFigure>, ReportError> {
    let Some(basin) = tables.get("basin").map(AttractorMap::of) else { return Ok(None) };
    let places = defined([&basin.displacement, &basin.velocity, &basin.attractor]);
    let Some([x, y, attractor]) = places else { return Ok(None) };
    let Some(grid) = Grid::new(x, y) else { return Ok(None) };
    let axis = |name: &str, ends| Axis::linear(name, Unit::none(), ends);
    let mut chart = Chart::new(axis("Start: displacement X", grid.x), axis("Start: velocity dX/dτ", grid.y));
    chart.backdrop = Some(Backdrop { data_uri: grid.image(attractor)?, x: grid.x, y: grid.y, aspect: None });
    for (kind, name, colour, _) in ATTRACTORS {
        if attractor.contains(&kind) {
            chart.add(name, Mark::Patch { colour: tint(kind, colour) });
        }
    }
    let curves = [
        ("separatrix", "separatrix", Pen::new(BLACK, 2.0, Dash::Dashed)),
        ("limit_cycle", "limit cycle", Pen::new(VERMILION, 2.4, Dash::Solid)),
    ];
    for (table, name, pen) in curves {
        let Some(curve) = tables.get(table).map(Portrait::of) else { continue };
        if let Some([x, y]) = defined([&curve.displacement, &curve.velocity]) {
            outlined(&mut chart, name, x, y, pen);
        }
    }
    let caption = "Every point of the phase plane in the colour of the attractor that a mass started there reaches, with the border \
                   between them and the limit cycle.";
    let charts = [chart.with_height(420.0)];
    Ok(CaptionedFigure::from_charts("basin", "Attractors over the phase plane", caption, 1, &charts, &[]))
}

/// A regular grid of cells, row by row in order of velocity, from the centres of its cells.
struct Grid {
    columns: usize,
    rows: usize,
    /// Outer edges.
    x: (f64, f64),
    y: (f64, f64),
}

impl Grid {
    fn new(x: &[f64], y: &[f64]) -> Option<Self> {
        let columns = y.iter().take_while(|value| **value == y[0]).count();
        let rows = x.len().checked_div(columns)?;
        if columns * rows != x.len() || columns > MAX_ALONG || rows > MAX_ALONG {
            return None;
        }
        let edges = |values: &[f64], cells: usize| {
            let (low, high) = range(values)?;
            let half = if cells > 1 { 0.5 * (high - low) / (cells - 1) as f64 } else { 0.5 };
            Some((low - half, high + half))
        };
        Some(Self { columns, rows, x: edges(x, columns)?, y: edges(y, rows)? })
    }

    /// Encodes the image, from the top.
    fn image(&self, attractor: &[f64]) -> Result<String, ReportError> {
        let tints = ATTRACTORS.iter().map(|(kind, _, colour, _)| tint(*kind, *colour));
        let index = |found: &f64| ATTRACTORS.iter().position(|(kind, ..)| kind == found).map_or(0, |k| k as u8 + 1);
        let rows = (0..self.rows).rev().map(|row| &attractor[row * self.columns..(row + 1) * self.columns]);
        let indices: Vec<u8> = rows.flatten().map(index).collect();
        indexed(self.columns, self.rows, &indices, std::iter::once(WHITE).chain(tints).collect())
    }
}
