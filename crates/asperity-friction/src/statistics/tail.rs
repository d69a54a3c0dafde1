//! Upper tail of μ.
//!
//! Peaks over a high threshold are the largest values of separate clusters of windows above it. The distribution of
//! their excesses tends to the generalised Pareto distribution 1 − (1 + ξy/σ)^{−1/ξ}. ξ < 0 is a tail that ends (at
//! −σ/ξ above the threshold; ξ = −1/b for a Beta distribution), ξ = 0 an exponential tail, ξ > 0 a power law.
//!
//! # References
//! Pickands, *Ann. Stat.* **3** (1975) 119, <https://doi.org/10.1214/aos/1176343003>; Davison & Smith, *J. R. Stat.
//! Soc. B* **52** (1990) 393, <https://doi.org/10.1111/j.2517-6161.1990.tb01796.x> (peaks of correlated records, return
//! levels).

use std::convert::Infallible;

use asperity_base::distribution::fit::{Family, Fit};
use asperity_base::numeric::{bisect, golden_section};
use asperity_base::stats::{Interval, NORMAL_95, correlation_time, quantile_sorted, sorted_present};

/// Fractions of the windows above the threshold, tried in this order until there are enough clusters.
const FRACTIONS: [f64; 4] = [0.05, 0.1, 0.15, 0.2];
const WANTED_CLUSTERS: usize = 40;
const LEAST_CLUSTERS: usize = 20;
/// Distances of the return levels in metre.
const DISTANCES_M: [f64; 3] = [0.1, 1.0, 10.0];
/// Range of shapes ξ of the search; below −1 the likelihood has no maximum.
const SHAPES: [f64; 2] = [-0.95, 2.0];
/// Drop of the log-likelihood at the ends of a 95 % profile interval.
const DROP: f64 = 0.5 * NORMAL_95 * NORMAL_95;

/// Upper tail of μ(s).
#[derive(Debug, Clone, PartialEq)]
pub struct Tail {
    /// Largest value.
    pub largest: f64,
    /// Threshold of the peaks.
    pub threshold: f64,
    /// Fraction of the windows above the threshold.
    pub fraction: f64,
    /// Number of clusters of windows above the threshold. Clusters are at least a correlation time apart. Tracks on one
    /// strip count by their effective number.
    pub clusters: usize,
    /// Clusters per metre of sliding, of one track.
    pub clusters_per_m: f64,
    /// Shape ξ of the generalised Pareto distribution of the highest excess of each cluster.
    pub shape: f64,
    /// 95 % interval of the shape by the profile of the likelihood.
    pub shape_interval: Interval,
    /// Scale σ.
    pub scale: f64,
    /// Values exceeded once in 0.1 m, 1 m and 10 m of sliding, for distances with more than one cluster.
    pub return_levels: Vec<ReturnLevel>,
    /// Tails of the fitted distributions, in the order of their ranking.
    pub distributions: Vec<DistributionTail>,
}

/// A value that μ exceeds once in a distance on average.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ReturnLevel {
    /// Sliding distance in metre.
    pub distance_m: f64,
    /// The value.
    pub mu: f64,
    /// 95 % interval of the value by the profile of the likelihood; `None` if the profile has no end.
    pub interval: Option<Interval>,
}

/// Upper tail of a fitted distribution with the clustering of the records at the threshold.
#[derive(Debug, Clone, PartialEq)]
pub struct DistributionTail {
    /// Family of the distribution.
    pub family: Family,
    /// Probability that the largest of the same number of values exceeds the observed largest. Near 0 the tail of the
    /// distribution is too light, near 1 too heavy.
    pub larger: f64,
    /// Values exceeded once in the distances of [`Tail::return_levels`].
    pub return_levels: Vec<f64>,
}

impl Tail {
    /// Estimates the tail of records with steps of `step_m` and `tracks` records per strip, and of distributions fitted
    /// to them. Returns `None` with fewer than 20 clusters. Tracks that are above the threshold together count by their
    /// effective number.
    pub(super) fn of(records: &[&[f64]], tracks: usize, step_m: f64, fits: &[Fit]) -> Option<Self> {
        let sorted = sorted_present(records.iter().flat_map(|record| record.iter().copied()));
        let largest = *sorted.last()?;
        if sorted[0] == largest {
            return None;
        }
        let times = records.iter().filter_map(|record| correlation_time(record).ok()).map(|time| time.steps);
        let apart = times.fold([0.0, 0.0], |[sum, count], steps| [sum + steps, count + 1.0]);
        let apart = (apart[0] / apart[1]).ceil() as usize;
        let found = FRACTIONS.map(|fraction| {
            let threshold = quantile_sorted(&sorted, 1.0 - fraction);
            let (peaks, alike) = (peaks(records, threshold, apart), alike(records, tracks, threshold));
            let separate = (peaks.len() as f64 / alike).round() as usize;
            (threshold, peaks, alike, separate)
        });
        let enough = found.iter().find(|(.., separate)| *separate >= WANTED_CLUSTERS);
        let (threshold, peaks, alike, separate) = enough.or(found.iter().max_by_key(|(.., separate)| *separate))?;
        if *separate < LEAST_CLUSTERS {
            return None;
        }
        let distance_m = sorted.len() as f64 * step_m;
        let fraction = sorted.iter().filter(|mu| **mu > *threshold).count() as f64 / sorted.len() as f64;
        let clusters_per_m = peaks.len() as f64 / distance_m;
        let excesses = Excesses::of(peaks, *threshold, *alike);
        let (shape, height) = excesses.best_shape(|shape| excesses.profile(shape));
        let shape_interval = excesses.shape_interval(shape, height);
        let scale = excesses.best_scale(shape);
        let distances = || DISTANCES_M.into_iter().filter(|distance_m| clusters_per_m * distance_m >= 1.0);
        let return_levels = distances().map(|distance_m| {
            let clusters = clusters_per_m * distance_m;
            let ends = excesses.return_interval(clusters, [shape, scale], height);
            let interval = match ends {
                (Some(low), Some(high)) => Some(Interval { low: threshold + low, high: threshold + high }),
                _ => None,
            };
            ReturnLevel { distance_m, mu: threshold + scale * growth(shape, clusters), interval }
        });
        let distributions = fits.iter().map(|fit| {
            // The ratio of clusters above x to clusters above the threshold equals the same ratio of windows.
            let clusters = |x: f64| clusters_per_m * fit.marginal.survival(x) / fraction;
            DistributionTail {
                family: fit.family,
                larger: -(-clusters(largest) * distance_m / alike).exp_m1(),
                return_levels: distances()
                    .map(|distance_m| fit.marginal.quantile(1.0 - fraction / (clusters_per_m * distance_m)))
                    .collect(),
            }
        });
        Some(Self {
            largest,
            threshold: *threshold,
            fraction,
            clusters: *separate,
            clusters_per_m,
            shape,
            shape_interval,
            scale,
            return_levels: return_levels.collect(),
            distributions: distributions.collect(),
        })
    }
}

/// Returns the highest value of each cluster. Values above the threshold with fewer than `apart` others between them
/// form one cluster. A missing value counts as one below.
fn peaks(records: &[&[f64]], threshold: f64, apart: usize) -> Vec<f64> {
    let mut peaks = vec![];
    for record in records {
        let mut below = apart;
        for mu in *record {
            if *mu > threshold {
                match peaks.last_mut() {
                    Some(peak) if below < apart => *peak = f64::max(*peak, *mu),
                    _ => peaks.push(*mu),
                }
                below = 0;
            } else {
                below += 1;
            }
        }
    }
    peaks
}

/// Returns the variance of the number of tracks above a threshold over the variance of independent tracks.
fn alike(records: &[&[f64]], tracks: usize, threshold: f64) -> f64 {
    if tracks == 1 {
        return 1.0;
    }
    let above = |mu: &f64| f64::from(u8::from(*mu > threshold));
    let values = records.iter().map(|record| record.len()).sum::<usize>() as f64;
    let fraction = records.iter().flat_map(|record| record.iter()).map(above).sum::<f64>() / values;
    let (mut together, mut alone) = (0.0, 0.0);
    for strip in records.chunks(tracks) {
        for place in 0..strip[0].len() {
            let differences = || strip.iter().map(|track| above(&track[place]) - fraction);
            together += differences().sum::<f64>().powi(2);
            alone += differences().map(|difference| difference * difference).sum::<f64>();
        }
    }
    (together / alone).clamp(1.0, tracks as f64)
}

/// Returns ((clusters)^ξ − 1)/ξ: the excess, in scales, that one in this number of clusters exceeds.
fn growth(shape: f64, clusters: f64) -> f64 {
    let log = clusters.ln();
    if (shape * log).abs() < 1e-9 { log } else { (shape * log).exp_m1() / shape }
}

/// Excesses over a threshold and their likelihood under the generalised Pareto distribution.
struct Excesses {
    values: Vec<f64>,
    mean: f64,
    /// Drop of the log-likelihood at the ends of an interval.
    drop: f64,
}

impl Excesses {
    /// Creates the excesses of peaks; each independent peak occurs `times` times.
    fn of(peaks: &[f64], threshold: f64, times: f64) -> Self {
        let values: Vec<f64> = peaks.iter().map(|peak| peak - threshold).collect();
        let mean = values.iter().sum::<f64>() / values.len() as f64;
        Self { values, mean, drop: times * DROP }
    }

    /// Returns the log-likelihood.
    fn log_likelihood(&self, shape: f64, scale: f64) -> f64 {
        let n = self.values.len() as f64;
        let sum: f64 = self
            .values
            .iter()
            .map(|y| {
                let t = y / scale;
                if shape.abs() < 1e-9 {
                    t
                } else if shape * t <= -1.0 {
                    f64::INFINITY
                } else {
                    (1.0 + 1.0 / shape) * (shape * t).ln_1p()
                }
            })
            .sum();
        -n * scale.ln() - sum
    }

    /// Returns the most likely scale at a shape, in a range of scales about the mean excess.
    fn best_scale(&self, shape: f64) -> f64 {
        let largest = self.values.iter().copied().fold(0.0, f64::max);
        let least = if shape < 0.0 { (-shape * largest / self.mean).max(1e-3) } else { 1e-3 };
        let log = maximum(|log: f64| self.log_likelihood(shape, self.mean * log.exp()), [least.ln(), 30.0_f64.ln()]);
        self.mean * log.exp()
    }

    fn profile(&self, shape: f64) -> f64 {
        self.log_likelihood(shape, self.best_scale(shape))
    }

    fn best_shape(&self, profile: impl Fn(f64) -> f64) -> (f64, f64) {
        let shape = maximum(&profile, SHAPES);
        (shape, profile(shape))
    }

    fn shape_interval(&self, shape: f64, height: f64) -> Interval {
        let inside = |candidate: f64| self.profile(candidate) > height - self.drop;
        let end = |limit: f64| edge(inside, shape, limit).unwrap_or(limit);
        Interval { low: end(SHAPES[0]), high: end(SHAPES[1]) }
    }

    /// Returns the ends of the interval of the excess that one in `clusters` exceeds; inside, the log-likelihood falls
    /// by less than `drop`.
    fn return_interval(&self, clusters: f64, best: [f64; 2], height: f64) -> (Option<f64>, Option<f64>) {
        let centre = best[1] * growth(best[0], clusters);
        let inside = |excess: f64| {
            let at = |shape: f64| {
                let scale = excess / growth(shape, clusters);
                if scale > 0.0 { self.log_likelihood(shape, scale) } else { f64::NEG_INFINITY }
            };
            // The profile has one maximum, but may start at −∞.
            let near = maximum(at, SHAPES);
            at(near) > height - self.drop
        };
        if centre.is_nan() || centre <= 0.0 {
            return (None, None);
        }
        (edge(inside, centre, 1e-3 * centre), edge(inside, centre, 50.0 * centre))
    }
}

/// Returns the end of the range, from `from` towards `to`, in which a condition holds; `None` if it also holds at `to`.
fn edge(holds: impl Fn(f64) -> bool, from: f64, to: f64) -> Option<f64> {
    if holds(to) {
        return None;
    }
    let Ok([inside, _]) = bisect(from, to, 1e-12 * (to - from).abs(), |x| Ok::<_, Infallible>(holds(x)));
    Some(inside)
}

/// Returns the argument of the largest value: the best of a coarse grid, refined by golden sections.
fn maximum(f: impl Fn(f64) -> f64, [low, high]: [f64; 2]) -> f64 {
    const GRID: usize = 24;
    let step = (high - low) / GRID as f64;
    let at = |i: usize| low + step * i as f64;
    let best = (0..=GRID).map(|i| (i, f(at(i)))).filter(|(_, v)| !v.is_nan()).max_by(|a, b| a.1.total_cmp(&b.1));
    let centre = best.map_or(0, |(i, _)| i);
    let bracket = [at(centre.saturating_sub(1)), at((centre + 1).min(GRID))];
    golden_section(|x| -f(x), bracket, 2.1e-7 * (bracket[1] - bracket[0])).middle()
}

#[cfg(test)]
mod tests {
    use super::*;
    use asperity_base::distribution::Marginal;
    use asperity_base::random;
    use asperity_testing::{covered, repetitions};

    /// Returns independent values with a tail of shape ξ: (U^{−ξ} − 1)/ξ.
    fn pareto(shape: f64, n: usize, run: u64) -> Vec<f64> {
        let xi = random::standard_normal(&mut random::stream(23, "tail", run), n);
        let exponential = |g: &f64| -asperity_base::distribution::standard_normal_cdf(*g).ln();
        xi.iter().map(exponential).map(|e| if shape == 0.0 { e } else { (shape * e).exp_m1() / shape }).collect()
    }

    #[test]
    fn clusters_are_runs_at_a_sufficient_distance() {
        let first: &[f64] = &[2.0, 0.0, 3.0, 0.0, 0.0, 0.0, 1.5, f64::NAN, f64::NAN, 4.0];
        // Two values below join at a distance of three, three do not. A new record starts a new cluster.
        assert_eq!(peaks(&[first, &[0.0, 1.2]], 1.0, 3), [3.0, 4.0, 1.2]);
        assert_eq!(peaks(&[first], 1.0, 1), [2.0, 3.0, 1.5, 4.0]);
        assert_eq!(peaks(&[first], 1.0, 4), [4.0]);
    }

    #[test]
    #[ignore = "slow"]
    fn intervals_cover_the_shape_and_the_return_level() {
        for shape in [-0.2, 0.0, 0.3] {
            let runs = repetitions(100);
            let (mut held, mut levels) = (0, 0);
            for run in 0..runs as u64 {
                let values = pareto(shape, 1000, run);
                let records: Vec<&[f64]> = values.chunks(250).collect();
                let tail = Tail::of(&records, 1, 1e-3, &[]).unwrap();
                // For independent values every value above the threshold is a cluster, except neighbours.
                assert!(tail.clusters >= 40 && tail.clusters as f64 <= 1000.0 * tail.fraction, "{tail:?}");
                held += usize::from(tail.shape_interval.contains(shape));
                // A value exceeded once in ten metres is exceeded by one of 10,000 values.
                let truth = growth(shape, 10_000.0);
                let level = tail.return_levels[2];
                levels += usize::from(level.interval.is_none_or(|interval| interval.contains(truth)));
                assert!(level.interval.is_none_or(|interval| interval.contains(level.mu)), "{level:?}");
            }
            let case = format!("1,000 values of a generalised Pareto distribution, ξ = {shape}");
            let shapes = covered("shape of the friction tail", &case, held, runs);
            let levels = covered("return level of friction", &case, levels, runs);
            // 95 % with a standard error of 2.2 %. The coverage with 45 excesses is slightly below its limit.
            assert!(shapes >= 0.85 && levels >= 0.85, "ξ = {shape}: {shapes} and {levels}");
        }
    }

    #[test]
    fn a_correct_distribution_expects_the_largest_value_and_a_lighter_one_does_not() {
        let values = pareto(0.3, 4000, 1);
        let records: Vec<&[f64]> = values.chunks(1000).collect();
        let fit = |marginal: Marginal| Fit {
            family: Family::Normal,
            marginal,
            n: 4000,
            log_likelihood: 0.0,
            low_end: asperity_base::distribution::fit::End::Given,
            high_end: asperity_base::distribution::fit::End::Given,
        };
        // For the true distribution the number of values above the threshold is as observed. The normal distribution of
        // the same mean and standard deviation has almost no values as large as the largest.
        let distribution = Marginal::empirical(pareto(0.3, 200_000, 2)).unwrap();
        let (mean, std) = (distribution.mean(), distribution.std());
        let tail =
            Tail::of(&records, 1, 1e-3, &[fit(distribution), fit(Marginal::normal(mean, std).unwrap())]).unwrap();
        assert!(tail.distributions[0].larger > 0.02 && tail.distributions[0].larger < 0.98, "{:?}", tail.distributions);
        assert!(tail.distributions[1].larger < 1e-3, "{:?}", tail.distributions);
        assert!(tail.distributions[1].return_levels[1] < tail.return_levels[1].mu);
    }

    #[test]
    fn few_peaks_have_no_tail() {
        let values: Vec<f64> = (0..2000).map(|i| (f64::from(i) / 100.0).sin()).collect();
        assert_eq!(Tail::of(&[&values], 1, 1e-3, &[]), None);
        assert_eq!(Tail::of(&[&[0.2; 50]], 1, 1e-3, &[]), None);
    }
}
