//! The friction coefficient against penetration, its law, its correlation and its course along the track.

pub(crate) mod correlation;
mod cutoff;
pub(crate) mod law;
mod levels;
mod trace;
mod uncertainty;
mod windows;

use super::{Plate, Stage, csv};
use crate::chart::{Chart, Layout, figure};
use crate::page::{law_name, leading_level};
use crate::{ReportError, Run};

/// Height of a chart that has a figure of its own.
pub(crate) const HEIGHT: f64 = 330.0;

pub(super) fn plates(run: &Run, plates: &mut Vec<Plate>) -> Result<(), ReportError> {
    levels::load_curve(run, plates)?;
    cutoff::plates(run, plates)?;
    let lead = run.results.friction.as_ref().and_then(leading_level);
    let first = match lead.and_then(|lead| lead.at_mean_load.marginal.as_ref()) {
        Some(law) => format!("law ranked first ({})", law_name(law)),
        None => "law ranked first".to_owned(),
    };
    let alone = |chart: Option<Chart>, height: f64| chart.map(|chart| vec![(height, chart)]);
    let table = |name: &str| run.tables.get(name);
    let drawn = [
        (
            "friction_histogram",
            "Law of the friction coefficient",
            "Histogram of μ over all windows of the operating point, taken at the mean load, with the laws fitted by likelihood: that \
             ranked first by Akaike’s criterion, the Beta law of the paper with its bounds fitted too, and the others.",
            alone(table("friction_histogram").and_then(|t| law::histogram(t, "windows", &first)), HEIGHT),
        ),
        (
            "friction_pit",
            "Probability integral transform of the friction coefficient",
            "Values of the distribution function ranked first at the windows: uniform if the law fits. The band counts as many \
             independent windows as the correlated ones are worth.",
            alone(table("friction_pit").and_then(|t| law::integral_transform(t, "windows")), HEIGHT),
        ),
        (
            "friction_qq",
            "Quantiles of the friction coefficient",
            "Quantiles of the windows over those of the law ranked first, at the same probabilities.",
            alone(table("friction_qq").and_then(|t| law::quantiles(t, "windows")), law::SQUARE),
        ),
        (
            "friction_acf",
            "Autocorrelation of the friction coefficient",
            "Autocorrelation of μ along the track at the operating point, taken at the mean load. A window that slides over \
             uncorrelated friction gives the triangle by itself: only what differs from it is a property of the surface. “Window and \
             exponential” is the triangle convolved with the exponential that all windows share.",
            alone(table("friction_acf").and_then(|t| correlation::autocorrelation(t, "windows")), HEIGHT),
        ),
        (
            "friction_windows",
            "The correlation of friction through several windows",
            windows::CAPTION,
            table("friction_windows").and_then(|t| windows::lengths_and_scatter(t, lead)),
        ),
        (
            "friction_spectrum",
            "Power spectral density of the friction coefficient",
            "One-sided power spectral density of μ at the operating point, taken at the mean load: its integral over the frequency is \
             the variance. The window alone has zeros at multiples of 1/W, where the mean over a bin stays above them.",
            alone(table("friction_spectrum").and_then(correlation::spectrum), HEIGHT),
        ),
        (
            "friction_area_load",
            "Contact area and load of a window",
            "Correlation of the contact area of a window with the load of the window that lies the lag further on.",
            alone(table("friction_area_load").and_then(correlation::area_and_load), 260.0),
        ),
    ];
    for (name, title, caption, charts) in drawn {
        if let Some(charts) = charts {
            plates.push(plate(name, name, title, caption.to_owned(), &charts)?);
        }
    }
    uncertainty::plate(run, plates)?;
    levels::quotient(run, plates)?;
    trace::trace(run, plates)
}

/// A figure of charts one above the other, from a table.
fn plate(
    name: &'static str,
    table: &str,
    title: &str,
    caption: String,
    charts: &[(f64, Chart)],
) -> Result<Plate, ReportError> {
    let svg = figure(title, &caption, Layout::Column, charts)?;
    Ok(Plate { name, stage: Stage::Friction, title: title.into(), caption, sources: vec![csv(table)], svg })
}

/// The values that a logarithmic axis can show.
fn positive(values: &[f64]) -> impl Iterator<Item = &f64> {
    values.iter().filter(|value| **value > 0.0)
}
