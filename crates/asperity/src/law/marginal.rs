//! The marginal law of heights, pressures and friction coefficients.

use serde::{Deserialize, Serialize};
use statrs::distribution::{Beta, Continuous, ContinuousCDF, Normal};
use thiserror::Error;

/// Why a law could not be made.
#[derive(Debug, Clone, PartialEq, Error)]
pub enum LawError {
    /// A parameter lies outside its range.
    #[error("{law}: {parameter} is {value}, but must be {wanted}")]
    Parameter {
        /// Name of the law.
        law: &'static str,
        /// Name of the parameter.
        parameter: &'static str,
        /// Value found.
        value: f64,
        /// Values allowed.
        wanted: &'static str,
    },
    /// The sample is too small or degenerate.
    #[error("{law}: cannot be fitted to {n} values: {reason}")]
    Sample {
        /// Name of the law.
        law: &'static str,
        /// Sample size.
        n: usize,
        /// What is wrong.
        reason: &'static str,
    },
    /// The text names no law.
    #[error("`{text}` is not a law; write normal, lognormal:MU,SIGMA, weibull:SHAPE,SCALE or beta:A,B[,LOW,HIGH]")]
    Syntax {
        /// What was found.
        text: String,
    },
}

/// A continuous law on the real line.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Marginal {
    /// Normal law.
    Normal {
        /// Mean.
        mean: f64,
        /// Standard deviation.
        std: f64,
    },
    /// ln(x − shift) is normal.
    Lognormal {
        /// Mean of the logarithm.
        mu: f64,
        /// Standard deviation of the logarithm.
        sigma: f64,
        /// Lower end of the support.
        shift: f64,
    },
    /// Weibull law.
    Weibull {
        /// Shape.
        shape: f64,
        /// Scale.
        scale: f64,
        /// Lower end of the support.
        shift: f64,
    },
    /// Beta law on [low, high].
    Beta {
        /// First shape.
        a: f64,
        /// Second shape.
        b: f64,
        /// Lower end of the support.
        low: f64,
        /// Upper end of the support.
        high: f64,
    },
    /// A measured law: linear interpolation between sorted values at probabilities (i + ½)/n.
    Empirical {
        /// Sorted values.
        sorted: Vec<f64>,
    },
}

/// The standard normal distribution function Φ.
pub fn standard_normal_cdf(x: f64) -> f64 {
    Normal::standard().cdf(x)
}

/// The standard normal quantile Φ⁻¹.
pub fn standard_normal_quantile(probability: f64) -> f64 {
    Normal::standard().inverse_cdf(probability)
}

impl Marginal {
    /// The standard normal law.
    pub const STANDARD_NORMAL: Self = Self::Normal { mean: 0.0, std: 1.0 };

    /// Distribution function F(x).
    pub fn cdf(&self, x: f64) -> f64 {
        match self {
            Self::Normal { mean, std } => standard_normal_cdf((x - mean) / std),
            Self::Lognormal { mu, sigma, shift } => {
                if x > *shift {
                    standard_normal_cdf(((x - shift).ln() - mu) / sigma)
                } else {
                    0.0
                }
            }
            Self::Weibull { shape, scale, shift } => {
                if x > *shift {
                    -(-((x - shift) / scale).powf(*shape)).exp_m1()
                } else {
                    0.0
                }
            }
            Self::Beta { a, b, low, high } => {
                let unit = ((x - low) / (high - low)).clamp(0.0, 1.0);
                Beta::new(*a, *b).map_or(f64::NAN, |law| law.cdf(unit))
            }
            Self::Empirical { sorted } => {
                let n = sorted.len() as f64;
                let after = sorted.partition_point(|v| *v <= x);
                if after == 0 {
                    return 0.0;
                }
                if after == sorted.len() {
                    return 1.0;
                }
                let (left, right) = (sorted[after - 1], sorted[after]);
                (after as f64 - 0.5 + (x - left) / (right - left)) / n
            }
        }
    }

    /// Quantile F⁻¹(probability).
    pub fn quantile(&self, probability: f64) -> f64 {
        match self {
            Self::Normal { mean, std } => mean + std * standard_normal_quantile(probability),
            Self::Lognormal { mu, sigma, shift } => shift + (mu + sigma * standard_normal_quantile(probability)).exp(),
            Self::Weibull { shape, scale, shift } => shift + scale * (-(-probability).ln_1p()).powf(1.0 / shape),
            Self::Beta { a, b, low, high } => {
                let unit = Beta::new(*a, *b).map_or(f64::NAN, |law| law.inverse_cdf(probability));
                low + (high - low) * unit
            }
            Self::Empirical { sorted } => {
                let position = (probability * sorted.len() as f64 - 0.5).clamp(0.0, sorted.len() as f64 - 1.0);
                let left = position.floor() as usize;
                let right = (left + 1).min(sorted.len() - 1);
                sorted[left] + (position - left as f64) * (sorted[right] - sorted[left])
            }
        }
    }

    /// Density; zero outside the support. An empirical law has none: NaN.
    pub fn pdf(&self, x: f64) -> f64 {
        match self {
            Self::Normal { mean, std } => Normal::standard().pdf((x - mean) / std) / std,
            Self::Lognormal { mu, sigma, shift } => {
                let t = x - shift;
                if t > 0.0 { Normal::standard().pdf((t.ln() - mu) / sigma) / (sigma * t) } else { 0.0 }
            }
            Self::Weibull { shape, scale, shift } => {
                let t = (x - shift) / scale;
                if t > 0.0 { shape / scale * t.powf(shape - 1.0) * (-t.powf(*shape)).exp() } else { 0.0 }
            }
            Self::Beta { a, b, low, high } => {
                let unit = (x - low) / (high - low);
                if !(0.0..=1.0).contains(&unit) {
                    return 0.0;
                }
                Beta::new(*a, *b).map_or(f64::NAN, |law| law.pdf(unit) / (high - low))
            }
            Self::Empirical { .. } => f64::NAN,
        }
    }
}
