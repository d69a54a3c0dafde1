//! Colours and symbols of the methods.

use asperity_results::PressureMethod;

use crate::plot::{BLUE, Dash, GREEN, ORANGE, PLUM, PURPLE, Pen, SKY, Shape, VERMILION};

/// Returns the curve and the symbol of a method, the same in all figures.
pub(super) fn style(method: PressureMethod) -> (Pen, Shape) {
    let (colour, width, dash, shape) = match method {
        PressureMethod::MonteCarlo => (BLUE, 1.8, Dash::Short, Shape::Ring),
        PressureMethod::LatinHypercube => (SKY, 1.8, Dash::Dashed, Shape::Frame),
        PressureMethod::Sobol => (GREEN, 1.8, Dash::Alternating, Shape::Diamond),
        PressureMethod::PolynomialChaos => (PURPLE, 1.8, Dash::Dotted, Shape::Cross),
        PressureMethod::PolynomialChaosLog => (ORANGE, 1.8, Dash::Long, Shape::Plus),
        PressureMethod::PolynomialChaosLocal => (PLUM, 1.8, Dash::LongShort, Shape::OpenDiamond),
        PressureMethod::Default => (VERMILION, 2.6, Dash::Solid, Shape::Disc),
    };
    (Pen::new(colour, width, dash), shape)
}
