//! Sobol' indices of expansions with bootstrap intervals.

use thiserror::Error;

use super::resamples::FITTED_FRACTION;
use super::{Expansion, Factor, Resamples, ResamplesError, SampleEstimate};
use asperity_base::blocks;
use asperity_base::stats::Interval;

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

fn within(factors: &[Factor], subset: &[usize]) -> bool {
    factors.iter().all(|factor| subset.contains(&(factor.variable as usize)))
}

#[cfg(test)]
mod tests;
