//! The distribution function of the pressure by every method (Fig. 2 of the paper).

use asperity_results::PressureMethod;
use asperity_results::choice::Choice;

use crate::Run;
use crate::figures::pressure::style::style;
use crate::figures::{CaptionedFigure, columns};
use crate::format::{Dimension, Unit};
use crate::plot::{self, Axis, BLACK, CURVES, Chart, Dash, GREY, ORANGE, Pen, VERMILION, range, stacked};

/// The methods that are left out first if there are too many curves.
const EXTRA: [PressureMethod; 2] = [PressureMethod::PolynomialChaosLocal, PressureMethod::Sobol];
const NAME: &str = "pressure_cdf";
const BANDS: &str = "pressure_bands";
/// Largest number of methods beside which the legend has room for the bands and the point mass.
const NAMED: usize = 3;
/// A larger difference of neighbours is a jump.
const JUMP: f64 = 0.02;

/// A distribution function by its column.
type Method<'a> = (&'a str, &'a [f64]);

/// Pointwise and simultaneous bands of the default method at its own pressures.
struct Bands<'a> {
    pressure: &'a [f64],
    pointwise: [&'a [f64]; 2],
    simultaneous: [&'a [f64]; 2],
}

impl<'a> Bands<'a> {
    fn new(run: &'a Run) -> Option<Self> {
        let names = ["pressure_pa", "pointwise_low", "pointwise_high", "simultaneous_low", "simultaneous_high"];
        let names = names.map(|name| format!("default_{name}"));
        let table = run.tables.get(BANDS)?;
        let [pressure, a, b, c, d] = columns(table, names.each_ref().map(String::as_str))?;
        Some(Self { pressure, pointwise: [a, b], simultaneous: [c, d] })
    }

    /// Draws both bands relative to a distribution function, with their names if `named`.
    fn draw(&self, chart: &mut Chart, named: bool, reference: impl Fn(f64) -> f64) {
        for (name, limits, colour) in [
            ("default: 95 %, all pressures at once", self.simultaneous, ORANGE),
            ("default: 95 %, at one pressure", self.pointwise, VERMILION),
        ] {
            let shifted = |limit: &[f64]| -> Vec<f64> {
                limit.iter().zip(self.pressure).map(|(f, p)| f - reference(*p)).collect()
            };
            let [low, high] = limits.map(shifted);
            chart.band(if named { name } else { "" }, self.pressure, [&low, &high], colour);
        }
    }

    /// Returns the largest half width of the simultaneous band.
    fn half_width(&self) -> f64 {
        let [low, high] = self.simultaneous;
        low.iter().zip(high).map(|(low, high)| 0.5 * (high - low)).filter(|w| w.is_finite()).fold(0.0, f64::max)
    }
}

/// Returns the name of a column for readers: that of its method, or of the reference.
fn column_name(column: &str) -> String {
    PressureMethod::from_name(column).map_or_else(|_| column.replace('_', " "), |method| method.words())
}

/// Interpolates a tabulated distribution function: linear between its points except at jumps, and constant beyond.
fn interpolated(x: &[f64], y: &[f64], at: f64) -> f64 {
    let after = x.partition_point(|x| *x <= at);
    match (after.checked_sub(1), x.get(after)) {
        (None, _) => y[0],
        (Some(last), None) => y[last],
        (Some(low), Some(_)) if y[after] - y[low] > JUMP => y[low],
        (Some(low), Some(_)) => y[low] + (at - x[low]) / (x[after] - x[low]) * (y[after] - y[low]),
    }
}

pub(super) fn figure(run: &Run) -> Option<CaptionedFigure> {
    let table = run.tables.get(NAME)?;
    let [pressure] = columns(table, ["pressure_pa"])?;
    // The other methods are compared with the reference, which is drawn below them.
    let reference = ["reference", PressureMethod::MonteCarlo.name()]
        .into_iter()
        .find_map(|name| Some((name, table.defined_column(name)?)));
    let is_reference = |name: &str| reference.is_some_and(|(own, _)| own == name);
    let others = table.columns().iter().filter(|(name, _)| name != "pressure_pa" && !is_reference(name));
    let others = others.filter_map(|(name, _)| Some((name.as_str(), table.defined_column(name)?)));
    let mut methods: Vec<Method<'_>> = reference.into_iter().chain(others).collect();
    let mut hidden = Vec::new();
    for extra in EXTRA {
        let place = methods.iter().position(|(name, _)| *name == extra.name());
        if let Some(place) = place.filter(|_| methods.len() > CURVES) {
            methods.remove(place);
            hidden.push(extra.words());
        }
    }
    let first = methods.first()?.1;
    let axis = pressure_axis(pressure, first);
    let lowest = axis_start(&methods);
    let y = Axis::linear("CDF of the pressure", Unit::none(), (lowest, 1.0 + 0.03 * (1.0 - lowest)));
    let mut cdf = Chart::new(axis.clone(), y);
    let pen = |index: usize, name: &str| match is_reference(name) {
        true => Pen { opacity: 0.55, ..Pen::new(GREY, 5.0, Dash::Solid) },
        false => {
            PressureMethod::from_name(name).map_or_else(|_| plot::pen(index.saturating_sub(1)), |own| style(own).0)
        }
    };
    let bands = Bands::new(run);
    if reference.is_none() {
        bands.iter().for_each(|bands| bands.draw(&mut cdf, true, |_| 0.0));
    }
    for (index, (name, values)) in methods.iter().enumerate() {
        let (x, y) = with_step(&axis, pressure, values);
        cdf.line(column_name(name), &x, &y, pen(index, name));
    }
    if pressure[0] <= 0.0 && first[0].is_finite() {
        let pen = Pen::new(BLACK, 1.0, Dash::Dotted);
        let name = if methods.len() <= NAMED { "1 − P(contact), the point mass at p = 0" } else { "" };
        cdf.horizontal(name, first[0], pen);
    }
    let mut caption =
        "Cumulative distribution of the pressure at the point studied (the paper’s Fig. 2). The step at p = 0, \
                       up to the dotted line, is the probability of no contact."
            .to_owned();
    if !hidden.is_empty() {
        caption += &format!(" In the table alone: {}.", hidden.join(", "));
    }
    if lowest > 0.0 {
        caption += " The vertical axis does not begin at 0.";
    }
    let mut charts = vec![cdf];
    let below = reference
        .and_then(|(name, base)| Some((name, differences(axis, pressure, base, &methods, pen, bands.as_ref())?)));
    if let Some((name, (chart, beyond))) = below {
        charts.push(chart);
        caption += &format!(
            " Below: difference of every method from “{}”; its largest absolute value is the KS distance.",
            column_name(name)
        );
        if !beyond.is_empty() {
            caption += &format!(" Beyond the frame below: {}.", beyond.join(", "));
        }
    }
    if bands.is_some() {
        caption += " The shaded bands of asperity’s default contain the true distribution function with 95 % probability at one \
                    pressure, and at all pressures at once.";
    }
    let mut charts = if charts.len() > 1 { stacked(charts, 290.0) } else { charts };
    charts.iter_mut().skip(1).for_each(|chart| chart.height = if bands.is_some() { 230.0 } else { 190.0 });
    let tables: &[&str] = if bands.is_some() { &[NAME, BANDS] } else { &[NAME] };
    CaptionedFigure::from_charts(NAME, "Distribution of the contact pressure", caption, 1, &charts, tables)
}

/// Draws the differences from the reference, the first of the methods. Also returns the methods beyond the frame: a biased method
/// does not compress the others.
fn differences(
    axis: Axis,
    pressure: &[f64],
    base: &[f64],
    methods: &[Method<'_>],
    pen: impl Fn(usize, &str) -> Pen,
    bands: Option<&Bands<'_>>,
) -> Option<(Chart, Vec<String>)> {
    let of = |values: &[f64]| values.iter().zip(base).map(|(a, b)| a - b).collect::<Vec<f64>>();
    let largest = |values: &[f64]| range(values).map_or(0.0, |(low, high)| low.abs().max(high.abs()));
    let all: Vec<(usize, &str, Vec<f64>)> =
        methods.iter().enumerate().skip(1).map(|(index, (name, values))| (index, *name, of(values))).collect();
    let mut each: Vec<f64> = all.iter().map(|(_, _, values)| largest(values)).collect();
    each.sort_by(f64::total_cmp);
    let most = each.last().copied().unwrap_or(0.0);
    // Three times the range of half of the methods; the others are models, which may share a bias.
    let usual = each.get(each.len().div_ceil(2).saturating_sub(1)).copied().unwrap_or(0.0);
    let half = 1.1 * most.min((3.0 * usual).max(bands.map_or(0.0, Bands::half_width)));
    if half <= 0.0 {
        return None;
    }
    let mut chart = Chart::new(axis, Axis::linear("Difference", Unit::none(), (-half, half)));
    bands
        .into_iter()
        .for_each(|bands| bands.draw(&mut chart, methods.len() <= NAMED, |p| interpolated(pressure, base, p)));
    chart.horizontal("", 0.0, Pen { opacity: 0.55, ..Pen::new(GREY, 3.0, Dash::Solid) });
    for (index, name, values) in &all {
        chart.line(column_name(name), pressure, values, pen(*index, name));
    }
    let beyond = all.iter().filter(|(_, _, values)| largest(values) > half);
    Some((chart, beyond.map(|(_, name, _)| format!("“{}”", column_name(name))).collect()))
}

/// Returns the start of the axis of the CDF: one or two tenths below the point masses at zero, so that most of the height shows the
/// pressures.
fn axis_start(methods: &[Method<'_>]) -> f64 {
    let masses = methods.iter().filter_map(|(_, cdf)| cdf.first()).filter(|mass| mass.is_finite());
    let least = masses.fold(1.0_f64, |least, mass| least.min(*mass));
    (10.0 * least - 1.0).floor().clamp(0.0, 9.0) / 10.0
}

/// Returns the distribution function with its step at zero.
fn with_step(axis: &Axis, pressure: &[f64], cdf: &[f64]) -> (Vec<f64>, Vec<f64>) {
    let (mut x, mut y) = (pressure.to_vec(), cdf.to_vec());
    if axis.position(0.0).is_none() {
        // On a logarithmic axis the curve enters from the left at the height of the point mass.
        if let Some(first) = (0..x.len()).find(|&i| y[i].is_finite()) {
            x.insert(0, axis.ends().0);
            y.insert(0, y[first]);
        }
    } else {
        x.splice(0..0, [axis.ends().0, 0.0]);
        y.splice(0..0, [0.0, 0.0]);
    }
    (x, y)
}

/// Returns a linear axis from just below zero, so that the point mass appears as a step, or a logarithmic one if most of the
/// distribution lies in the lowest part of the range.
fn pressure_axis(pressure: &[f64], cdf: &[f64]) -> Axis {
    let mass = cdf.first().copied().filter(|v| v.is_finite()).unwrap_or(0.0);
    let quantile = |probability: f64| {
        let level = mass + probability * (1.0 - mass);
        pressure.iter().zip(cdf).find(|(p, f)| **p > 0.0 && **f >= level).map(|(p, _)| *p)
    };
    let last = range(pressure).map_or(1.0, |(_, high)| high);
    let high = Some(quantile(0.9995).unwrap_or(last)).filter(|high| *high > 0.0).unwrap_or(1.0);
    let median = quantile(0.5).unwrap_or(high);
    let lowest = pressure.iter().copied().filter(|p| *p > 0.0).fold(high, f64::min);
    if median < 0.02 * high && lowest < median {
        let low = lowest.max(1e-3 * median);
        Axis::logarithmic("Pressure", Dimension::Pressure.unit(median), (low, high))
    } else {
        Axis::linear("Pressure", Dimension::Pressure.unit(high), (-0.03 * high, 1.03 * high))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_pressure_axis_is_linear_for_a_uniform_distribution_and_logarithmic_over_many_decades() {
        let even: Vec<f64> = (0..=100).map(|i| f64::from(i) * 1e7).collect();
        let cdf: Vec<f64> = even.iter().map(|p| 0.5 + 0.5 * p / 1e9).collect();
        assert!(pressure_axis(&even, &cdf).position(0.0).is_some_and(|zero| zero > 0.0));
        let wide: Vec<f64> =
            std::iter::once(0.0).chain((0..=90).map(|i| 10f64.powf(3.0 + f64::from(i) / 15.0))).collect();
        let cdf: Vec<f64> = (0..wide.len()).map(|i| 0.5 + 0.5 * i as f64 / (wide.len() - 1) as f64).collect();
        assert_eq!(pressure_axis(&wide, &cdf).position(0.0), None);
    }
}
