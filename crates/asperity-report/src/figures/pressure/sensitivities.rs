//! Sobol' indices of the variables for several quantities.

use asperity_results::{IndexEntry, Pair, SensitivityEntry};

use super::CaptionedFigure;
use crate::Run;
use crate::format::{Unit, fixed};
use crate::plot::{
    Align, Axis, BLACK, BLUE, Canvas, Colour, Dash, GRID, LABEL, ORANGE, Pen, Rect, TEXT, THIN, WIDTH, draw_x_ticks,
    label_x_axis, text_width,
};

const NAME: &str = "pressure_sensitivities";
/// Height of the rows of a variable, of a bar, and of the room above and below the rows of a panel, in pixels.
const ROW: f64 = 25.0;
const BAR: f64 = 9.0;
const HEAD: f64 = 46.0;
const FOOT: f64 = 26.0;
/// Height of the legend in pixels.
const LEGEND: f64 = 24.0;
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
    let room = |row: &[Option<Panel>]| row.iter().flatten().map(|panel| panel.indices.len()).max();
    let rows: Vec<(f64, Vec<Option<Panel>>)> =
        rows.into_iter().filter_map(|row| Some((HEAD + ROW * room(&row)? as f64 + FOOT, row))).collect();
    let width = WIDTH / rows.first()?.1.len() as f64;
    let height = rows.iter().map(|(height, _)| height).sum::<f64>() + 2.0 * LEGEND;
    Some(CaptionedFigure::from_drawing(name, title, caption, (WIDTH, height), |canvas| {
        let mut x = 12.0;
        for (_, text, colour) in INDICES {
            canvas.fill(Rect::new(x, 8.0, 18.0, BAR), colour, 1.0);
            canvas.text((x + 24.0, 12.5), text, TEXT, Align::Start);
            x += 24.0 + text_width(text, TEXT) + 24.0;
        }
        let mut top = LEGEND;
        for (number, (height, row)) in rows.iter().enumerate() {
            for (column, panel) in row.iter().enumerate() {
                let labelled =
                    rows.get(number + 1).is_none_or(|(_, below)| below.get(column).is_none_or(Option::is_none));
                let outer = Rect::new(width * column as f64, top, width, *height);
                panel.iter().for_each(|panel| panel.draw(canvas, outer, labelled));
            }
            top += height;
        }
    }))
}

impl Panel {
    /// Draws the bars of the indices, and the fraction of the variance that they refer to.
    fn draw(&self, canvas: &mut Canvas, outer: Rect, labelled: bool) {
        let Self { title, indices, error } = self;
        let room = indices.iter().map(|index| text_width(&index.name, TEXT)).fold(40.0, f64::max) + 20.0;
        let plot = Rect {
            left: outer.left + room.min(0.5 * outer.width()),
            top: outer.top + HEAD,
            right: outer.right - 16.0,
            bottom: outer.top + HEAD + ROW * indices.len() as f64,
        };
        canvas.text((outer.left + 12.0, outer.top + 14.0), title, LABEL, Align::Start);
        if let Some(error) = error {
            let explained = format!("explained: {} % of the variance", fixed((100.0 * (1.0 - error)).max(0.0), 0));
            canvas.text((outer.left + 12.0, outer.top + 33.0), &explained, TEXT, Align::Start);
        }
        let axis = Axis::linear("Sobol’ index", Unit::none(), (0.0, 1.0));
        draw_x_ticks(canvas, plot, &axis, Some(GRID), true);
        if labelled {
            label_x_axis(canvas, plot, &axis);
        }
        let place = |value: f64| plot.left + value.clamp(0.0, 1.0) * plot.width();
        for (row, index) in indices.iter().enumerate() {
            let middle = plot.top + ROW * (row as f64 + 0.5);
            canvas.text((plot.left - 8.0, middle), &index.name, TEXT, Align::End);
            for ((of, _, colour), y) in INDICES.into_iter().zip([middle - 0.5 * BAR, middle + 0.5 * BAR]) {
                let (value, [low, high]) = of(index);
                canvas.fill(Rect::new(plot.left, y - 0.5 * BAR, place(value) - plot.left, BAR), colour, 1.0);
                canvas.interval((place(low), place(high)), y, 3.0, Pen::new(BLACK, 1.2, Dash::Solid));
            }
        }
        canvas.frame(plot, THIN);
    }
}
