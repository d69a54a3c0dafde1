//! `[vibration]`.

use std::fmt;
use std::path::PathBuf;

use asperity_base::choice;
use asperity_base::choice::ByName;
use serde::{Deserialize, Deserializer, Serialize, Serializer, de};

use crate::friction::process::Generator;
use crate::quantity::{AngularFrequency, Area, Force, InverseVelocity, Length, Mass, Velocity};
use crate::study::sentence;
use crate::vibration::{Drive, MapOver, Method};

/// The paper's coefficient a, where none is stated.
const USUAL_STRIBECK: f64 = 4.2;

/// Stribeck coefficient a of μ_k/(1 + a|v|): a number or a quantity such as `"0.13 s/m"`.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Stribeck {
    /// Per unit of dimensionless velocity, N/(mω₀); it belongs to the stated load, mass and frequency.
    Dimensionless(f64),
    /// Per unit of velocity; it holds for every load, mass and frequency.
    Physical(InverseVelocity),
}

impl Stribeck {
    /// The coefficient for the unit of velocity N/(mω₀).
    pub fn per_unit(self, velocity_m_per_s: f64) -> f64 {
        match self {
            Self::Dimensionless(value) => value,
            Self::Physical(value) => value.0 * velocity_m_per_s,
        }
    }

    /// The coefficient in s/m, given the unit of velocity N/(mω₀).
    pub fn s_per_m(self, velocity_m_per_s: f64) -> f64 {
        match self {
            Self::Dimensionless(value) => value / velocity_m_per_s,
            Self::Physical(value) => value.0,
        }
    }

    /// The number as it is stated.
    pub(in crate::study) fn value(self) -> f64 {
        match self {
            Self::Dimensionless(value) | Self::Physical(InverseVelocity(value)) => value,
        }
    }
}

impl fmt::Display for Stribeck {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Dimensionless(value) => f.write_str(&sentence::digits(*value)),
            Self::Physical(value) => value.fmt(f),
        }
    }
}

impl Serialize for Stribeck {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        match self {
            Self::Dimensionless(value) => serializer.serialize_f64(*value),
            Self::Physical(value) => value.serialize(serializer),
        }
    }
}

impl<'de> Deserialize<'de> for Stribeck {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        struct Visitor;
        impl de::Visitor<'_> for Visitor {
            type Value = Stribeck;

            fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
                f.write_str("a number per unit of dimensionless velocity, or an inverse velocity such as \"0.13 s/m\"")
            }

            fn visit_f64<E: de::Error>(self, value: f64) -> Result<Stribeck, E> {
                Ok(Stribeck::Dimensionless(value))
            }

            fn visit_i64<E: de::Error>(self, value: i64) -> Result<Stribeck, E> {
                Ok(Stribeck::Dimensionless(value as f64))
            }

            fn visit_u64<E: de::Error>(self, value: u64) -> Result<Stribeck, E> {
                Ok(Stribeck::Dimensionless(value as f64))
            }

            fn visit_str<E: de::Error>(self, text: &str) -> Result<Stribeck, E> {
                text.parse().map(Stribeck::Physical).map_err(E::custom)
            }
        }
        deserializer.deserialize_any(Visitor)
    }
}

choice! {
    /// Dependence of friction on the sliding velocity.
    #[derive(Default)]
    pub enum VelocityLaw: "velocity law" {
        /// μ_k/(1 + a|v|) with `stribeck` a, the paper's.
        #[default]
        Stribeck = "stribeck",
        /// μ_k − b|v| with `linear_weakening` b.
        Linear = "linear",
        /// μ_∞ + (μ_k − μ_∞)e^{−|v|/v₀} with `stribeck_velocity` v₀ and `high_speed_share` μ_∞/μ_k.
        Exponential = "exponential",
    }
}

choice! {
    /// Relation of the scatter over the nominal area to that of one window.
    #[derive(Default)]
    pub enum Upscaling: "upscaling" {
        /// Windows average over the nominal area.
        #[default]
        Area = "area",
        /// One window carries the whole normal force (the paper's reading).
        Paper = "paper",
    }
}

/// `[vibration.map]`: the probability of sustained vibration over two parameters, under the leading upscaling.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct MapSection {
    /// The parameters.
    pub over: MapOver,
    /// First axis: from, to, cells of the first grid.
    pub x: (f64, f64, usize),
    /// Second axis.
    pub y: (f64, f64, usize),
    /// How often cells at the front are halved.
    #[serde(default = "map_depth")]
    pub depth: u32,
    /// Trajectories at a point.
    #[serde(default = "trajectories")]
    pub trajectories: usize,
}

/// `[vibration]`.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct VibrationSection {
    /// Mass m.
    pub mass: Mass,
    /// Natural angular frequency ω₀ = √(c/m).
    pub natural_frequency: AngularFrequency,
    /// Damping ratio ζ = d/(2mω₀).
    pub damping_ratio: f64,
    /// Normal force N.
    pub normal_force: Force,
    /// Area that carries the normal force.
    pub nominal_area: Area,
    /// Velocity of the belt.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub belt_velocity: Option<Velocity>,
    /// The same as V = v_b m ω₀/N.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub dimensionless_belt_velocity: Option<f64>,
    /// Harmonic force on the mass.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub forcing: Option<Force>,
    /// Its angular frequency.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub forcing_frequency: Option<AngularFrequency>,
    /// Kinetic friction coefficient at vanishing velocity over the static one.
    #[serde(default = "one")]
    pub kinetic_share: f64,
    /// How friction falls with the velocity.
    #[serde(default)]
    pub velocity_law: VelocityLaw,
    /// Stribeck coefficient a of μ_k/(1 + a|v|), per unit of dimensionless velocity or in s/m; 4.2 when left out.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub stribeck: Option<Stribeck>,
    /// Slope b of the linear law, per unit of dimensionless velocity.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub linear_weakening: Option<f64>,
    /// Velocity v₀ of the exponential law.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub stribeck_velocity: Option<Velocity>,
    /// Friction coefficient at high velocity over the kinetic one, of the exponential law.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub high_speed_share: Option<f64>,
    /// How the fluctuation is made; left out, that of a fitted process, or else the recursion where it makes the correlation.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub generator: Option<ByName<Generator>>,
    /// What the fluctuation is a function of.
    #[serde(default)]
    pub drive: Drive,
    /// How slip is integrated.
    #[serde(default)]
    pub integrator: ByName<Method>,
    /// Which upscaling the report leads with; both are computed.
    #[serde(default)]
    pub upscaling: Upscaling,
    /// Friction level, as a percentile of `[friction]`; without it, the one solved at N/nominal_area.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub level: Option<f64>,
    /// Whether more than 5 % of the friction values may be clipped to stay positive.
    #[serde(default, skip_serializing_if = "std::ops::Not::not")]
    pub allow_clipping: bool,
    /// Damping ratios: from, to, count.
    #[serde(default = "damping_sweep")]
    pub damping_sweep: (f64, f64, usize),
    /// Trajectories per damping ratio.
    #[serde(default = "trajectories")]
    pub trajectories: usize,
    /// Dimensionless duration ω₀t of a trajectory.
    #[serde(default = "duration")]
    pub duration: f64,
    /// A stability map.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub map: Option<MapSection>,
    /// A fitted process ([`crate::friction::process::FittedProcess`]), relative to the study file, when there is no friction
    /// stage: the `friction_process.json` of another study, or of a measured record. Its Stribeck coefficient, if it has one,
    /// takes the place of `stribeck`.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub friction_process: Option<PathBuf>,
    /// Mean (static) friction coefficient, when there is no friction stage.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub static_friction: Option<f64>,
    /// Standard deviation of the friction of one window, when there is no friction stage.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub friction_std: Option<f64>,
    /// Correlation length of the friction of one window, when there is no friction stage.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub friction_correlation_length: Option<Length>,
    /// Marginal law of the friction coefficient, when there is no friction stage.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub friction_marginal: Option<String>,
}

impl VibrationSection {
    /// Returns the Stribeck coefficient, stated or usual, if the law has one.
    pub(in crate::study) fn stribeck(&self) -> Option<Stribeck> {
        let usual = Stribeck::Dimensionless(USUAL_STRIBECK);
        (self.velocity_law == VelocityLaw::Stribeck).then(|| self.stribeck.unwrap_or(usual))
    }
}

fn map_depth() -> u32 {
    3
}
fn one() -> f64 {
    1.0
}

fn damping_sweep() -> (f64, f64, usize) {
    (0.05, 0.30, 11)
}
fn trajectories() -> usize {
    200
}
fn duration() -> f64 {
    640.0
}
