//! Functions of a germ as sums of orthonormal polynomials.

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

    /// The least-squares expansion of the values `response` at `germs`, and its fit.
    ///
    /// # Errors
    /// As [`LeastSquares::new`] and [`LeastSquares::fit`].
    pub fn fit<G: AsRef<[f64]>>(basis: Basis, germs: &[G], response: &[f64]) -> Result<(Self, Fit), RegressionError> {
        if germs.len() <= basis.len() {
            return Err(RegressionError::TooFewSamples { samples: germs.len(), coefficients: basis.len() });
        }
        let fit = LeastSquares::new(basis.design_matrix(germs).view())?.fit(response)?;
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
    /// If the germ is shorter than the number of variables; values beyond them are ignored.
    pub fn evaluate(&self, germ: &[f64]) -> f64 {
        let mut value = [0.0];
        self.check(&[germ]);
        self.evaluate_block(&[germ], &mut value, &mut Scratch::default());
        value[0]
    }

    /// f at each germ, in order, by all threads. A germ's value does not depend on the others.
    ///
    /// # Panics
    /// As [`Expansion::evaluate`].
    pub fn evaluate_many<G: AsRef<[f64]> + Sync>(&self, germs: &[G]) -> Vec<f64> {
        self.check(germs);
        let mut values = vec![0.0; germs.len()];
        let blocks = germs.par_chunks(BLOCK).zip(values.par_chunks_mut(BLOCK));
        blocks.for_each_init(Scratch::default, |scratch, (germs, values)| self.evaluate_block(germs, values, scratch));
        values
    }

    fn check<G: AsRef<[f64]>>(&self, germs: &[G]) {
        let variables = self.basis.set().variables();
        let short = germs.iter().map(|germ| germ.as_ref().len()).find(|&length| length < variables);
        assert!(short.is_none(), "{} germ values for {variables} variables", short.unwrap_or_default());
    }

    fn evaluate_block<G: AsRef<[f64]>>(&self, germs: &[G], values: &mut [f64], scratch: &mut Scratch) {
        wide::<Evaluate, (&Horner, &[G], &mut [f64], &mut Scratch)>((&self.horner, germs, values, scratch));
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
