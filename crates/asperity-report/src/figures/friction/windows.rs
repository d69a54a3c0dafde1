//! Correlation length and standard deviation of friction through several windows.

use asperity_results::{FrictionWindows, LevelResult, Table};

use crate::figures::{defined, positive};
use crate::format::{Dimension, Unit};
use crate::plot::{Axis, BLACK, BLUE, Chart, Dash, GREEN, Pen, VERMILION, range, stacked};
/// ℓ/W of the e^{−s/ℓ} that is closest to the triangle 1 − s/W of the window alone, by least squares over 0 < s < W.
const TRIANGLE_LENGTH: f64 = 0.614_290_278;
/// Lengths below this fraction of the narrowest window are drawn at the end of the axis.
const SHORTEST: f64 = 0.02;
/// Least ratio of the ends of a logarithmic axis with two labelled ticks.
const TWO_TICKS: f64 = 4.0;

pub(super) const CAPTION: &str = "Every point is a window of length W over the same strips, at the mean load. Top: the ℓ of e^(−s/ℓ) \
     fitted to the correlation, which includes the window, with the line 0.614 W of the same fit for a window that slides over \
     uncorrelated friction; and the ℓ without the window, with its 95 % interval, beside the ℓ fitted to all windows together; the \
     lower edge stands for 0. Below: the standard deviation of μ and its expectation from that ℓ; for uncorrelated friction it \
     decreases as W^(−1/2).";

/// Draws two charts over the length of the window.
pub(super) fn charts(table: &Table, level: Option<&LevelResult>) -> Vec<Chart> {
    let curves = FrictionWindows::of(table);
    let Some((first, last)) = range(positive(&curves.window_m)) else { return Vec::new() };
    let axis = || Axis::logarithmic("Window W", Dimension::Length.unit(last), (first / 1.2, last * 1.2));
    let charts = [lengths(&curves, axis(), level), deviations(&curves, axis())];
    stacked(charts.into_iter().flatten().collect(), 230.0)
}

fn lengths(curves: &FrictionWindows<'_>, x_axis: Axis, level: Option<&LevelResult>) -> Option<Chart> {
    let FrictionWindows { window_m: window, correlation_length_m: fitted, own_length_m: own, .. } = curves;
    let (first, last) = x_axis.ends();
    let band = defined([&curves.own_length_low_m, &curves.own_length_high_m]);
    let joint = level.and_then(|level| level.process.correlation_length_without_window_m).unwrap_or(f64::NAN);
    let lowest = SHORTEST * first;
    let drawn = [&**fitted, &**own].into_iter().chain(band.into_iter().flatten());
    let (low, high) = range(drawn.flatten().chain([&joint]).filter(|length| length.is_finite()))?;
    let ends = (low.max(lowest) / 1.3, high.max(lowest) * 1.3);
    let widen = (TWO_TICKS / (ends.1 / ends.0)).max(1.0).sqrt();
    let ends = (ends.0 / widen, ends.1 * widen);
    let mut chart = Chart::new(x_axis, Axis::logarithmic("ℓ", Dimension::Length.unit(high), ends));
    if let Some(band) = band {
        let [low, high] = band.map(|limit| limit.iter().map(|length| length.max(ends.0)).collect::<Vec<f64>>());
        chart.band("", window, [&low, &high], GREEN);
    }
    if !fitted.is_empty() {
        chart.points("ℓ with the window", window, fitted, Pen::new(VERMILION, 1.8, Dash::Dashed));
        let triangle = [TRIANGLE_LENGTH * first, TRIANGLE_LENGTH * last];
        chart.line("window alone: 0.614 W", &[first, last], &triangle, Pen::new(BLACK, 1.3, Dash::Dotted));
    }
    if !own.is_empty() {
        // A length of zero has no place on a logarithmic axis; its interval is drawn alone.
        let y: Vec<f64> = own.iter().map(|l| if *l >= ends.0 { *l } else { f64::NAN }).collect();
        chart.points("ℓ without it, 95 %", window, &y, Pen::new(GREEN, 1.8, Dash::Solid));
    }
    if joint < ends.0 {
        chart.note((first * last).sqrt(), ends.0 * 1.1, "ℓ of all windows together is below this axis");
    } else if joint.is_finite() {
        chart.horizontal("ℓ of all windows together", joint, Pen::new(BLUE, 1.3, Dash::Long));
    }
    Some(chart)
}

fn deviations(curves: &FrictionWindows<'_>, x_axis: Axis) -> Option<Chart> {
    let FrictionWindows { window_m: window, std, expected_std: expected, .. } = curves;
    defined([std])?;
    let (low, high) = range(positive(std).chain(positive(expected)))?;
    let mut chart = Chart::new(x_axis, Axis::logarithmic("Std of μ", Unit::none(), (low / 1.2, high * 1.2)));
    if !expected.is_empty() {
        chart.line("std expected with it", window, expected, Pen::new(BLUE, 1.5, Dash::Long));
    }
    chart.points("std of μ", window, std, Pen::new(VERMILION, 1.8, Dash::Solid));
    Some(chart)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_length_of_the_triangle_minimises_the_sum_of_squares() {
        let misfit = |length: f64| -> f64 {
            let points = (1..=4000).map(|i| (f64::from(i) - 0.5) / 4000.0);
            points.map(|s| (1.0 - s - (-s / length).exp()).powi(2)).sum()
        };
        let tried = (500..750).map(|i| 1e-3 * f64::from(i));
        let best = tried.min_by(|a, b| misfit(*a).total_cmp(&misfit(*b))).unwrap();
        assert!((best - TRIANGLE_LENGTH).abs() < 1e-3, "{best}");
    }
}
