//! Symbols of points, which differ in shape as well as colour.

use std::f64::consts::TAU;

use crate::plot::canvas::{Canvas, Colour, Dash, Pen, Point};

/// Shape of a symbol.
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
    /// Draws the symbol around a point. All shapes cover about the area of a disc of this radius.
    pub(crate) fn draw(self, canvas: &mut Canvas, point: Point, radius: f64, colour: Colour) {
        canvas.at(point, |canvas| self.draw_centred(canvas, radius, colour));
    }

    fn draw_centred(self, canvas: &mut Canvas, radius: f64, colour: Colour) {
        let pen = Pen::new(colour, 1.8, Dash::Solid);
        let outer = 1.25 * radius;
        // `count` corners from the angle `from`, in turns; the first one again at the end.
        let corners = |count: usize, from: f64, reach: f64| -> Vec<Point> {
            let angle = |i: usize| TAU * (from + i as f64 / count as f64);
            (0..=count).map(|i| (reach * angle(i).cos(), reach * angle(i).sin())).collect()
        };
        match self {
            Self::Disc => canvas.disc((0.0, 0.0), radius, colour),
            Self::Ring => canvas.line(&corners(24, 0.0, radius), pen),
            Self::Frame => canvas.line(&corners(4, 0.125, outer), pen),
            Self::Diamond => canvas.polygon(&corners(4, 0.0, outer), colour, 1.0),
            Self::OpenDiamond => canvas.line(&corners(4, 0.0, outer), pen),
            Self::Cross | Self::Plus => {
                let ends = corners(4, if self == Self::Cross { 0.125 } else { 0.0 }, outer);
                canvas.line(&[ends[0], ends[2]], pen);
                canvas.line(&[ends[1], ends[3]], pen);
            }
        }
    }
}
