//! The probability of sustained vibration over two parameters.

use asperity_results::{MapResolutionResult, MapResult, Table};

use crate::figures::vibration::curves::{Tables, axis_label, outlined, separated};
use crate::figures::{CaptionedFigure, columns, present};
use crate::format::{Unit, significant};
use crate::plot::{
    Axis, BLACK, Backdrop, Chart, ColourBar, Dash, Pen, VERMILION, indexed, range, scale_palette, shade,
};
use crate::{ReportError, Run};

/// Largest number of pixels of the image along an axis.
const MAX_ALONG: f64 = 1024.0;
const HEIGHT: f64 = 400.0;

/// Levels of the contours with their dashes.
const LEVELS: [(f64, &str, Dash); 3] =
    [(0.05, "5 %", Dash::Dotted), (0.5, "50 %", Dash::Solid), (0.95, "95 %", Dash::Dashed)];

const TITLE: &str = "Probability of sustained vibration";
const CAPTION: &str = "Colours: fraction of the trajectories that vibrate for at least half of the second half of their time, by any kind of \
                       vibration. Lines: where it is 5, 50 and 95 %, and where vibration ends without fluctuation.";

/// Draws the map of a study.
pub(super) fn of_run(run: &Run) -> Result<Option<CaptionedFigure>, ReportError> {
    let Some(map) = run.results.vibration.as_ref().and_then(|vibration| vibration.map.as_ref()) else {
        return Ok(None);
    };
    let sources = present(run, &["map_cells", "map_contours", "map_limit"]);
    Ok(drawn(map, &run.tables)?.map(|figure| figure.with_tables(&sources)))
}

/// Describes the map, and the part of it whose cells are wider than the transition.
fn caption(resolution: &MapResolutionResult) -> String {
    let &MapResolutionResult { x: width, y: height, unresolved_share: unresolved } = resolution;
    if unresolved <= 0.0 {
        return CAPTION.into();
    }
    let along = if unresolved >= 1.0 {
        "the whole front".into()
    } else {
        format!("{} % of the front", significant(100.0 * unresolved, 2))
    };
    format!(
        "{CAPTION} Along {along} the probability falls from 95 % to 5 % within one of the smallest cells ({} × {}): the width of the \
         transition is less than that and not resolved, so the lines of 5 and 95 % are left out there.",
        significant(width, 2),
        significant(height, 2)
    )
}

/// Draws a map from its tables.
pub(super) fn drawn(map: &MapResult, tables: &Tables) -> Result<Option<CaptionedFigure>, ReportError> {
    let MapResult { x, y, resolution } = map;
    let Some(cells) = tables.get("map_cells").and_then(|table| Cells::new(table, x, y)) else { return Ok(None) };
    let axis = |name: &str, ends| Axis::linear(&axis_label(name), Unit::none(), ends);
    let mut chart = Chart::new(axis(x, cells.x), axis(y, cells.y));
    chart.backdrop = Some(Backdrop { data_uri: cells.image()?, x: cells.x, y: cells.y, aspect: None });
    let contours = LEVELS.map(|(level, name, dash)| ("map_contours", Some(level), name, Pen::new(BLACK, 2.0, dash)));
    let limit =
        ("map_limit", None, "end of vibration without fluctuation", Pen::new(VERMILION, 2.6, Dash::Alternating));
    for (table, level, name, pen) in contours.into_iter().chain([limit]) {
        if let Some((x, y)) = tables.get(table).and_then(|table| lines(table, [x, y], level)) {
            outlined(&mut chart, name, &x, &y, pen);
        }
    }
    with_colour_bar("stability_map", TITLE, caption(resolution), chart, TITLE)
}

/// Draws a chart over an image of probabilities, with the bar of its colours.
///
/// # Errors
/// The PNG encoder failed.
pub(in crate::figures) fn with_colour_bar(
    name: &'static str,
    title: &str,
    caption: String,
    chart: Chart,
    quantity: &str,
) -> Result<Option<CaptionedFigure>, ReportError> {
    let bar = ColourBar::new(Axis::linear(quantity, Unit::none(), (0.0, 1.0)))?;
    let chart = chart.with_height(HEIGHT);
    Ok(CaptionedFigure::from_charts(name, title, caption, 1, &[chart], &[]).map(|figure| figure.with_colours(bar)))
}

/// Returns the lines of a table, of one level if stated; `None` without points.
pub(in crate::figures) fn lines(table: &Table, [x, y]: [&str; 2], level: Option<f64>) -> Option<(Vec<f64>, Vec<f64>)> {
    let [line, x, y] = columns(table, ["line", x, y])?;
    let levels = table.defined_column("level");
    let wanted = |i: &usize| level.is_none_or(|level| levels.is_some_and(|l| (l[*i] - level).abs() < 1e-9));
    let of = |values: &[f64]| (0..line.len()).filter(wanted).map(|i| values[i]).collect::<Vec<f64>>();
    Some(separated(&of(line), &of(x), &of(y))).filter(|(x, _)| !x.is_empty())
}

/// The cells of the map, which differ in size.
struct Cells<'a> {
    x: (f64, f64),
    y: (f64, f64),
    /// Lower and upper ends along x and y, and the probability, cell by cell.
    columns: [&'a [f64]; 5],
}

impl<'a> Cells<'a> {
    fn new(table: &'a Table, x: &str, y: &str) -> Option<Self> {
        let names = [format!("{x}_low"), format!("{x}_high"), format!("{y}_low"), format!("{y}_high")];
        let [a, b, c, d] = names.each_ref().map(String::as_str);
        let columns = columns(table, [a, b, c, d, "probability"])?;
        let [x_low, x_high, y_low, y_high, _] = columns;
        let (x, y) = (range(x_low.iter().chain(x_high))?, range(y_low.iter().chain(y_high))?);
        (x.1 > x.0 && y.1 > y.0).then_some(Self { x, y, columns })
    }

    /// Encodes an image with one pixel for the smallest cell, from the top.
    fn image(&self) -> Result<String, ReportError> {
        let [x_low, x_high, y_low, y_high, probability] = self.columns;
        let smallest = |low: &[f64], high: &[f64]| {
            let widths = low.iter().zip(high).map(|(low, high)| high - low).filter(|width| *width > 0.0);
            widths.fold(f64::INFINITY, f64::min)
        };
        let count = |ends: (f64, f64), width: f64| ((ends.1 - ends.0) / width).round().clamp(1.0, MAX_ALONG) as usize;
        let (nx, ny) = (count(self.x, smallest(x_low, x_high)), count(self.y, smallest(y_low, y_high)));
        let place = |value: f64, ends: (f64, f64), n: usize| {
            ((value - ends.0) / (ends.1 - ends.0) * n as f64).round().clamp(0.0, n as f64) as usize
        };
        let mut indices = vec![0; nx * ny];
        for cell in 0..probability.len() {
            if !self.columns.iter().all(|column| column[cell].is_finite()) {
                continue;
            }
            let (left, right) = (place(x_low[cell], self.x, nx), place(x_high[cell], self.x, nx));
            for row in place(y_low[cell], self.y, ny)..place(y_high[cell], self.y, ny) {
                let start = (ny - 1 - row) * nx;
                indices[start + left..start + right.max(left)].fill(shade(probability[cell]));
            }
        }
        indexed(nx, ny, &indices, scale_palette())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_caption_states_transitions_that_are_narrower_than_a_cell() {
        let at = |unresolved_share| caption(&MapResolutionResult { x: 0.0125, y: 0.001, unresolved_share });
        assert_eq!(at(0.0), CAPTION);
        assert!(at(1.0).contains("Along the whole front") && at(0.4).contains("Along 40 % of the front"));
        assert!(at(0.4).contains("0.013 × 0.001)") && at(0.4).contains("not resolved"), "{}", at(0.4));
    }
}
