//! A Monte Carlo law corrected by a surrogate: a chaos expansion as control variate.
//!
//! Out of contact the pressure says nothing about how far from contact the cell is; the gap does. At the hardness H it says
//! nothing about how far the cell yields; the plastic displacement does. The *latent* pressure q = p + κ(plastic
//! displacement − gap) continues the pressure below zero and above H, so that P(p ≤ t) = P(q ≤ t) for 0 ≤ t < H, and it can
//! be regressed on all samples without truncation. A polynomial s(v) of local variables v predicts it; with the law G of its leave-one-out
//! errors around similar predictions, h_t(v) = G(t − s(v)) predicts the probability of q ≤ t. The law is then
//!
//! F(t) = mean_fine 1(q ≤ t) + β [mean_fresh h_t − mean_fine h_t],
//!
//! where `fine` are the contact solutions and `fresh` many maps that need none. Each fold of the fine
//! samples is predicted by a fit to the other folds, so whatever the surrogate is worth the estimate has no bias beyond the
//! order 1/n of a β, a κ and scales that come from the same samples; the better the surrogate, the smaller its variance.
//!
//! # References
//! Glynn & Szechtman, in *Monte Carlo and Quasi-Monte Carlo Methods 2000* (2002) 27,
//! <https://doi.org/10.1007/978-3-642-56046-0_3> (control variates).
//! Chernozhukov et al., *Econometrics J.* **21** (2018) C1, <https://doi.org/10.1111/ectj.12097> (cross-fitting).

use crate::chaos::{Basis, Expansion, RegressionError, StepLaw, number_of_terms};
use crate::pressure::local::Scaling;
use crate::pressure::{Estimate, MethodError, Observation};

/// Parts into which the fine samples are split for cross-fitting.
const FOLDS: usize = 5;
/// Samples in a group of neighbouring predictions that share one law of errors.
const GROUP: usize = 50;
/// Quantiles of the surrogate's law at which F is evaluated besides the fine pressures.
const MODEL_QUANTILES: usize = 1000;

/// Pressures, gaps and plastic displacements as one latent variable p + κ(plastic displacement − gap), κ the ratio of the
/// spreads of the pressures in contact and of the gaps out of it.
pub(super) fn latent(observations: &[Observation]) -> Vec<f64> {
    let spread = |in_contact: bool, quantity: fn(&Observation) -> f64| {
        let chosen = observations.iter().filter(|o| (o.pressure_pa > 0.0) == in_contact).map(|o| (quantity(o), 1.0));
        StepLaw::weighted(chosen).map_or(0.0, |law| law.std())
    };
    let (pressure_pa, gap_m) = (spread(true, |o| o.pressure_pa), spread(false, |o| o.gap_m));
    let kappa = if pressure_pa > 0.0 && gap_m > 0.0 { pressure_pa / gap_m } else { 1.0 };
    observations.iter().map(|o| o.pressure_pa + kappa * (o.plastic_displacement_m - o.gap_m)).collect()
}

/// The surrogate of one fold: predictions of the fine samples held out, of the fresh ones, and the laws of the errors.
struct FoldModel {
    held_out: Vec<(usize, f64)>,
    errors: ErrorLaws,
    /// Predictions of the fresh samples, increasing.
    fresh: Vec<f64>,
}

/// The law of the leave-one-out errors around similar predictions: their spread differs in and out of contact.
struct ErrorLaws {
    /// Least prediction of each group after the first.
    bounds: Vec<f64>,
    laws: Vec<StepLaw>,
}

impl ErrorLaws {
    /// Groups of about [`GROUP`] samples with neighbouring predictions, from (prediction, error) pairs.
    fn new(mut pairs: Vec<(f64, f64)>) -> Result<Self, MethodError> {
        pairs.sort_by(|a, b| a.0.total_cmp(&b.0));
        let groups = (pairs.len() / GROUP).max(1);
        let start = |group: usize| group * pairs.len() / groups;
        let laws = (0..groups)
            .map(|group| {
                let errors: Vec<f64> = pairs[start(group)..start(group + 1)].iter().map(|pair| pair.1).collect();
                StepLaw::empirical(&errors)
            })
            .collect::<Result<_, _>>()?;
        Ok(Self { bounds: (1..groups).map(|group| pairs[start(group)].0).collect(), laws })
    }

    fn law(&self, prediction: f64) -> &StepLaw {
        &self.laws[self.bounds.partition_point(|bound| *bound <= prediction)]
    }

    /// h_t = G(t − s).
    fn cdf(&self, t: f64, prediction: f64) -> f64 {
        self.law(prediction).cdf(t - prediction)
    }
}

impl FoldModel {
    /// mean_fresh h_t: in each group one pass through the sorted predictions and errors.
    fn fresh_mean(&self, t: f64) -> f64 {
        let mut sum = 0.0;
        let mut from = 0;
        for (group, law) in self.errors.laws.iter().enumerate() {
            let to = match self.errors.bounds.get(group) {
                Some(bound) => self.fresh.partition_point(|s| s < bound),
                None => self.fresh.len(),
            };
            let (values, cumulative) = (law.values(), law.cumulative());
            let mut below = values.len();
            for s in &self.fresh[from..to] {
                while below > 0 && values[below - 1] > t - s {
                    below -= 1;
                }
                if below == 0 {
                    break;
                }
                sum += cumulative[below - 1];
            }
            from = to;
        }
        sum / self.fresh.len() as f64
    }
}

/// The controlled law of the pressure from `latent` values at the local variables `fine`, and `fresh` local variables. No
/// pressure exceeds `hardness_pa`.
pub(super) fn estimate(
    fine: &[Vec<f64>],
    latent: &[f64],
    fresh: &[Vec<f64>],
    degree: usize,
    hardness_pa: Option<f64>,
) -> Result<Estimate, MethodError> {
    let scaling = Scaling::of(fine);
    let fine: Vec<Vec<f64>> = fine.iter().map(|row| scaling.apply(row)).collect();
    let fresh: Vec<Vec<f64>> = fresh.iter().map(|row| scaling.apply(row)).collect();
    let whole = Surrogate::fit(&scaling, &fine, latent, degree)?;
    let folds: Vec<FoldModel> =
        (0..FOLDS).map(|fold| fold_model(fold, &scaling, &fine, latent, &fresh, degree)).collect::<Result<_, _>>()?;
    let thresholds = thresholds(latent, &folds, hardness_pa.unwrap_or(f64::INFINITY));
    let n = latent.len();
    let mut predicted = vec![0.0; n];
    // Per threshold: share of fine samples below, mean prediction of fine and of fresh samples, residual spread.
    let mut rows = Vec::with_capacity(thresholds.len());
    let (mut covariance, mut variance) = (0.0, 0.0);
    for &t in &thresholds {
        for fold in &folds {
            for &(i, s) in &fold.held_out {
                predicted[i] = fold.errors.cdf(t, s);
            }
        }
        let fresh_mean =
            folds.iter().map(|fold| fold.fresh_mean(t) * fold.held_out.len() as f64).sum::<f64>() / n as f64;
        let below = latent.iter().filter(|q| **q <= t).count() as f64 / n as f64;
        let fine_mean = predicted.iter().sum::<f64>() / n as f64;
        for (q, h) in latent.iter().zip(&predicted) {
            covariance += (f64::from(u8::from(*q <= t)) - below) * (h - fine_mean);
            variance += (h - fine_mean).powi(2);
        }
        rows.push((below, fine_mean, fresh_mean));
    }
    let beta = if variance > 0.0 { (covariance / variance).clamp(0.0, 1.0) } else { 0.0 };
    let distribution: Vec<f64> =
        rows.iter().map(|&(below, fine_mean, fresh_mean)| below + beta * (fresh_mean - fine_mean)).collect();
    let contact_probability_se = standard_error_at_zero(latent, &folds, beta, fresh.len());
    let law = monotone_law(&thresholds, distribution)?;
    Ok(Estimate {
        contact_probability: 1.0 - law.cdf(0.0),
        contact_probability_se,
        coefficients: Some(whole.expansion.coefficients().len()),
        leave_one_out_error: Some(whole.relative_error),
        law,
    })
}

/// An expansion of the latent pressure in the local variables.
struct Surrogate {
    expansion: Expansion,
    /// Leave-one-out errors.
    errors: Vec<f64>,
    relative_error: f64,
}

impl Surrogate {
    /// The expansion of the degree ≤ `degree` with the least leave-one-out error.
    fn fit(scaling: &Scaling, rows: &[Vec<f64>], latent: &[f64], degree: usize) -> Result<Self, MethodError> {
        let variables = scaling.variables();
        if variables == 0 {
            return Err(MethodError::NoVariation);
        }
        let mut best: Option<Self> = None;
        for degree in 0..=degree {
            if number_of_terms(variables, degree).is_none_or(|terms| terms >= rows.len()) {
                break;
            }
            // A degree whose functions the samples cannot tell apart is no candidate.
            let (expansion, fit) = match Expansion::fit(Basis::hermite(variables, degree)?, rows, latent) {
                Ok(fitted) => fitted,
                Err(RegressionError::RankDeficient { .. }) => continue,
                Err(error) => return Err(error.into()),
            };
            let Some(relative_error) = fit.leave_one_out.relative_error else { continue };
            if best.as_ref().is_none_or(|best| relative_error < best.relative_error) {
                let errors = fit.leave_one_out.errors.into_iter().flatten().collect();
                best = Some(Self { expansion, errors, relative_error });
            }
        }
        best.ok_or(MethodError::NoVariation)
    }
}

fn fold_model(
    fold: usize,
    scaling: &Scaling,
    fine: &[Vec<f64>],
    latent: &[f64],
    fresh: &[Vec<f64>],
    degree: usize,
) -> Result<FoldModel, MethodError> {
    let (rows, values): (Vec<Vec<f64>>, Vec<f64>) = fine
        .iter()
        .zip(latent)
        .enumerate()
        .filter(|(i, _)| i % FOLDS != fold)
        .map(|(_, (row, value))| (row.clone(), *value))
        .unzip();
    let surrogate = Surrogate::fit(scaling, &rows, &values, degree)?;
    let held_out =
        (0..fine.len()).filter(|i| i % FOLDS == fold).map(|i| (i, surrogate.expansion.evaluate(&fine[i]))).collect();
    let mut fresh = surrogate.expansion.evaluate_many(fresh);
    fresh.sort_by(f64::total_cmp);
    let errors = ErrorLaws::new(values.iter().zip(&surrogate.errors).map(|(q, e)| (q - e, *e)).collect())?;
    Ok(FoldModel { held_out, fresh, errors })
}

/// Pressures at which F is evaluated, increasing from 0: those of the fine samples, and quantiles of the surrogate up
/// to the largest pressure it can predict, limited to `largest_pa`, where F is 1.
fn thresholds(latent: &[f64], folds: &[FoldModel], largest_pa: f64) -> Vec<f64> {
    let mut thresholds: Vec<f64> = std::iter::once(0.0).chain(latent.iter().copied().filter(|q| *q > 0.0)).collect();
    for fold in folds {
        let last = fold.fresh.len() - 1;
        for k in 0..=MODEL_QUANTILES / FOLDS {
            let s = fold.fresh[k * last / (MODEL_QUANTILES / FOLDS)];
            thresholds.push(s + fold.errors.law(s).quantile(0.5));
        }
        thresholds.push(fold.fresh[last] + fold.errors.law(fold.fresh[last]).quantile(1.0));
    }
    thresholds.retain(|t| *t >= 0.0);
    thresholds.iter_mut().for_each(|t| *t = t.min(largest_pa));
    thresholds.sort_by(f64::total_cmp);
    thresholds.dedup();
    thresholds
}

/// √(Var(1(q ≤ 0) − βh₀)/n + β² Var(h₀)/m) for n fine and m fresh samples.
fn standard_error_at_zero(latent: &[f64], folds: &[FoldModel], beta: f64, fresh: usize) -> f64 {
    let n = latent.len() as f64;
    let (mut residuals, mut predictions) = (Vec::new(), Vec::new());
    for fold in folds {
        for &(i, s) in &fold.held_out {
            let h = fold.errors.cdf(0.0, s);
            residuals.push(f64::from(u8::from(latent[i] <= 0.0)) - beta * h);
            predictions.push(beta * h);
        }
    }
    let variance = |values: &[f64]| {
        let mean = values.iter().sum::<f64>() / n;
        values.iter().map(|x| (x - mean).powi(2)).sum::<f64>() / (n - 1.0)
    };
    (variance(&residuals) / n + variance(&predictions) / fresh as f64).sqrt()
}

/// The law whose distribution function is nearest to the given values (isotonic regression by pooling adjacent
/// violators, which never increases the largest error), limited to [0, 1].
fn monotone_law(thresholds: &[f64], distribution: Vec<f64>) -> Result<StepLaw, MethodError> {
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
    Ok(StepLaw::weighted(atoms)?)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::chaos::distance::{kolmogorov_smirnov, kolmogorov_smirnov_to};
    use crate::law::standard_normal_cdf;
    use crate::random::{standard_normal, stream};

    const NOISE: f64 = 0.3;

    /// q = v₀ + noise is normal with variance 1 + NOISE², so P(q > 0) = ½; v₁ is idle.
    fn linear_world(repeat: u64, fine: usize, fresh: usize) -> (Vec<Vec<f64>>, Vec<f64>, Vec<Vec<f64>>) {
        let draw = |stage: &str, n: usize| -> Vec<Vec<f64>> {
            (0..n as u64).map(|i| standard_normal(&mut stream(repeat, stage, i), 3)).collect()
        };
        let fine = draw("fine", fine);
        let latent = fine.iter().map(|v| v[0] + NOISE * v[2]).collect();
        let two = |rows: Vec<Vec<f64>>| rows.into_iter().map(|v| v[..2].to_vec()).collect();
        (two(fine), latent, two(draw("fresh", fresh)))
    }

    #[test]
    fn the_controlled_probability_is_unbiased_and_its_standard_error_is_right() {
        let repeats = 60;
        let scores: Vec<f64> = (0..repeats)
            .map(|repeat| {
                let (fine, latent, fresh) = linear_world(repeat, 120, 2000);
                let estimate = estimate(&fine, &latent, &fresh, 2, None).unwrap();
                (estimate.contact_probability - 0.5) / estimate.contact_probability_se
            })
            .collect();
        let n = repeats as f64;
        let mean = scores.iter().sum::<f64>() / n;
        let variance = scores.iter().map(|z| z * z).sum::<f64>() / n;
        assert!(mean.abs() < 4.0 / n.sqrt(), "mean score {mean:.2}");
        assert!((variance - 1.0).abs() < 4.0 * (2.0 / n).sqrt(), "mean square score {variance:.2}");
    }

    #[test]
    fn a_surrogate_removes_the_variance_that_it_explains() {
        let truth = |t: f64| standard_normal_cdf(t / (1.0 + NOISE * NOISE).sqrt());
        let left = |t: f64| if t <= 0.0 { 0.0 } else { truth(t) };
        let (repeats, fine, fresh) = (60, 150, 4000);
        let (mut square, mut controlled, mut plain) = (0.0, 0.0, 0.0);
        for repeat in 100..100 + repeats {
            let (fine, latent, fresh) = linear_world(repeat, fine, fresh);
            let estimate = estimate(&fine, &latent, &fresh, 2, None).unwrap();
            square += (estimate.contact_probability - 0.5).powi(2) / repeats as f64;
            controlled += kolmogorov_smirnov_to(&estimate.law, truth, left);
            let clipped: Vec<f64> = latent.iter().map(|q| q.max(0.0)).collect();
            plain += kolmogorov_smirnov_to(&StepLaw::empirical(&clipped).unwrap(), truth, left);
        }
        // Var h₀ = asin(ρ)/2π for two latent values that share v, correlated by ρ = 1/(1 + NOISE²).
        let explained = (1.0 / (1.0 + NOISE * NOISE)).asin() / std::f64::consts::TAU;
        let predicted = (0.25 - explained) / fine as f64 + explained / fresh as f64;
        let ratio = (square / predicted).sqrt();
        assert!((ratio - 1.0).abs() < 4.0 / (2.0 * repeats as f64).sqrt(), "error over its prediction {ratio:.2}");
        // The largest error gains less than an error at one pressure, a factor of 2, but it gains.
        assert!(controlled < 0.85 * plain, "controlled {controlled:.3}, plain {plain:.3}");
    }

    #[test]
    fn a_surrogate_that_knows_nothing_leaves_monte_carlo_as_it_is() {
        let (fine, latent, fresh) = linear_world(7, 400, 2000);
        let shuffled: Vec<Vec<f64>> = fine.iter().map(|v| vec![v[1]]).collect();
        let fresh: Vec<Vec<f64>> = fresh.iter().map(|v| vec![v[1]]).collect();
        let law = estimate(&shuffled, &latent, &fresh, 3, None).unwrap().law;
        let clipped: Vec<f64> = latent.iter().map(|q| q.max(0.0)).collect();
        let difference = kolmogorov_smirnov(&law, &StepLaw::empirical(&clipped).unwrap());
        // Half the standard error ½/√400 of a probability near ½.
        assert!(difference < 0.0125, "differs by {difference:.4}");
    }

    #[test]
    fn no_pressure_exceeds_the_hardness_and_the_atom_there_is_right() {
        let hardness = 1.2;
        let (fine, latent, fresh) = linear_world(8, 200, 1000);
        let law = estimate(&fine, &latent, &fresh, 2, Some(hardness)).unwrap().law;
        assert_eq!(law.quantile(1.0), hardness);
        let atom = 1.0 - law.cdf_left(hardness);
        let wanted = 1.0 - standard_normal_cdf(hardness / (1.0 + NOISE * NOISE).sqrt());
        // Four standard errors of a share of 200 samples.
        assert!((atom - wanted).abs() < 4.0 * (wanted * (1.0 - wanted) / 200.0).sqrt(), "{atom:.4} {wanted:.4}");
    }

    #[test]
    fn pooling_gives_the_nearest_rising_function() {
        let law = monotone_law(&[0.0, 1.0, 2.0, 3.0], vec![0.2, 0.6, 0.4, 1.1]).unwrap();
        let values: Vec<f64> = (0..4).map(|t| law.cdf(f64::from(t))).collect();
        for (found, wanted) in values.iter().zip([0.2, 0.5, 0.5, 1.0]) {
            assert!((found - wanted).abs() < 1e-15, "{values:?}");
        }
    }

    #[test]
    fn the_latent_pressure_orders_gaps_pressures_and_plastic_displacements() {
        let seen = |pressure_pa: f64, gap_m: f64, plastic_displacement_m: f64| Observation {
            pressure_pa,
            gap_m,
            plastic_displacement_m,
            separation_m: 0.0,
        };
        // Spreads 2 and 0.2: κ = 10.
        let found = latent(&[seen(1.0, 0.0, 0.0), seen(5.0, 0.0, 0.3), seen(0.0, 0.5, 0.0), seen(0.0, 0.1, 0.0)]);
        for (q, wanted) in found.iter().zip([1.0, 8.0, -5.0, -1.0]) {
            assert!((q - wanted).abs() < 1e-12, "{found:?}");
        }
    }
}
