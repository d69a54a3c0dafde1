//! Johnson's system of distributions: skewness and kurtosis free of each other.
//!
//! A standard normal g is the function γ + δ f((x − ξ)/λ) of x, so densities, distribution functions, quantiles and
//! translations are closed forms. Every pair with kurtosis > 1 + skewness² is the shape of exactly one such
//! distribution: on a line the lognormal one, above it the unbounded one, below it the bounded one, at (0, 3) the
//! normal one.
//!
//! # References
//! Johnson, *Biometrika* **36** (1949) 149, <https://doi.org/10.1093/biomet/36.1-2.149>.

mod bounded;
mod by_moments;
#[cfg(test)]
mod tests;
mod unbounded;

use serde::{Deserialize, Serialize};

use super::marginal::ln_normal;
use super::moments::{Exact, lognormal};

/// The function f of a Johnson distribution, and with it where the distribution lives.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum JohnsonSystem {
    /// S_U: f(u) = arsinh u, on the whole line.
    Unbounded,
    /// S_B: f(u) = ln(u/(1 − u)), on (ξ, ξ + λ).
    Bounded,
    /// S_L: f(u) = ln u, beyond ξ on the side of λ, which may be negative. Then −g, not g, is γ + δ f, so that x grows
    /// with g. Only e^{−γ/δ}λ counts, not γ and λ apart.
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

/// A distribution whose γ + δ f((x − ξ)/λ) is standard normal, f as [`JohnsonSystem`] says.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct Johnson {
    /// The function f.
    pub system: JohnsonSystem,
    /// γ: shape; its sign is that of −skewness for S_U and of the skewness for S_B.
    pub gamma: f64,
    /// δ > 0: shape; the smaller, the farther from normal.
    pub delta: f64,
    /// ξ: location, in the unit of x.
    pub xi: f64,
    /// λ: scale, in the unit of x; positive but for S_L.
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
            // Each end is reached exactly.
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

    /// Returns −1 where x falls with γ + δ f.
    fn direction(&self) -> f64 {
        if self.system == JohnsonSystem::Lognormal && self.lambda < 0.0 { -1.0 } else { 1.0 }
    }
}
