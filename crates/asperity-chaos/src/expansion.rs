//! Functions of a Î¾ as sums of orthonormal polynomials.

use rayon::prelude::*;

use super::horner::{Evaluate, Horner, Scratch};
use super::{Basis, Fit, LeastSquares, RegressionError};
use asperity_base::wide::wide;

/// Points that a thread evaluates at a time.
const BLOCK: usize = 1024;

/// f(ξ) = Σ_α c_α Ψ_α(ξ) with orthonormal Ψ_α.
#[derive(Debug, Clone, PartialEq)]
pub struct Expansion {
    basis: Basis,
    coefficients: Vec<f64>,
    horner: Horner,
}

impl Expansion {
    /// An expansion with given coefficients, in the order of the basis.
    ///
    /// # Panics
    /// If the numbers of coefficients and functions differ.
    pub fn new(basis: Basis, coefficients: Vec<f64>) -> Self {
        assert_eq!(basis.len(), coefficients.len(), "coefficients of another basis");
        let horner = Horner::new(&basis, &coefficients);
        Self { basis, coefficients, horner }
    }

    /// The least-squares expansion of the values `response` at `xi_samples`, and its fit.
    ///
    /// # Errors
    /// As [`LeastSquares::new`] and [`LeastSquares::fit`].
    pub fn fit<G: AsRef<[f64]>>(
        basis: Basis,
        xi_samples: &[G],
        response: &[f64],
    ) -> Result<(Self, Fit), RegressionError> {
        if xi_samples.len() <= basis.len() {
            return Err(RegressionError::TooFewSamples { samples: xi_samples.len(), coefficients: basis.len() });
        }
        let fit = LeastSquares::new(basis.design_matrix(xi_samples).view())?.fit(response)?;
        Ok((Self::new(basis, fit.coefficients.clone()), fit))
    }

    /// The basis.
    pub fn basis(&self) -> &Basis {
        &self.basis
    }

    /// Coefficients in the order of the basis.
    pub fn coefficients(&self) -> &[f64] {
        &self.coefficients
    }

    /// f(ξ), the same bits as [`Expansion::evaluate_many`] gives.
    ///
    /// # Panics
    /// If the Î¾ is shorter than the number of variables; values beyond them are ignored.
    pub fn evaluate(&self, xi: &[f64]) -> f64 {
        let mut value = [0.0];
        self.check(&[xi]);
        self.evaluate_block(&[xi], &mut value, &mut Scratch::default());
        value[0]
    }

    /// f at each Î¾, in order, by all threads. A Î¾'s value does not depend on the others.
    ///
    /// # Panics
    /// As [`Expansion::evaluate`].
    pub fn evaluate_many<G: AsRef<[f64]> + Sync>(&self, xi_samples: &[G]) -> Vec<f64> {
        self.check(xi_samples);
        let mut values = vec![0.0; xi_samples.len()];
        let blocks = xi_samples.par_chunks(BLOCK).zip(values.par_chunks_mut(BLOCK));
        blocks.for_each_init(Scratch::default, |scratch, (xi_samples, values)| {
            self.evaluate_block(xi_samples, values, scratch)
        });
        values
    }

    fn check<G: AsRef<[f64]>>(&self, xi_samples: &[G]) {
        let variables = self.basis.set().variables();
        let short = xi_samples.iter().map(|xi| xi.as_ref().len()).find(|&length| length < variables);
        assert!(short.is_none(), "{} normal variables for {variables} variables", short.unwrap_or_default());
    }

    fn evaluate_block<G: AsRef<[f64]>>(&self, xi_samples: &[G], values: &mut [f64], scratch: &mut Scratch) {
        wide::<Evaluate, (&Horner, &[G], &mut [f64], &mut Scratch)>((&self.horner, xi_samples, values, scratch));
    }

    /// E f = c₀.
    pub fn mean(&self) -> f64 {
        self.coefficients[0]
    }

    /// Var f = Σ_{α≠0} c_α².
    pub fn variance(&self) -> f64 {
        self.coefficients[1..].iter().map(|c| c * c).sum()
    }
}

#[cfg(test)]
mod tests;
