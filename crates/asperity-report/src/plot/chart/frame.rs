//! Ticks, grid and labels around the plot of a chart.

use std::iter;

use super::{Backdrop, Chart};
use crate::plot::axis::{Axis, Tick};
use crate::plot::canvas::{Align, Canvas, GRID, LABEL, Pen, Rect, TEXT, THIN, text_width};

impl Chart {
    /// Draws the image behind the marks.
    pub(super) fn draw_backdrop(&self, canvas: &mut Canvas, plot: Rect) {
        if let Some(Backdrop { data_uri, x, y, .. }) = &self.backdrop {
            let ends = (self.x_at(plot, x.0), self.x_at(plot, x.1), self.y_at(plot, y.1), self.y_at(plot, y.0));
            if let (Some(left), Some(right), Some(top), Some(bottom)) = ends {
                canvas.image(Rect { left, top: top.min(bottom), right, bottom: top.max(bottom) }, data_uri);
            }
        }
    }

    /// Draws the grid, the ticks and the labels.
    pub(super) fn draw_axes(&self, canvas: &mut Canvas, plot: Rect) {
        let grid = self.backdrop.is_none().then_some(GRID);
        group(canvas, "x", &self.x, |canvas| draw_x_ticks(canvas, plot, &self.x, grid, self.shows_x));
        group(canvas, "y", &self.y, |canvas| {
            for tick in self.y.ticks((plot.height() / 70.0).max(2.0) as usize) {
                let y = plot.bottom - tick.position * plot.height();
                if !tick.label.is_empty() {
                    grid.into_iter().for_each(|grid| canvas.line(&[(plot.left, y), (plot.right, y)], grid));
                    if self.shows_y {
                        canvas.text((plot.left - 8.0, y), &tick.label, TEXT, Align::End);
                    }
                }
                canvas.line(&[(plot.left - length(&tick), y), (plot.left, y)], THIN);
            }
        });
        if self.shows_x {
            canvas.text((plot.centre().0, plot.bottom + 38.0), &self.x.label(), LABEL, Align::Middle);
        }
        if self.shows_y {
            canvas.text((plot.left - 60.0, plot.centre().1), &self.y.label(), LABEL, Align::Upward);
        }
    }
}

/// Draws the ticks of an axis as a group that states the axis.
fn group(canvas: &mut Canvas, name: &str, axis: &Axis, ticks: impl FnOnce(&mut Canvas)) {
    let own = axis.attributes();
    let own = own.iter().map(|(name, value)| (*name, value.as_str()));
    canvas.group(&iter::once(("data-axis", name)).chain(own).collect::<Vec<_>>(), ticks);
}

/// Returns the length of a tick; minor ones, without a label, are shorter.
fn length(tick: &Tick) -> f64 {
    if tick.label.is_empty() { 3.0 } else { 5.0 }
}

/// Draws the ticks of a horizontal axis below `plot`, with grid lines and numbers if wanted.
fn draw_x_ticks(canvas: &mut Canvas, plot: Rect, axis: &Axis, grid: Option<Pen>, numbers: bool) {
    for tick in fitting_ticks(axis, plot.width()) {
        let x = plot.left + tick.position * plot.width();
        if let Some(grid) = grid.filter(|_| !tick.label.is_empty()) {
            canvas.line(&[(x, plot.top), (x, plot.bottom)], grid);
        }
        canvas.line(&[(x, plot.bottom), (x, plot.bottom + length(&tick))], THIN);
        if numbers && !tick.label.is_empty() {
            canvas.text((x, plot.bottom + 15.0), &tick.label, TEXT, Align::Middle);
        }
    }
}

/// Returns the ticks of a horizontal axis, as many as there is room for their labels.
fn fitting_ticks(axis: &Axis, width: f64) -> Vec<Tick> {
    let most = (width / 110.0).max(2.0) as usize;
    let fits = |ticks: &Vec<Tick>| {
        let labelled: Vec<&Tick> = ticks.iter().filter(|tick| !tick.label.is_empty()).collect();
        labelled.windows(2).all(|pair| {
            let needed = 0.5 * (text_width(&pair[0].label, TEXT) + text_width(&pair[1].label, TEXT)) + 8.0;
            (pair[1].position - pair[0].position) * width >= needed
        })
    };
    let mut all = (1..=most).rev().map(|wanted| axis.ticks(wanted));
    all.clone().find(fits).or(all.next_back()).unwrap_or_default()
}
