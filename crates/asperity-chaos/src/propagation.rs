//! Uncertain parameters through a response that is expensive and known with noise.
//!
//! [`Propagation`] says at which parameters to evaluate, and makes a chaos expansion of what was found there: mean, standard
//! deviation and distribution of the response over the parameters, and Sobol' indices that say which of them matters.
//!
//! # Noise
//!
//! A response that is an average over few random samples has noise. Where all points of the design use the *same* samples,
//! their errors are alike: most of the noise moves all responses together and only what is left of it varies from point to
//! point. A standard error of each point cannot tell the one from the other, so noise is stated by what the response would be
//! *without each of the samples* ([`Observed::without`]). From that follow the standard error of the mean over the parameters
//! (the common part) and the share of the variance over the points that is expected of noise alone ([`Noise`]); intervals of
//! moments and indices count both.
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

use super::{
    Basis, BasisError, Design, Estimate, Expansion, MultiIndexSet, RegressionError, Resamples, ResamplesError,
    SamplingError, SamplingMethod, Truncation,
};
use asperity_base::distribution::DistributionError;
use asperity_base::stats::{Interval, Moments, quantile_sorted};
use replicate::Samples;

/// Sets of terms that are tried: degree and exponent of [`Truncation`]. With q = ½ a second degree has no interactions.
const TRUNCATIONS: [(usize, f64); 5] = [(1, 1.0), (2, 0.5), (2, 1.0), (3, 0.75), (3, 1.0)];
/// Points for each coefficient.
const POINTS_PER_TERM: usize = 3;
/// Fewest points for each coefficient of a linear response.
const LEAST_POINTS_PER_TERM: usize = 4;
/// Share of the points that must have a response.
const VALID_SHARE: f64 = 0.9;
/// Points at which the distribution of the response is drawn from its expansion.
const DRAWS: usize = 4096;
/// Scatter over the mean below which a response does not vary.
const ROUNDING: f64 = 1e-12;

/// Why uncertain parameters could not be propagated.
#[derive(Debug, Clone, PartialEq, Error)]
pub enum PropagationError {
    /// There is nothing uncertain.
    #[error("there is no uncertain parameter")]
    NoParameter,
    /// The design is too small for a response that is linear in all parameters.
    #[error("a design of {points} points; {parameters} uncertain parameters need at least {wanted}")]
    TooFewPoints {
        /// Points asked for.
        points: usize,
        /// Number of parameters.
        parameters: usize,
        /// Fewest points.
        wanted: usize,
    },
    /// A distribution is not one.
    #[error(transparent)]
    Law(#[from] DistributionError),
    /// The design could not be made.
    #[error(transparent)]
    Design(#[from] SamplingError),
    /// The terms of an expansion could not be made.
    #[error(transparent)]
    Basis(#[from] BasisError),
    /// A setting of the bootstrap is out of range.
    #[error(transparent)]
    Resamples(#[from] ResamplesError),
    /// Responses of another number of points.
    #[error("{values} responses at {points} points")]
    Length {
        /// Responses given.
        values: usize,
        /// Points of the design.
        points: usize,
    },
    /// Too few points have a response: what is left is not the distribution of the parameters.
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

/// Why a response has no Sobol' indices.
#[derive(Debug, Clone, PartialEq, Error)]
pub enum NoIndices {
    /// It does not vary with the parameters.
    #[error("it does not depend on the parameters")]
    Constant,
    /// No expansion predicts it better than its mean does.
    #[error("no expansion in the parameters predicts it better than its mean: relative leave-one-out error {error:.2}")]
    NothingPredicts {
        /// The least error.
        error: f64,
    },
    /// Too many resamples have no expansion.
    #[error("{failed} of {resamples} resamples of the points have no expansion; more points are needed")]
    TooManyFailures {
        /// Resamples without.
        failed: usize,
        /// All resamples.
        resamples: usize,
    },
}

/// Independent uncertain parameters, and the design of points at which a response is wanted: a maximin Latin hypercube.
#[derive(Debug, Clone)]
pub struct Propagation {
    parameters: Vec<Parameter>,
    seed: u64,
    /// Î¾ of each point.
    xi_samples: Vec<Vec<f64>>,
}

/// What was found at the points of a design.
#[derive(Debug, Clone, Copy)]
pub struct Observed<'a> {
    /// Response at each point; NaN where there is none.
    pub values: &'a [f64],
    /// For each of the random samples behind the responses, the response at each point without that sample; empty where the
    /// response has no noise. NaN counts as the response with all samples.
    pub without: &'a [Vec<f64>],
    /// Responses that differ by less are taken for equal.
    pub resolution: f64,
}

impl<'a> Observed<'a> {
    /// Responses without noise.
    pub fn exact(values: &'a [f64]) -> Self {
        Self { values, without: &[], resolution: 0.0 }
    }
}

/// What the noise of a response does.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Noise {
    /// Standard error, by the jackknife, of the mean over the points: noise that all points have in common is in it in full.
    pub standard_error: f64,
    /// Variance over the points that is expected of noise alone, over the variance found: 0 without noise, about 1 where noise
    /// is all there is. Noise common to all points adds nothing to it. 0 for a response that does not vary.
    pub variance_share: f64,
}

/// Sobol' indices in the order of the parameters. An interval counts the choice of the points, the noise, and with the relative
/// leave-one-out error, by which an index can be wrong at most, what the expansion does not explain.
#[derive(Debug, Clone, PartialEq)]
pub struct ParameterIndices {
    /// First order: the share of the variance that a parameter explains alone.
    pub first_order: Vec<Estimate>,
    /// Total: together with all others.
    pub total: Vec<Estimate>,
}

/// A response over the distribution of its parameters.
#[derive(Debug, Clone, PartialEq)]
pub struct Propagated {
    /// Mean over the parameters.
    pub mean: Estimate,
    /// Standard deviation over the parameters.
    pub std: Estimate,
    /// The chaos expansion; constant where the response is, or where nothing predicts it.
    pub expansion: Expansion,
    /// Mean square error of predicting each point from the others, over the variance; 0 for a constant response.
    pub leave_one_out: f64,
    /// Sobol' indices, or why there are none.
    pub indices: Result<ParameterIndices, NoIndices>,
    /// Noise of the samples.
    pub noise: Noise,
    /// Points without a response, left out.
    pub failed: Vec<usize>,
    /// Sorted draws of the response over the distribution of the parameters.
    marginal: Vec<f64>,
}

impl Propagated {
    /// Quantile of the response over the distribution of the parameters, by its expansion; where nothing predicts the response, of its
    /// values at the points.
    ///
    /// # Panics
    /// If the probability lies outside [0, 1].
    pub fn quantile(&self, probability: f64) -> f64 {
        quantile_sorted(&self.marginal, probability)
    }

    /// Where the response lies for 95 % of the parameters.
    pub fn band(&self) -> Interval {
        Interval { low: self.quantile(0.025), high: self.quantile(0.975) }
    }
}

impl Propagation {
    /// Plans a design of `points` points; equal (seed, parameters) give equal points.
    ///
    /// # Errors
    /// No parameter, fewer than four points for each parameter and the constant, or more than 2,000.
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

    /// Fewest points of a design.
    pub fn least_points(parameters: usize) -> usize {
        LEAST_POINTS_PER_TERM * (parameters + 1)
    }

    /// The parameters.
    pub fn parameters(&self) -> &[Parameter] {
        &self.parameters
    }

    /// Number of points.
    pub fn points(&self) -> usize {
        self.xi_samples.len()
    }

    /// Values of the parameters at point `k`.
    ///
    /// # Panics
    /// If there is no such point.
    pub fn point(&self, k: usize) -> Vec<f64> {
        self.parameters.iter().zip(&self.xi_samples[k]).map(|(parameter, xi)| parameter.at(*xi)).collect()
    }

    /// The response over the distribution of the parameters, with intervals by `resamples`.
    ///
    /// Of expansions of degree up to three, with at least three points for each term, the one that predicts each point best from
    /// the others is taken; resamples of points and samples keep its terms. Samples are drawn again for all points together,
    /// spread as Student's distribution of so many samples is.
    ///
    /// # Errors
    /// Responses of another number of points, fewer than 90 % of the points with one, or settings of the bootstrap out of range.
    pub fn respond(&self, observed: &Observed<'_>, resamples: &Resamples) -> Result<Propagated, PropagationError> {
        let points = self.xi_samples.len();
        for values in std::iter::once(observed.values).chain(observed.without.iter().map(Vec::as_slice)) {
            if values.len() != points {
                return Err(PropagationError::Length { values: values.len(), points });
            }
        }
        resamples.check([points])?;
        let (kept, failed): (Vec<usize>, Vec<usize>) = (0..points).partition(|&k| observed.values[k].is_finite());
        if (kept.len() as f64) < VALID_SHARE * points as f64 {
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

    /// The expansion that predicts best, and its relative leave-one-out error.
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

    /// Mean and spread of the points themselves, where no expansion says more.
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
            noise.variance_share = 0.0;
        }
        let expansion = Expansion::new(constant, vec![mean.value]);
        Ok(Propagated { mean, std, expansion, leave_one_out: error, indices: Err(reason), noise, failed, marginal })
    }
}

/// The Î¾ of a point of the unit cube.
fn xi(parameters: &[Parameter], unit: &[f64]) -> Vec<f64> {
    parameters.iter().zip(unit).map(|(parameter, u)| parameter.family().from_unit(*u)).collect()
}
