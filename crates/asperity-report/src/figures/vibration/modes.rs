//! Mode coupling: growth and frequency of the modes over the friction coefficient, and the cycle in the plane.

use std::collections::BTreeMap;

use serde_json::Value;

use super::{Words, columns};
use crate::axis::{Axis, range};
use crate::canvas::{Dash, Pen};
use crate::chart::{Chart, Layout, Mark, stacked};
use crate::format::{Unit, significant};
use crate::palette::{BLACK, BLUE, GREEN, GREY, PURPLE, VERMILION};
use crate::symbol::Shape;
use crate::{Figure, ReportError, Table};

/// Contact of the mass in tables: stick, slip, over-slip, flight.
const CONTACTS: [(f64, &str, Pen); 4] = [
    (0.0, "stick", Pen { colour: VERMILION, width: 3.0, dash: Dash::Solid, opacity: 1.0 }),
    (1.0, "slip", Pen { colour: BLUE, width: 2.0, dash: Dash::Solid, opacity: 1.0 }),
    (2.0, "faster than the belt", Pen { colour: GREEN, width: 2.0, dash: Dash::Dashed, opacity: 1.0 }),
    (3.0, "off the belt", Pen { colour: PURPLE, width: 2.0, dash: Dash::Dotted, opacity: 1.0 }),
];

/// Growth above, frequency below.
pub(super) fn over_friction(answer: &Value, tables: &BTreeMap<String, Table>) -> Result<Option<Figure>, ReportError> {
    let Some(table) = tables.get("modes_over_friction") else { return Ok(None) };
    let Some(friction) = table.column("friction") else { return Ok(None) };
    let Some(ends) = range(friction) else { return Ok(None) };
    let mut charts = Vec::new();
    for (label, quantity) in [("Growth rate", "growth"), ("Frequency ω/ω₀", "frequency")] {
        let modes = [1, 2].map(|mode| table.column(&format!("{quantity}_{mode}")));
        let Some((low, high)) = range(modes.iter().flatten().copied().flatten()) else { continue };
        // Without any growth the axis still has a middle.
        let ends_y = if quantity == "growth" { (low.min(-1e-3), high.max(1e-3)) } else { (low, high) };
        let x = Axis::linear("Friction coefficient μ", Unit::none(), ends);
        let mut chart = Chart::new(x, Axis::padded(label, Unit::none(), ends_y, 0.08));
        if quantity == "growth" {
            chart.add(None, Mark::Horizontal { y: 0.0, pen: Pen::new(GREY, 1.2, Dash::Solid) });
        }
        let pens = [Pen::new(BLUE, 2.2, Dash::Solid), Pen::new(VERMILION, 2.2, Dash::Dashed)];
        for ((mode, pen), name) in modes.into_iter().zip(pens).zip(["first mode", "second mode"]) {
            if let Some(y) = mode {
                chart.add(name, Mark::Line { x: friction.to_vec(), y: y.to_vec(), pen });
            }
        }
        values(&mut chart, answer, ends);
        if quantity == "growth"
            && let (Some(x), Some(y)) = (answer["friction"].as_f64(), answer["growth_rate_mean"].as_f64())
        {
            let mark = Mark::Symbol { x, y, shape: Shape::Diamond, colour: PURPLE };
            chart.add("mean growth under fluctuation", mark);
        }
        charts.push(chart);
    }
    let words = Words {
        name: "modes",
        title: "Modes over the friction coefficient",
        description: "Growth rate and frequency of the two modes of small motion about steady sliding. Where the frequencies meet without \
                      damping one mode begins to grow; damping moves the loss of stability to the critical coefficient.",
    };
    words.figure(Layout::Column, &stacked(charts, 220.0))
}

/// Vertical lines at the friction coefficients that matter.
fn values(chart: &mut Chart, answer: &Value, (_, last): (f64, f64)) {
    let values = [
        ("coalescence", "undamped modes meet, μ", Pen::new(GREY, 1.8, Dash::Dotted)),
        ("critical_friction", "critical μ", Pen::new(BLACK, 1.8, Dash::Alternating)),
        ("friction", "stated machine, μ", Pen::new(GREEN, 1.6, Dash::Long)),
    ];
    for (key, name, pen) in values {
        if let Some(x) = answer[key].as_f64() {
            let name = format!("{name} = {}", significant(x, 5));
            if x <= last {
                chart.add_named(name, Mark::Vertical { x, pen });
            } else {
                chart.add_named(format!("{name}, further on"), Mark::Line { x: Vec::new(), y: Vec::new(), pen });
            }
        }
    }
}

/// The path of the mass, and its velocity along the belt.
pub(super) fn cycle(answer: &Value, tables: &BTreeMap<String, Table>) -> Result<Option<Figure>, ReportError> {
    let names = ["tangential", "tangential_velocity", "normal", "contact"];
    let Some([x, u, y, contact]) = tables.get("mode_cycle").and_then(|t| columns(t, names)) else { return Ok(None) };
    let mut charts = Vec::new();
    for (label, values) in [("Into the belt, y", y), ("Velocity along the belt, dx/dτ", u)] {
        let (Some(x_ends), Some(mut y_ends)) = (range(x), range(values)) else { continue };
        let belt = answer["belt_velocity"].as_f64().filter(|_| label.starts_with("Velocity"));
        if let Some(belt) = belt {
            y_ends = (y_ends.0.min(belt), y_ends.1.max(belt));
        }
        let x_axis = Axis::padded("Along the belt, x", Unit::none(), x_ends, 0.06);
        let mut chart = Chart::new(x_axis, Axis::padded(label, Unit::none(), y_ends, 0.08));
        if let Some(y) = belt {
            chart.add("velocity of the belt", Mark::Horizontal { y, pen: Pen::new(GREY, 1.4, Dash::Dashed) });
        }
        for (kind, name, pen) in CONTACTS {
            if contact.contains(&kind) {
                // A point belongs to what it ends, so that pieces meet.
                let of = |i: usize| contact[i] == kind || contact.get(i + 1) == Some(&kind);
                let y = (0..x.len()).map(|i| if of(i) { values[i] } else { f64::NAN }).collect();
                chart.add(name, Mark::Line { x: x.to_vec(), y, pen });
            }
        }
        charts.push((0.0, chart));
    }
    let words = Words {
        name: "mode_cycle",
        title: "The vibration in the plane",
        description: "One period of the motion without fluctuation: the path of the mass in its plane, and its velocity along the belt over \
                      its displacement.",
    };
    words.figure(Layout::Row(320.0), &charts)
}
