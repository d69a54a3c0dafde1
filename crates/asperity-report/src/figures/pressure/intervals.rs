//! Contact probability and mean pressure with their intervals, method by method.

use asperity_results::{MethodEntry, Pair, PressureResult};

use super::{CaptionedFigure, style};
use crate::Run;
use crate::format::Dimension;
use crate::page::method_name;
use crate::plot::{
    Align, Axis, BLACK, Canvas, Colour, Dash, GREY, GRID, Pen, Rect, TEXT, THIN, WIDTH, draw_x_ticks, label_x_axis,
    range,
};

/// Height of a row in pixels.
const ROW: f64 = 24.0;
/// Room for the names in pixels.
const NAMES: f64 = 190.0;

/// A value with its interval.
type Estimate = (f64, Option<Pair>);

/// One quantity by every method.
struct Panel {
    axis: Axis,
    rows: Vec<Option<Estimate>>,
    reference: Estimate,
}

impl Panel {
    /// Returns a panel whose axis contains all intervals; `None` if no method has one.
    fn new(label: &str, dimension: Dimension, rows: Vec<Option<Estimate>>, reference: Estimate) -> Option<Self> {
        // Estimates without an interval do not determine the axis.
        let known: Vec<&Estimate> = rows.iter().flatten().filter(|(_, interval)| interval.is_some()).collect();
        known.first()?;
        let values = known.into_iter().chain([&reference]);
        let (low, high) = range(values.flat_map(|(value, interval)| interval.iter().flatten().chain([value])))?;
        Some(Self { axis: Axis::padded(label, dimension.unit(high.abs()), (low, high), 0.06), rows, reference })
    }

    fn place(&self, plot: Rect, value: f64) -> f64 {
        plot.left + self.axis.position(value).unwrap_or(f64::NAN) * plot.width()
    }

    fn draw(&self, canvas: &mut Canvas, plot: Rect, methods: &[(usize, &MethodEntry)]) {
        draw_x_ticks(canvas, plot, &self.axis, Some(GRID), true);
        label_x_axis(canvas, plot, &self.axis);
        let (value, interval) = self.reference;
        if let Some([left, right]) = interval.map(|ends| ends.map(|end| self.place(plot, end))) {
            canvas.fill(Rect { left, right, ..plot }, GREY, 0.45);
        }
        let x = self.place(plot, value);
        canvas.line(&[(x, plot.top), (x, plot.bottom)], Pen::new(BLACK, 1.0, Dash::Dotted));
        for (row, ((index, method), estimate)) in methods.iter().zip(&self.rows).enumerate() {
            let Some((value, interval)) = *estimate else { continue };
            let (pen, shape) = style(&method.name, *index);
            let y = plot.top + 6.0 + ROW * (row as f64 + 0.5);
            if let Some([low, high]) = interval.map(|ends| ends.map(|end| self.place(plot, end))) {
                canvas.interval((low, high), y, 4.0, Pen { dash: Dash::Solid, width: 2.0, ..pen });
            }
            match self.place(plot, value) {
                x if (plot.left..=plot.right).contains(&x) => shape.draw(canvas, (x, y), 4.2, pen.colour),
                x => draw_arrow(canvas, plot, y, x > plot.right, pen.colour),
            }
        }
        canvas.frame(plot, THIN);
    }
}

/// Draws an arrow at the frame for an estimate beyond it.
fn draw_arrow(canvas: &mut Canvas, plot: Rect, y: f64, to_the_right: bool, colour: Colour) {
    let (end, step) = if to_the_right { (plot.right - 3.0, -9.0) } else { (plot.left + 3.0, 9.0) };
    canvas.line(&[(end + 2.0 * step, y), (end + step, y)], Pen::new(colour, 2.0, Dash::Solid));
    canvas.polygon(&[(end, y), (end + step, y - 4.5), (end + step, y + 4.5)], colour, 1.0);
}

fn panels(pressure: &PressureResult, methods: &[(usize, &MethodEntry)]) -> Vec<Panel> {
    let rows = |of: &dyn Fn(&MethodEntry) -> Option<Estimate>| methods.iter().map(|(_, method)| of(method)).collect();
    let contact = rows(&|method| Some((method.contact_probability?, method.contact_probability_interval)));
    let mean = rows(&|method| Some((method.mean_pa?, method.mean_interval)));
    let reference = (pressure.contact_probability, pressure.contact_probability_interval);
    let panels = [
        Panel::new("P(contact)", Dimension::None, contact, reference),
        Panel::new("Mean pressure", Dimension::Pressure, mean, (pressure.mean_pa, pressure.mean_interval)),
    ];
    panels.into_iter().flatten().collect()
}

pub(super) fn figure(run: &Run) -> Option<CaptionedFigure> {
    let pressure = run.results.pressure.as_ref()?;
    let all = pressure.methods.iter().enumerate();
    let methods: Vec<(usize, &MethodEntry)> = all.filter(|(_, method)| method.contact_probability.is_some()).collect();
    let panels = panels(pressure, &methods);
    if panels.is_empty() {
        return None;
    }
    let height = ROW * methods.len() as f64 + 12.0;
    let width = (WIDTH - NAMES - 12.0) / panels.len() as f64;
    let title = "Contact probability and mean pressure by method";
    let caption = "Estimates with 95 % intervals; the grey bar is the reference’s. Intervals of polynomial chaos are corrected for the \
                   bias on samples that were not used in the fit: a symbol off its bar is a biased estimate. An arrow points at an \
                   estimate beyond the frame.";
    let drawn = CaptionedFigure::from_drawing("pressure_intervals", title, caption, (WIDTH, height + 62.0), |canvas| {
        for (row, (_, method)) in methods.iter().enumerate() {
            let y = 8.0 + 6.0 + ROW * (row as f64 + 0.5);
            canvas.text((NAMES - 10.0, y), &method_name(&method.name), TEXT, Align::End);
        }
        for (number, panel) in panels.iter().enumerate() {
            panel.draw(canvas, Rect::new(NAMES + number as f64 * width, 8.0, width - 22.0, height), &methods);
        }
    });
    Some(drawn.with_tables(&["pressure_methods"]))
}
