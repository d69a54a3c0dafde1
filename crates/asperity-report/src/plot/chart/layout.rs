//! Figures of several charts.

use super::{Chart, Legend};
use crate::plot::canvas::{Rect, draw};

/// Width of a figure in pixels.
pub(crate) const WIDTH: f64 = 640.0;

/// Arranges charts over one x axis, one above the other and equally high; the lowest has the labels of the axis.
pub(crate) fn stacked(charts: Vec<Chart>, height: f64) -> Vec<Chart> {
    let last = charts.len().saturating_sub(1);
    let place = |(index, chart)| {
        let shows_x = index == last;
        Chart { shows_x, height: if shows_x { height + 42.0 } else { height }, ..chart }
    };
    charts.into_iter().enumerate().map(place).collect()
}

/// Draws charts in that many columns, row by row, with one legend above them.
pub(crate) fn figure(title: &str, description: &str, columns: usize, charts: &[Chart]) -> String {
    let legend = Legend::new(charts, 72.0, WIDTH - 76.0);
    let rows = || charts.chunks(columns).filter_map(|row| Some((row.first()?.height, row)));
    let height = legend.height() + rows().map(|(height, _)| height).sum::<f64>();
    let width = WIDTH / columns as f64;
    draw((WIDTH, height), title, description, |canvas| {
        legend.draw(canvas, 0.0);
        let mut top = legend.height();
        for (height, row) in rows() {
            for (column, chart) in row.iter().enumerate() {
                chart.draw(canvas, Rect::new(column as f64 * width, top, width, height));
            }
            top += height;
        }
    })
}
