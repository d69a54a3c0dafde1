//! Symbols of points, told apart by their shape as well as their colour.

use std::f64::consts::TAU;

use plotters::prelude::RGBColor;

use crate::ReportError;
use crate::canvas::{Canvas, Dash, Pen};

/// The shape of a symbol.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Shape {
    Disc,
    Ring,
    Frame,
    Diamond,
    Cross,
    Plus,
    OpenDiamond,
}

impl Shape {
    /// Draws the symbol around a point; all shapes cover about the area of a disc of this radius.
    pub(crate) fn draw(
        self,
        canvas: &mut Canvas<'_>,
        (x, y): (f64, f64),
        radius: f64,
        colour: RGBColor,
    ) -> Result<(), ReportError> {
        let pen = Pen::new(colour, 1.8, Dash::Solid);
        let corners = |count: usize, from: f64, reach: f64| -> Vec<(f64, f64)> {
            let angle = |i: usize| TAU * (from + i as f64 / count as f64);
            (0..count).map(|i| (x + reach * angle(i).cos(), y + reach * angle(i).sin())).collect()
        };
        let closed = |mut points: Vec<(f64, f64)>| {
            points.push(points[0]);
            points
        };
        let outer = 1.25 * radius;
        match self {
            Self::Disc => canvas.disc((x, y), radius, colour),
            Self::Ring => canvas.line(&closed(corners(24, 0.0, radius)), pen),
            Self::Frame => canvas.line(&closed(corners(4, 0.125, outer)), pen),
            Self::Diamond => canvas.polygon(&corners(4, 0.0, outer), colour, 1.0),
            Self::OpenDiamond => canvas.line(&closed(corners(4, 0.0, outer)), pen),
            Self::Cross | Self::Plus => {
                let ends = corners(4, if self == Self::Cross { 0.125 } else { 0.0 }, outer);
                canvas.line(&[ends[0], ends[2]], pen)?;
                canvas.line(&[ends[1], ends[3]], pen)
            }
        }
    }
}
