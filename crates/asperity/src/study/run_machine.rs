//! The machine of a run, to be moved again elsewhere.

use serde::{Deserialize, Serialize};

use crate::friction::process::ProcessModel;
use crate::vibration::{Drive, Parameters};

/// Machine of a run in the variables of the oscillator, with the fluctuation of its friction: the content of `machine.json`.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct RunMachine {
    /// Oscillator at the mean friction.
    pub parameters: Parameters,
    /// Fluctuation under the upscaling of the study; `None` if friction is constant.
    pub process: Option<ProcessModel>,
    /// Unit N/c of the displacement.
    pub length_m: f64,
    /// Unit 1/ω₀ of the time.
    pub time_s: f64,
    /// Variable that the fluctuation follows: path or time.
    pub drive: Drive,
    /// Trajectories of an ensemble.
    pub trajectories: usize,
    /// Duration τ of a trajectory.
    pub duration: f64,
    /// Seed of the study.
    pub seed: u64,
}
