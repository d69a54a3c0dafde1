//! Friction that is the same at all velocities.

use asperity_base::sentence::digits;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use super::{BatchForm, Law};
use crate::VibrationError;

/// Constant coefficient.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Coulomb {
    /// μ_k.
    pub kinetic: f64,
}

impl Law for Coulomb {
    fn coefficient(&self, _: f64) -> f64 {
        self.kinetic
    }

    fn weakening(&self, _: f64) -> f64 {
        0.0
    }

    fn steepest(&self) -> f64 {
        0.0
    }

    fn kinetic(&self) -> f64 {
        self.kinetic
    }

    fn numbers_mut(&mut self) -> Vec<(&'static str, &mut f64)> {
        vec![("kinetic", &mut self.kinetic)]
    }

    fn rescaled(&self, _: f64) -> Self {
        *self
    }

    fn with_coefficients(&self, map: impl Fn(f64) -> f64) -> Result<Self, VibrationError> {
        Ok(Self { kinetic: map(self.kinetic) })
    }

    fn is_linear(&self) -> bool {
        true
    }

    fn has_convex_fall(&self) -> bool {
        true
    }

    fn batch_form(&self, _: f64) -> Option<BatchForm> {
        Some(BatchForm::constant(self.kinetic))
    }

    fn term(&self, _: &[f64], _: &[f64], _: usize) -> f64 {
        0.0
    }

    fn describe(&self) -> String {
        digits(self.kinetic)
    }

    #[cfg(test)]
    fn examples() -> Vec<Self> {
        vec![Self { kinetic: 0.3 }]
    }
}
