//! Figures of several charts.

use super::{Chart, Legend};
use crate::ReportError;
use crate::canvas::{Rect, draw};

/// Charts over one x axis, one above the other and equally high; the lowest has its labels.
pub(crate) fn stacked(charts: Vec<Chart>, height: f64) -> Vec<(f64, Chart)> {
    let last = charts.len().saturating_sub(1);
    let place = |(index, chart)| {
        let shows_x = index == last;
        (if shows_x { height + 42.0 } else { height }, Chart { shows_x, ..chart })
    };
    charts.into_iter().enumerate().map(place).collect()
}

/// How charts share a figure.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) enum Layout {
    /// From left to right, equally wide, this high.
    Row(f64),
    /// Two beside each other, row by row, each row this high.
    Pairs(f64),
    /// One above the other; each has its height in the list given to [`figure`].
    Column,
}

/// A figure 640 px wide with one legend above its charts.
///
/// # Errors
/// The drawing backend's.
pub(crate) fn figure(
    title: &str,
    description: &str,
    layout: Layout,
    charts: &[(f64, Chart)],
) -> Result<String, ReportError> {
    const WIDTH: f64 = 640.0;
    let legend = Legend::new(charts.iter().map(|(_, chart)| chart), 72.0, WIDTH - 72.0 - 4.0);
    let top = legend.height();
    let height = match layout {
        Layout::Row(height) => top + height,
        Layout::Pairs(height) => top + charts.len().div_ceil(2) as f64 * height,
        Layout::Column => top + charts.iter().map(|(height, _)| height).sum::<f64>(),
    };
    draw((WIDTH, height), title, description, |canvas| {
        legend.draw(canvas, 0.0)?;
        let mut at = (0.0, top);
        for (place, (share, chart)) in charts.iter().enumerate() {
            match layout {
                Layout::Row(height) => {
                    let width = WIDTH / charts.len() as f64;
                    chart.draw(canvas, Rect::new(at.0, at.1, width, height))?;
                    at.0 += width;
                }
                Layout::Pairs(height) => {
                    let left = if place % 2 == 0 { 0.0 } else { 0.5 * WIDTH };
                    let top = top + (place / 2) as f64 * height;
                    chart.draw(canvas, Rect::new(left, top, 0.5 * WIDTH, height))?;
                }
                Layout::Column => {
                    chart.draw(canvas, Rect::new(at.0, at.1, WIDTH, *share))?;
                    at.1 += share;
                }
            }
        }
        Ok(())
    })
}
