//! Charts, maps and symbols as SVG.

mod axis;
mod canvas;
mod chart;
mod image;
mod palette;
mod polyline;
mod raster;
mod symbol;

pub(crate) use axis::{Axis, range};
pub(crate) use canvas::{Align, Canvas, Colour, Dash, GRID, LABEL, Pen, Rect, TEXT, THIN, WHITE, draw, text_width};
pub(crate) use chart::{Backdrop, Chart, Mark, WIDTH, draw_x_ticks, figure, label_x_axis, stacked};
pub(crate) use image::{ColourBar, indexed, scale_palette, shade};
pub(crate) use palette::{BLACK, BLUE, GREEN, GREY, ORANGE, PLUM, PURPLE, SKY, VERMILION, pale, pen};
pub(crate) use raster::{Kind, Raster};
pub(crate) use symbol::Shape;
