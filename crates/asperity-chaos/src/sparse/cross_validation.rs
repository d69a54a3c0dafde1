//! Selection of the number of terms by cross-validation.

use ndarray::Axis;

use super::candidates::Candidates;
use super::error::SparseError;
use super::fit::{Attempt, SparseFit};
use super::growing_fit::{GrowingFit, mean_and_spread};
use super::matching_pursuit::pursue;
use crate::LeaveOneOut;
use asperity_base::blocks;
use asperity_base::random::{standard_normal, stream};

/// Number of attempts that an error reports.
const REPORTED: usize = 5;

/// Returns the model whose number of terms has the smallest cross-validation error, or an error if the mean is better.
pub(super) fn select(
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
        blocks::map(0..folds, |fold| Part::new(candidates, response, &sizes, |sample| parts[sample] == fold));
    let (_, spread) = mean_and_spread(response);
    let scale = samples as f64 * spread * spread / (samples as f64 - 1.0);
    let mut squares = vec![0.0; sizes.len()];
    let mut of_the_mean = 0.0;
    for part in found? {
        squares.iter_mut().zip(&part.squares).for_each(|(sum, square)| *sum += square / scale);
        of_the_mean += part.of_the_mean / scale;
    }
    let mut path: Vec<Attempt> =
        sizes.into_iter().zip(squares).map(|(terms, error)| Attempt { terms, error }).collect();
    let best = path.iter().copied().min_by(|a, b| a.error.total_cmp(&b.error));
    let Some(Attempt { terms, error }) = best.filter(|best| best.error < of_the_mean) else {
        let tried = path.len();
        path.sort_by(|a, b| a.error.total_cmp(&b.error));
        path.truncate(REPORTED);
        return Err(SparseError::NothingPredicts { tried, of_the_mean, attempts: path });
    };
    let fit = pursue(GrowingFit::new(candidates, response), terms);
    // If fewer terms entered, the last model represents all larger ones.
    let terms = terms.min(fit.terms().len());
    let (residuals, leverages) = fit.residuals_and_leverages(response, terms);
    Ok(SparseFit {
        terms: fit.terms()[..terms].to_vec(),
        coefficients: fit.coefficients(terms),
        leave_one_out: LeaveOneOut::new(response, &residuals, &leverages),
        cross_validated: error,
        condition: fit.condition(terms),
        path,
    })
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
        let fit = pursue(GrowingFit::new(&fewer, &values), limit);
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
