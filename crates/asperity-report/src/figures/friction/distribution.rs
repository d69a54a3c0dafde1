//! The distribution of a friction coefficient and its goodness of fit; `data` names the data: windows or a record.

use asperity_results::Table;

use crate::figures::columns;
use crate::format::Unit;
use crate::plot::{Axis, BLACK, BLUE, CURVES, Chart, Dash, GREY, Pen, VERMILION, pen, range};
use crate::words::in_words;
/// Draws the histogram with the chosen distribution and the other fitted ones; Beta stands out.
pub(crate) fn histogram(table: &Table, data: &str, chosen: &str) -> Option<Chart> {
    let [mu, density] = columns(table, ["mu", "density"])?;
    let named = table
        .columns()
        .iter()
        .filter_map(|(name, _)| Some((name.strip_suffix("_density")?, table.defined_column(name)?)));
    let mut fits: Vec<(&str, &[f64])> = named.collect();
    // The prominent curves come first in the legend.
    fits.sort_by_key(|(name, _)| match *name {
        "fitted" => 0,
        "beta" => 1,
        "normal" => 2,
        _ => 3,
    });
    fits.truncate(CURVES - 1);
    let largest = |values: &[f64]| values.iter().copied().filter(|v| v.is_finite()).fold(0.0, f64::max);
    let tallest = largest(density);
    // A density that is infinite at an end of its support would flatten the rest.
    let top = fits.iter().map(|(_, values)| largest(values)).fold(tallest, f64::max).min(1.6 * tallest);
    let (low, high) = range(mu).filter(|_| tallest > 0.0)?;
    let margin = if mu.len() > 1 { 0.75 * (high - low) / (mu.len() - 1) as f64 } else { 0.0 };
    let x = Axis::linear("Friction coefficient μ", Unit::none(), (low - margin, high + margin));
    let mut chart = Chart::new(x, Axis::linear("Density", Unit::none(), (0.0, 1.06 * top)));
    chart.bars(data, mu, density, BLUE);
    let mut others = (2..).map(|index| Pen { width: 1.3, ..pen(index) });
    for (name, values) in fits {
        let (label, pen) = match name {
            "fitted" => (chosen.to_owned(), Pen::new(VERMILION, 2.2, Dash::Solid)),
            "beta" => (in_words(name), Pen::new(BLACK, 1.8, Dash::Dashed)),
            other => (in_words(other), others.next().unwrap_or(pen(2))),
        };
        chart.line(label, mu, values, pen);
    }
    Some(chart)
}

/// Draws the histogram of F(μ), which is flat if the distribution fits.
pub(crate) fn integral_transform(table: &Table, data: &str) -> Option<Chart> {
    let [x, density] = columns(table, ["probability", "density"])?;
    let band = columns(table, ["low", "high"]);
    let (_, top) = range(density.iter().chain(band.into_iter().flatten().flatten()))?;
    let axis = Axis::linear("F(μ) of the fitted distribution", Unit::none(), (0.0, 1.0));
    let mut chart = Chart::new(axis, Axis::linear("Density", Unit::none(), (0.0, (1.1 * top).max(1.5))));
    chart.bars(data, x, density, BLUE);
    if let Some(band) = band {
        // From end to end of the axis, beyond the centres of the bins.
        let mut x = x.to_vec();
        if let [first, .., last] = &mut x[..] {
            (*first, *last) = (0.0, 1.0);
        }
        chart.band("95 % of the bins, if it fits", &x, band, GREY);
    }
    chart.horizontal("", 1.0, Pen::new(BLACK, 1.2, Dash::Dashed));
    Some(chart)
}

/// Draws the quantiles of the data over those of the distribution.
pub(crate) fn quantiles(table: &Table, data: &str) -> Option<Chart> {
    let [fitted, measured] = columns(table, ["fitted", "measured"])?;
    let ends = range(fitted.iter().chain(measured))?;
    let axis = |name: &str| Axis::padded(name, Unit::none(), ends, 0.04);
    let x = axis("Quantile of the fitted distribution");
    // Both axes have the same scale.
    let mut chart = Chart::new(x, axis(&format!("Quantile of the {data}"))).with_height(430.0);
    let diagonal = [ends.0, ends.1];
    chart.line("equal", &diagonal, &diagonal, Pen::new(BLACK, 1.2, Dash::Dashed));
    chart.line(data, fitted, measured, Pen::new(BLUE, 2.2, Dash::Solid));
    Some(chart)
}
