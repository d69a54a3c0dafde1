//! Contact pressure: one surface, all cells, one point by every method, and errors and costs of the methods.

mod accuracy;
mod distribution;
mod intervals;
mod maps;
mod style;

use super::{CaptionedFigure, field_map};
use crate::plot::Kind;
use crate::{ReportError, Run};

/// Draws the figures for which the run holds data.
///
/// # Errors
/// The PNG encoder failed.
pub(crate) fn figures(run: &Run) -> Result<Vec<CaptionedFigure>, ReportError> {
    let title = "Contact pressure on one realisation";
    let caption = "Pressure on one realisation of the surface; points without colour are not in contact. The colours saturate \
                   beyond the 99.9 % quantile.";
    let sample = field_map(run, "pressure_sample", Kind::Pressure, title, caption)?;
    let charts = [distribution::figure(run), intervals::figure(run), accuracy::figure(run)];
    Ok(sample.into_iter().chain(maps::figures(run)?).chain(charts.into_iter().flatten()).collect())
}
