//! Density of heights with the laws that fit it.

use super::{Plate, Stage, columns, csv, which};
use crate::axis::{Axis, range};
use crate::canvas::{Dash, Pen};
use crate::chart::{Chart, Layout, Mark, figure};
use crate::fits::{HeightFit, height_fits};
use crate::format::Dimension;
use crate::palette::{BLACK, BLUE, GREEN, ORANGE, PURPLE, VERMILION};
use crate::{ReportError, Run, Table};

const NAME: &str = "height_pdf";
/// Fits drawn, the best first.
const DRAWN: usize = 3;

/// Columns of the table with their names in the legend, in the order of the legend.
fn curves(table: &Table, fits: &[HeightFit]) -> Vec<(String, String, Pen)> {
    let pens = [(VERMILION, Dash::Solid), (GREEN, Dash::Alternating), (PURPLE, Dash::Dotted)];
    let normal = Pen::new(BLACK, 1.6, Dash::Dashed);
    let ranked = fits.iter().take(DRAWN).zip(pens).map(|(fit, (colour, dash))| {
        let pen = if fit.law == "normal" { normal } else { Pen::new(colour, 1.9, dash) };
        (format!("{}_density_per_m", fit.law), format!("{}. {}", fit.rank, fit.name()), pen)
    });
    let mut curves: Vec<(String, String, Pen)> = ranked.collect();
    if curves.is_empty() {
        curves.push(("fitted_density_per_m".into(), "fitted law".into(), Pen::new(VERMILION, 1.9, Dash::Solid)));
    }
    if curves.iter().all(|(column, _, _)| column != "normal_density_per_m") {
        curves.push(("normal_density_per_m".into(), "normal law".into(), normal));
    }
    curves.push(("study_density_per_m".into(), "law of the study".into(), Pen::new(ORANGE, 2.2, Dash::Long)));
    curves.retain(|(column, _, _)| table.column(column).is_some());
    curves
}

pub(super) fn plate(run: &Run) -> Result<Option<Plate>, ReportError> {
    let Some(table) = run.tables.get(NAME) else { return Ok(None) };
    let Some([x, measured]) = columns(table, ["height_m", "density_per_m"]) else { return Ok(None) };
    let fits = run.tables.get("height_fits").map(height_fits).unwrap_or_default();
    let curves = curves(table, &fits);
    let unit = Dimension::Length.unit(range(x).map_or(0.0, |(low, high)| low.abs().max(high.abs())));
    let largest = |values: &[f64]| values.iter().copied().filter(|v| v.is_finite()).fold(0.0, f64::max);
    let of_data = largest(measured);
    // A law whose density diverges at an end of its support must not flatten the rest.
    let of_laws = curves.iter().filter_map(|(column, _, _)| table.column(column)).map(largest).fold(0.0, f64::max);
    let highest = of_data.max(of_laws.min(1.5 * of_data));
    let lowest = measured.iter().copied().filter(|v| *v > 0.0).fold(highest, f64::min).max(highest * 1e-7);
    if highest <= 0.0 {
        return Ok(None);
    }
    // Densities count per µm where they would be tiny numbers per nm.
    let per = if highest * unit.si < 0.02 { Dimension::Length.unit(1e3 * unit.si) } else { unit.clone() };
    let axis = || Axis::linear("Height", unit.clone(), range(x).unwrap_or((0.0, 1.0)));
    let mut linear = Chart::new(axis(), Axis::linear("Density", per.inverse(), (0.0, 1.06 * highest)));
    let mut logarithmic =
        Chart::new(axis(), Axis::logarithmic("Density", per.inverse(), (0.3 * lowest, 2.0 * highest)));
    linear.add("measured", Mark::Bars { x: x.to_vec(), y: measured.to_vec(), colour: BLUE });
    // Hundreds of discs would hide the laws; bars have no base on a logarithmic axis.
    let step = Pen { opacity: 0.55, ..Pen::new(BLUE, 1.2, Dash::Solid) };
    let positive: Vec<f64> = measured.iter().map(|v| if *v > 0.0 { *v } else { f64::NAN }).collect();
    if x.len() > 80 {
        logarithmic.add(None, Mark::Line { x: x.to_vec(), y: positive, pen: step });
    } else {
        logarithmic.add(None, Mark::Points { x: x.to_vec(), y: positive, pen: Pen { opacity: 0.35, ..step } });
    }
    for (column, label, pen) in &curves {
        if let Some(y) = table.column(column) {
            for chart in [&mut linear, &mut logarithmic] {
                chart.add_named(label.clone(), Mark::Line { x: x.to_vec(), y: y.to_vec(), pen: *pen });
            }
        }
    }
    let title = "Probability density of heights";
    let stated = table.column("study_density_per_m").is_some();
    let mut caption = match fits.is_empty() {
        true => "Density of the levelled heights with the fitted law and the normal law of equal mean and standard deviation"
            .to_owned(),
        false => "Density of the levelled heights with the laws that fit best by Akaike’s criterion, numbered by rank, and the \
                  normal law of equal mean and standard deviation"
            .to_owned(),
    };
    caption += match (fits.is_empty(), stated) {
        (_, true) => ", and the law that the random surfaces have",
        (false, false) => "; the random surfaces have the law of the measured heights itself",
        (true, false) => "",
    };
    caption += "; left linear, right logarithmic, where the tails show.";
    caption += &which(run);
    let svg = figure(title, &caption, Layout::Row(300.0), &[(0.0, linear), (0.0, logarithmic)])?;
    Ok(Some(Plate { name: NAME, stage: Stage::Surface, title: title.into(), caption, sources: vec![csv(NAME)], svg }))
}
