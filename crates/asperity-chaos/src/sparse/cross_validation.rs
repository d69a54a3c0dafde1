//! Selection of the number of terms by cross-validation.

use ndarray::Axis;

use super::candidates::Candidates;
use super::error::SparseError;
use super::fit::{Attempt, SparseFit};
use super::growing_fit::{GrowingFit, mean_and_spread};
use super::settings::SparseMethod;
use asperity_base::blocks;
use asperity_base::random::{standard_normal, stream};

/// Returns the model whose number of terms has the smallest cross-validation error.
pub(super) fn select(
    method: SparseMethod,
    candidates: &Candidates<'_>,
    response: &[f64],
    limit: usize,
    folds: usize,
) -> Result<SparseFit, SparseError> {
    let samples = response.len();
    let folds = folds.clamp(2, samples);
    // No more terms than every part can determine.
    let limit = limit.min((samples - samples.div_ceil(folds)).saturating_sub(1));
    let constant = usize::from(candidates.constant().is_some());
    let sizes: Vec<usize> = (constant + 1..=limit).collect();
    let parts = partition(samples, folds);
    let found: Result<Vec<Part>, SparseError> =
        blocks::map(0..folds, |fold| Part::new(method, candidates, response, &sizes, |sample| parts[sample] == fold));
    let (_, spread) = mean_and_spread(response);
    let scale = samples as f64 * spread * spread / (samples as f64 - 1.0);
    let mut squares = vec![0.0; sizes.len()];
    let mut of_the_mean = 0.0;
    for part in found? {
        squares.iter_mut().zip(&part.squares).for_each(|(sum, square)| *sum += square / scale);
        of_the_mean += part.of_the_mean / scale;
    }
    let best = (0..sizes.len()).min_by(|&a, &b| squares[a].total_cmp(&squares[b]));
    let terms = best.map_or(constant, |best| sizes[best]);
    let start = GrowingFit::new(candidates, response);
    // The whole path, without early stopping.
    let mut search = method.search(start, terms.max(constant + 1).min(limit), usize::MAX / 2);
    search.best = search.fit.terms().len().min(terms);
    let tried = std::mem::take(&mut search.path);
    search.path = sizes
        .iter()
        .zip(squares)
        .map(|(&terms, error)| {
            // If fewer terms entered, the last model represents all larger ones.
            let last = tried.last().filter(|last| last.terms < terms && last.terms == search.best);
            let known = tried.iter().find(|attempt| attempt.terms == terms).or(last);
            let (leave_one_out, corrected) = known.map_or((None, None), |known| (known.leave_one_out, known.corrected));
            Attempt { terms, leave_one_out, corrected, cross_validated: Some(error) }
        })
        .collect();
    search.finish(response, of_the_mean)
}

/// Squared errors at the left-out samples.
struct Part {
    /// Squared error of each number of terms.
    squares: Vec<f64>,
    /// Squared error of the mean of the other samples.
    of_the_mean: f64,
}

impl Part {
    fn new(
        method: SparseMethod,
        candidates: &Candidates<'_>,
        response: &[f64],
        sizes: &[usize],
        left_out: impl Fn(usize) -> bool,
    ) -> Result<Self, SparseError> {
        let (out, kept): (Vec<usize>, Vec<usize>) = (0..response.len()).partition(|&sample| left_out(sample));
        let matrix = candidates.design().select(Axis(0), &kept);
        let values: Vec<f64> = kept.iter().map(|&sample| response[sample]).collect();
        let fewer = Candidates::new(matrix.view())?;
        let (mean, _) = mean_and_spread(&values);
        let of_the_mean: f64 = out.iter().map(|&sample| (response[sample] - mean).powi(2)).sum();
        let limit = sizes.last().copied().unwrap_or(0);
        let fit = method.search(GrowingFit::new(&fewer, &values), limit, usize::MAX / 2).fit;
        let mut sums = vec![0.0; fit.terms().len()];
        for &sample in &out {
            let errors = fit.errors_at(candidates.design().row(sample), response[sample]);
            sums.iter_mut().zip(errors).for_each(|(sum, error)| *sum += error * error);
        }
        // A path may end early when nothing is left to explain or to enter.
        let last = sums.last().copied().unwrap_or(of_the_mean);
        let squares = sizes.iter().map(|&size| sums.get(size - 1).copied().unwrap_or(last)).collect();
        Ok(Self { squares, of_the_mean })
    }
}

/// Returns the part of each sample, a random partition that depends on the two numbers alone.
fn partition(samples: usize, folds: usize) -> Vec<usize> {
    let keys = standard_normal(&mut stream(0, "parts of a cross-validation", samples as u64), samples);
    let mut order: Vec<usize> = (0..samples).collect();
    order.sort_by(|&a, &b| keys[a].total_cmp(&keys[b]));
    let mut parts = vec![0; samples];
    order.iter().enumerate().for_each(|(place, &sample)| parts[sample] = place % folds);
    parts
}
