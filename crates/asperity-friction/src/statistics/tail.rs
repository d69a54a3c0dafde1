//! How large μ gets.
//!
//! Peaks over a high threshold, one from each cluster of windows above it, have excesses whose law tends to the generalised
//! Pareto law 1 − (1 + ξy/σ)^{−1/ξ}: ξ < 0 is a tail that ends (at −σ/ξ above the threshold; ξ = −1/b for a Beta law), ξ = 0
//! an exponential one, ξ > 0 a power law.
//!
//! # References
//! Pickands, *Ann. Stat.* **3** (1975) 119, <https://doi.org/10.1214/aos/1176343003>; Davison & Smith, *J. R. Stat. Soc. B*
//! **52** (1990) 393, <https://doi.org/10.1111/j.2517-6161.1990.tb01796.x> (peaks of correlated records, return levels).

use std::convert::Infallible;

use asperity_base::law::fit::{Family, Fit};
use asperity_base::numeric::{bisect, golden_section};
use asperity_base::stats::{Interval, NORMAL_95, correlation_time, quantile_sorted, sorted_present};

/// Shares of the windows above the threshold that are tried, until there are enough clusters.
const SHARES: [f64; 4] = [0.05, 0.1, 0.15, 0.2];
const WANTED_CLUSTERS: usize = 40;
const LEAST_CLUSTERS: usize = 20;
/// Distances of the return levels in metre.
const DISTANCES_M: [f64; 3] = [0.1, 1.0, 10.0];
/// Shapes ξ that are searched; below −1 the likelihood has no maximum.
const SHAPES: [f64; 2] = [-0.95, 2.0];
/// Drop of the logarithm of the likelihood at the ends of a 95 % profile interval.
const DROP: f64 = 0.5 * NORMAL_95 * NORMAL_95;

/// The upper tail of μ(s).
#[derive(Debug, Clone, PartialEq)]
pub struct Tail {
    /// Largest value.
    pub largest: f64,
    /// Threshold of the peaks.
    pub threshold: f64,
    /// Share of the windows above it.
    pub share: f64,
    /// Clusters of windows above it: runs that are at least a correlation time apart, and as many as those of the lanes of a
    /// strip are worth.
    pub clusters: usize,
    /// Clusters per metre of sliding, of one lane.
    pub clusters_per_m: f64,
    /// Shape ξ of the generalised Pareto law of the highest excess of each cluster.
    pub shape: f64,
    /// Its 95 % interval by the profile of the likelihood.
    pub shape_interval: Interval,
    /// Scale σ.
    pub scale: f64,
    /// Values exceeded once in 0.1 m, 1 m and 10 m of sliding, as far as that is more than one cluster.
    pub return_levels: Vec<ReturnLevel>,
    /// What fitted laws say, in the order of their ranking.
    pub laws: Vec<LawTail>,
}

/// A value that μ exceeds once in a distance on average.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ReturnLevel {
    /// Sliding distance in metre.
    pub distance_m: f64,
    /// The value.
    pub mu: f64,
    /// Its 95 % interval by the profile of the likelihood; none where that does not end it.
    pub interval: Option<Interval>,
}

/// The upper tail by a fitted law that clusters as the records do at the threshold.
#[derive(Debug, Clone, PartialEq)]
pub struct LawTail {
    /// Family of the law.
    pub family: Family,
    /// Probability that the largest of as many values would be larger than the one found. Near 0 the law's tail is too
    /// light, near 1 too heavy.
    pub larger: f64,
    /// Values exceeded once in the distances of [`Tail::return_levels`].
    pub return_levels: Vec<f64>,
}

impl Tail {
    /// The tail of records with steps of `step_m`, so many lanes to a strip, and of laws fitted to them; `None` with fewer than
    /// 20 clusters. Lanes that are above the threshold together
    /// count as far as they differ.
    pub(super) fn of(records: &[&[f64]], lanes: usize, step_m: f64, fits: &[Fit]) -> Option<Self> {
        let sorted = sorted_present(records.iter().flat_map(|record| record.iter().copied()));
        let largest = *sorted.last()?;
        if sorted[0] == largest {
            return None;
        }
        let times = records.iter().filter_map(|record| correlation_time(record).ok()).map(|time| time.steps);
        let apart = times.fold([0.0, 0.0], |[sum, count], steps| [sum + steps, count + 1.0]);
        let apart = (apart[0] / apart[1]).ceil() as usize;
        let found = SHARES.map(|share| {
            let threshold = quantile_sorted(&sorted, 1.0 - share);
            let (peaks, alike) = (peaks(records, threshold, apart), alike(records, lanes, threshold));
            let separate = (peaks.len() as f64 / alike).round() as usize;
            (threshold, peaks, alike, separate)
        });
        let enough = found.iter().find(|(.., separate)| *separate >= WANTED_CLUSTERS);
        let (threshold, peaks, alike, separate) = enough.or(found.iter().max_by_key(|(.., separate)| *separate))?;
        if *separate < LEAST_CLUSTERS {
            return None;
        }
        let distance_m = sorted.len() as f64 * step_m;
        let share = sorted.iter().filter(|mu| **mu > *threshold).count() as f64 / sorted.len() as f64;
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
        let laws = fits.iter().map(|fit| {
            // Clusters above x for each above the threshold, as windows above x for each above it.
            let clusters = |x: f64| clusters_per_m * fit.law.survival(x) / share;
            LawTail {
                family: fit.family,
                larger: -(-clusters(largest) * distance_m / alike).exp_m1(),
                return_levels: distances()
                    .map(|distance_m| fit.law.quantile(1.0 - share / (clusters_per_m * distance_m)))
                    .collect(),
            }
        });
        Some(Self {
            largest,
            threshold: *threshold,
            share,
            clusters: *separate,
            clusters_per_m,
            shape,
            shape_interval,
            scale,
            return_levels: return_levels.collect(),
            laws: laws.collect(),
        })
    }
}

/// The highest value of each cluster: values above the threshold with fewer than `apart` others between them. A missing value
/// counts as one below.
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

/// How many lanes of a strip are above a threshold together: variance of the number above over that of independent ones.
fn alike(records: &[&[f64]], lanes: usize, threshold: f64) -> f64 {
    if lanes == 1 {
        return 1.0;
    }
    let above = |mu: &f64| f64::from(u8::from(*mu > threshold));
    let values = records.iter().map(|record| record.len()).sum::<usize>() as f64;
    let share = records.iter().flat_map(|record| record.iter()).map(above).sum::<f64>() / values;
    let (mut together, mut alone) = (0.0, 0.0);
    for strip in records.chunks(lanes) {
        for place in 0..strip[0].len() {
            let differences = || strip.iter().map(|lane| above(&lane[place]) - share);
            together += differences().sum::<f64>().powi(2);
            alone += differences().map(|difference| difference * difference).sum::<f64>();
        }
    }
    (together / alone).clamp(1.0, lanes as f64)
}

/// ((clusters)^ξ − 1)/ξ: the excess, in scales, that one in so many clusters exceeds.
fn growth(shape: f64, clusters: f64) -> f64 {
    let log = clusters.ln();
    if (shape * log).abs() < 1e-9 { log } else { (shape * log).exp_m1() / shape }
}

/// Excesses over a threshold and their likelihood under the generalised Pareto law.
struct Excesses {
    values: Vec<f64>,
    mean: f64,
    /// Drop of the logarithm of the likelihood at the ends of an interval.
    drop: f64,
}

impl Excesses {
    /// Each of the independent peaks is there so many times.
    fn of(peaks: &[f64], threshold: f64, times: f64) -> Self {
        let values: Vec<f64> = peaks.iter().map(|peak| peak - threshold).collect();
        let mean = values.iter().sum::<f64>() / values.len() as f64;
        Self { values, mean, drop: times * DROP }
    }

    /// Logarithm of the likelihood.
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

    /// The scale of largest likelihood at a shape, in a range of scales about the mean excess.
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

    /// Ends of the excess that one in `clusters` exceeds, within which the likelihood falls by less than `drop`.
    fn return_interval(&self, clusters: f64, best: [f64; 2], height: f64) -> (Option<f64>, Option<f64>) {
        let centre = best[1] * growth(best[0], clusters);
        let inside = |excess: f64| {
            let at = |shape: f64| {
                let scale = excess / growth(shape, clusters);
                if scale > 0.0 { self.log_likelihood(shape, scale) } else { f64::NEG_INFINITY }
            };
            // The profile has one maximum but may be −∞ at first.
            let near = maximum(at, SHAPES);
            at(near) > height - self.drop
        };
        if centre.is_nan() || centre <= 0.0 {
            return (None, None);
        }
        (edge(inside, centre, 1e-3 * centre), edge(inside, centre, 50.0 * centre))
    }
}

/// Where a condition that holds at `from` ceases to hold on the way to `to`; `None` where it still holds there.
fn edge(holds: impl Fn(f64) -> bool, from: f64, to: f64) -> Option<f64> {
    if holds(to) {
        return None;
    }
    let Ok([inside, _]) = bisect(from, to, 1e-12 * (to - from).abs(), |x| Ok::<_, Infallible>(holds(x)));
    Some(inside)
}

/// The argument of the largest value: the best of a coarse grid, then golden sections about it.
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
    use asperity_base::law::Marginal;
    use asperity_base::random;

    /// Independent values with a tail of shape ξ: (U^{−ξ} − 1)/ξ.
    fn pareto(shape: f64, n: usize, run: u64) -> Vec<f64> {
        let germ = random::standard_normal(&mut random::stream(23, "tail", run), n);
        let exponential = |g: &f64| -asperity_base::law::standard_normal_cdf(*g).ln();
        germ.iter().map(exponential).map(|e| if shape == 0.0 { e } else { (shape * e).exp_m1() / shape }).collect()
    }

    #[test]
    fn clusters_are_runs_that_are_far_enough_apart() {
        let first: &[f64] = &[2.0, 0.0, 3.0, 0.0, 0.0, 0.0, 1.5, f64::NAN, f64::NAN, 4.0];
        // Two below join at three apart, three do not; a new record begins anew.
        assert_eq!(peaks(&[first, &[0.0, 1.2]], 1.0, 3), [3.0, 4.0, 1.2]);
        assert_eq!(peaks(&[first], 1.0, 1), [2.0, 3.0, 1.5, 4.0]);
        assert_eq!(peaks(&[first], 1.0, 4), [4.0]);
    }

    #[test]
    fn the_shape_of_a_tail_and_its_return_level_lie_in_their_intervals() {
        for shape in [-0.2, 0.0, 0.3] {
            let runs = 100;
            let (mut held, mut levels) = (0, 0);
            for run in 0..runs {
                let values = pareto(shape, 1000, run);
                let records: Vec<&[f64]> = values.chunks(250).collect();
                let tail = Tail::of(&records, 1, 1e-3, &[]).unwrap();
                // Independent values: every one above the threshold is a cluster, but for neighbours.
                assert!(tail.clusters >= 40 && tail.clusters <= 50 && tail.share == 0.05, "{tail:?}");
                held += usize::from(tail.shape_interval.contains(shape));
                // Once in ten metres: one value of 10,000.
                let truth = growth(shape, 10_000.0);
                let level = tail.return_levels[2];
                levels += usize::from(level.interval.is_none_or(|interval| interval.contains(truth)));
                assert!(level.interval.is_none_or(|interval| interval.contains(level.mu)), "{level:?}");
            }
            println!("{shape}: {held} {levels}");
            // 95 % with a standard error of 2.2 %; the likelihood of 45 excesses is a little short of its limit.
            assert!(held >= 85 && levels >= 85, "ξ = {shape}: {held} and {levels} of {runs}");
        }
    }

    #[test]
    fn a_law_that_is_right_expects_the_largest_value_and_a_lighter_one_does_not() {
        let values = pareto(0.3, 4000, 1);
        let records: Vec<&[f64]> = values.chunks(1000).collect();
        let fit = |law: Marginal| Fit {
            family: Family::Normal,
            law,
            n: 4000,
            log_likelihood: 0.0,
            low_end: asperity_base::law::fit::End::Given,
            high_end: asperity_base::law::fit::End::Given,
        };
        // As many values as there are lie above the threshold of the true law, and hardly any of the normal one of the same
        // mean and standard deviation lies where the largest is.
        let true_law = Marginal::empirical(pareto(0.3, 200_000, 2)).unwrap();
        let (mean, std) = (true_law.mean(), true_law.std());
        let tail = Tail::of(&records, 1, 1e-3, &[fit(true_law), fit(Marginal::normal(mean, std).unwrap())]).unwrap();
        assert!(tail.laws[0].larger > 0.02 && tail.laws[0].larger < 0.98, "{:?}", tail.laws);
        assert!(tail.laws[1].larger < 1e-3, "{:?}", tail.laws);
        assert!(tail.laws[1].return_levels[1] < tail.return_levels[1].mu);
    }

    #[test]
    fn few_peaks_have_no_tail() {
        let values: Vec<f64> = (0..2000).map(|i| (f64::from(i) / 100.0).sin()).collect();
        assert_eq!(Tail::of(&[&values], 1, 1e-3, &[]), None);
        assert_eq!(Tail::of(&[&[0.2; 50]], 1, 1e-3, &[]), None);
    }
}
