//! Distributions of properties of the whole contact: area, load, gap and stiffness.

use asperity_results::ScalarQuantile;

use crate::Run;
use crate::figures::{CaptionedFigure, columns};
use crate::format::{Dimension, Unit};
use crate::plot::{Axis, BLACK, BLUE, Chart, Dash, Mark, Pen, Shape, VERMILION, range};

const NAME: &str = "pressure_scalars";
const TABLE: &str = "pressure_scalar_distributions";

pub(super) fn figure(run: &Run) -> Option<CaptionedFigure> {
    let table = run.tables.get(TABLE)?;
    let [probability] = columns(table, ["probability"])?;
    let stiffness = table.defined_column("stiffness_pa_per_m").is_some();
    let properties = [
        ("contact_fraction", "Contact area / nominal"),
        ("mean_pressure_pa", "Mean pressure"),
        ("mean_gap_m", "Mean gap"),
        ("stiffness_pa_per_m", "Stiffness"),
    ];
    let properties =
        properties.into_iter().filter_map(|(name, label)| Some((name, label, range(table.defined_column(name)?)?)));
    // Two by two with the stiffness, otherwise in a row.
    let (per_row, height) = if stiffness { (2, 230.0) } else { (3, 250.0) };
    let charts = properties.enumerate().filter_map(|(number, (name, label, ends))| {
        let unit = Dimension::of_key(name).1.unit(ends.0.abs().max(ends.1.abs()));
        let y = if number % per_row == 0 { "CDF" } else { "" };
        let mut chart = Chart::new(Axis::padded(label, unit, ends, 0.05), Axis::linear(y, Unit::none(), (0.0, 1.0)));
        chart.line(
            "distribution by the default",
            table.defined_column(name)?,
            probability,
            Pen::new(BLUE, 1.8, Dash::Solid),
        );
        for &ScalarQuantile { value: x, probability: y, value_interval: [from, to] } in quantiles(run, name) {
            chart.add("10, 50 and 90 % quantiles", Mark::Symbol { x, y, shape: Shape::Ring, colour: BLACK });
            let pen = Pen::new(VERMILION, 2.6, Dash::Solid);
            chart.add("95 % interval", Mark::Span { from, to, y, pen });
        }
        Some(chart.with_height(height))
    });
    let charts: Vec<Chart> = charts.collect();
    let (title, also) = match stiffness {
        true => (
            "Distributions of contact area, load, gap and stiffness",
            "mean gap, and rise of the mean pressure per approach of the plane",
        ),
        false => ("Distributions of contact area, load and gap", "and mean gap"),
    };
    let caption = format!(
        "Distribution functions over the realisations of the surface: contact area over nominal area, load over nominal \
         area, {also}, by the default method for the pressure. Intervals that are not visible are narrower than their rings."
    );
    CaptionedFigure::from_charts(NAME, title, caption, charts.len().min(per_row), &charts, &[TABLE, NAME])
}

fn quantiles<'a>(run: &'a Run, name: &str) -> &'a [ScalarQuantile] {
    let mut scalars = run.results.pressure.iter().flat_map(|pressure| &pressure.scalars);
    scalars.find(|scalar| scalar.name == name).map_or(&[], |scalar| &scalar.quantiles)
}
