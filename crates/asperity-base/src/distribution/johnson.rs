//! Johnson's system of distributions, with independent skewness and kurtosis.
//!
//! The variable g = γ + δ f((x − ξ)/λ) is standard normal, so densities, distribution functions, quantiles and
//! translations have closed forms. Exactly one such distribution has any given skewness and kurtosis > 1 + skewness²:
//! the lognormal one on a line, the unbounded one above it, the bounded one below it, and the normal one at (0, 3).
//!
//! # References
//! Johnson, *Biometrika* **36** (1949) 149, <https://doi.org/10.1093/biomet/36.1-2.149>.

mod bounded;
mod by_moments;
#[cfg(test)]
mod tests;
mod unbounded;

use serde::{Deserialize, Serialize};

use super::moments::{Exact, lognormal};
use super::special::ln_normal;

/// Function f of a Johnson distribution, which determines the support.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum JohnsonSystem {
    /// S_U: f(u) = arsinh u, on the real line.
    Unbounded,
    /// S_B: f(u) = ln(u/(1 − u)), on (ξ, ξ + λ).
    Bounded,
    /// S_L: f(u) = ln u, on the side of ξ given by the sign of λ. For λ < 0, γ + δ f is −g rather than g, so that x
    /// increases with g. The distribution depends on γ and λ only through e^{−γ/δ}λ.
    Lognormal,
    /// S_N: f(u) = u.
    Normal,
}

impl JohnsonSystem {
    /// Every system.
    pub const ALL: [Self; 4] = [Self::Unbounded, Self::Bounded, Self::Lognormal, Self::Normal];

    /// Returns the name of the distribution: `johnson_su`, `johnson_sb`, `johnson_sl` or `johnson_sn`.
    pub fn name(self) -> &'static str {
        match self {
            Self::Unbounded => "johnson_su",
            Self::Bounded => "johnson_sb",
            Self::Lognormal => "johnson_sl",
            Self::Normal => "johnson_sn",
        }
    }
}

/// Distribution of x with γ + δ f((x − ξ)/λ) standard normal, for the f of [`JohnsonSystem`].
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct Johnson {
    /// The function f.
    pub system: JohnsonSystem,
    /// γ: shape, with the sign of −skewness for S_U and of the skewness for S_B.
    pub gamma: f64,
    /// δ > 0: shape; small values are far from normal.
    pub delta: f64,
    /// ξ: location, in the unit of x.
    pub xi: f64,
    /// λ: scale, in the unit of x; positive except for S_L.
    pub lambda: f64,
}

impl Johnson {
    /// Returns the standard normal value g of x; ±∞ beyond the support.
    pub(super) fn normal_of(&self, x: f64) -> f64 {
        let from_low = x - self.xi;
        let f = match self.system {
            JohnsonSystem::Unbounded => (from_low / self.lambda).asinh(),
            JohnsonSystem::Bounded => {
                (from_low.max(0.0) / self.lambda).ln() - ((self.lambda - from_low).max(0.0) / self.lambda).ln()
            }
            JohnsonSystem::Lognormal => (from_low / self.lambda).max(0.0).ln(),
            JohnsonSystem::Normal => from_low / self.lambda,
        };
        self.direction() * (self.gamma + self.delta * f)
    }

    /// Returns the x of a standard normal value g.
    pub(super) fn value_of(&self, g: f64) -> f64 {
        let t = (self.direction() * g - self.gamma) / self.delta;
        let (xi, lambda) = (self.xi, self.lambda);
        match self.system {
            JohnsonSystem::Unbounded => xi + lambda * t.sinh(),
            // The ends are exact.
            JohnsonSystem::Bounded if t <= 0.0 => xi + lambda * (1.0 / (1.0 + (-t).exp())),
            JohnsonSystem::Bounded => (xi + lambda) - lambda * (1.0 / (1.0 + t.exp())),
            JohnsonSystem::Lognormal => xi + lambda * t.exp(),
            JohnsonSystem::Normal => xi + lambda * t,
        }
    }

    /// Returns the logarithm of the density; −∞ outside the support.
    pub(super) fn ln_pdf(&self, x: f64) -> f64 {
        let u = (x - self.xi) / self.lambda;
        // −ln df/du.
        let stretch = match self.system {
            JohnsonSystem::Unbounded => 0.5 * (u * u).ln_1p(),
            JohnsonSystem::Bounded if u > 0.0 && u < 1.0 => u.ln() + (1.0 - u).ln(),
            JohnsonSystem::Lognormal if u > 0.0 => u.ln(),
            JohnsonSystem::Bounded | JohnsonSystem::Lognormal => return f64::NEG_INFINITY,
            JohnsonSystem::Normal => 0.0,
        };
        ln_normal(self.normal_of(x)) + (self.delta / self.lambda.abs()).ln() - stretch
    }

    /// Returns the moments of x.
    pub(super) fn exact(&self) -> Exact {
        let Self { gamma, delta, xi, lambda, .. } = *self;
        let unit = match self.system {
            JohnsonSystem::Unbounded => unbounded::unit_moments(gamma, delta),
            JohnsonSystem::Bounded => bounded::unit_moments(gamma, delta),
            JohnsonSystem::Lognormal => lognormal(-gamma / delta, 1.0 / delta, 0.0),
            JohnsonSystem::Normal => {
                Exact { mean: -gamma / delta, std: 1.0 / delta, skewness: 0.0, excess_kurtosis: 0.0 }
            }
        };
        Exact {
            mean: xi + lambda * unit.mean,
            std: lambda.abs() * unit.std,
            skewness: unit.skewness * self.direction(),
            ..unit
        }
    }

    /// Returns −1 if x decreases with γ + δ f.
    fn direction(&self) -> f64 {
        if self.system == JohnsonSystem::Lognormal && self.lambda < 0.0 { -1.0 } else { 1.0 }
    }
}
