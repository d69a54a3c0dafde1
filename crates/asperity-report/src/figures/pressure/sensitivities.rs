//! Sobol' indices of the variables for several quantities.

use asperity_results::{IndexEntry, Pair, SensitivityEntry};

use crate::Run;
use crate::figures::CaptionedFigure;
use crate::format::{Unit, fixed};
use crate::plot::{Axis, BLACK, BLUE, Chart, Colour, Dash, Mark, ORANGE, Pen};

const NAME: &str = "pressure_sensitivities";
/// Height of the rows of a variable, of a bar, and of title and axis together, in pixels.
const ROW: f64 = 25.0;
const BAR: f64 = 9.0;
const HEAD: f64 = 76.0;
/// Distance of the bars from the middle of their row, as a fraction of it.
const SHIFT: f64 = 0.19;
/// Quantities by row of the figure, sets of variables by column.
const QUANTITIES: [(&str, &str); 3] = [
    ("pressure_pa", "Pressure at the cell"),
    ("contact_fraction", "Contact area"),
    ("mean_pressure_pa", "Mean pressure"),
];
const SETS: [(&str, &str); 2] = [("local", "heights about the cell"), ("global", "leading modes")];
/// The two indices of each variable.
const INDICES: [(Index, &str, Colour); 2] = [
    (|index| (index.first_order, index.first_order_interval), "first order: alone", BLUE),
    (|index| (index.total, index.total_interval), "total: with all others", ORANGE),
];

/// Reads an index with its interval.
type Index = fn(&IndexEntry) -> (f64, Pair);

/// The indices of one quantity.
pub(in crate::figures) struct Panel {
    pub(in crate::figures) title: String,
    pub(in crate::figures) indices: Vec<IndexEntry>,
    /// Fraction of the variance that the expansion does not explain.
    pub(in crate::figures) error: Option<f64>,
}

pub(super) fn figure(run: &Run) -> Option<CaptionedFigure> {
    let entries = run.results.pressure.as_ref().map_or(&[][..], |pressure| &pressure.sensitivities);
    let entry = |quantity: &str, set: &str| {
        let is_wanted = |entry: &&SensitivityEntry| entry.quantity == quantity && entry.variables == set;
        entries.iter().filter(is_wanted).find(|entry| !entry.indices.is_empty())
    };
    let known = |set: &str| QUANTITIES.iter().any(|(name, _)| entry(name, set).is_some());
    let sets: Vec<_> = SETS.into_iter().filter(|(set, _)| known(set)).collect();
    let panel = |(name, label): (&str, &str), (set, variables): (&str, &str)| {
        let entry = entry(name, set)?;
        let title = format!("{label}: {variables}");
        Some(Panel { title, indices: entry.indices.clone(), error: entry.cross_validated_error })
    };
    let rows = QUANTITIES.into_iter().map(|quantity| sets.iter().map(|set| panel(quantity, *set)).collect());
    let mut caption = "Sobol’ indices with 95 % intervals: the fraction of the variance that a variable explains alone (first \
                       order), and together with all others (total), relative to the variance that a sparse chaos expansion explains. \
                       Each panel states this explained variance as a fraction of the whole, by cross-validation; the rest is due to \
                       other variables and to errors of the expansion. The pressure is continued below zero by the gap."
        .to_owned();
    if sets.iter().any(|(set, _)| *set == "local") {
        caption += " Rings: mean heights around the cell, ring n within 2ⁿ⁻¹ grid spacings; each index is the contribution \
                    beyond the rings before it.";
    }
    Some(draw_panels(NAME, "Sensitivity to the variables", &caption, rows.collect())?.with_tables(&[NAME]))
}

/// Draws rows of panels with one legend above them; rows without any panel are left out.
pub(in crate::figures) fn draw_panels(
    name: &'static str,
    title: &str,
    caption: &str,
    rows: Vec<Vec<Option<Panel>>>,
) -> Option<CaptionedFigure> {
    let columns = rows.iter().map(|row| row.iter().flatten().count()).max()?;
    let charts: Vec<Chart> = rows.iter().flatten().flatten().map(Panel::chart).collect();
    CaptionedFigure::from_charts(name, title, caption, columns, &charts, &[])
}

impl Panel {
    /// Returns the bars of the indices, with the fraction of the variance that they refer to.
    fn chart(&self) -> Chart {
        let Self { title, indices, error } = self;
        let names = indices.iter().map(|index| index.name.clone()).collect();
        let label = match error {
            Some(error) => format!("Sobol’ index; {} % explained", fixed((100.0 * (1.0 - error)).max(0.0), 0)),
            None => "Sobol’ index".to_owned(),
        };
        let axis = Axis::linear(&label, Unit::none(), (0.0, 1.0));
        let height = ROW * indices.len() as f64 + HEAD;
        let mut chart = Chart::new(axis, Axis::named(names)).with_title(title).with_height(height);
        for (row, index) in indices.iter().enumerate() {
            for ((of, name, colour), shift) in INDICES.into_iter().zip([-SHIFT, SHIFT]) {
                let (value, [low, high]) = of(index);
                let y = row as f64 + shift;
                let mut span = |name: &str, from: f64, to: f64, pen: Pen| {
                    let [from, to] = [from, to].map(|end| end.clamp(0.0, 1.0));
                    chart.add(name, Mark::Span { from, to, y, pen });
                };
                span(name, 0.0, value, Pen::new(colour, BAR, Dash::Solid));
                span("95 %", low, high, Pen::new(BLACK, 1.2, Dash::Solid));
            }
        }
        chart
    }
}
