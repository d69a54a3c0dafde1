//! Propagation of uncertain parameters through an expensive, noisy response.
//!
//! [`Propagation`] selects the parameter values at which the response is evaluated, and fits a polynomial chaos
//! expansion to the results. It returns the mean, standard deviation and distribution of the response over the
//! parameters, and Sobol' indices of the parameters.
//!
//! # Noise
//!
//! A response that is an average over few random samples is noisy. If all design points use the *same* samples, their
//! errors are correlated: most of the noise shifts all responses together, and only the remainder varies from point to
//! point. The standard error of each point cannot separate the two parts. The noise is therefore described by the
//! response *without each of the samples* ([`Observed::without`]). These values determine the standard error of the
//! mean over the parameters (the common part) and the fraction of the variance over the points that is due to noise
//! ([`Noise`]). Intervals of moments and indices include both.
//!
//! ```
//! use asperity_chaos::{Observed, Parameter, Propagation, Resamples};
//!
//! let parameters = vec![Parameter::normal("a", 1.0, 0.3)?, Parameter::normal("b", 2.0, 0.4)?];
//! let propagation = Propagation::new(parameters, 16, 7)?;
//! let values: Vec<f64> = (0..16).map(|k| propagation.point(k)).map(|x| x[0] + x[1]).collect();
//! let found = propagation.respond(&Observed::exact(&values), &Resamples::new(1))?;
//! assert!((found.mean.value - 3.0).abs() < 1e-12 && (found.std.value - 0.5).abs() < 1e-12);
//! let indices = found.indices.unwrap();
//! assert!((indices.total[0].value - 0.36).abs() < 1e-12);
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```

mod parameter;
mod replicate;
#[cfg(test)]
mod tests;

use thiserror::Error;

pub use parameter::Parameter;
pub use replicate::{NoIndices, Noise, Observed, ParameterIndices};

use super::{
    Basis, BasisError, Design, Expansion, MultiIndexSet, RegressionError, Resamples, ResamplesError, SampleEstimate,
    SamplingError, SamplingMethod, Truncation,
};
use asperity_base::distribution::DistributionError;
use asperity_base::stats::{Interval, Moments, quantile_sorted};
use replicate::Samples;

/// Truncations that are tried: degree and exponent of [`Truncation`]. With q = ½, degree 2 has no interactions.
const TRUNCATIONS: [(usize, f64); 5] = [(1, 1.0), (2, 0.5), (2, 1.0), (3, 0.75), (3, 1.0)];
/// Number of points required per coefficient.
const POINTS_PER_TERM: usize = 3;
/// Minimum number of points per coefficient of a linear response.
const LEAST_POINTS_PER_TERM: usize = 4;
/// Smallest fraction of points that must have a response.
const VALID_FRACTION: f64 = 0.9;
/// Number of draws from the expansion that represent the distribution of the response.
const DRAWS: usize = 4096;
/// Ratio of standard deviation to mean below which a response counts as constant.
const ROUNDING: f64 = 1e-12;

/// Reason why uncertain parameters could not be propagated.
#[derive(Debug, Clone, PartialEq, Error)]
#[non_exhaustive]
pub enum PropagationError {
    /// The list of parameters is empty.
    #[error("there is no uncertain parameter")]
    NoParameter,
    /// The design is too small for a response that is linear in all parameters.
    #[error("a design of {points} points; {parameters} uncertain parameters need at least {wanted}")]
    TooFewPoints {
        /// Requested number of points.
        points: usize,
        /// Number of parameters.
        parameters: usize,
        /// Minimum number of points.
        wanted: usize,
    },
    /// A parameter has an invalid distribution.
    #[error(transparent)]
    Distribution(#[from] DistributionError),
    /// The design could not be created.
    #[error(transparent)]
    Design(#[from] SamplingError),
    /// The terms of an expansion could not be created.
    #[error(transparent)]
    Basis(#[from] BasisError),
    /// A setting of the bootstrap is out of range.
    #[error(transparent)]
    Resamples(#[from] ResamplesError),
    /// The number of responses differs from the number of points.
    #[error("{values} responses at {points} points")]
    Length {
        /// Responses given.
        values: usize,
        /// Points of the design.
        points: usize,
    },
    /// Too few points have a response, so the remaining points do not represent the distribution of the parameters.
    #[error("only {valid} of {points} points have a response")]
    TooFewValid {
        /// Points with a response.
        valid: usize,
        /// All points.
        points: usize,
    },
    /// No set of terms could be fitted.
    #[error(transparent)]
    Regression(#[from] RegressionError),
}

/// Independent uncertain parameters with a maximin Latin hypercube design.
#[derive(Debug, Clone)]
pub struct Propagation {
    parameters: Vec<Parameter>,
    seed: u64,
    /// Standard variables ξ of each point.
    xi_samples: Vec<Vec<f64>>,
}

/// Distribution of a response over its parameters.
#[derive(Debug, Clone, PartialEq)]
pub struct Propagated {
    /// Mean over the parameters.
    pub mean: SampleEstimate,
    /// Standard deviation over the parameters.
    pub std: SampleEstimate,
    /// Chaos expansion; constant if the response is constant or unpredictable.
    pub expansion: Expansion,
    /// Mean square error of predicting each point from the others, divided by the variance; 0 for a constant response.
    pub leave_one_out: f64,
    /// Sobol' indices, or the reason why there are none.
    pub indices: Result<ParameterIndices, NoIndices>,
    /// Noise of the random samples.
    pub noise: Noise,
    /// Indices of the points without a response, which are left out.
    pub failed: Vec<usize>,
    /// Sorted draws of the response over the distribution of the parameters.
    marginal: Vec<f64>,
}

impl Propagated {
    /// Returns a quantile of the response over the distribution of the parameters.
    ///
    /// It is computed from the expansion, or from the values at the points if nothing predicts the response.
    ///
    /// # Panics
    /// If the probability is outside [0, 1].
    pub fn quantile(&self, probability: f64) -> f64 {
        quantile_sorted(&self.marginal, probability)
    }

    /// Returns the interval that contains the response for 95 % of the parameters.
    pub fn band(&self) -> Interval {
        Interval { low: self.quantile(0.025), high: self.quantile(0.975) }
    }
}

impl Propagation {
    /// Plans a design of `points` points; equal (seed, parameters) give equal points.
    ///
    /// # Errors
    /// There is no parameter, fewer than four points per parameter and constant, or more than 2,000 points.
    pub fn new(parameters: Vec<Parameter>, points: usize, seed: u64) -> Result<Self, PropagationError> {
        let wanted = Self::least_points(parameters.len());
        if parameters.is_empty() {
            return Err(PropagationError::NoParameter);
        }
        if points < wanted {
            return Err(PropagationError::TooFewPoints { points, parameters: parameters.len(), wanted });
        }
        let method = SamplingMethod::MaximinLatinHypercube;
        let design = Design::new(method, seed, "chaos/propagation", points, parameters.len())?;
        let xi_samples = (0..points).map(|k| xi(&parameters, &design.unit(k))).collect();
        Ok(Self { parameters, seed, xi_samples })
    }

    /// Returns the minimum number of points of a design.
    pub fn least_points(parameters: usize) -> usize {
        LEAST_POINTS_PER_TERM * (parameters + 1)
    }

    /// Returns the parameters.
    pub fn parameters(&self) -> &[Parameter] {
        &self.parameters
    }

    /// Returns the number of points.
    pub fn points(&self) -> usize {
        self.xi_samples.len()
    }

    /// Returns the values of the parameters at point `k`.
    ///
    /// # Panics
    /// If there is no such point.
    pub fn point(&self, k: usize) -> Vec<f64> {
        self.parameters.iter().zip(&self.xi_samples[k]).map(|(parameter, xi)| parameter.at(*xi)).collect()
    }

    /// Adds a point, given by the standard variables ξ of the parameters. The expansion may use points that do not follow the
    /// distribution of the parameters.
    ///
    /// # Panics
    /// If the number of variables differs from the number of parameters.
    pub fn push(&mut self, xi: Vec<f64>) {
        assert_eq!(xi.len(), self.parameters.len(), "one standard variable per parameter");
        self.xi_samples.push(xi);
    }

    /// Estimates the distribution of the response over the parameters, with intervals from `resamples`.
    ///
    /// Expansions of degree up to three with at least three points per term are tried; the one with the smallest
    /// leave-one-out error is used. Resamples of points and samples keep its terms. Samples are resampled for all
    /// points together; their deviations are scaled to Student's distribution for the number of samples.
    ///
    /// # Errors
    /// The number of responses is wrong, fewer than 90 % of the points have one, or a setting of the bootstrap is out
    /// of range.
    pub fn respond(&self, observed: &Observed<'_>, resamples: &Resamples) -> Result<Propagated, PropagationError> {
        let points = self.xi_samples.len();
        for values in std::iter::once(observed.values).chain(observed.without.iter().map(Vec::as_slice)) {
            if values.len() != points {
                return Err(PropagationError::Length { values: values.len(), points });
            }
        }
        resamples.check([points])?;
        let (kept, failed): (Vec<usize>, Vec<usize>) = (0..points).partition(|&k| observed.values[k].is_finite());
        if (kept.len() as f64) < VALID_FRACTION * points as f64 {
            return Err(PropagationError::TooFewValid { valid: kept.len(), points });
        }
        let samples = Samples::new(&kept.iter().map(|&k| &self.xi_samples[k][..]).collect::<Vec<_>>(), observed, &kept);
        let moments = Moments::new(&samples.values);
        let variance = moments.sample_std().powi(2);
        if variance.sqrt() <= observed.resolution.max(ROUNDING * moments.mean.abs()) {
            return self.without_indices(&samples, failed, 0.0, NoIndices::Constant, resamples);
        }
        match self.best(&samples)? {
            (_, error) if error >= 1.0 => {
                self.without_indices(&samples, failed, error, NoIndices::NothingPredicts { error }, resamples)
            }
            (expansion, error) => {
                let draws = Design::new(
                    SamplingMethod::Sobol,
                    self.seed,
                    "chaos/propagation/law",
                    DRAWS,
                    self.parameters.len(),
                )?;
                let xi_samples: Vec<Vec<f64>> = (0..DRAWS).map(|i| xi(&self.parameters, &draws.unit(i))).collect();
                let mut marginal = expansion.evaluate_many(&xi_samples);
                marginal.sort_by(f64::total_cmp);
                let (mean, std, indices) = samples.estimates(&expansion, error, resamples);
                let noise = samples.noise(variance);
                Ok(Propagated { mean, std, expansion, leave_one_out: error, indices, noise, failed, marginal })
            }
        }
    }

    /// Returns the expansion with the smallest relative leave-one-out error, and this error.
    fn best(&self, samples: &Samples<'_>) -> Result<(Expansion, f64), PropagationError> {
        let mut best: Option<(Expansion, f64)> = None;
        let mut terms = 0;
        for (degree, q) in TRUNCATIONS {
            let truncation = Truncation { q, ..Truncation::total_degree(degree) };
            let basis = self.basis(&truncation)?;
            let more = basis.len() > terms && (best.is_none() || POINTS_PER_TERM * basis.len() <= samples.len());
            if !more {
                continue;
            }
            terms = basis.len();
            let (expansion, fit) = Expansion::fit(basis, &samples.xi_samples, &samples.values)?;
            let error = fit.leave_one_out.relative_error.unwrap_or(f64::INFINITY);
            if best.as_ref().is_none_or(|(_, least)| error < *least) {
                best = Some((expansion, error));
            }
        }
        best.ok_or(PropagationError::NoParameter)
    }

    fn basis(&self, truncation: &Truncation) -> Result<Basis, PropagationError> {
        let set = MultiIndexSet::truncated(self.parameters.len(), truncation).map_err(BasisError::from)?;
        Ok(Basis::new(set, self.parameters.iter().map(Parameter::family).collect())?)
    }

    /// Returns a result with the mean and standard deviation of the points, if no expansion predicts the response.
    fn without_indices(
        &self,
        samples: &Samples<'_>,
        failed: Vec<usize>,
        error: f64,
        reason: NoIndices,
        resamples: &Resamples,
    ) -> Result<Propagated, PropagationError> {
        let (mean, std) = samples.moments(resamples);
        let constant = self.basis(&Truncation::total_degree(0))?;
        let mut marginal = samples.values.clone();
        marginal.sort_by(f64::total_cmp);
        let mut noise = samples.noise(std.value * std.value);
        if reason == NoIndices::Constant {
            noise.variance_fraction = 0.0;
        }
        let expansion = Expansion::new(constant, vec![mean.value]);
        Ok(Propagated { mean, std, expansion, leave_one_out: error, indices: Err(reason), noise, failed, marginal })
    }
}

/// Returns the standard variables ξ of a point of the unit cube.
fn xi(parameters: &[Parameter], unit: &[f64]) -> Vec<f64> {
    parameters.iter().zip(unit).map(|(parameter, u)| parameter.family().from_unit(*u)).collect()
}
