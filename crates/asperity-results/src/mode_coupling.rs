//! The machine of two modes that friction couples in `results.json`.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use crate::keys::{DAMPING_RATIO, NORMAL_FORCE, STATIC_FRICTION};
use crate::{MotionKind, Pair};

crate::choice! {
    /// Model of the machine.
    #[derive(Default)]
    pub enum MachineModel: "model of the machine" {
        /// One degree of freedom, and friction that depends on the velocity. Its margin is one of the damping ratio, ζ − ζ_v.
        #[default]
        StickSlip = "stick_slip": "stick-slip",
        /// Two degrees of freedom that friction couples. Its margin is one of the friction coefficient, μ_c − μ.
        ModeCoupling = "mode_coupling",
    }
}

impl MachineModel {
    /// Returns the values of a machine whose changes the verdict states where a study states none.
    pub fn usual_changes(self) -> [&'static str; 2] {
        match self {
            Self::StickSlip => [DAMPING_RATIO, NORMAL_FORCE],
            Self::ModeCoupling => [DAMPING_RATIO, STATIC_FRICTION],
        }
    }
}

crate::choice! {
    /// Long-term motion of the machine.
    #[derive(Default)]
    pub enum CoupledMotion: "long-term motion" {
        /// The motion is periodic.
        Cycle = "cycle": "limit cycle",
        /// Steady sliding.
        #[default]
        Steady = "steady": "steady sliding",
        /// The belt carries the mass away (self-locking).
        Locked = "locked": "self-locking",
        /// The motion did not repeat.
        Irregular = "irregular": "not periodic",
    }
}

/// The machine with the mean friction coefficient, without fluctuation. Stiffnesses are in units of mω₀².
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct ModeCouplingResult {
    /// Damping ratio ζ: dampers of 2ζmω₀ along and across the belt.
    pub damping_ratio: f64,
    /// Dimensionless belt velocity V.
    pub belt_velocity: f64,
    /// Mean friction coefficient μ.
    pub friction: f64,
    /// Stiffness k₁₁, k₁₂, k₂₂ in mω₀² of the mass in contact, without friction.
    pub stiffness: [f64; 3],
    /// Stiffness of the contact spring in mω₀².
    pub contact_spring: f64,
    /// Stiffness of the contact spring with its unit.
    pub contact_stiffness_n_per_m: f64,
    /// Friction coefficient at which the undamped modes meet; `null` if friction separates them.
    pub coalescence: Option<f64>,
    /// Least friction coefficient μ_c at which steady sliding is unstable; `null` if it never is.
    pub critical_friction: Option<f64>,
    /// Margin μ_c − μ.
    pub friction_margin: Option<f64>,
    /// Damping ratio that just keeps steady sliding stable; `null` if none does.
    pub limit_damping_ratio: Option<f64>,
    /// Whether steady sliding is unstable.
    pub steady_sliding_unstable: bool,
    /// Kind of the motion: `flutter`, `divergence` or `none`.
    pub kind: MotionKind,
    /// Frequency at which flutter begins at μ_c; `null` without flutter.
    pub onset_frequency_hz: Option<f64>,
    /// Frequencies of the two modes of small motion, the slow one first; 0 without vibration.
    pub mode_frequencies_hz: Pair,
    /// Growth rates of the two modes of small motion.
    pub mode_growth_rates_per_s: Pair,
    /// Long-term motion, started 1 % away from steady sliding; `null` if steady sliding does not exist or is neutral.
    pub motion: Option<CoupledMotion>,
    /// The limit cycle; `null` if there is none.
    pub cycle: Option<CoupledCycleResult>,
}

/// Limit cycle of two coupled modes.
#[derive(Debug, Clone, Copy, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct CoupledCycleResult {
    /// Frequency of the limit cycle.
    pub frequency_hz: f64,
    /// Half the difference of the largest and the smallest velocity along the belt.
    pub velocity_amplitude_m_per_s: f64,
    /// Half the difference of the largest and the smallest displacement along the belt.
    pub displacement_amplitude_m: f64,
    /// Half the difference of the largest and the smallest displacement across the belt.
    pub normal_amplitude_m: f64,
    /// Fraction of the period in stick.
    pub stick_share: f64,
    /// Fraction of the period off the belt.
    pub flight_share: f64,
}
