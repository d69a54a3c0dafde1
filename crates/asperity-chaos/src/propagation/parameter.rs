//! Distributions of uncertain parameters.

use crate::PolynomialFamily;
use asperity_base::distribution::{DistributionError, Marginal};
use asperity_base::stats::{Interval, NORMAL_95};
use serde::Serialize;

/// Uncertain parameter that is independent of all others.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Parameter {
    name: String,
    marginal: Marginal,
    family: PolynomialFamily,
}

impl Parameter {
    /// Creates a parameter with the given distribution.
    ///
    /// # Errors
    /// A parameter of the distribution is out of range.
    pub fn new(name: &str, marginal: Marginal) -> Result<Self, DistributionError> {
        marginal.check()?;
        let uniform = matches!(marginal, Marginal::Beta { a: 1.0, b: 1.0, .. });
        let family = if uniform { PolynomialFamily::Legendre } else { PolynomialFamily::Hermite };
        Ok(Self { name: name.into(), marginal, family })
    }

    /// Creates a normal parameter.
    ///
    /// # Errors
    /// The standard deviation is not positive, or a number is not finite.
    pub fn normal(name: &str, mean: f64, std: f64) -> Result<Self, DistributionError> {
        Self::new(name, Marginal::normal(mean, std)?)
    }

    /// Creates a lognormal parameter with the given mean and standard deviation.
    ///
    /// # Errors
    /// The mean or the standard deviation is not positive.
    pub fn lognormal(name: &str, mean: f64, std: f64) -> Result<Self, DistributionError> {
        let sigma = (std / mean).powi(2).ln_1p().sqrt();
        positive("mean", mean)?;
        positive("std", std)?;
        Self::new(name, Marginal::lognormal(mean.ln() - 0.5 * sigma * sigma, sigma, 0.0)?)
    }

    /// Creates a parameter that is uniform between two values.
    ///
    /// # Errors
    /// `high` is not above `low`.
    pub fn uniform(name: &str, low: f64, high: f64) -> Result<Self, DistributionError> {
        Self::new(name, Marginal::beta(1.0, 1.0, low, high)?)
    }

    /// Creates a normal parameter that lies in the interval with 95 % probability.
    ///
    /// # Errors
    /// The interval has no width.
    pub fn normal_within(name: &str, interval: Interval) -> Result<Self, DistributionError> {
        let Interval { low, high } = interval;
        Self::normal(name, 0.5 * (low + high), 0.5 * (high - low) / NORMAL_95)
    }

    /// Creates a lognormal parameter that lies in a positive interval with 95 % probability.
    ///
    /// # Errors
    /// The interval has no width or reaches zero.
    pub fn lognormal_within(name: &str, interval: Interval) -> Result<Self, DistributionError> {
        positive("low", interval.low)?;
        let (low, high) = (interval.low.ln(), interval.high.ln());
        Self::new(name, Marginal::lognormal(0.5 * (low + high), 0.5 * (high - low) / NORMAL_95, 0.0)?)
    }

    /// Returns the name.
    pub fn name(&self) -> &str {
        &self.name
    }

    /// Returns the distribution.
    pub fn marginal(&self) -> &Marginal {
        &self.marginal
    }

    /// Returns the polynomial family of the standard variable ξ.
    pub(super) fn family(&self) -> PolynomialFamily {
        self.family
    }

    /// Returns the parameter value at the standard variable `xi`.
    pub(super) fn at(&self, xi: f64) -> f64 {
        match self.family {
            PolynomialFamily::Hermite => self.marginal.translate(xi),
            PolynomialFamily::Legendre => self.marginal.quantile(0.5 * (1.0 + xi)),
        }
    }
}

fn positive(parameter: &'static str, value: f64) -> Result<(), DistributionError> {
    if value.is_finite() && value > 0.0 {
        return Ok(());
    }
    Err(DistributionError::Parameter { distribution: "lognormal", parameter, value, wanted: "positive and finite" })
}
