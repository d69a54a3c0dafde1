//! Parameters of an oscillator that can be varied.

use super::super::{Forcing, Oscillator, Parameters, VibrationError};

asperity_base::choice! {
    /// Parameter of a curve or a diagram.
    pub enum CurveParameter: "parameter of the oscillator" {
        /// Damping ratio ζ.
        DampingRatio = "damping_ratio",
        /// Dimensionless belt velocity V.
        BeltVelocity = "belt_velocity",
        /// Static friction coefficient μ_st; the ratio of the kinetic coefficient to it is constant.
        StaticFriction = "static_friction",
        /// Weakening rate: a of the Stribeck law, b of the linear law.
        Weakening = "weakening",
        /// Amplitude q of the harmonic force.
        ForcingAmplitude = "forcing_amplitude",
        /// Frequency η of the harmonic force.
        ForcingFrequency = "forcing_frequency",
    }
}

impl CurveParameter {
    /// Returns the SI unit of the parameter before it is made dimensionless; `None` of a pure number.
    pub fn unit(self) -> Option<&'static str> {
        match self {
            Self::DampingRatio | Self::StaticFriction => None,
            Self::BeltVelocity => Some("m/s"),
            Self::Weakening => Some("s/m"),
            Self::ForcingAmplitude => Some("N"),
            Self::ForcingFrequency => Some("rad/s"),
        }
    }

    /// Returns the value of the parameter; none if the oscillator does not have it.
    pub fn value(self, oscillator: &Oscillator) -> Option<f64> {
        match self {
            Self::DampingRatio => Some(oscillator.damping_ratio()),
            Self::BeltVelocity => Some(oscillator.belt_velocity()),
            Self::StaticFriction => Some(oscillator.static_friction()),
            Self::Weakening => oscillator.law().weakening_rate(),
            Self::ForcingAmplitude => oscillator.parameters().forcing.map(|f| f.amplitude),
            Self::ForcingFrequency => oscillator.parameters().forcing.map(|f| f.frequency),
        }
    }

    /// Returns the same oscillator with another value. Fails if the value is out of range, or if there is no such
    /// parameter.
    pub fn set(self, oscillator: &Oscillator, value: f64) -> Result<Oscillator, VibrationError> {
        let old = oscillator.parameters().clone();
        let missing = |reason| VibrationError::NotFound { what: "parameter", reason };
        let forcing = old.forcing;
        let forcing = || forcing.ok_or(missing("the oscillator has no forcing"));
        Oscillator::new(match self {
            Self::DampingRatio => Parameters { damping_ratio: value, ..old },
            Self::BeltVelocity => Parameters { belt_velocity: value, ..old },
            Self::StaticFriction => {
                // A kinetic coefficient equal to the static one stays exactly equal.
                let scaled = |kinetic: f64| value * (kinetic / old.static_friction);
                let law = old.law.with_coefficients(scaled)?;
                Parameters { static_friction: value, law, ..old }
            }
            Self::Weakening => {
                let law = old.law.with_weakening_rate(value);
                let law = law.ok_or(missing("the friction law has no weakening rate"))?;
                Parameters { law, ..old }
            }
            Self::ForcingAmplitude => Parameters { forcing: Some(Forcing { amplitude: value, ..forcing()? }), ..old },
            Self::ForcingFrequency => Parameters { forcing: Some(Forcing { frequency: value, ..forcing()? }), ..old },
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::VelocityLaw;
    use crate::law::Coulomb;

    #[test]
    fn setting_a_parameter_changes_nothing_else() {
        let forced = Oscillator::with_stribeck(0.3, 4.2, 0.1, 0.05)
            .unwrap()
            .with_forcing(Some(Forcing { amplitude: 0.01, frequency: 0.9 }))
            .unwrap();
        let all = [
            CurveParameter::DampingRatio,
            CurveParameter::BeltVelocity,
            CurveParameter::StaticFriction,
            CurveParameter::Weakening,
            CurveParameter::ForcingAmplitude,
            CurveParameter::ForcingFrequency,
        ];
        for parameter in all {
            let other = parameter.set(&forced, 0.7).unwrap();
            assert_eq!(parameter.value(&other), Some(0.7));
            for rest in all.into_iter().filter(|p| *p != parameter) {
                assert_eq!(rest.value(&other), rest.value(&forced));
            }
        }
        let friction = CurveParameter::StaticFriction.set(&forced, 0.7).unwrap();
        assert_eq!(friction.law().kinetic(), 0.7);
        let law = VelocityLaw::Coulomb(Coulomb { kinetic: 0.2 });
        let coulomb = Oscillator::new(Parameters { law, forcing: None, ..forced.parameters().clone() }).unwrap();
        let scaled = CurveParameter::StaticFriction.set(&coulomb, 0.6).unwrap();
        assert!((scaled.law().kinetic() - 0.4).abs() < 1e-15);
        assert_eq!(CurveParameter::Weakening.value(&coulomb), None);
        assert!(
            CurveParameter::Weakening.set(&coulomb, 1.0).is_err()
                && CurveParameter::ForcingAmplitude.set(&coulomb, 0.1).is_err()
        );
        assert!(CurveParameter::BeltVelocity.set(&coulomb, -1.0).is_err());
    }
}
