//! Distributions from surrogate models, with estimates of their errors.
//!
//! A [`Surrogate`] is fitted to samples and has a distribution of its own. Its error is estimated from samples that
//! were not used for the fit, for which both the true value and the conditional distribution of the model are known.
//! Let h_f be the model's distribution function given ξ, fitted to all samples except part f of ten, and s(t) = 1(p ≤
//! t). Then
//!
//! F̃(t) = mean_i [s_i(t) − β (h_f(t | ξ_i) − E h_f(t))]
//!
//! over all samples i, each with its part f, has the expectation F(t) for every β. The β of minimum variance, limited
//! to 0 … 1, is estimated from the samples (control variates), so that a bad model does not increase the error of plain
//! counting. The difference between the model's own distribution and F̃ is its bias, and the variance of the terms
//! gives the error of F̃. Intervals are those of F̃; if the bias is large, they may not contain the model's own value.
//!
//! # References
//! B. L. Nelson, *Oper. Res.* **38** (1990) 974, <https://doi.org/10.1287/opre.38.6.974> (control variates).
//! V. Chernozhukov et al., *Econometrics J.* **21** (2018) C1, <https://doi.org/10.1111/ectj.12097> (cross-fitting).

use crate::band::RARE;
use crate::band::{Moments, Total};
use crate::estimate::nodes;
use crate::nested::kappa_pa_per_m;
use crate::rotated_variables::RotatedVariables;
use crate::{Band, MethodError, PressureError, PressureEstimate, Problem, Quantity, Samples};
use asperity_base::blocks;
use asperity_base::numeric::Line;
use asperity_base::stats::{Interval, wilson_interval};
use asperity_chaos::{Design, DiscreteDistribution};

/// Number of parts into which the samples are split.
const FOLDS: usize = 10;
/// Maximum number of rotated variables, and the degree of the polynomials that select them.
const MOST_VARIABLES: usize = 8;
const CHOOSING_DEGREE: usize = 3;

/// Pressures in pascal with their probabilities.
pub type PointMasses = Vec<(f64, f64)>;

/// Fitted surrogate model.
#[derive(Debug, Clone)]
pub struct Fitted {
    /// Distribution of the pressure.
    pub distribution: PointMasses,
    /// Conditional distributions given ξ of the samples that were not fitted, in their order.
    pub given: Vec<PointMasses>,
    pub coefficients: usize,
    pub leave_one_out_error: Option<f64>,
}

/// Surrogate model of the pressure.
pub trait Surrogate: Sync {
    /// Fits the samples at increasing positions.
    fn fit(&self, samples: &[usize]) -> Result<Fitted, MethodError>;
}

/// Samples to which models are fitted.
#[derive(Debug, Clone, Copy)]
pub struct TrainingSamples<'a> {
    pub pressures_pa: &'a [f64],
    /// Group of each sample, counted from 0. Groups are independent of each other; `None` if all samples are
    /// independent.
    pub groups: Option<&'a [usize]>,
    /// Number of fresh samples on which models are evaluated.
    pub evaluations: usize,
    /// Upper bound of the pressure: the hardness, or infinity.
    pub largest_pa: f64,
}

impl TrainingSamples<'_> {
    fn group(&self, sample: usize) -> usize {
        self.groups.map_or(sample, |groups| groups[sample])
    }

    /// Returns the number of groups.
    fn count(&self) -> usize {
        self.groups.map_or(self.pressures_pa.len(), |groups| groups.iter().max().map_or(0, |last| last + 1))
    }

    /// Returns the degrees of freedom of the variance between groups, if there are few groups.
    fn degrees_of_freedom(&self) -> Option<usize> {
        self.groups.map(|_| self.count().saturating_sub(1))
    }

    /// Returns the number of samples in contact.
    fn in_contact(&self) -> usize {
        self.pressures_pa.iter().filter(|p| **p > 0.0).count()
    }

    /// Returns the mean over samples of a vector per sample, with its error.
    fn mean(&self, vectors: &[Vec<f64>]) -> Total {
        let length = vectors.first().map_or(0, Vec::len);
        let mut groups = vec![vec![0.0; length]; self.count()];
        let scale = self.count() as f64 / vectors.len() as f64;
        for (sample, vector) in vectors.iter().enumerate() {
            groups[self.group(sample)].iter_mut().zip(vector).for_each(|(sum, value)| *sum += scale * value);
        }
        let mut moments = Moments::new(length);
        groups.iter().for_each(|group| moments.add(group));
        let mut total = Total::new(length);
        total.add_mean(&moments);
        total
    }

    /// Returns the standard error and the 95 % interval of the fraction of samples in contact.
    pub(super) fn contact_fraction(&self, seed: u64) -> (f64, Interval) {
        let (samples, in_contact) = (self.pressures_pa.len(), self.in_contact());
        let fraction = in_contact as f64 / samples as f64;
        if self.groups.is_none() {
            return ((fraction * (1.0 - fraction) / samples as f64).sqrt(), wilson_interval(in_contact, samples));
        }
        let observed: Vec<Vec<f64>> = self.pressures_pa.iter().map(|p| vec![f64::from(u8::from(*p <= 0.0))]).collect();
        let band = self.mean(&observed).band(&[0.0], self.degrees_of_freedom(), seed);
        (band.standard_errors[0], self.contact_interval(&band))
    }

    /// Returns the 95 % interval of P(contact) from the band of F, or Wilson's interval if samples of either kind are
    /// rare.
    fn contact_interval(&self, band: &Band) -> Interval {
        let (samples, in_contact) = (self.pressures_pa.len(), self.in_contact());
        if in_contact.min(samples - in_contact) < RARE {
            return wilson_interval(in_contact, samples);
        }
        let [low, high] = band.pointwise(0);
        Interval { low: 1.0 - high, high: 1.0 - low }
    }
}

/// Estimates the distribution by a surrogate, with its bias and error. These are missing if parts of the samples have
/// no model.
///
/// # Errors
/// The samples have no model, or the model overflows.
pub fn estimate(
    surrogate: &dyn Surrogate,
    training: TrainingSamples<'_>,
    seed: u64,
) -> Result<PressureEstimate, MethodError> {
    let samples: Vec<usize> = (0..training.pressures_pa.len()).collect();
    let fitted = surrogate.fit(&samples)?;
    let overflowed = fitted.distribution.iter().filter(|(p, _)| !p.is_finite()).count();
    if overflowed > 0 {
        return Err(MethodError::Overflow { overflowed, evaluations: training.evaluations });
    }
    let distribution = DiscreteDistribution::weighted(fitted.distribution)?;
    let contact_probability = 1.0 - distribution.cdf(0.0);
    let mean_pa = distribution.mean().min(training.largest_pa);
    let own = PressureEstimate {
        contact_probability,
        contact_probability_se: f64::NAN,
        contact_probability_interval: None,
        contact_probability_bias: None,
        mean_pa,
        mean_se_pa: f64::NAN,
        mean_bias_pa: None,
        band: None,
        interval_failure: None,
        coefficients: Some(fitted.coefficients),
        leave_one_out_error: fitted.leave_one_out_error,
        largest_pa: training.largest_pa,
        distribution,
    };
    let empirical = DiscreteDistribution::empirical(training.pressures_pa)?;
    let nodes = nodes(&empirical, samples.len());
    let unbiased = match held_out(surrogate, training, &nodes) {
        Ok(unbiased) => unbiased,
        Err(reason) => return Ok(PressureEstimate { interval_failure: Some(reason), ..own }),
    };
    let cdf: Vec<f64> = nodes.iter().map(|t| own.distribution.cdf(*t)).collect();
    let band = unbiased.band(&nodes, training.degrees_of_freedom(), seed).with_estimate(cdf);
    Ok(PressureEstimate {
        contact_probability_se: band.standard_errors[0],
        contact_probability_interval: Some(training.contact_interval(&band)),
        contact_probability_bias: Some(-band.bias[0]),
        mean_se_pa: unbiased.standard_error(nodes.len(), training.degrees_of_freedom()),
        mean_bias_pa: Some(mean_pa - unbiased.value(nodes.len()).clamp(0.0, training.largest_pa)),
        band: Some(band.widened([training.in_contact(), samples.len()])),
        ..own
    })
}

/// Returns the unbiased distribution function at the nodes, and the mean.
fn held_out(surrogate: &dyn Surrogate, training: TrainingSamples<'_>, nodes: &[f64]) -> Result<Total, MethodError> {
    let count = training.pressures_pa.len();
    let parts: Vec<(Vec<usize>, Result<Fitted, MethodError>)> = blocks::map(0..FOLDS, |fold| {
        let (held, fitted): (Vec<usize>, Vec<usize>) = (0..count).partition(|i| training.group(*i) % FOLDS == fold);
        (held, surrogate.fit(&fitted))
    });
    let mut observed: Vec<Vec<f64>> = training.pressures_pa.iter().map(|p| summary(vec![(*p, 1.0)], nodes)).collect();
    let mut predicted = vec![Vec::new(); count];
    for (held, fitted) in parts {
        if held.is_empty() {
            continue;
        }
        let fitted = fitted?;
        let expected = summary(fitted.distribution, nodes);
        for (sample, given) in held.into_iter().zip(fitted.given) {
            let own = summary(given, nodes);
            predicted[sample] = own.iter().zip(&expected).map(|(own, expected)| own - expected).collect();
        }
    }
    let slopes: Vec<f64> = (0..=nodes.len()).map(|k| slope(&observed, &predicted, k)).collect();
    for (observed, predicted) in observed.iter_mut().zip(&predicted) {
        observed.iter_mut().zip(predicted).zip(&slopes).for_each(|((observed, predicted), slope)| {
            if *slope > 0.0 {
                *observed -= slope * predicted;
            }
        });
    }
    let mut total = training.mean(&observed);
    // The fresh samples add an error of their own.
    let mut fresh = Moments::new(nodes.len() + 1);
    for predicted in &predicted {
        let used =
            predicted.iter().zip(&slopes).map(|(predicted, slope)| if *slope > 0.0 { slope * predicted } else { 0.0 });
        fresh.add(&used.collect::<Vec<_>>());
    }
    total.add_error(&fresh, training.evaluations as f64);
    Ok(total)
}

/// Returns the control-variate coefficient, limited to 0 … 1, that minimises the variance of the differences.
fn slope(observed: &[Vec<f64>], predicted: &[Vec<f64>], k: usize) -> f64 {
    let points: Vec<(f64, f64)> = predicted.iter().zip(observed).map(|(b, a)| (b[k], a[k])).collect();
    let slope = Line::through(&points).slope;
    if slope.is_finite() { slope.clamp(0.0, 1.0) } else { 0.0 }
}

/// Returns the distribution function at the nodes, and mean.
fn summary(mut masses: PointMasses, nodes: &[f64]) -> Vec<f64> {
    masses.sort_by(|a, b| a.0.total_cmp(&b.0));
    let mean = masses.iter().map(|(p, probability)| p * probability).sum();
    let (mut masses, mut below) = (masses.into_iter().peekable(), 0.0);
    let mut values: Vec<f64> = nodes
        .iter()
        .map(|t| {
            while let Some((_, probability)) = masses.next_if(|(p, _)| p <= t) {
                below += probability;
            }
            below
        })
        .collect();
    values.push(mean);
    values
}

/// Samples in rotated variables, and fresh samples.
#[derive(Debug, Clone)]
pub struct RotatedSamples {
    /// Variables of each sample; empty if no direction predicts the pressure.
    pub rows: Vec<Vec<f64>>,
    pub pressures_pa: Vec<f64>,
    /// Fresh variables, independent and standard normal.
    pub fresh: Vec<Vec<f64>>,
    /// Upper bound of the pressure.
    pub largest_pa: f64,
}

impl RotatedSamples {
    /// Creates the rotated samples. `design` creates fresh samples of the given number of variables.
    ///
    /// # Errors
    /// The variables cannot be rotated ([`PressureError::Method`]), or there is no design.
    pub(super) fn new(
        problem: &Problem<'_>,
        samples: &Samples,
        design: impl Fn(usize) -> Result<Design, PressureError>,
    ) -> Result<Self, PressureError> {
        let latent = Quantity::Pressure.values(samples.observations(), kappa_pa_per_m(samples.observations()));
        let (_, rows) =
            RotatedVariables::new(problem, MOST_VARIABLES, CHOOSING_DEGREE, |sample| samples.xi(sample), &latent)?;
        let variables = rows.first().map_or(0, Vec::len);
        // A design has at least one variable.
        let design = design(variables.max(1))?;
        let fresh = (0..design.samples()).map(|i| design.xi(i)).collect();
        let largest_pa = problem.hardness_pa().unwrap_or(f64::INFINITY);
        Ok(Self { rows, pressures_pa: samples.pressures_pa(), fresh, largest_pa })
    }

    pub fn variables(&self) -> usize {
        self.rows.first().map_or(0, Vec::len)
    }

    /// Returns the samples, which are independent of each other.
    pub fn training(&self) -> TrainingSamples<'_> {
        let Self { pressures_pa, fresh, largest_pa, .. } = self;
        TrainingSamples { pressures_pa, groups: None, evaluations: fresh.len(), largest_pa: *largest_pa }
    }
}

/// Returns the positions below `count` that do not occur in the increasing list.
pub fn others(samples: &[usize], count: usize) -> Vec<usize> {
    (0..count).filter(|i| samples.binary_search(i).is_err()).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use asperity_base::random::{standard_normal, stream};

    /// Model that ignores ξ and predicts half the mean of the pressures.
    struct HalfTheMean<'a>(&'a [f64]);

    impl Surrogate for HalfTheMean<'_> {
        fn fit(&self, samples: &[usize]) -> Result<Fitted, MethodError> {
            let mean = samples.iter().map(|i| self.0[*i]).sum::<f64>() / samples.len() as f64;
            let distribution = vec![(0.5 * mean, 1.0)];
            let given = vec![distribution.clone(); self.0.len() - samples.len()];
            Ok(Fitted { distribution, given, coefficients: 1, leave_one_out_error: None })
        }
    }

    #[test]
    fn a_wrong_model_reports_its_bias_and_its_intervals_contain_the_truth() {
        // Uniform between 0 and 1 with probability 0.7, otherwise 0.
        let normal = standard_normal(&mut stream(7, "surrogate", 0), 1500);
        let uniform = normal.into_iter().map(asperity_base::distribution::standard_normal_cdf);
        let pressures_pa: Vec<f64> = uniform.map(|u| ((u - 0.3) / 0.7).max(0.0)).collect();
        let training =
            TrainingSamples { pressures_pa: &pressures_pa, groups: None, evaluations: 1000, largest_pa: f64::INFINITY };
        let found = estimate(&HalfTheMean(&pressures_pa), training, 1).unwrap();
        let band = found.band.as_ref().unwrap();
        for (i, value) in band.values.iter().enumerate() {
            let [low, high] = band.simultaneous(i);
            let truth = (0.3 + 0.7 * value).min(1.0);
            assert!(low <= truth && truth <= high, "{value}: {truth} in [{low}, {high}]");
            assert!((band.cdf[i] - band.bias[i] - truth).abs() < 4.0 * band.standard_errors[i]);
        }
        // The model has no pressure of zero, so its probability of contact is 1.
        assert!((found.contact_probability_bias.unwrap() - 0.3).abs() < 4.0 * found.contact_probability_se);
        let interval = found.contact_probability_interval.unwrap();
        assert!(interval.contains(0.7) && !interval.contains(1.0), "{interval:?}");
        // A model that predicts nothing has the error of counting.
        let counted = (0.3_f64 * 0.7 / 1500.0).sqrt();
        assert!((found.contact_probability_se / counted - 1.0).abs() < 0.1, "{}", found.contact_probability_se);
        assert!((found.mean_pa - 0.175).abs() < 0.01 && found.mean_interval_pa().unwrap().contains(0.35));
    }
}
