//! Phase portraits: many trajectories, one, and the deterministic cycle over them.

use std::collections::BTreeMap;

use super::{Words, columns, parted};
use crate::axis::{Axis, range};
use crate::canvas::{Dash, Pen};
use crate::chart::{self, Chart, Layout, Mark};
use crate::figures::{Plate, Stage, csv};
use crate::format::Unit;
use crate::palette::{PURPLE, SKY, VERMILION};
use crate::{Figure, ReportError, Run, Table};

const HEIGHT: f64 = 380.0;
/// Points of a cloud that are further apart in τ are drawn as points, not as curves.
const DENSE: f64 = 0.3;
/// Points of a cloud that together are about as dark as its curves.
const MANY: f64 = 1500.0;

pub(super) fn plate(run: &Run, plates: &mut Vec<Plate>) -> Result<(), ReportError> {
    let settled = run.results.vibration.as_ref().is_some_and(|vibration| !vibration.cycle.limit_cycle);
    let deterministic = if settled { "deterministic motion (no cycle)" } else { "deterministic limit cycle" };
    let Some((chart, drawn)) = portrait(&run.tables, deterministic) else { return Ok(()) };
    let title = "Phase portrait";
    let cloud = if drawn.contains(&"phase_cloud") {
        " The cloud is many trajectories, each for about one period at the end of its time."
    } else {
        ""
    };
    let caption = format!(
        "Displacement and velocity of the mass (the paper’s Fig. 5a). On the flat upper side the mass sticks to the belt.{cloud}"
    );
    let svg = chart::figure(title, &caption, Layout::Column, &[(HEIGHT, chart)])?;
    let sources = drawn.iter().rev().map(|name| csv(name)).collect();
    plates.push(Plate { name: "limit_cycle", stage: Stage::Vibration, title: title.into(), caption, sources, svg });
    Ok(())
}

/// The figure of a command; a map of attractors has the cycle itself.
pub(super) fn figure(tables: &BTreeMap<String, Table>) -> Result<Option<Figure>, ReportError> {
    if tables.contains_key("basin") {
        return Ok(None);
    }
    let Some((chart, _)) = portrait(tables, "deterministic limit cycle") else { return Ok(None) };
    let words = Words {
        name: "phase_portrait",
        title: "Phase portrait",
        description: "Displacement and velocity of many trajectories, each for about one period at the end of its time, and the \
                      limit cycle without fluctuation over them. On the flat upper side the mass sticks to the belt.",
    };
    words.figure(Layout::Column, &[(HEIGHT, chart)])
}

/// The chart, and the tables that it shows from below to the top.
fn portrait(tables: &BTreeMap<String, Table>, deterministic: &'static str) -> Option<(Chart, Vec<&'static str>)> {
    let found = |name: &str| columns(tables.get(name)?, ["displacement", "velocity"]);
    let cloud = tables.get("phase_cloud").and_then(|t| columns(t, ["trajectory", "tau", "displacement", "velocity"]));
    let (path, cycle) = (found("trajectory"), found("limit_cycle"));
    let all = [cloud.map(|[_, _, x, y]| [x, y]), path, cycle];
    let x_range = range(all.iter().flatten().flat_map(|curve| curve[0]))?;
    let y_range = range(all.iter().flatten().flat_map(|curve| curve[1]))?;
    let x = Axis::padded("Displacement X = xc/N", Unit::none(), x_range, 0.04);
    let mut chart = Chart::new(x, Axis::padded("Velocity dX/dτ", Unit::none(), y_range, 0.08));
    let mut drawn = Vec::new();
    if let Some(columns) = cloud {
        chart.add("many trajectories", cloud_mark(columns));
        drawn.push("phase_cloud");
    }
    if let Some([x, y]) = path {
        // Over a cloud one trajectory is an example that must be told from it.
        let colour = if cloud.is_some() { PURPLE } else { SKY };
        let pen = Pen { opacity: 0.55, ..Pen::new(colour, 0.9, Dash::Solid) };
        chart.add("one stochastic trajectory", Mark::Line { x: x.to_vec(), y: y.to_vec(), pen });
        drawn.push("trajectory");
    }
    if let Some([x, y]) = cycle {
        let pen = Pen::new(VERMILION, 2.4, Dash::Solid);
        chart.add(deterministic, Mark::Line { x: x.to_vec(), y: y.to_vec(), pen });
        drawn.push("limit_cycle");
    }
    Some((chart, drawn))
}

/// Short curves where points are near each other in time, else the points.
fn cloud_mark([trajectory, tau, x, y]: [&[f64]; 4]) -> Mark {
    let mut steps: Vec<f64> = (1..tau.len())
        .filter(|&i| trajectory[i].to_bits() == trajectory[i - 1].to_bits())
        .map(|i| (tau[i] - tau[i - 1]).abs())
        .filter(|step| step.is_finite())
        .collect();
    steps.sort_by(f64::total_cmp);
    if steps.get(steps.len() / 2).is_some_and(|step| *step <= DENSE) {
        let (x, y) = parted(trajectory, x, y);
        return Mark::Line { x, y, pen: Pen { opacity: 0.22, ..Pen::new(SKY, 0.9, Dash::Solid) } };
    }
    let opacity = (MANY / x.len().max(1) as f64).clamp(0.15, 0.7);
    Mark::Dots { x: x.to_vec(), y: y.to_vec(), radius: 1.3, colour: SKY, opacity }
}
