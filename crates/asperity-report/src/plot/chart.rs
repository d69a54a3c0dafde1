//! Charts: series over two axes, with the legend outside the data.

mod frame;
mod layout;
mod legend;
pub(super) mod mark;

pub(crate) use self::layout::{Layout, ONE_COLUMN, PAGE, SCREEN, TWO_COLUMNS, Width, stacked};
use self::mark::{DISC, Mark, SYMBOL, Series};
use crate::plot::axis::Axis;
use crate::plot::canvas::{Align, Canvas, Colour, LABEL, Pen, Point, Rect, TEXT, THIN, WHITE, px, text_width};
use crate::plot::polyline::{clipped, simplified};

/// Curves are simplified by at most this distance in pixels.
const TOLERANCE: f64 = 0.12;
/// A curve with more corners is simplified further.
const MAX_CORNERS: usize = 30_000;
/// Bars of a histogram up to this width in pixels have no edge.
const NARROW_BAR: f64 = 4.0;
/// Size of notes in pixels.
const SMALL: f64 = 12.0;
/// Largest number of curves that remain distinct in one chart.
pub(crate) const CURVES: usize = 6;
/// Height of a chart that has a figure of its own, in pixels.
const HEIGHT: f64 = 330.0;

/// An image behind the marks of a chart, which replaces its grid.
#[derive(Debug, Clone)]
pub(crate) struct Backdrop {
    pub(crate) data_uri: String,
    /// Ends of the image along the axes, in SI units.
    pub(crate) x: (f64, f64),
    pub(crate) y: (f64, f64),
    /// Height over width of the image if both axes have one scale.
    pub(crate) aspect: Option<f64>,
}

/// Series over two axes.
#[derive(Debug, Clone)]
pub(crate) struct Chart {
    title: Option<String>,
    pub(crate) x: Axis,
    pub(crate) y: Axis,
    pub(crate) series: Vec<Series>,
    /// Whether the x axis has tick labels and a label; of stacked charts only the lowest has them.
    pub(crate) shows_x: bool,
    /// Whether the y axis has tick labels and a label.
    pub(crate) shows_y: bool,
    pub(crate) backdrop: Option<Backdrop>,
    /// Height in a figure, in pixels; the largest one for a map with one scale along both axes.
    pub(crate) height: f64,
}

impl Chart {
    pub(crate) fn new(x: Axis, y: Axis) -> Self {
        Self { title: None, x, y, series: Vec::new(), shows_x: true, shows_y: true, backdrop: None, height: HEIGHT }
    }

    pub(crate) fn with_title(mut self, title: &str) -> Self {
        self.title = Some(title.into());
        self
    }

    pub(crate) fn with_height(self, height: f64) -> Self {
        Self { height, ..self }
    }

    /// Adds a series; an empty name keeps it out of the legend.
    pub(crate) fn add(&mut self, name: impl Into<String>, mark: Mark) {
        self.series.push(Series { name: name.into(), mark });
    }

    /// Adds a curve.
    pub(crate) fn line(&mut self, name: impl Into<String>, x: &[f64], y: &[f64], pen: Pen) {
        self.add(name, Mark::Line { x: x.to_vec(), y: y.to_vec(), pen });
    }

    /// Adds a curve with a disc at every point.
    pub(crate) fn points(&mut self, name: impl Into<String>, x: &[f64], y: &[f64], pen: Pen) {
        self.add(name, Mark::Points { x: x.to_vec(), y: y.to_vec(), pen });
    }

    /// Adds the region between two curves.
    pub(crate) fn band(&mut self, name: impl Into<String>, x: &[f64], [low, high]: [&[f64]; 2], colour: Colour) {
        self.add(name, Mark::Band { x: x.to_vec(), low: low.to_vec(), high: high.to_vec(), colour });
    }

    /// Adds the bars of a histogram.
    pub(crate) fn bars(&mut self, name: impl Into<String>, x: &[f64], y: &[f64], colour: Colour) {
        self.add(name, Mark::Bars { x: x.to_vec(), y: y.to_vec(), colour });
    }

    /// Adds a vertical line.
    pub(crate) fn vertical(&mut self, name: impl Into<String>, x: f64, pen: Pen) {
        self.add(name, Mark::Vertical { x, pen });
    }

    /// Adds a horizontal line.
    pub(crate) fn horizontal(&mut self, name: impl Into<String>, y: f64, pen: Pen) {
        self.add(name, Mark::Horizontal { y, pen });
    }

    /// Adds a short text above a point.
    pub(crate) fn note(&mut self, x: f64, y: f64, text: impl Into<String>) {
        self.add("", Mark::Note { x, y, text: text.into() });
    }

    /// Returns the room for labels at the left and at the right in pixels.
    pub(crate) fn horizontal_margins(&self) -> f64 {
        self.left_margin() + 20.0
    }

    fn left_margin(&self) -> f64 {
        match self.y.names() {
            _ if !self.shows_y => 12.0,
            [] => 72.0,
            names => names.iter().map(|name| text_width(name, TEXT)).fold(40.0, f64::max) + 20.0,
        }
    }

    fn vertical_margins(&self) -> [f64; 2] {
        [if self.title.is_some() { 26.0 } else { 8.0 }, if self.shows_x { 50.0 } else { 8.0 }]
    }

    /// Returns the height of the chart with its margins, if its plot has a width.
    pub(crate) fn height_for(&self, width: f64) -> f64 {
        let margins: f64 = self.vertical_margins().iter().sum();
        let aspect = self.backdrop.as_ref().and_then(|backdrop| backdrop.aspect);
        aspect.map_or(self.height, |aspect| (width * aspect).clamp(40.0, self.height.max(40.0)) + margins)
    }

    /// Returns the place of the plot in that of the chart.
    pub(crate) fn plot(&self, outer: Rect) -> Rect {
        let [above, below] = self.vertical_margins();
        let mut plot = Rect {
            left: outer.left + self.left_margin(),
            top: outer.top + above,
            right: outer.right - 20.0,
            bottom: outer.bottom - below,
        };
        if let Some(aspect) = self.backdrop.as_ref().and_then(|backdrop| backdrop.aspect) {
            let spare = (plot.width() - (plot.height() / aspect).max(40.0)).max(0.0);
            plot.left += 0.5 * spare;
            plot.right -= 0.5 * spare;
        }
        plot
    }

    /// Draws the chart without its legend into `outer`, margins for labels included.
    pub(crate) fn draw(&self, canvas: &mut Canvas, outer: Rect) {
        let plot = self.plot(outer);
        let place = [plot.left, plot.top, plot.right, plot.bottom].map(|end| px(end).to_string()).join(" ");
        let data = if self.backdrop.is_some() { "data image" } else { "data" };
        canvas.group(&[("class", "chart"), ("data-plot", &place)], |canvas| {
            self.draw_axes(canvas, plot);
            canvas.group(&[("class", data)], |canvas| {
                self.draw_backdrop(canvas, plot);
                for Series { name, mark } in &self.series {
                    canvas.group(&[("data-series", name)], |canvas| self.draw_mark(canvas, plot, mark));
                }
                canvas.group(&[], |canvas| self.draw_notes(canvas, plot));
            });
            canvas.frame(plot, THIN);
            if let Some(title) = &self.title {
                // Beside names a title needs their room, too.
                let left = if self.y.names().is_empty() { plot.left } else { outer.left + 12.0 };
                canvas.text((left, outer.top + 13.0), title, LABEL, Align::Start);
            }
        });
    }

    fn x_at(&self, plot: Rect, x: f64) -> Option<f64> {
        self.x.position(x).map(|position| plot.left + position * plot.width())
    }

    fn y_at(&self, plot: Rect, y: f64) -> Option<f64> {
        self.y.position(y).map(|position| plot.bottom - position * plot.height())
    }

    /// Returns the runs of defined points, in pixels.
    fn runs(&self, plot: Rect, x: &[f64], y: &[f64]) -> Vec<Vec<Point>> {
        let points: Vec<Option<Point>> =
            x.iter().zip(y).map(|(x, y)| self.x_at(plot, *x).zip(self.y_at(plot, *y))).collect();
        let runs = points.split(Option::is_none).filter(|run| !run.is_empty());
        runs.map(|run| run.iter().copied().flatten().collect()).collect()
    }

    /// Returns the points inside the chart, in pixels.
    fn visible(&self, plot: Rect, x: &[f64], y: &[f64]) -> Vec<Point> {
        self.runs(plot, x, y).into_iter().flatten().filter(|point| plot.contains(*point)).collect()
    }

    fn draw_mark(&self, canvas: &mut Canvas, plot: Rect, mark: &Mark) {
        match mark {
            Mark::Line { x, y, pen } => self.draw_curve(canvas, plot, x, y, *pen),
            Mark::Points { x, y, pen } => {
                self.draw_curve(canvas, plot, x, y, *pen);
                for point in self.visible(plot, x, y) {
                    canvas.disc(point, DISC, pen.colour);
                }
            }
            Mark::Symbol { x, y, shape, colour } => {
                for point in self.visible(plot, &[*x], &[*y]) {
                    shape.draw(canvas, point, SYMBOL, *colour);
                }
            }
            Mark::Span { from, to, y, pen } => self.draw_curve(canvas, plot, &[*from, *to], &[*y, *y], *pen),
            Mark::Band { x, low, high, colour } => self.draw_band(canvas, plot, x, [low, high], *colour),
            Mark::Bars { x, y, colour } => self.draw_bars(canvas, plot, x, y, *colour),
            Mark::Region { from, to, colour } => {
                // A logarithmic axis has no place for zero.
                let place = |x: f64| self.x_at(plot, x).unwrap_or(plot.left).clamp(plot.left, plot.right);
                let (left, right) = (place(*from), place(*to));
                if right - left > 0.5 {
                    canvas.fill(Rect { left, right, ..plot }, *colour, 0.16);
                }
            }
            Mark::Vertical { x, pen } => {
                if let Some(x) = self.x_at(plot, *x).filter(|x| (plot.left..=plot.right).contains(x)) {
                    canvas.line(&[(x, plot.bottom), (x, plot.top)], *pen);
                }
            }
            Mark::Horizontal { y, pen } => {
                if let Some(y) = self.y_at(plot, *y).filter(|y| (plot.top..=plot.bottom).contains(y)) {
                    canvas.line(&[(plot.left, y), (plot.right, y)], *pen);
                }
            }
            Mark::Dots { x, y, radius, colour, opacity } => {
                for point in self.visible(plot, x, y) {
                    canvas.dot(point, *radius, *colour, *opacity);
                }
            }
            // Notes are placed together, and a patch is in the legend alone.
            Mark::Note { .. } | Mark::Patch { .. } => {}
        }
    }

    fn draw_curve(&self, canvas: &mut Canvas, plot: Rect, x: &[f64], y: &[f64], pen: Pen) {
        for piece in self.runs(plot, x, y).iter().flat_map(|run| clipped(run, plot)) {
            let mut tolerance = TOLERANCE;
            let mut points = simplified(&piece, tolerance);
            // Viewers are slow on curves with very many corners.
            while points.len() > MAX_CORNERS && tolerance < 1.0 {
                tolerance *= 2.0;
                points = simplified(&piece, tolerance);
            }
            canvas.line(&points, pen);
        }
    }

    fn draw_band(&self, canvas: &mut Canvas, plot: Rect, x: &[f64], limits: [&[f64]; 2], colour: Colour) {
        let (bottom, top) = self.y.ends();
        let defined: Vec<usize> = (0..x.len()).filter(|&i| limits.iter().all(|limit| limit[i].is_finite())).collect();
        for group in defined.chunk_by(|a, b| b - a == 1) {
            let x: Vec<f64> = group.iter().map(|&i| x[i]).collect();
            let [low, high] = limits.map(|limit| {
                let y: Vec<f64> = group.iter().map(|&i| limit[i].clamp(bottom, top)).collect();
                self.runs(plot, &x, &y).concat()
            });
            let mut outline: Vec<Point> = high.into_iter().chain(low.into_iter().rev()).collect();
            outline.retain(|point| point.0 >= plot.left - 1.0 && point.0 <= plot.right + 1.0);
            if outline.len() > 2 {
                canvas.polygon(&outline, colour, 0.22);
            }
        }
    }

    fn draw_bars(&self, canvas: &mut Canvas, plot: Rect, x: &[f64], y: &[f64], colour: Colour) {
        for (low, high, y) in bins(x, y) {
            let ends = (self.x_at(plot, low), self.x_at(plot, high), self.y_at(plot, y));
            let (Some(left), Some(right), Some(top)) = ends else { continue };
            let Rect { bottom, .. } = plot;
            let [left, right] = [left, right].map(|x| x.clamp(plot.left, plot.right));
            let top = top.clamp(plot.top, bottom);
            if top < bottom && left < right {
                canvas.fill(Rect { left, top, right, bottom }, colour, 0.30);
                // The edges of narrow bars would hide the bars.
                if right - left > NARROW_BAR {
                    let edge = Pen { colour, width: 0.8, opacity: 0.7, ..THIN };
                    canvas.line(&[(left, bottom), (left, top), (right, top), (right, bottom)], edge);
                }
            }
        }
    }

    /// Writes the notes above or below their points, over an image on a white ground at the points. A note that would overlap another
    /// one is left out.
    fn draw_notes(&self, canvas: &mut Canvas, plot: Rect) {
        let mut taken: Vec<Rect> = Vec::new();
        for series in &self.series {
            let Mark::Note { x, y, text } = &series.mark else { continue };
            let Some(&point) = self.visible(plot, &[*x], &[*y]).first() else { continue };
            let (x, y) = point;
            let (width, height) = (text_width(text, SMALL) + 4.0, SMALL + 2.0);
            let left = (x - 0.5 * width).clamp(plot.left + 2.0, (plot.right - width - 2.0).max(plot.left + 2.0));
            let shifts = if self.backdrop.is_some() { [0.0, -14.0, 14.0] } else { [-14.0, 14.0, -27.0] };
            let places = shifts.map(|shift| Rect::new(left, y + shift - 0.5 * height, width, height));
            let free = |place: &&Rect| {
                place.top > plot.top && place.bottom < plot.bottom && taken.iter().all(|other| !place.overlaps(other))
            };
            if let Some(place) = places.iter().find(free).copied() {
                let (left, top) = (place.left - x, place.top - y);
                canvas.at(point, |canvas| {
                    let place = Rect::new(left, top, width, height);
                    if self.backdrop.is_some() {
                        canvas.fill(place, WHITE, 0.85);
                    }
                    canvas.text(place.centre(), text, SMALL, Align::Middle);
                });
                taken.push(place);
            }
        }
    }
}

/// Returns the edges and the height of every bin from the centres; edges lie midway between them.
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
    fn the_places_of_a_curve_give_its_values_by_the_attributes_of_the_axes() {
        let (x, y) = ([1e-5, 5e-5, 2e-4], [2.0, 30.0, 70.0]);
        let down = Axis::linear("Lag", Unit::new("µm", 1e-6), (0.0, 2e-4)).downward();
        let mut chart = Chart::new(Axis::logarithmic("k", Unit::none(), (1.0, 100.0)), down);
        chart.line("a < b", &y, &x, Pen { width: 2.0, ..THIN });
        let svg = Layout::new(1, &[chart]).svg("", "", TWO_COLUMNS);
        let attribute = |part: &str, name: &str| {
            let found = svg.split_once(part).and_then(|(_, rest)| rest.split_once(&format!("{name}=\"")));
            found.unwrap().1.split('"').next().unwrap().to_owned()
        };
        let numbers = |text: &str| text.split([' ', ',']).map(|n| n.parse().unwrap()).collect::<Vec<f64>>();
        let plot = numbers(&attribute("class=\"chart\"", "data-plot"));
        let ends = |axis: &str| ["data-from", "data-to"].map(|end| attribute(axis, end).parse::<f64>().unwrap());
        let ([x0, x1], [y0, y1]) = (ends("data-axis=\"x\""), ends("data-axis=\"y\""));
        assert_eq!(attribute("data-axis=\"y\"", "data-label"), "Lag (µm)");
        assert_eq!(
            ["x", "y"].map(|axis| attribute(&format!("data-axis=\"{axis}\""), "data-spacing")),
            ["log", "linear"]
        );
        let places = numbers(&attribute("data-series=\"a &lt; b\"", "points"));
        assert_eq!(places.len(), 6);
        for (place, (lag, k)) in places.chunks(2).zip(x.iter().zip(y)) {
            let (across, up) = ((place[0] - plot[0]) / (plot[2] - plot[0]), (plot[3] - place[1]) / (plot[3] - plot[1]));
            // Half a tenth of a pixel, of at least 250 pixels.
            assert!((x0 * (x1 / x0).powf(across) / k).ln().abs() < 2e-4 * (x1 / x0).ln());
            assert!((y0 + up * (y1 - y0) - lag * 1e6).abs() < 2e-4 * (y1 - y0).abs());
        }
    }

    #[test]
    fn bins_meet_midway_between_their_centres() {
        let bins: Vec<_> = bins(&[1.0, 2.0, 4.0], &[5.0, 6.0, 7.0]).collect();
        assert_eq!(bins, [(0.5, 1.5, 5.0), (1.5, 3.0, 6.0), (3.0, 5.0, 7.0)]);
    }
}
