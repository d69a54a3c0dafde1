//! The sections `[uncertainty]` and `[verdict]`.

use asperity_base::choice;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use toml::Value;

use crate::quantity::Time;

/// The section `[uncertainty]`: dependence of the uncertain values.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct JointSection {
    /// Spearman's rank correlations of pairs of uncertain values, each named `section.key`.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub correlation: Vec<(String, String, f64)>,
    /// Whether the verdict counts what the scans leave uncertain of the surface and of the counterface.
    #[serde(default = "yes")]
    pub surface: bool,
}

/// The section `[verdict]`: the probability of vibration over the uncertain values, and what changes it.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct VerdictSection {
    /// Duration T after which a machine with fluctuating friction must still vibrate; that of `[vibration]` when left out.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub duration: Option<Time>,
    /// Fraction of the time: a machine counts as vibrating if it vibrates longer than this fraction of the second half of the duration.
    #[serde(default = "threshold")]
    pub threshold: f64,
    /// Values to change until the probability reaches the targets; when left out, of uncertain machines whose friction does not fluctuate, the
    /// damping ratio, and the load, or for coupled modes a stated friction coefficient, if no contact needs to be solved for it.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub remedies: Option<Vec<RemedySection>>,
    /// Probabilities to reach.
    #[serde(default = "targets")]
    pub targets: Vec<f64>,
    /// Half width of the 95 % interval of the probability at which sampling stops.
    #[serde(default = "half_width")]
    pub half_width: f64,
    /// Largest number of machines that are evaluated for the probability.
    #[serde(default = "evaluations")]
    pub evaluations: usize,
}

/// Number, or quantity with its unit.
#[derive(JsonSchema)]
#[schemars(untagged)]
#[expect(dead_code, reason = "only its schema is used")]
enum NumberOrQuantity {
    Number(f64),
    Quantity(String),
}

/// Value to change.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct RemedySection {
    /// Name of the value, `section.key`.
    pub input: String,
    /// Range of its central value.
    #[schemars(with = "[NumberOrQuantity; 2]")]
    pub range: [Value; 2],
    /// Damping that stays constant under a change of mass or natural frequency; the damper when left out.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub hold: Option<Hold>,
}

choice! {
    /// Damping that stays constant when mass or natural frequency change.
    #[derive(Default)]
    pub enum Hold: "damping that stays constant" {
        /// The coefficient of the damper, c = 2ζmω₀, in N s/m.
        #[default]
        Damper = "damper",
        /// The damping ratio ζ.
        DampingRatio = "damping_ratio",
    }
}

impl Default for VerdictSection {
    fn default() -> Self {
        Self {
            duration: None,
            threshold: threshold(),
            remedies: None,
            targets: targets(),
            half_width: half_width(),
            evaluations: evaluations(),
        }
    }
}

fn yes() -> bool {
    true
}
fn threshold() -> f64 {
    0.1
}
fn targets() -> Vec<f64> {
    vec![0.05, 0.01]
}
fn half_width() -> f64 {
    0.02
}
fn evaluations() -> usize {
    1 << 16
}
