//! Colours and symbols of the methods.

use crate::plot::{BLUE, Dash, GREEN, ORANGE, PLUM, PURPLE, Pen, SKY, Shape, VERMILION, pen};

/// Returns the curve and the symbol of a method, the same in all figures; `index` is its place in the list.
pub(super) fn style(method: &str, index: usize) -> (Pen, Shape) {
    let (colour, width, dash, shape) = match method {
        "monte_carlo" => (BLUE, 1.8, Dash::Short, Shape::Ring),
        "latin_hypercube" => (SKY, 1.8, Dash::Dashed, Shape::Frame),
        "sobol" => (GREEN, 1.8, Dash::Alternating, Shape::Diamond),
        "polynomial_chaos" => (PURPLE, 1.8, Dash::Dotted, Shape::Cross),
        "polynomial_chaos_log" => (ORANGE, 1.8, Dash::Long, Shape::Plus),
        "polynomial_chaos_local" => (PLUM, 1.8, Dash::LongShort, Shape::OpenDiamond),
        "default" => (VERMILION, 2.6, Dash::Solid, Shape::Disc),
        _ => return (pen(index), Shape::Ring),
    };
    (Pen::new(colour, width, dash), shape)
}
