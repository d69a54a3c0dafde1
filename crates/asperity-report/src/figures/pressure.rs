//! The contact pressure of one surface, its laws at all cells, its law at a point by every method, what the methods cost and
//! are worth, and which variables matter.

mod accuracy;
mod distribution;
mod intervals;
mod maps;
mod scalars;
pub(super) mod sensitivities;

use plotters::prelude::RGBColor;

use super::{Plate, Stage, map};
use crate::canvas::{Dash, Pen};
use crate::palette::{BLUE, GREEN, ORANGE, PLUM, PURPLE, SKY, VERMILION, pen};
use crate::raster::Kind;
use crate::symbol::Shape;
use crate::{ReportError, Run};

/// Colour of the default's bands.
const BAND: RGBColor = VERMILION;

pub(super) fn plates(run: &Run, plates: &mut Vec<Plate>) -> Result<(), ReportError> {
    let title = "Contact pressure on one realisation";
    let caption = "Pressure on one realisation of the surface; white points are not in contact. The colours saturate \
                   beyond the 99.9 % quantile.";
    plates.extend(map(run, ("pressure_sample", Stage::Pressure), Kind::Pressure, title, caption)?);
    maps::plates(run, plates)?;
    distribution::plate(run, plates)?;
    intervals::plate(run, plates)?;
    accuracy::plate(run, plates)?;
    scalars::plate(run, plates)?;
    sensitivities::plate(run, plates)
}

/// The curve and the symbol of a method, the same in all figures; `index` is its place among those shown.
fn style(method: &str, index: usize) -> (Pen, Shape) {
    let (colour, width, dash, shape) = match method {
        "monte_carlo" => (BLUE, 1.8, Dash::Solid, Shape::Ring),
        "latin_hypercube" => (SKY, 1.8, Dash::Dashed, Shape::Frame),
        "sobol" => (GREEN, 1.8, Dash::Alternating, Shape::Diamond),
        "polynomial_chaos" => (PURPLE, 1.8, Dash::Dotted, Shape::Cross),
        "polynomial_chaos_log" => (ORANGE, 1.8, Dash::Long, Shape::Plus),
        "polynomial_chaos_local" => (PLUM, 1.8, Dash::Solid, Shape::OpenDiamond),
        "default" => (VERMILION, 2.6, Dash::Solid, Shape::Disc),
        _ => (pen(index).colour, pen(index).width, pen(index).dash, Shape::Ring),
    };
    (Pen::new(colour, width, dash), shape)
}
