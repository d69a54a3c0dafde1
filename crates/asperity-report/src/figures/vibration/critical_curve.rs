//! The damping ratios at which the cycle ends and sliding becomes stable, along a parameter.

use std::collections::BTreeMap;

use serde_json::Value;

use super::{Words, columns, in_words};
use crate::axis::{Axis, range};
use crate::canvas::{Dash, Pen};
use crate::chart::{Chart, Layout, Mark, stacked};
use crate::format::Unit;
use crate::palette::{BLACK, BLUE, ORANGE, VERMILION};
use crate::{Figure, ReportError, Table};

/// Ratio of the ends of a parameter from which on its axis is logarithmic.
const WIDE: f64 = 4.0;

const WORDS: Words = Words {
    name: "critical_curve",
    title: "Critical damping along a parameter",
    description: "ζ_c, at which the stick-slip cycle ends, and ζ_H, above which steady sliding is stable. Between the two both exist.",
};

pub(super) fn figure(answer: &Value, tables: &BTreeMap<String, Table>) -> Result<Option<Figure>, ReportError> {
    let Some(parameter) = answer["parameter"].as_str() else { return Ok(None) };
    let names = [parameter, "critical_damping_ratio", "hopf_damping_ratio"];
    let Some([x, critical, hopf]) = tables.get("critical_curve").and_then(|t| columns(t, names)) else {
        return Ok(None);
    };
    // Only the locked cycle of a forced machine has a phase at detachment.
    let locked = tables.get("critical_curve").is_some_and(|table| table.column("detachment_phase").is_some());
    let (Some(ends), Some(y)) = (range(x), range(critical.iter().chain(hopf))) else { return Ok(None) };
    let axis = || {
        let name = in_words(parameter);
        let wide = ends.0 > 0.0 && ends.1 > WIDE * ends.0;
        if wide { Axis::logarithmic(&name, Unit::none(), ends) } else { Axis::linear(&name, Unit::none(), ends) }
    };
    let mut chart = Chart::new(axis(), Axis::padded("Damping ratio ζ", Unit::none(), y, 0.08));
    if !locked {
        let (x, low, high) = (x.to_vec(), hopf.to_vec(), critical.to_vec());
        chart.add("sliding and stick-slip coexist", Mark::Band { x, low, high, colour: ORANGE });
    }
    let pen = Pen::new(VERMILION, 2.2, Dash::Solid);
    let name = if locked { "ζ_c: the locked cycle ends (fold)" } else { "ζ_c: the stick-slip cycle ends" };
    chart.add(name, Mark::Line { x: x.to_vec(), y: critical.to_vec(), pen });
    let pen = Pen::new(BLUE, 2.0, Dash::Dashed);
    let name = if locked { "ζ_H of the unforced machine" } else { "ζ_H: sliding is stable above" };
    chart.add(name, Mark::Line { x: x.to_vec(), y: hopf.to_vec(), pen });
    let mut charts = vec![chart];
    if !locked {
        charts.extend(gap(axis(), x, critical, hopf));
    }
    WORDS.figure(Layout::Column, &stacked(charts, if locked { 320.0 } else { 250.0 }))
}

/// Width of the region in which both exist, which is often too narrow to be seen.
fn gap(axis: Axis, x: &[f64], critical: &[f64], hopf: &[f64]) -> Option<Chart> {
    let gap: Vec<f64> = critical.iter().zip(hopf).map(|(c, h)| if c > h { c - h } else { f64::NAN }).collect();
    let (low, high) = range(&gap)?;
    let y = Axis::logarithmic("ζ_c − ζ_H", Unit::none(), (low / 1.5, high * 1.5));
    let mut chart = Chart::new(axis, y);
    let pen = Pen::new(BLACK, 1.8, Dash::Solid);
    chart.add(None, Mark::Line { x: x.to_vec(), y: gap, pen });
    Some(chart)
}
