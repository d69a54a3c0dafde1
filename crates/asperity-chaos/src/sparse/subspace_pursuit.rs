//! Subspace pursuit.

use std::cmp::Ordering;

use super::candidates::Candidates;
use super::fit::{Attempt, StopReason};
use super::growing_fit::GrowingFit;
use super::search::Search;
use asperity_base::blocks;

/// Numbers of terms tried first, logarithmically spaced, and then around the best.
const COARSE: usize = 24;
const FINE: usize = 8;

/// Maximum number of exchanges for one number of terms.
const MAX_EXCHANGES: usize = 50;

/// Tries subspace pursuit for numbers of terms up to half of the samples, and returns the best model.
pub(super) fn search<'a, 'c>(start: GrowingFit<'a, 'c>, limit: usize) -> Search<'a, 'c> {
    let candidates = start.candidates();
    let constant = start.terms().len();
    let most = most(candidates, limit, constant);
    let mut correlations = vec![0.0; candidates.columns()];
    candidates.correlate(start.residual(), &mut correlations);
    let pursue = |counts: Vec<usize>| -> Vec<(usize, Attempt, GrowingFit<'a, 'c>)> {
        blocks::map(0..counts.len(), |index| {
            let fit = pursue(&start, &correlations, counts[index]);
            (counts[index], fit.assess(), fit)
        })
    };
    let mut tried: Vec<(usize, Attempt)> = Vec::new();
    let mut best: Option<(Attempt, GrowingFit<'a, 'c>)> = None;
    let mut keep = |found: Vec<(usize, Attempt, GrowingFit<'a, 'c>)>, tried: &mut Vec<(usize, Attempt)>| {
        // The response is uncorrelated with all columns or already spanned: there is no model besides the constant.
        for (count, attempt, fit) in found.into_iter().filter(|(_, attempt, _)| attempt.terms > constant) {
            tried.push((count, attempt));
            if best.as_ref().is_none_or(|(least, _)| attempt.error() < least.error()) {
                best = Some((attempt, fit));
            }
        }
        tried.sort_by_key(|(count, _)| *count);
    };
    keep(pursue(spaced(1, most, COARSE)), &mut tried);
    let at = (0..tried.len()).min_by(|&a, &b| tried[a].1.error().total_cmp(&tried[b].1.error()));
    if let Some(at) = at {
        let from = tried[at.saturating_sub(1)].0;
        let to = tried[(at + 1).min(tried.len() - 1)].0;
        let known: Vec<usize> = tried.iter().map(|(count, _)| *count).collect();
        keep(pursue(spaced(from, to, FINE).into_iter().filter(|count| !known.contains(count)).collect()), &mut tried);
    }
    let path = tried.into_iter().map(|(_, attempt)| attempt).collect();
    let fit = best.map_or(start, |(_, fit)| fit);
    let stop_reason = if fit.is_exact() { StopReason::Exact } else { StopReason::TermLimit };
    Search { best: fit.terms().len(), fit, path, stop_reason }
}

/// Returns the maximum number of terms besides the constant. Twice as many columns are fitted at once, and one sample
/// must remain.
fn most(candidates: &Candidates<'_>, limit: usize, constant: usize) -> usize {
    limit.min(candidates.samples().div_ceil(2)).saturating_sub(constant).min(candidates.selectable())
}

/// Returns the numbers of terms, including the constant, that are tried first.
pub(super) fn sizes(candidates: &Candidates<'_>, limit: usize) -> Vec<usize> {
    let constant = usize::from(candidates.constant().is_some());
    spaced(1, most(candidates, limit, constant), COARSE).into_iter().map(|count| count + constant).collect()
}

/// Returns the model with the given number of terms, including the constant.
pub(super) fn with_terms<'a, 'c>(start: GrowingFit<'a, 'c>, terms: usize) -> GrowingFit<'a, 'c> {
    let mut correlations = vec![0.0; start.candidates().columns()];
    start.candidates().correlate(start.residual(), &mut correlations);
    pursue(&start, &correlations, terms.saturating_sub(start.terms().len()))
}

/// Returns logarithmically spaced integers between two numbers, both included.
fn spaced(from: usize, to: usize, count: usize) -> Vec<usize> {
    if to < from || from == 0 {
        return Vec::new();
    }
    let ratio = (to as f64 / from as f64).ln() / (count - 1) as f64;
    let mut numbers: Vec<usize> =
        (0..count).map(|i| (from as f64 * (ratio * i as f64).exp()).round() as usize).collect();
    numbers.dedup();
    numbers
}

/// Returns the set of `count` terms besides the constant that exchanges cannot improve.
fn pursue<'a, 'c>(start: &GrowingFit<'a, 'c>, correlations: &[f64], count: usize) -> GrowingFit<'a, 'c> {
    let candidates = start.candidates();
    let mut fit = grown(start, &largest(correlations, count));
    let mut products = vec![0.0; candidates.columns()];
    for _ in 0..MAX_EXCHANGES {
        if fit.is_exact() {
            break;
        }
        candidates.correlate(fit.residual(), &mut products);
        let chosen = &fit.terms()[start.terms().len()..];
        chosen.iter().for_each(|&term| products[term] = 0.0);
        let union: Vec<usize> = chosen.iter().copied().chain(largest(&products, count)).collect();
        let both = grown(start, &union);
        let weights: Vec<f64> = both
            .coefficients(both.terms().len())
            .iter()
            .zip(both.terms())
            .map(|(coefficient, &term)| coefficient * candidates.norm(term))
            .collect();
        let places = largest(&weights[start.terms().len()..], count);
        let kept: Vec<usize> = places.into_iter().map(|place| both.terms()[start.terms().len() + place]).collect();
        let exchanged = grown(start, &kept);
        if square(exchanged.residual()) >= square(fit.residual()) {
            break;
        }
        fit = exchanged;
    }
    fit
}

/// Adds further terms to a fit; linearly dependent terms are left out.
fn grown<'a, 'c>(start: &GrowingFit<'a, 'c>, terms: &[usize]) -> GrowingFit<'a, 'c> {
    let mut fit = start.clone();
    for &term in terms {
        fit.enter(term);
    }
    fit
}

/// Returns the positions of the largest non-zero absolute values, largest first.
fn largest(values: &[f64], count: usize) -> Vec<usize> {
    let order = |&a: &usize, &b: &usize| -> Ordering { values[b].abs().total_cmp(&values[a].abs()).then(a.cmp(&b)) };
    let mut places: Vec<usize> = (0..values.len()).filter(|&place| values[place] != 0.0).collect();
    if count < places.len() && count > 0 {
        places.select_nth_unstable_by(count - 1, order);
    }
    places.truncate(count);
    places.sort_by(order);
    places
}

fn square(values: &[f64]) -> f64 {
    values.iter().map(|x| x * x).sum()
}
