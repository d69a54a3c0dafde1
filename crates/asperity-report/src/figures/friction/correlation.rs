//! The correlation of friction: over the lag, over the frequency, and of contact area with load.

use super::positive;
use crate::Table;
use crate::axis::{Axis, range};
use crate::canvas::{Dash, Pen};
use crate::chart::{Chart, Mark};
use crate::figures::columns;
use crate::format::{Dimension, Unit};
use crate::page::in_words;
use crate::palette::{BLACK, BLUE, GREEN, GREY, VERMILION, pen};

/// Autocorrelation with the window alone and with the models fitted to it; `seen` is what it is of.
pub(crate) fn autocorrelation(table: &Table, seen: &'static str) -> Option<Chart> {
    let [lag] = columns(table, ["lag_m"])?;
    let curves: Vec<(&str, &[f64])> = table
        .columns
        .iter()
        .filter(|(name, _)| name != "lag_m")
        .filter_map(|(n, _)| Some((&n[..], table.column(n)?)))
        .collect();
    let (low, high) = range(curves.iter().flat_map(|(_, values)| *values))?;
    let (first, last) = range(lag)?;
    let x = Axis::linear("Lag", Dimension::Length.unit(last), (first, last));
    let y = Axis::linear("Autocorrelation of μ", Unit::none(), ((low - 0.04).min(-0.05), high.max(1.0) + 0.04));
    let mut chart = Chart::new(x, y);
    chart.add(None, Mark::Horizontal { y: 0.0, pen: Pen::new(GREY, 1.0, Dash::Solid) });
    // Beside the exponential of the paper other models are thin.
    let (first, width) = if table.column("fit").is_some() { (3, 1.1) } else { (1, 1.8) };
    let mut others = (first..).map(|index| Pen { width, ..pen(index) });
    for (name, values) in curves {
        let (label, pen) = match name {
            "acf" => (seen.to_owned(), Pen::new(BLUE, 2.2, Dash::Solid)),
            "fit" => ("exponential".into(), Pen::new(VERMILION, 1.8, Dash::Dashed)),
            "windowed_fit" => ("window and exponential".into(), Pen::new(GREEN, 1.8, Dash::Alternating)),
            "window_only" => ("window alone (triangle)".into(), Pen::new(BLACK, 1.5, Dash::Dotted)),
            other => (in_words(other.trim_start_matches("fit_")), others.next().unwrap_or(pen(first))),
        };
        chart.add_named(label, Mark::Line { x: lag.to_vec(), y: values.to_vec(), pen });
    }
    Some(chart)
}

/// Power spectral density with its band and that of the window, alone and with the process under it.
pub(super) fn spectrum(table: &Table) -> Option<Chart> {
    let [frequency, density] = columns(table, ["frequency_per_m", "density_m"])?;
    let band = columns(table, ["density_m_low", "density_m_high"]);
    let ends = range(positive(density).chain(band.iter().flatten().flat_map(|end| positive(end))))?;
    let (first, last) = range(positive(frequency))?;
    let x = Axis::logarithmic("Frequency", Dimension::Length.unit(1.0 / first).inverse(), (first / 1.1, last * 1.1));
    let y = Axis::logarithmic("Power spectral density of μ", Unit::new("m", 1.0), (ends.0 / 2.0, ends.1 * 2.0));
    let mut chart = Chart::new(x, y);
    if let Some([low, high]) = band {
        let (x, low, high) = (frequency.to_vec(), low.to_vec(), high.to_vec());
        chart.add("95 % band", Mark::Band { x, low, high, colour: BLUE });
    }
    let curves = [
        ("density_m", "windows", Pen::new(BLUE, 2.0, Dash::Solid)),
        ("windowed_fit_m", "window and exponential", Pen::new(GREEN, 1.8, Dash::Alternating)),
        ("window_only_m", "window alone", Pen::new(BLACK, 1.5, Dash::Dotted)),
    ];
    for (column, name, pen) in curves {
        if let Some(y) = table.column(column) {
            chart.add(name, Mark::Line { x: frequency.to_vec(), y: y.to_vec(), pen });
        }
    }
    Some(chart)
}

/// Correlation of contact area and load over the lag between them.
pub(super) fn area_and_load(table: &Table) -> Option<Chart> {
    let [lag, correlation] = columns(table, ["lag_m", "correlation"])?;
    let (ends, (low, high)) = (range(lag)?, range(correlation)?);
    let x = Axis::linear("Lag of the load", Dimension::Length.unit(ends.1), ends);
    let y = Axis::linear("Correlation", Unit::none(), (low.min(0.0) - 0.04, high.max(1.0) + 0.04));
    let mut chart = Chart::new(x, y);
    let thin = Pen::new(GREY, 1.0, Dash::Solid);
    chart.add(None, Mark::Horizontal { y: 0.0, pen: thin });
    chart.add(None, Mark::Vertical { x: 0.0, pen: thin });
    let pen = Pen::new(BLUE, 2.0, Dash::Solid);
    chart.add(None, Mark::Line { x: lag.to_vec(), y: correlation.to_vec(), pen });
    Some(chart)
}
