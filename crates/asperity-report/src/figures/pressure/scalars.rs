//! The laws of what belongs to the whole contact: area, load, gap and stiffness.

use asperity_results::ScalarQuantile;

use crate::axis::{Axis, range};
use crate::canvas::{Dash, Pen};
use crate::chart::{Chart, Layout, Mark, figure};
use crate::figures::{Plate, Stage, columns, csv};
use crate::format::{Dimension, Unit};
use crate::palette::{BLACK, BLUE, VERMILION};
use crate::symbol::Shape;
use crate::{ReportError, Run};

const NAME: &str = "pressure_scalars";
const LAWS: &str = "pressure_scalar_laws";

pub(super) fn plate(run: &Run, plates: &mut Vec<Plate>) -> Result<(), ReportError> {
    let Some(table) = run.tables.get(LAWS) else { return Ok(()) };
    let Some([probability]) = columns(table, ["probability"]) else { return Ok(()) };
    let stiffness = table.column("stiffness_pa_per_m").is_some();
    let mut charts = Vec::new();
    for (name, label) in [
        ("contact_fraction", "Contact area / nominal"),
        ("mean_pressure_pa", "Mean pressure"),
        ("mean_gap_m", "Mean gap"),
        ("stiffness_pa_per_m", "Stiffness"),
    ] {
        let Some(values) = table.column(name) else { continue };
        let Some((low, high)) = range(values) else { continue };
        let unit = match Dimension::of_key(name).1 {
            Dimension::None => Unit::none(),
            dimension => dimension.unit(high.abs().max(low.abs())),
        };
        let y = if charts.is_empty() || charts.len() == 2 && stiffness { "CDF" } else { "" };
        let mut chart =
            Chart::new(Axis::padded(label, unit, (low, high), 0.05), Axis::linear(y, Unit::none(), (0.0, 1.0)));
        let pen = Pen::new(BLUE, 1.8, Dash::Solid);
        chart.add("law by the default", Mark::Line { x: values.to_vec(), y: probability.to_vec(), pen });
        for &ScalarQuantile { value: x, probability: y, value_interval: [from, to] } in quantiles(run, name) {
            let ring = Mark::Symbol { x, y, shape: Shape::Ring, colour: BLACK };
            chart.add("10, 50 and 90 % quantiles", ring);
            let pen = Pen::new(VERMILION, 2.6, Dash::Solid);
            chart.add("95 % interval", Mark::Span { from, to, y, pen });
        }
        charts.push((1.0, chart));
    }
    if charts.is_empty() {
        return Ok(());
    }
    let (title, also, layout) = if stiffness {
        let also = ", mean gap, and rise of the mean pressure per approach of the plane";
        ("Laws of contact area, load, gap and stiffness", also, Layout::Pairs(230.0))
    } else {
        ("Laws of contact area, load and gap", ", and mean gap", Layout::Row(250.0))
    };
    let caption = format!(
        "Distribution functions over the realisations of the surface: contact area over nominal area, load over nominal \
         area{also}, by the method that is the default for the pressure. Intervals that are not seen are narrower than their \
         rings."
    );
    let svg = figure(title, &caption, layout, &charts)?;
    let sources = vec![csv(LAWS), csv("pressure_scalars")];
    plates.push(Plate { name: NAME, stage: Stage::Pressure, title: title.into(), caption, sources, svg });
    Ok(())
}

/// The quantiles of a scalar.
fn quantiles<'a>(run: &'a Run, name: &str) -> &'a [ScalarQuantile] {
    let mut scalars = run.results.pressure.iter().flat_map(|pressure| &pressure.scalars);
    scalars.find(|scalar| scalar.name == name).map_or(&[], |scalar| &scalar.quantiles)
}
