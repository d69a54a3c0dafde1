//! The figures of a measured friction record: its course, and how well law and correlation fit.

use std::collections::BTreeMap;

use crate::axis::{Axis, range};
use crate::canvas::{Dash, Pen};
use crate::chart::{Chart, Layout, Mark, figure};
use crate::format::{Dimension, Unit};
use crate::palette::{BLACK, BLUE, GREEN, GREY, PURPLE, VERMILION, pen};
use crate::{Figure, ReportError, Table};

/// Draws a record that a process was fitted to, from the tables `friction_record`, `friction_histogram`, `friction_pit`,
/// `friction_qq` and `friction_acf`; a pure function, as [`crate::render`].
///
/// # Errors
/// A table with columns of different lengths; never because something is absent.
pub fn record_figures(tables: &BTreeMap<String, Table>) -> Result<Vec<Figure>, ReportError> {
    crate::validate(tables.iter().map(|(name, table)| (name.as_str(), table)), [])?;
    let draw: [(&str, Drawing); 5] = [
        ("friction_record", course),
        ("friction_histogram", histogram),
        ("friction_pit", integral_transform),
        ("friction_qq", quantiles),
        ("friction_acf", correlation),
    ];
    let mut figures = Vec::new();
    for (name, draw) in draw {
        if let Some(svg) = tables.get(name).map(draw).transpose()?.flatten() {
            figures.push(Figure { name: name.into(), svg });
        }
    }
    Ok(figures)
}

type Drawing = fn(&Table) -> Result<Option<String>, ReportError>;

/// The record with its trend, and below it what is left.
fn course(table: &Table) -> Result<Option<String>, ReportError> {
    let Some(position) = table.column("position_m") else { return Ok(None) };
    let Some(ends) = range(position) else { return Ok(None) };
    let line = |column: &str, colour, width, dash| {
        let y = table.column(column)?.to_vec();
        Some(Mark::Line { x: position.to_vec(), y, pen: Pen::new(colour, width, dash) })
    };
    let curves = [
        vec![
            ("as measured", line("measured", BLUE, 0.9, Dash::Solid), "measured"),
            ("trend", line("trend", VERMILION, 2.0, Dash::Solid), "trend"),
        ],
        vec![("without its trend", line("mu", GREEN, 0.9, Dash::Solid), "mu")],
    ];
    let mut charts = Vec::new();
    for curves in curves {
        let values = curves.iter().filter_map(|(_, _, column)| table.column(column)).flatten();
        let Some(y) = range(values) else { continue };
        let x = Axis::linear("Sliding distance", Dimension::Length.unit(ends.1), ends);
        let mut chart = Chart::new(x, Axis::padded("Friction coefficient μ", Unit::none(), y, 0.06));
        for (name, mark, _) in curves {
            if let Some(mark) = mark {
                chart.add(name, mark);
            }
        }
        charts.push((200.0, chart));
    }
    let last = charts.len().saturating_sub(1);
    for (index, (height, chart)) in charts.iter_mut().enumerate() {
        chart.shows_x = index == last;
        *height += if index == last { 42.0 } else { 0.0 };
    }
    if charts.is_empty() {
        return Ok(None);
    }
    let description =
        "The record as it was measured, with the trend that was taken out, and what is left about its mean.";
    figure("A measured friction record", description, Layout::Column, &charts).map(Some)
}

/// Histogram with the law that was chosen and those that were tried.
fn histogram(table: &Table) -> Result<Option<String>, ReportError> {
    let (Some(mu), Some(density)) = (table.column("mu"), table.column("density")) else { return Ok(None) };
    let laws: Vec<(&str, &[f64])> = table
        .columns
        .iter()
        .filter_map(|(name, _)| Some((name.strip_suffix("_density")?, table.column(name)?)))
        .collect();
    let highest = density.iter().chain(laws.iter().flat_map(|(_, law)| *law)).filter(|v| v.is_finite());
    // A law that is infinite at an end of its support would flatten the rest.
    let tallest = density.iter().copied().filter(|v| v.is_finite()).fold(0.0, f64::max);
    let top = highest.copied().fold(0.0, f64::max).min(1.6 * tallest);
    let Some((low, high)) = range(mu).filter(|_| tallest > 0.0) else { return Ok(None) };
    let margin = if mu.len() > 1 { 0.75 * (high - low) / (mu.len() - 1) as f64 } else { 0.0 };
    let x = Axis::linear("Friction coefficient μ", Unit::none(), (low - margin, high + margin));
    let mut chart = Chart::new(x, Axis::linear("Density", Unit::none(), (0.0, 1.06 * top)));
    chart.add("record", Mark::Bars { x: mu.to_vec(), y: density.to_vec(), colour: BLUE });
    let pens = [(BLACK, Dash::Dashed), (GREEN, Dash::Alternating), (PURPLE, Dash::Dotted), (GREY, Dash::Long)];
    let mut others = pens.into_iter().cycle();
    for (name, values) in laws {
        let (label, pen) = match name {
            "fitted" => ("law of the process".to_owned(), Pen::new(VERMILION, 2.2, Dash::Solid)),
            other => {
                let (colour, dash) = others.next().unwrap_or((BLACK, Dash::Dashed));
                (other.replace('_', " "), Pen::new(colour, 1.5, dash))
            }
        };
        chart.add_named(label, Mark::Line { x: mu.to_vec(), y: values.to_vec(), pen });
    }
    let description =
        "Histogram of the record without its trend, with the law of the process and the others that were fitted.";
    figure("Law of the friction coefficient", description, Layout::Column, &[(330.0, chart)]).map(Some)
}

/// Histogram of F(μ), flat if the law fits.
fn integral_transform(table: &Table) -> Result<Option<String>, ReportError> {
    let (Some(x), Some(density)) = (table.column("probability"), table.column("density")) else { return Ok(None) };
    let band = table.column("low").zip(table.column("high"));
    let limits = band.into_iter().flat_map(|(low, high)| low.iter().chain(high));
    let Some((_, top)) = range(density.iter().chain(limits)) else { return Ok(None) };
    let axis = Axis::linear("F(μ) of the fitted law", Unit::none(), (0.0, 1.0));
    let mut chart = Chart::new(axis, Axis::linear("Density", Unit::none(), (0.0, (1.1 * top).max(1.5))));
    chart.add("record", Mark::Bars { x: x.to_vec(), y: density.to_vec(), colour: BLUE });
    if let Some((low, high)) = band {
        // From end to end of the axis, beyond the centres of the bins.
        let mut x = x.to_vec();
        if let [first, .., last] = &mut x[..] {
            (*first, *last) = (0.0, 1.0);
        }
        chart.add(
            "95 % of the bins, if it fits",
            Mark::Band { x, low: low.to_vec(), high: high.to_vec(), colour: GREY },
        );
    }
    chart.add(None, Mark::Horizontal { y: 1.0, pen: Pen::new(BLACK, 1.2, Dash::Dashed) });
    let description = "Probability integral transform: the values of the fitted distribution function at the record are uniform \
                       if the law fits; the band counts as many independent values as the record is worth.";
    figure("Probability integral transform", description, Layout::Column, &[(300.0, chart)]).map(Some)
}

/// Quantiles of the record over those of the law.
fn quantiles(table: &Table) -> Result<Option<String>, ReportError> {
    let (Some(fitted), Some(measured)) = (table.column("fitted"), table.column("measured")) else { return Ok(None) };
    let Some(ends) = range(fitted.iter().chain(measured)) else { return Ok(None) };
    let axis = |name| Axis::padded(name, Unit::none(), ends, 0.04);
    let mut chart = Chart::new(axis("Quantile of the fitted law"), axis("Quantile of the record"));
    let diagonal = vec![ends.0, ends.1];
    let line = Pen::new(BLACK, 1.2, Dash::Dashed);
    chart.add("equal", Mark::Line { x: diagonal.clone(), y: diagonal, pen: line });
    let curve = Pen::new(BLUE, 2.2, Dash::Solid);
    chart.add("record", Mark::Line { x: fitted.to_vec(), y: measured.to_vec(), pen: curve });
    let description = "Quantiles of the record over those of the fitted law at the same probabilities.";
    figure("Quantiles", description, Layout::Column, &[(430.0, chart)]).map(Some)
}

/// Autocorrelation with the models fitted to it.
fn correlation(table: &Table) -> Result<Option<String>, ReportError> {
    let (Some(lag), Some(acf)) = (table.column("lag_m"), table.column("acf")) else { return Ok(None) };
    let Some((first, last)) = range(lag) else { return Ok(None) };
    let Some((low, high)) = range(acf) else { return Ok(None) };
    let x = Axis::linear("Lag", Dimension::Length.unit(last), (first, last));
    let y = Axis::linear("Autocorrelation of μ", Unit::none(), ((low - 0.04).min(-0.05), high.max(1.0) + 0.04));
    let mut chart = Chart::new(x, y);
    chart.add(None, Mark::Horizontal { y: 0.0, pen: Pen::new(GREY, 1.0, Dash::Solid) });
    chart.add("record", Mark::Line { x: lag.to_vec(), y: acf.to_vec(), pen: Pen::new(BLUE, 2.2, Dash::Solid) });
    let models = table.columns.iter().filter(|(name, _)| name != "lag_m" && name != "acf");
    for (index, (name, _)) in models.enumerate() {
        if let Some(values) = table.column(name) {
            chart.add_named(
                name.replace('_', " "),
                Mark::Line { x: lag.to_vec(), y: values.to_vec(), pen: pen(index + 1) },
            );
        }
    }
    let description =
        "Autocorrelation of the record without its trend, with the models fitted to it, the closest first.";
    figure("Autocorrelation of the friction coefficient", description, Layout::Column, &[(330.0, chart)]).map(Some)
}
