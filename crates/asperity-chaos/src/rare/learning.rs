//! Learning the region of failure from few evaluations.
//!
//! Subset simulation runs on an [`Interpolant`] of the evaluations so far. The limit state is then evaluated at some of the
//! samples that fail there, and the interpolant is renewed until its failures are mostly true. The set that is sampled is {ĝ < m},
//! with the margin m equal to the error of the latest predictions, so that it also contains failures that the interpolant misses.
//! Further evaluations search for other regions of failure: samples with a small ĝ > m, far from all evaluations, and samples
//! furthest from all evaluations.
//!
//! If a few points of the first design predict the evaluations of one search, learning ends there. Otherwise the whole first design
//! is evaluated. If learning does not end, [`Learning::located`] runs subset simulation on the limit state itself.

use std::convert::Infallible;

use asperity_base::distribution::standard_normal_quantile;
use asperity_base::random::{Stream, standard_normal, stream};

use super::chains::{LastLevel, Plan, descend};
use super::error::RareError;
use super::interpolant::Interpolant;
use super::limit_state::LimitState;
use super::proposal::unit;
use crate::{Design, SamplingMethod};

/// Samples of a level of the interpolant, in the rounds and for the learnt region.
const SAMPLES: [usize; 2] = [400, 10_000];
/// Samples in the learnt region.
const REGION: usize = 800;
/// Moves of every sample in the region of a round; the learnt region has 10 more, and two more per variable.
const MOVES: usize = 2;
/// Evaluations of a round at random samples.
const RANDOM: usize = 8;
/// Evaluations of the first round that search for other regions; each round has one more.
const SEARCH: usize = 4;
/// Samples per level of subset simulation on the limit state, and failures that are kept and added there.
const LEVEL_SAMPLES: usize = 700;
const FAILURES: usize = 200;
/// Latest evaluations of that simulation that the interpolant passes through.
const LATEST: usize = 1500;
/// Step outwards from which the slope of the limit state is determined.
const OUTWARDS: f64 = 1.5;
/// Smallest slope, divided by the median deviation of the values.
const LEAST_SLOPE: f64 = 0.1;
/// Fraction of true failures, and of samples that fail without the margin, at which learning ends.
const SETTLED: f64 = 0.5;
/// Points of the first design that are evaluated at first, beside two per variable, and evaluations of the search that checks them.
const FEW: usize = 4;
const FIRST_SEARCH: usize = 4;
/// Power of the distance that selects the candidate furthest from all evaluations.
const FURTHEST: f64 = 12.0;
/// Random directions among the candidates of the search.
const SHELL: usize = 500;
/// Largest error of the search, divided by the predicted value plus the mean depth of the failures, at which one round
/// suffices, and several rounds.
const SURE: f64 = 0.02;
const ACCURATE: f64 = 0.5;
/// Number of successive rounds with accurate predictions after which learning ends.
const CONFIRMED: usize = 3;
/// Smallest probability that determines the distance of the search.
const LEAST_PROBABILITY: f64 = 1e-9;
/// Largest distance of design points beyond the mean norm √n.
const BEYOND: f64 = 5.0;
/// Values further from their median than this multiple of their median deviation are clipped for the interpolant.
const CLIP: f64 = 20.0;

/// Evaluations that the interpolant passes through.
pub(super) struct Learning {
    variables: usize,
    seed: u64,
    points: Vec<Vec<f64>>,
    values: Vec<f64>,
    /// Range of values without outliers.
    range: [f64; 2],
    rounds: u64,
    margin: f64,
    /// Points of the first design that are not evaluated yet.
    design: Vec<Vec<f64>>,
    /// Number of successive rounds with accurate predictions.
    confirmed: usize,
}

/// Learnt region of failure.
pub(super) struct Region {
    pub(super) points: Vec<Vec<f64>>,
    /// Directions of steepest descent of the interpolant at the points.
    pub(super) directions: Vec<Vec<f64>>,
    /// Interpolant of the evaluations so far.
    pub(super) interpolant: Interpolant,
}

impl Learning {
    /// Evaluates a few points of the first design: scrambled Sobol' directions, norms from those of standard normal variables to
    /// far outside.
    pub(super) fn new<E: Send>(
        variables: usize,
        seed: u64,
        state: &mut LimitState<'_, E>,
    ) -> Result<Self, RareError<E>> {
        let count = 24 + 2 * variables;
        let design = Design::new(SamplingMethod::Sobol, seed, "chaos/rare/design", count, variables)?;
        let mut points: Vec<Vec<f64>> = (0..count)
            .map(|index| {
                let xi = design.xi(index);
                let norm = xi.iter().map(|xi| xi * xi).sum::<f64>().sqrt();
                let outside = (variables as f64).sqrt() + BEYOND * (index % 8 + 1) as f64 / 8.0;
                let factor = if index % 2 == 0 { 1.0 } else { outside / norm };
                xi.iter().map(|xi| factor * xi).collect()
            })
            .collect();
        let rest = points.split_off(FEW + 2 * variables);
        let values = state.evaluate(&points)?;
        let range = range(&values);
        Ok(Self { variables, seed, range, points, values, rounds: 0, margin: 0.0, design: rest, confirmed: 0 })
    }

    /// Evaluates the rest of the first design.
    fn complete_design<E: Send>(&mut self, state: &mut LimitState<'_, E>) -> Result<(), RareError<E>> {
        let design = std::mem::take(&mut self.design);
        let values = state.evaluate(&design)?;
        self.add(&design, &values);
        self.range = range(&self.values);
        Ok(())
    }

    /// Adds evaluations.
    pub(super) fn add(&mut self, points: &[Vec<f64>], values: &[f64]) {
        for (point, value) in points.iter().zip(values) {
            if self.distance(point) > 1e-12 {
                self.points.push(point.clone());
                self.values.push(*value);
            }
        }
    }

    /// Learns for at most `rounds` rounds.
    pub(super) fn region<E: Send>(
        &mut self,
        rounds: usize,
        state: &mut LimitState<'_, E>,
    ) -> Result<Option<Region>, RareError<E>> {
        for round in 0.. {
            let Some(interpolant) = Interpolant::new(&self.points, &self.clipped()) else { return Ok(None) };
            let (level, _) = self.sample(&interpolant, SAMPLES[0]);
            let failing = level.values.iter().filter(|value| **value + self.margin < 0.0).count();
            if self.confirmed >= CONFIRMED && level.failed && failing as f64 >= SETTLED * level.values.len() as f64 {
                let (mut level, mut walk) = self.sample(&interpolant, SAMPLES[1]);
                walk.mix(10 + 2 * self.variables, &mut level);
                let directions = interpolant.descents(&level.points);
                return Ok(Some(Region { points: level.points, directions, interpolant }));
            }
            if round == rounds || state.left() < RANDOM + SEARCH + round {
                return Ok(None);
            }
            // The first search checks the few points of the design.
            let first = !self.design.is_empty();
            let (random, search) = if first { (0, FIRST_SEARCH) } else { (RANDOM, SEARCH + round) };
            let mut batch: Vec<Vec<f64>> =
                level.points.iter().step_by(level.points.len() / RANDOM).take(random).cloned().collect();
            let candidates = self.candidates(&level, &interpolant);
            for number in 0..search {
                // The error of cubic interpolation grows as d³ᐟ²; a large power selects the candidate furthest from all evaluations.
                let power = if number % 2 == 0 { 1.5 } else { FURTHEST };
                batch.extend(self.search(power, &candidates, &batch));
            }
            let values = state.evaluate(&batch)?;
            let predicted = interpolant.values(&batch);
            let errors: Vec<f64> =
                predicted.iter().zip(&values).map(|(found, g)| (found - self.clip(*g)).abs()).collect();
            // Mean depth of the failures: lowering g by so much multiplies the probability by about e.
            let depth = -level.values.iter().sum::<f64>() / level.values.len() as f64;
            // Errors far from failure matter less.
            let searched = errors[random..].iter().zip(&predicted[random..]);
            let worst = searched.fold(0.0_f64, |worst, (error, found)| worst.max(error / (depth + found.max(0.0))));
            let failures = values[..random].iter().filter(|g| **g < 0.0).count();
            self.confirmed = match worst {
                _ if !level.failed || (failures as f64) < SETTLED * random as f64 => 0,
                worst if worst < SURE => CONFIRMED,
                worst if worst < ACCURATE => self.confirmed + 1,
                _ => 0,
            };
            self.add(&batch, &values);
            if first {
                if self.confirmed < CONFIRMED {
                    self.confirmed = 0;
                    self.complete_design(state)?;
                }
            } else {
                self.margin = (errors[..random].iter().map(|e| e * e).sum::<f64>() / random as f64).sqrt();
            }
        }
        Ok(None)
    }

    /// Returns the region that subset simulation on the limit state itself locates; `None` without failures or evaluations.
    ///
    /// The levels are those of g divided by its slope outwards, which is about the distance to failure: levels of g itself lose
    /// regions where g is steep.
    pub(super) fn located<E: Send>(&mut self, state: &mut LimitState<'_, E>) -> Result<Option<Region>, RareError<E>> {
        // Replicates of subset simulation need the rest if importance sampling fails.
        let levels = state.left() / (3 * LEVEL_SAMPLES);
        let least = LEAST_SLOPE * (self.range[1] - self.range[0]) / (2.0 * CLIP);
        if levels < 2 || !least.is_finite() {
            return Ok(None);
        }
        let mut latest: Vec<(Vec<f64>, f64)> = Vec::new();
        let mut distances = |points: &[Vec<f64>]| {
            let outside = points.iter().map(|z| {
                let factor = 1.0 + OUTWARDS / norm(z);
                z.iter().map(|z| factor * z).collect()
            });
            let all: Vec<Vec<f64>> = points.iter().cloned().chain(outside).collect();
            let values = state.evaluate(&all)?;
            let (inner, outer) = values.split_at(points.len());
            let slopes = inner.iter().zip(outer).map(|(g, outer)| ((g - outer) / OUTWARDS).max(least));
            let distances = inner.iter().zip(slopes).map(|(g, slope)| g / slope).collect();
            latest.extend(all.into_iter().zip(values));
            Ok::<Vec<f64>, RareError<E>>(distances)
        };
        let mut draws = stream(self.seed, "chaos/rare/located", 0);
        let plan = Plan { variables: self.variables, samples: LEVEL_SAMPLES, fraction: 0.1, levels };
        let mut level = descend(plan, &mut draws, &mut distances)?;
        if !level.failed {
            return Ok(None);
        }
        // Failures among earlier evaluations start chains too, because the levels lose small regions.
        level.thin(FAILURES);
        let furthest = level.points.iter().map(|z| norm(z)).fold(0.0, f64::max);
        for (point, value) in self.points.iter().zip(&self.values) {
            if *value < 0.0 && norm(point) <= furthest {
                level.points.push(point.clone());
                level.values.push(*value);
            }
        }
        let count = level.points.len() + FAILURES;
        level.fill(count, &|value| value < 0.0, &mut 0.6, &mut draws, &mut distances)?;
        let (points, values): (Vec<_>, Vec<_>) = latest.into_iter().rev().take(LATEST).unzip();
        self.add(&points, &values);
        let Some(interpolant) = Interpolant::new(&self.points, &self.clipped()) else { return Ok(None) };
        let directions = interpolant.descents(&level.points);
        Ok(Some(Region { points: level.points, directions, interpolant }))
    }

    /// Returns predicted safe points among which a missed region may be, with ĝ − m: the samples of the last levels, and random
    /// directions at the distance of failures of a hundredth of the probability.
    fn candidates(&mut self, level: &LastLevel, interpolant: &Interpolant) -> Vec<(Vec<f64>, f64)> {
        let mut draws = stream(self.seed, "chaos/rare/search", self.rounds);
        let beta = standard_normal_quantile(0.01 * level.probability.max(LEAST_PROBABILITY));
        let radius = (beta * beta + self.variables as f64 - 1.0).sqrt();
        let mut points: Vec<Vec<f64>> = (0..SHELL)
            .map(|_| {
                let xi = unit(&standard_normal(&mut draws, self.variables));
                xi.into_iter().map(|xi| radius * xi).collect()
            })
            .collect();
        points.extend(level.before.iter().flat_map(|(points, _)| points.iter().cloned()));
        let values = interpolant.values(&points).into_iter().map(|value| value - self.margin);
        let mut candidates: Vec<_> = points.into_iter().zip(values).collect();
        candidates.retain(|(_, value)| *value > 0.0);
        candidates
    }

    /// Returns the candidate with the smallest (ĝ − m)/dᵖ, with d the distance to the nearest evaluation.
    fn search(&self, power: f64, candidates: &[(Vec<f64>, f64)], batch: &[Vec<f64>]) -> Option<Vec<f64>> {
        let scored =
            candidates.iter().map(|(z, value)| (z, value / self.distance(z).min(nearest(batch, z)).powf(power)));
        scored.min_by(|a, b| a.1.total_cmp(&b.1)).map(|(z, _)| z.clone())
    }

    /// Samples {ĝ < m}, or the last level above it; the values are ĝ − m.
    fn sample<'i>(&mut self, interpolant: &'i Interpolant, samples: usize) -> (LastLevel, Walk<'i>) {
        let mut draws = stream(self.seed, "chaos/rare/learning", self.rounds);
        self.rounds += 1;
        let plan = Plan { variables: self.variables, samples, fraction: 0.1, levels: usize::MAX };
        let margin = self.margin;
        let Ok(mut level) = descend(plan, &mut draws, &mut |points| shifted(interpolant, margin, points));
        let largest = level.values.iter().copied().fold(f64::NEG_INFINITY, f64::max);
        let threshold = if level.failed { -f64::MIN_POSITIVE } else { largest };
        let mut walk = Walk { interpolant, margin, threshold, step: 0.6, draws };
        let Ok(()) = level.fill(REGION, &|value| value <= threshold, &mut walk.step, &mut walk.draws, &mut |points| {
            shifted(interpolant, margin, points)
        });
        level.thin(REGION);
        walk.mix(MOVES, &mut level);
        (level, walk)
    }

    /// Returns the distance to the nearest evaluation.
    fn distance(&self, point: &[f64]) -> f64 {
        nearest(&self.points, point)
    }

    /// Returns the values without outliers.
    fn clipped(&self) -> Vec<f64> {
        self.values.iter().map(|value| self.clip(*value)).collect()
    }

    fn clip(&self, value: f64) -> f64 {
        value.clamp(self.range[0], self.range[1])
    }
}

/// Returns the range of values without outliers.
fn range(values: &[f64]) -> [f64; 2] {
    let median = |mut values: Vec<f64>| {
        let middle = values.len() / 2;
        *values.select_nth_unstable_by(middle, f64::total_cmp).1
    };
    let centre = median(values.to_vec());
    let reach = CLIP * median(values.iter().map(|value| (value - centre).abs()).collect());
    if reach > 0.0 { [centre - reach, centre + reach] } else { [f64::MIN, f64::MAX] }
}

/// Moves in the set {ĝ − m ≤ threshold}.
struct Walk<'i> {
    interpolant: &'i Interpolant,
    margin: f64,
    threshold: f64,
    step: f64,
    draws: Stream,
}

impl Walk<'_> {
    fn mix(&mut self, moves: usize, level: &mut LastLevel) {
        let Self { interpolant, margin, threshold, step, draws } = self;
        let Ok(()) = level
            .mix(moves, &|value| value <= *threshold, step, draws, &mut |points| shifted(interpolant, *margin, points));
    }
}

fn shifted(interpolant: &Interpolant, margin: f64, points: &[Vec<f64>]) -> Result<Vec<f64>, Infallible> {
    Ok(interpolant.values(points).into_iter().map(|value| value - margin).collect())
}

/// Returns the Euclidean norm, which is positive.
fn norm(z: &[f64]) -> f64 {
    z.iter().map(|z| z * z).sum::<f64>().sqrt().max(f64::MIN_POSITIVE)
}

fn nearest(points: &[Vec<f64>], z: &[f64]) -> f64 {
    let distance = |x: &Vec<f64>| x.iter().zip(z).map(|(x, z)| (x - z) * (x - z)).sum::<f64>();
    points.iter().map(distance).fold(f64::INFINITY, f64::min).sqrt()
}
