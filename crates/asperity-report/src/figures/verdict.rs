//! Figures of the verdict: the probability over two inputs, and against the number of windows that share the load.

mod area;
mod map;

use super::CaptionedFigure;
use crate::{ReportError, Run};

/// Draws the figures for which the run holds data.
///
/// # Errors
/// The PNG encoder failed.
pub(crate) fn figures(run: &Run) -> Result<Vec<CaptionedFigure>, ReportError> {
    Ok(map::figure(run)?.into_iter().chain(area::figure(run)).collect())
}
