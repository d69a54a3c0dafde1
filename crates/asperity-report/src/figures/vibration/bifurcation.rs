//! Attractors of the motion over a parameter that rises, and then falls.

use asperity_results::Table;

use crate::figures::vibration::curves::{ATTRACTORS, Tables, axis_label};
use crate::figures::{CaptionedFigure, columns};
use crate::format::{Unit, significant};
use crate::plot::{Axis, BLACK, Chart, Dash, GREY, Mark, Pen, range, stacked};
/// Directions of the parameter: table and name, and width and opacity of the lines. A broad pale line upwards lies under a thin
/// line downwards, so that both are visible where they agree.
const DIRECTIONS: [(&str, &str, f64, f64); 2] =
    [("bifurcation_up", "upwards", 6.0, 0.38), ("bifurcation_down", "downwards", 1.6, 1.0)];

pub(super) fn figure(parameter: &str, tables: &Tables) -> Option<CaptionedFigure> {
    let found: Vec<&Table> = DIRECTIONS.iter().filter_map(|direction| tables.get(direction.0)).collect();
    let ends = range(found.iter().filter_map(|table| table.defined_column(parameter)).flatten())?;
    let charts = [("Velocity dX/dτ", "velocity"), ("Displacement X", "displacement")];
    let charts = charts.into_iter().filter_map(|(label, quantity)| {
        let names = [format!("{quantity}_min"), format!("{quantity}_max")];
        let values =
            found.iter().flat_map(|table| names.iter().filter_map(|name| table.defined_column(name))).flatten();
        let x = Axis::padded(&axis_label(parameter), Unit::none(), ends, 0.02);
        let mut chart = Chart::new(x, Axis::padded(label, Unit::none(), range(values)?, 0.08));
        draw_marks(&mut chart, tables, parameter);
        draw_turns(&mut chart, tables, parameter, quantity);
        draw_curves(&mut chart, tables, parameter, &names);
        Some(chart)
    });
    let caption = "Least and largest velocity and displacement of the motion as a parameter slowly rises (broad) and slowly falls \
                   (thin). Where the two differ, more than one attractor exists.";
    let charts = stacked(charts.collect(), 240.0);
    CaptionedFigure::from_charts("bifurcation", "Attractors over a parameter", caption, 1, &charts, &[])
}

/// Draws curves in the colour of the attractor, with a dot at each point without neighbours.
fn draw_curves(chart: &mut Chart, tables: &Tables, parameter: &str, names: &[String; 2]) {
    for (kind, name, colour, dash) in ATTRACTORS {
        let mut named = false;
        for (table, _, width, opacity) in DIRECTIONS {
            let Some([x, attractor]) = tables.get(table).and_then(|t| columns(t, [parameter, "attractor"])) else {
                continue;
            };
            if !attractor.contains(&kind) {
                continue;
            }
            for column in names.iter().filter_map(|name| tables[table].defined_column(name)) {
                let y: Vec<f64> =
                    column.iter().zip(attractor).map(|(y, found)| if *found == kind { *y } else { f64::NAN }).collect();
                let pen = Pen { opacity, ..Pen::new(colour, width, dash) };
                let legend = !named && width < 2.0;
                named |= legend;
                chart.add("", isolated_points(x, &y, pen));
                chart.line(if legend { name } else { "" }, x, &y, pen);
            }
        }
        let attractor = |direction: &(&str, &str, f64, f64)| tables.get(direction.0)?.defined_column("attractor");
        if !named && DIRECTIONS.iter().filter_map(attractor).flatten().any(|found| *found == kind) {
            chart.add(name, Mark::Patch { colour });
        }
    }
    for (_, name, width, opacity) in DIRECTIONS.iter().filter(|direction| tables.contains_key(direction.0)) {
        // In the legend alone: both directions have the colours of the attractors.
        chart.line(*name, &[], &[], Pen { opacity: opacity.max(0.5), ..Pen::new(GREY, *width, Dash::Solid) });
    }
}

/// Returns the points without a neighbour, which are not visible as lines.
fn isolated_points(x: &[f64], y: &[f64], pen: Pen) -> Mark {
    let defined = |i: Option<usize>| i.and_then(|i| y.get(i)).is_some_and(|y| y.is_finite());
    let alone = |i: usize| !defined(i.checked_sub(1)) && !defined(i.checked_add(1));
    let y = (0..y.len()).map(|i| if alone(i) { y[i] } else { f64::NAN }).collect();
    Mark::Dots { x: x.to_vec(), y, radius: 0.5 * pen.width + 0.5, colour: pen.colour, opacity: pen.opacity }
}

/// Draws every turn of a motion that has several in its period or is not periodic.
fn draw_turns(chart: &mut Chart, tables: &Tables, parameter: &str, quantity: &str) {
    let column = if quantity == "velocity" { "velocity_min" } else { "reattachment_displacement" };
    if let Some([x, y]) = tables.get("bifurcation_turnovers").and_then(|t| columns(t, [parameter, column])) {
        let (x, y) = (x.to_vec(), y.to_vec());
        // Both charts share one entry of the legend.
        let name = "each turn: least velocity, re-attachment";
        chart.add(name, Mark::Dots { x, y, radius: 1.0, colour: BLACK, opacity: 0.3 });
    }
}

/// Draws the values of the parameter at which the attractors change.
fn draw_marks(chart: &mut Chart, tables: &Tables, parameter: &str) {
    let kinds = [
        ("hopf", "Hopf point", "ζ_H", Dash::Dotted),
        ("fold", "cycle ends", "ζ_c", Dash::Alternating),
        ("locked_fold", "locked cycle ends", "ζ", Dash::Dashed),
    ];
    for (column, name, symbol, dash) in kinds {
        let values = tables.get("bifurcation_marks").and_then(|table| table.defined_column(column)).unwrap_or_default();
        for value in values.iter().filter(|value| value.is_finite()) {
            let at = if parameter == "damping_ratio" { format!(", {symbol} = ") } else { " at ".into() };
            chart.vertical(format!("{name}{at}{}", significant(*value, 4)), *value, Pen::new(BLACK, 1.6, dash));
        }
    }
}
