//! Where steady sliding loses its stability, and what is born there.

use serde::{Deserialize, Serialize};

use super::super::series::{Loading, Series};
use super::super::weakening::Weakening;
use super::super::{Oscillator, VibrationError};

/// A third derivative of the scaled law below this is rounding.
const FLAT: f64 = 1e-15;

/// Side of the Hopf point on which its cycles live.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Criticality {
    /// Unstable cycles beside stable sliding, at higher damping.
    Subcritical,
    /// Stable cycles beside unstable sliding, at lower damping.
    Supercritical,
    /// The law has no third derivative there, as the linear one: higher orders would decide.
    Degenerate,
}

/// The Hopf bifurcation of steady sliding, 2ζ_H = −dμ/d|v| at the belt velocity; its frequency is 1.
///
/// Small oscillations of the velocity have an amplitude R that obeys R′ = (ζ_H − ζ)R + ℓR³, with ℓ = −μ‴(V)/16: the
/// equation of motion is X″ + X = f(X′), whose quadratic part is reversible in time and therefore adds nothing to ℓ.
///
/// # References
/// Guckenheimer & Holmes, *Nonlinear Oscillations, Dynamical Systems, and Bifurcations of Vector Fields*, §3.4.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct HopfPoint {
    /// ζ_H; negative for a law that rises with the velocity.
    pub damping_ratio: f64,
    /// ℓ, per square of dimensionless velocity.
    pub lyapunov_coefficient: f64,
    /// Sign of ℓ.
    pub criticality: Criticality,
}

impl HopfPoint {
    /// Amplitude √((ζ − ζ_H)/ℓ) of the velocity in the cycle near the Hopf point, to leading order; none on the side
    /// without a cycle.
    pub fn velocity_amplitude(&self, damping_ratio: f64) -> Option<f64> {
        let square = (damping_ratio - self.damping_ratio) / self.lyapunov_coefficient;
        (self.criticality != Criticality::Degenerate && square >= 0.0).then(|| square.sqrt())
    }
}

/// The Hopf point of an oscillator; its own damping ratio and forcing are left aside.
pub fn hopf_point(oscillator: &Oscillator) -> Result<HopfPoint, VibrationError> {
    let velocity = oscillator.belt_velocity();
    let weakening = oscillator.law().weakening(velocity);
    let mut flow = Weakening::new(&oscillator.with_forcing(None)?.with_damping(0.5 * weakening.max(0.0))?);
    if weakening < 0.0 {
        flow = Weakening::new(&oscillator.with_damping(0.0)?);
    }
    // W′ = f(W) + e with e held, through W = 1 at the rate 1: f′ vanishes at ζ_H, and W⁗ is then f‴.
    let held = Loading { base: 0.0, kappa: 0.0, swing: 0.0, frequency: 0.0, phase: 0.0 };
    flow.select(1.0, 1.0 - flow.acceleration(1.0, 0.0), &held);
    let mut series = Series::new();
    series.expand(&flow, &held, 1.0, 1.0 - flow.acceleration(1.0, 0.0), 0.0);
    let [_, _, w2, w3, w4] = *series.w().first_chunk::<5>().unwrap_or(&[0.0; 5]);
    // f′ = 2w₂, f″ = 6w₃ − f′², f‴ = 24w₄ − 4f′f″ − f′³.
    let first = 2.0 * w2;
    let second = 6.0 * w3 - first * first;
    let third = 24.0 * w4 - 4.0 * first * second - first * first * first;
    let lyapunov_coefficient = third / (16.0 * velocity * velocity);
    let criticality = if third.abs() <= FLAT {
        Criticality::Degenerate
    } else if third > 0.0 {
        Criticality::Subcritical
    } else {
        Criticality::Supercritical
    };
    Ok(HopfPoint { damping_ratio: 0.5 * weakening, lyapunov_coefficient, criticality })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{FrictionLaw, Parameters};

    #[test]
    fn the_coefficient_is_the_third_derivative_of_the_law() {
        for (friction, decay, velocity) in [(0.1, 4.2, 0.003), (0.3, 4.2, 0.1), (1.0, 3.0, 0.2), (0.2, 50.0, 2.0)] {
            let found = hopf_point(&Oscillator::stribeck(friction, decay, 0.7, velocity).unwrap()).unwrap();
            let speed: f64 = 1.0 + decay * velocity;
            // μ‴ = −6a³μ/(1 + aV)⁴.
            let wanted = 6.0 / 16.0 * decay.powi(3) * friction / speed.powi(4);
            assert!((found.lyapunov_coefficient / wanted - 1.0).abs() < 1e-11, "{found:?} instead of {wanted}");
            assert_eq!(found.criticality, Criticality::Subcritical);
            assert!((found.damping_ratio - 0.5 * decay * friction / speed.powi(2)).abs() < 1e-15);
        }
    }

    #[test]
    fn a_law_without_curvature_decides_nothing() {
        for law in [FrictionLaw::Linear { kinetic: 0.4, slope: 0.3 }, FrictionLaw::Coulomb { kinetic: 0.4 }] {
            let parameters =
                Parameters { static_friction: 0.4, law, damping_ratio: 0.1, belt_velocity: 0.1, forcing: None };
            let found = hopf_point(&Oscillator::new(parameters).unwrap()).unwrap();
            assert_eq!((found.criticality, found.velocity_amplitude(0.2)), (Criticality::Degenerate, None));
        }
    }
}
