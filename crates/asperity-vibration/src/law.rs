//! Velocity laws: the friction coefficient as a function of the relative velocity.

use serde::{Deserialize, Serialize};

use super::{FrictionTable, VibrationError, positive};
use asperity_base::sentence::digits;

/// Kinetic friction coefficient μ(|v|) of a sliding contact, at the dimensionless relative velocity v = v_rel·mω₀/N.
///
/// The stick limit is a separate parameter, [`super::Oscillator::static_friction`].
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case", deny_unknown_fields)]
pub enum VelocityLaw {
    /// Velocity weakening μ = μ_k/(1 + a|v|), the law of Gaus et al. 2016 (there μ_k is the static coefficient).
    Stribeck {
        /// μ_k, the coefficient at vanishing sliding velocity.
        kinetic: f64,
        /// a ≥ 0, per unit of dimensionless velocity.
        decay: f64,
    },
    /// Constant coefficient.
    Coulomb {
        /// μ_k.
        kinetic: f64,
    },
    /// Linear weakening μ = μ_k − b|v|. The law is invalid from |v| = μ_k/b on, which is reported as an error.
    Linear {
        /// μ_k, the coefficient at vanishing sliding velocity.
        kinetic: f64,
        /// b ≥ 0, per unit of dimensionless velocity.
        slope: f64,
    },
    /// Exponential weakening μ = μ_∞ + (μ_k − μ_∞)e^{−|v|/v_0}.
    Exponential {
        /// μ_k, the coefficient at vanishing sliding velocity.
        kinetic: f64,
        /// 0 < μ_∞ ≤ μ_k, the coefficient at high velocity.
        high_speed: f64,
        /// v_0 > 0, the Stribeck velocity.
        stribeck_velocity: f64,
    },
    /// Monotone cubics between given points.
    Tabulated(FrictionTable),
}

impl VelocityLaw {
    /// Returns the coefficient at the speed |v| ≥ 0.
    pub fn coefficient(&self, speed: f64) -> f64 {
        match self {
            Self::Stribeck { kinetic, decay } => kinetic / (1.0 + decay * speed),
            Self::Coulomb { kinetic } => *kinetic,
            Self::Linear { kinetic, slope } => kinetic - slope * speed,
            Self::Exponential { kinetic, high_speed, stribeck_velocity } => {
                high_speed + (kinetic - high_speed) * (-speed / stribeck_velocity).exp()
            }
            Self::Tabulated(table) => table.coefficient(speed),
        }
    }

    /// Returns the weakening rate −dμ/d|v| at the speed |v| ≥ 0; at the last point of a table, the rate beyond it.
    pub fn weakening(&self, speed: f64) -> f64 {
        match self {
            Self::Stribeck { kinetic, decay } => kinetic * decay / (1.0 + decay * speed).powi(2),
            Self::Coulomb { .. } => 0.0,
            Self::Linear { slope, .. } => *slope,
            Self::Exponential { kinetic, high_speed, stribeck_velocity } => {
                (kinetic - high_speed) / stribeck_velocity * (-speed / stribeck_velocity).exp()
            }
            Self::Tabulated(table) => table.weakening(speed),
        }
    }

    /// Returns the law μ(f|v|), f > 0. It is the same law in SI when the unit of velocity N/(mω₀) grows by the factor
    /// f, for example under another load.
    pub(super) fn rescaled(&self, factor: f64) -> Self {
        match self {
            Self::Stribeck { kinetic, decay } => Self::Stribeck { kinetic: *kinetic, decay: decay * factor },
            Self::Coulomb { kinetic } => Self::Coulomb { kinetic: *kinetic },
            Self::Linear { kinetic, slope } => Self::Linear { kinetic: *kinetic, slope: slope * factor },
            Self::Exponential { kinetic, high_speed, stribeck_velocity } => Self::Exponential {
                kinetic: *kinetic,
                high_speed: *high_speed,
                stribeck_velocity: stribeck_velocity / factor,
            },
            Self::Tabulated(table) => Self::Tabulated(table.rescaled(factor)),
        }
    }

    /// Returns the coefficient at vanishing sliding velocity, μ_k.
    pub fn kinetic(&self) -> f64 {
        match self {
            Self::Stribeck { kinetic, .. }
            | Self::Coulomb { kinetic }
            | Self::Linear { kinetic, .. }
            | Self::Exponential { kinetic, .. } => *kinetic,
            Self::Tabulated(table) => table.kinetic(),
        }
    }

    /// Returns the weakening rate as a parameter: a of the Stribeck law, b of the linear law; `None` for other laws.
    pub fn weakening_rate(&self) -> Option<f64> {
        match self {
            Self::Stribeck { decay: rate, .. } | Self::Linear { slope: rate, .. } => Some(*rate),
            Self::Coulomb { .. } | Self::Exponential { .. } | Self::Tabulated(_) => None,
        }
    }

    /// Returns the law with another weakening rate; `None` for laws without one.
    pub fn with_weakening_rate(&self, rate: f64) -> Option<Self> {
        match *self {
            Self::Stribeck { kinetic, .. } => Some(Self::Stribeck { kinetic, decay: rate }),
            Self::Linear { kinetic, .. } => Some(Self::Linear { kinetic, slope: rate }),
            Self::Coulomb { .. } | Self::Exponential { .. } | Self::Tabulated(_) => None,
        }
    }

    /// Returns the law with `map` applied to its friction coefficients. Weakening rates and velocities stay equal.
    ///
    /// # Errors
    /// A table with these coefficients is invalid.
    pub fn with_coefficients(&self, map: impl Fn(f64) -> f64) -> Result<Self, VibrationError> {
        Ok(match self {
            Self::Stribeck { kinetic, decay } => Self::Stribeck { kinetic: map(*kinetic), decay: *decay },
            Self::Coulomb { kinetic } => Self::Coulomb { kinetic: map(*kinetic) },
            Self::Linear { kinetic, slope } => Self::Linear { kinetic: map(*kinetic), slope: *slope },
            Self::Exponential { kinetic, high_speed, stribeck_velocity } => Self::Exponential {
                kinetic: map(*kinetic),
                high_speed: map(*high_speed),
                stribeck_velocity: *stribeck_velocity,
            },
            Self::Tabulated(table) => {
                let points: Vec<[f64; 2]> = table.points().map(|[v, mu]| [v, map(mu)]).collect();
                Self::Tabulated(FrictionTable::new(&points)?)
            }
        })
    }

    /// Describes the law with its parameters.
    pub fn describe(&self) -> String {
        match self {
            Self::Coulomb { kinetic } => digits(*kinetic),
            Self::Stribeck { kinetic, decay } => {
                format!("{}/(1 + a|v|), a = {} per unit of dimensionless velocity,", digits(*kinetic), digits(*decay))
            }
            Self::Linear { kinetic, slope } => {
                format!("{} − b|v|, b = {} per unit of dimensionless velocity,", digits(*kinetic), digits(*slope))
            }
            Self::Exponential { kinetic, high_speed, stribeck_velocity } => format!(
                "{} + {}·exp(−|v|/{})",
                digits(*high_speed),
                digits(kinetic - high_speed),
                digits(*stribeck_velocity)
            ),
            Self::Tabulated(_) => "a tabulated law".into(),
        }
    }

    /// Returns [c, b] such that friction with a fluctuation m ≤ 0 is positive at the speed |v| if c + m > |v|(b − am), with a of
    /// the Stribeck law and a = 0 for other laws. For a table the condition holds at |v| = 0 only.
    pub(super) fn floor_and_slope(&self) -> [f64; 2] {
        match self {
            Self::Exponential { high_speed, .. } => [*high_speed, 0.0],
            Self::Linear { kinetic, slope } => [*kinetic, *slope],
            Self::Stribeck { .. } | Self::Coulomb { .. } | Self::Tabulated(_) => [self.kinetic(), 0.0],
        }
    }

    /// Returns whether the coefficient depends linearly on the velocity.
    pub(super) fn is_linear(&self) -> bool {
        matches!(self, Self::Coulomb { .. } | Self::Linear { .. })
    }

    /// Returns whether the fall −dμ/d|v| is a convex function of the velocity that nowhere increases.
    pub(super) fn has_convex_fall(&self) -> bool {
        !self.is_tabulated()
    }

    /// Returns whether a table defines the law.
    pub(super) fn is_tabulated(&self) -> bool {
        matches!(self, Self::Tabulated(_))
    }

    /// Returns the least coefficient at speeds up to this one.
    pub(super) fn least_coefficient(&self, speed: f64) -> f64 {
        match self {
            Self::Tabulated(table) => table.least_coefficient(speed),
            falling @ (Self::Stribeck { .. }
            | Self::Coulomb { .. }
            | Self::Linear { .. }
            | Self::Exponential { .. }) => falling.coefficient(speed),
        }
    }

    /// Returns whether the coefficient is positive at every speed.
    pub(super) fn is_positive(&self) -> bool {
        match self {
            Self::Linear { slope, .. } => *slope <= 0.0,
            Self::Coulomb { .. } | Self::Stribeck { .. } | Self::Exponential { .. } | Self::Tabulated(_) => true,
        }
    }

    /// Returns an upper bound of |dμ/d|v||.
    pub(super) fn steepest(&self) -> f64 {
        match self {
            Self::Tabulated(table) => table.steepest(),
            falling @ (Self::Stribeck { .. }
            | Self::Coulomb { .. }
            | Self::Linear { .. }
            | Self::Exponential { .. }) => falling.weakening(0.0),
        }
    }

    /// Returns whether the coefficient is the same at all speeds.
    pub(super) fn is_constant(&self) -> bool {
        match self {
            Self::Tabulated(table) => table.is_constant(),
            falling @ (Self::Stribeck { .. }
            | Self::Coulomb { .. }
            | Self::Linear { .. }
            | Self::Exponential { .. }) => falling.weakening(0.0) == 0.0,
        }
    }

    pub(super) fn validate(&self) -> Result<(), VibrationError> {
        positive("kinetic_friction", self.kinetic())?;
        match *self {
            Self::Stribeck { decay: rate, .. } | Self::Linear { slope: rate, .. } => {
                super::non_negative("velocity weakening of the friction law", rate)
            }
            Self::Exponential { kinetic, high_speed, stribeck_velocity } => {
                positive("stribeck_velocity", stribeck_velocity)?;
                positive("high-speed friction", high_speed)?;
                if high_speed > kinetic {
                    let wanted = "at most the kinetic friction";
                    return Err(VibrationError::Parameter {
                        parameter: "high-speed friction",
                        value: high_speed,
                        wanted,
                    });
                }
                Ok(())
            }
            Self::Coulomb { .. } | Self::Tabulated(_) => Ok(()),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_weakening_is_the_negative_derivative_of_the_coefficient() {
        for law in [
            VelocityLaw::Stribeck { kinetic: 0.3, decay: 4.2 },
            VelocityLaw::Coulomb { kinetic: 0.3 },
            VelocityLaw::Linear { kinetic: 0.4, slope: 0.3 },
            VelocityLaw::Exponential { kinetic: 0.4, high_speed: 0.3, stribeck_velocity: 0.2 },
            VelocityLaw::Tabulated(FrictionTable::new(&[[0.0, 0.4], [0.1, 0.3], [0.5, 0.2]]).unwrap()),
        ] {
            let (speed, h) = (0.2, 1e-5);
            let difference = (law.coefficient(speed - h) - law.coefficient(speed + h)) / (2.0 * h);
            assert!((law.weakening(speed) - difference).abs() < 1e-9);
            let rescaled = law.rescaled(2.5);
            for speed in [0.0, 0.01, 0.05, 0.1, 0.13, 0.3, 1.0] {
                assert!((rescaled.coefficient(speed) - law.coefficient(2.5 * speed)).abs() < 1e-15);
            }
            assert_eq!(law.coefficient(0.0), law.kinetic());
        }
    }

    #[test]
    fn laws_are_named_in_snake_case_and_tables_are_checked_when_read() {
        let text = r#"{"tabulated":{"points":[[0.0,0.4],[0.1,0.3]]}}"#;
        let law: VelocityLaw = serde_json::from_str(text).unwrap();
        assert_eq!(serde_json::to_string(&law).unwrap(), text);
        assert!(serde_json::from_str::<VelocityLaw>(r#"{"tabulated":{"points":[[0.1,0.4],[0.2,0.3]]}}"#).is_err());
        let text = r#"{"exponential":{"kinetic":0.4,"high_speed":0.3,"stribeck_velocity":0.2}}"#;
        assert_eq!(serde_json::to_string(&serde_json::from_str::<VelocityLaw>(text).unwrap()).unwrap(), text);
    }

    #[test]
    fn an_exponential_that_rises_is_refused() {
        for (kinetic, high_speed, stribeck_velocity) in [(0.3, 0.4, 0.1), (0.3, 0.0, 0.1), (0.3, 0.2, 0.0)] {
            assert!(VelocityLaw::Exponential { kinetic, high_speed, stribeck_velocity }.validate().is_err());
        }
    }
}
