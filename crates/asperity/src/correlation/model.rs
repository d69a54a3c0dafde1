//! Stationary covariance models.

use serde::{Deserialize, Serialize};
use thiserror::Error;

/// Why a covariance could not be made.
#[derive(Debug, Clone, PartialEq, Error)]
pub enum CovarianceError {
    /// A parameter lies outside its range.
    #[error("{parameter} is {value}, but must be {wanted}")]
    Parameter {
        /// Name of the parameter.
        parameter: &'static str,
        /// Value found.
        value: f64,
        /// Values allowed.
        wanted: &'static str,
    },
}

/// The shape ρ(r) of a stationary correlation at the scaled distance r = √((x/ℓx)² + (y/ℓy)²).
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum CorrelationModel {
    /// ρ = e^{−r²}.
    SquaredExponential,
    /// ρ = e^{−r}.
    Exponential,
    /// ρ = 2^{1−ν}/Γ(ν) (√(2ν) r)^ν K_ν(√(2ν) r).
    Matern {
        /// Smoothness ν > 0.
        nu: f64,
    },
    /// Self-affine with roll-off: power spectral density ∝ (1 + (q_x ℓx)² + (q_y ℓy)²)^{−(1+H)}, 0 < H < 1.
    ///
    /// In two dimensions this is the Matérn model of ν = H with ℓ in place of ℓ/√(2ν).
    SelfAffine {
        /// Hurst exponent H.
        hurst: f64,
    },
}

/// A stationary covariance C(x, y) = σ² ρ(r), r = √((x/ℓx)² + (y/ℓy)²).
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct Covariance {
    /// Shape of the correlation.
    pub model: CorrelationModel,
    /// Standard deviation σ in metre.
    pub std_m: f64,
    /// ℓx in metre.
    pub length_x_m: f64,
    /// ℓy in metre.
    pub length_y_m: f64,
}
