//! Autocorrelation along x and y with its bands, the model, and the correlation lengths.

use super::{Plate, Stage, columns, csv, scan, which};
use crate::axis::{Axis, range};
use crate::canvas::{Dash, Pen};
use crate::chart::{Chart, Layout, Mark, figure};
use crate::format::{Dimension, Unit};
use crate::palette::{BLACK, BLUE, GREEN, GREY, VERMILION};
use crate::{ReportError, Run, Table};

const NAME: &str = "height_acf";
/// Correlation lengths that are shown.
const LENGTHS: f64 = 6.0;
/// Axes whose lengths differ by a larger factor have a chart each.
const ONE_CHART: f64 = 3.0;

/// What is drawn of one axis.
struct Side<'a> {
    axis: &'static str,
    measured: &'a [f64],
    band: Option<[&'a [f64]; 2]>,
    model: Option<&'a [f64]>,
    /// Where the correlation falls to 1/e.
    length_m: Option<f64>,
    pens: [Pen; 2],
    /// Share of the chart by which notes stand beside their marks.
    aside: f64,
}

impl<'a> Side<'a> {
    fn of(run: &Run, table: &'a Table, axis: &'static str, pens: [Pen; 2]) -> Option<Self> {
        Some(Self {
            axis,
            measured: table.column(&format!("acf_{axis}"))?,
            band: table
                .column(&format!("acf_{axis}_low"))
                .zip(table.column(&format!("acf_{axis}_high")))
                .map(Into::into),
            model: table.column(&format!("fit_{axis}")),
            length_m: scan(run)
                .and_then(|scan| scan.number(&format!("correlation_length_{axis}_m")))
                .filter(|length| *length > 0.0),
            pens,
            aside: 0.12,
        })
    }

    /// Every series within the lags up to `last`.
    fn values(&self, lag: &'a [f64], last: f64) -> impl Iterator<Item = &'a f64> + '_ {
        let series = [Some(self.measured), self.model].into_iter().flatten().chain(self.band.into_iter().flatten());
        series.flat_map(move |values| lag.iter().zip(values).filter(move |(lag, _)| **lag <= last).map(|(_, v)| v))
    }

    fn draw(&self, chart: &mut Chart, lag: &[f64]) {
        let [pen, model] = self.pens;
        if let Some([low, high]) = self.band {
            let band = Mark::Band { x: lag.to_vec(), low: low.to_vec(), high: high.to_vec(), colour: pen.colour };
            chart.add_named(format!("95 % band, {}", self.axis), band);
        }
        let curve = |y: &[f64], pen| Mark::Line { x: lag.to_vec(), y: y.to_vec(), pen };
        chart.add_named(format!("measured, {}", self.axis), curve(self.measured, pen));
        if let Some(y) = self.model {
            chart.add_named(format!("model, {}", self.axis), curve(y, model));
        }
        if let Some(length_m) = self.length_m {
            let decayed = (-1f64).exp();
            chart.add(None, Mark::Vertical { x: length_m, pen: Pen::new(pen.colour, 1.0, Dash::Dotted) });
            chart.add(None, Mark::Points { x: vec![length_m], y: vec![decayed], pen });
        }
    }

    /// The length at the upper right of its mark, where no falling curve is; `row` counts notes upwards.
    fn note(&self, chart: &mut Chart, row: usize) {
        if let Some(length_m) = self.length_m {
            let text = format!("ℓ{} = {}", self.axis, Dimension::Length.show_short(length_m));
            let ((first, last), (low, high)) = (chart.x.ends(), chart.y.ends());
            let y = (-1f64).exp() + (0.02 + 0.06 * row as f64) * (high - low);
            chart.add(None, Mark::Note { x: length_m + self.aside * (last - first), y, text });
        }
    }
}

/// A chart of some axes over as many lags as can be read.
fn chart(sides: &[Side<'_>], lag: &[f64]) -> Option<Chart> {
    let (first, end) = range(lag)?;
    let longest = sides.iter().filter_map(|side| side.length_m).fold(0.0, f64::max);
    // Lags without a value in any series are not shown either.
    let defined = |(i, lag): (usize, &f64)| sides.iter().any(|side| side.measured[i].is_finite()).then_some(*lag);
    let last = lag.iter().enumerate().filter_map(defined).fold(first, f64::max);
    let last = if longest > 0.0 { last.min(LENGTHS * longest) } else { last }.min(end);
    let (low, high) = range(sides.iter().flat_map(|side| side.values(lag, last)))?;
    let x = Axis::linear("Lag", Dimension::Length.unit(last), (first, last));
    let y =
        Axis::linear("Autocorrelation", Unit::none(), ((low - 0.04).clamp(-1.04, -0.05), high.clamp(1.0, 1.2) + 0.04));
    let mut chart = Chart::new(x, y);
    chart.add(None, Mark::Horizontal { y: 0.0, pen: Pen::new(GREY, 1.0, Dash::Solid) });
    chart.add("1/e", Mark::Horizontal { y: (-1f64).exp(), pen: Pen::new(GREY, 1.2, Dash::Dotted) });
    sides.iter().for_each(|side| side.draw(&mut chart, lag));
    sides.iter().rev().enumerate().for_each(|(row, side)| side.note(&mut chart, row));
    Some(chart)
}

pub(super) fn plate(run: &Run) -> Result<Option<Plate>, ReportError> {
    let Some(table) = run.tables.get(NAME) else { return Ok(None) };
    let Some([lag]) = columns(table, ["lag_m"]) else { return Ok(None) };
    let pens = [
        ("x", [Pen::new(BLUE, 2.0, Dash::Solid), Pen::new(BLACK, 1.5, Dash::Dotted)]),
        ("y", [Pen::new(VERMILION, 2.0, Dash::Long), Pen::new(GREEN, 1.6, Dash::Alternating)]),
    ];
    let mut sides: Vec<Side<'_>> =
        pens.into_iter().filter_map(|(axis, pens)| Side::of(run, table, axis, pens)).collect();
    let lengths: Vec<f64> = sides.iter().filter_map(|side| side.length_m).collect();
    let apart = match lengths[..] {
        [x, y] => x.max(y) > ONE_CHART * x.min(y),
        // An axis along which the correlation does not fall to 1/e within the map is shown as far as it is known.
        [_] => sides.len() == 2,
        _ => false,
    };
    sides.iter_mut().filter(|_| apart).for_each(|side| side.aside = 0.24);
    let charts: Vec<(f64, Chart)> = if apart {
        sides.chunks(1).filter_map(|side| chart(side, lag)).map(|chart| (0.0, chart)).collect()
    } else {
        chart(&sides, lag).map(|chart| (350.0, chart)).into_iter().collect()
    };
    if charts.is_empty() {
        return Ok(None);
    }
    let title = "Autocorrelation of heights";
    let mut caption = "Autocorrelation of the levelled heights along x and y".to_owned();
    if sides.iter().any(|side| side.model.is_some()) {
        caption += " with the covariance model that the random surface uses";
    }
    caption += "; the correlation length ℓ is where the curve falls to 1/e.";
    if !lengths.is_empty() {
        caption += " Lags are shown up to six correlation lengths.";
    }
    if sides.iter().any(|side| side.band.is_some()) {
        caption += " Ribbons are pointwise 95 % bands.";
    }
    let layout = if apart { Layout::Row(320.0) } else { Layout::Column };
    caption += &which(run);
    let svg = figure(title, &caption, layout, &charts)?;
    Ok(Some(Plate { name: NAME, stage: Stage::Surface, title: title.into(), caption, sources: vec![csv(NAME)], svg }))
}
