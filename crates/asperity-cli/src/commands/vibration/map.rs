//! Probability of sustained vibration over two parameters.

use asperity::friction::process::FrictionProcess;
use asperity::study::{map_result, stability_map_tables};
use asperity::vibration::{MapAxis, MapOver, MapResolution, MapSettings, stability_map};
use asperity_report::VibrationFigures;
use clap::Args;

use super::folder::Folder;
use super::machine::{Damping, Machine};
use super::random::{Clipping, Fluctuation, Trajectories, note_time};
use crate::args;
use crate::failure::Failure;
use crate::monitor::Terminal;
use crate::output::{Answer, columns, print};

/// Maps the probability of sustained vibration: over damping and belt velocity, damping and standard deviation of
/// friction, or belt velocity and load.
#[derive(Debug, Args)]
pub(crate) struct Map {
    #[command(flatten)]
    machine: Machine,
    #[command(flatten)]
    damping: Damping,
    /// Standard deviation of the friction coefficient.
    #[arg(long, value_name = "X", value_parser = args::positive, allow_hyphen_values = true)]
    friction_std: f64,
    #[command(flatten)]
    fluctuation: Fluctuation,
    #[command(flatten)]
    clipping: Clipping,
    /// Damping ratios, the first axis: least, largest, cells of the first grid.
    #[arg(long, value_name = "FROM,TO,N", value_parser = axis, required_unless_present = "loads")]
    damping_ratios: Option<MapAxis>,
    /// Belt velocities: the second axis, or the first axis of a map over loads.
    #[arg(long, value_name = "FROM,TO,N", value_parser = axis, conflicts_with = "friction_stds")]
    belt_velocities: Option<MapAxis>,
    /// Standard deviations of friction, the second axis.
    #[arg(long, value_name = "FROM,TO,N", value_parser = axis, conflicts_with = "loads")]
    friction_stds: Option<MapAxis>,
    /// Ratios of the load to the stated machine's load, the second axis; lengths and velocities are in units of the
    /// load.
    #[arg(long, value_name = "FROM,TO,N", value_parser = axis, requires = "belt_velocities",
          conflicts_with = "damping_ratios")]
    loads: Option<MapAxis>,
    /// Number of times that cells at the front are halved. If the probability falls from 95 % to 5 % within one of the
    /// smallest cells, the width of the transition is not resolved and only the contour of 50 % is drawn.
    #[arg(long, value_name = "N", default_value = "3", value_parser = depth)]
    depth: u32,
    #[command(flatten)]
    trajectories: Trajectories,
    #[command(flatten)]
    folder: Folder,
    /// Print one JSON object instead of the contours.
    #[arg(long)]
    json: bool,
}

fn axis(text: &str) -> Result<MapAxis, String> {
    axis_range(text)?.check().map_err(|reason| format!("found `{text}`: {reason}"))
}

/// Parses FROM,TO,N: a rising range and its number of cells.
pub(super) fn axis_range(text: &str) -> Result<MapAxis, String> {
    let parts: Vec<&str> = text.split(',').map(str::trim).collect();
    let message =
        || format!("found `{text}`, expected the least and the largest value and a number of cells: FROM,TO,N");
    let [from, to, cells] = parts[..] else { return Err(message()) };
    match (from.parse::<f64>(), to.parse::<f64>(), cells.parse::<usize>()) {
        (Ok(from), Ok(to), Ok(cells)) if from < to && cells > 0 => Ok(MapAxis { from, to, cells }),
        (Ok(_), Ok(_), Ok(0)) => Err(format!("found `{text}`, expected at least 1 cell")),
        (Ok(_), Ok(_), Ok(_)) => Err(format!("found `{text}`, expected a last value above the first")),
        _ => Err(message()),
    }
}

fn depth(text: &str) -> Result<u32, String> {
    match text.parse() {
        Ok(depth @ 0..=8) => Ok(depth),
        _ => Err(format!("found `{text}`, expected a whole number from 0 to 8")),
    }
}

impl Map {
    pub(crate) fn run(&self, monitor: &Terminal) -> Result<(), Failure> {
        let stated = self.machine.oscillator(self.damping.damping_ratio, monitor)?;
        let (over, x, y) = match (self.damping_ratios, self.belt_velocities, self.friction_stds, self.loads) {
            (Some(x), Some(y), None, None) => (MapOver::DampingVelocity, x, y),
            (Some(x), None, Some(y), None) => (MapOver::DampingStd, x, y),
            (None, Some(x), None, Some(y)) => (MapOver::VelocityLoad, x, y),
            _ => {
                let message = "the map needs two axes: --damping-ratios with --belt-velocities or --friction-stds, or \
                              --belt-velocities with --loads";
                return Err(Failure::usage(message));
            }
        };
        // Points of the first grid only: refined points hardly change the order of magnitude.
        let belt_velocity = match over {
            MapOver::DampingStd => stated.belt_velocity(),
            MapOver::DampingVelocity => 0.5 * (y.from + y.to),
            MapOver::VelocityLoad => 0.5 * (x.from + x.to),
        };
        // Check the process once, so that an invalid distribution gives an error about the flag and not about a point.
        let friction = self.fluctuation.model(self.friction_std, 1.0);
        let process = monitor.killable(|| FrictionProcess::new(friction.clone()))?.map_err(Failure::usage)?;
        let ensemble = self.trajectories.settings();
        let count = ensemble.trajectories.saturating_mul(x.cells + 1).saturating_mul(y.cells + 1);
        note_time(&process, belt_velocity * ensemble.duration, count, monitor);
        let settings = MapSettings { x, y, depth: self.depth, ensemble };
        let clipped = settings.clipped_fraction(over, &stated, &friction)?;
        self.clipping.accept(clipped, monitor)?;
        let machine = |x: f64, y: f64| {
            let (oscillator, model) = over.machine(&stated, &friction, [x, y])?;
            Ok((oscillator, model.map(FrictionProcess::new).transpose()?))
        };
        let inputs = self.machine.friction.inputs();
        let has_folder = self.folder.is_requested(&inputs)?;
        let map = stability_map(&machine, &settings, monitor)?;
        let names = over.axes();
        let MapResolution { x, y, unresolved_share } = map.resolution;
        if unresolved_share > 0.0 {
            monitor.warn(&format!(
                "along {:.0} % of the front the probability falls from 95 % to 5 % within one cell of {x:.2e} × {y:.2e} ({} × {}): the \
                 transition is narrower than that, and only the contour of 50 % is given there; a larger --depth has smaller cells",
                100.0 * unresolved_share,
                names[0],
                names[1]
            ));
        }
        if has_folder || self.json {
            let answer = Answer::default().with("x", names[0]).with("y", names[1]).and(Answer::new(&map)?);
            let answer = answer.with("clipped_fraction", clipped);
            if has_folder {
                let figures = VibrationFigures::Map(map_result(&map, names));
                self.folder.write("map", &figures, &inputs, &answer, stability_map_tables(&map, names), monitor)?;
            }
            if self.json {
                return answer.print(true);
            }
        }
        let mut rows = vec![["level", names[0], names[1]].map(str::to_owned)];
        let contours = map.contours.iter().map(|c| (format!("{} %", 100.0 * c.level), &c.lines));
        for (level, lines) in contours.chain([("without fluctuation".to_owned(), &map.limit)]) {
            for [x, y] in lines.iter().flatten() {
                rows.push([level.clone(), format!("{x:.6}"), format!("{y:.6}")]);
            }
        }
        print(&columns(&rows))
    }
}
