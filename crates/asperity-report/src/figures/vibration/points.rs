//! Laws of the points at which the mass sticks again, and leaves the belt.

use std::collections::BTreeMap;

use plotters::prelude::RGBColor;

use super::{Words, columns};
use crate::axis::{Axis, range};
use crate::canvas::{Dash, Pen};
use crate::chart::{self, Chart, Layout, Mark};
use crate::figures::{Plate, Stage, csv};
use crate::format::Unit;
use crate::palette::{BLACK, BLUE, ORANGE};
use crate::{Figure, ReportError, Run, Table};

const HEIGHT: f64 = 270.0;

pub(super) fn plate(run: &Run, plates: &mut Vec<Plate>) -> Result<(), ReportError> {
    let panels =
        [("reattachment_area", "Upscaling “area”"), ("reattachment_paper", "Upscaling “paper” (one window carries N)")];
    let mut charts = Vec::new();
    let mut sources = Vec::new();
    for (name, heading) in panels {
        let histogram =
            run.tables.get(name).and_then(|t| histogram(t, "Re-attachment displacement X", ("re-attachments", BLUE)));
        if let Some(chart) = histogram {
            charts.push((HEIGHT, chart.titled(heading)));
            sources.push(csv(name));
        }
    }
    if charts.is_empty() {
        return Ok(());
    }
    let title = "Re-attachment points";
    let caption =
        "Histogram of the displacement at which the mass sticks again, with the normal law of equal mean and \
                   standard deviation (the paper’s Fig. 5b)."
            .to_owned();
    let svg = chart::figure(title, &caption, Layout::Column, &charts)?;
    plates.push(Plate { name: "reattachment", stage: Stage::Vibration, title: title.into(), caption, sources, svg });
    Ok(())
}

/// The figure of a command.
pub(super) fn figure(tables: &BTreeMap<String, Table>) -> Result<Option<Figure>, ReportError> {
    let panels = [
        ("reattachment", "Re-attachment displacement X", ("re-attachments", BLUE)),
        ("release", "Displacement X at detachment", ("detachments", ORANGE)),
    ];
    let drawn = |(name, axis, bars)| Some((HEIGHT, histogram(tables.get(name)?, axis, bars)?));
    let charts: Vec<(f64, Chart)> = panels.into_iter().filter_map(drawn).collect();
    let words = Words {
        name: "reattachment",
        title: "Where the mass sticks again, and where it leaves the belt",
        description: "Histograms of the displacements at which cycles stick again and at which the mass detaches, with the normal \
                      laws of equal mean and standard deviation.",
    };
    words.figure(Layout::Column, &charts)
}

fn histogram(table: &Table, axis: &str, (bars, colour): (&'static str, RGBColor)) -> Option<Chart> {
    let [x, density] = columns(table, ["displacement", "density"])?;
    let normal = table.column("normal_density");
    let all = density.iter().chain(normal.into_iter().flatten());
    let highest = all.copied().filter(|v| v.is_finite()).fold(0.0, f64::max);
    let ends = range(x).filter(|_| highest > 0.0)?;
    let axis = Axis::padded(axis, Unit::none(), ends, 0.03);
    let mut chart = Chart::new(axis, Axis::linear("Density", Unit::none(), (0.0, 1.06 * highest)));
    chart.add(bars, Mark::Bars { x: x.to_vec(), y: density.to_vec(), colour });
    if let Some(y) = normal {
        let pen = Pen::new(BLACK, 1.8, Dash::Dashed);
        chart.add("normal law", Mark::Line { x: x.to_vec(), y: y.to_vec(), pen });
    }
    Some(chart)
}
