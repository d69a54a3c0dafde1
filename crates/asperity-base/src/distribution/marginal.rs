//! Marginal distributions of heights, pressures and friction coefficients.

use serde::{Deserialize, Serialize};

use super::moments::{self, Exact};
use super::special::{
    beta_cdf, beta_quantile, beta_survival, gamma_cdf, gamma_quantile, gamma_survival, ln_beta, ln_gamma, ln_normal,
    standard_normal_cdf, standard_normal_quantile,
};
use super::{DistributionError, Johnson, JohnsonSystem, empirical, triangular};

/// Largest shapes of Beta, Weibull and Gamma distributions, and smallest σ of a lognormal one. The logarithm of the norming constant of
/// a Beta distribution is rounded, which changes quantiles by 1e-6 standard deviations at this shape; the others would be so narrow that
/// their values are equal in eight digits.
const LARGEST_BETA_SHAPE: f64 = 1e8;
const LARGEST_WEIBULL_SHAPE: f64 = 1e8;
const LARGEST_GAMMA_SHAPE: f64 = 1e16;
const SMALLEST_SIGMA: f64 = 1e-8;
/// Smallest standard deviation over the mean of a distribution that is standardised.
const LEAST_RELATIVE_STD: f64 = 1e-9;

/// Distribution on the real line.
///
/// The constructors check the parameters; [`Marginal::check`] checks a value created otherwise. Functions of a
/// distribution with parameters out of range return NaN.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Marginal {
    /// Normal distribution.
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
        /// Standard deviation of the logarithm, at least 1e-8.
        sigma: f64,
        /// Lower end of the support.
        shift: f64,
    },
    /// Weibull distribution: F(x) = 1 − exp(−((x − shift)/scale)^shape).
    Weibull {
        /// Shape, at most 1e8.
        shape: f64,
        /// Scale.
        scale: f64,
        /// Lower end of the support.
        shift: f64,
    },
    /// Gamma distribution: density ∝ (x − shift)^{shape−1} e^{−(x − shift)/scale}.
    Gamma {
        /// Shape, at most 1e16.
        shape: f64,
        /// Scale.
        scale: f64,
        /// Lower end of the support.
        shift: f64,
    },
    /// Beta distribution on [low, high]: density ∝ (x − low)^{a−1} (high − x)^{b−1}.
    Beta {
        /// First shape, at most 1e8.
        a: f64,
        /// Second shape, at most 1e8.
        b: f64,
        /// Lower end of the support.
        low: f64,
        /// Upper end of the support.
        high: f64,
    },
    /// Triangular distribution on [low, high]: the density rises linearly to the mode and falls linearly beyond it.
    Triangular {
        /// Lower end of the support.
        low: f64,
        /// Most probable value.
        mode: f64,
        /// Upper end of the support.
        high: f64,
    },
    /// Johnson's distribution: an elementary function of (x − ξ)/λ is normal.
    Johnson(Johnson),
    /// Empirical distribution: linear interpolation between sorted values at probabilities (i + ½)/n, with point masses
    /// for the half steps beyond the first and the last value.
    Empirical {
        /// Sorted values.
        sorted: Vec<f64>,
    },
}

impl Marginal {
    /// The standard normal distribution.
    pub const STANDARD_NORMAL: Self = Self::Normal { mean: 0.0, std: 1.0 };

    /// Creates the normal distribution with this mean and standard deviation.
    ///
    /// # Errors
    /// `std` is not positive, or a parameter is not finite.
    pub fn normal(mean: f64, std: f64) -> Result<Self, DistributionError> {
        Self::Normal { mean, std }.checked()
    }

    /// Creates the distribution of shift + e^{mu + sigma ξ}, ξ standard normal.
    ///
    /// # Errors
    /// `sigma` is not positive, or a parameter is not finite.
    pub fn lognormal(mu: f64, sigma: f64, shift: f64) -> Result<Self, DistributionError> {
        Self::Lognormal { mu, sigma, shift }.checked()
    }

    /// Creates the Weibull distribution; shape 1 is the exponential distribution.
    ///
    /// # Errors
    /// `shape` or `scale` is not positive, or a parameter is not finite.
    pub fn weibull(shape: f64, scale: f64, shift: f64) -> Result<Self, DistributionError> {
        Self::Weibull { shape, scale, shift }.checked()
    }

    /// Creates the Gamma distribution; shape 1 is the exponential distribution.
    ///
    /// # Errors
    /// `shape` or `scale` is not positive, or a parameter is not finite.
    pub fn gamma(shape: f64, scale: f64, shift: f64) -> Result<Self, DistributionError> {
        Self::Gamma { shape, scale, shift }.checked()
    }

    /// Creates the Beta distribution on [low, high].
    ///
    /// # Errors
    /// A shape is not positive, `high` is not above `low`, or a parameter is not finite.
    pub fn beta(a: f64, b: f64, low: f64, high: f64) -> Result<Self, DistributionError> {
        Self::Beta { a, b, low, high }.checked()
    }

    /// Creates the triangular distribution on [low, high] with its mode between them.
    ///
    /// # Errors
    /// `high` is not above `low`, `mode` lies outside [low, high], or a parameter is not finite.
    pub fn triangular(low: f64, mode: f64, high: f64) -> Result<Self, DistributionError> {
        Self::Triangular { low, mode, high }.checked()
    }

    /// Creates Johnson's distribution with these parameters.
    ///
    /// # Errors
    /// δ is not positive, λ is not positive (not zero for [`JohnsonSystem::Lognormal`]), or a parameter is not finite.
    pub fn johnson(
        system: JohnsonSystem,
        gamma: f64,
        delta: f64,
        xi: f64,
        lambda: f64,
    ) -> Result<Self, DistributionError> {
        Self::Johnson(Johnson { system, gamma, delta, xi, lambda }).checked()
    }

    /// Creates the empirical distribution of a sample in any order.
    ///
    /// # Errors
    /// Fewer than two values, a value that is not finite, or all values equal.
    pub fn empirical(mut values: Vec<f64>) -> Result<Self, DistributionError> {
        values.sort_by(f64::total_cmp);
        Self::Empirical { sorted: values }.checked()
    }

    /// Returns the name of the distribution: `normal`, `lognormal`, `weibull`, `gamma`, `beta`, `triangular`,
    /// `empirical`, or `johnson_su`, `johnson_sb`, `johnson_sl` and `johnson_sn`.
    pub fn name(&self) -> &'static str {
        match self {
            Self::Normal { .. } => "normal",
            Self::Lognormal { .. } => "lognormal",
            Self::Weibull { .. } => "weibull",
            Self::Gamma { .. } => "gamma",
            Self::Beta { .. } => "beta",
            Self::Triangular { .. } => "triangular",
            Self::Johnson(johnson) => johnson.system.name(),
            Self::Empirical { .. } => "empirical",
        }
    }

    /// Returns the names and values of the parameters; empty for an empirical distribution.
    pub fn parameters(&self) -> Vec<(&'static str, f64)> {
        match *self {
            Self::Normal { mean, std } => vec![("mean", mean), ("std", std)],
            Self::Lognormal { mu, sigma, shift } => vec![("mu", mu), ("sigma", sigma), ("shift", shift)],
            Self::Weibull { shape, scale, shift } | Self::Gamma { shape, scale, shift } => {
                vec![("shape", shape), ("scale", scale), ("shift", shift)]
            }
            Self::Beta { a, b, low, high } => vec![("a", a), ("b", b), ("low", low), ("high", high)],
            Self::Triangular { low, mode, high } => vec![("low", low), ("mode", mode), ("high", high)],
            Self::Johnson(Johnson { gamma, delta, xi, lambda, .. }) => {
                vec![("gamma", gamma), ("delta", delta), ("xi", xi), ("lambda", lambda)]
            }
            Self::Empirical { .. } => vec![],
        }
    }

    /// Returns the distribution of the same kind with these [`Marginal::parameters`], unchecked; an empirical
    /// distribution is unchanged.
    ///
    /// # Panics
    /// If there are fewer values than parameters.
    pub(super) fn with_parameters(&self, v: &[f64]) -> Self {
        match self {
            Self::Normal { .. } => Self::Normal { mean: v[0], std: v[1] },
            Self::Lognormal { .. } => Self::Lognormal { mu: v[0], sigma: v[1], shift: v[2] },
            Self::Weibull { .. } => Self::Weibull { shape: v[0], scale: v[1], shift: v[2] },
            Self::Gamma { .. } => Self::Gamma { shape: v[0], scale: v[1], shift: v[2] },
            Self::Beta { .. } => Self::Beta { a: v[0], b: v[1], low: v[2], high: v[3] },
            Self::Triangular { .. } => Self::Triangular { low: v[0], mode: v[1], high: v[2] },
            Self::Johnson(johnson) => {
                Self::Johnson(Johnson { gamma: v[0], delta: v[1], xi: v[2], lambda: v[3], ..*johnson })
            }
            Self::Empirical { .. } => self.clone(),
        }
    }

    /// Returns the distribution of a + bX with b > 0 and the given mean and standard deviation, where X has this
    /// distribution.
    ///
    /// # Errors
    /// A standard deviation that is not positive and finite, of this distribution or requested, or that is below 1e-9 of the mean, because
    /// values differ from the mean by a few roundings then.
    pub fn standardised(&self, mean: f64, std: f64) -> Result<Self, DistributionError> {
        let (own_mean, own_std) = (self.mean(), self.std());
        for value in [own_std, std] {
            if !(value.is_finite() && value > 0.0) {
                let (distribution, parameter, wanted) = (self.name(), "std", "positive and finite");
                return Err(DistributionError::Parameter { distribution, parameter, value, wanted });
            }
        }
        if own_std < LEAST_RELATIVE_STD * own_mean.abs() && !matches!(self, Self::Normal { .. }) {
            let (distribution, parameter) = (self.name(), "std");
            let wanted = "at least 1e-9 of the mean, or its values are rounded to a few";
            return Err(DistributionError::Parameter { distribution, parameter, value: own_std, wanted });
        }
        let scale = std / own_std;
        let at = |x: f64| mean + scale * (x - own_mean);
        Ok(match self {
            Self::Normal { .. } => Self::Normal { mean, std },
            Self::Lognormal { mu, sigma, shift } => {
                Self::Lognormal { mu: mu + scale.ln(), sigma: *sigma, shift: at(*shift) }
            }
            Self::Weibull { shape, scale: own, shift } => {
                Self::Weibull { shape: *shape, scale: scale * own, shift: at(*shift) }
            }
            Self::Gamma { shape, scale: own, shift } => {
                Self::Gamma { shape: *shape, scale: scale * own, shift: at(*shift) }
            }
            Self::Beta { a, b, low, high } => Self::Beta { a: *a, b: *b, low: at(*low), high: at(*high) },
            Self::Triangular { low, mode, high } => {
                Self::Triangular { low: at(*low), mode: at(*mode), high: at(*high) }
            }
            Self::Johnson(johnson) => {
                Self::Johnson(Johnson { xi: at(johnson.xi), lambda: scale * johnson.lambda, ..*johnson })
            }
            Self::Empirical { sorted } => Self::Empirical { sorted: sorted.iter().map(|x| at(*x)).collect() },
        })
    }

    /// Checks that every parameter is in its range.
    ///
    /// # Errors
    /// [`DistributionError::Parameter`] or [`DistributionError::Sample`] for the first violation.
    pub fn check(&self) -> Result<(), DistributionError> {
        let distribution = self.name();
        for (parameter, value) in self.parameters() {
            let positive = matches!(parameter, "std" | "sigma" | "shape" | "scale" | "a" | "b" | "delta");
            if !value.is_finite() || (positive && value <= 0.0) {
                let wanted = if positive { "positive and finite" } else { "finite" };
                return Err(DistributionError::Parameter { distribution, parameter, value, wanted });
            }
            let limit = match (distribution, parameter) {
                ("beta", "a" | "b") if value > LARGEST_BETA_SHAPE => {
                    "at most 1e8; such a distribution is practically normal, or a Gamma distribution"
                }
                ("weibull", "shape") if value > LARGEST_WEIBULL_SHAPE => "at most 1e8",
                ("gamma", "shape") if value > LARGEST_GAMMA_SHAPE => {
                    "at most 1e16; such a distribution is practically normal"
                }
                ("lognormal", "sigma") if value < SMALLEST_SIGMA => {
                    "at least 1e-8; such a distribution is practically normal"
                }
                _ => continue,
            };
            return Err(DistributionError::Parameter { distribution, parameter, value, wanted: limit });
        }
        match self {
            Self::Beta { low, high, .. } | Self::Triangular { low, high, .. } if high <= low => {
                Err(DistributionError::Parameter { distribution, parameter: "high", value: *high, wanted: "above low" })
            }
            Self::Triangular { low, mode, high } if mode < low || mode > high => {
                let wanted = "between low and high";
                Err(DistributionError::Parameter { distribution, parameter: "mode", value: *mode, wanted })
            }
            Self::Johnson(Johnson { system, lambda, .. }) => {
                let wanted = match system {
                    JohnsonSystem::Lognormal if *lambda == 0.0 => "not zero",
                    JohnsonSystem::Lognormal => return Ok(()),
                    _ if *lambda > 0.0 => return Ok(()),
                    _ => "positive and finite",
                };
                Err(DistributionError::Parameter { distribution, parameter: "lambda", value: *lambda, wanted })
            }
            Self::Empirical { sorted } => {
                let reason = match (sorted.first(), sorted.last()) {
                    _ if sorted.iter().any(|v| !v.is_finite()) => "a value is not finite",
                    (Some(first), Some(last)) if first == last => "all values are equal",
                    _ if sorted.len() < 2 => "at least two are needed",
                    _ if !sorted.is_sorted() => "they are not sorted",
                    _ => return Ok(()),
                };
                Err(DistributionError::Sample { distribution, n: sorted.len(), reason })
            }
            _ => Ok(()),
        }
    }

    fn checked(self) -> Result<Self, DistributionError> {
        self.check()?;
        Ok(self)
    }

    /// Returns the distribution function F(x).
    pub fn cdf(&self, x: f64) -> f64 {
        match self {
            Self::Normal { mean, std } => standard_normal_cdf((x - mean) / std),
            Self::Lognormal { mu, sigma, shift } => standard_normal_cdf(((x - shift).max(0.0).ln() - mu) / sigma),
            Self::Weibull { shape, scale, shift } => -(-((x - shift).max(0.0) / scale).powf(*shape)).exp_m1(),
            Self::Gamma { shape, scale, shift } => gamma_cdf(*shape, (x - shift) / scale),
            Self::Beta { a, b, low, high } => beta_cdf(*a, *b, (x - low) / (high - low)),
            Self::Triangular { low, mode, high } => triangular::cdf([*low, *mode, *high], x),
            Self::Johnson(johnson) => standard_normal_cdf(johnson.normal_of(x)),
            Self::Empirical { sorted } => empirical::cdf(sorted, x),
        }
    }

    /// Returns the survival function 1 − F(x), without cancellation in the upper tail.
    pub fn survival(&self, x: f64) -> f64 {
        match self {
            Self::Normal { mean, std } => standard_normal_cdf((mean - x) / std),
            Self::Lognormal { mu, sigma, shift } => standard_normal_cdf((mu - (x - shift).max(0.0).ln()) / sigma),
            Self::Weibull { shape, scale, shift } => (-((x - shift).max(0.0) / scale).powf(*shape)).exp(),
            Self::Gamma { shape, scale, shift } => gamma_survival(*shape, (x - shift) / scale),
            Self::Beta { a, b, low, high } => {
                let unit = (x - low) / (high - low);
                if unit <= 0.0 {
                    1.0
                } else if unit >= 1.0 {
                    0.0
                } else {
                    beta_survival(*a, *b, unit)
                }
            }
            Self::Triangular { low, mode, high } => triangular::survival([*low, *mode, *high], x),
            Self::Johnson(johnson) => standard_normal_cdf(-johnson.normal_of(x)),
            Self::Empirical { sorted } => 1.0 - empirical::cdf(sorted, x),
        }
    }

    /// Returns the quantile F⁻¹(probability); NaN outside [0, 1].
    pub fn quantile(&self, probability: f64) -> f64 {
        if !(0.0..=1.0).contains(&probability) {
            return f64::NAN;
        }
        self.quantile_of_tails(|| probability, || 1.0 - probability, || standard_normal_quantile(probability))
    }

    /// Returns the translation F⁻¹(Φ(g)) of a standard normal value g, with full precision in both tails.
    ///
    /// # References
    /// Grigoriu, *Applied Non-Gaussian Processes*, Prentice Hall 1995, ch. 3.
    pub fn translate(&self, g: f64) -> f64 {
        if g.is_nan() {
            return f64::NAN;
        }
        self.quantile_of_tails(|| standard_normal_cdf(g), || standard_normal_cdf(-g), || g)
    }

    /// Returns the quantile, of which the probabilities below and above and the standard normal quantile are computed only where
    /// they are needed.
    fn quantile_of_tails(&self, lower: impl Fn() -> f64, upper: impl Fn() -> f64, normal: impl Fn() -> f64) -> f64 {
        match self {
            Self::Normal { mean, std } => mean + std * normal(),
            Self::Lognormal { mu, sigma, shift } => shift + (mu + sigma * normal()).exp(),
            Self::Weibull { shape, scale, shift } => {
                let lower = lower();
                let exponential = if lower < 0.5 { -(-lower).ln_1p() } else { -upper().ln() };
                shift + scale * exponential.powf(1.0 / shape)
            }
            Self::Gamma { shape, scale, shift } => shift + scale * gamma_quantile(*shape, lower(), upper()),
            Self::Beta { a, b, low, high } => {
                let unit = beta_quantile(*a, *b, lower(), upper());
                // The ends are exact.
                if unit <= 0.5 { low + (high - low) * unit } else { high - (high - low) * (1.0 - unit) }
            }
            Self::Triangular { low, mode, high } => triangular::quantile([*low, *mode, *high], lower(), upper()),
            Self::Johnson(johnson) => johnson.value_of(normal()),
            Self::Empirical { sorted } => empirical::quantile(sorted, lower()),
        }
    }

    /// Returns the density; zero outside the support, +∞ at an end where it diverges, NaN for an empirical
    /// distribution.
    pub fn pdf(&self, x: f64) -> f64 {
        self.ln_pdf(x).exp()
    }

    /// Returns the logarithm of the density; −∞ outside the support, NaN for an empirical distribution.
    pub fn ln_pdf(&self, x: f64) -> f64 {
        match self {
            Self::Normal { mean, std } => ln_normal((x - mean) / std) - std.ln(),
            Self::Lognormal { mu, sigma, shift } => {
                let t = x - shift;
                if t > 0.0 { ln_normal((t.ln() - mu) / sigma) - (sigma * t).ln() } else { f64::NEG_INFINITY }
            }
            Self::Weibull { shape, scale, shift } => {
                let t = (x - shift) / scale;
                if t < 0.0 {
                    return f64::NEG_INFINITY;
                }
                (shape / scale).ln() + power_log(shape - 1.0, t) - t.powf(*shape)
            }
            Self::Gamma { shape, scale, shift } => {
                let t = (x - shift) / scale;
                if t < 0.0 {
                    return f64::NEG_INFINITY;
                }
                power_log(shape - 1.0, t) - t - ln_gamma(*shape) - scale.ln()
            }
            Self::Beta { a, b, low, high } => {
                let unit = (x - low) / (high - low);
                if !(0.0..=1.0).contains(&unit) {
                    return f64::NEG_INFINITY;
                }
                let rest = (high - x) / (high - low);
                power_log(a - 1.0, unit) + power_log(b - 1.0, rest) - ln_beta(*a, *b) - (high - low).ln()
            }
            Self::Triangular { low, mode, high } => triangular::ln_pdf([*low, *mode, *high], x),
            Self::Johnson(johnson) => johnson.ln_pdf(x),
            Self::Empirical { .. } => f64::NAN,
        }
    }

    /// Returns the mean.
    pub fn mean(&self) -> f64 {
        self.exact().mean
    }

    /// Returns the standard deviation.
    pub fn std(&self) -> f64 {
        self.exact().std
    }

    /// Returns the skewness E(x − m)³/σ³.
    pub fn skewness(&self) -> f64 {
        self.exact().skewness
    }

    /// Returns the excess kurtosis E(x − m)⁴/σ⁴ − 3.
    pub fn excess_kurtosis(&self) -> f64 {
        self.exact().excess_kurtosis
    }

    fn exact(&self) -> Exact {
        match self {
            Self::Normal { mean, std } => Exact { mean: *mean, std: *std, skewness: 0.0, excess_kurtosis: 0.0 },
            Self::Lognormal { mu, sigma, shift } => moments::lognormal(*mu, *sigma, *shift),
            Self::Weibull { shape, scale, shift } => moments::weibull(*shape, *scale, *shift),
            Self::Gamma { shape, scale, shift } => Exact {
                mean: shift + shape * scale,
                std: shape.sqrt() * scale,
                skewness: 2.0 / shape.sqrt(),
                excess_kurtosis: 6.0 / shape,
            },
            Self::Beta { a, b, low, high } => moments::beta(*a, *b, *low, *high),
            Self::Triangular { low, mode, high } => moments::triangular(*low, *mode, *high),
            Self::Johnson(johnson) => johnson.exact(),
            Self::Empirical { sorted } => moments::empirical(sorted),
        }
    }
}

/// Returns ln(t^exponent), with 0⁰ = 1.
fn power_log(exponent: f64, t: f64) -> f64 {
    if exponent == 0.0 { 0.0 } else { exponent * t.ln() }
}

#[cfg(test)]
pub(super) mod tests {
    use super::*;

    /// One distribution of each kind.
    pub(in crate::distribution) fn examples() -> Vec<Marginal> {
        vec![
            Marginal::normal(-2.0, 3.0).unwrap(),
            Marginal::lognormal(0.3, 0.7, -1.0).unwrap(),
            Marginal::weibull(1.7, 2.0, 0.5).unwrap(),
            Marginal::weibull(1.0, 1.0, 0.0).unwrap(),
            Marginal::gamma(2.5, 2.0, 0.5).unwrap(),
            Marginal::gamma(0.9, 2.0, 0.0).unwrap(),
            Marginal::beta(2.1, 5.0, 0.0, 1.0).unwrap(),
            Marginal::beta(0.6, 0.8, -1.0, 3.0).unwrap(),
            Marginal::triangular(-1.0, 0.5, 3.0).unwrap(),
            Marginal::johnson(JohnsonSystem::Unbounded, -1.1, 1.5, -1.0, 2.0).unwrap(),
            Marginal::johnson(JohnsonSystem::Bounded, 0.5, 0.8, -1.0, 2.0).unwrap(),
            Marginal::johnson(JohnsonSystem::Lognormal, 0.3, 2.5, 1.0, -2.0).unwrap(),
            Marginal::johnson(JohnsonSystem::Normal, 0.3, 0.5, 1.0, 2.0).unwrap(),
            Marginal::empirical(vec![3.0, 1.0, 1.5, 2.0, 4.0]).unwrap(),
        ]
    }

    #[test]
    fn a_standardised_distribution_is_shifted_and_stretched() {
        for text in [
            "normal:1,2",
            "lognormal:0.2,0.4,1",
            "weibull:1.5,2,-1",
            "gamma:1.5,2,-1",
            "beta:2.1,5,0,3",
            "triangular:0,2,3",
            "johnson:-1,5,2,3",
        ] {
            let marginal: Marginal = text.parse().unwrap();
            let moved = marginal.standardised(-3.0, 0.5).unwrap();
            let values: Vec<f64> = moved.parameters().into_iter().map(|(_, value)| value).collect();
            assert_eq!(marginal.with_parameters(&values), moved);
            assert!((moved.mean() + 3.0).abs() < 1e-12 && (moved.std() - 0.5).abs() < 1e-12, "{text}");
            for probability in [0.01, 0.3, 0.5, 0.9] {
                let wanted = -3.0 + 0.5 * (marginal.quantile(probability) - marginal.mean()) / marginal.std();
                assert!((moved.quantile(probability) - wanted).abs() < 1e-11, "{text}");
            }
        }
        let sample = Marginal::empirical(vec![0.0, 1.0, 5.0]).unwrap().standardised(0.0, 1.0).unwrap();
        assert!(sample.mean().abs() < 1e-15 && (sample.std() - 1.0).abs() < 1e-15);
        assert!(Marginal::STANDARD_NORMAL.standardised(0.0, 0.0).is_err());
    }

    #[test]
    fn the_quantile_inverts_the_distribution_function() {
        for marginal in examples() {
            for p in [1e-9, 1e-4, 0.12, 0.37, 0.5, 0.63, 0.88, 0.9999] {
                let x = marginal.quantile(p);
                if matches!(marginal, Marginal::Empirical { .. }) && !(0.1..0.9).contains(&p) {
                    assert!(x == marginal.quantile(0.0) || x == marginal.quantile(1.0));
                    continue;
                }
                // x is rounded, which the density converts to a probability.
                let rounding =
                    if marginal.name() == "empirical" { 0.0 } else { x.abs() * marginal.pdf(x) * f64::EPSILON / p };
                assert!(
                    (marginal.cdf(x) / p - 1.0).abs() < 2e-13 + rounding,
                    "{marginal:?} at {p}: F(F⁻¹) = {}",
                    marginal.cdf(x)
                );
                assert!((marginal.survival(x) + marginal.cdf(x) - 1.0).abs() < 1e-14);
            }
            assert!(marginal.quantile(-0.1).is_nan() && marginal.quantile(f64::NAN).is_nan());
        }
    }

    #[test]
    fn translation_is_the_quantile_of_the_normal_distribution_function_and_keeps_the_upper_tail() {
        for marginal in examples() {
            for g in [-3.0, -0.7, 0.0, 1.1, 2.5] {
                let direct = marginal.quantile(standard_normal_cdf(g));
                assert!((marginal.translate(g) - direct).abs() < 1e-12 * (1.0 + direct.abs()), "{marginal:?} at {g}");
            }
        }
        // F⁻¹(Φ(g)) of the exponential distribution is −ln Φ(−g): at g = 12, where Φ(g) rounds to one, 75.4106730015
        // (mpmath).
        let exponential = Marginal::weibull(1.0, 1.0, 0.0).unwrap();
        assert!((exponential.translate(12.0) - 75.410_673_001_568_8).abs() < 1e-11);
    }

    #[test]
    fn the_density_is_the_slope_of_the_distribution_function() {
        for marginal in examples().into_iter().filter(|marginal| marginal.name() != "empirical") {
            for p in [0.1, 0.4, 0.8] {
                let (x, h) = (marginal.quantile(p), 1e-5);
                let slope = (marginal.cdf(x + h) - marginal.cdf(x - h)) / (2.0 * h);
                assert!((slope / marginal.pdf(x) - 1.0).abs() < 1e-7, "{marginal:?} at {x}: {slope}");
            }
            assert_eq!(marginal.pdf(1e300), 0.0);
        }
        assert_eq!(crate::distribution::standard_normal_pdf(0.0), Marginal::STANDARD_NORMAL.pdf(0.0));
        assert!((Marginal::beta(1.0, 1.0, 0.0, 2.0).unwrap().pdf(0.0) - 0.5).abs() < 1e-14);
    }

    #[test]
    fn density_is_zero_outside_the_support() {
        for (text, below, above) in [
            ("lognormal:0,1,2", Some(1.0), None),
            ("weibull:1.5,1,2", Some(1.0), None),
            ("gamma:1.5,1,2", Some(1.0), None),
            ("beta:2,3,-1,1", Some(-2.0), Some(2.0)),
            ("triangular:-1,0,1", Some(-2.0), Some(2.0)),
            ("johnson_sb:0.5,1,-1,2", Some(-2.0), Some(2.0)),
            ("johnson_sl:0.5,1,2,1", Some(1.0), None),
            ("johnson_sl:0.5,1,2,-1", None, Some(3.0)),
        ] {
            let marginal: Marginal = text.parse().unwrap();
            for (x, cdf) in [(below, 0.0), (above, 1.0)].into_iter().filter_map(|(x, cdf)| Some((x?, cdf))) {
                assert_eq!(
                    (marginal.cdf(x), marginal.survival(x), marginal.pdf(x)),
                    (cdf, 1.0 - cdf, 0.0),
                    "{text} at {x}"
                );
            }
            assert!(marginal.quantile(0.0) < marginal.quantile(1.0), "{text}");
        }
    }

    #[test]
    fn a_parameter_outside_its_range_is_named() {
        let error = Marginal::beta(2.1, -5.0, 0.0, 1.0).unwrap_err();
        assert_eq!(error.to_string(), "beta: b is -5, but must be positive and finite");
        assert!(Marginal::beta(2.1, 5.0, 1.0, 1.0).is_err());
        let error = Marginal::beta(1.1e8, 2.0, 0.0, 1.0).unwrap_err().to_string();
        assert!(error.starts_with("beta: a is 110000000, but must be at most 1e8"), "{error}");
        for text in ["gamma:2,1,1e20", "triangular:1e12,1e12,1000000000001", "normal:1e20,1"] {
            let standardised = text.parse::<Marginal>().unwrap().standardised(0.0, 1.0);
            assert_eq!(standardised.is_ok(), text.starts_with("normal"), "{text}: {standardised:?}");
        }
        for text in ["weibull:1.1e8,1", "gamma:1.1e16,1", "lognormal:0,9e-9"] {
            let error = text.parse::<Marginal>().unwrap_err().to_string();
            assert!(error.contains("must be at ") && error.contains("1e"), "{text}: {error}");
        }
        assert!(Marginal::normal(f64::NAN, 1.0).is_err());
        assert!(Marginal::empirical(vec![1.0, f64::NAN]).is_err());
        assert!(Marginal::empirical(vec![1.0, 1.0]).is_err());
        assert!(Marginal::empirical(vec![]).is_err());
        assert!(Marginal::Empirical { sorted: vec![2.0, 1.0] }.check().is_err());
    }
}
