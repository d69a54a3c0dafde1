//! Mode coupling: growth and frequency of the modes over the friction coefficient, and the cycle in the plane.

use asperity_results::{CoupledPortrait, ModesOverFriction};

use crate::figures::vibration::curves::Tables;
use crate::figures::{CaptionedFigure, defined};
use crate::format::{Unit, significant};
use crate::motion::CoupledModes;
use crate::plot::{Axis, BLACK, BLUE, Chart, Dash, GREEN, GREY, Mark, PURPLE, Pen, Shape, VERMILION, range, stacked};

/// Contact states of the mass: number in tables, name and pen.
const CONTACTS: [(f64, &str, Pen); 4] = [
    (0.0, "stick", Pen::new(VERMILION, 3.0, Dash::Short)),
    (1.0, "slip", Pen::new(BLUE, 2.0, Dash::Solid)),
    (2.0, "faster than the belt", Pen::new(GREEN, 2.0, Dash::Dashed)),
    (3.0, "off the belt", Pen::new(PURPLE, 2.0, Dash::Dotted)),
];

/// Draws the growth above the frequency.
pub(super) fn over_friction(marks: &CoupledModes, tables: &Tables) -> Option<CaptionedFigure> {
    let curves = ModesOverFriction::of(tables.get("modes_over_friction")?);
    let friction = &curves.friction;
    let ends = range(&**friction)?;
    let growth = ("Growth rate", [&curves.growth_1, &curves.growth_2], true);
    let frequency = ("Frequency ω/ω₀", [&curves.frequency_1, &curves.frequency_2], false);
    let charts = [growth, frequency].into_iter().filter_map(|(label, modes, grows)| {
        let (low, high) = range(modes.iter().flat_map(|mode| mode.iter()))?;
        // Without any growth the axis still contains zero.
        let y = if grows { (low.min(-1e-3), high.max(1e-3)) } else { (low, high) };
        let x = Axis::linear("Friction coefficient μ", Unit::none(), ends);
        let mut chart = Chart::new(x, Axis::padded(label, Unit::none(), y, 0.08));
        if grows {
            chart.horizontal("", 0.0, Pen::new(GREY, 1.2, Dash::Solid));
        }
        let pens =
            [("first mode", Pen::new(BLUE, 2.2, Dash::Solid)), ("second mode", Pen::new(VERMILION, 2.2, Dash::Dashed))];
        for (mode, (name, pen)) in modes.into_iter().zip(pens) {
            if !mode.is_empty() {
                chart.line(name, friction, mode, pen);
            }
        }
        draw_values(&mut chart, marks, ends.1);
        if let Some(y) = marks.mean_growth.filter(|_| grows) {
            chart.add(
                "mean growth under fluctuation",
                Mark::Symbol { x: marks.friction, y, shape: Shape::Diamond, colour: PURPLE },
            );
        }
        Some(chart)
    });
    let caption = "Growth rate and frequency of the two modes of small motion about steady sliding. Where the frequencies meet without \
                   damping one mode begins to grow; damping moves the loss of stability to the critical coefficient.";
    let charts = stacked(charts.collect(), 220.0);
    CaptionedFigure::from_charts("modes", "Modes over the friction coefficient", caption, 1, &charts, &[])
}

/// Draws vertical lines at the characteristic friction coefficients.
fn draw_values(chart: &mut Chart, marks: &CoupledModes, last: f64) {
    let values = [
        (marks.coalescence, "undamped modes meet, μ", Pen::new(GREY, 1.8, Dash::Dotted)),
        (marks.critical_friction, "critical μ", Pen::new(BLACK, 1.8, Dash::Alternating)),
        (Some(marks.friction), "stated machine, μ", Pen::new(GREEN, 1.6, Dash::Long)),
    ];
    for (value, name, pen) in values {
        if let Some(x) = value {
            let beyond = if x > last { ", beyond the axis" } else { "" };
            chart.vertical(format!("{name} = {}{beyond}", significant(x, 4)), x, pen);
        }
    }
}

/// Draws the path of the mass, and its velocity along the belt.
pub(super) fn cycle(marks: &CoupledModes, tables: &Tables) -> Option<CaptionedFigure> {
    let curve = CoupledPortrait::of(tables.get("mode_cycle")?);
    let [x, u, y, contact] = defined([&curve.tangential, &curve.tangential_velocity, &curve.normal, &curve.contact])?;
    let belt = marks.belt_velocity;
    let panels = [("Into the belt, y", y, None), ("Velocity along the belt, dx/dτ", u, belt)];
    let charts = panels.into_iter().filter_map(|(label, values, belt)| {
        let ends = range(values.iter().chain(belt.as_slice()))?;
        let x_axis = Axis::padded("Along the belt, x", Unit::none(), range(x)?, 0.06);
        let mut chart = Chart::new(x_axis, Axis::padded(label, Unit::none(), ends, 0.08)).with_height(320.0);
        if let Some(belt) = belt {
            chart.horizontal("velocity of the belt", belt, Pen::new(GREY, 1.4, Dash::Dashed));
        }
        for (kind, name, pen) in CONTACTS {
            if contact.contains(&kind) {
                // A point also belongs to the piece that follows it, so that pieces meet.
                let of = |i: usize| contact[i] == kind || contact.get(i + 1) == Some(&kind);
                let y: Vec<f64> = (0..x.len()).map(|i| if of(i) { values[i] } else { f64::NAN }).collect();
                chart.line(name, x, &y, pen);
            }
        }
        Some(chart)
    });
    let charts: Vec<Chart> = charts.collect();
    let caption = "One period of the motion without fluctuation: the path of the mass in its plane, and its velocity along the belt over \
                   its displacement.";
    CaptionedFigure::from_charts("mode_cycle", "The vibration in the plane", caption, charts.len(), &charts, &[])
}
