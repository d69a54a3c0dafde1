//! Sobol' indices of expansions.

use super::{Expansion, Factor};

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
