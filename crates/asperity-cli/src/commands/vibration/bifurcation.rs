//! The attractors of the machine without fluctuation along a parameter.

use asperity::vibration::{BifurcationSettings, bifurcation_diagram};
use clap::Args;

use super::critical_curve::Over;
use super::{Damping, Machine, refused};
use crate::args;
use crate::failure::Failure;
use crate::monitor::Terminal;
use crate::output::{Answer, columns, print};

/// Follows the attractor up and down a parameter: sliding, cycles and their multiplicity, irregular motion.
#[derive(Debug, Args)]
pub(crate) struct Bifurcation {
    #[command(flatten)]
    machine: Machine,
    #[command(flatten)]
    damping: Damping,
    /// The parameter.
    #[arg(long, value_enum)]
    over: Over,
    /// Least value.
    #[arg(long, value_name = "X", value_parser = args::number, allow_hyphen_values = true)]
    from: f64,
    /// Largest value.
    #[arg(long, value_name = "X", value_parser = args::number, allow_hyphen_values = true)]
    to: f64,
    /// Number of values.
    #[arg(long, value_name = "N", default_value = "101", value_parser = args::count, allow_hyphen_values = true)]
    points: usize,
    /// Print one JSON object instead of a table.
    #[arg(long)]
    json: bool,
}

impl Bifurcation {
    pub(crate) fn run(&self, monitor: &Terminal) -> Result<(), Failure> {
        let oscillator = self.machine.oscillator(self.damping.damping_ratio)?;
        let settings = BifurcationSettings::new([self.from, self.to], self.points);
        let diagram =
            bifurcation_diagram(&oscillator, self.over.parameter(), &settings, monitor).map_err(|e| refused(&e))?;
        if self.json {
            return Answer::of(&diagram)?.print(true);
        }
        let heading = ["way", "parameter", "attractor", "multiplicity", "least velocity", "largest velocity"];
        let mut rows = vec![heading.map(str::to_owned)];
        for (way, points) in [("up", &diagram.upward), ("down", &diagram.downward)] {
            for point in points {
                rows.push([
                    way.to_owned(),
                    format!("{:.8}", point.parameter),
                    format!("{:?}", point.attractor),
                    point.multiplicity.map_or_else(|| "-".to_owned(), |m| m.to_string()),
                    format!("{:.6e}", point.velocity[0]),
                    format!("{:.6e}", point.velocity[1]),
                ]);
            }
        }
        print(&columns(&rows))
    }
}
