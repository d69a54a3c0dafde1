//! Autocorrelation along x and y with its bands, the model, and the correlation lengths.

use asperity_results::HeightCorrelation;

use crate::Run;
use crate::figures::surface::scan::{scan, scan_sentence};
use crate::figures::{CaptionedFigure, defined};
use crate::format::{Dimension, Unit};
use crate::plot::{Axis, BLACK, BLUE, Chart, Dash, GREEN, GREY, Mark, Pen, Shape, VERMILION, range};

const NAME: &str = "height_acf";
/// Longest lag in the figure, in correlation lengths.
const LENGTHS: f64 = 6.0;
/// Axes whose lengths differ by a larger factor have a chart each.
const ONE_CHART: f64 = 3.0;

/// Autocorrelation along one axis.
struct Side<'a> {
    axis: &'static str,
    measured: &'a [f64],
    band: Option<[&'a [f64]; 2]>,
    model: Option<&'a [f64]>,
    /// Lag at which the correlation falls to 1/e, and its symbol in the figure.
    length_m: Option<f64>,
    shape: Shape,
    pens: [Pen; 2],
}

impl<'a> Side<'a> {
    /// Returns both axes that were measured.
    fn of_both(run: &Run, curves: &'a HeightCorrelation<'_>) -> Vec<Self> {
        let of_x = Self {
            axis: "x",
            measured: &curves.acf_x,
            band: defined([&curves.acf_x_low, &curves.acf_x_high]),
            model: defined([&curves.fit_x]).map(|[model]| model),
            length_m: scan(run).and_then(|scan| scan.correlation_length_x_m),
            shape: Shape::Disc,
            pens: [Pen::new(BLUE, 2.0, Dash::Solid), Pen::new(BLACK, 1.5, Dash::Dotted)],
        };
        let of_y = Self {
            axis: "y",
            measured: &curves.acf_y,
            band: defined([&curves.acf_y_low, &curves.acf_y_high]),
            model: defined([&curves.fit_y]).map(|[model]| model),
            length_m: scan(run).and_then(|scan| scan.correlation_length_y_m),
            shape: Shape::Diamond,
            pens: [Pen::new(VERMILION, 2.0, Dash::Long), Pen::new(GREEN, 1.6, Dash::Alternating)],
        };
        let known = |side: Self| Self { length_m: side.length_m.filter(|length| *length > 0.0), ..side };
        [of_x, of_y].into_iter().filter(|side| !side.measured.is_empty()).map(known).collect()
    }

    /// Returns every value at lags up to `last`.
    fn values(&self, lag: &'a [f64], last: f64) -> impl Iterator<Item = &'a f64> + '_ {
        let series = [Some(self.measured), self.model].into_iter().flatten().chain(self.band.into_iter().flatten());
        series.flat_map(move |values| lag.iter().zip(values).filter(move |(lag, _)| **lag <= last).map(|(_, v)| v))
    }

    fn draw(&self, chart: &mut Chart, lag: &[f64]) {
        let [pen, model] = self.pens;
        if let Some(band) = self.band {
            chart.band("", lag, band, pen.colour);
        }
        chart.line(format!("measured, {}", self.axis), lag, self.measured, pen);
        if let Some(y) = self.model {
            chart.line(format!("model, {}", self.axis), lag, y, model);
        }
        if let Some(x) = self.length_m {
            let name = format!("ℓ{} = {}", self.axis, Dimension::Length.show_short(x));
            chart.add(name, Mark::Symbol { x, y: (-1f64).exp(), shape: self.shape, colour: pen.colour });
        }
    }
}

/// Draws some axes over the lags of interest.
fn chart(sides: &[Side<'_>], lag: &[f64]) -> Option<Chart> {
    let (first, end) = range(lag)?;
    let longest = sides.iter().filter_map(|side| side.length_m).fold(0.0, f64::max);
    // Lags without a value in any series are left out.
    let is_measured = |(i, lag): (usize, &f64)| sides.iter().any(|side| side.measured[i].is_finite()).then_some(*lag);
    let last = lag.iter().enumerate().filter_map(is_measured).fold(first, f64::max);
    let last = if longest > 0.0 { last.min(LENGTHS * longest) } else { last }.min(end);
    let (low, high) = range(sides.iter().flat_map(|side| side.values(lag, last)))?;
    let ends = ((low - 0.04).clamp(-1.04, -0.05), high.clamp(1.0, 1.2) + 0.04);
    let x = Axis::linear("Lag", Dimension::Length.unit(last), (first, last));
    let mut chart = Chart::new(x, Axis::linear("Autocorrelation", Unit::none(), ends));
    chart.horizontal("", 0.0, Pen::new(GREY, 1.0, Dash::Solid));
    chart.horizontal("", (-1f64).exp(), Pen::new(GREY, 1.2, Dash::Dashed));
    sides.iter().for_each(|side| side.draw(&mut chart, lag));
    Some(chart)
}

pub(super) fn figure(run: &Run) -> Option<CaptionedFigure> {
    let curves = HeightCorrelation::of(run.tables.get(NAME)?);
    let [lag] = defined([&curves.lag_m])?;
    let sides = Side::of_both(run, &curves);
    let lengths: Vec<f64> = sides.iter().filter_map(|side| side.length_m).collect();
    let apart = match lengths[..] {
        [x, y] => x.max(y) > ONE_CHART * x.min(y),
        // An axis along which the correlation does not fall to 1/e within the map is shown over all its lags.
        [_] => sides.len() == 2,
        _ => false,
    };
    let (each, height) = if apart { (1, 320.0) } else { (2, 350.0) };
    let charts = sides.chunks(each).filter_map(|sides| chart(sides, lag));
    let charts: Vec<Chart> = charts.map(|chart| chart.with_height(height)).collect();
    let mut caption = "Autocorrelation of the levelled heights along x and y".to_owned();
    if sides.iter().any(|side| side.model.is_some()) {
        caption += " with the covariance model of the random surface";
    }
    caption += "; the curve falls to 1/e (dashed) at the correlation length ℓ.";
    if !lengths.is_empty() {
        caption += " Lags are shown up to six correlation lengths.";
    }
    if sides.iter().any(|side| side.band.is_some()) {
        caption += " Ribbons are pointwise 95 % bands.";
    }
    caption += &scan_sentence(run);
    CaptionedFigure::from_charts(NAME, "Autocorrelation of heights", caption, charts.len(), &charts, &[NAME])
}
