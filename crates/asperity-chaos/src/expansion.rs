//! Polynomial chaos expansions of functions of standard variables ξ.

use super::horner::{Evaluate, Horner, Scratch};
use super::sparse::constant_value;
use super::{Basis, LeastSquares, LeastSquaresFit, RegressionError};
use asperity_base::blocks;
use asperity_base::wide::wide;

/// Number of points that a thread evaluates at a time.
const BLOCK: usize = 1024;

/// Expansion f(ξ) = Σ_α c_α Ψ_α(ξ) in orthonormal polynomials Ψ_α.
#[derive(Debug, Clone, PartialEq)]
pub struct Expansion {
    basis: Basis,
    coefficients: Vec<f64>,
    horner: Horner,
}

impl Expansion {
    /// Creates an expansion with given coefficients, in the order of the basis.
    ///
    /// # Panics
    /// If the numbers of coefficients and functions differ.
    pub fn new(basis: Basis, coefficients: Vec<f64>) -> Self {
        assert_eq!(basis.len(), coefficients.len(), "coefficients of another basis");
        let horner = Horner::new(&basis, &coefficients);
        Self { basis, coefficients, horner }
    }

    /// Fits an expansion to the values `response` at `xi_samples` by least squares, and returns it with the fit.
    ///
    /// # Errors
    /// See [`LeastSquares::new`] and [`LeastSquares::fit`].
    pub fn fit<G: AsRef<[f64]>>(
        basis: Basis,
        xi_samples: &[G],
        response: &[f64],
    ) -> Result<(Self, LeastSquaresFit), RegressionError> {
        let (expansion, fit, _) = Self::solved(basis, xi_samples, response)?;
        Ok((expansion, fit))
    }

    /// Fits an expansion as [`Expansion::fit`] and returns the factorised problem as well.
    pub(super) fn solved<G: AsRef<[f64]>>(
        basis: Basis,
        xi_samples: &[G],
        response: &[f64],
    ) -> Result<(Self, LeastSquaresFit, LeastSquares), RegressionError> {
        if xi_samples.len() <= basis.len() {
            return Err(RegressionError::TooFewSamples { samples: xi_samples.len(), coefficients: basis.len() });
        }
        // The first function is 1. A constant response is its coefficient; the other coefficients would be rounding errors.
        let constant = constant_value(response);
        let varying: Vec<f64> = response.iter().map(|value| if constant.is_some() { 0.0 } else { *value }).collect();
        let problem = LeastSquares::new(basis.design_matrix(xi_samples))?;
        let mut fit = problem.fit(&varying)?;
        fit.coefficients[0] += constant.unwrap_or_default();
        Ok((Self::new(basis, fit.coefficients.clone()), fit, problem))
    }

    /// Returns the basis.
    pub fn basis(&self) -> &Basis {
        &self.basis
    }

    /// Returns the coefficients in the order of the basis.
    pub fn coefficients(&self) -> &[f64] {
        &self.coefficients
    }

    /// Returns f(ξ), bit-identical to [`Expansion::evaluate_many`].
    ///
    /// # Panics
    /// If `xi` is shorter than the number of variables; further entries are ignored.
    pub fn evaluate(&self, xi: &[f64]) -> f64 {
        let mut value = [0.0];
        self.check(&[xi]);
        self.evaluate_block(&[xi], &mut value, &mut Scratch::default());
        value[0]
    }

    /// Evaluates f at each ξ in parallel, in order. A value does not depend on the other points.
    ///
    /// # Panics
    /// See [`Expansion::evaluate`].
    pub fn evaluate_many<G: AsRef<[f64]> + Sync>(&self, xi_samples: &[G]) -> Vec<f64> {
        self.check(xi_samples);
        let mut values = vec![0.0; xi_samples.len()];
        if xi_samples.len() <= BLOCK {
            self.evaluate_block(xi_samples, &mut values, &mut Scratch::default());
            return values;
        }
        let items = xi_samples.chunks(BLOCK).zip(values.chunks_mut(BLOCK));
        blocks::for_each_with(items, Scratch::default, |scratch, (xi_samples, values)| {
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

    /// Returns the mean E f = c₀.
    pub fn mean(&self) -> f64 {
        self.coefficients[0]
    }

    /// Returns the variance Var f = Σ_{α≠0} c_α².
    pub fn variance(&self) -> f64 {
        self.coefficients[1..].iter().map(|c| c * c).sum()
    }
}

#[cfg(test)]
mod tests;
