//! What attracts the motion over a parameter that rises, and then falls.

use std::collections::BTreeMap;

use serde_json::Value;

use super::{ATTRACTORS, Words, columns, in_words};
use crate::axis::{Axis, range};
use crate::canvas::{Dash, Pen};
use crate::chart::{Chart, Layout, Mark, stacked};
use crate::format::{Unit, significant};
use crate::palette::{BLACK, GREY};
use crate::{Figure, ReportError, Table};

/// Ways through the parameter: their table and name, and width and opacity of their lines. The upward way is a broad pale
/// line under the thin one downwards, so that both are seen where they agree.
const WAYS: [(&str, &str, f64, f64); 2] =
    [("bifurcation_up", "upwards", 6.0, 0.38), ("bifurcation_down", "downwards", 1.6, 1.0)];

const WORDS: Words = Words {
    name: "bifurcation",
    title: "Attractors over a parameter",
    description: "Least and largest velocity and displacement of the motion that a slowly rising (broad) and a slowly falling (thin) \
                  parameter leads through. Where the two differ, more than one attractor exists.",
};

pub(super) fn figure(answer: &Value, tables: &BTreeMap<String, Table>) -> Result<Option<Figure>, ReportError> {
    let Some(parameter) = answer["parameter"].as_str() else { return Ok(None) };
    let ways: Vec<&Table> = WAYS.iter().filter_map(|way| tables.get(way.0)).collect();
    let Some(ends) = range(ways.iter().filter_map(|table| table.column(parameter)).flatten()) else { return Ok(None) };
    let charts = [("Velocity dX/dτ", "velocity"), ("Displacement X", "displacement")];
    let charts = charts.into_iter().filter_map(|(label, quantity)| {
        let names = [format!("{quantity}_min"), format!("{quantity}_max")];
        let values = ways.iter().flat_map(|table| names.iter().filter_map(|name| table.column(name))).flatten();
        let x = Axis::padded(&in_words(parameter), Unit::none(), ends, 0.02);
        let mut chart = Chart::new(x, Axis::padded(label, Unit::none(), range(values)?, 0.08));
        marks(&mut chart, tables, parameter);
        turns(&mut chart, tables, parameter, quantity);
        curves(&mut chart, tables, parameter, &names);
        Some(chart)
    });
    WORDS.figure(Layout::Column, &stacked(charts.collect(), 240.0))
}

/// Curves in the colour of the attractor, with a dot at each value of the parameter.
fn curves(chart: &mut Chart, tables: &BTreeMap<String, Table>, parameter: &str, names: &[String; 2]) {
    for (kind, name, colour) in ATTRACTORS {
        let mut named = false;
        for (table, _, width, opacity) in WAYS {
            let Some([x, attractor]) = tables.get(table).and_then(|t| columns(t, [parameter, "attractor"])) else {
                continue;
            };
            if !attractor.contains(&kind) {
                continue;
            }
            for column in names.iter().filter_map(|name| tables[table].column(name)) {
                let y: Vec<f64> =
                    column.iter().zip(attractor).map(|(y, found)| if *found == kind { *y } else { f64::NAN }).collect();
                let pen = Pen { opacity, ..Pen::new(colour, width, Dash::Solid) };
                let legend = (!named && width < 2.0).then_some(name);
                named |= legend.is_some();
                chart.add(None, lone(x, &y, 0.5 * width + 0.5, pen));
                chart.add(legend, Mark::Line { x: x.to_vec(), y, pen });
            }
        }
        if !named && seen(tables, kind) {
            chart.add(name, Mark::Patch { colour });
        }
    }
    for (_, name, width, opacity) in WAYS.iter().filter(|way| tables.contains_key(way.0)) {
        // For the legend alone: both ways have the colours of the attractors.
        let pen = Pen { opacity: opacity.max(0.5), ..Pen::new(GREY, *width, Dash::Solid) };
        chart.add(*name, Mark::Line { x: Vec::new(), y: Vec::new(), pen });
    }
}

/// Points without a neighbour, which no line shows.
fn lone(x: &[f64], y: &[f64], radius: f64, pen: Pen) -> Mark {
    let defined = |i: Option<usize>| i.and_then(|i| y.get(i)).is_some_and(|y| y.is_finite());
    let alone = |i: usize| !defined(i.checked_sub(1)) && !defined(i.checked_add(1));
    let y = (0..y.len()).map(|i| if alone(i) { y[i] } else { f64::NAN }).collect();
    Mark::Dots { x: x.to_vec(), y, radius, colour: pen.colour, opacity: pen.opacity }
}

fn seen(tables: &BTreeMap<String, Table>, kind: f64) -> bool {
    let attractor = |way: &(&str, &str, f64, f64)| tables.get(way.0)?.column("attractor");
    WAYS.iter().filter_map(attractor).flatten().any(|found| *found == kind)
}

/// Every turn of a motion that has several in its period, or does not repeat itself.
fn turns(chart: &mut Chart, tables: &BTreeMap<String, Table>, parameter: &str, quantity: &str) {
    let column = if quantity == "velocity" { "velocity_min" } else { "reattachment_displacement" };
    let Some([x, y]) = tables.get("bifurcation_turnovers").and_then(|t| columns(t, [parameter, column])) else {
        return;
    };
    // One name, and so one entry, in both charts.
    let name = "each turn: least velocity, re-attachment";
    let (x, y) = (x.to_vec(), y.to_vec());
    chart.add(name, Mark::Dots { x, y, radius: 1.0, colour: BLACK, opacity: 0.3 });
}

/// Where the structure changes, with the values.
fn marks(chart: &mut Chart, tables: &BTreeMap<String, Table>, parameter: &str) {
    let Some(table) = tables.get("bifurcation_marks") else { return };
    let kinds = [
        ("hopf", "Hopf point", Pen::new(BLACK, 1.6, Dash::Dotted)),
        ("fold", "cycle ends", Pen::new(BLACK, 1.6, Dash::Alternating)),
        ("locked_fold", "locked cycle ends", Pen::new(BLACK, 1.6, Dash::Dashed)),
    ];
    for (column, name, pen) in kinds {
        for value in table.column(column).unwrap_or_default().iter().filter(|value| value.is_finite()) {
            let symbol = match (parameter, column) {
                ("damping_ratio", "hopf") => ", ζ_H = ",
                ("damping_ratio", "fold") => ", ζ_c = ",
                ("damping_ratio", _) => ", ζ = ",
                _ => " at ",
            };
            chart.add_named(format!("{name}{symbol}{}", significant(*value, 5)), Mark::Vertical { x: *value, pen });
        }
    }
}
