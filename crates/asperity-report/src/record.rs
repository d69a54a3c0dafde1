//! The figures of a measured friction record: its course, and how well law and correlation fit.

use std::collections::BTreeMap;

use crate::axis::{Axis, range};
use crate::canvas::{Dash, Pen};
use crate::chart::{Chart, Layout, Mark, figure, stacked};
use crate::figures::friction::{HEIGHT, correlation, law};
use crate::format::{Dimension, Unit};
use crate::palette::{BLUE, GREEN, VERMILION};
use crate::{Figure, ReportError, Table};

/// Draws a record that a process was fitted to, from the tables `friction_record`, `friction_histogram`, `friction_pit`,
/// `friction_qq` and `friction_acf`; a pure function, as [`crate::render`].
///
/// # Errors
/// A table with columns of different lengths; never because something is absent.
pub fn record_figures(tables: &BTreeMap<String, Table>) -> Result<Vec<Figure>, ReportError> {
    crate::validate(tables.iter().map(|(name, table)| (name.as_str(), table)), [])?;
    let alone = |chart: Option<Chart>, height: f64| chart.map(|chart| vec![(height, chart)]);
    let table = |name: &str| tables.get(name);
    let drawn = [
        (
            "friction_record",
            "A measured friction record",
            "The record as it was measured, with the trend that was taken out, and what is left about its mean.",
            table("friction_record").and_then(course),
        ),
        (
            "friction_histogram",
            "Law of the friction coefficient",
            "Histogram of the record without its trend, with the law of the process and the others that were fitted.",
            alone(table("friction_histogram").and_then(|t| law::histogram(t, SEEN, "law of the process")), HEIGHT),
        ),
        (
            "friction_pit",
            "Probability integral transform",
            "Probability integral transform: the values of the fitted distribution function at the record are uniform if the law \
             fits; the band counts as many independent values as the record is worth.",
            alone(table("friction_pit").and_then(|t| law::integral_transform(t, SEEN)), HEIGHT),
        ),
        (
            "friction_qq",
            "Quantiles",
            "Quantiles of the record over those of the fitted law at the same probabilities.",
            alone(table("friction_qq").and_then(|t| law::quantiles(t, SEEN)), law::SQUARE),
        ),
        (
            "friction_acf",
            "Autocorrelation of the friction coefficient",
            "Autocorrelation of the record without its trend, with the models fitted to it, the closest first.",
            alone(table("friction_acf").and_then(|t| correlation::autocorrelation(t, SEEN)), HEIGHT),
        ),
    ];
    let mut figures = Vec::new();
    for (name, title, description, charts) in drawn {
        if let Some(charts) = charts {
            let svg = figure(title, description, Layout::Column, &charts)?;
            figures.push(Figure { name: name.into(), svg });
        }
    }
    Ok(figures)
}

/// What the figures call the values.
const SEEN: &str = "record";

/// The record with its trend, and below it what is left.
fn course(table: &Table) -> Option<Vec<(f64, Chart)>> {
    let position = table.column("position_m")?;
    let ends = range(position)?;
    let curves = [
        vec![("as measured", "measured", BLUE, 0.9), ("trend", "trend", VERMILION, 2.0)],
        vec![("without its trend", "mu", GREEN, 0.9)],
    ];
    let mut charts = Vec::new();
    for curves in curves {
        let Some(y) = range(curves.iter().filter_map(|curve| table.column(curve.1)).flatten()) else { continue };
        let x = Axis::linear("Sliding distance", Dimension::Length.unit(ends.1), ends);
        let mut chart = Chart::new(x, Axis::padded("Friction coefficient μ", Unit::none(), y, 0.06));
        for (name, column, colour, width) in curves {
            if let Some(y) = table.column(column) {
                let pen = Pen::new(colour, width, Dash::Solid);
                chart.add(name, Mark::Line { x: position.to_vec(), y: y.to_vec(), pen });
            }
        }
        charts.push(chart);
    }
    (!charts.is_empty()).then(|| stacked(charts, 200.0))
}
