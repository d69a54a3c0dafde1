//! The damping ratios at which the cycle ends and sliding becomes stable, along a parameter.

use crate::figures::vibration::curves::{Tables, axis_label};
use crate::figures::{CaptionedFigure, columns};
use crate::format::Unit;
use crate::plot::{Axis, BLACK, BLUE, Chart, Dash, ORANGE, Pen, VERMILION, range, stacked};

/// Least ratio of the ends of a parameter for a logarithmic axis.
const WIDE: f64 = 4.0;

pub(super) fn figure(parameter: &str, tables: &Tables) -> Option<CaptionedFigure> {
    let table = tables.get("critical_curve")?;
    let [x, critical, hopf] = columns(table, [parameter, "critical_damping_ratio", "hopf_damping_ratio"])?;
    // Only the locked cycle of a forced machine has a phase at detachment.
    let locked = table.defined_column("detachment_phase").is_some();
    let (ends, y) = (range(x)?, range(critical.iter().chain(hopf))?);
    let axis = || {
        let label = axis_label(parameter);
        let wide = ends.0 > 0.0 && ends.1 > WIDE * ends.0;
        if wide { Axis::logarithmic(&label, Unit::none(), ends) } else { Axis::linear(&label, Unit::none(), ends) }
    };
    let mut chart = Chart::new(axis(), Axis::padded("Damping ratio ζ", Unit::none(), y, 0.08));
    let (height, cycle, sliding) = match locked {
        true => (320.0, "ζ_c: the locked cycle ends (fold)", "ζ_H of the unforced machine"),
        false => (250.0, "ζ_c: the stick-slip cycle ends", "ζ_H: sliding is stable above"),
    };
    if !locked {
        chart.band("sliding and stick-slip coexist", x, [hopf, critical], ORANGE);
    }
    chart.line(cycle, x, critical, Pen::new(VERMILION, 2.2, Dash::Solid));
    chart.line(sliding, x, hopf, Pen::new(BLUE, 2.0, Dash::Dashed));
    let gap = if locked { None } else { gap(axis(), x, critical, hopf) };
    let caption = "ζ_c, at which the stick-slip cycle ends, and ζ_H, above which steady sliding is stable. Between the two both exist.";
    let charts = stacked(std::iter::once(chart).chain(gap).collect(), height);
    CaptionedFigure::from_charts("critical_curve", "Critical damping along a parameter", caption, 1, &charts, &[])
}

/// Draws the width of the region in which both exist, which is often too narrow to be visible.
fn gap(axis: Axis, x: &[f64], critical: &[f64], hopf: &[f64]) -> Option<Chart> {
    let gap: Vec<f64> = critical.iter().zip(hopf).map(|(c, h)| if c > h { c - h } else { f64::NAN }).collect();
    let (low, high) = range(&gap)?;
    let mut chart = Chart::new(axis, Axis::logarithmic("ζ_c − ζ_H", Unit::none(), (low / 1.5, high * 1.5)));
    chart.line("", x, &gap, Pen::new(BLACK, 1.8, Dash::Solid));
    Some(chart)
}
