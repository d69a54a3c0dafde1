//! Generators of realisations of a friction process.

use asperity_base::choice::Choice;
use serde::{Deserialize, Serialize};

use super::{CorrelationShape, ProcessError};
use asperity_base::distribution::Marginal;

/// Usual number of harmonics.
const USUAL_HARMONICS: usize = 256;
/// Largest number of harmonics; a realisation stores 32 bytes for each.
const MOST_HARMONICS: usize = 100_000;

/// Method that generates realisations of the process.
///
/// Use [`Generator::Autoregressive`] by default: it supports every distribution, is exact at its grid points and is the
/// fastest. [`Generator::Spectral`] is for correlations without a recursion, and for comparison with the paper.
/// [`Generator::Jacobi`] is an alternative for a bounded friction coefficient whose dynamics matter: it is a diffusion
/// with a Beta distribution that slows down towards its bounds, whereas the rate of a translated process is constant in
/// the normal score. Its correlation needs no correction. [`Generator::Renewal`] is for friction that changes in
/// patches: it is constant over a patch and independent in the next.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Generator {
    /// Translated standard normal process from the exact recursion of a sampled Ornstein–Uhlenbeck process, g_{i+1} =
    /// φg_i + √(1 − φ²)ξ, or from its moving average over a window. Realisations have no end. Supports exponential and
    /// windowed exponential correlations.
    #[default]
    Autoregressive,
    /// Translated sum of harmonics with random frequencies and phases, after the paper. Supports every correlation
    /// without a window.
    Spectral {
        /// Number of harmonics, at most 100,000.
        harmonics: usize,
    },
    /// Diffusion dX = −θ(X − a/(a+b))ds + √(2θX(1 − X)/(a+b)) dB, θ = 1/ℓ, with a Beta distribution and exactly the
    /// correlation e^{−s/ℓ}. It uses the exact transition distribution between grid points. Supports Beta distributions
    /// only.
    Jacobi,
    /// Piecewise constant m on intervals of exponential length with mean ℓ, with an independent value in each, so m
    /// jumps at the points of a Poisson process. The correlation is exactly e^{−s/ℓ} for any distribution.
    Renewal,
}

impl Choice for Generator {
    const NOUN: &'static str = "generator";
    const ALL: &'static [Self] =
        &[Self::Autoregressive, Self::Spectral { harmonics: USUAL_HARMONICS }, Self::Jacobi, Self::Renewal];
    const NAMES: &'static [&'static str] = &["autoregressive", "spectral", "jacobi", "renewal"];

    fn name(self) -> &'static str {
        match self {
            Self::Autoregressive => Self::NAMES[0],
            Self::Spectral { .. } => Self::NAMES[1],
            Self::Jacobi => Self::NAMES[2],
            Self::Renewal => Self::NAMES[3],
        }
    }

    fn description(self) -> &'static str {
        match self {
            Self::Autoregressive => "Exact recursion of an Ornstein–Uhlenbeck process, translated",
            Self::Spectral { .. } => "Sum of 256 random harmonics, translated, after the paper",
            Self::Jacobi => "Diffusion with a Beta distribution and exactly exponential correlation",
            Self::Renewal => "Independent values over exponential lengths, with exactly exponential correlation",
        }
    }
}

impl Generator {
    /// Returns the exact recursion for the shapes that it supports, otherwise 256 harmonics. With 256 harmonics the
    /// excess kurtosis of the normal process is −0.006.
    pub fn for_shape(shape: CorrelationShape) -> Self {
        if shape.has_recursion() { Self::Autoregressive } else { Self::Spectral { harmonics: USUAL_HARMONICS } }
    }

    /// Returns whether m is a translated normal process; its correlation then differs from the correlation of the
    /// normal process.
    pub(super) fn translates(self) -> bool {
        matches!(self, Self::Autoregressive | Self::Spectral { .. })
    }

    /// Fails if the generator does not support this shape of correlation or this distribution.
    pub(super) fn check(self, shape: CorrelationShape, marginal: &Marginal) -> Result<(), ProcessError> {
        let makes = match self {
            Self::Autoregressive => shape.has_recursion(),
            Self::Spectral { harmonics } => {
                if !(1..=MOST_HARMONICS).contains(&harmonics) {
                    let (parameter, wanted) = ("number of harmonics", "from 1 to 100,000");
                    return Err(ProcessError::Parameter { parameter, value: harmonics as f64, wanted });
                }
                shape.spectral_quantile(0.5).is_some()
            }
            Self::Jacobi | Self::Renewal => shape.is_exponential(),
        };
        if !makes {
            let able = Self::for_shape(shape).name();
            return Err(ProcessError::Generator { generator: self.name(), correlation: shape.name(), able });
        }
        if self == Self::Jacobi && !matches!(marginal, Marginal::Beta { .. }) {
            return Err(ProcessError::Marginal {
                generator: self.name(),
                distribution: marginal.name(),
                wanted: "beta",
            });
        }
        Ok(())
    }
}
