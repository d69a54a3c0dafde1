//! The probability against the value that a remedy changes.

use asperity_results::{Remedy, Risk, VerdictResult};

use crate::format::{Dimension, Unit};
use crate::markup::{Html, html};
use crate::plot::{Axis, Tick};
use crate::verdict::vibration;
use crate::words::{named, unbroken};

/// Size of the picture, and the range of the drawing in it.
const WIDTH: f64 = 240.0;
const HEIGHT: f64 = 102.0;
const LEFT: f64 = 40.0;
const RIGHT: f64 = 232.0;
const TOP: f64 = 8.0;
const BASE: f64 = 66.0;
/// Characters that have room along the axis, and lines beside it.
const ACROSS: usize = 28;
const LINES: usize = 4;

/// Draws the curve of the remedy that has one.
pub(super) fn picture(verdict: &VerdictResult) -> Html {
    let drawn = verdict.remedies.iter().find(|remedy| !remedy.risk.is_empty());
    let Some((remedy, [first, .., last])) = drawn.map(|remedy| (remedy, &remedy.risk[..])) else {
        return Html::default();
    };
    let largest = remedy.risk.iter().map(|risk| risk.probability).fold(0.0, f64::max);
    let range = (first.value.min(last.value), first.value.max(last.value));
    let dimension = Dimension::of_unit(&remedy.unit);
    let x = Axis::linear(&named(&remedy.input), dimension.unit(range.1), range);
    let y = Axis::linear("probability", Unit::new("%", 0.01), (0.0, largest.max(0.01)));
    let place = |Risk { value, probability }: &Risk| {
        let [right, up] = [(&x, *value), (&y, *probability)].map(|(axis, value)| axis.position(value).unwrap_or(0.0));
        format!("{:.1} {:.1}", LEFT + (RIGHT - LEFT) * right, BASE - (BASE - TOP) * up)
    };
    let line: Vec<String> = remedy.risk.iter().map(place).collect();
    let of = |value: f64| format!("{:.1}", LEFT + (RIGHT - LEFT) * x.position(value).unwrap_or(0.0));
    let (what, falls) = (vibration(verdict), last.value > first.value);
    html!(
        "<svg class=\"risk\" viewBox=\"0 0 {} {}\" role=\"img\" aria-label=\"Probability of {} against the {}\">\n\
         <path class=\"area vibrates\" d=\"M{4} {5}L{6}L{7} {5}Z\"/>\n{8}{9}{10}\
         <text x=\"136\" y=\"98\" text-anchor=\"middle\">{11}</text>\n\
         <text x=\"{12}\" y=\"18\" text-anchor=\"{13}\">probability</text>\n</svg>\n",
        format!("{WIDTH}"),
        format!("{HEIGHT}"),
        &what,
        x.label(),
        of(first.value),
        format!("{BASE}"),
        line.join("L"),
        of(last.value),
        reached(remedy, range, &place),
        scale(&x, &|ticks, widest| (ticks * (widest + 2)).div_ceil(ACROSS), &|tick| {
            let at = LEFT + (RIGHT - LEFT) * tick.position;
            html!("<text x=\"{}\" y=\"82\" text-anchor=\"middle\">{}</text>\n", format!("{at:.1}"), &tick.label)
        }),
        scale(&y, &|ticks, _| ticks.div_ceil(LINES), &|tick| {
            let at = BASE - (BASE - TOP) * tick.position;
            let label = unbroken(&format!("{} %", tick.label));
            html!("<text x=\"36\" y=\"{}\" text-anchor=\"end\">{}</text>\n", format!("{:.1}", at + 4.0), label)
        }),
        x.label(),
        // Where the curve is low.
        if falls { "232" } else { "44" },
        if falls { "end" } else { "start" },
    )
}

/// Draws the values that reach the targets.
fn reached(remedy: &Remedy, (low, high): (f64, f64), place: &dyn Fn(&Risk) -> String) -> Html {
    let points = remedy.reach.iter().filter_map(|reach| {
        // The present value, and the end of a range without it, are more than enough.
        let ends = [remedy.now, remedy.range[0], remedy.range[1]];
        let value = reach.value.filter(|value| (low..=high).contains(value) && !ends.contains(value))?;
        let point = place(&Risk { value, probability: reach.probability });
        let (x, y) = point.split_once(' ')?;
        Some(html!("<circle class=\"mark\" cx=\"{}\" cy=\"{}\" r=\"3.5\"/>\n", x, y))
    });
    points.collect()
}

/// Writes one of so many ticks as `stride` returns for their number and their widest label in characters.
fn scale(axis: &Axis, stride: &dyn Fn(usize, usize) -> usize, text: &dyn Fn(&Tick) -> Html) -> Html {
    let mut ticks = axis.ticks(3);
    ticks.retain(|tick| !tick.label.is_empty() && (-1e-9..=1.0 + 1e-9).contains(&tick.position));
    let widest = ticks.iter().map(|tick| tick.label.chars().count()).max().unwrap_or(0);
    ticks.iter().step_by(stride(ticks.len(), widest).max(1)).map(text).collect()
}
