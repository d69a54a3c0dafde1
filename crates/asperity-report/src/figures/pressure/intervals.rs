//! Contact probability and mean pressure with their intervals, method by method.

use asperity_results::choice::Choice;
use asperity_results::{MethodEntry, Pair};

use crate::Run;
use crate::figures::CaptionedFigure;
use crate::figures::pressure::style::style;
use crate::format::Dimension;
use crate::plot::{Axis, BLACK, Chart, Dash, GREY, Mark, Pen, range};

/// Height of a row in pixels.
const ROW: f64 = 24.0;

/// A value with its interval.
type Estimate = (f64, Option<Pair>);

/// Returns the chart of one quantity by every method; `None` if no method has an interval.
fn chart(
    label: &str,
    dimension: Dimension,
    methods: &[&MethodEntry],
    of: impl Fn(&MethodEntry) -> Option<Estimate>,
    reference: Estimate,
) -> Option<Chart> {
    let estimates: Vec<(usize, Estimate)> =
        methods.iter().enumerate().filter_map(|(row, method)| Some((row, of(method)?))).collect();
    // Estimates without an interval do not determine the axis.
    let known: Vec<&Estimate> = estimates.iter().map(|(_, e)| e).filter(|(_, interval)| interval.is_some()).collect();
    known.first()?;
    let values = known.into_iter().chain([&reference]);
    let (low, high) = range(values.flat_map(|(value, interval)| interval.iter().flatten().chain([value])))?;
    let axis = Axis::padded(label, dimension.unit(high.abs()), (low, high), 0.06);
    let (left, right) = axis.ends();
    let names = methods.iter().map(|method| method.name.words()).collect();
    let mut chart = Chart::new(axis, Axis::named(names)).with_height(ROW * methods.len() as f64 + 62.0);
    if let Some([from, to]) = reference.1 {
        chart.add("reference, 95 %", Mark::Region { from, to, colour: GREY });
    }
    chart.vertical("reference", reference.0, Pen::new(BLACK, 1.0, Dash::Dotted));
    for (row, (value, interval)) in estimates {
        let (pen, shape) = style(methods[row].name);
        let y = row as f64;
        if let Some([from, to]) = interval {
            chart.add("", Mark::Span { from, to, y, pen: Pen { dash: Dash::Solid, width: 2.0, ..pen } });
        }
        match value {
            x if x < left => chart.note(left, y, "◂"),
            x if x > right => chart.note(right, y, "▸"),
            x => chart.add("", Mark::Symbol { x, y, shape, colour: pen.colour }),
        }
    }
    Some(chart)
}

pub(super) fn figure(run: &Run) -> Option<CaptionedFigure> {
    let pressure = run.results.pressure.as_ref().filter(|pressure| pressure.reference_samples > 0)?;
    let methods = pressure.methods.iter().filter(|method| method.contact_probability.is_some());
    let methods: Vec<&MethodEntry> = methods.collect();
    let contact = |method: &MethodEntry| Some((method.contact_probability?, method.contact_probability_interval));
    let mean = |method: &MethodEntry| Some((method.mean_pa?, method.mean_interval));
    let reference = (pressure.contact_probability, pressure.contact_probability_interval);
    let of_mean = (pressure.mean_pa, pressure.mean_interval);
    let charts = [
        chart("P(contact)", Dimension::None, &methods, contact, reference),
        chart("Mean pressure", Dimension::Pressure, &methods, mean, of_mean),
    ];
    let mut charts: Vec<Chart> = charts.into_iter().flatten().collect();
    charts.iter_mut().skip(1).for_each(|chart| chart.shows_y = false);
    let title = "Contact probability and mean pressure by method";
    let caption = "Estimates with 95 % intervals; the grey bar is the reference’s. Intervals of polynomial chaos are corrected for the \
                   bias on samples that were not used in the fit: a symbol off its bar is a biased estimate. An arrow points at an \
                   estimate beyond the frame.";
    CaptionedFigure::from_charts("pressure_intervals", title, caption, charts.len(), &charts, &["pressure_methods"])
}
