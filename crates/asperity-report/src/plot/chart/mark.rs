//! Data of charts.

use crate::plot::canvas::{Colour, Pen};
use crate::plot::symbol::Shape;

/// Radius of symbols in pixels.
pub(super) const SYMBOL: f64 = 4.2;
/// Radius of the discs on curves in pixels.
pub(super) const DISC: f64 = 3.2;

/// Data of a series and how they are drawn; values are in SI units.
#[derive(Debug, Clone)]
pub(crate) enum Mark {
    /// A curve, interrupted where a value is undefined.
    Line { x: Vec<f64>, y: Vec<f64>, pen: Pen },
    /// A curve with a disc at every point.
    Points { x: Vec<f64>, y: Vec<f64>, pen: Pen },
    /// A symbol at one point.
    Symbol { x: f64, y: f64, shape: Shape, colour: Colour },
    /// A horizontal line between two values of x, for intervals.
    Span { from: f64, to: f64, y: f64, pen: Pen },
    /// The region between two curves, interrupted where one of them is undefined.
    Band { x: Vec<f64>, low: Vec<f64>, high: Vec<f64>, colour: Colour },
    /// Bars of a histogram from the base of the chart; `x` holds the bin centres.
    Bars { x: Vec<f64>, y: Vec<f64>, colour: Colour },
    /// A part of the x axis over the whole height of the chart, cut at the ends of the axis.
    Region { from: f64, to: f64, colour: Colour },
    /// A vertical line across the chart.
    Vertical { x: f64, pen: Pen },
    /// A horizontal line across the chart.
    Horizontal { y: f64, pen: Pen },
    /// A short text above a point.
    Note { x: f64, y: f64, text: String },
    /// Many small points.
    Dots { x: Vec<f64>, y: Vec<f64>, radius: f64, colour: Colour, opacity: f64 },
    /// An entry of the legend that explains a colour of the image behind the chart.
    Patch { colour: Colour },
}

/// A series with its name in the legend; a series without a name is not in the legend.
#[derive(Debug, Clone)]
pub(crate) struct Series {
    pub(crate) name: String,
    pub(crate) mark: Mark,
}
