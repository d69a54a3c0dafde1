//! Attractors of the machine without fluctuation along a parameter.

use asperity::study::Table;
use asperity::vibration::CurveParameter;
use asperity::vibration::{BifurcationDiagram, BifurcationPoint, BifurcationSettings, MarkKind, bifurcation_diagram};
use asperity_report::VibrationFigures;
use clap::Args;

use super::critical_curve::{check_over, parameter};
use super::folder::Folder;
use super::machine::{Damping, Machine, code};
use crate::args;
use crate::failure::Failure;
use crate::monitor::Terminal;
use crate::output::{Answer, columns, print};
use crate::resources::require_memory;

/// Memory for the motions at one value of the parameter, in bytes; irregular motions store a hundred turns each.
const POINT_BYTES: f64 = 8192.0;

/// Follows the attractor up and down a parameter: steady sliding, cycles and their multiplicity, irregular motion.
#[derive(Debug, Args)]
pub(crate) struct Bifurcation {
    #[command(flatten)]
    machine: Machine,
    #[command(flatten)]
    damping: Damping,
    /// Parameter to vary.
    #[arg(long, value_parser = parameter())]
    over: CurveParameter,
    /// Least value.
    #[arg(long, value_name = "X", value_parser = args::number, allow_hyphen_values = true)]
    from: f64,
    /// Largest value.
    #[arg(long, value_name = "X", value_parser = args::number, allow_hyphen_values = true)]
    to: f64,
    /// Number of values.
    #[arg(long, value_name = "N", default_value = "101", value_parser = args::count, allow_hyphen_values = true)]
    points: usize,
    #[command(flatten)]
    folder: Folder,
    /// Print one JSON object instead of a table.
    #[arg(long)]
    json: bool,
}

impl Bifurcation {
    pub(crate) fn run(&self, monitor: &Terminal) -> Result<(), Failure> {
        let oscillator = self.machine.oscillator(self.damping.damping_ratio, monitor)?;
        check_over(self.over, &oscillator, self.from, self.to)?;
        if self.points < 2 {
            return Err(Failure::usage(format!("--points is {}, but must be at least 2", self.points)));
        }
        require_memory(POINT_BYTES * self.points as f64, "the diagram")?;
        let settings = BifurcationSettings::new([self.from, self.to], self.points);
        let inputs = self.machine.friction.inputs();
        let has_folder = self.folder.is_requested(&inputs)?;
        let diagram = bifurcation_diagram(&oscillator, self.over, &settings, monitor)?;
        if has_folder {
            let figures = VibrationFigures::Bifurcation { parameter: self.over.name().to_owned() };
            self.folder.write(
                "bifurcation",
                &figures,
                &inputs,
                &Answer::new(&diagram)?,
                tables(&diagram, self.over.name()),
                monitor,
            )?;
        }
        if self.json {
            return Answer::new(&diagram)?.print(true);
        }
        let heading = ["way", "parameter", "attractor", "multiplicity", "least velocity", "largest velocity"];
        let mut rows = vec![heading.map(str::to_owned)];
        for (way, points) in [("up", &diagram.upward), ("down", &diagram.downward)] {
            for point in points {
                rows.push([
                    way.to_owned(),
                    format!("{:.8}", point.parameter),
                    point.attractor.to_string(),
                    match point.multiplicity {
                        Some(multiplicity) => multiplicity.to_string(),
                        None if point.settled => "irregular".to_owned(),
                        None => "not settled".to_owned(),
                    },
                    format!("{:.6e}", point.velocity[0]),
                    format!("{:.6e}", point.velocity[1]),
                ]);
            }
        }
        print(&columns(&rows))
    }
}

/// Returns the tables: attractors in both directions, marks, and the turns of motions that have several in a period.
fn tables(diagram: &BifurcationDiagram, parameter: &str) -> Vec<(&'static str, Table)> {
    let marks = |kind: MarkKind| {
        let value = move |mark: &asperity::vibration::Mark| if mark.kind == kind { mark.parameter } else { f64::NAN };
        diagram.marks.iter().map(value).collect::<Vec<f64>>()
    };
    let mut tables = vec![
        ("bifurcation_up", attractors(&diagram.upward, parameter)),
        ("bifurcation_down", attractors(&diagram.downward, parameter)),
        (
            "bifurcation_marks",
            Table::new([
                ("hopf", marks(MarkKind::Hopf)),
                ("fold", marks(MarkKind::Fold)),
                ("locked_fold", marks(MarkKind::LockedFold)),
            ]),
        ),
    ];
    let ways = [(0.0, &diagram.upward), (1.0, &diagram.downward)];
    if ways.iter().any(|(_, points)| points.iter().any(|point| point.turnovers.len() > 1)) {
        tables.push(("bifurcation_turnovers", turnovers(&ways, parameter)));
    }
    tables
}

fn attractors(points: &[BifurcationPoint], parameter: &str) -> Table {
    let column = |of: fn(&BifurcationPoint) -> f64| points.iter().map(of).collect::<Vec<f64>>();
    Table::new([
        (parameter, column(|p| p.parameter)),
        ("attractor", column(|p| code(p.attractor))),
        ("multiplicity", column(|p| p.multiplicity.map_or(f64::NAN, |m| m as f64))),
        ("settled", column(|p| f64::from(u8::from(p.settled)))),
        ("velocity_min", column(|p| p.velocity[0])),
        ("velocity_max", column(|p| p.velocity[1])),
        ("displacement_min", column(|p| p.displacement[0])),
        ("displacement_max", column(|p| p.displacement[1])),
    ])
}

/// Tabulates every turn in both directions, up (0) and down (1).
fn turnovers(ways: &[(f64, &Vec<BifurcationPoint>)], parameter: &str) -> Table {
    let mut columns = [(); 5].map(|()| Vec::new());
    for (way, points) in ways {
        for point in *points {
            for turn in &point.turnovers {
                let back = turn.reattachment_displacement.unwrap_or(f64::NAN);
                let row = [*way, point.parameter, turn.duration, back, turn.velocity_min];
                columns.iter_mut().zip(row).for_each(|(column, value)| column.push(value));
            }
        }
    }
    Table::new(["way", parameter, "duration", "reattachment_displacement", "velocity_min"].into_iter().zip(columns))
}
