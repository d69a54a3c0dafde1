//! Sobol' indices of expansions with bootstrap and jackknife intervals.

use thiserror::Error;

use super::resamples::FITTED_FRACTION;
use super::{
    Basis, Expansion, Factor, LeastSquaresFit, MultiIndexSet, RegressionError, Resamples, ResamplesError,
    SampleEstimate,
};
use asperity_base::blocks;
use asperity_base::stats::{Interval, student_95};

/// Reason why indices have no intervals.
#[derive(Debug, Clone, PartialEq, Error)]
#[non_exhaustive]
pub enum IndexError<E> {
    /// A setting is out of range.
    #[error(transparent)]
    Resamples(#[from] ResamplesError),
    /// The samples themselves have no expansion.
    #[error("the samples have no expansion: {0}")]
    Fit(E),
    /// Too many resamples have no expansion or a constant one. About a third of the samples are missing from a resample.
    #[error(
        "{failed} of {resamples} resamples have no expansion that varies{}; more samples are needed",
        .first.as_ref().map_or_else(String::new, |first| format!(", the first without any because {first}"))
    )]
    TooManyFailures {
        /// Number of resamples without indices.
        failed: usize,
        /// Total number of resamples.
        resamples: usize,
        /// Error of the first resample without an expansion.
        first: Option<E>,
    },
    /// The expansion of the samples is constant.
    #[error("the expansion of the samples is constant: it has no indices")]
    Constant,
}

/// Sobol' indices with standard errors and intervals.
///
/// The intervals describe the effect of the choice of samples on the indices of an expansion with these terms. The
/// truncation of the expansion is a separate error: a variance fraction ε outside the set of terms, about the relative
/// leave-one-out error, changes an index by at most ε.
#[derive(Debug, Clone, PartialEq)]
pub struct IndexEstimates {
    /// First-order index of each variable.
    pub first_order: Vec<SampleEstimate>,
    /// Total index of each variable.
    pub total: Vec<SampleEstimate>,
    /// Closed index of each requested subset.
    pub closed: Vec<SampleEstimate>,
    /// Number of resamples without an expansion or with a constant one, which are left out.
    pub failed: usize,
}

impl Resamples {
    /// Estimates Sobol' indices of a regression over `samples` samples by resampling, with the closed indices of some
    /// subsets of variables.
    ///
    /// `fit` creates an expansion from the samples at the given positions, some of which occur several times. It is
    /// called with 0, 1, …, `samples` − 1 first. Everything that it does, such as selecting terms, is part of the
    /// resampled procedure.
    ///
    /// A resample contains 63 % of the samples, so there should be at least twice as many samples as coefficients.
    /// Samples are assumed independent (Monte Carlo). Samples of stratified designs determine the indices better than
    /// the intervals indicate.
    ///
    /// # Errors
    /// A setting is out of range, the expansion is constant, or the samples or more than 5 % of the resamples have no
    /// expansion.
    ///
    /// # References
    /// Dubreuil, Berveiller, Petitjean & Salaün, *Reliab. Eng. Syst. Saf.* **121** (2014) 263,
    /// <https://doi.org/10.1016/j.ress.2013.09.011>.
    pub fn sobol_indices<E: Send>(
        &self,
        samples: usize,
        closed: &[&[usize]],
        fit: &(dyn Fn(&[usize]) -> Result<Expansion, E> + Sync),
    ) -> Result<IndexEstimates, IndexError<E>> {
        self.check([samples])?;
        let all = |expansion: &Expansion| -> Vec<f64> {
            let mut indices = expansion.first_order_indices();
            indices.extend(expansion.total_indices());
            indices.extend(closed.iter().map(|subset| expansion.closed_index(subset)));
            indices
        };
        let expansion = fit(&(0..samples).collect::<Vec<_>>()).map_err(IndexError::Fit)?;
        let values = all(&expansion);
        if !values.iter().all(|value| value.is_finite()) {
            return Err(IndexError::Constant);
        }
        let replicate = |index: usize| fit(&self.positions(index, &[samples])[0]).map(|expansion| all(&expansion));
        let (mut replicates, mut failed, mut first) = (vec![Vec::with_capacity(self.count); values.len()], 0, None);
        for outcome in blocks::map::<_, Vec<_>>(0..self.count, replicate) {
            match outcome {
                Ok(indices) if indices.iter().all(|value| value.is_finite()) => {
                    replicates.iter_mut().zip(indices).for_each(|(list, index)| list.push(index));
                }
                constant_or_error => {
                    failed += 1;
                    first = first.or(constant_or_error.err());
                }
            }
        }
        if (self.count - failed) as f64 <= FITTED_FRACTION * self.count as f64 {
            return Err(IndexError::TooManyFailures { failed, resamples: self.count, first });
        }
        let range = Interval { low: 0.0, high: 1.0 };
        let mut estimates = values.iter().zip(replicates).map(|(&value, list)| self.estimate(value, list, range));
        let variables = expansion.basis().set().variables();
        let first_order = estimates.by_ref().take(variables).collect();
        let total = estimates.by_ref().take(variables).collect();
        Ok(IndexEstimates { first_order, total, closed: estimates.collect(), failed })
    }
}

/// Variance fractions of groups of terms. All are NaN if the variance is zero.
///
/// # References
/// Sudret, *Reliab. Eng. Syst. Saf.* **93** (2008) 964, <https://doi.org/10.1016/j.ress.2007.04.002>.
impl Expansion {
    /// Returns the first-order Sobol' index of each variable: the variance fraction of the terms in that variable
    /// alone.
    pub fn first_order_indices(&self) -> Vec<f64> {
        self.fractions(|factors| factors.len() == 1)
    }

    /// Returns the total Sobol' index of each variable: the variance fraction of all terms that contain it.
    pub fn total_indices(&self) -> Vec<f64> {
        self.fractions(|_| true)
    }

    /// Returns the variance fraction of the terms in exactly the variables of `subset`, the Sobol' index of their
    /// interaction.
    pub fn subset_index(&self, subset: &[usize]) -> f64 {
        self.fraction(|factors| {
            within(factors, subset) && subset.iter().all(|&v| factors.iter().any(|f| f.variable as usize == v))
        })
    }

    /// Returns the closed Sobol' index Var E(f | ξ_i, i in subset)/Var f: the variance fraction of the terms in no
    /// variable beyond `subset`.
    pub fn closed_index(&self, subset: &[usize]) -> f64 {
        self.fraction(|factors| within(factors, subset))
    }

    /// Returns mean, variance, first-order and total indices of all variables, and the indices of the interactions of two
    /// variables alone: a symmetric matrix, row by row, with NaN on its diagonal.
    pub fn statistics(&self) -> Vec<f64> {
        statistics(self.basis().set(), self.coefficients().iter().copied())
    }

    /// Fits an expansion as [`Expansion::fit`], and estimates 95 % intervals of the [`Expansion::statistics`] by the
    /// jackknife over the samples; `None` if the fit depends entirely on one of them.
    ///
    /// The variance fraction that the terms leave out changes variance and indices by up to the relative leave-one-out
    /// error, by which their intervals are wider. The terms are taken as given. Samples are assumed independent
    /// (Monte Carlo); those of stratified designs determine the statistics better than the intervals indicate.
    ///
    /// # Errors
    /// See [`Expansion::fit`].
    ///
    /// # References
    /// Efron & Stein, *Ann. Statist.* **9** (1981) 586, <https://doi.org/10.1214/aos/1176345462>.
    pub fn fit_with_intervals<G: AsRef<[f64]>>(
        basis: Basis,
        xi_samples: &[G],
        response: &[f64],
    ) -> Result<(Self, LeastSquaresFit, Option<Vec<Interval>>), RegressionError> {
        let (expansion, fit, problem) = Self::solved(basis, xi_samples, response)?;
        let error = fit.leave_one_out.relative_error.unwrap_or_default();
        let values = expansion.statistics();
        let intervals = problem.without_each(&fit).map(|without| {
            let samples = response.len();
            // Mean and mean square of the changes without each sample.
            let mut changes = vec![(0.0, 0.0); values.len()];
            for own in without.columns() {
                let without = statistics(expansion.basis().set(), own.iter().copied());
                for ((mean, square), change) in changes.iter_mut().zip(without.iter().zip(&values).map(|(w, v)| w - v))
                {
                    *mean += change / samples as f64;
                    *square += change * change / samples as f64;
                }
            }
            let interval = |(place, (&value, (mean, square))): (usize, (&f64, (f64, f64)))| {
                let (left_out, low, high) = match place {
                    0 => (0.0, f64::NEG_INFINITY, f64::INFINITY),
                    1 => (error * value, 0.0, f64::INFINITY),
                    _ => (error, 0.0, 1.0),
                };
                let jackknife_error = ((samples - 1) as f64 * (square - mean * mean)).max(0.0).sqrt();
                let half = student_95(samples) * jackknife_error + left_out;
                Interval { low: (value - half).clamp(low, high), high: (value + half).clamp(low, high) }
            };
            values.iter().zip(changes).enumerate().map(interval).collect()
        });
        Ok((expansion, fit, intervals))
    }

    /// Returns for each variable the fraction of the terms that contain it and satisfy `belong`.
    fn fractions(&self, belong: impl Fn(&[Factor]) -> bool) -> Vec<f64> {
        let mut parts = vec![0.0; self.basis().set().variables()];
        for (factors, c) in self.fluctuations().filter(|(factors, _)| belong(factors)) {
            for factor in factors {
                parts[factor.variable as usize] += c * c;
            }
        }
        let variance = self.variance();
        parts.iter_mut().for_each(|part| *part /= variance);
        parts
    }

    fn fraction(&self, belongs: impl Fn(&[Factor]) -> bool) -> f64 {
        let part: f64 = self.fluctuations().filter(|(factors, _)| belongs(factors)).map(|(_, c)| c * c).sum();
        part / self.variance()
    }

    /// Returns all terms except the constant.
    fn fluctuations(&self) -> impl Iterator<Item = (&[Factor], f64)> {
        self.basis().set().iter().zip(self.coefficients().iter().copied()).skip(1)
    }
}

/// Returns the [`Expansion::statistics`] of given coefficients.
fn statistics(set: &MultiIndexSet, coefficients: impl Iterator<Item = f64>) -> Vec<f64> {
    let n = set.variables();
    let (first_order, total, second_order) = (2, 2 + n, 2 + 2 * n);
    let mut parts = vec![0.0; second_order + n * n];
    for (factors, c) in set.iter().zip(coefficients) {
        match factors {
            [] => {
                parts[0] = c;
                continue;
            }
            [own] => parts[first_order + own.variable as usize] += c * c,
            [own, other] => {
                let (own, other) = (own.variable as usize, other.variable as usize);
                parts[second_order + own * n + other] += c * c;
                parts[second_order + other * n + own] += c * c;
            }
            _ => {}
        }
        parts[1] += c * c;
        factors.iter().for_each(|own| parts[total + own.variable as usize] += c * c);
    }
    let variance = parts[1];
    parts[first_order..].iter_mut().for_each(|part| *part /= variance);
    (0..n).for_each(|own| parts[second_order + own * n + own] = f64::NAN);
    parts
}

fn within(factors: &[Factor], subset: &[usize]) -> bool {
    factors.iter().all(|factor| subset.contains(&(factor.variable as usize)))
}

#[cfg(test)]
mod tests;
