//! Figures as JSON for the script of the page (`web/src/figure.ts`): the same charts, with values in the units of their axes.

use serde_json::{Value, json};

use crate::plot::axis::Axis;
use crate::plot::canvas::Pen;
use crate::plot::chart::mark::{Mark, Series};
use crate::plot::chart::{Backdrop, Chart, Layout, bins};
use crate::plot::polyline::corners;

/// Curves with more points are simplified.
const MANY: usize = 2000;
/// Size of a chart, in pixels, in which a simplified curve stays within `TOLERANCE`: room to zoom in.
const SIZE: f64 = 2400.0;
const TOLERANCE: f64 = 0.12;

impl Layout {
    /// Returns the figure as JSON.
    pub(crate) fn json(&self) -> Value {
        let charts = self.charts.iter().zip(self.ratios()).map(|(chart, ratio)| of_chart(chart, ratio));
        let mut figure = json!({ "columns": self.columns, "charts": charts.collect::<Vec<_>>() });
        if let Some(bar) = &self.colours {
            figure["colours"] = json!({ "axis": of_axis(&bar.axis), "image": bar.data_uri() });
        }
        figure
    }
}

fn of_chart(chart: &Chart, ratio: f64) -> Value {
    let series = chart.series.iter().map(|series| of_series(chart, series));
    let mut value = json!({
        "title": chart.title().unwrap_or_default(),
        "ratio": number(ratio),
        "x": of_axis(&chart.x),
        "y": of_axis(&chart.y),
        "series": series.collect::<Vec<_>>(),
    });
    if let Some(Backdrop { data_uri, x, y, aspect }) = &chart.backdrop {
        let ends = |axis: &Axis, (low, high): (f64, f64)| [low, high].map(|end| number(axis.shown(end)));
        value["backdrop"] = json!({ "image": data_uri, "x": ends(&chart.x, *x), "y": ends(&chart.y, *y) });
        if let Some(aspect) = aspect {
            value["backdrop"]["aspect"] = number(*aspect);
        }
    }
    value
}

fn of_axis(axis: &Axis) -> Value {
    let (low, high) = axis.ends();
    let mut value = json!({ "label": axis.label(), "low": number(axis.shown(low)), "high": number(axis.shown(high)) });
    for (key, holds) in [("log", axis.is_logarithmic()), ("downward", axis.is_downward())] {
        if holds {
            value[key] = true.into();
        }
    }
    if !axis.names().is_empty() {
        value["names"] = axis.names().into();
    }
    value
}

fn of_series(chart: &Chart, Series { name, mark }: &Series) -> Value {
    let x = |values: &[f64]| shown(&chart.x, values);
    let y = |values: &[f64]| shown(&chart.y, values);
    let (at_x, at_y) = (|value: f64| number(chart.x.shown(value)), |value: f64| number(chart.y.shown(value)));
    match mark {
        Mark::Line { x: xs, y: ys, pen } | Mark::Points { x: xs, y: ys, pen } => {
            let discs = matches!(mark, Mark::Points { .. });
            let [xs, ys] = if discs { [xs.clone(), ys.clone()] } else { fewer(chart, xs, ys) };
            json!({ "name": name, "mark": "line", "x": x(&xs), "y": y(&ys), "pen": of_pen(pen), "discs": discs })
        }
        Mark::Symbol { x, y, shape, colour } => {
            json!({ "name": name, "mark": "symbol", "x": at_x(*x), "y": at_y(*y), "shape": shape.name(), "colour": colour.to_string() })
        }
        Mark::Span { from, to, y, pen } => {
            json!({ "name": name, "mark": "span", "low": at_x(*from), "high": at_x(*to), "y": at_y(*y), "pen": of_pen(pen) })
        }
        Mark::Band { x: xs, low, high, colour } => {
            json!({ "name": name, "mark": "band", "x": x(xs), "low": y(low), "high": y(high), "colour": colour.to_string() })
        }
        Mark::Bars { x: xs, y: ys, colour } => {
            let bins: Vec<(f64, f64, f64)> = bins(xs, ys).collect();
            let edges: Vec<f64> = bins.iter().map(|bin| bin.0).chain(bins.last().map(|bin| bin.1)).collect();
            json!({ "name": name, "mark": "bars", "edges": x(&edges), "y": y(ys), "colour": colour.to_string() })
        }
        Mark::Region { from, to, colour } => {
            json!({ "name": name, "mark": "region", "low": at_x(*from), "high": at_x(*to), "colour": colour.to_string() })
        }
        Mark::Vertical { x, pen } => json!({ "name": name, "mark": "vertical", "at": at_x(*x), "pen": of_pen(pen) }),
        Mark::Horizontal { y, pen } => {
            json!({ "name": name, "mark": "horizontal", "at": at_y(*y), "pen": of_pen(pen) })
        }
        Mark::Note { x, y, text } => {
            json!({ "name": name, "mark": "note", "x": at_x(*x), "y": at_y(*y), "text": text })
        }
        Mark::Dots { x: xs, y: ys, radius, colour, opacity } => {
            let colour = colour.to_string();
            json!({ "name": name, "mark": "dots", "x": x(xs), "y": y(ys), "radius": radius, "colour": colour, "opacity": opacity })
        }
        Mark::Patch { colour } => json!({ "name": name, "mark": "patch", "colour": colour.to_string() }),
    }
}

fn of_pen(pen: &Pen) -> Value {
    json!({ "colour": pen.colour.to_string(), "width": pen.width, "dash": pen.dash.lengths(), "opacity": pen.opacity })
}

/// Returns a curve with fewer points if it has very many; undefined points stay.
fn fewer(chart: &Chart, x: &[f64], y: &[f64]) -> [Vec<f64>; 2] {
    if x.len() <= MANY {
        return [x.to_vec(), y.to_vec()];
    }
    let place = |i: usize| Some((SIZE * chart.x.position(x[i])?, SIZE * chart.y.position(y[i])?));
    let places: Vec<_> = (0..x.len().min(y.len())).map(place).collect();
    let mut kept = Vec::new();
    for run in places.chunk_by(|a, b| a.is_some() == b.is_some()) {
        let points: Vec<(f64, f64)> = run.iter().copied().flatten().collect();
        // Of undefined points one separates the pieces.
        kept.extend(match points.is_empty() {
            true => (0..run.len()).map(|i| i == 0).collect(),
            false => corners(&points, TOLERANCE),
        });
    }
    [x, y].map(|values| values.iter().zip(&kept).filter(|(_, kept)| **kept).map(|(value, _)| *value).collect())
}

fn shown(axis: &Axis, values: &[f64]) -> Vec<Value> {
    values.iter().map(|value| number(axis.shown(*value))).collect()
}

/// Returns a number with seven digits, null if it is undefined.
fn number(value: f64) -> Value {
    format!("{value:.6e}").parse::<f64>().ok().filter(|value| value.is_finite()).map_or(Value::Null, Value::from)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::format::Unit;
    use crate::plot::{BLUE, Dash};

    #[test]
    fn values_are_in_the_units_of_the_axes_and_undefined_ones_are_null() {
        let micrometre = || Unit::new("µm", 1e-6);
        let axis = Axis::logarithmic("k", Unit::none(), (1.0, 100.0));
        let mut chart = Chart::new(Axis::linear("Lag", micrometre(), (0.0, 2e-4)), axis);
        chart.line("a", &[1e-6, 2e-6], &[10.0, f64::NAN], Pen::new(BLUE, 1.8, Dash::Dotted));
        let figure = Layout::new(1, &[chart]).json();
        let chart = &figure["charts"][0];
        assert_eq!(chart["x"], json!({ "label": "Lag (µm)", "low": 0.0, "high": 200.0 }));
        assert_eq!(chart["y"]["log"], json!(true));
        let series = &chart["series"][0];
        assert_eq!((&series["x"], &series["y"]), (&json!([1.0, 2.0]), &json!([10.0, null])));
        assert_eq!(series["pen"]["dash"], json!([2.0, 3.0]));
    }

    #[test]
    fn a_long_curve_keeps_its_shape_and_its_gaps() {
        let x: Vec<f64> = (0..10_000).map(|i| f64::from(i) / 10_000.0).collect();
        let mut y: Vec<f64> = x.iter().map(|x| (20.0 * x).sin()).collect();
        y[5000..5010].fill(f64::NAN);
        let axis = |ends| Axis::linear("", Unit::none(), ends);
        let [fewer_x, fewer_y] = fewer(&Chart::new(axis((0.0, 1.0)), axis((-1.0, 1.0))), &x, &y);
        assert!(fewer_x.len() < 1000, "{} points", fewer_x.len());
        assert_eq!(fewer_y.iter().filter(|y| y.is_nan()).count(), 1);
        for (x, y) in x.iter().zip(&y).filter(|(_, y)| y.is_finite()) {
            let after = fewer_x.partition_point(|other| other < x).min(fewer_x.len() - 1);
            let [x0, x1, y0, y1] =
                [fewer_x[after.max(1) - 1], fewer_x[after], fewer_y[after.max(1) - 1], fewer_y[after]];
            if y0.is_finite() && y1.is_finite() && x1 > x0 {
                // 0.12 pixels beside a curve with a slope of 10 are 1.2 pixels above it, of 2400 for a range of 2.
                assert!((y0 + (y1 - y0) * (x - x0) / (x1 - x0) - y).abs() < 1.01e-3, "at {x}");
            }
        }
    }
}
