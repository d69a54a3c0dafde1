//! Distributions of the points at which the mass sticks again and at which it leaves the belt.

use asperity_results::{DisplacementHistogram, Table};

use crate::Run;
use crate::figures::vibration::curves::Tables;
use crate::figures::{CaptionedFigure, defined};
use crate::format::Unit;
use crate::plot::{Axis, BLACK, BLUE, Chart, Colour, Dash, ORANGE, Pen, range};

/// Draws the re-attachment points of a run.
pub(super) fn of_run(run: &Run) -> Option<CaptionedFigure> {
    let panels =
        [("reattachment_area", "Upscaling “area”"), ("reattachment_paper", "Upscaling “paper” (one window carries N)")];
    let chart = |(name, title): (&'static str, &str)| {
        let chart = histogram(run.tables.get(name)?, "Re-attachment displacement X", "re-attachments", BLUE)?;
        Some((name, chart.with_title(title)))
    };
    let (names, charts): (Vec<&'static str>, Vec<Chart>) = panels.into_iter().filter_map(chart).unzip();
    let caption = "Histogram of the displacement at which the mass sticks again, with the normal distribution of equal mean and \
                   standard deviation (the paper’s Fig. 5b).";
    CaptionedFigure::from_charts("reattachment", "Re-attachment points", caption, 1, &charts, &names)
}

/// Draws the points of a command.
pub(super) fn figure(tables: &Tables) -> Option<CaptionedFigure> {
    let panels = [
        ("reattachment", "Re-attachment displacement X", "re-attachments", BLUE),
        ("release", "Displacement X at detachment", "detachments", ORANGE),
    ];
    let drawn =
        panels.into_iter().filter_map(|(name, axis, bars, colour)| histogram(tables.get(name)?, axis, bars, colour));
    let charts: Vec<Chart> = drawn.collect();
    let title = "Re-attachment and detachment points";
    let caption = "Histograms of the displacements at which cycles stick again and at which the mass detaches, with the normal \
                   distributions of equal mean and standard deviation.";
    CaptionedFigure::from_charts("reattachment", title, caption, 1, &charts, &[])
}

fn histogram(table: &Table, axis: &str, bars: &str, colour: Colour) -> Option<Chart> {
    let DisplacementHistogram { displacement, density, normal_density: normal } = DisplacementHistogram::of(table);
    let [x, density] = defined([&displacement, &density])?;
    let (_, highest) = range(density.iter().chain(&*normal)).filter(|(_, top)| *top > 0.0)?;
    let axis = Axis::padded(axis, Unit::none(), range(x)?, 0.03);
    let mut chart = Chart::new(axis, Axis::linear("Density", Unit::none(), (0.0, 1.06 * highest))).with_height(270.0);
    chart.bars(bars, x, density, colour);
    if !normal.is_empty() {
        chart.line("normal distribution", x, &normal, Pen::new(BLACK, 1.8, Dash::Dashed));
    }
    Some(chart)
}
