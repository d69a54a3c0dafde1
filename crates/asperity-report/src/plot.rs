//! Charts, maps and symbols as SVG.

mod axis;
mod canvas;
mod chart;
mod image;
mod palette;
mod polyline;
mod raster;
mod symbol;

pub(crate) use axis::{Axis, Tick, range};
pub(crate) use canvas::{Colour, Dash, Pen, WHITE};
pub(crate) use chart::mark::Mark;
pub(crate) use chart::{Backdrop, CURVES, Chart, Layout, ONE_COLUMN, PAGE, SCREEN, TWO_COLUMNS, Width, stacked};
pub(crate) use image::{ColourBar, indexed, scale_palette, shade};
pub(crate) use palette::{BLACK, BLUE, GREEN, GREY, ORANGE, PLUM, PURPLE, SKY, VERMILION, pale, pen};
pub(crate) use raster::{Kind, Raster};
pub(crate) use symbol::Shape;
