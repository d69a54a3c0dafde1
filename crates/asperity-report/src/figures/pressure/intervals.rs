//! Contact probability and mean pressure with their intervals, method by method.

use asperity_results::{MethodEntry, Pair};
use plotters::prelude::RGBColor;

use super::style;
use crate::axis::{Axis, range};
use crate::canvas::{Align, Canvas, Dash, GRID, INK, LABEL, Pen, Rect, TEXT, draw};
use crate::chart::fitting_ticks;
use crate::figures::{Plate, Stage, csv};
use crate::format::{Dimension, Unit};
use crate::page::method_name;
use crate::palette::{BLACK, GREY};
use crate::{ReportError, Run};

const NAME: &str = "pressure_intervals";
/// Height of a row in pixels.
const ROW: f64 = 24.0;
/// Room for the names in pixels.
const NAMES: f64 = 190.0;

/// A value with its interval.
type Known = (f64, Option<(f64, f64)>);

/// An estimate of a method.
type Read = fn(&MethodEntry) -> Option<Known>;

pub(super) fn plate(run: &Run, plates: &mut Vec<Plate>) -> Result<(), ReportError> {
    let Some(pressure) = &run.results.pressure else { return Ok(()) };
    let known = |value, interval: Option<Pair>| -> Known { (value, interval.map(Into::into)) };
    let contact: Read =
        |method| Some((method.contact_probability?, method.contact_probability_interval.map(Into::into)));
    let mean: Read = |method| Some((method.mean_pa?, method.mean_interval.map(Into::into)));
    let panels = [
        ("P(contact)", contact, known(pressure.contact_probability, pressure.contact_probability_interval), None),
        ("Mean pressure", mean, known(pressure.mean_pa, pressure.mean_interval), Some(Dimension::Pressure)),
    ];
    let all = pressure.methods.iter().enumerate();
    let methods: Vec<(usize, &MethodEntry)> = all.filter(|(_, method)| method.contact_probability.is_some()).collect();
    let panels: Vec<_> = panels
        .into_iter()
        .filter_map(|(label, of, reference, dimension)| {
            let rows: Vec<Option<Known>> = methods.iter().map(|(_, method)| of(method)).collect();
            let ends =
                |known: &Known| known.1.map_or([known.0; 2], |(low, high)| [low.min(known.0), high.max(known.0)]);
            // Estimates without an interval do not press the others flat.
            let with_interval = rows.iter().flatten().filter(|known| known.1.is_some());
            let values: Vec<f64> = with_interval.chain([&reference]).flat_map(ends).collect();
            rows.iter().flatten().find(|known| known.1.is_some())?;
            let (low, high) = range(&values)?;
            let unit = dimension.map_or_else(Unit::none, |dimension| dimension.unit(high.abs()));
            Some((Axis::padded(label, unit, (low, high), 0.06), rows, reference))
        })
        .collect();
    if panels.is_empty() {
        return Ok(());
    }
    let height = ROW * methods.len() as f64 + 12.0;
    let width = (640.0 - NAMES - 12.0) / panels.len() as f64;
    let title = "Contact probability and mean pressure by method";
    let caption = "Estimates with 95 % intervals; the grey bar is the reference’s. Intervals of polynomial chaos are corrected for the \
                   bias seen on samples that it was not fitted to: a symbol off its bar is a biased estimate. An arrow points at an estimate beyond the frame.";
    let svg = draw((640.0, height + 62.0), title, caption, |canvas| {
        for (row, (_, method)) in methods.iter().enumerate() {
            let y = 8.0 + 6.0 + ROW * (row as f64 + 0.5);
            let name = method_name(&method.name);
            canvas.text((NAMES - 10.0, y), &name, TEXT, Align::End)?;
        }
        for (number, (axis, rows, reference)) in panels.iter().enumerate() {
            let plot = Rect::new(NAMES + number as f64 * width, 8.0, width - 22.0, height);
            frame(canvas, plot, axis)?;
            bar(canvas, plot, axis, *reference)?;
            for (row, ((index, method), known)) in methods.iter().zip(rows).enumerate() {
                let Some((value, limits)) = *known else { continue };
                let (pen, shape) = style(&method.name, *index);
                let y = plot.top + 6.0 + ROW * (row as f64 + 0.5);
                let place = |value: f64| axis.position(value).map(|share| plot.left + share * plot.width());
                if let Some((Some(low), Some(high))) = limits.map(|(low, high)| (place(low), place(high))) {
                    let solid = Pen { dash: Dash::Solid, width: 2.0, ..pen };
                    canvas.line(&[(low, y), (high, y)], solid)?;
                    for end in [low, high] {
                        canvas.line(&[(end, y - 4.0), (end, y + 4.0)], solid)?;
                    }
                }
                match axis.position(value) {
                    Some(share) if (0.0..=1.0).contains(&share) => {
                        shape.draw(canvas, (plot.left + share * plot.width(), y), 4.2, pen.colour)?;
                    }
                    Some(share) => beyond(canvas, plot, y, share > 1.0, pen.colour)?,
                    None => {}
                }
            }
            canvas.frame(plot, Pen::new(INK, 1.0, Dash::Solid))?;
        }
        Ok(())
    })?;
    let sources = vec![csv("pressure_methods")];
    plates.push(Plate {
        name: NAME,
        stage: Stage::Pressure,
        title: title.into(),
        caption: caption.into(),
        sources,
        svg,
    });
    Ok(())
}

/// An arrow at the frame.
fn beyond(
    canvas: &mut Canvas<'_>,
    plot: Rect,
    y: f64,
    to_the_right: bool,
    colour: RGBColor,
) -> Result<(), ReportError> {
    let (end, step) = if to_the_right { (plot.right - 3.0, -9.0) } else { (plot.left + 3.0, 9.0) };
    canvas.line(&[(end + 2.0 * step, y), (end + step, y)], Pen::new(colour, 2.0, Dash::Solid))?;
    canvas.polygon(&[(end, y), (end + step, y - 4.5), (end + step, y + 4.5)], colour, 1.0)
}

/// Ticks and label of a panel.
fn frame(canvas: &mut Canvas<'_>, plot: Rect, axis: &Axis) -> Result<(), ReportError> {
    for tick in fitting_ticks(axis, plot.width()) {
        let x = plot.left + tick.position * plot.width();
        canvas.line(&[(x, plot.top), (x, plot.bottom)], Pen::new(GRID, 0.8, Dash::Solid))?;
        canvas.line(&[(x, plot.bottom), (x, plot.bottom + 5.0)], Pen::new(INK, 1.0, Dash::Solid))?;
        canvas.text((x, plot.bottom + 15.0), &tick.label, TEXT, Align::Middle)?;
    }
    canvas.text((0.5 * (plot.left + plot.right), plot.bottom + 38.0), &axis.label(), LABEL, Align::Middle)
}

/// The reference with its interval, over all rows.
fn bar(canvas: &mut Canvas<'_>, plot: Rect, axis: &Axis, (value, limits): Known) -> Result<(), ReportError> {
    let place = |value: f64| axis.position(value).map(|share| plot.left + share * plot.width());
    if let Some((Some(low), Some(high))) = limits.map(|(low, high)| (place(low), place(high))) {
        let corners = [(low, plot.top), (high, plot.top), (high, plot.bottom), (low, plot.bottom)];
        canvas.polygon(&corners, GREY, 0.45)?;
    }
    match place(value) {
        Some(x) => canvas.line(&[(x, plot.top), (x, plot.bottom)], Pen::new(BLACK, 1.0, Dash::Dotted)),
        None => Ok(()),
    }
}
