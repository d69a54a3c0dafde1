//! The friction coefficient over penetration, its distribution, its correlation, and its values along the track.

pub(crate) mod correlation;
mod cutoff;
pub(crate) mod distribution;
mod levels;
mod trace;
mod uncertainty;

use asperity_results::{FrictionResult, Table};

use crate::figures::CaptionedFigure;
use crate::plot::Chart;
use crate::words::distribution_name;
use crate::{ReportError, Run};

/// Draws the figures of the friction coefficient.
///
/// # Errors
/// The PNG encoder failed.
pub(crate) fn figures(run: &Run) -> Result<Vec<CaptionedFigure>, ReportError> {
    let level = run.results.friction.as_ref().and_then(FrictionResult::operating_level);
    let first = match level.and_then(|level| level.process.at_mean_load.marginal.as_ref()) {
        Some(distribution) => format!("ranked first ({})", distribution_name(distribution)),
        None => "ranked first".to_owned(),
    };
    let chart = |name: &str, draw: &dyn Fn(&Table) -> Option<Chart>| -> Vec<Chart> {
        run.tables.get(name).and_then(draw).into_iter().collect()
    };
    let drawn = [
        (
            "friction_histogram",
            "Distribution of the friction coefficient",
            "Histogram of μ over all windows of the operating point, taken at the mean load, with the distributions fitted by \
             likelihood: the one ranked first by Akaike’s criterion, the Beta distribution of the paper with its bounds fitted too, \
             and at most three others; the table has all.",
            chart("friction_histogram", &|table| distribution::histogram(table, "windows", &first)),
        ),
        (
            "friction_pit",
            "Probability integral transform of the friction coefficient",
            "Distribution function ranked first, at the values of the windows: uniform if the distribution fits. The band is for the \
             effective sample size of the correlated windows.",
            chart("friction_pit", &|table| distribution::integral_transform(table, "windows")),
        ),
        (
            "friction_qq",
            "Quantiles of the friction coefficient",
            "Quantiles of the windows over those of the distribution ranked first, at the same probabilities.",
            chart("friction_qq", &|table| distribution::quantiles(table, "windows")),
        ),
        (
            "friction_acf",
            "Autocorrelation of the friction coefficient",
            "Autocorrelation of μ along the track at the operating point, taken at the mean load. A window that slides over \
             uncorrelated friction has the triangle as its autocorrelation: only deviations from it are properties of the surface. \
             “Window and process” is the triangle convolved with the correlation that all windows share.",
            chart("friction_acf", &|table| correlation::autocorrelation(table, "windows")),
        ),
        (
            "friction_spectrum",
            "Power spectral density of the friction coefficient",
            "One-sided power spectral density of μ at the operating point, taken at the mean load: its integral over the frequency is \
             the variance. The window alone has zeros at multiples of 1/W, where the mean over a bin stays above them.",
            chart("friction_spectrum", &correlation::spectrum),
        ),
    ];
    let drawn = drawn.into_iter().filter_map(|(name, title, caption, charts)| {
        CaptionedFigure::from_charts(name, title, caption, 1, &charts, &[name])
    });
    let first = [levels::load_curve(run), cutoff::figure(run)].into_iter().flatten();
    let last = levels::figures(run).into_iter().chain(trace::figure(run)?);
    Ok(first.chain(drawn).chain(uncertainty::figure(run)).chain(last).collect())
}
