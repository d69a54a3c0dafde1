//! The law of a friction coefficient and how well it fits; `seen` says of what: windows or a record.

use crate::Table;
use crate::axis::{Axis, range};
use crate::canvas::{Dash, Pen};
use crate::chart::{Chart, Mark};
use crate::figures::columns;
use crate::format::Unit;
use crate::page::in_words;
use crate::palette::{BLACK, BLUE, GREEN, GREY, OLIVE, ORANGE, PURPLE, SKY, VERMILION};

/// Height of a chart whose axes have one scale.
pub(crate) const SQUARE: f64 = 430.0;

/// Histogram with the law to go on with, called `chosen`, and the others that were fitted; Beta stands out.
pub(crate) fn histogram(table: &Table, seen: &'static str, chosen: &str) -> Option<Chart> {
    let [mu, density] = columns(table, ["mu", "density"])?;
    let named =
        table.columns.iter().filter_map(|(name, _)| Some((name.strip_suffix("_density")?, table.column(name)?)));
    let mut laws: Vec<(&str, &[f64])> = named.collect();
    // What stands out is named first.
    laws.sort_by_key(|(name, _)| match *name {
        "fitted" => 0,
        "beta" => 1,
        _ => 2,
    });
    let top = density.iter().chain(laws.iter().flat_map(|(_, law)| *law)).filter(|v| v.is_finite());
    // A law that is infinite at an end of its support would flatten the rest.
    let tallest = density.iter().copied().filter(|v| v.is_finite()).fold(0.0, f64::max);
    let top = top.copied().fold(0.0, f64::max).min(1.6 * tallest);
    let (low, high) = range(mu).filter(|_| tallest > 0.0)?;
    let margin = if mu.len() > 1 { 0.75 * (high - low) / (mu.len() - 1) as f64 } else { 0.0 };
    let x = Axis::linear("Friction coefficient μ", Unit::none(), (low - margin, high + margin));
    let mut chart = Chart::new(x, Axis::linear("Density", Unit::none(), (0.0, 1.06 * top)));
    chart.add_named(seen.into(), Mark::Bars { x: mu.to_vec(), y: density.to_vec(), colour: BLUE });
    let pens = [
        (GREEN, Dash::Alternating),
        (PURPLE, Dash::Dotted),
        (SKY, Dash::Solid),
        (GREY, Dash::Long),
        (OLIVE, Dash::Alternating),
        (ORANGE, Dash::Dotted),
    ];
    let mut others = pens.into_iter().cycle();
    for (name, values) in laws {
        let (label, pen) = match name {
            "fitted" => (chosen.to_owned(), Pen::new(VERMILION, 2.2, Dash::Solid)),
            "beta" => ("Beta".to_owned(), Pen::new(BLACK, 1.8, Dash::Dashed)),
            other => {
                let (colour, dash) = others.next().unwrap_or((GREEN, Dash::Solid));
                (in_words(other), Pen::new(colour, 1.3, dash))
            }
        };
        chart.add_named(label, Mark::Line { x: mu.to_vec(), y: values.to_vec(), pen });
    }
    Some(chart)
}

/// Histogram of F(μ), flat if the law fits.
pub(crate) fn integral_transform(table: &Table, seen: &'static str) -> Option<Chart> {
    let [x, density] = columns(table, ["probability", "density"])?;
    let band = columns(table, ["low", "high"]);
    let (_, top) = range(density.iter().chain(band.into_iter().flatten().flatten()))?;
    let axis = Axis::linear("F(μ) of the fitted law", Unit::none(), (0.0, 1.0));
    let mut chart = Chart::new(axis, Axis::linear("Density", Unit::none(), (0.0, (1.1 * top).max(1.5))));
    chart.add(seen, Mark::Bars { x: x.to_vec(), y: density.to_vec(), colour: BLUE });
    if let Some([low, high]) = band {
        // From end to end of the axis, beyond the centres of the bins.
        let mut x = x.to_vec();
        if let [first, .., last] = &mut x[..] {
            (*first, *last) = (0.0, 1.0);
        }
        let (low, high) = (low.to_vec(), high.to_vec());
        chart.add("95 % of the bins, if it fits", Mark::Band { x, low, high, colour: GREY });
    }
    chart.add(None, Mark::Horizontal { y: 1.0, pen: Pen::new(BLACK, 1.2, Dash::Dashed) });
    Some(chart)
}

/// Quantiles of what was seen over those of the law.
pub(crate) fn quantiles(table: &Table, seen: &'static str) -> Option<Chart> {
    let [fitted, measured] = columns(table, ["fitted", "measured"])?;
    let ends = range(fitted.iter().chain(measured))?;
    let axis = |name: &str| Axis::padded(name, Unit::none(), ends, 0.04);
    let mut chart = Chart::new(axis("Quantile of the fitted law"), axis(&format!("Quantile of the {seen}")));
    let diagonal = vec![ends.0, ends.1];
    let line = Pen::new(BLACK, 1.2, Dash::Dashed);
    chart.add("equal", Mark::Line { x: diagonal.clone(), y: diagonal, pen: line });
    let curve = Pen::new(BLUE, 2.2, Dash::Solid);
    chart.add(seen, Mark::Line { x: fitted.to_vec(), y: measured.to_vec(), pen: curve });
    Some(chart)
}
