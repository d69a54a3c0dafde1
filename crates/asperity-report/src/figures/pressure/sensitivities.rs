//! Sobol' indices: which variables matter for which quantity.

use asperity_results::{IndexEntry, Pair, SensitivityEntry};

use crate::axis::Axis;
use crate::canvas::{Align, Canvas, Dash, GRID, INK, LABEL, Pen, Rect, TEXT, draw, text_width};
use crate::figures::{Plate, Stage, csv};
use crate::format::{Unit, fixed};
use crate::palette::{BLACK, BLUE, ORANGE};
use crate::{ReportError, Run};

const NAME: &str = "pressure_sensitivities";
/// Height of the rows of a variable, of a bar, and of what stands above and below the rows of a panel, in pixels.
pub(in crate::figures) const ROW: f64 = 25.0;
const BAR: f64 = 9.0;
pub(in crate::figures) const HEAD: f64 = 46.0;
pub(in crate::figures) const FOOT: f64 = 26.0;
/// Quantities from above, sets of variables from the left.
const QUANTITIES: [(&str, &str); 3] = [
    ("pressure_pa", "Pressure at the cell"),
    ("contact_fraction", "Contact area"),
    ("mean_pressure_pa", "Mean pressure"),
];
const SETS: [(&str, &str); 2] = [("local", "heights about the cell"), ("global", "leading modes")];
/// The two indices of each variable.
const INDICES: [(Index, &str, plotters::prelude::RGBColor); 2] = [
    (|index| (index.first_order, index.first_order_interval), "first order: alone", BLUE),
    (|index| (index.total, index.total_interval), "total: with all others", ORANGE),
];

/// An index with its interval.
type Index = fn(&IndexEntry) -> (f64, Pair);

pub(super) fn plate(run: &Run, plates: &mut Vec<Plate>) -> Result<(), ReportError> {
    let entries = run.results.pressure.as_ref().map_or(&[][..], |pressure| &pressure.sensitivities);
    let found = |quantity: &str, set: &str| {
        let is_wanted = |entry: &&SensitivityEntry| entry.quantity == quantity && entry.variables == set;
        entries.iter().filter(is_wanted).find(|entry| !entry.indices.is_empty())
    };
    let sets: Vec<_> =
        SETS.into_iter().filter(|(set, _)| QUANTITIES.iter().any(|(name, _)| found(name, set).is_some())).collect();
    let rows: Vec<_> = QUANTITIES
        .into_iter()
        .filter(|(name, _)| sets.iter().any(|(set, _)| found(name, set).is_some()))
        .map(|(name, title)| {
            let most = sets.iter().filter_map(|(set, _)| found(name, set)).map(|entry| entry.indices.len()).max();
            (name, title, ROW * most.unwrap_or(0) as f64)
        })
        .collect();
    if rows.is_empty() {
        return Ok(());
    }
    let title = "Which variables matter";
    let caption = caption(sets.iter().any(|(set, _)| *set == "local"));
    let width = 640.0 / sets.len() as f64;
    let height = 24.0 + rows.iter().map(|(_, _, height)| height + HEAD + FOOT).sum::<f64>();
    let svg = draw((640.0, height + 24.0), title, &caption, |canvas| {
        legend(canvas)?;
        let mut top = 24.0;
        for (row, (name, label, room)) in rows.iter().enumerate() {
            for (column, (set, variables)) in sets.iter().enumerate() {
                let Some(entry) = found(name, set) else { continue };
                let outer = Rect::new(width * column as f64, top, width, HEAD + room + FOOT);
                panel(
                    canvas,
                    outer,
                    (&entry.indices, entry.cross_validated_error),
                    &format!("{label}: {variables}"),
                    row + 1 == rows.len(),
                )?;
            }
            top += HEAD + room + FOOT;
        }
        Ok(())
    })?;
    let sources = vec![csv(NAME)];
    plates.push(Plate { name: NAME, stage: Stage::Pressure, title: title.into(), caption, sources, svg });
    Ok(())
}

fn caption(local: bool) -> String {
    let mut words = "Sobol’ indices with 95 % intervals: the share of the variance that a variable explains alone \
                     (first order), and together with all others (total), of what a sparse chaos expansion explains. How much of \
                     the whole variance that is stands above each panel, by cross-validation; the rest is due to other variables \
                     and to errors of the expansion. The pressure is continued below zero by the gap."
        .to_owned();
    if local {
        words += " Rings: mean heights around the cell, ring n within 2ⁿ⁻¹ grid spacings, each for what it says beyond those \
                  before it.";
    }
    words
}

pub(in crate::figures) fn legend(canvas: &mut Canvas<'_>) -> Result<(), ReportError> {
    let mut x = 12.0;
    for (_, text, colour) in INDICES {
        canvas.fill(Rect::new(x, 8.0, 18.0, BAR), colour)?;
        canvas.text((x + 24.0, 12.5), text, TEXT, Align::Start)?;
        x += 24.0 + text_width(text, TEXT) + 24.0;
    }
    Ok(())
}

/// The bars of indices, and how much of the variance they are of.
pub(in crate::figures) fn panel(
    canvas: &mut Canvas<'_>,
    outer: Rect,
    (indices, unexplained): (&[IndexEntry], Option<f64>),
    title: &str,
    last: bool,
) -> Result<(), ReportError> {
    let room = indices.iter().map(|index| text_width(&index.name, TEXT)).fold(40.0, f64::max) + 20.0;
    let plot = Rect {
        left: outer.left + room.min(0.5 * outer.width()),
        top: outer.top + HEAD,
        right: outer.right - 16.0,
        bottom: outer.top + HEAD + ROW * indices.len() as f64,
    };
    canvas.text((outer.left + 12.0, outer.top + 14.0), title, LABEL, Align::Start)?;
    if let Some(error) = unexplained {
        let explained = format!("explained: {} % of the variance", fixed((100.0 * (1.0 - error)).max(0.0), 0));
        canvas.text((outer.left + 12.0, outer.top + 33.0), &explained, TEXT, Align::Start)?;
    }
    let axis = Axis::linear("Sobol’ index", Unit::none(), (0.0, 1.0));
    for tick in axis.ticks(2) {
        let x = plot.left + tick.position * plot.width();
        canvas.line(&[(x, plot.top), (x, plot.bottom)], Pen::new(GRID, 0.8, Dash::Solid))?;
        canvas.line(&[(x, plot.bottom), (x, plot.bottom + 5.0)], Pen::new(INK, 1.0, Dash::Solid))?;
        canvas.text((x, plot.bottom + 15.0), &tick.label, TEXT, Align::Middle)?;
    }
    if last {
        canvas.text((0.5 * (plot.left + plot.right), plot.bottom + 36.0), &axis.label(), LABEL, Align::Middle)?;
    }
    let place = |value: f64| plot.left + value.clamp(0.0, 1.0) * plot.width();
    for (row, index) in indices.iter().enumerate() {
        let middle = plot.top + ROW * (row as f64 + 0.5);
        canvas.text((plot.left - 8.0, middle), &index.name, TEXT, Align::End)?;
        for ((of, _, colour), y) in INDICES.into_iter().zip([middle - 0.5 * BAR, middle + 0.5 * BAR]) {
            let (value, [low, high]) = of(index);
            let end = place(value);
            if end > plot.left {
                canvas.fill(Rect::new(plot.left, y - 0.5 * BAR, end - plot.left, BAR), colour)?;
            }
            let (low, high) = (place(low), place(high));
            canvas.line(&[(low, y), (high, y)], Pen::new(BLACK, 1.2, Dash::Solid))?;
            for x in [low, high] {
                canvas.line(&[(x, y - 3.0), (x, y + 3.0)], Pen::new(BLACK, 1.2, Dash::Solid))?;
            }
        }
    }
    canvas.frame(plot, Pen::new(INK, 1.0, Dash::Solid))
}
