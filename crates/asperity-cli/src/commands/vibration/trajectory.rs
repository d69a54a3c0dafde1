//! Trajectory over a recorded friction fluctuation.

use std::path::PathBuf;

use asperity::friction::process::RecordedProcess;
use asperity::vibration::{self, Drive, TrajectorySettings, VibrationError};
use clap::Args;
use serde_json::json;

use super::machine::{Damping, Machine};
use crate::args;
use crate::failure::Failure;
use crate::input::read_failure;
use crate::monitor::Terminal;
use crate::output::Answer;

/// Simulates a trajectory and lists its events: D the mass leaves the belt, R it sticks again, O over-slip begins or
/// ends.
#[derive(Debug, Args)]
pub(crate) struct Trajectory {
    #[command(flatten)]
    machine: Machine,
    #[command(flatten)]
    damping: Damping,
    /// Fluctuation m(0), m(h), m(2h), … of the friction coefficient: a one-dimensional NPY array.
    #[arg(long, value_name = "M.npy")]
    friction_file: PathBuf,
    /// Sliding distance h between its values, dimensionless.
    #[arg(long, value_name = "X", value_parser = args::positive, allow_hyphen_values = true)]
    friction_step: f64,
    /// Duration τ.
    #[arg(long, value_name = "X", value_parser = args::positive, allow_hyphen_values = true)]
    duration: f64,
    /// Displacement X at the start, in stick; 0.97 μ_st − 2ζV when left out.
    #[arg(long, value_name = "X", value_parser = args::number, allow_hyphen_values = true)]
    start: Option<f64>,
    /// Print one JSON object instead of a table.
    #[arg(long)]
    json: bool,
}

impl Trajectory {
    pub(crate) fn run(&self, monitor: &Terminal) -> Result<(), Failure> {
        let oscillator = self.machine.oscillator(self.damping.damping_ratio, monitor)?;
        let values = asperity_formats::read_series(&self.friction_file).map_err(|e| read_failure(&e))?;
        let record = RecordedProcess::new(self.friction_step, values)
            .map_err(|e| Failure::data(self.friction_file.display(), &e))?;
        let (duration, start) = (self.duration, self.start);
        let settings = TrajectorySettings { duration, start, drive: Drive::Distance };
        let simulated = monitor.killable(|| vibration::Trajectory::simulate(&oscillator, record.path(), &settings))?;
        let path = simulated.map_err(|e| match e {
            VibrationError::ProcessTooShort { .. } | VibrationError::FrictionNotPositive { .. } => {
                Failure::data(self.friction_file.display(), &e)
            }
            e => e.into(),
        })?;
        let events: Vec<_> =
            path.events.iter().map(|e| json!([e.kind.code(), e.tau, e.displacement, e.sliding_distance])).collect();
        Answer::default().with("events", events).print(self.json)
    }
}
