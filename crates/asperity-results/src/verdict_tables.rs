//! Tables of numbers in the verdict.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use crate::Pair;

/// Probability of vibration if a number of independent windows share the load.
#[derive(Debug, Clone, Copy, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct AreaAsOne {
    /// Number of windows: 1 is the paper's reading, the last is the nominal area over the area of one window.
    pub windows: f64,
    /// Standard deviation of the friction coefficient along the path and between the parts of a rough slider, of the machine with all values
    /// at their centres.
    pub friction_std: f64,
    /// Probability that a machine vibrates whose motion begins in stick.
    pub probability: f64,
    /// Its 95 % interval: the error of the sample.
    pub probability_interval: Pair,
}

/// Probability of vibration over the central values of two inputs.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct ProbabilityMap {
    /// First input.
    pub x: ProbabilityMapAxis,
    /// Second input.
    pub y: ProbabilityMapAxis,
    /// Probability that a machine vibrates whose motion begins in stick: one row per value of `y`, one column per value of `x`.
    pub probability: Vec<Vec<f64>>,
    /// Whether the friction of the study fluctuates. The map is that of its mean, without fluctuation.
    pub leaves_out_fluctuation: bool,
}

/// One input of a map.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct ProbabilityMapAxis {
    /// Name of the value, `section.key`.
    pub input: String,
    /// SI unit of the value; empty for a number.
    pub unit: String,
    /// Central values.
    pub values: Vec<f64>,
}
