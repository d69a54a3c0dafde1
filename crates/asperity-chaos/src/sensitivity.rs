//! Sobol' indices of expansions, and how well samples determine them.

use rayon::prelude::*;
use thiserror::Error;

use super::{Estimate, Expansion, Factor, Resamples, ResamplesError};
use asperity_base::stats::Interval;

/// Share of the resamples that must have an expansion.
const FITTED_SHARE: f64 = 0.95;

/// Why indices have no intervals.
#[derive(Debug, Clone, PartialEq, Error)]
pub enum IndexError<E> {
    /// A setting is out of range.
    #[error(transparent)]
    Resamples(#[from] ResamplesError),
    /// The samples themselves have no expansion.
    #[error("the samples have no expansion: {0}")]
    Fit(E),
    /// Too many resamples have none. About a third of the samples are missing from a resample.
    #[error("{failed} of {resamples} resamples have no expansion, the first because {first}; more samples are needed")]
    TooManyFailures {
        /// Resamples without expansion.
        failed: usize,
        /// All resamples.
        resamples: usize,
        /// Why the first of them has none.
        first: E,
    },
    /// The expansion of the samples is constant.
    #[error("the expansion of the samples is constant: it has no indices")]
    Constant,
}

/// Sobol' indices with standard errors and intervals.
///
/// They say what the choice of the samples does to the indices of an expansion with these terms. What is missing from the
/// set of terms is another error: a variance share ε outside of it, about the relative leave-one-out error, moves an index
/// by at most ε.
#[derive(Debug, Clone, PartialEq)]
pub struct IndexEstimates {
    /// First-order index of each variable.
    pub first_order: Vec<Estimate>,
    /// Total index of each variable.
    pub total: Vec<Estimate>,
    /// Closed index of each subset that was asked for.
    pub closed: Vec<Estimate>,
    /// Resamples without expansion, left out.
    pub failed: usize,
}

impl Resamples {
    /// Sobol' indices of a regression over `samples` samples, and the closed ones of some subsets of variables, by drawing
    /// the samples again. `fit` makes an expansion of the samples at the given positions, of which some occur several
    /// times; it is called with 0, 1, …, `samples` − 1 first. Whatever it does besides, such as choosing terms, is part of
    /// what is tried.
    ///
    /// A resample holds 63 % of the samples, so there should be at least twice as many as coefficients. They are taken
    /// as independent (Monte Carlo); those of stratified designs determine the indices better than the intervals say.
    ///
    /// # Errors
    /// Settings out of range, a constant expansion, no expansion of the samples or of more than 5 % of the resamples.
    ///
    /// # References
    /// Dubreuil, Berveiller, Petitjean & Salaün, *Reliab. Eng. Syst. Saf.* **121** (2014) 263,
    /// <https://doi.org/10.1016/j.ress.2013.09.011>.
    pub fn sobol_indices<E: Send>(
        &self,
        samples: usize,
        closed: &[&[usize]],
        fit: impl Fn(&[usize]) -> Result<Expansion, E> + Sync,
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
        for outcome in (0..self.count).into_par_iter().map(replicate).collect::<Vec<_>>() {
            match outcome {
                Ok(indices) => replicates.iter_mut().zip(indices).for_each(|(list, index)| list.push(index)),
                Err(error) => {
                    failed += 1;
                    first.get_or_insert(error);
                }
            }
        }
        if let Some(first) = first
            && (self.count - failed) as f64 <= FITTED_SHARE * self.count as f64
        {
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

/// Variance shares of groups of terms. All are NaN when the variance is zero.
///
/// # References
/// Sudret, *Reliab. Eng. Syst. Saf.* **93** (2008) 964, <https://doi.org/10.1016/j.ress.2007.04.002>.
impl Expansion {
    /// First-order Sobol' index of each variable: the variance share of the terms in that variable alone.
    pub fn first_order_indices(&self) -> Vec<f64> {
        self.shares(|factors| factors.len() == 1)
    }

    /// Total Sobol' index of each variable: the variance share of all terms that hold it.
    pub fn total_indices(&self) -> Vec<f64> {
        self.shares(|_| true)
    }

    /// Variance share of the terms that hold exactly the variables of `subset`, the Sobol' index of their interaction.
    pub fn subset_index(&self, subset: &[usize]) -> f64 {
        self.share(|factors| {
            within(factors, subset) && subset.iter().all(|&v| factors.iter().any(|f| f.variable as usize == v))
        })
    }

    /// Closed Sobol' index: the variance share of the terms that hold no variable beyond `subset`, Var E(f | ξ_i, i in
    /// subset)/Var f.
    pub fn closed_index(&self, subset: &[usize]) -> f64 {
        self.share(|factors| within(factors, subset))
    }

    /// For each variable the share of the terms that hold it and `belong`.
    fn shares(&self, belong: impl Fn(&[Factor]) -> bool) -> Vec<f64> {
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

    fn share(&self, belongs: impl Fn(&[Factor]) -> bool) -> f64 {
        let part: f64 = self.fluctuations().filter(|(factors, _)| belongs(factors)).map(|(_, c)| c * c).sum();
        part / self.variance()
    }

    /// All terms but the constant.
    fn fluctuations(&self) -> impl Iterator<Item = (&[Factor], f64)> {
        self.basis().set().iter().zip(self.coefficients().iter().copied()).skip(1)
    }
}

fn within(factors: &[Factor], subset: &[usize]) -> bool {
    factors.iter().all(|factor| subset.contains(&(factor.variable as usize)))
}

#[cfg(test)]
mod tests;
