//! Multilevel estimator of a distribution function.
//!
//! Few samples are solved on the fine grid; many more are solved on coarser grids, whose results correlate with the
//! fine ones. The estimate is a telescoping sum over the levels from coarse to fine:
//!
//! F(t) = E h_0(t) + mean_1 [h_1(t) − h_0(t)] + … + mean_L [h_L(t) − h_{L−1}(t)] + mean_fine [1(q ≤ t) − h_L(t)],
//!
//! where h_l(t) predicts P(q ≤ t) from the results of levels 0 … l, and mean_l is over all samples of level l. Level 0
//! consists of a few exactly standard normal variables, so its expectation requires no contact solution. Each predictor
//! is fitted by cross-fitting: it is never applied to the samples to which it was fitted. The estimate is therefore
//! unbiased for any predictor, and a better predictor only reduces the variance, which is estimated from the
//! contributions of the samples.
//!
//! # References
//! M. B. Giles, *Acta Numerica* **24** (2015) 259, <https://doi.org/10.1017/S096249291500001X> (multilevel Monte Carlo).
//! B. Peherstorfer, K. Willcox and M. Gunzburger, *SIAM J. Sci. Comput.* **38** (2016) A3163,
//! <https://doi.org/10.1137/15M1046472> (many models, levels samples).
//! Chernozhukov et al., *Econometrics J.* **21** (2018) C1, <https://doi.org/10.1111/ectj.12097> (cross-fitting).

use crate::band::{Moments, RARE, Total};
use crate::predictor::Predictor;
use crate::{Band, MethodError};
use asperity_base::blocks;
use asperity_base::numeric::isotonic;
use asperity_chaos::{Design, DiscreteDistribution, SamplingMethod};

/// Number of parts into which the samples are split for cross-fitting.
const FOLDS: usize = 5;
/// Minimum number of fine samples.
pub(super) const LEAST_SAMPLES: usize = 2 * FOLDS;
/// Maximum number of values at which the distribution function is estimated.
const THRESHOLDS: usize = 1000;
/// Maximum number of values at which its covariance is estimated.
const NODES: usize = 64;
/// Number of independent randomisations of the points for the expectation of level 0, and number of points of each.
const REPLICATES: usize = 10;
const POINTS: usize = 2048;

/// Samples of one quantity on all levels.
#[derive(Debug, Clone)]
pub(super) struct LevelSamples {
    /// Standard normal variables ξ of each sample; empty if none are used.
    pub(super) xi: Vec<Vec<f64>>,
    /// Results per level, coarsest first. Each level covers the leading samples; the last level is the quantity itself.
    pub(super) values: Vec<Vec<f64>>,
    /// Further results of each coarse level for the same samples, used as predictors.
    pub(super) covariates: Vec<Vec<Vec<f64>>>,
}

/// Estimated distribution with its errors.
#[derive(Debug, Clone)]
pub(super) struct MultilevelEstimate {
    pub(super) distribution: DiscreteDistribution,
    pub(super) mean: f64,
    pub(super) mean_se: f64,
    pub(super) band: Band,
    /// Number of fine samples above the lower bound, and of all fine samples.
    pub(super) above: [usize; 2],
    /// Number of coefficients of the finest model's polynomial.
    pub(super) coefficients: Option<usize>,
    pub(super) leave_one_out_error: Option<f64>,
}

/// Settings of the estimator.
#[derive(Debug, Clone, Copy)]
pub(super) struct Settings {
    pub(super) seed: u64,
    /// Largest degree of the polynomials.
    pub(super) degree: usize,
    /// Whether levels predict by a polynomial; otherwise their results replace those of the next finer level.
    pub(super) fitted: bool,
    /// Lower and upper bound to which the quantity is clipped.
    pub(super) least: f64,
    pub(super) largest: f64,
}

impl LevelSamples {
    /// Returns the number of samples on level `l`.
    fn count(&self, l: usize) -> usize {
        self.values[l].len()
    }

    /// Returns the predictors of a sample: the results of level `l` and the next coarser one, and the normal variables.
    fn row(&self, l: usize, sample: usize) -> Vec<f64> {
        let mut row = vec![self.values[l][sample]];
        row.extend(&self.covariates[l][sample]);
        row.extend(l.checked_sub(1).map(|coarser| self.values[coarser][sample]));
        row.extend(self.xi.get(sample).into_iter().flatten());
        row
    }
}

/// Predictors fitted to all samples outside one fold.
struct Fold {
    /// Predictors of every level except the quantity itself, coarsest first.
    predictors: Vec<Predictor>,
    /// Predictor from the normal variables alone, if there are any.
    normal: Option<Predictor>,
}

impl Fold {
    /// Fits the predictors of all folds; each with the quantity of all samples, drawn where it was not solved.
    fn fit_all(levels: &LevelSamples, settings: &Settings) -> Result<Vec<(Self, Vec<f64>)>, MethodError> {
        let folds: Vec<_> = blocks::map(0..FOLDS, |fold| Self::fit(levels, fold, settings));
        folds.into_iter().collect()
    }

    fn fit(levels: &LevelSamples, fold: usize, settings: &Settings) -> Result<(Self, Vec<f64>), MethodError> {
        let last = levels.values.len() - 1;
        // The quantity itself where it was solved, elsewhere a draw from its conditional distribution.
        let mut values = levels.values[last].clone();
        let mut predictors = Vec::with_capacity(last);
        let outside = |count: usize| (0..count).filter(move |i| i % FOLDS != fold);
        for l in (0..last).rev() {
            let rows: Vec<Vec<f64>> = outside(values.len()).map(|i| levels.row(l, i)).collect();
            let known: Vec<f64> = outside(values.len()).map(|i| values[i]).collect();
            let predictor =
                if settings.fitted { Predictor::fit(&rows, &known, settings.degree)? } else { Predictor::Identity };
            for i in values.len()..levels.count(l) {
                let prediction = predictor.predict(&levels.row(l, i));
                values.push(prediction + pick(predictor.errors(prediction), golden(i)));
            }
            predictors.push(predictor);
        }
        predictors.reverse();
        let has_normal = settings.fitted && levels.xi.first().is_some_and(|row| !row.is_empty());
        let normal = if has_normal {
            let rows: Vec<Vec<f64>> = outside(values.len()).map(|i| levels.xi[i].clone()).collect();
            let known: Vec<f64> = outside(values.len()).map(|i| values[i]).collect();
            Some(Predictor::fit(&rows, &known, settings.degree)?)
        } else {
            None
        };
        Ok((Self { predictors, normal }, values))
    }
}

impl Fold {
    /// Calls `add` with level, prediction, errors and sign for both terms of each level that contains `sample`.
    fn brackets(&self, levels: &LevelSamples, sample: usize, mut add: impl FnMut(usize, f64, &[f64], f64)) {
        let last = levels.values.len() - 1;
        // Prediction of the sample by the next coarser level.
        let mut below = self.normal.as_ref().map(|normal| (normal.predict(&levels.xi[sample]), normal));
        for l in (0..=last).take_while(|l| sample < levels.count(*l)) {
            if let Some((prediction, predictor)) = below {
                add(l, prediction, predictor.errors(prediction), -1.0);
            }
            let (prediction, predictor) = match self.predictors.get(l) {
                Some(predictor) => (predictor.predict(&levels.row(l, sample)), predictor),
                None => (levels.values[last][sample], &Predictor::Identity),
            };
            add(l, prediction, predictor.errors(prediction), 1.0);
            below = Some((prediction, predictor));
        }
    }
}

/// Returns how many of the leading `count` samples belong to a fold.
fn fold_size(fold: usize, count: usize) -> usize {
    (count + FOLDS - 1 - fold) / FOLDS
}

/// Returns a quasi-random point between 0 and 1 for each index.
fn golden(index: usize) -> f64 {
    ((index as f64 + 0.5) * 0.618_033_988_749_894_9).fract()
}

/// Returns the quantile of increasing errors at `fraction` between 0 and 1.
fn pick(errors: &[f64], fraction: f64) -> f64 {
    errors[((fraction * errors.len() as f64) as usize).min(errors.len() - 1)]
}

/// Sum of distribution functions at increasing thresholds.
struct Histogram<'a> {
    thresholds: &'a [f64],
    steps: Vec<f64>,
}

impl Histogram<'_> {
    /// Adds the distribution of `prediction` plus a random error.
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

/// Contributions of one sample at the nodes and to the mean.
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

/// Estimates the distribution of the clipped quantity.
///
/// # Errors
/// There are fewer fine samples than folds, or a fit fails.
pub(super) fn estimate(levels: &LevelSamples, settings: &Settings) -> Result<MultilevelEstimate, MethodError> {
    let last = levels.values.len() - 1;
    let fine = levels.count(last);
    if fine < LEAST_SAMPLES {
        return Err(MethodError::TooFewSamples { samples: fine, wanted: LEAST_SAMPLES });
    }
    let folds = Fold::fit_all(levels, settings)?;
    let drawn = folds.first().map_or(&[][..], |(_, values)| values.as_slice());
    let thresholds = thresholds(&levels.values[last], drawn, settings);
    let nodes: Vec<f64> = nodes(&thresholds, drawn, &levels.values[last], settings);
    let mut total = Histogram { thresholds: &thresholds, steps: vec![0.0; thresholds.len()] };
    let mut errors = Total::new(nodes.len() + 1);
    let mut classes: Vec<Moments> = (0..=last).map(|_| Moments::new(nodes.len() + 1)).collect();
    for (fold, (fits, _)) in folds.iter().enumerate() {
        let fraction = fold_size(fold, fine) as f64 / fine as f64;
        for sample in (0..levels.count(0)).filter(|i| i % FOLDS == fold) {
            let mut own = Contribution::new(&nodes, settings);
            let mut class = 0;
            fits.brackets(levels, sample, |l, prediction, errors, sign| {
                class = l;
                let weight = sign * fraction / fold_size(fold, levels.count(l)) as f64;
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
        expect_normal(&normals, levels.xi[0].len(), &nodes, settings, &mut total, &mut errors)?;
    }
    classes.iter().for_each(|class| errors.add_sum(class));
    let predictor = folds.first().and_then(|(fold, _)| fold.predictors.last().or(fold.normal.as_ref()));
    Ok(MultilevelEstimate {
        distribution: monotone_distribution(&thresholds, total.sums())?,
        mean: errors.value(nodes.len()),
        mean_se: errors.standard_error(nodes.len(), None),
        band: errors.band(&nodes, None, settings.seed),
        above: [levels.values[last].iter().filter(|q| **q > settings.least).count(), fine],
        coefficients: predictor.and_then(Predictor::coefficients),
        leave_one_out_error: predictor.and_then(Predictor::relative_error),
    })
}

/// Returns the variance per sample of each term of the sum, added over the nodes: fine level first, coarsest last. All
/// levels must cover the same samples.
pub(super) fn bracket_variances(levels: &LevelSamples, settings: &Settings) -> Result<Vec<f64>, MethodError> {
    let last = levels.values.len() - 1;
    let folds = Fold::fit_all(levels, settings)?;
    let fine = &levels.values[last];
    let nodes = nodes(&thresholds(fine, fine, settings), fine, fine, settings);
    let mut moments: Vec<Moments> = (0..=last).map(|_| Moments::new(nodes.len() + 1)).collect();
    for sample in 0..levels.count(last) {
        let mut own: Vec<Contribution<'_>> = (0..=last).map(|_| Contribution::new(&nodes, settings)).collect();
        let (fits, _) = &folds[sample % FOLDS];
        fits.brackets(levels, sample, |l, prediction, errors, sign| own[l].add(prediction, errors, sign));
        moments.iter_mut().zip(&own).for_each(|(moments, own)| moments.add(&own.values));
    }
    Ok(moments.iter().rev().map(|moments| moments.variances().take(nodes.len()).sum()).collect())
}

/// Adds the expectation of the predictions from `variables` standard normal variables, each with its weight.
///
/// The expectation is over scrambled Sobol' points with one random error each; independent randomisations give its own
/// error.
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

/// Returns increasing values at which F is estimated, from the lower bound to the largest draw.
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

/// Selects thresholds with equal numbers of draws between them: the lower bound, and thresholds with enough fine
/// samples on both sides for normal errors; not the upper bound.
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
    // F is 1 at the upper bound.
    nodes.retain(|t| *t == settings.least || (*t < settings.largest && common(t)));
    nodes
}

/// Returns the distribution whose distribution function is nearest to the given values, limited to [0, 1].
///
/// It uses isotonic regression, which never increases the largest error.
fn monotone_distribution(thresholds: &[f64], distribution: Vec<f64>) -> Result<DiscreteDistribution, MethodError> {
    let levels = isotonic(distribution.into_iter().map(|value| [value.clamp(0.0, 1.0), 1.0]));
    let mut before = 0.0;
    let mut points: Vec<(f64, f64)> = thresholds
        .iter()
        .zip(levels)
        .map(|(&t, level)| {
            let step = (t, level - before);
            before = level;
            step
        })
        .collect();
    if let Some((_, weight)) = points.last_mut() {
        *weight += 1.0 - before;
    }
    Ok(DiscreteDistribution::weighted(points)?)
}

#[cfg(test)]
mod tests;
