//! Moments and load over penetration (Fig. 3 of the paper).

use asperity_results::Table;

use crate::Run;
use crate::figures::{CaptionedFigure, columns, positive};
use crate::format::{Dimension, Unit, significant};
use crate::plot::{Axis, BLUE, Chart, Colour, Dash, GREY, ORANGE, Pen, VERMILION, range, stacked};
use crate::words::conditions;

/// A band this much wider than the curves is cut off.
const WIDE: f64 = 4.0;

/// Lower and upper ends of intervals.
type Limits = [Vec<f64>; 2];

/// Values at every level from the shallowest, with their intervals if there are any.
struct Curve {
    y: Vec<f64>,
    limits: Option<Limits>,
}

impl Curve {
    fn new(table: &Table, column: &str, order: &[usize]) -> Option<Self> {
        let limits = columns(table, [&format!("{column}_low"), &format!("{column}_high")]);
        let limits = limits.map(|limits| limits.map(|end| ordered(end, order)));
        Some(Self { y: ordered(table.defined_column(column)?, order), limits })
    }

    fn values(&self) -> impl Iterator<Item = &f64> {
        self.y.iter().chain(self.limits.iter().flatten().flatten())
    }

    fn draw(&self, chart: &mut Chart, x: &[f64], (name, band): (&str, &str), pen: Pen) {
        chart.points(name, x, &self.y, pen);
        if let Some([low, high]) = &self.limits {
            chart.band(band, x, [low, high], pen.colour);
        }
    }
}

/// Returns the rows of a column in an order.
fn ordered(values: &[f64], order: &[usize]) -> Vec<f64> {
    order.iter().map(|&row| values[row]).collect()
}

/// Returns the rows with a penetration from the shallowest; levels may be listed in any order.
fn by_depth(penetration: &[f64]) -> Vec<usize> {
    let mut order: Vec<usize> = (0..penetration.len()).filter(|&row| penetration[row].is_finite()).collect();
    order.sort_by(|&a, &b| penetration[a].total_cmp(&penetration[b]));
    order
}

/// Draws the moments of the quotient F/N at every level, beside those at the mean load.
pub(super) fn figures(run: &Run) -> Vec<CaptionedFigure> {
    const NAME: &str = "friction_levels";
    const UNCERTAIN: &str = "friction_uncertainty";
    let Some(table) = run.tables.get(NAME) else { return Vec::new() };
    let conditions = run.results.friction.as_ref().map_or_else(String::new, conditions);
    let uncertain = run.tables.get(UNCERTAIN);
    let over = " Orange: interval of the moments of F/N over 95 % of the uncertain parameters of the surface, from fewer strips.";
    let drawn = [
        (
            NAME,
            "Mean and standard deviation of the friction coefficient over penetration",
            "Mean and standard deviation of μ over the windows at each penetration",
            [("Mean of μ", "mean", "at_mean_load_mean"), ("Std of μ", "std", "at_mean_load_std")],
            uncertain.map_or("", |_| over),
        ),
        (
            "friction_shape",
            "Coefficient of variation and skewness of the friction coefficient over penetration",
            "Coefficient of variation, std over mean, and skewness of μ over the windows at each penetration",
            [("CoV of μ", "coefficient_of_variation", ""), ("Skewness of μ", "skewness", "")],
            "",
        ),
    ];
    let drawn = drawn.into_iter().filter_map(|(name, title, moments, panels, over)| {
        let (charts, clipped) = charts(table, uncertain, panels);
        let cut = if clipped { " Bands that are far wider than the curves are cut off." } else { "" };
        let caption = format!(
            "{moments} (the paper’s Fig. 3). “F/N” is the quotient of friction force and load of each window, where it has a variance; \
             “at the mean load” weights each window by the load it carries; shaded: 95 % intervals, if the strips hold enough \
             windows for one. The numbers at the points are the percentile of heights above the plane; “at load” is the level at the \
             mean pressure of the machine. {conditions}{over}{cut}"
        );
        let tables: &[&str] = if over.is_empty() { &[NAME] } else { &[NAME, UNCERTAIN] };
        CaptionedFigure::from_charts(name, title, caption.trim_end(), 1, &charts, tables)
    });
    drawn.collect()
}

/// Returns penetrations and limits of a moment over the uncertain parameters of the surface.
fn parameter_band(table: &Table, column: &str) -> Option<(Vec<f64>, Limits)> {
    let [penetration, low, high] =
        columns(table, ["penetration_m", &format!("{column}_low"), &format!("{column}_high")])?;
    let known = |row: &usize| low[*row].is_finite() && high[*row].is_finite();
    let order: Vec<usize> = by_depth(penetration).into_iter().filter(known).collect();
    (order.len() > 1).then(|| (ordered(penetration, &order), [ordered(low, &order), ordered(high, &order)]))
}

/// Draws the moments of the quotient, and the moments at the mean load where they differ visibly. `uncertain` holds the moments over
/// the uncertain parameters of the surface. Also reports whether a band was cut off.
fn charts(table: &Table, uncertain: Option<&Table>, panels: [(&str, &str, &str); 2]) -> (Vec<Chart>, bool) {
    let order = by_depth(table.defined_column("penetration_m").unwrap_or_default());
    let x = ordered(table.defined_column("penetration_m").unwrap_or_default(), &order);
    let Some(x_range) = range(&x) else { return (Vec::new(), false) };
    let (mut charts, mut clipped) = (Vec::new(), false);
    for (label, column, other) in panels {
        let Some(quotient) = Curve::new(table, column, &order) else { continue };
        let Some((low, high)) = range(quotient.values()) else { continue };
        let apart = |other: &Curve| {
            let mut pairs = other.y.iter().zip(&quotient.y);
            pairs.any(|(a, b)| (a - b).abs() > 0.01 * (high - low) || (b.is_nan() && !a.is_nan()))
        };
        let other = match column {
            "coefficient_of_variation" => variation_at_mean_load(table, &order),
            _ => Curve::new(table, other, &order),
        };
        let other = other.filter(apart);
        let over = uncertain.and_then(|table| parameter_band(table, column));
        let limits = over.iter().flat_map(|(_, limits)| limits.iter().flatten());
        let values = quotient.values().chain(other.iter().flat_map(Curve::values)).chain(limits);
        let Some(all) = range(values) else { continue };
        let curves = quotient.y.iter().chain(other.iter().flat_map(|other| &other.y));
        let (low, high) = range(curves).map_or(all, |curves| near(curves, all));
        clipped |= (low, high) != all;
        // The names of the levels need room above the first curve.
        let room = if charts.is_empty() { 0.25 * (high - low) } else { 0.0 };
        let y_axis = Axis::padded(label, Unit::none(), (low, high + room), 0.08);
        let x_axis = Axis::padded("Penetration", Dimension::Length.unit(x_range.1), x_range, 0.05);
        let mut chart = Chart::new(x_axis, y_axis);
        chart.horizontal("", 0.0, Pen::new(GREY, 1.0, Dash::Solid));
        if let Some((x, [low, high])) = &over {
            chart.band("95 % of the parameters", x, [low, high], ORANGE);
        }
        if charts.is_empty() {
            // Without a quotient the name is at the value at the mean load.
            let other = other.as_ref().map_or(&quotient.y, |other| &other.y);
            let places = quotient.y.iter().zip(other).map(|(own, other)| if own.is_nan() { *other } else { *own });
            name_levels(&mut chart, table, &order, &x, &places.collect::<Vec<f64>>());
        }
        quotient.draw(&mut chart, &x, ("F/N of a window", "95 %, F/N"), Pen::new(BLUE, 1.8, Dash::Solid));
        if let Some(other) = other {
            let pen = Pen::new(VERMILION, 1.8, Dash::Dashed);
            other.draw(&mut chart, &x, ("at the mean load", "95 %, at the mean load"), pen);
        }
        charts.push(chart);
    }
    (stacked(charts, 190.0), clipped)
}

/// Returns the range of an axis whose bands may be far wider than its curves. It then extends beyond the curves by their range, or by
/// a quarter of their magnitude.
fn near((low, high): (f64, f64), all: (f64, f64)) -> (f64, f64) {
    let span = (high - low).max(0.25 * low.abs().max(high.abs()));
    if all.1 - all.0 > WIDE * span { (all.0.max(low - span), all.1.min(high + span)) } else { all }
}

/// Returns the coefficient of variation at the mean load. Its interval is that of the std: the error of the mean is negligible.
fn variation_at_mean_load(table: &Table, order: &[usize]) -> Option<Curve> {
    let mean = Curve::new(table, "at_mean_load_mean", order)?.y;
    let std = Curve::new(table, "at_mean_load_std", order)?;
    let over = |values: Vec<f64>| values.iter().zip(&mean).map(|(value, mean)| value / mean).collect();
    Some(Curve { y: over(std.y), limits: std.limits.map(|limits| limits.map(over)) })
}

fn name_levels(chart: &mut Chart, table: &Table, order: &[usize], x: &[f64], y: &[f64]) {
    let percentiles = table.defined_column("percentile").map(|values| ordered(values, order));
    for (row, (&x, &y)) in x.iter().zip(y).enumerate() {
        let percentile = percentiles.as_ref().map_or(f64::NAN, |values| values[row]);
        let text =
            if percentile.is_finite() { format!("{} %", significant(percentile, 3)) } else { "at load".to_owned() };
        chart.note(x, y, text);
    }
}

/// Draws the load over penetration.
pub(super) fn load_curve(run: &Run) -> Option<CaptionedFigure> {
    const NAME: &str = "friction_load_curve";
    let table = run.tables.get(NAME)?;
    let [penetration] = columns(table, ["penetration_m"])?;
    let order = by_depth(penetration);
    let x = ordered(penetration, &order);
    let x_range = range(&x)?;
    let panel = |label: &str, column: &str, band: Option<[&str; 2]>, dimension: Dimension, colour: Colour| {
        let y = ordered(table.defined_column(column)?, &order);
        let limits = band.and_then(|names| columns(table, names)).map(|limits| limits.map(|end| ordered(end, &order)));
        let ends = range(positive(&y).chain(limits.iter().flatten().flat_map(|end| positive(end))))?;
        let y_axis = Axis::logarithmic(label, dimension.unit(ends.1), (ends.0 / 1.3, ends.1 * 1.3));
        let x_axis = Axis::padded("Penetration", Dimension::Length.unit(x_range.1), x_range, 0.05);
        let mut chart = Chart::new(x_axis, y_axis);
        if let Some([low, high]) = &limits {
            chart.band("95 % interval", &x, [low, high], colour);
        }
        chart.points("", &x, &y, Pen::new(colour, 1.8, Dash::Solid));
        Some(chart)
    };
    let panels = [
        panel("Mean pressure", "mean_pressure_pa", Some(["low", "high"]), Dimension::Pressure, BLUE),
        panel("Contact fraction", "contact_fraction", None, Dimension::None, VERMILION),
    ];
    let caption = "Mean pressure over the nominal area, and contact area over nominal area, against the mean depth of the plane \
                   below the highest point of each strip; shaded: 95 % interval over the strips.";
    let charts = stacked(panels.into_iter().flatten().collect(), 190.0);
    CaptionedFigure::from_charts(NAME, "Load over penetration", caption, 1, &charts, &[NAME])
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_axis_follows_its_curves_where_bands_are_far_wider() {
        assert_eq!(near((1.0, 2.0), (0.0, 3.0)), (0.0, 3.0));
        assert_eq!(near((1.0, 2.0), (-50.0, 60.0)), (0.0, 3.0));
        assert_eq!(near((1.0, 2.0), (0.9, 60.0)), (0.9, 3.0));
    }

    #[test]
    fn levels_are_sorted_by_penetration() {
        let depth = [3.0, 1.0, f64::NAN, 2.0];
        assert_eq!(ordered(&depth, &by_depth(&depth)), [1.0, 2.0, 3.0]);
    }
}
