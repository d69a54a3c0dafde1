//! The probability of vibration over the central values of two inputs.

use asperity_results::{ProbabilityMap, ProbabilityMapAxis, VerdictResult};

use crate::cells::percent;
use crate::figures::vibration::curves::outlined;
use crate::figures::vibration::stability_map::{lines, with_colour_bar};
use crate::figures::{CaptionedFigure, present};
use crate::format::Dimension;
use crate::plot::{Axis, BLACK, Backdrop, Chart, Dash, Mark, Pen, Shape, WHITE, indexed, range, scale_palette, shade};
use crate::run::RESULTS;
use crate::verdict::percent as probability;
use crate::words::named;
use crate::{ReportError, Run};

const CONTOURS: &str = "verdict_map_contours";
const TITLE: &str = "Probability of vibration over two inputs";
const BAR: &str = "Probability of vibration";
/// Pixels of the image between two central values.
const PIXELS: usize = 8;
/// Dashes of the contours; that of 50 % is solid.
const DASHES: [Dash; 4] = [Dash::Dashed, Dash::Dotted, Dash::Alternating, Dash::Short];
const EVEN: f64 = 0.5;

/// Draws the map of a run.
///
/// # Errors
/// The PNG encoder failed.
pub(super) fn figure(run: &Run) -> Result<Option<CaptionedFigure>, ReportError> {
    let Some(verdict) = &run.results.verdict else { return Ok(None) };
    let Some(map) = verdict.map.as_ref() else { return Ok(None) };
    let (Some(x), Some(y)) = (range(&map.x.values), range(&map.y.values)) else { return Ok(None) };
    let mut chart = Chart::new(axis(&map.x, x), axis(&map.y, y));
    chart.backdrop = Some(Backdrop { data_uri: image(map)?, x, y, aspect: None });
    let table = run.tables.get(CONTOURS);
    let mut levels: Vec<f64> =
        table.and_then(|table| table.defined_column("level")).map_or_else(Vec::new, <[f64]>::to_vec);
    levels.sort_by(f64::total_cmp);
    levels.dedup();
    let mut dashes = DASHES.into_iter().cycle();
    for level in levels {
        let dash = if level == EVEN { Dash::Solid } else { dashes.next().unwrap_or(Dash::Dashed) };
        let found = table.and_then(|table| lines(table, [&map.x.input, &map.y.input], Some(level)));
        let Some((x, y)) = found else { continue };
        let name = percent(level, 2);
        outlined(&mut chart, &name, &x, &y, Pen::new(BLACK, 2.0, dash));
        let longest = x.split(|x| x.is_nan()).map(<[f64]>::len).max().unwrap_or(0);
        let ends = x.split(|x| x.is_nan()).scan(0, |start, line| {
            let own = *start;
            *start += line.len() + 1;
            Some((own, line.len()))
        });
        if let Some((start, count)) = ends.into_iter().find(|(_, count)| *count == longest) {
            let middle = start + count / 2;
            chart.note(x[middle], y[middle], name);
        }
    }
    let now = |axis: &ProbabilityMapAxis| verdict.remedies.iter().find(|r| r.input == axis.input).map(|r| r.now);
    if let (Some(x), Some(y)) = (now(&map.x), now(&map.y)) {
        chart.add("", Mark::Symbol { x, y, shape: Shape::Disc, colour: WHITE });
        chart.add("now", Mark::Symbol { x, y, shape: Shape::Ring, colour: BLACK });
    }
    let figure = with_colour_bar("verdict_map", TITLE, caption(verdict, map), chart, BAR)?;
    Ok(figure.map(|mut figure| {
        figure.sources.push(RESULTS.into());
        figure.with_tables(&present(run, &[CONTOURS]))
    }))
}

fn axis(axis: &ProbabilityMapAxis, ends: (f64, f64)) -> Axis {
    let mut label = named(&axis.input);
    if let Some(first) = label.get(..1) {
        label = format!("{}{}, central value", first.to_uppercase(), &label[1..]);
    }
    Axis::linear(&label, Dimension::of_unit(&axis.unit).unit(ends.1), ends)
}

fn caption(verdict: &VerdictResult, map: &ProbabilityMap) -> String {
    let now = |axis: &ProbabilityMapAxis| verdict.remedies.iter().find(|r| r.input == axis.input).map(|r| r.now);
    let holds = |axis: &ProbabilityMapAxis| {
        now(axis).zip(range(&axis.values)).is_some_and(|(now, (low, high))| (low..=high).contains(&now))
    };
    // The map of mean friction has another probability than the verdict, and steps that are too wide for a steep one.
    let same = map.leaves_out_fluctuation == verdict.leaves_out_fluctuation && holds(&map.x) && holds(&map.y);
    let here = match same {
        true => format!(" At the present values it is {}.", probability(verdict.probability)),
        false => String::new(),
    };
    let constant = match (map.leaves_out_fluctuation, verdict.leaves_out_fluctuation) {
        (false, _) => "",
        (true, false) => {
            " Friction has its mean value: the map leaves out its fluctuation along the path, which the verdict includes."
        }
        (true, true) => {
            " Friction has its mean value: the map leaves out its fluctuation along the path, as the verdict does."
        }
    };
    format!(
        "Colours and lines: probability that a machine vibrates whose motion begins in stick, if two central values change and the \
         variability of all values stays.{here}{constant}"
    )
}

/// Interpolates the probability linearly at a place [x, y] between the central values.
fn interpolated(map: &ProbabilityMap, [x, y]: [f64; 2]) -> f64 {
    let near = |place: f64, count: usize| {
        let index = (place as usize).min(count.saturating_sub(2));
        (index, place - index as f64)
    };
    let ((i, right), (j, up)) = (near(x, map.x.values.len()), near(y, map.y.values.len()));
    let row = |j: usize| (1.0 - right) * map.probability[j][i] + right * map.probability[j][i + 1];
    (1.0 - up) * row(j) + up * row(j + 1)
}

/// Encodes the image of the probability, from the top.
fn image(map: &ProbabilityMap) -> Result<String, ReportError> {
    let [nx, ny] = [&map.x, &map.y].map(|axis| PIXELS * (axis.values.len() - 1));
    let place = |pixel: usize| (pixel as f64 + 0.5) / PIXELS as f64;
    let indices: Vec<u8> =
        (0..nx * ny).map(|pixel| shade(interpolated(map, [place(pixel % nx), place(ny - 1 - pixel / nx)]))).collect();
    indexed(nx, ny, &indices, scale_palette())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn probabilities_are_linear_between_central_values() {
        let axis = |values: &[f64]| ProbabilityMapAxis { values: values.into(), ..ProbabilityMapAxis::default() };
        let map = ProbabilityMap {
            x: axis(&[1.0, 2.0, 4.0]),
            y: axis(&[10.0, 20.0]),
            probability: vec![vec![0.0, 0.2, 0.4], vec![0.4, 0.6, 0.8]],
            leaves_out_fluctuation: false,
        };
        // Places count in steps.
        for (at, wanted) in [([0.0, 0.0], 0.0), ([2.0, 1.0], 0.8), ([1.5, 0.0], 0.3), ([0.5, 0.5], 0.3)] {
            assert!((interpolated(&map, at) - wanted).abs() < 1e-12, "{at:?}");
        }
    }
}
