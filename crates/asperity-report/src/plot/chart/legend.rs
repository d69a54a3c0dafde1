//! Legend of one or several charts.

use super::mark::{DISC, Mark, SYMBOL, Series};
use crate::plot::canvas::{Align, Canvas, Pen, Rect, TEXT, THIN, WHITE, text_width};

/// Height of one row in print, in pixels.
pub(super) const PRINTED_ROW: f64 = 21.0;

/// The named series of several charts, each name once, in rows that fit a width.
pub(super) struct Legend<'a> {
    rows: Vec<Vec<(f64, &'a Series)>>,
    /// Height of one row in pixels.
    row: f64,
}

impl<'a> Legend<'a> {
    pub(super) fn new(all: impl IntoIterator<Item = &'a Series>, left: f64, width: f64, row: f64) -> Self {
        let mut rows: Vec<Vec<(f64, &Series)>> = Vec::new();
        let mut seen: Vec<&str> = vec![""];
        let mut x = f64::INFINITY;
        for series in all {
            let name = series.name.as_str();
            if seen.contains(&name) {
                continue;
            }
            seen.push(name);
            let length = 38.0 + text_width(name, TEXT) + 18.0;
            if x + length > left + width {
                rows.push(Vec::new());
                x = left;
            }
            rows.last_mut().into_iter().for_each(|row| row.push((x, series)));
            x += length;
        }
        Self { rows, row }
    }

    pub(super) fn height(&self) -> f64 {
        if self.rows.is_empty() { 0.0 } else { self.row * self.rows.len() as f64 + 6.0 }
    }

    pub(super) fn draw(&self, canvas: &mut Canvas, top: f64) {
        for (row, entries) in self.rows.iter().enumerate() {
            let y = top + self.row * (row as f64 + 0.5) + 4.0;
            for (x, series) in entries {
                canvas.group(&[("data-entry", &series.name)], |canvas| {
                    if self.row > PRINTED_ROW {
                        // The area of a button; paper has none.
                        let width = 38.0 + text_width(&series.name, TEXT);
                        canvas.fill(Rect::new(*x, y - 0.5 * self.row, width, self.row), WHITE, 0.0);
                    }
                    draw_sample(canvas, (*x, y), &series.mark);
                    canvas.text((*x + 38.0, y), &series.name, TEXT, Align::Start);
                });
            }
        }
    }
}

/// Draws the sample of a mark beside its name.
fn draw_sample(canvas: &mut Canvas, (x, y): (f64, f64), mark: &Mark) {
    let line = [(x, y), (x + 32.0, y)];
    let patch = Rect::new(x + 4.0, y - 6.0, 24.0, 12.0);
    match mark {
        Mark::Symbol { shape, colour, .. } => shape.draw(canvas, (x + 16.0, y), SYMBOL, *colour),
        Mark::Line { pen, .. } | Mark::Vertical { pen, .. } | Mark::Horizontal { pen, .. } | Mark::Span { pen, .. } => {
            canvas.line(&line, Pen { opacity: pen.opacity.max(0.7), ..*pen });
        }
        Mark::Points { pen, .. } => {
            canvas.line(&line, *pen);
            canvas.disc((x + 16.0, y), DISC, pen.colour);
        }
        Mark::Band { colour, .. } | Mark::Bars { colour, .. } | Mark::Region { colour, .. } => {
            canvas.fill(patch, *colour, 0.30);
        }
        Mark::Dots { colour, .. } => {
            for place in [(x + 9.0, y + 2.0), (x + 16.0, y - 3.0), (x + 23.0, y + 1.0)] {
                canvas.dot(place, 2.0, *colour, 0.8);
            }
        }
        Mark::Patch { colour } => {
            canvas.fill(patch, *colour, 1.0);
            canvas.frame(patch, Pen { width: 0.8, ..THIN });
        }
        Mark::Note { .. } => {}
    }
}
