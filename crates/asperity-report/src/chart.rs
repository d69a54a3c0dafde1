//! Charts: series over two axes, with the legend outside the data.

mod layout;
mod legend;

use plotters::prelude::RGBColor;

pub(crate) use self::layout::{Layout, figure, stacked};
use self::legend::Legend;
use crate::ReportError;
use crate::axis::{Axis, Tick};
use crate::canvas::{Align, Canvas, Dash, GRID, INK, LABEL, Pen, Rect, TEXT, text_width};
use crate::polyline::{clipped, simplified};
use crate::symbol::Shape;

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
    /// Many small points.
    Dots { x: Vec<f64>, y: Vec<f64>, radius: f64, colour: RGBColor, opacity: f64 },
    /// What a colour of the image behind the chart means; in the legend alone.
    Patch { colour: RGBColor },
}

/// An image behind the marks of a chart, in the place of its grid.
#[derive(Debug, Clone)]
pub(crate) struct Backdrop {
    pub(crate) data_uri: String,
    /// Ends of the image along the axes, in SI units.
    pub(crate) x: (f64, f64),
    pub(crate) y: (f64, f64),
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
    pub(crate) backdrop: Option<Backdrop>,
}

impl Chart {
    pub(crate) fn new(x: Axis, y: Axis) -> Self {
        Self { title: None, x, y, series: Vec::new(), shows_x: true, backdrop: None }
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
        self.behind(canvas, plot);
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

    /// Height of the chart's legend where it is `width` wide.
    pub(crate) fn legend_height(&self, width: f64) -> f64 {
        Legend::new([self], 72.0, width - 76.0).height()
    }

    /// Draws the legend of the chart into the upper part of `outer`.
    pub(crate) fn draw_legend(&self, canvas: &mut Canvas<'_>, outer: Rect) -> Result<(), ReportError> {
        Legend::new([self], outer.left + 72.0, outer.width() - 76.0).draw(canvas, outer.top)
    }

    /// Draws the chart into `outer` with its legend above it, for charts that share a figure with a map.
    pub(crate) fn draw_with_legend(&self, canvas: &mut Canvas<'_>, outer: Rect) -> Result<(), ReportError> {
        let legend = Legend::new([self], outer.left + 72.0, outer.width() - 72.0);
        legend.draw(canvas, outer.top)?;
        self.draw(canvas, Rect { top: outer.top + legend.height(), ..outer })
    }

    /// Places the image behind the marks; it must lie within the axes.
    fn behind(&self, canvas: &mut Canvas<'_>, plot: Rect) {
        let Some(Backdrop { data_uri, x, y }) = &self.backdrop else { return };
        let ends = [self.x.position(x.0), self.x.position(x.1), self.y.position(y.0), self.y.position(y.1)];
        let [Some(left), Some(right), Some(low), Some(high)] = ends else { return };
        let rect = Rect {
            left: plot.left + left * plot.width(),
            right: plot.left + right * plot.width(),
            top: plot.bottom - high * plot.height(),
            bottom: plot.bottom - low * plot.height(),
        };
        canvas.image(rect, data_uri);
    }

    fn axes(&self, canvas: &mut Canvas<'_>, plot: Rect) -> Result<(), ReportError> {
        let tick = Pen::new(INK, 1.0, Dash::Solid);
        let grid = Pen::new(GRID, 0.8, Dash::Solid);
        for mark in fitting_ticks(&self.x, plot.width()) {
            let x = plot.left + mark.position * plot.width();
            let length = if mark.label.is_empty() { 3.0 } else { 5.0 };
            if !mark.label.is_empty() {
                if self.backdrop.is_none() {
                    canvas.line(&[(x, plot.top), (x, plot.bottom)], grid)?;
                }
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
                if self.backdrop.is_none() {
                    canvas.line(&[(plot.left, y), (plot.right, y)], grid)?;
                }
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
            Mark::Dots { x, y, radius, colour, opacity } => {
                for at in self.runs(plot, x, y).into_iter().flatten().filter(|at| inside(*at, plot)) {
                    canvas.dot(at, *radius, *colour, *opacity)?;
                }
                Ok(())
            }
            // Notes know of each other and are placed together.
            Mark::Note { .. } | Mark::Patch { .. } => Ok(()),
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
