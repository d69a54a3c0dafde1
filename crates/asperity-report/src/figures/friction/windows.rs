//! What of the correlation of friction is the window's: lengths and scatter under several windows.

use asperity_results::LevelResult;

use super::positive;
use crate::Table;
use crate::axis::{Axis, range};
use crate::canvas::{Dash, Pen};
use crate::chart::{Chart, Mark, stacked};
use crate::figures::columns;
use crate::format::{Dimension, Unit};
use crate::palette::{BLACK, BLUE, GREEN, VERMILION};

/// ℓ/W of the e^{−s/ℓ} that is closest to the triangle 1 − s/W of the window alone, by least squares over 0 < s < W.
const TRIANGLE_LENGTH: f64 = 0.614_290_278;
/// Lengths below this share of the narrowest window are drawn at the end of the axis.
const SHORTEST: f64 = 0.02;
/// Ratio of the ends of a logarithmic axis that has two ticks with numbers.
const TWO_TICKS: f64 = 4.0;

pub(super) const CAPTION: &str = "Every point is a window of length W over the same strips, at the mean load. Top: the ℓ of e^(−s/ℓ) fitted to the \
     correlation under the window, which contains the window, with the line 0.614 W that the same fit finds for a window that slides \
     over uncorrelated friction; and the ℓ that is left of each when its window is taken out, with its 95 % interval, beside the one \
     length that all windows share; the lower edge stands for 0. Below: the scatter of μ and that expected from the shared length; uncorrelated friction falls as \
     W^(−1/2).";

/// Two charts over the length of the window.
pub(super) fn lengths_and_scatter(table: &Table, lead: Option<&LevelResult>) -> Option<Vec<(f64, Chart)>> {
    let [window] = columns(table, ["window_m"])?;
    let (first, last) = range(positive(window))?;
    let axis = || Axis::logarithmic("Window W", Dimension::Length.unit(last), (first / 1.2, last * 1.2));
    let charts = [lengths(table, window, axis(), lead), scatter(table, window, axis())];
    let charts: Vec<Chart> = charts.into_iter().flatten().collect();
    (!charts.is_empty()).then(|| stacked(charts, 230.0))
}

fn lengths(table: &Table, window: &[f64], x_axis: Axis, lead: Option<&LevelResult>) -> Option<Chart> {
    let (first, last) = x_axis.ends();
    let fitted = table.column("correlation_length_m");
    let own = table.column("own_length_m");
    let band = columns(table, ["own_length_low_m", "own_length_high_m"]);
    let joint = lead.and_then(|lead| lead.correlation_length_without_window_m).unwrap_or(f64::NAN);
    let lowest = SHORTEST * first;
    let drawn = [fitted, own].into_iter().chain(band.into_iter().flatten().map(Some)).flatten();
    let (low, high) = range(drawn.flatten().chain([&joint]).filter(|length| length.is_finite()))?;
    let ends = (low.max(lowest) / 1.3, high.max(lowest) * 1.3);
    // Two ticks at least.
    let widen = (TWO_TICKS / (ends.1 / ends.0)).max(1.0).sqrt();
    let ends = (ends.0 / widen, ends.1 * widen);
    let mut chart = Chart::new(x_axis, Axis::logarithmic("ℓ", Dimension::Length.unit(high), ends));
    let shown = |values: &[f64]| values.iter().map(|length| length.max(ends.0)).collect::<Vec<f64>>();
    // No length has no place on a logarithmic axis; its interval tells.
    let points = |values: &[f64]| values.iter().map(|l| if *l >= ends.0 { *l } else { f64::NAN }).collect::<Vec<f64>>();
    let x = window.to_vec();
    if let Some([low, high]) = band {
        chart.add(None, Mark::Band { x: x.clone(), low: shown(low), high: shown(high), colour: GREEN });
    }
    let triangle = vec![TRIANGLE_LENGTH * first, TRIANGLE_LENGTH * last];
    let pen = Pen::new(BLACK, 1.3, Dash::Dotted);
    if let Some(y) = fitted {
        let dashed = Pen::new(VERMILION, 1.8, Dash::Dashed);
        chart.add("ℓ with the window", Mark::Points { x: x.clone(), y: y.to_vec(), pen: dashed });
        chart.add("window alone: 0.614 W", Mark::Line { x: vec![first, last], y: triangle, pen });
    }
    if let Some(y) = own {
        let pen = Pen::new(GREEN, 1.8, Dash::Solid);
        chart.add("ℓ without it, 95 %", Mark::Points { x, y: points(y), pen });
    }
    if joint < ends.0 {
        let text = "ℓ of all windows together is below this axis".to_owned();
        chart.add(None, Mark::Note { x: (first * last).sqrt(), y: ends.0 * 1.1, text });
    } else if joint.is_finite() {
        let pen = Pen::new(BLUE, 1.3, Dash::Long);
        chart.add("ℓ of all windows together", Mark::Horizontal { y: joint.max(ends.0), pen });
    }
    Some(chart)
}

fn scatter(table: &Table, window: &[f64], x_axis: Axis) -> Option<Chart> {
    let [std] = columns(table, ["std"])?;
    let expected = table.column("expected_std");
    let (low, high) = range(positive(std).chain(expected.into_iter().flatten().filter(|v| **v > 0.0)))?;
    let y_axis = Axis::logarithmic("Std of μ", Unit::none(), (low / 1.2, high * 1.2));
    let mut chart = Chart::new(x_axis, y_axis);
    let (x, y) = (window.to_vec(), std.to_vec());
    if let Some(expected) = expected {
        let pen = Pen::new(BLUE, 1.5, Dash::Long);
        chart.add("std expected with it", Mark::Line { x: x.clone(), y: expected.to_vec(), pen });
    }
    chart.add("std of μ", Mark::Points { x, y, pen: Pen::new(VERMILION, 1.8, Dash::Solid) });
    Some(chart)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_line_of_the_window_alone_is_the_least_of_the_sum_of_squares() {
        let misfit = |length: f64| -> f64 {
            let points = (1..=4000).map(|i| (f64::from(i) - 0.5) / 4000.0);
            points.map(|s| (1.0 - s - (-s / length).exp()).powi(2)).sum()
        };
        let tried = (500..750).map(|i| 1e-3 * f64::from(i));
        let best = tried.min_by(|a, b| misfit(*a).total_cmp(&misfit(*b))).unwrap();
        assert!((best - TRIANGLE_LENGTH).abs() < 1e-3, "{best}");
    }
}
