//! Contact pressure: one surface, all cells, one point by every method, errors and costs of the methods, and sensitivities.

mod accuracy;
mod distribution;
mod intervals;
mod maps;
mod scalars;
pub(super) mod sensitivities;

use super::{CaptionedFigure, columns, field_map};
use crate::plot::{BLUE, Dash, GREEN, Kind, ORANGE, PLUM, PURPLE, Pen, SKY, Shape, VERMILION, pen};
use crate::{ReportError, Run};

/// Draws the figures for which the run holds data.
///
/// # Errors
/// The PNG encoder failed.
pub(crate) fn figures(run: &Run) -> Result<Vec<CaptionedFigure>, ReportError> {
    let title = "Contact pressure on one realisation";
    let caption = "Pressure on one realisation of the surface; white points are not in contact. The colours saturate \
                   beyond the 99.9 % quantile.";
    let sample = field_map(run, "pressure_sample", Kind::Pressure, title, caption)?;
    let charts = [
        distribution::figure(run),
        intervals::figure(run),
        accuracy::figure(run),
        scalars::figure(run),
        sensitivities::figure(run),
    ];
    Ok(sample.into_iter().chain(maps::figures(run)?).chain(charts.into_iter().flatten()).collect())
}

/// Returns the curve and the symbol of a method, the same in all figures; `index` is its place in the list.
fn style(method: &str, index: usize) -> (Pen, Shape) {
    let (colour, width, dash, shape) = match method {
        "monte_carlo" => (BLUE, 1.8, Dash::Short, Shape::Ring),
        "latin_hypercube" => (SKY, 1.8, Dash::Dashed, Shape::Frame),
        "sobol" => (GREEN, 1.8, Dash::Alternating, Shape::Diamond),
        "polynomial_chaos" => (PURPLE, 1.8, Dash::Dotted, Shape::Cross),
        "polynomial_chaos_log" => (ORANGE, 1.8, Dash::Long, Shape::Plus),
        "polynomial_chaos_local" => (PLUM, 1.8, Dash::LongShort, Shape::OpenDiamond),
        "default" => (VERMILION, 2.6, Dash::Solid, Shape::Disc),
        _ => return (pen(index), Shape::Ring),
    };
    (Pen::new(colour, width, dash), shape)
}
