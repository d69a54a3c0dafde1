//! Friction laws: the coefficient as a function of the relative velocity.

use serde::{Deserialize, Serialize};

use super::VibrationError;

/// Kinetic friction coefficient μ(|v|) of a sliding contact, at the dimensionless relative velocity v = v_rel·mω₀/N.
///
/// The stick limit is a separate number, [`super::Oscillator::static_friction`].
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case", deny_unknown_fields)]
pub enum FrictionLaw {
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
    /// Linear weakening μ = μ_k − b|v|; it loses its meaning at |v| = μ_k/b, which is reported as an error.
    Linear {
        /// μ_k, the coefficient at vanishing sliding velocity.
        kinetic: f64,
        /// b ≥ 0, per unit of dimensionless velocity.
        slope: f64,
    },
}

impl FrictionLaw {
    /// Coefficient at the speed |v| ≥ 0.
    pub fn coefficient(&self, speed: f64) -> f64 {
        match *self {
            Self::Stribeck { kinetic, decay } => kinetic / (1.0 + decay * speed),
            Self::Coulomb { kinetic } => kinetic,
            Self::Linear { kinetic, slope } => kinetic - slope * speed,
        }
    }

    /// Weakening rate −dμ/d|v| at the speed |v| ≥ 0.
    pub fn weakening(&self, speed: f64) -> f64 {
        match *self {
            Self::Stribeck { kinetic, decay } => kinetic * decay / (1.0 + decay * speed).powi(2),
            Self::Coulomb { .. } => 0.0,
            Self::Linear { slope, .. } => slope,
        }
    }

    /// Coefficient at vanishing sliding velocity, μ_k.
    pub fn kinetic(&self) -> f64 {
        match *self {
            Self::Stribeck { kinetic, .. } | Self::Coulomb { kinetic } | Self::Linear { kinetic, .. } => kinetic,
        }
    }

    pub(super) fn validate(&self) -> Result<(), VibrationError> {
        let rate = match *self {
            Self::Stribeck { decay, .. } => decay,
            Self::Coulomb { .. } => 0.0,
            Self::Linear { slope, .. } => slope,
        };
        super::positive("kinetic_friction", self.kinetic())?;
        super::non_negative("velocity weakening of the friction law", rate)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_weakening_is_the_negative_derivative_of_the_coefficient() {
        for law in [
            FrictionLaw::Stribeck { kinetic: 0.3, decay: 4.2 },
            FrictionLaw::Coulomb { kinetic: 0.3 },
            FrictionLaw::Linear { kinetic: 0.4, slope: 0.3 },
        ] {
            let (speed, h) = (0.2, 1e-5);
            let difference = (law.coefficient(speed - h) - law.coefficient(speed + h)) / (2.0 * h);
            assert!((law.weakening(speed) - difference).abs() < 1e-9);
            assert_eq!(law.coefficient(0.0), law.kinetic());
        }
    }
}
