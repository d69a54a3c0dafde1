//! The correlation of friction over the lag and over the frequency.

use asperity_results::{FrictionSpectrum, Table};

use crate::figures::{columns, defined, positive};
use crate::format::{Dimension, Unit};
use crate::plot::{Axis, BLACK, BLUE, CURVES, Chart, Dash, GREEN, GREY, Pen, VERMILION, pen, range};
use crate::words::in_words;
/// Draws the autocorrelation with that of the window alone and with the models fitted to it; `data` names the data.
pub(crate) fn autocorrelation(table: &Table, data: &str) -> Option<Chart> {
    let [lag] = columns(table, ["lag_m"])?;
    let named = table.columns().iter().filter(|(name, _)| name != "lag_m");
    let mut curves: Vec<(&str, &[f64])> =
        named.filter_map(|(name, _)| Some((&name[..], table.defined_column(name)?))).collect();
    // Further models are in the table.
    curves.truncate(CURVES);
    let (low, high) = range(curves.iter().flat_map(|(_, values)| *values))?;
    let (first, last) = range(lag)?;
    let x = Axis::linear("Lag", Dimension::Length.unit(last), (first, last));
    let y = Axis::linear("Autocorrelation of μ", Unit::none(), ((low - 0.04).min(-0.05), high.max(1.0) + 0.04));
    let mut chart = Chart::new(x, y);
    chart.horizontal("", 0.0, Pen::new(GREY, 1.0, Dash::Solid));
    // Beside the exponential of the paper other models are thin.
    let (first, width) = if table.defined_column("fit").is_some() { (4, 1.1) } else { (1, 1.8) };
    let mut others = (first..).map(|index| Pen { width, ..pen(index) });
    for (name, values) in curves {
        let (label, pen) = match name {
            "acf" => (data.to_owned(), Pen::new(BLUE, 2.2, Dash::Solid)),
            "fit" => ("exponential".into(), Pen::new(VERMILION, 1.8, Dash::Dashed)),
            "windowed_fit" => ("window and process".into(), Pen::new(GREEN, 1.8, Dash::Alternating)),
            "window_only" => ("window alone (triangle)".into(), Pen::new(BLACK, 1.5, Dash::Dotted)),
            other => (in_words(other.trim_start_matches("fit_")), others.next().unwrap_or(pen(first))),
        };
        chart.line(label, lag, values, pen);
    }
    Some(chart)
}

/// Draws the power spectral density with its band, that of the window alone, and that of the process seen through the window.
pub(super) fn spectrum(table: &Table) -> Option<Chart> {
    let FrictionSpectrum { frequency_per_m, density_m, density_m_low, density_m_high, window_only_m, windowed_fit_m } =
        FrictionSpectrum::of(table);
    let [frequency, density] = defined([&frequency_per_m, &density_m])?;
    let band = defined([&density_m_low, &density_m_high]);
    let ends = range(positive(density).chain(band.iter().flatten().flat_map(|end| positive(end))))?;
    let (first, last) = range(positive(frequency))?;
    let x = Axis::logarithmic("Frequency", Dimension::Length.unit(1.0 / first).inverse(), (first / 1.1, last * 1.1));
    let y = Axis::logarithmic("Power spectral density of μ", Unit::new("m", 1.0), (ends.0 / 2.0, ends.1 * 2.0));
    let mut chart = Chart::new(x, y);
    if let Some(band) = band {
        chart.band("95 % band", frequency, band, BLUE);
    }
    let curves = [
        (density, "windows", Pen::new(BLUE, 2.0, Dash::Solid)),
        (&windowed_fit_m, "window and process", Pen::new(GREEN, 1.8, Dash::Alternating)),
        (&window_only_m, "window alone", Pen::new(BLACK, 1.5, Dash::Dotted)),
    ];
    for (y, name, pen) in curves.into_iter().filter(|curve| !curve.0.is_empty()) {
        chart.line(name, frequency, y, pen);
    }
    Some(chart)
}
