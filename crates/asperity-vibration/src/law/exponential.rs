//! Friction that falls exponentially to a value at high velocity.

use asperity_base::sentence::digits;
use asperity_base::statement::Statement;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use super::curve::{CurveShape, Recurrence, Straight};
use super::{BatchForm, Curve, Law, VelocityLaw, VelocityLawKind};
use crate::polynomial::{RECIPROCAL, cross};
use crate::{VibrationError, positive};

/// Exponential weakening μ = μ_∞ + (μ_k − μ_∞)e^{−|v|/v₀}.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Exponential {
    /// μ_k, the coefficient at vanishing sliding velocity.
    pub kinetic: f64,
    /// 0 < μ_∞ ≤ μ_k, the coefficient at high velocity.
    pub high_speed: f64,
    /// v₀ > 0, the Stribeck velocity.
    pub stribeck_velocity: f64,
}

const VELOCITY: &str = "vibration.stribeck_velocity";
const SHARE: &str = "vibration.high_speed_share";

impl Exponential {
    pub(super) const STATEMENT: &Statement<VelocityLaw> = &Statement {
        inputs: &[VELOCITY, SHARE],
        law: |stated| {
            let number = |input| stated.number(input).ok_or_else(|| VelocityLawKind::Exponential.requires(input));
            let (stribeck_velocity, high_speed) = (number(VELOCITY)?, number(SHARE)?);
            Ok(Self { kinetic: stated.kinetic(), high_speed, stribeck_velocity }.into())
        },
    };
}

impl Law for Exponential {
    fn coefficient(&self, speed: f64) -> f64 {
        self.high_speed + (self.kinetic - self.high_speed) * (-speed / self.stribeck_velocity).exp()
    }

    fn weakening(&self, speed: f64) -> f64 {
        (self.kinetic - self.high_speed) / self.stribeck_velocity * (-speed / self.stribeck_velocity).exp()
    }

    fn steepest(&self) -> f64 {
        self.weakening(0.0)
    }

    fn kinetic(&self) -> f64 {
        self.kinetic
    }

    fn numbers_mut(&mut self) -> Vec<(&'static str, &mut f64)> {
        vec![
            ("kinetic", &mut self.kinetic),
            ("high_speed", &mut self.high_speed),
            ("stribeck_velocity", &mut self.stribeck_velocity),
        ]
    }

    fn rescaled(&self, factor: f64) -> Self {
        Self { stribeck_velocity: self.stribeck_velocity / factor, ..*self }
    }

    fn with_coefficients(&self, map: impl Fn(f64) -> f64) -> Result<Self, VibrationError> {
        Ok(Self { kinetic: map(self.kinetic), high_speed: map(self.high_speed), ..*self })
    }

    fn validate(&self) -> Result<(), VibrationError> {
        let Self { kinetic, high_speed, stribeck_velocity } = *self;
        positive("stribeck_velocity", stribeck_velocity)?;
        positive("high-speed friction", high_speed)?;
        if high_speed > kinetic {
            let wanted = "at most the kinetic friction";
            return Err(VibrationError::Parameter { parameter: "high-speed friction", value: high_speed, wanted });
        }
        Ok(())
    }

    fn has_convex_fall(&self) -> bool {
        true
    }

    fn curve(&self, velocity: f64) -> Curve {
        match self.batch_form(velocity) {
            Some(BatchForm { gain, curvature, is_exponential: true, .. }) => Curve::Decay(Decay { gain, curvature }),
            _ => Curve::Straight(Straight),
        }
    }

    fn batch_form(&self, velocity: f64) -> Option<BatchForm> {
        let Self { kinetic, high_speed, stribeck_velocity } = *self;
        let constant = BatchForm::constant(high_speed);
        let falling = BatchForm {
            gain: (kinetic - high_speed) / stribeck_velocity,
            curvature: velocity / stribeck_velocity,
            is_exponential: true,
            ..constant
        };
        Some(if high_speed < kinetic { falling } else { constant })
    }

    fn exponent(&self) -> f64 {
        self.stribeck_velocity.recip()
    }

    /// v₀μ′ = −(μ − μ_∞)w′.
    fn term(&self, before: &[f64], w: &[f64], k: usize) -> f64 {
        let mut sum = k as f64 * w[k] * (before[0] - self.high_speed);
        for j in 1..k {
            sum += j as f64 * w[j] * before[k - j];
        }
        -sum / (k as f64 * self.stribeck_velocity)
    }

    fn describe(&self) -> String {
        let Self { kinetic, high_speed, stribeck_velocity } = *self;
        let [high_speed, rest, velocity] = [high_speed, kinetic - high_speed, stribeck_velocity].map(digits);
        format!("{high_speed} + {rest}·exp(−|v|/{velocity})")
    }

    #[cfg(test)]
    fn examples() -> Vec<Self> {
        vec![
            Self { kinetic: 0.4, high_speed: 0.3, stribeck_velocity: 0.2 },
            Self { kinetic: 0.3, high_speed: 0.3, stribeck_velocity: 0.2 },
        ]
    }
}

/// r = (g/c)(1 − e^{−cW}).
#[derive(Debug, Clone, Copy)]
pub(crate) struct Decay {
    gain: f64,
    curvature: f64,
}

impl CurveShape for Decay {
    type Terms<const N: usize> = DecayTerms<N>;

    #[inline(always)]
    fn value(&self, w: f64) -> f64 {
        -(self.gain / self.curvature) * (-self.curvature * w).exp_m1()
    }

    fn slope(&self, w: f64) -> f64 {
        self.gain * (-self.curvature * w).exp()
    }

    fn argument(&self, w: f64) -> f64 {
        self.curvature * w
    }

    fn exponent(&self) -> f64 {
        self.curvature
    }

    #[inline(always)]
    fn terms<const N: usize>(&self, w0: f64) -> DecayTerms<N> {
        let Self { gain, curvature } = *self;
        DecayTerms { slope: gain * (-curvature * w0).exp(), curvature, r: [0.0; N], rates: [0.0; N] }
    }
}

/// Coefficients of an exponential: r′ = cW′(g/c − r) gives n·r_n = n·slope·w_n − c·Σ k·w_k r_{n−k} over 0 < k < n, with
/// slope = g − c·r_0.
pub(crate) struct DecayTerms<const N: usize> {
    slope: f64,
    curvature: f64,
    r: [f64; N],
    /// −c·k·w_k.
    rates: [f64; N],
}

impl<const N: usize> Recurrence<N> for DecayTerms<N> {
    #[inline(always)]
    fn slope(&self) -> f64 {
        self.slope
    }

    #[inline(always)]
    fn rest(&mut self, w: &[f64; N], n: usize) -> f64 {
        let rest = cross(&self.rates, &self.r, n) * RECIPROCAL[n];
        self.rates[n] = -self.curvature * (n as f64 * w[n]);
        self.r[n] = self.slope * w[n] + rest;
        rest
    }
}
