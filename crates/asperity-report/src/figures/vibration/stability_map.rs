//! The probability of sustained vibration over two parameters.

use std::collections::BTreeMap;

use asperity_results::{MapResolutionResult, MapResult};
use serde_json::Value;

use super::{columns, in_words, outlined, parted};
use crate::axis::{Axis, range};
use crate::canvas::{Canvas, Dash, Pen, Rect, draw};
use crate::chart::{Backdrop, Chart};
use crate::figures::{Plate, Stage, csv};
use crate::format::{Unit, significant};
use crate::image;
use crate::palette::{BLACK, VERMILION};
use crate::{Figure, ReportError, Run, Table};

/// Most pixels of the image along an axis.
const MOST: f64 = 1024.0;
const HEIGHT: f64 = 400.0;
/// Width of the colour bar with its labels.
const BAR: f64 = 92.0;

/// Levels with the line of each.
const LEVELS: [(f64, &str, Dash); 3] =
    [(0.05, "5 %", Dash::Dotted), (0.5, "50 %", Dash::Solid), (0.95, "95 %", Dash::Dashed)];

const TITLE: &str = "Probability of sustained vibration";
const DESCRIPTION: &str = "Colours: share of the trajectories that vibrate for at least half of the second half of their time, whatever \
                           the kind of vibration. Lines: where it is 5, 50 and 95 %, and where vibration ends without fluctuation.";

/// The map of a study.
pub(super) fn plate(run: &Run, plates: &mut Vec<Plate>) -> Result<(), ReportError> {
    let Some(map) = run.results.vibration.as_ref().and_then(|vibration| vibration.map.as_ref()) else { return Ok(()) };
    let Some(Figure { svg, .. }) = drawn(map, &run.tables)? else { return Ok(()) };
    let sources = ["map_cells", "map_contours", "map_limit"].into_iter().filter(|name| run.tables.contains_key(*name));
    plates.push(Plate {
        name: "stability_map",
        stage: Stage::Vibration,
        title: TITLE.into(),
        caption: description(&map.resolution),
        sources: sources.map(csv).collect(),
        svg,
    });
    Ok(())
}

/// What the map shows, and where its cells are too wide for the transition.
fn description(resolution: &MapResolutionResult) -> String {
    let &MapResolutionResult { x: width, y: height, unresolved_share: unresolved } = resolution;
    if unresolved <= 0.0 {
        return DESCRIPTION.into();
    }
    let along = if unresolved >= 1.0 {
        "the whole front".into()
    } else {
        format!("{} % of the front", significant(100.0 * unresolved, 2))
    };
    format!(
        "{DESCRIPTION} Along {along} the probability falls from 95 % to 5 % within one of the smallest cells ({} × {}): the width of the \
         transition is less than that and not resolved, so the lines of 5 and 95 % are left out there.",
        significant(width, 2),
        significant(height, 2)
    )
}

pub(super) fn figure(answer: &Value, tables: &BTreeMap<String, Table>) -> Result<Option<Figure>, ReportError> {
    let (Some(x), Some(y)) = (answer["x"].as_str(), answer["y"].as_str()) else { return Ok(None) };
    let number = |key: &str| answer["resolution"][key].as_f64().unwrap_or(0.0);
    let resolution =
        MapResolutionResult { x: number("x"), y: number("y"), unresolved_share: number("unresolved_share") };
    drawn(&MapResult { x: x.into(), y: y.into(), resolution }, tables)
}

fn drawn(map: &MapResult, tables: &BTreeMap<String, Table>) -> Result<Option<Figure>, ReportError> {
    let MapResult { x, y, resolution } = map;
    let Some(cells) = tables.get("map_cells").and_then(|table| Cells::of(table, x, y)) else { return Ok(None) };
    let axis = |name: &str, ends| Axis::linear(&in_words(name), Unit::none(), ends);
    let mut chart = Chart::new(axis(x, cells.x), axis(y, cells.y));
    chart.backdrop = Some(Backdrop { data_uri: cells.image()?, x: cells.x, y: cells.y });
    let lines = |name: &str, level: Option<f64>| {
        let table = tables.get(name)?;
        let [line, x, y] = columns(table, ["line", x, y])?;
        let levels = table.column("level");
        let wanted = |i: &usize| level.is_none_or(|level| levels.is_some_and(|l| (l[*i] - level).abs() < 1e-9));
        let of = |values: &[f64]| (0..line.len()).filter(wanted).map(|i| values[i]).collect::<Vec<f64>>();
        Some(parted(&of(line), &of(x), &of(y))).filter(|(x, _)| !x.is_empty())
    };
    for (level, name, dash) in LEVELS {
        if let Some(line) = lines("map_contours", Some(level)) {
            outlined(&mut chart, name, line, Pen::new(BLACK, 2.0, dash));
        }
    }
    if let Some(line) = lines("map_limit", None) {
        outlined(&mut chart, "end of vibration without fluctuation", line, Pen::new(VERMILION, 2.6, Dash::Solid));
    }
    let bar = Axis::linear(TITLE, Unit::none(), (0.0, 1.0));
    let svg = with_bar(&chart, &bar, TITLE, &description(resolution))?;
    Ok(Some(Figure { name: "stability_map".into(), svg }))
}

fn with_bar(chart: &Chart, axis: &Axis, title: &str, description: &str) -> Result<String, ReportError> {
    let legend = chart.legend_height(640.0);
    draw((640.0, legend + HEIGHT), title, description, |canvas: &mut Canvas<'_>| {
        chart.draw_legend(canvas, Rect::new(0.0, 0.0, 640.0, legend))?;
        chart.draw(canvas, Rect::new(0.0, legend, 640.0 - BAR + 10.0, HEIGHT))?;
        // As high as the chart between its margins.
        image::colour_bar(canvas, Rect::new(640.0 - BAR + 4.0, legend + 8.0, 16.0, HEIGHT - 58.0), axis)
    })
}

/// The cells of the map, which differ in size.
struct Cells<'a> {
    x: (f64, f64),
    y: (f64, f64),
    /// Lower and upper ends along x and y, and the probability, cell by cell.
    columns: [&'a [f64]; 5],
}

impl<'a> Cells<'a> {
    fn of(table: &'a Table, x: &str, y: &str) -> Option<Self> {
        let names = [format!("{x}_low"), format!("{x}_high"), format!("{y}_low"), format!("{y}_high")];
        let [a, b, c, d] = names.each_ref().map(String::as_str);
        let columns = columns(table, [a, b, c, d, "probability"])?;
        let [x_low, x_high, y_low, y_high, _] = columns;
        let (x, y) = (range(x_low.iter().chain(x_high))?, range(y_low.iter().chain(y_high))?);
        (x.1 > x.0 && y.1 > y.0).then_some(Self { x, y, columns })
    }

    /// An image with a pixel for the smallest cell, from the top.
    fn image(&self) -> Result<String, ReportError> {
        let [x_low, x_high, y_low, y_high, probability] = self.columns;
        let smallest = |low: &[f64], high: &[f64]| {
            let widths = low.iter().zip(high).map(|(low, high)| high - low).filter(|width| *width > 0.0);
            widths.fold(f64::INFINITY, f64::min)
        };
        let count = |ends: (f64, f64), width: f64| ((ends.1 - ends.0) / width).round().clamp(1.0, MOST) as usize;
        let (nx, ny) = (count(self.x, smallest(x_low, x_high)), count(self.y, smallest(y_low, y_high)));
        let place = |value: f64, ends: (f64, f64), n: usize| {
            ((value - ends.0) / (ends.1 - ends.0) * n as f64).round().clamp(0.0, n as f64) as usize
        };
        let mut indices = vec![0; nx * ny];
        for cell in 0..probability.len() {
            if ![x_low, x_high, y_low, y_high, probability].iter().all(|column| column[cell].is_finite()) {
                continue;
            }
            let (left, right) = (place(x_low[cell], self.x, nx), place(x_high[cell], self.x, nx));
            for row in place(y_low[cell], self.y, ny)..place(y_high[cell], self.y, ny) {
                let start = (ny - 1 - row) * nx;
                indices[start + left..start + right.max(left)].fill(image::shade(probability[cell]));
            }
        }
        image::indexed(nx, ny, &indices, image::scale_palette())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_transition_within_a_cell_is_not_shown_as_if_the_cell_were_its_width() {
        let at = |unresolved_share| description(&MapResolutionResult { x: 0.0125, y: 0.001, unresolved_share });
        assert_eq!(at(0.0), DESCRIPTION);
        assert!(at(1.0).contains("Along the whole front") && at(0.4).contains("Along 40 % of the front"));
        assert!(at(0.4).contains("0.013 × 0.001)") && at(0.4).contains("not resolved"), "{}", at(0.4));
    }
}
