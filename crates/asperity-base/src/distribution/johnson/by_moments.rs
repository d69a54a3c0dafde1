//! Johnson distribution with given moments.

use super::{Johnson, JohnsonSystem, bounded, unbounded};
use crate::distribution::{DistributionError, Marginal};

/// Tolerance of skewness and excess kurtosis for the normal distribution.
const NORMAL: f64 = 1e-9;
/// Relative tolerance of the kurtosis for the lognormal distribution.
const LOGNORMAL: f64 = 1e-12;

impl Marginal {
    /// Creates the Johnson distribution of this mean, standard deviation, skewness and excess kurtosis (0 for the
    /// normal distribution).
    ///
    /// Every shape with kurtosis > 1 + skewness² is possible, except within about 0.2 % of two point masses. The
    /// lognormal distribution has γ = 0, the normal one γ = 0, δ = 1.
    ///
    /// # References
    /// Hill, Hill & Holder, *Appl. Statist.* **25** (1976) 180, algorithm AS 99, <https://doi.org/10.2307/2346692>, for
    /// the choice of the system; S_U is solved as in Tuenter, *J. Stat. Comput. Simul.* **70** (2001) 325.
    ///
    /// # Errors
    /// [`DistributionError::Infeasible`] for shapes that no distribution has, [`DistributionError::Moments`] for shapes
    /// too close to two point masses, [`DistributionError::Parameter`] for a standard deviation that is not positive or
    /// a moment that is not finite.
    pub fn johnson_with_moments(
        mean: f64,
        std: f64,
        skewness: f64,
        excess_kurtosis: f64,
    ) -> Result<Self, DistributionError> {
        let moments = [("mean", mean), ("std", std), ("skewness", skewness), ("excess_kurtosis", excess_kurtosis)];
        for (parameter, value) in moments {
            let positive = parameter == "std";
            if !value.is_finite() || (positive && value <= 0.0) {
                let wanted = if positive { "positive and finite" } else { "finite" };
                return Err(DistributionError::Parameter { distribution: "johnson", parameter, value, wanted });
            }
        }
        let kurtosis = excess_kurtosis + 3.0;
        let least = 1.0 + skewness * skewness;
        if kurtosis <= least {
            return Err(DistributionError::Infeasible { skewness, kurtosis, least });
        }
        let johnson = unit_distribution(skewness.abs(), excess_kurtosis).ok_or(DistributionError::Moments {
            distribution: "johnson",
            skewness,
            kurtosis,
            reason: "the distribution is nearly two point masses; the kurtosis must exceed 1 + skewness² by more",
        })?;
        let mirrored = if skewness < 0.0 { johnson.mirrored() } else { johnson };
        Self::Johnson(mirrored).standardised(mean, std)
    }
}

impl Johnson {
    /// Returns the distribution of −x.
    fn mirrored(self) -> Self {
        let Self { system, gamma, delta, xi, lambda } = self;
        match system {
            JohnsonSystem::Unbounded | JohnsonSystem::Normal => Self { gamma: -gamma, xi: -xi, ..self },
            JohnsonSystem::Bounded => Self { gamma: -gamma, xi: -xi - lambda, ..self },
            JohnsonSystem::Lognormal => Self { system, gamma, delta, xi: -xi, lambda: -lambda },
        }
    }
}

/// Returns a distribution of this shape, with arbitrary mean and standard deviation; skewness ≥ 0.
fn unit_distribution(skewness: f64, excess: f64) -> Option<Johnson> {
    let skewness = if skewness <= NORMAL { 0.0 } else { skewness };
    if skewness == 0.0 && excess.abs() <= NORMAL {
        return Some(Johnson { system: JohnsonSystem::Normal, gamma: 0.0, delta: 1.0, xi: 0.0, lambda: 1.0 });
    }
    let d = lognormal_d(skewness);
    let lognormal = d * (16.0 + d * (15.0 + d * (6.0 + d)));
    let above = excess - lognormal;
    let (system, gamma, delta) = if skewness > 0.0 && above.abs() <= LOGNORMAL * (1.0 + lognormal) {
        (JohnsonSystem::Lognormal, 0.0, 1.0 / d.ln_1p().sqrt())
    } else if above > 0.0 {
        let (gamma, delta) = unbounded::solve(skewness, excess, d)?;
        (JohnsonSystem::Unbounded, gamma, delta)
    } else {
        let (gamma, delta) = bounded::solve(skewness, excess, d)?;
        (JohnsonSystem::Bounded, gamma, delta)
    };
    Some(Johnson { system, gamma, delta, xi: 0.0, lambda: 1.0 })
}

/// Returns d = e^{σ²} − 1 of the lognormal distribution of this skewness: the root of d(3 + d)² = skewness².
pub(super) fn lognormal_d(skewness: f64) -> f64 {
    let square = skewness * skewness;
    // The function is convex, so Newton's method converges monotonically from the right of the root.
    let mut d = f64::min(square / 9.0, square.cbrt());
    for _ in 0..100 {
        let step = (d * (3.0 + d).powi(2) - square) / (3.0 * (3.0 + d) * (1.0 + d));
        d -= step;
        if step.abs() <= 1e-16 * d {
            break;
        }
    }
    d
}
