//! Friction that falls in proportion to the velocity.

use asperity_base::sentence::digits;
use asperity_base::statement::Statement;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use super::{BatchForm, Law, VelocityLaw, VelocityLawKind};
use crate::VibrationError;

/// Linear weakening μ = μ_k − b|v|. The law is invalid from |v| = μ_k/b on, which is reported as an error.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Linear {
    /// μ_k, the coefficient at vanishing sliding velocity.
    pub kinetic: f64,
    /// b ≥ 0, per unit of dimensionless velocity.
    pub slope: f64,
}

const SLOPE: &str = "vibration.linear_weakening";

impl Linear {
    pub(super) const STATEMENT: &Statement<VelocityLaw> = &Statement {
        inputs: &[SLOPE],
        law: |stated| {
            let slope = stated.number(SLOPE).ok_or_else(|| VelocityLawKind::Linear.requires(SLOPE))?;
            Ok(Self { kinetic: stated.kinetic(), slope }.into())
        },
    };
}

impl Law for Linear {
    fn coefficient(&self, speed: f64) -> f64 {
        self.kinetic - self.slope * speed
    }

    fn weakening(&self, _: f64) -> f64 {
        self.slope
    }

    fn steepest(&self) -> f64 {
        self.slope
    }

    fn kinetic(&self) -> f64 {
        self.kinetic
    }

    fn numbers_mut(&mut self) -> Vec<(&'static str, &mut f64)> {
        vec![("kinetic", &mut self.kinetic), ("slope", &mut self.slope)]
    }

    fn rescaled(&self, factor: f64) -> Self {
        Self { slope: self.slope * factor, ..*self }
    }

    fn with_coefficients(&self, map: impl Fn(f64) -> f64) -> Result<Self, VibrationError> {
        Ok(Self { kinetic: map(self.kinetic), ..*self })
    }

    fn rate(&self) -> Option<f64> {
        Some(self.slope)
    }

    fn with_rate(&self, rate: f64) -> Option<Self> {
        Some(Self { slope: rate, ..*self })
    }

    fn is_linear(&self) -> bool {
        true
    }

    fn has_convex_fall(&self) -> bool {
        true
    }

    fn is_positive(&self) -> bool {
        self.slope <= 0.0
    }

    fn linear_part(&self) -> f64 {
        self.slope
    }

    fn batch_form(&self, velocity: f64) -> Option<BatchForm> {
        Some(BatchForm { loss: self.slope * velocity, ..BatchForm::constant(self.kinetic) })
    }

    fn term(&self, _: &[f64], w: &[f64], k: usize) -> f64 {
        -self.slope * w[k]
    }

    fn describe(&self) -> String {
        let [kinetic, slope] = [self.kinetic, self.slope].map(digits);
        format!("{kinetic} − b|v|, b = {slope} per unit of dimensionless velocity,")
    }

    #[cfg(test)]
    fn examples() -> Vec<Self> {
        vec![Self { kinetic: 0.4, slope: 0.3 }]
    }
}
