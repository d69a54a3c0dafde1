//! The law of the paper: friction that falls like a quotient.

use asperity_base::sentence::digits;
use asperity_base::statement::Statement;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use super::curve::{CurveShape, Recurrence, Straight};
use super::{BatchForm, Curve, Law, VelocityLaw, VelocityLawKind};
use crate::VibrationError;
use crate::polynomial::cross;

/// Velocity weakening μ = μ_k/(1 + a|v|), the law of Gaus et al. 2016 (there μ_k is the static coefficient).
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Stribeck {
    /// μ_k, the coefficient at vanishing sliding velocity.
    pub kinetic: f64,
    /// a ≥ 0, per unit of dimensionless velocity.
    pub decay: f64,
}

const DECAY: &str = "vibration.stribeck";

impl Stribeck {
    pub(super) const STATEMENT: &Statement<VelocityLaw> = &Statement {
        inputs: &[DECAY],
        law: |stated| {
            let decay = stated.number(DECAY).ok_or_else(|| VelocityLawKind::Stribeck.requires(DECAY))?;
            Ok(Self { kinetic: stated.kinetic(), decay }.into())
        },
    };
}

impl Law for Stribeck {
    fn coefficient(&self, speed: f64) -> f64 {
        self.kinetic / (1.0 + self.decay * speed)
    }

    fn weakening(&self, speed: f64) -> f64 {
        self.kinetic * self.decay / (1.0 + self.decay * speed).powi(2)
    }

    fn steepest(&self) -> f64 {
        self.weakening(0.0)
    }

    fn kinetic(&self) -> f64 {
        self.kinetic
    }

    fn numbers_mut(&mut self) -> Vec<(&'static str, &mut f64)> {
        vec![("kinetic", &mut self.kinetic), ("decay", &mut self.decay)]
    }

    fn rescaled(&self, factor: f64) -> Self {
        Self { decay: self.decay * factor, ..*self }
    }

    fn with_coefficients(&self, map: impl Fn(f64) -> f64) -> Result<Self, VibrationError> {
        Ok(Self { kinetic: map(self.kinetic), ..*self })
    }

    fn rate(&self) -> Option<f64> {
        Some(self.decay)
    }

    fn with_rate(&self, rate: f64) -> Option<Self> {
        Some(Self { decay: rate, ..*self })
    }

    fn has_convex_fall(&self) -> bool {
        true
    }

    fn curve(&self, velocity: f64) -> Curve {
        let Self { kinetic, decay } = *self;
        if decay > 0.0 {
            Curve::Quotient(Quotient { gain: decay * kinetic, curvature: decay * velocity })
        } else {
            Curve::Straight(Straight)
        }
    }

    fn batch_form(&self, velocity: f64) -> Option<BatchForm> {
        let [gain, curvature] = [self.decay * self.kinetic, self.decay * velocity];
        Some(BatchForm { gain, curvature, ..BatchForm::constant(self.kinetic) })
    }

    /// μ·(1 + aw) = μ_k.
    fn term(&self, before: &[f64], w: &[f64], k: usize) -> f64 {
        let mut sum = 0.0;
        for j in 1..=k {
            sum += w[j] * before[k - j];
        }
        -self.decay * sum / (1.0 + self.decay * w[0])
    }

    fn describe(&self) -> String {
        let [kinetic, decay] = [self.kinetic, self.decay].map(digits);
        format!("{kinetic}/(1 + a|v|), a = {decay} per unit of dimensionless velocity,")
    }

    #[cfg(test)]
    fn examples() -> Vec<Self> {
        vec![Self { kinetic: 0.3, decay: 4.2 }, Self { kinetic: 0.3, decay: 0.0 }]
    }
}

/// r = gW/(1 + cW).
#[derive(Debug, Clone, Copy)]
pub(crate) struct Quotient {
    gain: f64,
    curvature: f64,
}

impl CurveShape for Quotient {
    type Terms<const N: usize> = QuotientTerms<N>;

    #[inline(always)]
    fn value(&self, w: f64) -> f64 {
        self.gain * w / (1.0 + self.curvature * w)
    }

    fn slope(&self, w: f64) -> f64 {
        let inverse = 1.0 / (1.0 + self.curvature * w);
        self.gain * inverse * inverse
    }

    fn argument(&self, w: f64) -> f64 {
        self.curvature * w
    }

    #[inline(always)]
    fn terms<const N: usize>(&self, w0: f64) -> QuotientTerms<N> {
        let inverse = 1.0 / (1.0 + self.curvature * w0);
        QuotientTerms {
            slope: self.gain * inverse * inverse,
            curvature: self.curvature * inverse,
            r: [0.0; N],
            damped: [0.0; N],
        }
    }
}

/// Coefficients of a quotient: r(1 + cW) = gW gives r_n = slope·w_n − c′·Σ w_k r_{n−k} over 0 < k < n, with c′ = c/(1 +
/// cW_0).
pub(crate) struct QuotientTerms<const N: usize> {
    slope: f64,
    curvature: f64,
    r: [f64; N],
    /// −c′·w_k.
    damped: [f64; N],
}

impl<const N: usize> Recurrence<N> for QuotientTerms<N> {
    #[inline(always)]
    fn slope(&self) -> f64 {
        self.slope
    }

    #[inline(always)]
    fn rest(&mut self, w: &[f64; N], n: usize) -> f64 {
        let rest = cross(&self.damped, &self.r, n);
        self.r[n] = self.slope * w[n] + rest;
        self.damped[n] = -self.curvature * w[n];
        rest
    }
}
