//! Maximum-likelihood Johnson distribution, unbounded or bounded.
//!
//! For given ξ and λ, f((x − ξ)/λ) is a normal sample with γ and δ from its moments. The search is over ξ and λ, or
//! over the two ends; for a large sample it uses the [`condensed`] one.

use super::family::{End, Family, Fit};
use super::maximise::FARTHEST;
use crate::distribution::{DistributionError, JohnsonSystem, Marginal, condensed};
use crate::numeric::simplex;
use crate::stats::Moments;

/// Range of the scale of S_U in standard deviations of the sample; at the upper limit the distribution is practically
/// lognormal or normal.
const SCALES: std::ops::RangeInclusive<f64> = 1e-3..=1e3;
/// Largest distance of ξ of S_U from the mean, in units of max(λ, standard deviation).
const FARTHEST_CENTRE: f64 = 30.0;
/// Least distance of an end of S_B from the sample, in units of its range. Smaller ones approach the unbounded
/// likelihood at the extreme value.
const NEAREST: f64 = 1e-4;

/// Returns the system with the larger likelihood; the lognormal and normal distributions are limits of both.
pub(super) fn fit(sorted: &[f64]) -> Result<Fit, DistributionError> {
    let systems = [unbounded, bounded];
    let candidates: Vec<Option<Fit>> = crate::blocks::map(0..systems.len(), |system| systems[system](sorted));
    candidates.into_iter().flatten().max_by(|a, b| a.log_likelihood.total_cmp(&b.log_likelihood)).ok_or(
        DistributionError::Sample {
            distribution: "johnson",
            n: sorted.len(),
            reason: "the likelihood has no maximum over the ends",
        },
    )
}

/// Returns the maximum-likelihood γ and δ for given ξ and λ, with the mean log-likelihood.
fn profile(sorted: &[f64], system: JohnsonSystem, xi: f64, lambda: f64) -> Option<(Marginal, f64)> {
    let u = || sorted.iter().map(|x| (x - xi) / lambda);
    let (normal, stretch): (Moments, f64) = match system {
        JohnsonSystem::Bounded => {
            let logits = || u().map(|u| (u.ln(), (1.0 - u).ln()));
            (Moments::from_values(logits().map(|(a, b)| a - b)), logits().map(|(a, b)| a + b).sum())
        }
        _ => (Moments::from_values(u().map(f64::asinh)), u().map(|u| 0.5 * (u * u).ln_1p()).sum()),
    };
    let delta = 1.0 / normal.std;
    // Σ ln φ of a standardised sample is −n (1 + ln 2π)/2.
    let mean_log = (delta / lambda).ln() - stretch / sorted.len() as f64 - 0.5 * (1.0 + std::f64::consts::TAU.ln());
    let marginal = Marginal::johnson(system, -normal.mean * delta, delta, xi, lambda).ok()?;
    mean_log.is_finite().then_some((marginal, mean_log))
}

fn fitted(sorted: &[f64], (marginal, mean_log): (Marginal, f64), low_end: End, high_end: End) -> Fit {
    let n = sorted.len();
    Fit { family: Family::Johnson, marginal, n, log_likelihood: n as f64 * mean_log, low_end, high_end }
}

/// Returns the maximum-likelihood S_U distribution, searched from the best of a grid of centres and scales and from the
/// distribution with the moments of the sample.
fn unbounded(sorted: &[f64]) -> Option<Fit> {
    let moments = Moments::new(sorted);
    let at = |values: &[f64], [centre, log_scale]: [f64; 2]| {
        let scale = log_scale.exp();
        let inside = SCALES.contains(&scale) && centre.abs() <= FARTHEST_CENTRE * scale.max(1.0);
        let (xi, lambda) = (moments.mean + moments.std * centre, moments.std * scale);
        if inside { profile(values, JohnsonSystem::Unbounded, xi, lambda) } else { None }
    };
    let few = condensed(sorted);
    let height = |place: [f64; 2]| at(&few, place).map_or(f64::NEG_INFINITY, |(_, mean_log)| mean_log);
    let mut starts: Vec<[f64; 2]> = vec![];
    for scale in [0.3_f64, 1.0, 3.0, 10.0, 100.0] {
        starts.extend([-2.0, -0.7, 0.0, 0.7, 2.0].map(|fraction| [fraction * scale.max(0.5), scale.ln()]));
    }
    if let Ok(Marginal::Johnson(marginal)) =
        Marginal::johnson_with_moments(0.0, 1.0, moments.skewness, moments.excess_kurtosis)
        && marginal.system == JohnsonSystem::Unbounded
    {
        starts.push([marginal.xi, marginal.lambda.ln()]);
    }
    let best = starts.into_iter().max_by(|a, b| height(*a).total_cmp(&height(*b)))?;
    let (place, _) = simplex(height, best, 0.3);
    Some(fitted(sorted, at(sorted, place)?, End::Given, End::Given))
}

/// Returns the maximum-likelihood S_B distribution with ends outside the sample.
fn bounded(sorted: &[f64]) -> Option<Fit> {
    let (first, last) = (sorted[0], sorted[sorted.len() - 1]);
    let range = last - first;
    let searched = NEAREST.ln()..=FARTHEST.ln();
    let at = |values: &[f64], log_gaps: [f64; 2]| {
        if log_gaps.iter().any(|gap| !searched.contains(gap)) {
            return None;
        }
        let [low, high] = [first - range * log_gaps[0].exp(), last + range * log_gaps[1].exp()];
        profile(values, JohnsonSystem::Bounded, low, high - low)
    };
    let few = condensed(sorted);
    let height = |log_gaps: [f64; 2]| at(&few, log_gaps).map_or(f64::NEG_INFINITY, |(_, mean_log)| mean_log);
    // Start from a local maximum of a coarse grid that is not at the smallest gaps, where the likelihood rises towards
    // an extreme value.
    let grid: Vec<f64> = (0..8).map(|i| 1e-3_f64.ln() + f64::from(i) * (1e5_f64.ln() / 7.0)).collect();
    let heights: Vec<Vec<f64>> = grid.iter().map(|a| grid.iter().map(|b| height([*a, *b])).collect()).collect();
    let peak = |i: usize, j: usize| {
        let neighbours = [(i.wrapping_sub(1), j), (i + 1, j), (i, j.wrapping_sub(1)), (i, j + 1)];
        neighbours.iter().all(|(k, l)| heights.get(*k).and_then(|row| row.get(*l)).is_none_or(|h| *h <= heights[i][j]))
    };
    let start = (1..grid.len())
        .flat_map(|i| (1..grid.len()).map(move |j| (i, j)))
        .filter(|&(i, j)| heights[i][j].is_finite() && peak(i, j))
        .max_by(|a, b| heights[a.0][a.1].total_cmp(&heights[b.0][b.1]))?;
    let (log_gaps, _) = simplex(height, [grid[start.0], grid[start.1]], 0.5);
    if log_gaps.iter().any(|gap| *gap <= NEAREST.ln() + 0.05) {
        return None;
    }
    let end = |gap: f64| if gap >= FARTHEST.ln() - 2.5 { End::OutOfSight } else { End::Fitted };
    Some(fitted(sorted, at(sorted, log_gaps)?, end(log_gaps[0]), end(log_gaps[1])))
}

#[cfg(test)]
mod tests {
    use super::super::tests::{assert_most_likely, sample};
    use super::super::{fit, rank_by_aic};
    use super::*;
    use crate::distribution::Johnson;

    fn johnson(fit: &Fit) -> Johnson {
        let Marginal::Johnson(marginal) = fit.marginal else { panic!("{} is no Johnson distribution", fit.marginal) };
        marginal
    }

    fn neighbours(marginal: Johnson) -> Vec<Marginal> {
        let mut marginals = vec![];
        for h in [-1e-3, 1e-3] {
            marginals.push(
                Marginal::johnson(marginal.system, marginal.gamma + h, marginal.delta, marginal.xi, marginal.lambda)
                    .unwrap(),
            );
            marginals.push(
                Marginal::johnson(marginal.system, marginal.gamma, marginal.delta + h, marginal.xi, marginal.lambda)
                    .unwrap(),
            );
            marginals.push(
                Marginal::johnson(marginal.system, marginal.gamma, marginal.delta, marginal.xi + h, marginal.lambda)
                    .unwrap(),
            );
            marginals.push(
                Marginal::johnson(marginal.system, marginal.gamma, marginal.delta, marginal.xi, marginal.lambda + h)
                    .unwrap(),
            );
        }
        marginals
    }

    #[test]
    fn the_fit_is_a_local_maximum_at_the_true_quantiles() {
        // The standard errors of quantiles p of n values are at most √(p(1 − p)/n)/density; those of a parametric fit
        // are smaller.
        let n = 4000;
        for (index, text) in
            ["johnson_su:-1.1,1.5,3,2", "johnson_su:0,0.9", "johnson_sb:0.5,0.8,-1,3", "johnson_sb:-1,1.6,0,5"]
                .into_iter()
                .enumerate()
        {
            let truth: Marginal = text.parse().unwrap();
            let values = sample(text, n, 100 + index as u64);
            let fitted = fit(Family::Johnson, &values).unwrap();
            assert_eq!(fitted.marginal.name(), truth.name(), "{text}: {fitted:?}");
            let direct: f64 = values.iter().map(|x| fitted.marginal.ln_pdf(*x)).sum();
            assert!((direct - fitted.log_likelihood).abs() < 1e-7, "{text}");
            assert_most_likely(&fitted, &values, &neighbours(johnson(&fitted)));
            assert_most_likely(&fitted, &values, std::slice::from_ref(&truth));
            for p in [0.02, 0.2, 0.5, 0.8, 0.98] {
                let x = truth.quantile(p);
                let error = (p * (1.0 - p) / n as f64).sqrt() / truth.pdf(x);
                assert!((fitted.marginal.quantile(p) - x).abs() < 4.0 * error, "{text} at {p}: {}", fitted.marginal);
            }
        }
    }

    #[test]
    fn normal_and_lognormal_samples_are_met_in_the_limit() {
        for (text, family, index) in
            [("normal:10,2", Family::Normal, 110), ("lognormal:0,0.4,-1", Family::ShiftedLognormal, 111)]
        {
            let values = sample(text, 1000, index);
            let (limit, fitted) = (fit(family, &values).unwrap(), fit(Family::Johnson, &values).unwrap());
            assert!(fitted.log_likelihood > limit.log_likelihood - 0.05, "{text}: {fitted:?} {limit:?}");
            assert!(
                (fitted.marginal.mean() / limit.marginal.mean() - 1.0).abs() < 0.02,
                "{text}: {fitted:?} {limit:?}"
            );
            assert!((fitted.marginal.std() / limit.marginal.std() - 1.0).abs() < 0.05, "{text}: {fitted:?} {limit:?}");
        }
    }

    #[test]
    fn a_plateau_of_heights_is_ranked_as_a_johnson_distribution() {
        // Worn-in surfaces have negative skewness and heavy tails; a Weibull distribution of skewness −0.5 has a
        // kurtosis of 3.3.
        let values = sample("johnson:-0.5,6", 4000, 112);
        let ranking = rank_by_aic(&Family::HEIGHTS, &values, None);
        assert_eq!(ranking.fits[0].family, Family::Johnson, "{ranking:?}");
        assert!(ranking.fits[1].aic() > ranking.fits[0].aic() + 10.0);
    }

    #[test]
    fn the_fit_follows_the_unit_of_the_values() {
        let metre = sample("johnson_su:-1.1,1.5,3,2", 300, 113);
        let nanometre: Vec<f64> = metre.iter().map(|x| x * 1e-9).collect();
        let (a, b) = (fit(Family::Johnson, &metre).unwrap(), fit(Family::Johnson, &nanometre).unwrap());
        for p in [0.1, 0.5, 0.9] {
            assert!((a.marginal.quantile(p) * 1e-9 / b.marginal.quantile(p) - 1.0).abs() < 1e-5);
        }
    }
}
