//! The figures of a measured friction record: the record itself, and the fit of distribution and correlation.

use std::collections::BTreeMap;

use asperity_results::Table;

use crate::Figure;
use crate::figures::CaptionedFigure;
use crate::figures::friction::{correlation, distribution};
use crate::format::{Dimension, Unit};
use crate::plot::{Axis, BLUE, Chart, Dash, GREEN, Pen, VERMILION, range, stacked};

/// Word for the data in the figures.
const DATA: &str = "record";

/// Draws a record with the process fitted to it, from the tables `friction_record`, `friction_histogram`, `friction_pit`,
/// `friction_qq` and `friction_acf`. It is a pure function; absent tables and columns are left out.
pub fn record_figures(tables: &BTreeMap<String, Table>) -> Vec<Figure> {
    let chart = |name: &str, draw: &dyn Fn(&Table) -> Option<Chart>| -> Vec<Chart> {
        tables.get(name).and_then(draw).into_iter().collect()
    };
    let drawn = [
        (
            "friction_record",
            "A measured friction record",
            "The record as measured with its trend, and the record about its mean without the trend.",
            tables.get("friction_record").map_or_else(Vec::new, record),
        ),
        (
            "friction_histogram",
            "Distribution of the friction coefficient",
            "Histogram of the record without its trend, with the distribution of the process and the other fitted ones.",
            chart("friction_histogram", &|table| distribution::histogram(table, DATA, "distribution of the process")),
        ),
        (
            "friction_pit",
            "Probability integral transform",
            "Probability integral transform: the fitted distribution function at the values of the record is uniform if the \
             distribution fits. The band is for the effective sample size of the record.",
            chart("friction_pit", &|table| distribution::integral_transform(table, DATA)),
        ),
        (
            "friction_qq",
            "Quantiles",
            "Quantiles of the record over those of the fitted distribution at the same probabilities.",
            chart("friction_qq", &|table| distribution::quantiles(table, DATA)),
        ),
        (
            "friction_acf",
            "Autocorrelation of the friction coefficient",
            "Autocorrelation of the record without its trend, with the correlation families that the record does not reject, the more likely first.",
            chart("friction_acf", &|table| correlation::autocorrelation(table, DATA)),
        ),
    ];
    let figures = drawn.into_iter().filter_map(|(name, title, description, charts)| {
        CaptionedFigure::from_charts(name, title, description, 1, &charts, &[])
    });
    figures.map(Figure::from).collect()
}

/// Draws the record with its trend, and below it the record without the trend.
fn record(table: &Table) -> Vec<Chart> {
    let Some((position, ends)) = table.defined_column("position_m").and_then(|x| Some((x, range(x)?))) else {
        return Vec::new();
    };
    let panels = [
        vec![("as measured", "measured", BLUE, 0.9, Dash::Solid), ("trend", "trend", VERMILION, 2.0, Dash::Dashed)],
        vec![("without its trend", "mu", GREEN, 0.9, Dash::Solid)],
    ];
    let charts = panels.into_iter().filter_map(|curves| {
        let y = range(curves.iter().filter_map(|curve| table.defined_column(curve.1)).flatten())?;
        let x = Axis::linear("Sliding distance", Dimension::Length.unit(ends.1), ends);
        let mut chart = Chart::new(x, Axis::padded("Friction coefficient μ", Unit::none(), y, 0.06));
        for (name, column, colour, width, dash) in curves {
            if let Some(y) = table.defined_column(column) {
                chart.line(name, position, y, Pen::new(colour, width, dash));
            }
        }
        Some(chart)
    });
    stacked(charts.collect(), 200.0)
}
