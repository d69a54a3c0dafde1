//! The ways to make a friction process.

use serde::{Deserialize, Serialize};

use super::{CorrelationShape, ProcessError, positive};
use asperity_base::law::Marginal;

/// How the process is made.
///
/// Take [`Generator::Autoregressive`] unless there is a reason: it makes every law, is exact at its knots, and the fastest.
/// [`Generator::Spectral`] is for correlations without a recursion, and for the paper's way. [`Generator::Jacobi`] is the
/// alternative for a bounded friction coefficient whose *dynamics* matter: it is a diffusion of Beta law that slows down
/// towards its bounds, where a translated process keeps its pace in the score, and its correlation needs no correction.
/// [`Generator::Renewal`] is for friction that changes by patches: constant over a patch, then something else.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Generator {
    /// A translated standard normal process made by the exact recursion of a sampled Ornstein–Uhlenbeck process, g_{i+1} =
    /// φg_i + √(1 − φ²)ξ, or of its moving average over a window; endless. For exponential and windowed exponential
    /// correlations.
    #[default]
    Autoregressive,
    /// A translated sum of harmonics with random frequencies and phases, after the paper. For every correlation without a
    /// window.
    Spectral {
        /// Number of harmonics.
        harmonics: usize,
    },
    /// The diffusion dX = −θ(X − a/(a+b))ds + √(2θX(1 − X)/(a+b)) dB, θ = 1/ℓ, of Beta law and of correlation e^{−s/ℓ}
    /// exactly, with the exact transition law from knot to knot. Only for Beta laws.
    Jacobi,
    /// m is constant over intervals of exponential length of mean ℓ and a fresh draw from the law in each: it jumps, at the
    /// points of a Poisson process. The correlation is e^{−s/ℓ} exactly, whatever the law.
    Renewal,
}

impl Generator {
    /// The recursion where it makes a shape, which is exact, and otherwise 256 harmonics, with which the excess kurtosis of the
    /// normal process is −0.006.
    pub fn of(shape: CorrelationShape) -> Self {
        if shape.has_recursion() { Self::Autoregressive } else { Self::Spectral { harmonics: 256 } }
    }

    /// Name as in files: `autoregressive`, `spectral`, `jacobi`, `renewal`.
    pub fn name(self) -> &'static str {
        match self {
            Self::Autoregressive => "autoregressive",
            Self::Spectral { .. } => "spectral",
            Self::Jacobi => "jacobi",
            Self::Renewal => "renewal",
        }
    }

    /// Whether m is a translated normal process, so that its correlation is not the normal process's.
    pub(super) fn translates(self) -> bool {
        matches!(self, Self::Autoregressive | Self::Spectral { .. })
    }

    /// Fails unless it makes this shape of correlation and this law.
    pub(super) fn check(self, shape: CorrelationShape, law: &Marginal) -> Result<(), ProcessError> {
        let makes = match self {
            Self::Autoregressive => shape.has_recursion(),
            Self::Spectral { harmonics } => {
                positive("number of harmonics", harmonics as f64)?;
                shape.spectral_quantile(0.5).is_some()
            }
            Self::Jacobi | Self::Renewal => shape.is_exponential(),
        };
        if !makes {
            let able = Self::of(shape).name();
            return Err(ProcessError::Generator { generator: self.name(), correlation: shape.name(), able });
        }
        if self == Self::Jacobi && !matches!(law, Marginal::Beta { .. }) {
            return Err(ProcessError::Marginal { generator: self.name(), law: law.name(), wanted: "beta" });
        }
        Ok(())
    }
}
