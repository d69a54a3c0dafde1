//! The section `[vibration]`.

use std::error::Error;
use std::fmt;
use std::path::PathBuf;

use asperity_base::choice::ByName;
use asperity_results::keys::KEYS;
use schemars::JsonSchema;
use serde::{Deserialize, Deserializer, Serialize, Serializer, de};
use toml::Table;

use super::mode_coupling::{ContactSpring, MachineModel};
use crate::friction::Upscaling;
use crate::friction::process::Generator;
use crate::quantity::{AngularFrequency, Area, Force, InverseVelocity, Length, Mass, Velocity};
use crate::study::sentence;
use crate::vibration::law::VelocityLawKind;
use crate::vibration::{Drive, MapOver};

/// Stribeck coefficient a of μ_k/(1 + a|v|): a number or a quantity such as `"0.13 s/m"`.
#[derive(Debug, Clone, Copy, PartialEq, JsonSchema)]
#[schemars(untagged)]
pub enum Stribeck {
    /// Coefficient per unit of dimensionless velocity, N/(mω₀); valid for the stated load, mass and frequency.
    Dimensionless(f64),
    /// Coefficient per unit of velocity; valid for every load, mass and frequency.
    Physical(InverseVelocity),
}

impl Stribeck {
    /// Returns the coefficient per unit of velocity N/(mω₀).
    pub fn per_unit(self, velocity_m_per_s: f64) -> f64 {
        match self {
            Self::Dimensionless(value) => value,
            Self::Physical(value) => value.0 * velocity_m_per_s,
        }
    }

    /// Returns the coefficient in s/m, given the unit of velocity N/(mω₀).
    pub fn s_per_m(self, velocity_m_per_s: f64) -> f64 {
        match self {
            Self::Dimensionless(value) => value / velocity_m_per_s,
            Self::Physical(value) => value.0,
        }
    }
}

impl From<Stribeck> for f64 {
    /// Returns the number as stated, in s/m for a quantity.
    fn from(coefficient: Stribeck) -> Self {
        match coefficient {
            Stribeck::Dimensionless(value) | Stribeck::Physical(InverseVelocity(value)) => value,
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

/// The section `[vibration.map]`: probability of sustained vibration over two parameters, with the main upscaling.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct MapSection {
    /// Parameters of the map.
    pub over: MapOver,
    /// First axis: from, to, cells of the first grid.
    pub x: (f64, f64, usize),
    /// Second axis: from, to, cells of the first grid.
    pub y: (f64, f64, usize),
    /// Number of times that cells at the front are halved.
    #[serde(default = "map_depth")]
    pub depth: u32,
    /// Number of trajectories per point.
    #[serde(default = "trajectories")]
    pub trajectories: usize,
}

/// Declares the section with the inputs of the velocity laws between two lists of keys.
macro_rules! section {
    (
        {
            $(#[$about:meta])*
            pub struct $section:ident { $($(#[$of_first:meta])* pub $first:ident: $first_type:ty,)* }
            { $($(#[$of_last:meta])* pub $last:ident: $last_type:ty,)* }
        }
        $($name:ident: $type:ty, $doc:tt; $([$($facts:tt)*])+)*
    ) => {
        $(#[$about])*
        pub struct $section {
            $($(#[$of_first])* pub $first: $first_type,)*
            $(#[doc = $doc] #[serde(skip_serializing_if = "Option::is_none")] pub $name: Option<$type>,)*
            $($(#[$of_last])* pub $last: $last_type,)*
        }

        impl $section {
            /// Names of all keys.
            const KEYS: &[&str] = &[$(stringify!($first),)* $(stringify!($name),)* $(stringify!($last),)*];
        }
    };
}

asperity_results::velocity_law_keys! { [section] {
/// The section `[vibration]`.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct VibrationSection {
    /// Model of the machine.
    #[serde(default, skip_serializing_if = "is_usual")]
    pub model: MachineModel,
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
    /// Velocity of the belt as V = v_b m ω₀/N.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub dimensionless_belt_velocity: Option<f64>,
    /// Directions of the two inclined springs of `mode_coupling` in degrees, from the belt's velocity towards the belt.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub spring_angles: Option<[f64; 2]>,
    /// Stiffnesses of these springs in units of mω₀².
    #[serde(skip_serializing_if = "Option::is_none")]
    pub springs: Option<[f64; 2]>,
    /// Stiffness of the contact spring of `mode_coupling` in units of mω₀², or `"surface"`.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub contact_spring: Option<ContactSpring>,
    /// Harmonic force on the mass.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub forcing: Option<Force>,
    /// Angular frequency of the harmonic force.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub forcing_frequency: Option<AngularFrequency>,
    /// Ratio of the kinetic friction coefficient at vanishing velocity to the static one.
    #[serde(default = "kinetic_share")]
    pub kinetic_share: f64,
    /// Dependence of friction on the velocity.
    #[serde(default)]
    pub velocity_law: VelocityLawKind,
} {
    /// Points (velocity, coefficient) of a friction law, from velocity 0 on; constant beyond the last. Coefficients count relative to the
    /// first, which stands for the kinetic friction coefficient.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub friction_table: Option<Vec<(Velocity, f64)>>,
    /// Generator of the fluctuation. When left out, the generator of the fitted process, or else the recursion if it
    /// reproduces the correlation.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub generator: Option<ByName<Generator>>,
    /// Argument of the fluctuation.
    #[serde(default)]
    pub drive: Drive,
    /// Upscaling that the report shows first; both are computed.
    #[serde(default)]
    pub upscaling: Upscaling,
    /// Friction level, as a percentile of `[friction]`; when left out, the level solved at N/nominal_area.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub level: Option<f64>,
    /// Whether more than 5 % of the friction values may be clipped to stay positive.
    #[serde(default, skip_serializing_if = "std::ops::Not::not")]
    pub allow_clipping: bool,
    /// Damping ratios: from, to, count.
    #[serde(default = "damping_sweep")]
    pub damping_sweep: (f64, f64, usize),
    /// Number of trajectories per damping ratio.
    #[serde(default = "trajectories")]
    pub trajectories: usize,
    /// Dimensionless duration ω₀t of a trajectory.
    #[serde(default = "duration")]
    pub duration: f64,
    /// A stability map.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub map: Option<MapSection>,
    /// File of a fitted process, relative to the study file, for studies without a friction stage: the `friction_process.json` of
    /// another study, or the fit of a measured record. If it has a Stribeck coefficient, this replaces `stribeck`.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub friction_process: Option<PathBuf>,
    /// Mean (static) friction coefficient, for studies without a friction stage.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub static_friction: Option<f64>,
    /// Standard deviation of the friction of one window, for studies without a friction stage.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub friction_std: Option<f64>,
    /// Correlation length of the friction of one window, for studies without a friction stage.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub friction_correlation_length: Option<Length>,
    /// Marginal distribution of the friction coefficient, for studies without a friction stage.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub friction_marginal: Option<String>,
} } }

fn is_usual(model: &MachineModel) -> bool {
    *model == MachineModel::default()
}

impl VibrationSection {
    /// Returns the keys of one degree of freedom alone that do not have their default values, but for the numbers of the velocity law.
    pub(in crate::study) fn unusual_keys(&self) -> Result<Vec<&'static str>, Box<dyn Error>> {
        let own = Table::try_from(self)?;
        let is_of_both = |name: &str| {
            let mut rows = KEYS.iter().filter(|key| (key.section, key.name) == ("vibration", name));
            matches!(name, "level" | "friction_marginal")
                || rows.any(|key| key.default.is_none() || key.needs.is_some())
        };
        let of_both: Table = own.clone().into_iter().filter(|(name, _)| is_of_both(name)).collect();
        let usual = Table::try_from(of_both.try_into::<Self>()?)?;
        Ok(Self::KEYS.iter().copied().filter(|name| own.get(*name) != usual.get(*name)).collect())
    }
}

fn map_depth() -> u32 {
    3
}
fn kinetic_share() -> f64 {
    asperity_results::keys::KINETIC_SHARE
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
