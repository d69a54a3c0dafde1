//! A linear elastic, isotropic body.

use crate::ContactError;

/// A linear elastic, isotropic body.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Elastic {
    /// Young's modulus in pascal, > 0.
    pub youngs_modulus_pa: f64,
    /// Poisson's ratio, above −1 and at most ½.
    pub poisson_ratio: f64,
}

impl Elastic {
    /// A rigid body.
    pub const RIGID: Self = Self { youngs_modulus_pa: f64::INFINITY, poisson_ratio: 0.0 };

    /// Default of Poisson's ratio.
    pub const POISSON_RATIO: f64 = 0.3;

    /// Creates a body of Young's modulus E in pascal and Poisson's ratio ν.
    ///
    /// # Errors
    /// The modulus is not positive and finite, or the ratio not above −1 and at most ½.
    pub fn new(youngs_modulus_pa: f64, poisson_ratio: f64) -> Result<Self, ContactError> {
        let body = Self { youngs_modulus_pa, poisson_ratio };
        body.validate("Young's modulus", "Poisson's ratio").map(|()| body)
    }

    /// Checks that the constants are those of an elastic body. `modulus` and `ratio` name them in the error.
    pub(super) fn validate(&self, modulus: &'static str, ratio: &'static str) -> Result<(), ContactError> {
        let parameter =
            |parameter, value, unit, wanted| Err(ContactError::Parameter { parameter, value, unit, wanted });
        let Self { youngs_modulus_pa, poisson_ratio } = *self;
        if !(youngs_modulus_pa.is_finite() && youngs_modulus_pa > 0.0) {
            return parameter(modulus, youngs_modulus_pa, "Pa", "positive");
        }
        if !(poisson_ratio > -1.0 && poisson_ratio <= 0.5) {
            return parameter(ratio, poisson_ratio, "(dimensionless)", "above -1 and at most 0.5");
        }
        Ok(())
    }

    pub(super) fn shear_modulus_pa(&self) -> f64 {
        0.5 * self.youngs_modulus_pa / (1.0 + self.poisson_ratio)
    }

    /// Returns 3 − 4ν.
    pub(super) fn kolosov(&self) -> f64 {
        3.0 - 4.0 * self.poisson_ratio
    }

    /// Returns the contact modulus E/(1−ν²) in pascal against a rigid body; infinite for a rigid one.
    pub fn contact_modulus_pa(&self) -> f64 {
        contact_modulus_pa(self.youngs_modulus_pa, self.poisson_ratio)
    }
}

/// Returns the contact modulus E* = E/(1−ν²) in pascal of an elastic body pressed against a rigid one, from Young's
/// modulus E in pascal and Poisson's ratio ν.
pub fn contact_modulus_pa(youngs_modulus_pa: f64, poisson_ratio: f64) -> f64 {
    youngs_modulus_pa / (1.0 - poisson_ratio * poisson_ratio)
}
