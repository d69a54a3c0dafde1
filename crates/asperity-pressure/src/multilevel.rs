//! One distribution from many cheap samples and few exact ones.
//!
//! A quantity q is known on the fine samples; cheaper models of it, coarser and coarser, on these and on more and more others.
//! With h_l(t) the probability that q ≤ t given what model l and those below it say, fitted to samples that it is not applied to,
//!
//! F(t) = mean_fine [1(q ≤ t) − h_{L}(t)] + mean_L [h_L(t) − h_{L−1}(t)] + … + mean_1 [h_1(t) − h_0(t)] + E h_0(t),
//!
//! where mean_l goes over all samples on which model l is known. Model 0 is a few variables whose distribution is exactly standard
//! normal, so that its expectation needs no samples of the others. Every fold of the samples is judged by fits to the other
//! folds; given these each bracket has the expectation it should have, so F is unbiased whatever the models are worth, and the better
//! they are the smaller its variance, which the spread of the samples' contributions tells.
//!
//! # References
//! M. B. Giles, *Acta Numerica* **24** (2015) 259, <https://doi.org/10.1017/S096249291500001X> (multilevel Monte Carlo).
//! B. Peherstorfer, K. Willcox and M. Gunzburger, *SIAM J. Sci. Comput.* **38** (2016) A3163,
//! <https://doi.org/10.1137/15M1046472> (many models, nested samples).
//! Chernozhukov et al., *Econometrics J.* **21** (2018) C1, <https://doi.org/10.1111/ectj.12097> (cross-fitting).

use crate::band::{Moments, Total};
use crate::predictor::Predictor;
use crate::{Band, MethodError};
use asperity_chaos::{Design, DiscreteDistribution, SamplingMethod};

/// Parts into which the samples are split for cross-fitting.
const FOLDS: usize = 5;
/// Minimum number of fine samples.
pub(super) const LEAST_SAMPLES: usize = 2 * FOLDS;
/// Values at which the distribution function is estimated,
const THRESHOLDS: usize = 1000;
/// and those at which its covariance is.
const NODES: usize = 64;
/// Minimum number of samples on either side of a value whose share has normal errors.
pub(super) const RARE: usize = 15;
/// Independent randomisations of the points on which the expectation of model 0 is computed, and points of each.
const REPLICATES: usize = 10;
const POINTS: usize = 2048;

/// A quantity on the samples of all models, the fine ones first.
#[derive(Debug, Clone)]
pub(super) struct LevelSamples {
    /// Standard normal variables of every sample; may be empty.
    pub(super) normal: Vec<Vec<f64>>,
    /// What the models say, the coarsest first, each of the leading samples; the last is the quantity itself.
    pub(super) models: Vec<Vec<f64>>,
    /// What else each but the last says of the same samples.
    pub(super) beside: Vec<Vec<Vec<f64>>>,
}

/// A distribution and how well it is known.
#[derive(Debug, Clone)]
pub(super) struct MultilevelEstimate {
    pub(super) distribution: DiscreteDistribution,
    pub(super) mean: f64,
    pub(super) mean_se: f64,
    pub(super) band: Band,
    /// Fine samples above the least value, and all.
    pub(super) above: [usize; 2],
    /// Of the finest model's polynomial.
    pub(super) coefficients: Option<usize>,
    pub(super) leave_one_out_error: Option<f64>,
}

/// How the models are used.
#[derive(Debug, Clone, Copy)]
pub(super) struct Settings {
    pub(super) seed: u64,
    /// Largest degree of the polynomials.
    pub(super) degree: usize,
    /// Whether models predict by a polynomial, or are taken at their word.
    pub(super) fitted: bool,
    /// The value is the quantity within these bounds.
    pub(super) least: f64,
    pub(super) largest: f64,
}

impl LevelSamples {
    /// Returns the samples on which model `l` is known.
    fn count(&self, l: usize) -> usize {
        self.models[l].len()
    }

    /// What model `l` and the next coarser one say of a sample, and its normal variables.
    fn row(&self, l: usize, sample: usize) -> Vec<f64> {
        let mut row = vec![self.models[l][sample]];
        row.extend(&self.beside[l][sample]);
        row.extend(l.checked_sub(1).map(|coarser| self.models[coarser][sample]));
        row.extend(self.normal.get(sample).into_iter().flatten());
        row
    }
}

/// The fits to all samples but those of one fold.
struct Fold {
    /// Of every model but the quantity itself, the coarsest first.
    predictors: Vec<Predictor>,
    /// By the normal variables alone, if there are any.
    normal: Option<Predictor>,
}

impl Fold {
    fn fit(nested: &LevelSamples, fold: usize, settings: &Settings) -> Result<(Self, Vec<f64>), MethodError> {
        let last = nested.models.len() - 1;
        // The quantity where it is known, elsewhere drawn from its conditional distribution.
        let mut values = nested.models[last].clone();
        let mut predictors = Vec::with_capacity(last);
        let outside = |count: usize| (0..count).filter(move |i| i % FOLDS != fold);
        for l in (0..last).rev() {
            let rows: Vec<Vec<f64>> = outside(values.len()).map(|i| nested.row(l, i)).collect();
            let known: Vec<f64> = outside(values.len()).map(|i| values[i]).collect();
            let predictor =
                if settings.fitted { Predictor::fit(&rows, &known, settings.degree)? } else { Predictor::Identity };
            for i in values.len()..nested.count(l) {
                let prediction = predictor.predict(&nested.row(l, i));
                values.push(prediction + pick(predictor.errors(prediction), golden(i)));
            }
            predictors.push(predictor);
        }
        predictors.reverse();
        let has_normal = settings.fitted && nested.normal.first().is_some_and(|row| !row.is_empty());
        let normal = if has_normal {
            let rows: Vec<Vec<f64>> = outside(values.len()).map(|i| nested.normal[i].clone()).collect();
            let known: Vec<f64> = outside(values.len()).map(|i| values[i]).collect();
            Some(Predictor::fit(&rows, &known, settings.degree)?)
        } else {
            None
        };
        Ok((Self { predictors, normal }, values))
    }
}

impl Fold {
    /// Calls `add` with number, prediction, errors and sign of both terms of every bracket that `sample` is in.
    fn brackets(&self, nested: &LevelSamples, sample: usize, mut add: impl FnMut(usize, f64, &[f64], f64)) {
        let last = nested.models.len() - 1;
        // What the sample is taken to be by the model below.
        let mut below = self.normal.as_ref().map(|normal| (normal.predict(&nested.normal[sample]), normal));
        for l in (0..=last).take_while(|l| sample < nested.count(*l)) {
            if let Some((prediction, predictor)) = below {
                add(l, prediction, predictor.errors(prediction), -1.0);
            }
            let (prediction, predictor) = match self.predictors.get(l) {
                Some(predictor) => (predictor.predict(&nested.row(l, sample)), predictor),
                None => (nested.models[last][sample], &Predictor::Identity),
            };
            add(l, prediction, predictor.errors(prediction), 1.0);
            below = Some((prediction, predictor));
        }
    }
}

/// How many of the leading `count` samples belong to a fold.
fn fold_size(fold: usize, count: usize) -> usize {
    (count + FOLDS - 1 - fold) / FOLDS
}

/// Returns a point between 0 and 1 for each index, evenly spread.
fn golden(index: usize) -> f64 {
    ((index as f64 + 0.5) * 0.618_033_988_749_894_9).fract()
}

/// Returns the error at a share 0 to 1 of increasing ones.
fn pick(errors: &[f64], fraction: f64) -> f64 {
    errors[((fraction * errors.len() as f64) as usize).min(errors.len() - 1)]
}

/// Adds up distribution functions at increasing thresholds.
struct Histogram<'a> {
    thresholds: &'a [f64],
    steps: Vec<f64>,
}

impl Histogram<'_> {
    /// Adds the distribution of `prediction` and any of `errors`.
    fn add(&mut self, prediction: f64, errors: &[f64], weight: f64) {
        let weight = weight / errors.len() as f64;
        for error in errors {
            let place = self.thresholds.partition_point(|t| *t < prediction + error);
            if let Some(step) = self.steps.get_mut(place) {
                *step += weight;
            }
        }
    }

    fn sums(&self) -> Vec<f64> {
        let mut sum = 0.0;
        let add = |step: &f64| {
            sum += step;
            sum
        };
        self.steps.iter().map(add).collect()
    }
}

/// Contributions of one sample at the nodes, and to the mean.
struct Contribution<'a> {
    nodes: &'a [f64],
    settings: &'a Settings,
    values: Vec<f64>,
}

impl<'a> Contribution<'a> {
    fn new(nodes: &'a [f64], settings: &'a Settings) -> Self {
        Self { nodes, settings, values: vec![0.0; nodes.len() + 1] }
    }

    fn add(&mut self, prediction: f64, errors: &[f64], weight: f64) {
        let weight = weight / errors.len() as f64;
        let mut below = 0;
        for (node, value) in self.nodes.iter().zip(&mut self.values) {
            while below < errors.len() && prediction + errors[below] <= *node {
                below += 1;
            }
            *value += weight * below as f64;
        }
        let bounded = |error: &f64| (prediction + error).clamp(self.settings.least, self.settings.largest);
        if let Some(mean) = self.values.last_mut() {
            *mean += weight * errors.iter().map(bounded).sum::<f64>();
        }
    }
}

/// Estimates the distribution of the value.
///
/// # Errors
/// There are fewer fine samples than folds, or a fit fails.
pub(super) fn estimate(nested: &LevelSamples, settings: &Settings) -> Result<MultilevelEstimate, MethodError> {
    let last = nested.models.len() - 1;
    let fine = nested.count(last);
    if fine < LEAST_SAMPLES {
        return Err(MethodError::TooFewSamples { samples: fine, wanted: LEAST_SAMPLES });
    }
    let folds = (0..FOLDS).map(|fold| Fold::fit(nested, fold, settings)).collect::<Result<Vec<_>, _>>()?;
    let drawn = folds.first().map_or(&[][..], |(_, values)| values.as_slice());
    let thresholds = thresholds(&nested.models[last], drawn, settings);
    let nodes: Vec<f64> = nodes(&thresholds, drawn, &nested.models[last], settings);
    let mut total = Histogram { thresholds: &thresholds, steps: vec![0.0; thresholds.len()] };
    let mut errors = Total::new(nodes.len() + 1);
    let mut classes: Vec<Moments> = (0..=last).map(|_| Moments::new(nodes.len() + 1)).collect();
    for (fold, (fits, _)) in folds.iter().enumerate() {
        let fraction = fold_size(fold, fine) as f64 / fine as f64;
        for sample in (0..nested.count(0)).filter(|i| i % FOLDS == fold) {
            let mut own = Contribution::new(&nodes, settings);
            let mut class = 0;
            fits.brackets(nested, sample, |l, prediction, errors, sign| {
                class = l;
                let weight = sign * fraction / fold_size(fold, nested.count(l)) as f64;
                total.add(prediction, errors, weight);
                own.add(prediction, errors, weight);
            });
            classes[class].add(&own.values);
        }
    }
    let normals: Vec<(&Predictor, f64)> = folds
        .iter()
        .enumerate()
        .filter_map(|(fold, (fits, _))| Some((fits.normal.as_ref()?, fold_size(fold, fine) as f64 / fine as f64)))
        .collect();
    if !normals.is_empty() {
        expect_normal(&normals, nested.normal[0].len(), &nodes, settings, &mut total, &mut errors)?;
    }
    classes.iter().for_each(|class| errors.add_sum(class));
    let predictor = folds.first().and_then(|(fold, _)| fold.predictors.last().or(fold.normal.as_ref()));
    Ok(MultilevelEstimate {
        distribution: monotone_distribution(&thresholds, total.sums())?,
        mean: errors.value(nodes.len()),
        mean_se: errors.standard_error(nodes.len(), None),
        band: errors.band(&nodes, None, settings.seed),
        above: [nested.models[last].iter().filter(|q| **q > settings.least).count(), fine],
        coefficients: predictor.and_then(Predictor::coefficients),
        leave_one_out_error: predictor.and_then(Predictor::relative_error),
    })
}

/// Returns the variance of what a sample adds to each bracket, summed over the nodes: of the fine model first, of the coarsest last. All models
/// are known on the same samples.
pub(super) fn bracket_variances(nested: &LevelSamples, settings: &Settings) -> Result<Vec<f64>, MethodError> {
    let last = nested.models.len() - 1;
    let folds = (0..FOLDS).map(|fold| Fold::fit(nested, fold, settings)).collect::<Result<Vec<_>, _>>()?;
    let fine = &nested.models[last];
    let nodes = nodes(&thresholds(fine, fine, settings), fine, fine, settings);
    let mut moments: Vec<Moments> = (0..=last).map(|_| Moments::new(nodes.len() + 1)).collect();
    for sample in 0..nested.count(last) {
        let mut own: Vec<Contribution<'_>> = (0..=last).map(|_| Contribution::new(&nodes, settings)).collect();
        let (fits, _) = &folds[sample % FOLDS];
        fits.brackets(nested, sample, |l, prediction, errors, sign| own[l].add(prediction, errors, sign));
        moments.iter_mut().zip(&own).for_each(|(moments, own)| moments.add(&own.values));
    }
    Ok(moments.iter().rev().map(|moments| moments.variances().take(nodes.len()).sum()).collect())
}

/// Adds the expectation of predictions by `variables` standard normal variables, each with its weight, over scrambled Sobol' points
/// that draw an error each; independent randomisations tell its own error.
fn expect_normal(
    normals: &[(&Predictor, f64)],
    variables: usize,
    nodes: &[f64],
    settings: &Settings,
    total: &mut Histogram<'_>,
    errors: &mut Total,
) -> Result<(), MethodError> {
    let design = Design::new(SamplingMethod::Sobol, settings.seed, "pressure/normal", POINTS, variables + 1)?;
    let mut spread = Moments::new(nodes.len() + 1);
    let mut point = vec![0.0; variables + 1];
    for replicate in 0..REPLICATES {
        let design = design.replicate(replicate)?;
        let mut own = Contribution::new(nodes, settings);
        for index in 0..POINTS {
            design.fill_unit(index, &mut point);
            for u in &mut point[..variables] {
                *u = asperity_base::distribution::standard_normal_quantile(*u);
            }
            for (normal, weight) in normals {
                let prediction = normal.predict(&point[..variables]);
                let error = [pick(normal.errors(prediction), point[variables])];
                total.add(prediction, &error, weight / (POINTS * REPLICATES) as f64);
                own.add(prediction, &error, weight / POINTS as f64);
            }
        }
        spread.add(&own.values);
    }
    errors.add_mean(&spread);
    Ok(())
}

/// Returns the increasing values at which F is estimated, from the least one to beyond the largest drawn.
fn thresholds(fine: &[f64], drawn: &[f64], settings: &Settings) -> Vec<f64> {
    let within = |q: &f64| *q > settings.least && *q < settings.largest;
    let quantiles = |values: &[f64], count: usize| {
        let mut values: Vec<f64> = values.iter().copied().filter(within).collect();
        values.sort_by(f64::total_cmp);
        let last = values.len().saturating_sub(1);
        let count = count.min(values.len());
        (0..count).map(|k| values[k * last / count.saturating_sub(1).max(1)]).collect::<Vec<f64>>()
    };
    let mut thresholds = quantiles(fine, THRESHOLDS / 2);
    thresholds.extend(quantiles(drawn, THRESHOLDS / 2));
    if settings.least.is_finite() {
        thresholds.push(settings.least);
    }
    let reaches = |q: &f64| *q >= settings.largest;
    if fine.iter().chain(drawn).any(reaches) || thresholds.is_empty() {
        thresholds.push(settings.largest.min(f64::MAX));
    }
    thresholds.sort_by(f64::total_cmp);
    thresholds.dedup();
    thresholds
}

/// Some of the thresholds, as many of the drawn values between any two: the least value, and those on either side of which there are
/// enough fine ones for normal errors; not the largest value.
fn nodes(thresholds: &[f64], drawn: &[f64], fine: &[f64], settings: &Settings) -> Vec<f64> {
    let mut counts = vec![0_usize; thresholds.len()];
    for q in drawn {
        let place = thresholds.partition_point(|t| t < q).min(thresholds.len() - 1);
        counts[place] += 1;
    }
    let first = counts[0];
    let rest = (drawn.len() - first).max(1);
    let mut nodes = vec![thresholds[0]];
    let mut count = 0;
    for (t, own) in thresholds.iter().zip(&counts).skip(1) {
        count += own;
        if count * (NODES - 1) >= nodes.len() * rest {
            nodes.push(*t);
        }
    }
    let common = |t: &f64| {
        let below = fine.iter().filter(|q| *q <= t).count();
        below.min(fine.len() - below) >= RARE
    };
    // At the largest value F is one.
    nodes.retain(|t| *t == settings.least || (*t < settings.largest && common(t)));
    nodes
}

/// Returns the distribution whose distribution function is nearest to the given values (isotonic regression by pooling adjacent
/// violators, which never increases the largest error), limited to [0, 1].
fn monotone_distribution(thresholds: &[f64], distribution: Vec<f64>) -> Result<DiscreteDistribution, MethodError> {
    let mut pools: Vec<(f64, usize)> = Vec::with_capacity(distribution.len());
    for value in distribution {
        let mut pool = (value.clamp(0.0, 1.0), 1);
        while let Some(&(mean, count)) = pools.last()
            && mean >= pool.0
        {
            pools.pop();
            let total = count + pool.1;
            pool = ((mean * count as f64 + pool.0 * pool.1 as f64) / total as f64, total);
        }
        pools.push(pool);
    }
    let mut before = 0.0;
    let levels = pools.iter().flat_map(|&(level, count)| std::iter::repeat_n(level, count));
    let mut atoms: Vec<(f64, f64)> = thresholds
        .iter()
        .zip(levels)
        .map(|(&t, level)| {
            let step = (t, level - before);
            before = level;
            step
        })
        .collect();
    if let Some((_, weight)) = atoms.last_mut() {
        *weight += 1.0 - before;
    }
    Ok(DiscreteDistribution::weighted(atoms)?)
}

#[cfg(test)]
mod tests;
