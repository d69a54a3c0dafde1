//! Mixtures of half-spaces and normal distributions from which failures are drawn.
//!
//! Each sample to imitate has a direction, into which the limit state falls there. The samples are grouped by their directions
//! (spherical k-means). Each group gives these parts:
//!
//! - the normal distribution restricted to the half-space a·z > b, with a the mean direction and b a low quantile of a·z. For a
//!   limit state that is linear in the group the weights φ/h are constant, and they are bounded inside the half-space;
//! - normal distributions with the mean and the widened covariance of the group, which follow curved sets in many variables.
//!
//! The weights of the parts maximise the likelihood of the samples (expectation maximisation), but the half-space of a group has
//! most of its weight: samples of Markov chains are correlated, and normal distributions fit their clusters. The number of groups and the
//! shrinkage of the covariances maximise the likelihood of the samples of the other half.
//!
//! # References
//! Half-spaces: Owen, Maximov & Chertkov, *Electron. J. Stat.* **13** (2019) 231, <https://doi.org/10.1214/18-EJS1527>. Normal
//! mixtures: Geyer, Papaioannou & Straub, *Struct. Saf.* **76** (2019) 15, <https://doi.org/10.1016/j.strusafe.2018.07.001>.

use asperity_base::distribution::{standard_normal_cdf, standard_normal_quantile};
use asperity_base::random::{Stream, standard_normal};

/// Numbers of groups that are tried.
const GROUPS: [usize; 5] = [1, 2, 3, 4, 6];
/// Shrinkages of the covariances towards multiples of the identity that are tried.
const SHRINKAGES: [f64; 3] = [0.05, 0.4, 1.0];
/// Factors on the fitted variances of the normal distributions of a group.
const WIDENINGS: [f64; 2] = [1.1, 1.8];
/// Quantile of a·z at which the half-space of a group begins.
const BEGIN: f64 = 0.01;
/// Smallest weight of a part, divided by the equal weight.
const LEAST_WEIGHT: f64 = 0.3;
/// Smallest weight of the half-space of a group, divided by the weight that the group has without it.
const HALF_SPACE: f64 = 1.5;
/// Distance of the half-space before that quantile, divided by the mean of a·z beyond it.
const BEFORE: f64 = 0.15;
/// Iterations of the grouping and of the weights.
const ITERATIONS: usize = 12;

/// Mixture density h from which samples are drawn.
#[derive(Debug, Clone)]
pub(super) struct Proposal {
    variables: usize,
    parts: Vec<(f64, Part)>,
}

#[derive(Debug, Clone)]
enum Part {
    /// Normal distribution restricted to direction·z > begin.
    HalfSpace { direction: Vec<f64>, begin: f64, probability: f64 },
    /// Normal distribution; the factor L of its covariance LLᵀ row by row.
    Normal { mean: Vec<f64>, factor: Vec<Vec<f64>>, log_determinant: f64 },
}

/// Sample and its direction, a unit vector.
type Directed<'a> = (&'a [f64], &'a [f64]);

impl Proposal {
    /// Fits the mixture to samples with their directions.
    pub(super) fn fit(points: &[Vec<f64>], directions: &[Vec<f64>]) -> Self {
        let all: Vec<Directed<'_>> =
            points.iter().zip(directions).map(|(z, direction)| (z.as_slice(), direction.as_slice())).collect();
        let half = |first: usize| all.iter().skip(first).step_by(2).copied().collect::<Vec<_>>();
        let (even, odd) = (half(0), half(1));
        let mut best = (f64::NEG_INFINITY, GROUPS[0], 1.0);
        for groups in GROUPS {
            if all.len() < 10 * groups && groups > 1 {
                break;
            }
            for shrinkage in SHRINKAGES {
                let score = Self::with(&even, groups, shrinkage).mean_log_ratio(&odd)
                    + Self::with(&odd, groups, shrinkage).mean_log_ratio(&even);
                if score > best.0 {
                    best = (score, groups, shrinkage);
                }
            }
        }
        Self::with(&all, best.1, best.2)
    }

    /// Fits a mixture with a number of groups and a shrinkage.
    fn with(points: &[Directed<'_>], groups: usize, shrinkage: f64) -> Self {
        let mut parts = Vec::new();
        for group in grouped(points, groups) {
            parts.push((1.0, half_space(&group)));
            parts.extend(WIDENINGS.map(|widening| (1.0, normal(&group, shrinkage, widening))));
        }
        let equal = 1.0 / parts.len() as f64;
        parts.iter_mut().for_each(|part| part.0 = equal);
        let mut mixture = Self { variables: points.first().map_or(0, |(z, _)| z.len()), parts };
        let ratios: Vec<Vec<f64>> = points
            .iter()
            .map(|(z, _)| mixture.parts.iter().map(|(_, part)| part.log_ratio(z).exp()).collect())
            .collect();
        for _ in 0..ITERATIONS {
            let mut sums = vec![0.0; mixture.parts.len()];
            for ratios in &ratios {
                let total: f64 = ratios.iter().zip(&mixture.parts).map(|(ratio, (weight, _))| ratio * weight).sum();
                if total > 0.0 && total.is_finite() {
                    let fractions =
                        ratios.iter().zip(&mixture.parts).map(|(ratio, (weight, _))| ratio * weight / total);
                    sums.iter_mut().zip(fractions).for_each(|(sum, fraction)| *sum += fraction);
                }
            }
            let total: f64 = sums.iter().sum::<f64>().max(f64::MIN_POSITIVE);
            for ((weight, _), sum) in mixture.parts.iter_mut().zip(sums) {
                *weight = LEAST_WEIGHT * equal + (1.0 - LEAST_WEIGHT) * sum / total;
            }
        }
        for group in mixture.parts.chunks_mut(1 + WIDENINGS.len()) {
            let least = HALF_SPACE * group.iter().map(|part| part.0).sum::<f64>();
            group[0].0 = group[0].0.max(least);
        }
        let total: f64 = mixture.parts.iter().map(|part| part.0).sum();
        mixture.parts.iter_mut().for_each(|part| part.0 /= total);
        mixture
    }

    /// Returns the mean of ln(h/φ) over the points, each at least −20.
    fn mean_log_ratio(&self, points: &[Directed<'_>]) -> f64 {
        points.iter().map(|(z, _)| self.ratio(z).ln().max(-20.0)).sum::<f64>() / points.len().max(1) as f64
    }

    /// Returns h/φ at a point.
    pub(super) fn ratio(&self, z: &[f64]) -> f64 {
        self.parts.iter().map(|(weight, part)| weight * part.log_ratio(z).exp()).sum()
    }

    /// Returns `count` points, distributed over the parts in proportion to their weights.
    pub(super) fn draw(&self, count: usize, draws: &mut Stream) -> Vec<Vec<f64>> {
        let offset = uniform(draws);
        (0..count)
            .map(|i| {
                let mut level = (i as f64 + offset) / count as f64;
                let chosen = self.parts.iter().find(|(weight, _)| {
                    level -= weight;
                    level < 0.0
                });
                let xi = standard_normal(draws, self.variables);
                let u = uniform(draws);
                chosen.or(self.parts.last()).map_or_else(Vec::new, |(_, part)| part.transform(xi, u))
            })
            .collect()
    }
}

impl Part {
    /// Returns the logarithm of the density divided by the standard normal density.
    fn log_ratio(&self, z: &[f64]) -> f64 {
        match self {
            Self::HalfSpace { direction, begin, probability } => {
                if dot(direction, z) > *begin {
                    -probability.ln()
                } else {
                    f64::NEG_INFINITY
                }
            }
            Self::Normal { mean, factor, log_determinant } => {
                let mut residual: Vec<f64> = z.iter().zip(mean).map(|(z, m)| z - m).collect();
                for i in 0..residual.len() {
                    let (solved, rest) = residual.split_at_mut(i);
                    rest[0] = (rest[0] - dot(&factor[i][..i], solved)) / factor[i][i];
                }
                0.5 * (dot(z, z) - dot(&residual, &residual)) - 0.5 * log_determinant
            }
        }
    }

    /// Returns a point of the part from standard normal variables and a uniform one.
    fn transform(&self, mut xi: Vec<f64>, u: f64) -> Vec<f64> {
        match self {
            Self::HalfSpace { direction, probability, .. } => {
                let along = -standard_normal_quantile(u * probability) - dot(direction, &xi);
                xi.iter_mut().zip(direction).for_each(|(z, a)| *z += along * a);
                xi
            }
            Self::Normal { mean, factor, .. } => {
                mean.iter().zip(factor).map(|(m, row)| m + dot(row, &xi[..row.len()])).collect()
            }
        }
    }
}

/// Returns the half-space of a group.
fn half_space(group: &[Directed<'_>]) -> Part {
    let direction = unit(&mean(group.iter().map(|(_, direction)| *direction)));
    let mut along: Vec<f64> = group.iter().map(|(z, _)| dot(&direction, z)).collect();
    let place = ((BEGIN * along.len() as f64) as usize).min(along.len() - 1);
    let begin = *along.select_nth_unstable_by(place, f64::total_cmp).1;
    // Correlated samples do not reach the lowest a·z.
    let beyond = along.iter().sum::<f64>() / along.len() as f64 - begin;
    let begin = (begin - BEFORE * beyond).next_down();
    Part::HalfSpace { direction, begin, probability: standard_normal_cdf(-begin) }
}

/// Returns the normal distribution of a group; the covariance is shrunk towards a multiple of the identity.
fn normal(group: &[Directed<'_>], shrinkage: f64, widening: f64) -> Part {
    let mean = mean(group.iter().map(|(z, _)| *z));
    let n = mean.len();
    let count = group.len() as f64;
    let mut covariance = vec![vec![0.0; n]; n];
    for (z, _) in group {
        let residual: Vec<f64> = z.iter().zip(&mean).map(|(z, m)| z - m).collect();
        for (row, r) in covariance.iter_mut().zip(&residual) {
            row.iter_mut().zip(&residual).for_each(|(c, s)| *c += r * s / count);
        }
    }
    let spread = ((0..n).map(|i| covariance[i][i]).sum::<f64>() / n as f64).max(1e-4);
    let mut factor: Vec<Vec<f64>> = Vec::with_capacity(n);
    let mut log_determinant = 0.0;
    for i in 0..n {
        let mut row = vec![0.0; i + 1];
        for j in 0..=i {
            let diagonal = if i == j { shrinkage * spread + 1e-6 * spread } else { 0.0 };
            let rest = widening * ((1.0 - shrinkage) * covariance[i][j] + diagonal)
                - dot(&row[..j], if j < i { &factor[j][..j] } else { &row[..j] });
            row[j] = if i == j { rest.max(1e-6 * spread).sqrt() } else { rest / factor[j][j] };
        }
        log_determinant += 2.0 * row[i].ln();
        factor.push(row);
    }
    Part::Normal { mean, factor, log_determinant }
}

/// Groups points by their directions: spherical k-means from starts that are far apart. Groups of fewer than five points are
/// left out, but one group remains.
fn grouped<'a>(points: &[Directed<'a>], groups: usize) -> Vec<Vec<Directed<'a>>> {
    let mut centres = vec![unit(&mean(points.iter().map(|(_, direction)| *direction)))];
    while centres.len() < groups {
        let closeness = |d: &[f64]| centres.iter().map(|c| dot(c, d)).fold(f64::NEG_INFINITY, f64::max);
        let far = points.iter().min_by(|a, b| closeness(a.1).total_cmp(&closeness(b.1)));
        let Some((_, far)) = far else { break };
        centres.push(far.to_vec());
    }
    let mut members: Vec<Vec<Directed<'a>>> = Vec::new();
    for _ in 0..ITERATIONS {
        members = vec![Vec::new(); centres.len()];
        for point in points {
            let nearest =
                (0..centres.len()).max_by(|a, b| dot(&centres[*a], point.1).total_cmp(&dot(&centres[*b], point.1)));
            members[nearest.unwrap_or(0)].push(*point);
        }
        for (centre, members) in centres.iter_mut().zip(&members) {
            if !members.is_empty() {
                *centre = unit(&mean(members.iter().map(|(_, direction)| *direction)));
            }
        }
    }
    members.retain(|group| group.len() >= 5);
    if members.is_empty() { vec![points.to_vec()] } else { members }
}

fn mean<'a>(points: impl ExactSizeIterator<Item = &'a [f64]>) -> Vec<f64> {
    let count = points.len() as f64;
    let mut mean = Vec::new();
    for z in points {
        mean.resize(z.len(), 0.0);
        mean.iter_mut().zip(z).for_each(|(m, z)| *m += z / count);
    }
    mean
}

pub(super) fn unit(z: &[f64]) -> Vec<f64> {
    let length = dot(z, z).sqrt().max(f64::MIN_POSITIVE);
    z.iter().map(|z| z / length).collect()
}

fn dot(a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).map(|(a, b)| a * b).sum()
}

/// Returns a uniform number in (0, 1).
fn uniform(draws: &mut Stream) -> f64 {
    standard_normal_cdf(standard_normal(draws, 1)[0])
}

#[cfg(test)]
mod tests {
    use super::*;
    use asperity_base::random::stream;
    use asperity_base::stats::Moments;

    /// Returns `count` points about (`along`, 0, 0) with the standard deviations 0.5, 1 and 2, and their direction.
    fn cluster(along: f64, count: usize, seed: u64) -> (Vec<Vec<f64>>, Vec<Vec<f64>>) {
        let normal = standard_normal(&mut stream(seed, "cluster", 0), 3 * count);
        let points = normal.chunks(3).map(|z| vec![along + 0.5 * z[0], z[1], 2.0 * z[2]]).collect();
        (points, vec![vec![along.signum(), 0.0, 0.0]; count])
    }

    fn directed<'a>(points: &'a [Vec<f64>], directions: &'a [Vec<f64>]) -> Vec<Directed<'a>> {
        points.iter().zip(directions).map(|(z, d)| (z.as_slice(), d.as_slice())).collect()
    }

    #[test]
    fn a_half_space_begins_before_the_low_quantile_of_its_group() {
        let (points, directions) = cluster(3.0, 250, 1);
        let Part::HalfSpace { direction, begin, probability } = half_space(&directed(&points, &directions)) else {
            panic!("another part")
        };
        let mut along: Vec<f64> = points.iter().map(|z| z[0]).collect();
        along.sort_by(f64::total_cmp);
        let wanted = along[2] - 0.15 * (along.iter().sum::<f64>() / 250.0 - along[2]);
        assert_eq!(direction, [1.0, 0.0, 0.0]);
        assert!((begin - wanted).abs() < 1e-12 && (probability - standard_normal_cdf(-begin)).abs() < 1e-15);
    }

    #[test]
    fn a_normal_part_has_the_widened_and_shrunk_covariance_of_its_group() {
        let (points, directions) = cluster(3.0, 400, 2);
        let mean: Vec<f64> = (0..3).map(|k| points.iter().map(|z| z[k]).sum::<f64>() / 400.0).collect();
        let covariance =
            |i: usize, j: usize| points.iter().map(|z| (z[i] - mean[i]) * (z[j] - mean[j])).sum::<f64>() / 400.0;
        let spread = (0..3).map(|i| covariance(i, i)).sum::<f64>() / 3.0;
        let part = normal(&directed(&points, &directions), 0.4, 1.8);
        let Part::Normal { mean: found, factor, log_determinant } = part else { panic!("another part") };
        assert!(found.iter().zip(&mean).all(|(a, b)| (a - b).abs() < 1e-12));
        for i in 0..3 {
            for j in 0..=i {
                let diagonal = if i == j { (0.4 + 1e-6) * spread } else { 0.0 };
                let wanted = 1.8 * (0.6 * covariance(i, j) + diagonal);
                assert!((dot(&factor[i][..=j], &factor[j]) - wanted).abs() < 1e-12, "{i} {j}");
            }
        }
        let determinant: f64 = (0..3).map(|i| factor[i][i].powi(2)).product();
        assert!((log_determinant - determinant.ln()).abs() < 1e-12);
    }

    #[test]
    fn groups_have_weights_after_their_samples_and_the_density_is_that_of_the_draws() {
        let (mut points, mut directions) = cluster(3.0, 800, 3);
        let (others, opposite) = cluster(-3.0, 200, 4);
        points.extend(others);
        directions.extend(opposite);
        let found = Proposal::with(&directed(&points, &directions), 2, 0.4);
        let weights: Vec<f64> = found.parts.iter().map(|part| part.0).collect();
        assert!((weights.iter().sum::<f64>() - 1.0).abs() < 1e-12 && weights.len() == 6);
        // The half-space of a group has its weight times a constant: 0.7 of the share of the samples and 0.3 of a half.
        let ratio = (weights[0] / weights[3]).max(weights[3] / weights[0]);
        assert!((ratio - (0.7 * 0.8 + 0.15) / (0.7 * 0.2 + 0.15)).abs() < 0.1, "{weights:?}");
        // The mean of φ/h over points of h that lie in a set is the probability of the set.
        let inverse = |z: &Vec<f64>| if z[0] > 2.0 { 1.0 / found.ratio(z) } else { 0.0 };
        let inverse: Vec<f64> = found.draw(40_000, &mut stream(5, "draws", 0)).iter().map(inverse).collect();
        let inverse = Moments::new(&inverse);
        assert!((inverse.mean - standard_normal_cdf(-2.0)).abs() < 4.0 * inverse.standard_error(), "{inverse:?}");
    }
}
