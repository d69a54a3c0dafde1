//! Phase portraits: many trajectories, one trajectory, and the deterministic cycle over them.

use asperity_results::{PhaseCloud, Portrait};

use crate::Run;
use crate::figures::vibration::curves::{Tables, separated};
use crate::figures::{CaptionedFigure, defined};
use crate::format::Unit;
use crate::plot::{Axis, Chart, Dash, Mark, PURPLE, Pen, SKY, VERMILION, range};

/// Points of a cloud that are further apart in τ are drawn as points, closer ones as curves.
const DENSE: f64 = 0.3;
/// Number of points of a cloud that together are about as dark as curves.
const MANY: f64 = 1500.0;

/// Draws the portrait of a run; `None` if every motion ends in steady sliding, where only the noise of friction would be seen.
pub(super) fn of_run(run: &Run) -> Option<CaptionedFigure> {
    let vibration = run.results.vibration.as_ref();
    let settled = vibration.is_some_and(|vibration| !vibration.cycle.limit_cycle);
    let motion = vibration.and_then(|vibration| vibration.of_study().motion.as_ref());
    if settled && motion.is_some_and(|motion| motion.share_in_cycle == 0.0) {
        return None;
    }
    let deterministic = if settled { "deterministic motion (no cycle)" } else { "deterministic limit cycle" };
    let (chart, drawn) = portrait(&run.tables, deterministic)?;
    let cloud = match drawn.contains(&"phase_cloud") {
        true => " The cloud is many trajectories, each for about one period at the end of its time.",
        false => "",
    };
    let caption = format!(
        "Displacement and velocity of the mass (the paper’s Fig. 5a). On the flat upper side the mass sticks to the belt.{cloud}"
    );
    let drawn: Vec<&str> = drawn.into_iter().rev().collect();
    CaptionedFigure::from_charts("limit_cycle", "Phase portrait", caption, 1, &[chart], &drawn)
}

/// Draws the portrait of a command. A map of attractors includes the cycle.
pub(super) fn figure(tables: &Tables) -> Option<CaptionedFigure> {
    let (chart, _) = portrait(tables, "deterministic limit cycle")?;
    let caption = "Displacement and velocity of many trajectories, each for about one period at the end of its time, and the limit \
                   cycle without fluctuation over them. On the flat upper side the mass sticks to the belt.";
    CaptionedFigure::from_charts("phase_portrait", "Phase portrait", caption, 1, &[chart], &[])
}

fn path<'a>(motion: &'a Option<Portrait<'_>>) -> Option<[&'a [f64]; 2]> {
    motion.as_ref().and_then(|motion| defined([&motion.displacement, &motion.velocity]))
}

/// Draws the chart. Also returns its tables from the lowest to the uppermost curve.
fn portrait(tables: &Tables, deterministic: &str) -> Option<(Chart, Vec<&'static str>)> {
    let [trajectory, cycle] = ["trajectory", "limit_cycle"].map(|name| tables.get(name).map(Portrait::of));
    let (trajectory, cycle) = (path(&trajectory), path(&cycle));
    let cloud = tables.get("phase_cloud").map(PhaseCloud::of);
    let cloud = cloud.as_ref().and_then(|of| defined([&of.trajectory, &of.tau, &of.displacement, &of.velocity]));
    let all = [cloud.map(|[_, _, x, y]| [x, y]), trajectory, cycle];
    let x_range = range(all.iter().flatten().flat_map(|curve| curve[0]))?;
    let y_range = range(all.iter().flatten().flat_map(|curve| curve[1]))?;
    let x = Axis::padded("Displacement X = xc/N", Unit::none(), x_range, 0.04);
    let mut chart = Chart::new(x, Axis::padded("Velocity dX/dτ", Unit::none(), y_range, 0.08)).with_height(380.0);
    let mut drawn = Vec::new();
    if let Some(columns) = cloud {
        chart.add("many trajectories", cloud_mark(columns));
        drawn.push("phase_cloud");
    }
    if let Some([x, y]) = trajectory {
        // The trajectory must be distinct from the cloud.
        let colour = if cloud.is_some() { PURPLE } else { SKY };
        let pen = Pen { opacity: 0.55, ..Pen::new(colour, 0.9, Dash::Solid) };
        chart.line("one stochastic trajectory", x, y, pen);
        drawn.push("trajectory");
    }
    if let Some([x, y]) = cycle {
        chart.line(deterministic, x, y, Pen::new(VERMILION, 2.4, Dash::Solid));
        drawn.push("limit_cycle");
    }
    Some((chart, drawn))
}

/// Returns short curves if the points are close to each other in time, otherwise the points.
fn cloud_mark([trajectory, tau, x, y]: [&[f64]; 4]) -> Mark {
    let mut steps: Vec<f64> = (1..tau.len())
        .filter(|&i| trajectory[i].to_bits() == trajectory[i - 1].to_bits())
        .map(|i| (tau[i] - tau[i - 1]).abs())
        .filter(|step| step.is_finite())
        .collect();
    steps.sort_by(f64::total_cmp);
    if steps.get(steps.len() / 2).is_some_and(|step| *step <= DENSE) {
        let (x, y) = separated(trajectory, x, y);
        return Mark::Line { x, y, pen: Pen { opacity: 0.22, ..Pen::new(SKY, 0.9, Dash::Solid) } };
    }
    let opacity = (MANY / x.len().max(1) as f64).clamp(0.15, 0.7);
    Mark::Dots { x: x.to_vec(), y: y.to_vec(), radius: 1.3, colour: SKY, opacity }
}
