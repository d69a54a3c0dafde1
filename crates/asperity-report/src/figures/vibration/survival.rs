//! How long vibration lasts.

use std::collections::BTreeMap;

use plotters::prelude::RGBColor;

use super::{Words, columns};
use crate::axis::{Axis, range};
use crate::canvas::{Dash, Pen};
use crate::chart::{self, Chart, Layout, Mark};
use crate::figures::{Plate, Stage, csv};
use crate::format::Unit;
use crate::palette::{BLUE, VERMILION};
use crate::{Figure, ReportError, Run, Table};

const HEIGHT: f64 = 300.0;
const TITLE: &str = "How long vibration lasts";
const CAPTION: &str = "Share of the trajectories that have vibrated without a break up to the time τ, with 95 % intervals. Vibration ends \
                       when the mass then slips for three natural periods without a swing that sticks, passes the velocity of the belt or \
                       belongs to a slip cycle; trajectories without such a swing leave it at τ = 0.";

/// A table with the name, colour and line of its curve.
type Curve<'a> = (&'a Table, &'static str, RGBColor, Dash);

pub(super) fn plate(run: &Run, plates: &mut Vec<Plate>) -> Result<(), ReportError> {
    let known = [
        ("survival_area", "upscaling “area”", BLUE, Dash::Long),
        ("survival_paper", "upscaling “paper”", VERMILION, Dash::Dashed),
    ];
    let of = |(table, name, colour, dash)| Some((run.tables.get(table)?, name, colour, dash));
    let curves: Vec<Curve<'_>> = known.into_iter().filter_map(of).collect();
    let Some(chart) = drawn(&curves) else { return Ok(()) };
    let svg = chart::figure(TITLE, CAPTION, Layout::Column, &[(HEIGHT, chart)])?;
    let sources = known.iter().filter(|known| run.tables.contains_key(known.0)).map(|known| csv(known.0)).collect();
    let (title, caption) = (TITLE.to_owned(), CAPTION.to_owned());
    plates.push(Plate { name: "survival", stage: Stage::Vibration, title, caption, sources, svg });
    Ok(())
}

/// The figure of a command.
pub(super) fn figure(tables: &BTreeMap<String, Table>) -> Result<Option<Figure>, ReportError> {
    let Some(table) = tables.get("survival") else { return Ok(None) };
    let charts: Vec<(f64, Chart)> =
        drawn(&[(table, "never left vibration", BLUE, Dash::Solid)]).map(|chart| (HEIGHT, chart)).into_iter().collect();
    Words { name: "survival", title: TITLE, description: CAPTION }.figure(Layout::Column, &charts)
}

fn drawn(curves: &[Curve<'_>]) -> Option<Chart> {
    let times = curves.iter().filter_map(|curve| curve.0.column("tau")).flatten();
    let x = Axis::linear("Time τ", Unit::none(), range(times)?);
    let mut chart = Chart::new(x, Axis::linear("Share in vibration", Unit::none(), (-0.04, 1.04)));
    for (table, name, colour, dash) in curves {
        let Some([tau, share]) = columns(table, ["tau", "share"]) else { continue };
        if let Some([low, high]) = columns(table, ["share_low", "share_high"]) {
            chart.add(None, Mark::Band { x: tau.to_vec(), low: low.to_vec(), high: high.to_vec(), colour: *colour });
        }
        let pen = Pen::new(*colour, 2.0, *dash);
        chart.add(*name, Mark::Line { x: tau.to_vec(), y: share.to_vec(), pen });
    }
    Some(chart)
}
