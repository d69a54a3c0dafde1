//! The limit cycle, the law of the re-attachment point, and lost cycles against damping.

use serde_json::Value;

use super::{Plate, Stage, columns, csv};
use crate::axis::{Axis, range};
use crate::canvas::{Dash, Pen};
use crate::chart::{Chart, Layout, Mark, figure};
use crate::format::{Unit, significant};
use crate::palette::{BLACK, BLUE, GREY, SKY, VERMILION};
use crate::{ReportError, Run, Table};

pub(super) fn plates(run: &Run, plates: &mut Vec<Plate>) -> Result<(), ReportError> {
    phase_portrait(run, plates)?;
    reattachment(run, plates)?;
    match run.tables.get("cycles_over_damping") {
        Some(table) => cycles(table, &run.results["vibration"], plates),
        None => Ok(()),
    }
}

fn phase_portrait(run: &Run, plates: &mut Vec<Plate>) -> Result<(), ReportError> {
    let settled = run.results["vibration"]["cycle"]["limit_cycle"] == Value::Bool(false);
    let deterministic = if settled { "deterministic motion (no cycle)" } else { "deterministic limit cycle" };
    let curves = [
        ("trajectory", "one stochastic trajectory", Pen { opacity: 0.55, ..Pen::new(SKY, 0.9, Dash::Solid) }),
        ("limit_cycle", deterministic, Pen::new(VERMILION, 2.4, Dash::Solid)),
    ];
    let found: Vec<_> = curves
        .iter()
        .filter_map(|(name, label, pen)| {
            let [x, y] = columns(run.tables.get(*name)?, ["displacement", "velocity"])?;
            Some((*name, *label, *pen, x, y))
        })
        .collect();
    let Some(x_range) = range(found.iter().flat_map(|c| c.3)) else { return Ok(()) };
    let Some(y_range) = range(found.iter().flat_map(|c| c.4)) else { return Ok(()) };
    let x = Axis::padded("Displacement X = xc/N", Unit::none(), x_range, 0.04);
    let mut chart = Chart::new(x, Axis::padded("Velocity dX/dτ", Unit::none(), y_range, 0.08));
    for (_, label, pen, x, y) in &found {
        chart.add(*label, Mark::Line { x: x.to_vec(), y: y.to_vec(), pen: *pen });
    }
    let title = "Phase portrait";
    let caption =
        "Displacement and velocity of the mass (the paper’s Fig. 5a). On the flat upper side the mass sticks \
                   to the belt."
            .to_owned();
    let svg = figure(title, &caption, Layout::Column, &[(380.0, chart)])?;
    let sources = found.iter().rev().map(|c| csv(c.0)).collect();
    plates.push(Plate { name: "limit_cycle", stage: Stage::Vibration, title: title.into(), caption, sources, svg });
    Ok(())
}

fn reattachment(run: &Run, plates: &mut Vec<Plate>) -> Result<(), ReportError> {
    let panels =
        [("reattachment_area", "Upscaling “area”"), ("reattachment_paper", "Upscaling “paper” (one window carries N)")];
    let mut charts = Vec::new();
    let mut sources = Vec::new();
    for (name, heading) in panels {
        let Some(table) = run.tables.get(name) else { continue };
        let Some([x, density]) = columns(table, ["displacement", "density"]) else { continue };
        let normal = table.column("normal_density");
        let all = density.iter().chain(normal.into_iter().flatten());
        let highest = all.copied().filter(|v| v.is_finite()).fold(0.0, f64::max);
        let Some((low, high)) = range(x).filter(|_| highest > 0.0) else { continue };
        let axis = Axis::padded("Re-attachment displacement X", Unit::none(), (low, high), 0.03);
        let mut chart = Chart::new(axis, Axis::linear("Density", Unit::none(), (0.0, 1.06 * highest))).titled(heading);
        chart.add("re-attachments", Mark::Bars { x: x.to_vec(), y: density.to_vec(), colour: BLUE });
        if let Some(y) = normal {
            let pen = Pen::new(BLACK, 1.8, Dash::Dashed);
            chart.add("normal law", Mark::Line { x: x.to_vec(), y: y.to_vec(), pen });
        }
        sources.push(csv(name));
        charts.push((270.0, chart));
    }
    if charts.is_empty() {
        return Ok(());
    }
    let title = "Re-attachment points";
    let caption =
        "Histogram of the displacement at which the mass sticks again, with the normal law of equal mean and \
                   standard deviation (the paper’s Fig. 5b)."
            .to_owned();
    let svg = figure(title, &caption, Layout::Column, &charts)?;
    plates.push(Plate { name: "reattachment", stage: Stage::Vibration, title: title.into(), caption, sources, svg });
    Ok(())
}

fn cycles(table: &Table, vibration: &Value, plates: &mut Vec<Plate>) -> Result<(), ReportError> {
    const NAME: &str = "cycles_over_damping";
    let Some([damping]) = columns(table, ["damping_ratio"]) else { return Ok(()) };
    let limits = [
        ("hopf_damping_ratio", "Hopf point ζ", Pen::new(GREY, 1.6, Dash::Dotted)),
        ("critical_damping_ratio", "cycle ends at ζ", Pen::new(BLACK, 1.6, Dash::Alternating)),
    ];
    let limits: Vec<(f64, String, Pen)> = limits
        .iter()
        .filter_map(|(key, label, pen)| {
            let value = vibration[*key].as_f64()?;
            Some((value, format!("{label} = {}", significant(value, 5)), *pen))
        })
        .collect();
    let Some((mut low, mut high)) = range(damping) else { return Ok(()) };
    for (value, _, _) in &limits {
        // A limit far outside the sweep must not compress it.
        let reach = 0.35 * (high - low);
        if *value > low - reach && *value < high + reach {
            (low, high) = (low.min(*value), high.max(*value));
        }
    }
    let axis = || Axis::padded("Damping ratio ζ", Unit::none(), (low, high), 0.03);
    let counts = [
        ("cycles_deterministic", "deterministic", Pen::new(BLACK, 1.8, Dash::Solid)),
        ("area_cycles_mean", "upscaling “area”", Pen::new(BLUE, 1.8, Dash::Long)),
        ("paper_cycles_mean", "upscaling “paper”", Pen::new(VERMILION, 1.8, Dash::Dashed)),
    ];
    let differences =
        [("area", "upscaling “area”", BLUE, Dash::Long), ("paper", "upscaling “paper”", VERMILION, Dash::Dashed)];
    let mut charts = Vec::new();
    if let Some(y) = range(counts.iter().filter_map(|c| table.column(c.0)).flatten()) {
        let mut chart = Chart::new(axis(), Axis::padded("Cycles M", Unit::none(), (y.0.min(0.0), y.1), 0.08));
        for (name, label, pen) in counts {
            if let Some(y) = table.column(name) {
                chart.add(label, Mark::Points { x: damping.to_vec(), y: y.to_vec(), pen });
            }
        }
        charts.push((230.0, chart));
    }
    let named =
        |prefix: &str, column: &str| table.column(&format!("{prefix}_difference_{column}")).map(<[f64]>::to_vec);
    let values = differences.iter().flat_map(|d| ["mean", "low", "high"].map(|c| named(d.0, c))).flatten().flatten();
    if let Some(y) = range(&values.collect::<Vec<_>>()) {
        let y = Axis::padded("M(det) − mean M", Unit::none(), (y.0.min(0.0), y.1.max(0.0)), 0.08);
        let mut chart = Chart::new(axis(), y);
        chart.add(None, Mark::Horizontal { y: 0.0, pen: Pen::new(GREY, 1.2, Dash::Solid) });
        for (prefix, label, colour, dash) in differences {
            if let (Some(low), Some(high)) = (named(prefix, "low"), named(prefix, "high")) {
                chart.add(None, Mark::Band { x: damping.to_vec(), low, high, colour });
            }
            if let Some(y) = named(prefix, "mean") {
                chart.add(label, Mark::Points { x: damping.to_vec(), y, pen: Pen::new(colour, 1.8, dash) });
            }
        }
        charts.push((230.0, chart));
    }
    let last = charts.len().saturating_sub(1);
    for (index, (height, chart)) in charts.iter_mut().enumerate() {
        for (value, label, pen) in limits.iter().filter(|limit| (low..=high).contains(&limit.0)) {
            chart.add_named(label.clone(), Mark::Vertical { x: *value, pen: *pen });
        }
        chart.shows_x = index == last;
        *height += if index == last { 42.0 } else { 0.0 };
    }
    if charts.is_empty() {
        return Ok(());
    }
    let title = "Cycles lost to roughness against damping";
    let caption =
        "Number of stick-slip cycles M, and its difference from the deterministic count (the paper’s Fig. 5c) \
                   with 95 % intervals. “Area” averages μ over the nominal contact area and is the reading to use; \
                   “paper” lets one window carry the whole normal force."
            .to_owned();
    let svg = figure(title, &caption, Layout::Column, &charts)?;
    let sources = vec![csv(NAME)];
    plates.push(Plate { name: NAME, stage: Stage::Vibration, title: title.into(), caption, sources, svg });
    Ok(())
}
