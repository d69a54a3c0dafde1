//! Moments and load against penetration (the paper's Fig. 3).

use plotters::prelude::RGBColor;

use super::{plate, positive};
use crate::axis::{Axis, range};
use crate::canvas::{Dash, Pen};
use crate::chart::{Chart, Mark, stacked};
use crate::figures::{Plate, Stage, columns};
use crate::format::{Dimension, Unit, significant};
use crate::page::conditions;
use crate::palette::{BLUE, GREY, ORANGE, VERMILION};
use crate::{ReportError, Run, Table};

const CUT_OFF: &str = " Bands that are far wider than the curves are cut off.";
/// A band this much wider than the curves is cut off.
const WIDE: f64 = 4.0;

/// Values at every level from the shallowest, with their intervals where they have some.
struct Course {
    y: Vec<f64>,
    limits: Option<(Vec<f64>, Vec<f64>)>,
}

impl Course {
    fn of(table: &Table, column: &str, order: &[usize]) -> Option<Self> {
        let ends = [format!("{column}_low"), format!("{column}_high")];
        let limits = columns(table, ends.each_ref().map(String::as_str));
        let limits = limits.map(|[low, high]| (ordered(low, order), ordered(high, order)));
        Some(Self { y: ordered(table.column(column)?, order), limits })
    }

    fn values(&self) -> impl Iterator<Item = &f64> {
        let limits = self.limits.iter().flat_map(|(low, high)| low.iter().chain(high));
        self.y.iter().chain(limits)
    }

    /// Limits cut off at the ends of an axis.
    fn within(mut self, (bottom, top): (f64, f64)) -> Self {
        if let Some((low, high)) = &mut self.limits {
            low.iter_mut().chain(high).for_each(|end| *end = end.clamp(bottom, top));
        }
        self
    }

    fn draw(self, chart: &mut Chart, x: &[f64], (name, band): (&'static str, &'static str), pen: Pen) {
        chart.add(name, Mark::Points { x: x.to_vec(), y: self.y, pen });
        if let Some((low, high)) = self.limits {
            chart.add(band, Mark::Band { x: x.to_vec(), low, high, colour: pen.colour });
        }
    }
}

/// The rows of a column in the order given.
fn ordered(values: &[f64], order: &[usize]) -> Vec<f64> {
    order.iter().map(|&row| values[row]).collect()
}

/// Rows with a penetration, from the shallowest: levels may be listed in any order.
fn by_depth(penetration: &[f64]) -> Vec<usize> {
    let mut order: Vec<usize> = (0..penetration.len()).filter(|&row| penetration[row].is_finite()).collect();
    order.sort_by(|&a, &b| penetration[a].total_cmp(&penetration[b]));
    order
}

/// The moments of the quotient F/N at every level, beside those at the mean load.
pub(super) fn quotient(run: &Run, plates: &mut Vec<Plate>) -> Result<(), ReportError> {
    let Some(table) = run.tables.get("friction_levels") else { return Ok(()) };
    let both = "“F/N” is the quotient of friction force and load of each window, where it has a variance; “at the mean load” is \
                friction where a window counts by the load it carries; shaded: 95 % intervals, where the strips hold enough windows \
                for one.";
    let labels = "The numbers at the points are the percentile of heights above the plane; “at load” is the level at the mean \
                  pressure of the machine.";
    let conditions = run.results.friction.as_ref().map_or_else(String::new, conditions);
    let uncertain = run.tables.get("friction_uncertainty");
    let mean = [("Mean of μ", "mean", "at_mean_load"), ("Std of μ", "std", "std_at_mean_load")];
    let shape = [("CoV of μ", "coefficient_of_variation", ""), ("Skewness of μ", "skewness", "")];
    let over = match uncertain {
        Some(_) => {
            " Orange: where the moments of F/N lie for 95 % of the uncertain parameters of the surface, by their own, fewer strips."
        }
        None => "",
    };
    for (name, title, what, panels, over) in [
        (
            "friction_levels",
            "Mean and scatter of the friction coefficient against penetration",
            "Mean and standard deviation of μ over the windows at each penetration",
            mean,
            over,
        ),
        (
            "friction_shape",
            "Relative scatter and skewness of the friction coefficient against penetration",
            "Coefficient of variation, std over mean, and skewness of μ over the windows at each penetration",
            shape,
            "",
        ),
    ] {
        let (charts, clipped) = moments(table, uncertain, panels);
        if charts.is_empty() {
            continue;
        }
        let cut = if clipped { CUT_OFF } else { "" };
        let caption = format!("{what} (the paper’s Fig. 3). {both} {labels} {conditions}{over}{cut}");
        let plate = plate(name, "friction_levels", title, caption.trim_end().to_owned(), &charts)?;
        plates.push(Plate { stage: Stage::Quotient, ..plate });
    }
    Ok(())
}

/// Load against penetration.
pub(super) fn load_curve(run: &Run, plates: &mut Vec<Plate>) -> Result<(), ReportError> {
    const NAME: &str = "friction_load_curve";
    let caption = "Mean pressure over the nominal area, and contact area over nominal area, against the mean depth of the plane \
                   below the highest point of each strip; shaded: 95 % interval over the strips.";
    let charts = run.tables.get(NAME).map_or_else(Vec::new, load_charts);
    if !charts.is_empty() {
        plates.push(plate(NAME, NAME, "Load against penetration", caption.into(), &charts)?);
    }
    Ok(())
}

/// Penetrations and limits of a moment over the uncertain parameters of the surface.
fn parameter_band(table: &Table, column: &str) -> Option<(Vec<f64>, Vec<f64>, Vec<f64>)> {
    let [penetration, low, high] =
        columns(table, ["penetration_m", &format!("{column}_low"), &format!("{column}_high")])?;
    let known = |row: &usize| low[*row].is_finite() && high[*row].is_finite();
    let order: Vec<usize> = by_depth(penetration).into_iter().filter(known).collect();
    (order.len() > 1).then(|| (ordered(penetration, &order), ordered(low, &order), ordered(high, &order)))
}

/// The moments of the quotient, and those at the mean load where they differ visibly; `uncertain` are the moments over the
/// uncertain parameters of the surface.
fn moments(
    table: &Table,
    uncertain: Option<&Table>,
    panels: [(&'static str, &'static str, &'static str); 2],
) -> (Vec<(f64, Chart)>, bool) {
    let Some([penetration]) = columns(table, ["penetration_m"]) else { return (Vec::new(), false) };
    let order = by_depth(penetration);
    let x = ordered(penetration, &order);
    let Some(x_range) = range(&x) else { return (Vec::new(), false) };
    let (mut charts, mut clipped) = (Vec::new(), false);
    for (label, column, other) in panels {
        let Some(quotient) = Course::of(table, column, &order) else { continue };
        let Some((low, high)) = range(quotient.values()) else { continue };
        let apart = |other: &Course| {
            let pairs = other.y.iter().zip(&quotient.y);
            pairs.into_iter().any(|(a, b)| (a - b).abs() > 0.01 * (high - low) || (b.is_nan() && !a.is_nan()))
        };
        let other = match column {
            "coefficient_of_variation" => at_mean_load(table, &order),
            _ => Course::of(table, other, &order),
        };
        let other = other.filter(apart);
        let over = uncertain.and_then(|table| parameter_band(table, column));
        let limits = over.iter().flat_map(|(_, low, high)| low.iter().chain(high));
        let values = quotient.values().chain(other.iter().flat_map(Course::values)).chain(limits);
        let Some(all) = range(values) else { continue };
        let curves = quotient.y.iter().chain(other.iter().flat_map(|other| &other.y));
        let (low, high) = range(curves).map_or(all, |curves| near(curves, all));
        clipped |= (low, high) != all;
        let [quotient, other] = [Some(quotient), other].map(|course| course.map(|course| course.within((low, high))));
        let Some(quotient) = quotient else { continue };
        let over = over.map(|(x, bottom, top)| {
            let cut = |ends: Vec<f64>| ends.into_iter().map(|end| end.clamp(low, high)).collect::<Vec<f64>>();
            (x, cut(bottom), cut(top))
        });
        // The names of the levels need room above the first curve.
        let room = if charts.is_empty() { 0.25 * (high - low) } else { 0.0 };
        let y_axis = Axis::padded(label, Unit::none(), (low, high + room), 0.08);
        let x_axis = Axis::padded("Penetration", Dimension::Length.unit(x_range.1), x_range, 0.05);
        let mut chart = Chart::new(x_axis, y_axis);
        chart.add(None, Mark::Horizontal { y: 0.0, pen: Pen::new(GREY, 1.0, Dash::Solid) });
        if let Some((x, low, high)) = over {
            chart.add("95 % of the parameters", Mark::Band { x, low, high, colour: ORANGE });
        }
        if charts.is_empty() {
            // Without a quotient the name stands at the value at the mean load.
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

/// The range of an axis whose bands may be far wider than its curves: then it reaches as far beyond the curves as they span, or as
/// a quarter of their size.
fn near((low, high): (f64, f64), all: (f64, f64)) -> (f64, f64) {
    let span = (high - low).max(0.25 * low.abs().max(high.abs()));
    if all.1 - all.0 > WIDE * span { (all.0.max(low - span), all.1.min(high + span)) } else { all }
}

/// Scatter at the mean load over the mean there; its interval is that of the std, beside which the mean is known.
fn at_mean_load(table: &Table, order: &[usize]) -> Option<Course> {
    let mean = Course::of(table, "at_mean_load", order)?.y;
    let std = Course::of(table, "std_at_mean_load", order)?;
    let over = |values: Vec<f64>| values.iter().zip(&mean).map(|(value, mean)| value / mean).collect();
    Some(Course { y: over(std.y), limits: std.limits.map(|(low, high)| (over(low), over(high))) })
}

fn name_levels(chart: &mut Chart, table: &Table, order: &[usize], x: &[f64], y: &[f64]) {
    let percentiles = table.column("percentile").map(|values| ordered(values, order));
    for (row, (&x, &y)) in x.iter().zip(y).enumerate() {
        let percentile = percentiles.as_ref().map_or(f64::NAN, |values| values[row]);
        let text =
            if percentile.is_finite() { format!("{} %", significant(percentile, 3)) } else { "at load".to_owned() };
        chart.add(None, Mark::Note { x, y, text });
    }
}

fn load_charts(table: &Table) -> Vec<(f64, Chart)> {
    let Some([penetration]) = columns(table, ["penetration_m"]) else { return Vec::new() };
    let order = by_depth(penetration);
    let x = ordered(penetration, &order);
    let Some(x_range) = range(&x) else { return Vec::new() };
    let panel = |label: &str, column: &str, band: Option<[&str; 2]>, dimension: Dimension, colour: RGBColor| {
        let y = ordered(table.column(column)?, &order);
        let limits = band.and_then(|names| columns(table, names)).map(|limits| limits.map(|end| ordered(end, &order)));
        let ends = range(positive(&y).chain(limits.iter().flatten().flat_map(|end| positive(end))))?;
        let y_axis = Axis::logarithmic(label, dimension.unit(ends.1), (ends.0 / 1.3, ends.1 * 1.3));
        let x_axis = Axis::padded("Penetration", Dimension::Length.unit(x_range.1), x_range, 0.05);
        let mut chart = Chart::new(x_axis, y_axis);
        if let Some([low, high]) = limits {
            chart.add("95 % interval", Mark::Band { x: x.clone(), low, high, colour });
        }
        chart.add(None, Mark::Points { x: x.clone(), y, pen: Pen::new(colour, 1.8, Dash::Solid) });
        Some(chart)
    };
    let band = Some(["low", "high"]);
    let pressure = panel("Mean pressure", "mean_pressure_pa", band, Dimension::Pressure, BLUE);
    let area = panel("Contact fraction", "contact_fraction", None, Dimension::None, VERMILION);
    stacked(pressure.into_iter().chain(area).collect(), 190.0)
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
    fn levels_out_of_order_are_sorted_by_penetration() {
        let depth = [3.0, 1.0, f64::NAN, 2.0];
        assert_eq!(ordered(&depth, &by_depth(&depth)), [1.0, 2.0, 3.0]);
    }
}
