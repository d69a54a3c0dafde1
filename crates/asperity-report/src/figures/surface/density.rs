//! Density of heights with the distributions that fit best.

use asperity_results::Table;

use crate::Run;
use crate::figures::surface::scan::scan_sentence;
use crate::figures::{CaptionedFigure, columns};
use crate::fits::{HeightFit, height_fits};
use crate::format::Dimension;
use crate::plot::{Axis, BLACK, BLUE, Chart, Dash, GREEN, Mark, ORANGE, PURPLE, Pen, VERMILION, range};
use crate::words::in_words;

const NAME: &str = "height_pdf";
/// Number of fits in the figure, the best first.
const DRAWN: usize = 3;

/// Returns columns of the table with their names and pens, in the order of the legend.
fn curves(table: &Table, fits: &[HeightFit]) -> Vec<(String, String, Pen)> {
    let pens = [(VERMILION, Dash::Solid), (GREEN, Dash::Alternating), (PURPLE, Dash::Dotted)];
    let normal = Pen::new(BLACK, 1.6, Dash::Dashed);
    let ranked = fits.iter().take(DRAWN).zip(pens).map(|(fit, (colour, dash))| {
        let pen = if fit.distribution == "normal" { normal } else { Pen::new(colour, 1.9, dash) };
        (format!("{}_density_per_m", fit.distribution), format!("{}. {}", fit.rank, in_words(fit.distribution)), pen)
    });
    let mut curves: Vec<(String, String, Pen)> = ranked.collect();
    if curves.is_empty() {
        let pen = Pen::new(VERMILION, 1.9, Dash::Solid);
        curves.push(("fitted_density_per_m".into(), "fitted distribution".into(), pen));
    }
    if curves.iter().all(|(column, _, _)| column != "normal_density_per_m") {
        curves.push(("normal_density_per_m".into(), "normal distribution".into(), normal));
    }
    let study = Pen::new(ORANGE, 2.2, Dash::Long);
    curves.push(("study_density_per_m".into(), "distribution of the study".into(), study));
    curves.retain(|(column, _, _)| table.defined_column(column).is_some());
    curves
}

pub(super) fn figure(run: &Run) -> Option<CaptionedFigure> {
    let table = run.tables.get(NAME)?;
    let [x, measured] = columns(table, ["height_m", "density_per_m"])?;
    let fits = run.tables.get("height_fits").map(height_fits).unwrap_or_default();
    let curves = curves(table, &fits);
    let (low, high) = range(x)?;
    let unit = Dimension::Length.unit(low.abs().max(high.abs()));
    let largest = |values: &[f64]| values.iter().copied().filter(|v| v.is_finite()).fold(0.0, f64::max);
    let of_data = largest(measured);
    // A density that diverges at an end of its support must not flatten the rest.
    let of_fits =
        curves.iter().filter_map(|(column, _, _)| table.defined_column(column)).map(largest).fold(0.0, f64::max);
    let highest = of_data.max(of_fits.min(1.5 * of_data));
    let lowest = measured.iter().copied().filter(|v| *v > 0.0).fold(highest, f64::min).max(highest * 1e-7);
    if highest <= 0.0 {
        return None;
    }
    // Densities that would be tiny per nm are given per µm.
    let per = if highest * unit.si < 0.02 { Dimension::Length.unit(1e3 * unit.si) } else { unit.clone() }.inverse();
    let axis = || Axis::linear("Height", unit.clone(), (low, high));
    let mut linear = Chart::new(axis(), Axis::linear("Density", per.clone(), (0.0, 1.06 * highest)));
    let mut logarithmic = Chart::new(axis(), Axis::logarithmic("Density", per, (0.3 * lowest, 2.0 * highest)));
    linear.bars("measured", x, measured, BLUE);
    // Bars have no base on a logarithmic axis.
    let dots = Mark::Dots { x: x.to_vec(), y: measured.to_vec(), radius: 1.8, colour: BLUE, opacity: 0.55 };
    logarithmic.add("", dots);
    for (column, label, pen) in &curves {
        if let Some(y) = table.defined_column(column) {
            linear.line(label, x, y, *pen);
            logarithmic.line(label, x, y, *pen);
        }
    }
    let stated = table.defined_column("study_density_per_m").is_some();
    let fitted = match fits.is_empty() {
        true => "the fitted distribution",
        false => "the distributions that fit best by Akaike’s criterion, numbered by rank,",
    };
    let study = match (fits.is_empty(), stated) {
        (_, true) => ", and the distribution of the random surfaces",
        (false, false) => "; the random surfaces have the distribution of the measured heights",
        (true, false) => "",
    };
    let caption = format!(
        "Density of the levelled heights with {fitted} and the normal distribution of equal mean and standard deviation{study}; left \
         linear, right logarithmic to show the tails.{}",
        scan_sentence(run)
    );
    let charts = [linear, logarithmic].map(|chart| chart.with_height(300.0));
    CaptionedFigure::from_charts(NAME, "Probability density of heights", caption, 2, &charts, &[NAME])
}
