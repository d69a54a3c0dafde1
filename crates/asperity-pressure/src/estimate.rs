//! Estimated distribution with its errors.

use crate::band::RARE;
use crate::band::{Band, Moments, Total};
use crate::multilevel::MultilevelEstimate;
use crate::{MethodError, PressureError, Samples};
use asperity_base::stats::{Interval, NORMAL_95, wilson_interval};
use asperity_chaos::DiscreteDistribution;
use asperity_chaos::distance::{kolmogorov_smirnov, wasserstein_1};

/// Number of values at which distribution functions have bands.
const NODES: usize = 64;
/// Maximum number of pooled pressures.
pub(super) const MOST_POOLED: usize = 1 << 22;

/// Estimated distribution of the pressure.
#[derive(Debug, Clone, PartialEq)]
pub struct PressureEstimate {
    /// Distribution of the pressure in pascal, with its point mass at 0.
    pub distribution: DiscreteDistribution,
    /// P(contact). The paper's expansions use K/K_t, whatever part of the expansion is clipped to 0.
    pub contact_probability: f64,
    /// Bias of P(contact), estimated from samples that were not used for the fit; `None` for an unbiased estimate.
    pub contact_probability_bias: Option<f64>,
    /// Standard error of P(contact) without its bias.
    pub contact_probability_se: f64,
    /// 95 % interval of P(contact), including bias and error.
    pub contact_probability_interval: Option<Interval>,
    /// Mean pressure E p in pascal.
    pub mean_pa: f64,
    /// Bias of the mean in pascal; `None` for an unbiased estimate.
    pub mean_bias_pa: Option<f64>,
    /// Standard error of the mean without its bias, in pascal.
    pub mean_se_pa: f64,
    /// Distribution function with its bands, at pressures in pascal that begin with 0.
    pub band: Option<Band>,
    /// Reason why a biased estimate has neither band nor intervals.
    pub interval_failure: Option<MethodError>,
    /// Number of coefficients of the expansion, if any.
    pub coefficients: Option<usize>,
    /// Mean square leave-one-out error of the expanded quantity divided by its variance, if any. Above 1 the expansion
    /// predicts worse than the mean.
    pub leave_one_out_error: Option<f64>,
    /// Upper bound of the pressure in pascal: the hardness, or infinity. The distribution, the mean and all intervals
    /// respect it.
    pub largest_pa: f64,
}

impl PressureEstimate {
    /// Creates the empirical estimate from independent samples.
    pub(super) fn from_independent(samples: &Samples, largest_pa: f64, seed: u64) -> Result<Self, PressureError> {
        let distribution = samples.distribution()?;
        let n = samples.len();
        let contact_probability = samples.contact_probability();
        let nodes = nodes(&distribution, samples.len());
        let cdf: Vec<f64> = nodes.iter().map(|t| distribution.cdf(*t)).collect();
        Ok(Self {
            contact_probability,
            contact_probability_se: (contact_probability * (1.0 - contact_probability) / n as f64).sqrt(),
            contact_probability_bias: None,
            contact_probability_interval: Some(wilson_interval(samples.in_contact(), n)),
            mean_pa: distribution.mean(),
            mean_bias_pa: None,
            mean_se_pa: distribution.std() / ((n - 1).max(1) as f64).sqrt(),
            band: Some(Band::from_independent(&nodes, &cdf, n, seed).widened([samples.in_contact(), n])),
            interval_failure: None,
            coefficients: None,
            leave_one_out_error: None,
            largest_pa,
            distribution,
        })
    }

    /// Creates the mean of the empirical distributions of independent randomisations. Their differences determine the
    /// errors.
    pub(super) fn from_replicates(samples: &Samples, largest_pa: f64, seed: u64) -> Result<Self, PressureError> {
        let distribution = samples.distribution()?;
        let nodes = nodes(&distribution, samples.len());
        let mut replicates = vec![Vec::new(); samples.replicates()];
        for (position, observation) in samples.observations().iter().enumerate() {
            replicates[samples.replicate_of(position)].push(observation.pressure_pa);
        }
        replicates.retain(|pressures| !pressures.is_empty());
        let degrees_of_freedom = Some(samples.replicates().saturating_sub(1));
        let found = Self::from_groups(distribution, samples, &nodes, replicates.into_iter(), degrees_of_freedom, seed);
        Ok(Self::from_multilevel(found, largest_pa))
    }

    /// Creates the empirical estimate from many cells. Each sample counts once for the errors, however many cells it
    /// provides.
    #[doc(hidden)]
    pub fn from_sites(samples: &Samples, largest_pa: f64, seed: u64) -> Result<Self, PressureError> {
        let each = samples.sites().first().map_or(1, Vec::len).max(1);
        let kept = (MOST_POOLED / samples.len().max(1)).clamp(1, each);
        let step = each.div_ceil(kept);
        // Rounding to single precision may exceed the bound.
        let pressure = |p: &f32| f64::from(*p).min(largest_pa);
        let pressures = |sites: &Vec<f32>| sites.iter().step_by(step).map(pressure).collect::<Vec<f64>>();
        let pooled: Vec<f64> = samples.sites().iter().flat_map(pressures).collect();
        let distribution = DiscreteDistribution::empirical(&pooled)?;
        let nodes = nodes(&distribution, samples.len());
        let found = Self::from_groups(distribution, samples, &nodes, samples.sites().iter().map(pressures), None, seed);
        Ok(Self::from_multilevel(found, largest_pa))
    }

    /// Estimates errors from independent groups of pressures whose pooled distribution is `distribution`.
    ///
    /// `degrees_of_freedom` is given if there are few groups.
    fn from_groups(
        distribution: DiscreteDistribution,
        samples: &Samples,
        nodes: &[f64],
        groups: impl Iterator<Item = Vec<f64>>,
        degrees_of_freedom: Option<usize>,
        seed: u64,
    ) -> MultilevelEstimate {
        let mut moments = Moments::new(nodes.len() + 1);
        for mut group in groups {
            group.sort_by(f64::total_cmp);
            let n = group.len() as f64;
            let fraction = |t: &f64| group.partition_point(|p| p <= t) as f64 / n;
            let mut values: Vec<f64> = nodes.iter().map(fraction).collect();
            values.push(group.iter().sum::<f64>() / n);
            moments.add(&values);
        }
        let mut total = Total::new(nodes.len() + 1);
        total.add_mean(&moments);
        MultilevelEstimate {
            mean: total.value(nodes.len()),
            mean_se: total.standard_error(nodes.len(), degrees_of_freedom),
            band: total.band(nodes, degrees_of_freedom, seed),
            distribution,
            above: [samples.in_contact(), samples.len()],
            coefficients: None,
            leave_one_out_error: None,
        }
    }
}

impl PressureEstimate {
    /// Returns the 95 % interval of `mean_pa` within the possible range; `None` without a standard error.
    pub fn mean_interval_pa(&self) -> Option<Interval> {
        let half = self.band.as_ref().map_or(NORMAL_95, |band| band.pointwise_factor) * self.mean_se_pa;
        let unbiased = self.mean_pa - self.mean_bias_pa.unwrap_or(0.0);
        let possible = |pressure_pa: f64| pressure_pa.clamp(0.0, self.largest_pa);
        half.is_finite().then(|| Interval { low: possible(unbiased - half), high: possible(unbiased + half) })
    }

    /// Returns the 95 % interval of a quantile in pascal; `None` without a band.
    pub fn quantile_interval_pa(&self, probability: f64) -> Option<Interval> {
        self.band.as_ref().map(|band| band.quantile(&self.distribution, probability).interval)
    }
}

impl PressureEstimate {
    /// Creates the estimate of the pressure from a multilevel estimate; `largest_pa` is its upper bound.
    pub(super) fn from_multilevel(found: MultilevelEstimate, largest_pa: f64) -> Self {
        let MultilevelEstimate {
            distribution,
            mean,
            mean_se,
            band,
            above: [in_contact, samples],
            coefficients,
            leave_one_out_error,
        } = found;
        let mut contact_probability =
            1.0 - band.cdf.first().copied().unwrap_or_else(|| distribution.cdf(0.0)).clamp(0.0, 1.0);
        let contact_probability_se = band.standard_errors.first().copied().unwrap_or(0.0);
        let contact_probability_interval = if in_contact.min(samples - in_contact) < RARE {
            // The estimate is unbiased, but with few samples it may lie far from their fraction, or beyond 0 or 1.
            let interval = wilson_interval(in_contact, samples);
            contact_probability = contact_probability.clamp(interval.low, interval.high);
            interval
        } else {
            let [low, high] = if band.values.is_empty() { [0.0, 1.0] } else { band.pointwise(0) };
            Interval { low: 1.0 - high, high: 1.0 - low }
        };
        Self {
            distribution,
            contact_probability,
            contact_probability_se,
            contact_probability_bias: None,
            contact_probability_interval: Some(contact_probability_interval),
            mean_pa: mean.clamp(0.0, largest_pa),
            mean_bias_pa: None,
            mean_se_pa: mean_se,
            band: Some(band.widened([in_contact, samples])),
            interval_failure: None,
            coefficients,
            leave_one_out_error,
            largest_pa,
        }
    }
}

/// Returns pressures from 0 on with about equal probability between them and enough samples on both sides of each.
pub(super) fn nodes(distribution: &DiscreteDistribution, samples: usize) -> Vec<f64> {
    let below = distribution.cdf(0.0);
    let quantiles = (1..NODES).map(|k| distribution.quantile(below + (1.0 - below) * k as f64 / NODES as f64));
    let common = |t: &f64| {
        let beyond = (1.0 - distribution.cdf(*t)).min(distribution.cdf(*t));
        *t > 0.0 && beyond * samples as f64 >= RARE as f64
    };
    let mut nodes: Vec<f64> = std::iter::once(0.0).chain(quantiles.filter(common)).collect();
    nodes.dedup();
    nodes
}

/// Distances between an estimated distribution and the reference distribution.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ReferenceDistances {
    /// Kolmogorov–Smirnov distance.
    pub ks_distance: f64,
    /// Wasserstein-1 distance divided by the standard deviation of the reference distribution, including its point mass
    /// at 0; `None` if that standard deviation is 0.
    pub wasserstein_1_over_std: Option<f64>,
}

impl ReferenceDistances {
    pub(super) fn between(distribution: &DiscreteDistribution, reference: &DiscreteDistribution) -> Self {
        let std = reference.std();
        Self {
            ks_distance: kolmogorov_smirnov(distribution, reference),
            wasserstein_1_over_std: (std > 0.0).then(|| wasserstein_1(distribution, reference) / std),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use asperity_base::random;

    #[test]
    #[ignore = "slow"]
    fn intervals_cover_the_quantiles_at_their_level() {
        let (replicates, n) = (1000, 200);
        let nodes: Vec<f64> = (0..20).map(|k| f64::from(k) / 19.0).collect();
        let mut held = [0_usize; 3];
        for replicate in 0..replicates {
            let normal = random::standard_normal(&mut random::stream(1, "quantile", replicate), n);
            let uniform: Vec<f64> = normal.into_iter().map(asperity_base::distribution::standard_normal_cdf).collect();
            let distribution = DiscreteDistribution::empirical(&uniform).unwrap();
            let cdf: Vec<f64> = nodes.iter().map(|t| distribution.cdf(*t)).collect();
            let band = Band::from_independent(&nodes, &cdf, n, 1);
            for (held, probability) in held.iter_mut().zip([0.1, 0.5, 0.9]) {
                // The quantile of a uniform variable equals its probability.
                *held += usize::from(band.quantile(&distribution, probability).interval.contains(probability));
            }
        }
        // A fraction of 95 % has a standard error of 0.7 %.
        for held in held {
            let fraction = held as f64 / replicates as f64;
            assert!((0.925..=0.975).contains(&fraction), "{fraction}");
        }
    }

    #[test]
    fn few_samples_without_or_with_contact_have_wilsons_interval() {
        for in_contact in [3, 500, 997] {
            let fraction = in_contact as f64 / 1000.0;
            let pressures: Vec<f64> = (0..1000).map(|i| f64::from(u8::from(i < in_contact))).collect();
            let band = Band::from_independent(&[0.0], &[1.0 - fraction], 1000, 1);
            let [low, high] = band.pointwise(0);
            let found = MultilevelEstimate {
                distribution: DiscreteDistribution::empirical(&pressures).unwrap(),
                mean: fraction,
                mean_se: 0.01,
                band,
                above: [in_contact, 1000],
                coefficients: None,
                leave_one_out_error: None,
            };
            let found = PressureEstimate::from_multilevel(found, 2.0);
            let wanted = if in_contact == 500 {
                Interval { low: 1.0 - high, high: 1.0 - low }
            } else {
                wilson_interval(in_contact, 1000)
            };
            assert_eq!(found.contact_probability_interval, Some(wanted));
            assert!((found.contact_probability - fraction).abs() < 1e-15);
        }
        // Predictors may move the estimate below zero.
        let band = Band { cdf: vec![1.03], ..Band::from_independent(&[0.0], &[0.9], 51, 1) };
        let found = MultilevelEstimate {
            distribution: DiscreteDistribution::empirical(&[0.0, 1.0]).unwrap(),
            mean: 0.1,
            mean_se: 0.01,
            band,
            above: [5, 51],
            coefficients: None,
            leave_one_out_error: None,
        };
        let found = PressureEstimate::from_multilevel(found, 2.0);
        assert_eq!(found.contact_probability, wilson_interval(5, 51).low);
    }

    #[test]
    fn a_quantile_within_a_point_mass_is_its_value() {
        let pressures: Vec<f64> = (0..1000).map(|i| f64::from((i - 800).max(0))).collect();
        let distribution = DiscreteDistribution::empirical(&pressures).unwrap();
        let nodes = nodes(&distribution, 1000);
        let cdf: Vec<f64> = nodes.iter().map(|t| distribution.cdf(*t)).collect();
        let band = Band::from_independent(&nodes, &cdf, 1000, 1);
        assert_eq!(band.quantile(&distribution, 0.5).interval, Interval { low: 0.0, high: 0.0 });
        let interval = band.quantile(&distribution, 0.9).interval;
        // F = .8 + p/1000 with the standard error √(.9 · .1/1000), interpolated between nodes.
        let half = 1000.0 * NORMAL_95 * (0.09_f64 / 1000.0).sqrt();
        assert!(
            (interval.low - 100.0 + half).abs() < 3.0 && (interval.high - 100.0 - half).abs() < 3.0,
            "{interval:?}"
        );
    }
}
