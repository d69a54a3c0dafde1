//! Charts: series over two axes, with the legend outside the data.

use plotters::prelude::RGBColor;

use crate::ReportError;
use crate::axis::{Axis, Tick};
use crate::canvas::{Align, Canvas, Dash, GRID, INK, LABEL, Pen, Rect, TEXT, draw, text_width};
use crate::polyline::{clipped, simplified};
use crate::symbol::Shape;

/// Height of one row of the legend in pixels.
const LEGEND_ROW: f64 = 21.0;
/// Curves are simplified by at most this distance in pixels.
const TOLERANCE: f64 = 0.12;
/// A curve with more corners is simplified further.
const MOST_CORNERS: usize = 30_000;
/// Bars of a histogram up to this width in pixels have no edge.
const NARROW_BAR: f64 = 4.0;
/// Radius of symbols in pixels.
const SYMBOL: f64 = 4.2;
/// Size of notes in pixels.
const SMALL: f64 = 12.0;

/// How a series is drawn; values are in SI units.
#[derive(Debug, Clone)]
pub(crate) enum Mark {
    /// A curve, interrupted where a value is undefined.
    Line { x: Vec<f64>, y: Vec<f64>, pen: Pen },
    /// A curve with a disc at every point.
    Points { x: Vec<f64>, y: Vec<f64>, pen: Pen },
    /// A symbol at one point.
    Symbol { x: f64, y: f64, shape: Shape, colour: RGBColor },
    /// A horizontal line between two values of x, for intervals.
    Span { from: f64, to: f64, y: f64, pen: Pen },
    /// The region between two curves.
    Band { x: Vec<f64>, low: Vec<f64>, high: Vec<f64>, colour: RGBColor },
    /// Bars of a histogram from the base of the chart; `x` holds the bin centres.
    Bars { x: Vec<f64>, y: Vec<f64>, colour: RGBColor },
    /// A part of the x axis over the whole height of the chart; an end beyond the axis is that of the axis.
    Region { from: f64, to: f64, colour: RGBColor },
    /// A vertical line across the chart.
    Vertical { x: f64, pen: Pen },
    /// A horizontal line across the chart.
    Horizontal { y: f64, pen: Pen },
    /// A short text above a point.
    Note { x: f64, y: f64, text: String },
}

/// A series with its name in the legend, if it has one.
#[derive(Debug, Clone)]
pub(crate) struct Series {
    pub(crate) name: Option<String>,
    pub(crate) mark: Mark,
}

/// Series over two axes.
#[derive(Debug, Clone)]
pub(crate) struct Chart {
    pub(crate) title: Option<String>,
    pub(crate) x: Axis,
    pub(crate) y: Axis,
    pub(crate) series: Vec<Series>,
    /// Tick labels and the label of the x axis are drawn; stacked charts leave them to the lowest one.
    pub(crate) shows_x: bool,
}

impl Chart {
    pub(crate) fn new(x: Axis, y: Axis) -> Self {
        Self { title: None, x, y, series: Vec::new(), shows_x: true }
    }

    pub(crate) fn titled(mut self, title: &str) -> Self {
        self.title = Some(title.into());
        self
    }

    pub(crate) fn add(&mut self, name: impl Into<Option<&'static str>>, mark: Mark) {
        self.series.push(Series { name: name.into().map(str::to_owned), mark });
    }

    pub(crate) fn add_named(&mut self, name: String, mark: Mark) {
        self.series.push(Series { name: Some(name), mark });
    }

    /// Draws the chart without its legend into `outer`, margins for labels included.
    pub(crate) fn draw(&self, canvas: &mut Canvas<'_>, outer: Rect) -> Result<(), ReportError> {
        let plot = Rect {
            left: outer.left + 72.0,
            top: outer.top + if self.title.is_some() { 26.0 } else { 8.0 },
            right: outer.right - 20.0,
            bottom: outer.bottom - if self.shows_x { 50.0 } else { 8.0 },
        };
        self.axes(canvas, plot)?;
        for series in &self.series {
            self.mark(canvas, plot, &series.mark)?;
        }
        self.notes(canvas, plot)?;
        canvas.frame(plot, Pen::new(INK, 1.0, Dash::Solid))?;
        if let Some(title) = &self.title {
            canvas.text((plot.left, outer.top + 13.0), title, LABEL, Align::Start)?;
        }
        Ok(())
    }

    /// Draws the chart into `outer` with its legend above it, for charts that share a figure with a map.
    pub(crate) fn draw_with_legend(&self, canvas: &mut Canvas<'_>, outer: Rect) -> Result<(), ReportError> {
        let legend = Legend::new([self], outer.left + 72.0, outer.width() - 72.0);
        legend.draw(canvas, outer.top)?;
        self.draw(canvas, Rect { top: outer.top + legend.height(), ..outer })
    }

    fn axes(&self, canvas: &mut Canvas<'_>, plot: Rect) -> Result<(), ReportError> {
        let tick = Pen::new(INK, 1.0, Dash::Solid);
        let grid = Pen::new(GRID, 0.8, Dash::Solid);
        for mark in fitting_ticks(&self.x, plot.width()) {
            let x = plot.left + mark.position * plot.width();
            let length = if mark.label.is_empty() { 3.0 } else { 5.0 };
            if !mark.label.is_empty() {
                canvas.line(&[(x, plot.top), (x, plot.bottom)], grid)?;
                if self.shows_x {
                    canvas.text((x, plot.bottom + 15.0), &mark.label, TEXT, Align::Middle)?;
                }
            }
            canvas.line(&[(x, plot.bottom), (x, plot.bottom + length)], tick)?;
        }
        for mark in self.y.ticks((plot.height() / 70.0).max(2.0) as usize) {
            let y = plot.bottom - mark.position * plot.height();
            let length = if mark.label.is_empty() { 3.0 } else { 5.0 };
            if !mark.label.is_empty() {
                canvas.line(&[(plot.left, y), (plot.right, y)], grid)?;
                canvas.text((plot.left - 8.0, y), &mark.label, TEXT, Align::End)?;
            }
            canvas.line(&[(plot.left - length, y), (plot.left, y)], tick)?;
        }
        if self.shows_x {
            let middle = 0.5 * (plot.left + plot.right);
            canvas.text((middle, plot.bottom + 38.0), &self.x.label(), LABEL, Align::Middle)?;
        }
        let middle = 0.5 * (plot.top + plot.bottom);
        canvas.text((plot.left - 60.0, middle), &self.y.label(), LABEL, Align::Upward)
    }

    /// The runs of defined points, in pixels.
    fn runs(&self, plot: Rect, x: &[f64], y: &[f64]) -> Vec<Vec<(f64, f64)>> {
        let mut runs = vec![Vec::new()];
        for (&x, &y) in x.iter().zip(y) {
            match (self.x.position(x), self.y.position(y)) {
                (Some(x), Some(y)) => {
                    let at = (plot.left + x * plot.width(), plot.bottom - y * plot.height());
                    runs.last_mut().into_iter().for_each(|run| run.push(at));
                }
                _ => runs.push(Vec::new()),
            }
        }
        runs.retain(|run| !run.is_empty());
        runs
    }

    fn mark(&self, canvas: &mut Canvas<'_>, plot: Rect, mark: &Mark) -> Result<(), ReportError> {
        match mark {
            Mark::Line { x, y, pen } => self.curve(canvas, plot, x, y, *pen),
            Mark::Points { x, y, pen } => {
                self.curve(canvas, plot, x, y, *pen)?;
                for at in self.runs(plot, x, y).into_iter().flatten().filter(|at| inside(*at, plot)) {
                    canvas.disc(at, 3.2, pen.colour)?;
                }
                Ok(())
            }
            Mark::Symbol { x, y, shape, colour } => {
                match self.runs(plot, &[*x], &[*y]).concat().first().filter(|at| inside(**at, plot)) {
                    Some(at) => shape.draw(canvas, *at, SYMBOL, *colour),
                    None => Ok(()),
                }
            }
            Mark::Span { from, to, y, pen } => self.curve(canvas, plot, &[*from, *to], &[*y, *y], *pen),
            Mark::Band { x, low, high, colour } => {
                let defined: Vec<usize> = (0..x.len()).filter(|&i| low[i].is_finite() && high[i].is_finite()).collect();
                // A band is interrupted where its limits are undefined.
                for group in defined.chunk_by(|a, b| b - a == 1) {
                    let pick = |v: &[f64]| group.iter().map(|&i| v[i]).collect::<Vec<_>>();
                    let clamp =
                        |v: Vec<f64>| v.iter().map(|v| v.clamp(self.y.ends().0, self.y.ends().1)).collect::<Vec<_>>();
                    let (x, low, high) = (pick(x), clamp(pick(low)), clamp(pick(high)));
                    let mut outline: Vec<_> = self.runs(plot, &x, &high).concat();
                    outline.extend(self.runs(plot, &x, &low).concat().into_iter().rev());
                    outline.retain(|at| at.0 >= plot.left - 1.0 && at.0 <= plot.right + 1.0);
                    if outline.len() > 2 {
                        canvas.polygon(&outline, *colour, 0.22)?;
                    }
                }
                Ok(())
            }
            Mark::Bars { x, y, colour } => {
                for (low, high, y) in bins(x, y) {
                    let (Some(low), Some(high), Some(top)) =
                        (self.x.position(low), self.x.position(high), self.y.position(y))
                    else {
                        continue;
                    };
                    let bar = Rect {
                        left: plot.left + low.clamp(0.0, 1.0) * plot.width(),
                        right: plot.left + high.clamp(0.0, 1.0) * plot.width(),
                        top: plot.bottom - top.clamp(0.0, 1.0) * plot.height(),
                        bottom: plot.bottom,
                    };
                    if bar.height() > 0.0 && bar.width() > 0.0 {
                        let corners = [
                            (bar.left, bar.bottom),
                            (bar.left, bar.top),
                            (bar.right, bar.top),
                            (bar.right, bar.bottom),
                        ];
                        canvas.polygon(&corners, *colour, 0.30)?;
                        // The edges of narrow bars would hide the bars.
                        if bar.width() > NARROW_BAR {
                            let edge = Pen { opacity: 0.7, ..Pen::new(*colour, 0.8, Dash::Solid) };
                            canvas.line(&corners, edge)?;
                        }
                    }
                }
                Ok(())
            }
            Mark::Region { from, to, colour } => {
                // Beyond the axis, and at zero on a logarithmic one, a region ends with the axis.
                let place = |x: f64| plot.left + self.x.position(x).unwrap_or(0.0).clamp(0.0, 1.0) * plot.width();
                let (left, right) = (place(*from), place(*to));
                if right - left > 0.5 {
                    let corners = [(left, plot.bottom), (left, plot.top), (right, plot.top), (right, plot.bottom)];
                    canvas.polygon(&corners, *colour, 0.16)?;
                }
                Ok(())
            }
            Mark::Vertical { x, pen } => match self.x.position(*x).filter(|p| (0.0..=1.0).contains(p)) {
                Some(p) => {
                    let x = plot.left + p * plot.width();
                    canvas.line(&[(x, plot.bottom), (x, plot.top)], *pen)
                }
                None => Ok(()),
            },
            Mark::Horizontal { y, pen } => match self.y.position(*y).filter(|p| (0.0..=1.0).contains(p)) {
                Some(p) => {
                    let y = plot.bottom - p * plot.height();
                    canvas.line(&[(plot.left, y), (plot.right, y)], *pen)
                }
                None => Ok(()),
            },
            // Notes know of each other and are placed together.
            Mark::Note { .. } => Ok(()),
        }
    }

    /// Writes the notes above their points, or below, or not at all where other notes already are.
    fn notes(&self, canvas: &mut Canvas<'_>, plot: Rect) -> Result<(), ReportError> {
        let mut taken: Vec<Rect> = Vec::new();
        for series in &self.series {
            let Mark::Note { x, y, text } = &series.mark else { continue };
            let Some(&at) = self.runs(plot, &[*x], &[*y]).concat().first().filter(|at| inside(**at, plot)) else {
                continue;
            };
            let (width, height) = (text_width(text, SMALL) + 4.0, SMALL + 2.0);
            let left = (at.0 - 0.5 * width).clamp(plot.left + 2.0, (plot.right - width - 2.0).max(plot.left + 2.0));
            let places = [-14.0, 14.0, -27.0].map(|shift| Rect::new(left, at.1 + shift - 0.5 * height, width, height));
            let free = |place: &&Rect| {
                place.top > plot.top && place.bottom < plot.bottom && taken.iter().all(|other| !place.overlaps(other))
            };
            if let Some(place) = places.iter().find(free).copied() {
                let middle = (0.5 * (place.left + place.right), 0.5 * (place.top + place.bottom));
                canvas.text(middle, text, SMALL, Align::Middle)?;
                taken.push(place);
            }
        }
        Ok(())
    }

    fn curve(&self, canvas: &mut Canvas<'_>, plot: Rect, x: &[f64], y: &[f64], pen: Pen) -> Result<(), ReportError> {
        for piece in self.runs(plot, x, y).iter().flat_map(|run| clipped(run, plot)) {
            let mut tolerance = TOLERANCE;
            let mut points = simplified(&piece, tolerance);
            // A cloud of very many turns is drawn a little coarser rather than as a file that no viewer opens.
            while points.len() > MOST_CORNERS && tolerance < 1.0 {
                tolerance *= 2.0;
                points = simplified(&piece, tolerance);
            }
            canvas.line(&points, pen)?;
        }
        Ok(())
    }
}

/// The ticks of a horizontal axis, as many as their labels leave room for.
pub(crate) fn fitting_ticks(axis: &Axis, width: f64) -> Vec<Tick> {
    let most = (width / 110.0).max(2.0) as usize;
    let fits = |ticks: &Vec<Tick>| {
        let labelled: Vec<&Tick> = ticks.iter().filter(|tick| !tick.label.is_empty()).collect();
        labelled.windows(2).all(|pair| {
            let needed = 0.5 * (text_width(&pair[0].label, TEXT) + text_width(&pair[1].label, TEXT)) + 8.0;
            (pair[1].position - pair[0].position) * width >= needed
        })
    };
    let mut all = (1..=most).rev().map(|wanted| axis.ticks(wanted));
    all.clone().find(fits).or(all.next_back()).unwrap_or_default()
}

fn inside((x, y): (f64, f64), plot: Rect) -> bool {
    x >= plot.left - 0.5 && x <= plot.right + 0.5 && y >= plot.top - 0.5 && y <= plot.bottom + 0.5
}

/// The named series of several charts, each name once, in rows that fit `width`.
struct Legend<'a> {
    rows: Vec<Vec<(f64, &'a Series)>>,
}

impl<'a> Legend<'a> {
    fn new(charts: impl IntoIterator<Item = &'a Chart>, left: f64, width: f64) -> Self {
        let mut rows: Vec<Vec<(f64, &Series)>> = Vec::new();
        let mut seen: Vec<&str> = Vec::new();
        let mut x = f64::INFINITY;
        for series in charts.into_iter().flat_map(|chart| &chart.series) {
            let Some(name) = series.name.as_deref().filter(|name| !seen.contains(name)) else { continue };
            seen.push(name);
            let length = 38.0 + text_width(name, TEXT) + 18.0;
            if x + length > left + width {
                rows.push(Vec::new());
                x = left;
            }
            rows.last_mut().into_iter().for_each(|row| row.push((x, series)));
            x += length;
        }
        Self { rows }
    }

    fn height(&self) -> f64 {
        if self.rows.is_empty() { 0.0 } else { LEGEND_ROW * self.rows.len() as f64 + 6.0 }
    }

    fn draw(&self, canvas: &mut Canvas<'_>, top: f64) -> Result<(), ReportError> {
        for (row, entries) in self.rows.iter().enumerate() {
            let y = top + LEGEND_ROW * (row as f64 + 0.5) + 4.0;
            for (x, series) in entries {
                let (from, to) = ((*x, y), (*x + 32.0, y));
                match &series.mark {
                    Mark::Symbol { shape, colour, .. } => shape.draw(canvas, (x + 16.0, y), SYMBOL, *colour)?,
                    Mark::Line { pen, .. }
                    | Mark::Vertical { pen, .. }
                    | Mark::Horizontal { pen, .. }
                    | Mark::Span { pen, .. } => {
                        canvas.line(&[from, to], Pen { opacity: pen.opacity.max(0.7), ..*pen })?;
                    }
                    Mark::Points { pen, .. } => {
                        canvas.line(&[from, to], *pen)?;
                        canvas.disc((*x + 16.0, y), 3.2, pen.colour)?;
                    }
                    Mark::Band { colour, .. } | Mark::Bars { colour, .. } | Mark::Region { colour, .. } => {
                        let (left, right, top, bottom) = (x + 4.0, x + 28.0, y - 6.0, y + 6.0);
                        let box_ = [(left, top), (right, top), (right, bottom), (left, bottom)];
                        canvas.polygon(&box_, *colour, 0.30)?;
                    }
                    Mark::Note { .. } => {}
                }
                if let Some(name) = &series.name {
                    canvas.text((*x + 38.0, y), name, TEXT, Align::Start)?;
                }
            }
        }
        Ok(())
    }
}

/// Charts over one x axis, one above the other and equally high; the lowest has its labels.
pub(crate) fn stacked(charts: Vec<Chart>, height: f64) -> Vec<(f64, Chart)> {
    let last = charts.len().saturating_sub(1);
    let place = |(index, chart)| {
        let shows_x = index == last;
        (if shows_x { height + 42.0 } else { height }, Chart { shows_x, ..chart })
    };
    charts.into_iter().enumerate().map(place).collect()
}

/// How charts share a figure.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) enum Layout {
    /// From left to right, equally wide, this high.
    Row(f64),
    /// Two beside each other, row by row, each row this high.
    Pairs(f64),
    /// One above the other; each has its height in the list given to [`figure`].
    Column,
}

/// A figure 640 px wide with one legend above its charts.
///
/// # Errors
/// The drawing backend's.
pub(crate) fn figure(
    title: &str,
    description: &str,
    layout: Layout,
    charts: &[(f64, Chart)],
) -> Result<String, ReportError> {
    const WIDTH: f64 = 640.0;
    let legend = Legend::new(charts.iter().map(|(_, chart)| chart), 72.0, WIDTH - 72.0 - 4.0);
    let top = legend.height();
    let height = match layout {
        Layout::Row(height) => top + height,
        Layout::Pairs(height) => top + charts.len().div_ceil(2) as f64 * height,
        Layout::Column => top + charts.iter().map(|(height, _)| height).sum::<f64>(),
    };
    draw((WIDTH, height), title, description, |canvas| {
        legend.draw(canvas, 0.0)?;
        let mut at = (0.0, top);
        for (place, (share, chart)) in charts.iter().enumerate() {
            match layout {
                Layout::Row(height) => {
                    let width = WIDTH / charts.len() as f64;
                    chart.draw(canvas, Rect::new(at.0, at.1, width, height))?;
                    at.0 += width;
                }
                Layout::Pairs(height) => {
                    let left = if place % 2 == 0 { 0.0 } else { 0.5 * WIDTH };
                    let top = top + (place / 2) as f64 * height;
                    chart.draw(canvas, Rect::new(left, top, 0.5 * WIDTH, height))?;
                }
                Layout::Column => {
                    chart.draw(canvas, Rect::new(at.0, at.1, WIDTH, *share))?;
                    at.1 += share;
                }
            }
        }
        Ok(())
    })
}

/// Edges and height of every bin, from centres: the edges lie midway.
fn bins<'a>(x: &'a [f64], y: &'a [f64]) -> impl Iterator<Item = (f64, f64, f64)> + 'a {
    let last = x.len().saturating_sub(1);
    (0..x.len().min(y.len())).filter(move |_| last > 0).map(move |i| {
        let low = if i == 0 { x[0] - 0.5 * (x[1] - x[0]) } else { 0.5 * (x[i - 1] + x[i]) };
        let high = if i == last { x[i] + 0.5 * (x[i] - x[i - 1]) } else { 0.5 * (x[i] + x[i + 1]) };
        (low, high, y[i])
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::format::Unit;

    const UNIT: Rect = Rect { left: 0.0, top: 0.0, right: 1.0, bottom: 1.0 };

    #[test]
    fn an_undefined_value_interrupts_a_curve() {
        let axis = || Axis::linear("x", Unit::none(), (0.0, 1.0));
        let chart = Chart::new(axis(), axis());
        let runs = chart.runs(UNIT, &[0.0, 0.2, 0.4, 0.6, 0.8], &[0.0, 0.0, f64::NAN, 1.0, 1.0]);
        assert_eq!(runs.iter().map(Vec::len).collect::<Vec<_>>(), [2, 2]);
    }

    #[test]
    fn bins_meet_midway_between_their_centres() {
        let bins: Vec<_> = bins(&[1.0, 2.0, 4.0], &[5.0, 6.0, 7.0]).collect();
        assert_eq!(bins, [(0.5, 1.5, 5.0), (1.5, 3.0, 6.0), (3.0, 5.0, 7.0)]);
    }
}
